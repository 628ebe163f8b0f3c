"""Every verb of the command line that reads or writes, under a limit."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path

from faults.bench import Bench, Counts
from faults.children import begin, ended
from results.spinning import block_data

import flexmb as fmb
from flexmb.cli.command_line import VERBS

__all__ = ["all_verbs"]

LEFT_OUT = {"warm"}
"""It compiles for minutes."""
MESH = str(Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh")


def plant() -> fmb.Model:
    """Return a mass on a spring that an input pushes: what linear analyses and units want."""
    place = fmb.JointCoordinate("place", joint="rail")
    return fmb.Model(
        name="plant",
        bodies=[
            fmb.Ground(markers={"A": (0, 0, 0)}),
            fmb.RigidBody("cart", mass=1.0, inertia=(1, 1, 1), markers={"A": (0, 0, 0)}),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.A", "cart.A"))],
        forces=[
            fmb.Actuator("push", joint="rail", effort=fmb.input("force", 1.0)),
            fmb.Actuator("hold", joint="rail", effort=fmb.formula("-40*x - 2*rate(x)", over={"x": place})),
        ],
        sensors=[place],
    )


def all_verbs(
    bench: Bench, counts: Counts, draw, limit, folder: Path | None = None, removed_after: float | None = None
) -> Counts:
    """Run every verb under a limit, or remove its folder after some seconds: messages, no tracebacks."""
    target = folder or bench.folder / "limited"
    target.mkdir(exist_ok=True)
    body, model = bench.folder / "block.h5", bench.folder / "plant.toml"
    block_data().save(body)
    fmb.save_model(plant(), model, fmb.Simulation(t_end=0.1, samples=11))
    with model.open("a", encoding="utf-8") as file:
        file.write("\n[parameters]\nnone = 1.0\n")  # for verbs that vary one
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        os.environ.pop(name, None)
    for verb in _commands(bench, target, str(body), str(model)):
        number = draw()
        if not (target / "run").is_dir():
            shutil.copytree(bench.folder / "reference", target / "run")
        child = begin(verb, lambda number=number: limit(number))
        if removed_after is not None:
            time.sleep(removed_after)
            shutil.rmtree(target, ignore_errors=True)
        end = ended(child)
        counts.cases += 1
        counts.take(end, " ".join(verb))
    return counts


def _commands(bench: Bench, target: Path, body: str, plant: str) -> list[list[str]]:
    """Return the commands: each verb at least once; ModelError of a verb that nobody has added here."""
    run, swing = str(target / "run"), str(bench.model)
    commands = [
        ["run", swing, "--out", str(target / "new")],
        ["run", swing, "--out", run, "--overwrite"],
        ["resume", run, "--t-end", "0.4"],
        ["export", run, "--vtk"],
        ["export", run, "--vtkhdf"],
        ["export", run, "--csv", "--to", str(target / "other")],
        ["plot", run],
        ["report", run, "--no-pictures"],
        ["show", body, "--modes", "0", "--html"],
        ["check", swing],
        ["sweep", plant, "--over", "none=1,2", "--out", str(target / "sweep")],
        [
            "reduce",
            MESH,
            *("--interface", "a=foot", "--interface", "b=load", "--material", "steel"),
            "-o",
            str(target / "part.h5"),
        ],
        ["render", run],
        ["view", run],  # opens the run, and has no screen
        ["verify", run],
        ["demo", "--out", str(target / "demo")],
        ["statics", plant, "-o", str(target / "rest.csv"), "--vtk", str(target / "rest.pvd")],
        ["modes", plant, "--vtk", str(target / "modes")],
        ["linearize", plant, "-o", str(target / "plant.mat")],
        ["bode", plant, "-o", str(target / "bode.png")],
        ["psd", plant, "--density", "1", "-o", str(target / "psd.png")],
        ["locus", plant, "--over", "none=1:2:2", "-o", str(target / "locus.png")],
        ["campbell", plant, "--over", "none=1:2:2", "-o", str(target / "campbell.png")],
        ["fmu", plant, "-o", str(target / "plant.fmu")],
        ["fmu", plant, "--fmi", "2", "-o", str(target / "plant2.fmu")],
        ["cache"],
    ]
    missing = {verb.NAME for verb in VERBS} - {command[0] for command in commands} - LEFT_OUT
    assert not missing, f"which command shows {missing}?"
    return commands
