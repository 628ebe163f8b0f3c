"""Simulate a model file and write a run folder.

The folder holds the resolved model (model.toml, can be run again), the solution (solution.h5, written while the
simulation runs: an interrupted run keeps what it had), the sensors (sensors.csv) and the log (log.txt).
"""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings
from flexmb.cli.progress import ProgressBar
from flexmb.cli.run_folder import LOG, MODEL, SOLUTION, TABLE, Log, new_run
from flexmb.errors import IntegrationError

NAME = "run"
SUMMARY = "simulate a model file and write a run folder"

FAILED, INTERRUPTED = 2, 130


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_model_arguments(parser)
    parser.add_argument("--out", metavar="FOLDER", help="run folder; default: runs/<name of the model file>")
    parser.add_argument(
        "--t-end", type=float, metavar="SECONDS", help="end time; default: that of [simulation]"
    )
    parser.add_argument(
        "--samples", type=int, metavar="N", help="number of samples; default: that of [simulation]"
    )
    parser.add_argument("--vtk", action="store_true", help="write ParaView files too")


def execute(arguments: argparse.Namespace) -> int:
    path = Path(arguments.model)
    given = settings(arguments)
    model = fmb.load_model(path, given)
    simulation = fmb.load_simulation(path, given, t_end=arguments.t_end, samples=arguments.samples)
    folder = new_run(Path(arguments.out) if arguments.out else Path("runs") / path.stem, path)
    with Log(folder / LOG) as log:
        log.line(shlex.join(["flexmb", *sys.argv[1:]]))
        log.line(repr(model))
        log.line(f"parameters: {', '.join(f'{k} = {v}' for k, v in model.parameters.items()) or 'none'}")
        fmb.save_model(model, folder / MODEL, simulation)
        solution = _simulate(model, simulation, folder, log)
        fmb.write_table(solution, folder / TABLE)
        for name, number in solution.statistics.items():
            log.line(f"{name}: {number}")
        if arguments.vtk:
            target = fmb.write_vtk(solution, folder / f"{path.stem}.pvd")
            log.line(f"ParaView files: {target}")
        log.line(str(solution.status))
    print(_summary(solution, folder))
    return 0 if solution.status.ok else INTERRUPTED if solution.status.kind == "interrupted" else FAILED


def _simulate(model, simulation: fmb.Simulation, folder: Path, log: Log):
    """Return the solution; after a failure or an interruption what had been computed until then."""
    try:
        with ProgressBar() as progress:
            return fmb.simulate(
                model,
                **simulation.keywords(),
                output=folder / SOLUTION,
                write_model=fmb.model_text,
                progress=lambda t, t_end: progress("simulating", t / t_end),
            )
    except IntegrationError as error:
        log.line(str(error))
        print(f"flexmb run: {error}", file=sys.stderr)
        if error.solution is None:
            raise
        return error.solution
    except KeyboardInterrupt:
        log.line("interrupted")
        if (folder / SOLUTION).is_file():
            return fmb.Solution.load(folder / SOLUTION, model=model)
        raise


def _summary(solution, folder: Path) -> str:
    """Return status, place and the range of every sensor as text."""
    import numpy as np

    lines = [
        f"{solution.status}",
        f"{len(solution.t)} samples, t = {solution.t[0]:g} to {solution.t[-1]:g} s",
    ]
    rows = []
    for name in solution.sensor_names:
        values = np.asarray(solution[name], float).reshape(len(solution.t), -1)
        for title, column in zip(solution.column_titles(name), values.T):
            rows.append(
                (f"{name} {title}".strip(), *(f"{x:.6g}" for x in (column.min(), column.max(), column[-1])))
            )
    if rows:
        head = ("sensor", "least", "greatest", "at the end")
        wide = [max(len(row[k]) for row in (head, *rows)) for k in range(4)]
        lines += [
            "  ".join([row[0].ljust(wide[0]), *(row[k].rjust(wide[k]) for k in (1, 2, 3))])
            for row in (head, *rows)
        ]
    lines.append(f"Run folder: {folder}. ParaView files: flexmb export {folder} --vtk")
    return "\n".join(lines)
