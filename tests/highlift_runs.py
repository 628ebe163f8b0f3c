"""The high-lift example: its files, its data, and runs that several tests look at."""

import tomllib
from functools import lru_cache
from pathlib import Path

import numpy as np

import flexmb as fmb

FOLDER = Path(__file__).parents[1] / "examples" / "highlift"
DATA = tomllib.loads((FOLDER / "parameters.toml").read_text())
CHECK = DATA["check"]["quasi_static"]
RANGE = np.radians(DATA["trailing_edge"]["track_2"]["drive"]["lever_range_deg"])


@lru_cache(maxsize=4)  # a solution with the motion of its 400 markers takes up to 100 MB
def run(case: str, *settings: tuple[str, float], t_end: float | None = None, samples: int | None = None):
    """Return the solution of a case of examples/highlift with parameters set."""
    path, given = FOLDER / f"{case}.toml", dict(settings)
    simulation = fmb.load_simulation(path, given, t_end=t_end, samples=samples)
    return fmb.simulate(fmb.load_model(path, given), **simulation.keywords())


def slow_run(*settings: tuple[str, float]):
    """Return an extension that takes 20 s, so slowly that inertia does not matter."""
    return run("operation", ("duration", 20.0), *settings, samples=201)


def at_stations(solution, name: str, column: int | None = None, eta=None):
    """Return a sensor at the progress of the check values (or at `eta`)."""
    values = solution[name] if column is None else solution[name][:, column]
    return np.interp(CHECK["eta"] if eta is None else eta, solution["inboard_t2_lever angle"] / RANGE, values)
