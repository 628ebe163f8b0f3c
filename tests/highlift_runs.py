"""The high-lift example: its files, its data, and runs that several tests look at."""

import importlib.util
import shutil
import tomllib
from functools import cache
from pathlib import Path

import numpy as np

import flexmb as fmb

FOLDER = Path(__file__).parents[1] / "examples" / "highlift"
DATA = tomllib.loads((FOLDER / "parameters.toml").read_text())
CHECK = DATA["check"]["quasi_static"]
RANGE = np.radians(DATA["trailing_edge"]["track_2"]["drive"]["lever_range_deg"])


@cache
def bodies():
    """Return the script that makes the elastic bodies, as a module."""
    spec = importlib.util.spec_from_file_location("make_bodies", FOLDER / "make_bodies.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def elastic_folder(path: Path, *names: str) -> Path:
    """Copy the model files to a folder, make reduced bodies beside them (by default all), and return the folder."""
    for file in FOLDER.glob("*.toml"):
        shutil.copy(file, path)
    if not names:
        bodies().main(path)
    for name in names:
        getattr(bodies(), name)(DATA).save(path / f"{name}.h5")
    return path


@cache
def run(case: str, *settings: tuple[str, float], t_end: float | None = None, samples: int | None = None):
    """Return the solution of a case of examples/highlift with parameters set."""
    path, given = FOLDER / f"{case}.toml", dict(settings)
    simulation = fmb.load_simulation(path, given, t_end=t_end, samples=samples)
    return fmb.simulate(fmb.load_model(path, given), **simulation.keywords())


def slow_run(*settings: tuple[str, float]):
    """Return an extension that takes 20 s, so slowly that inertia does not matter."""
    return run("operation", ("duration", 20.0), *settings, samples=801)


def at_stations(solution, name: str, column: int | None = None, eta=None):
    """Return a sensor at the progress of the check values (or at `eta`)."""
    values = solution[name] if column is None else solution[name][:, column]
    return np.interp(CHECK["eta"] if eta is None else eta, solution["inboard_t2_lever angle"] / RANGE, values)
