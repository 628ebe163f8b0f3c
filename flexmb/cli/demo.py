"""The track station of an aircraft flap, from mesh to ParaView.

An elastic lever, reduced from a mesh of quadratic tetrahedra, drives a carriage along its rail by a strut; a pendulum
guides the rear of the flap. The flap extends from retracted to landing under airload, in compressed time.

The folder holds the mesh and the model file, which describes the lever: change a parameter and run it again,
flexmb run demo/flap_station.toml --set lever_length=0.7
"""

from __future__ import annotations

import argparse
import shutil
import time
from pathlib import Path

import flexmb as fmb
from flexmb.cli.run import aligned, exit_code, record
from flexmb.cli.run_folder import LOG, Log, new_run
from flexmb.errors import FlexmbError, ModelError

NAME = "demo"
SUMMARY = "the flap station of a transport aircraft, from mesh to ParaView"

DATA = Path(__file__).parent / "demo_data"
STATION, MESH, LEVER = "flap_station.toml", "lever_arm.msh", "lever.h5"
ROWS = 11
EVERY = 4
"""Of the samples, every so many-th is a frame for ParaView."""
CAMERA = (0.2, -1.0, 0.27)
"""Direction to look from: along the hinges, a little from behind and above."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", default="demo", metavar="FOLDER", help="where everything is written; default: demo")


def execute(arguments: argparse.Namespace) -> int:
    folder = Path(arguments.out)
    _refuse_changed(folder)
    with new_run(folder / "run", DATA / STATION, overwrite=True) as run:
        return _shown(folder, run)


def _shown(folder: Path, run: Path) -> int:
    """Go from the mesh to the pictures, and tell about it."""
    clock = _Clock()
    _compile_ahead()
    for name in (STATION, MESH):
        shutil.copyfile(DATA / name, folder / name)

    print("1  Mesh to flexible body")
    model = fmb.load_model(folder / STATION)
    lever = model.body("lever").data
    lever.save(folder / LEVER)
    print(
        f"   {MESH}: {len(lever.nodes)} nodes, {lever.mass:.2f} kg -> {LEVER}: {lever.n_modes} flexible "
        f"coordinates, first frequency {lever.frequencies[0]:.1f} Hz (free)"
    )
    clock.stop("reduction")

    print("2  Mechanism")
    print("   " + str(fmb.check(model)).replace("\n", "\n   "))
    clock.stop("check")

    print("3  Motion and loads")
    with Log(run / LOG) as log:
        solution = record(model, fmb.load_simulation(folder / STATION), run, log)
    print("\n".join("   " + line for line in _table(solution)))
    print(f"   {solution.status}")
    clock.stop("simulation")

    print("4  Pictures and ParaView")
    _draw(solution, folder / "flap_station.png")
    clock.stop("picture")
    target = fmb.write_vtk(solution, folder / "flap_station.pvd", every=EVERY, surface=True)
    other = fmb.write_vtk(solution, folder / "flap_station.vtkhdf", every=EVERY, surface=True)
    clock.stop("ParaView files")
    frames = len(range(0, len(solution.t) - 1, EVERY)) + 1
    print(f"   Run folder: {run} (sensors.csv, solution.h5, model.toml, log.txt), {_megabytes(run):.0f} MB")
    print(f"   ParaView: open {target} and press Play (the same as VTKHDF: {other})")
    print(
        f"   {frames} frames, surface of the lever: {_megabytes(target.with_suffix('')):.0f} MB; all samples with "
        f"the inside: flexmb export {run} --vtk; whole folder {_megabytes(folder):.0f} MB"
    )
    print(clock)
    print(f"Report: flexmb report {run}")
    print(f"Next: flexmb run {folder / STATION} --set lever_length=0.7 --out {folder / 'longer'}")
    return exit_code(solution)


def _compile_ahead() -> None:
    """Compile what the second and third part need during the first."""
    from flexmb.constraints import Angle, Coincident, InPlane, Perpendicular
    from flexmb.integrate import compile_ahead_of_kinds

    kinds = fmb.FloatingBody, fmb.RigidBody, Coincident, Perpendicular, InPlane, Angle, fmb.PointLoad
    compile_ahead_of_kinds(kinds, fmb.GeneralizedAlpha)


def _refuse_changed(folder: Path) -> None:
    """Raise where a file of an earlier demo was changed since: its owner wants to keep it."""
    for name in (STATION, MESH):
        file = folder / name
        if file.exists() and file.read_bytes() != (DATA / name).read_bytes():
            raise ModelError(
                f"Demo folder '{folder}'",
                found=f"{name} in it was changed",
                expected="the files of the demo, or a new folder",
                remedy=f"Run what you changed (flexmb run {folder / STATION}), or write elsewhere with --out",
            )


class _Clock:
    """The seconds of every stage, and of compiling kernels."""

    def __init__(self):
        from flexmb.math import watch_compilation

        self.compiling = watch_compilation(lambda: print("   compiling kernels, first run only"))
        self.began = self.last = time.perf_counter()
        self.stages: list[str] = []

    def stop(self, stage: str) -> None:
        """End a stage."""
        now = time.perf_counter()
        self.stages.append(f"{stage} {now - self.last:.1f}")
        self.last = now

    def __str__(self) -> str:
        compiling = self.compiling()
        kernels = f"cold: {compiling:.1f} s of it compiling" if compiling else "warm: kernels from the cache"
        return f"Done in {self.last - self.began:.1f} s ({kernels}): {', '.join(self.stages)} s"


def _megabytes(folder: Path) -> float:
    """Return what the files of a folder take, MB."""
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()) / 1e6


def _table(solution: fmb.Solution) -> list[str]:
    """Return progress, angles, forces and stress over the extension as lines."""
    import numpy as np

    known, degree = solution.model.parameters, np.pi / 180.0
    columns = {
        "t [s]": solution.t,
        "progress [-]": (solution["lever angle"] - known["lever_start"]) / known["lever_range"],
        "lever [deg]": solution["lever angle"] / degree,
        "flap [deg]": solution["flap angle"] / degree,
        "strut [kN]": solution["strut force"][:, 0] / 1e3,
        "pendulum [kN]": solution["pendulum force"][:, 0] / 1e3,
        "torque [kN m]": solution["actuator torque"][:, 5] / 1e3,
        "lever stress [MPa]": solution["lever stress"] / 1e6,
    }
    chosen = np.unique(np.linspace(0, len(solution.t) - 1, ROWS).round().astype(int))
    return aligned([tuple(columns), *(tuple(f"{values[k]:.3f}" for values in columns.values()) for k in chosen)])


def _draw(solution: fmb.Solution, path: Path) -> None:
    """Draw retracted, middle and extended in one picture; on a machine that cannot draw, say what is missing."""
    from flexmb import view

    first, last = solution.t[0], solution.t[-1]
    try:
        times = [first, 0.5 * (first + last), last]
        print(f"   Picture: {view.overlay(solution, path, times=times, camera=CAMERA)}")
    except FlexmbError as error:
        print(f"   No picture. {error}")
