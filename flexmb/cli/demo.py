"""The track station of an aircraft flap, from mesh to ParaView.

An elastic lever, reduced from a mesh of quadratic tetrahedra, drives a carriage along its rail by a strut; a pendulum
guides the rear of the flap. The flap extends from retracted to landing under airload, in compressed time.

The folder holds the model file and the reduced lever: change them and run them again,
flexmb run demo/flap_station.toml --set lever_length=0.58
"""

from __future__ import annotations

import argparse
import shutil
import time
from pathlib import Path

import flexmb as fmb
from flexmb.cli.progress import ProgressBar
from flexmb.cli.run import aligned, exit_code, record
from flexmb.cli.run_folder import LOG, Log, new_run
from flexmb.errors import FlexmbError

NAME = "demo"
SUMMARY = "the flap station of a transport aircraft, from mesh to ParaView"

DATA = Path(__file__).parent / "demo_data"
STATION, LEVER = "flap_station.toml", "lever.h5"
ROWS = 11


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out", default="demo", metavar="FOLDER", help="where everything is written; default: demo"
    )


def execute(arguments: argparse.Namespace) -> int:
    began = time.perf_counter()
    folder = Path(arguments.out)
    run = new_run(folder / "run", DATA / STATION)
    shutil.copyfile(DATA / STATION, folder / STATION)

    print("1  Mesh to flexible body")
    lever = _reduced_lever(folder / LEVER)
    print(
        f"   {len(lever.nodes)} nodes, {lever.mass:.3f} kg -> {lever.n_modes} flexible coordinates, "
        f"first frequency {lever.frequencies[0]:.1f} Hz (free)"
    )

    print("2  Mechanism")
    model = fmb.load_model(folder / STATION)
    print("   " + str(fmb.check(model)).replace("\n", "\n   "))

    print("3  Motion and loads")
    simulation = fmb.load_simulation(folder / STATION)
    with Log(run / LOG) as log:
        solution = record(model, simulation, run, log)
    print("\n".join("   " + line for line in _table(solution)))
    print(f"   {solution.status}")

    print("4  Pictures and ParaView")
    _draw(solution, folder / "flap_station.png")
    target = fmb.write_vtk(solution, folder / "flap_station.pvd", every=2)
    print(f"   Open in ParaView: {target}")
    print(f"   Run folder: {run} (sensors.csv, solution.h5, model.toml, log.txt)")
    print(
        f"Done in {time.perf_counter() - began:.1f} s. Go on: flexmb run {folder / STATION} --set damping=0.05"
    )
    return exit_code(solution)


def _reduced_lever(path: Path) -> fmb.ModalNeutralData:
    """Reduce the lever's mesh and write the flexible body."""
    from flexmb import fem, reduction

    with ProgressBar() as progress:
        progress("reading the mesh", 0.0)
        fe = fem.solid(fem.read_mesh(DATA / "lever_arm.msh"), fmb.MATERIALS["titanium"])
        data = reduction.reduce(
            fe,
            interfaces={"root": "bore_root", "tip": "bore_tip"},
            modes=8,
            geometric_stiffness=True,
            progress=progress,
        )
    data.save(path)
    return data


def _table(solution: fmb.Solution) -> list[str]:
    """Return angles, stroke and forces over the extension as lines."""
    import numpy as np

    degree = np.pi / 180.0
    columns = {
        "t [s]": solution.t,
        "lever [deg]": solution["lever angle"] / degree,
        "flap [deg]": solution["flap angle"] / degree,
        "stroke [m]": solution["carriage stroke"],
        "strut [kN]": solution["strut force"][:, 0] / 1e3,
        "pendulum [kN]": solution["pendulum force"][:, 0] / 1e3,
        "torque [kN m]": solution["actuator torque"][:, 5] / 1e3,
        "lever bends [mm]": solution["lever deflection"][:, 2] * 1e3,
    }
    chosen = np.unique(np.linspace(0, len(solution.t) - 1, ROWS).round().astype(int))
    return aligned(
        [tuple(columns), *(tuple(f"{values[k]:.3f}" for values in columns.values()) for k in chosen)]
    )


def _draw(solution: fmb.Solution, path: Path) -> None:
    """Draw retracted, middle and extended in one picture; a machine that cannot draw is told what it lacks."""
    from flexmb import view

    first, last = solution.t[0], solution.t[-1]
    try:
        print(f"   Picture: {view.overlay(solution, path, times=[first, 0.5 * (first + last), last])}")
    except FlexmbError as error:
        print(f"   No picture. {error}")
