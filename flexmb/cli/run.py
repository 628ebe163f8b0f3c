"""Simulate a model file and write a run folder.

The folder holds the resolved model (model.toml, can be run again), the solution with the reduced bodies (solution.h5),
the sensors (sensors.csv) and the log (log.txt). The solution is written while the simulation runs, so an interrupted
run keeps its samples.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings
from flexmb.cli.progress import ProgressBar
from flexmb.cli.remedies import in_files_and_options
from flexmb.cli.run_folder import LOG, MODEL, SOLUTION, TABLE, VERIFICATION, Log, new_run, stored_in
from flexmb.errors import DataFileError, IntegrationError, caused_by_interrupt
from flexmb.results import STORED, stored_samples
from flexmb.whereabouts import is_folder

NAME = "run"
SUMMARY = "simulate a model file and write a run folder"

CODES = {"interrupted": 130, "limited": 124}
FAILED = 2
ZERO = 1e-9  # of the largest component of a sensor: what is less is rounding


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_model_arguments(parser)
    parser.add_argument("--out", metavar="FOLDER", help="run folder; default: runs/<name of the model file>")
    parser.add_argument("--overwrite", action="store_true", help="replace the run that the folder holds")
    parser.add_argument("--t-end", type=float, metavar="SECONDS", help="end time; default: as in [simulation]")
    parser.add_argument("--samples", type=int, metavar="N", help="number of samples; default: as in [simulation]")
    parser.add_argument(
        "--time-limit",
        type=float,
        metavar="SECONDS",
        help="end the run after so much clock time, with what it has reached (resume continues it)",
    )
    parser.add_argument("--vtk", action="store_true", help="write ParaView files too")


def chosen_settings(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what replaces settings of ``[simulation]``; None leaves them as they are."""
    return {"t_end": arguments.t_end, "samples": arguments.samples, "time_limit": arguments.time_limit}


@dataclass
class Kept:
    """What is said of a run that an interruption ends before its summary."""

    text: str = "nothing is stored, since there was no sample yet"


def execute(arguments: argparse.Namespace) -> int:
    said = Kept()
    try:
        return _executed(arguments, said)
    except (KeyboardInterrupt, SystemError, RuntimeError, ImportError) as error:
        if not caused_by_interrupt(error):
            raise
        raise KeyboardInterrupt(said.text) from None


def _executed(arguments: argparse.Namespace, said: Kept) -> int:
    """Simulate, and note in `said` what is kept; return the exit code."""
    path = Path(arguments.model)
    given = settings(arguments)
    file = fmb.io.OpenModelFile(path, trust=arguments.trust)
    model, simulation = file.model(given), file.simulation(given, **chosen_settings(arguments))
    out = Path(arguments.out) if arguments.out else Path("runs") / path.stem
    with new_run(out, path, overwrite=arguments.overwrite) as folder, Log(folder / LOG) as log:
        solution = record(model, simulation, folder, log, said)
        if arguments.vtk:
            pvd = (stored_in(solution, folder) or folder / SOLUTION).parent / f"{path.stem}.pvd"
            log.line(f"ParaView files: {fmb.write_vtk(solution, pvd)}")
        solution = still_stored(solution, simulation, folder, log)
    print(summary(solution, folder))
    return exit_code(solution)


def exit_code(solution: fmb.Solution) -> int:
    """Return how the command ends after a simulation; a file that was removed or moved meanwhile is an error too."""
    if STORED in solution.statistics:
        return FAILED
    return 0 if solution.status.ok else CODES.get(solution.status.kind, FAILED)


def record(
    model: fmb.Model, simulation: fmb.Simulation, folder: Path, log: Log, said: Kept | None = None
) -> fmb.Solution:
    """Simulate a model into a run folder and return the solution, complete or as far as it came; note in `said` what is
    kept.
    """
    said, home = said or Kept(), folder.stat()
    log.line(shlex.join(["flexmb", *sys.argv[1:]]))
    log.line(repr(model))
    log.line(f"parameters: {', '.join(f'{k} = {v}' for k, v in model.parameters.items()) or 'none'}")
    fmb.save_model(model, folder / MODEL, simulation, bodies_in=SOLUTION)
    output = {"output": folder / SOLUTION, "write_model": fmb.model_text}
    try:
        solution = computed(
            lambda progress: fmb.simulate(model, **simulation.keywords(), **output, progress=progress),
            lambda: fmb.Solution.load(folder / SOLUTION, model=model),
            log,
        )
    except BaseException:
        _without_samples(model, simulation, folder, home, said)
        raise
    path = stored_in(solution, folder)
    if path is not None:
        said.text = f"its samples are stored, what is made of them may not be; flexmb resume {path.parent} completes it"
    if path is not None and path.name == SOLUTION and not (path.parent / MODEL).is_file():
        fmb.save_model(model, path.parent / MODEL, simulation, bodies_in=SOLUTION)  # the folder was removed
    return kept(solution, folder, log)


def _without_samples(
    model: fmb.Model, simulation: fmb.Simulation, folder: Path, home: os.stat_result, said: Kept
) -> None:
    """Leave no solution file without samples, which the next run would have to overwrite; the model holds its bodies
    itself then. A folder that has the name by now and is not the one of the run (`home`) is left alone.
    """
    path = folder / SOLUTION
    try:
        if not is_folder(folder, home):
            said.text = f"run folder '{folder}' was moved, removed or replaced during the run"
        elif not path.is_file() or stored_samples(path) == 0:
            path.unlink(missing_ok=True)
            fmb.save_model(model, folder / MODEL, simulation)
        else:
            said.text = f"its samples are stored; flexmb resume {folder} continues it"
    except DataFileError as error:  # the error that ends the run is the one to tell, after Ctrl-C this one
        said.text = f"{error.part}: {error.found}"


def kept(solution: fmb.Solution, folder: Path, log: Log) -> fmb.Solution:
    """Write the table of the sensors and the end of the log of a run folder; return the solution."""
    path = stored_in(solution, folder)
    if path is not None:
        own = path.name == SOLUTION  # else the folder may hold another run by now
        fmb.write_table(solution, path.with_name(TABLE) if own else path.with_suffix(".csv"))
        if own:
            path.with_name(VERIFICATION).unlink(missing_ok=True)  # of the run as it was before
    for name, number in solution.statistics.items():
        log.line(f"{name}: {number}")
    for event in happened(solution):
        log.line(event)
    log.line(str(solution.status))
    if path is not None:
        log.keep(path.with_name(LOG) if own else path.with_suffix(".txt"))
    return solution


def still_stored(solution: fmb.Solution, simulation: fmb.Simulation, folder: Path, log: Log) -> fmb.Solution:
    """Write a run again whose folder was removed after its solution file was closed; return the solution, which says so
    then.
    """
    path = stored_in(solution, folder)
    if path is None or path.is_file():
        return solution
    path.parent.mkdir(parents=True, exist_ok=True)
    solution.save(path, fmb.model_text)
    warnings.warn(f"Solution file '{path}' was removed when it was complete: it was written again.", stacklevel=2)
    if solution.model is not None:
        fmb.save_model(solution.model, path.with_name(MODEL), simulation, bodies_in=path.name)
    return kept(replace(solution, statistics={**solution.statistics, STORED: str(path)}), folder, log)


def happened(solution: fmb.Solution) -> list[str]:
    """Return a line for each event of a solution: when, and its name."""
    return [f"event at t = {phase.t[-1]:.6g} s: {phase.ended}" for phase in solution.phases[:-1]]


@contextmanager
def _in_this_folder() -> Iterator[None]:
    """Come back to the working folder: Python parts of the model may leave another one, and paths are relative."""
    try:
        here = os.open(os.curdir, os.O_RDONLY) if os.name != "nt" else os.getcwd()
    except OSError:  # it may not be read, or was removed
        yield
        return
    try:
        yield
    finally:
        with suppress(OSError):
            os.chdir(here)
        if isinstance(here, int):
            os.close(here)


def computed(simulate: Callable[[Callable], fmb.Solution], load: Callable[[], fmb.Solution], log: Log):
    """Return what `simulate(progress)` returns; after a failure or an interruption what was computed until then."""
    with ProgressBar() as bar, _in_this_folder():
        try:
            return simulate(lambda t, t_end: bar("simulating", t / t_end))
        except IntegrationError as error:
            if error.solution is None:  # whoever catches it prints it
                raise
            log.line(str(error))
            print(f"flexmb run: {error}", file=sys.stderr)
            return error.solution
        except KeyboardInterrupt:
            log.line("interrupted")
            try:
                return load()
            except DataFileError:  # before the first sample
                raise KeyboardInterrupt from None


def summary(solution: fmb.Solution, folder: Path) -> str:
    """Return status, place and the range of every sensor as text.

    Columns that stay zero are counted only; warnings that have been shown are left out.
    """
    import numpy as np

    from flexmb import io

    rows, zero, shown = [], 0, getattr(warnings.showwarning, "seen", ())
    told = solution.statistics.get("warnings", ())
    for name in solution.sensor_names:
        values = np.asarray(solution[name], float).reshape(len(solution.t), -1)
        negligible = ZERO * np.abs(values).max(initial=0.0)
        for label, column in zip(io.labels(solution, name), values.T):
            if len(values.T) > 1 and np.abs(column).max() <= negligible:
                zero += 1
            else:
                rows.append((label, *(f"{x:.6g}" for x in (column.min(), column.max(), column[-1]))))
    lines = [
        *happened(solution),
        *(f"warning: {in_files_and_options(text)}" for text in told if text not in shown),
        *(f"note: {in_files_and_options(text)}" for text in solution.statistics.get("notes", ())),
        f"{solution.status}",
        f"{len(solution.t)} samples, t = {solution.t[0]:g} to {solution.t[-1]:g} s",
    ]
    if rows:
        lines += aligned([("sensor", "least", "greatest", "at the end"), *rows])
    if solution.shared_reactions:
        sensors = solution.model.sensors if solution.model is not None else ()
        readers = [s.name for s in sensors if s.reads_reactions and s.joint in solution.shared_reactions]
        lines.append(
            f"Reactions are not unique in the joints {', '.join(solution.shared_reactions)}: stiffness "
            "would decide how they share loads, and rigid bodies have none; the values of least norm are given"
            + (f" (sensors {', '.join(readers)})" if readers else "")
            + ". flexmb check lists the equations"
        )
    if zero:
        lines.append(f"({zero} columns are zero throughout)")
    lines.append(_place(solution, folder))
    return "\n".join(lines)


def _place(solution: fmb.Solution, folder: Path) -> str:
    """Return where a run is stored, and what can be done with it."""
    path = stored_in(solution, folder)
    if path is None:
        return f"Nothing is stored: run folder '{folder}' was removed during the run, and could not be written again"
    if path.name != SOLUTION:
        return f"Solution file: {path}, since another file took its place in {path.parent} during the run"
    return f"Run folder: {path.parent}. ParaView files: flexmb export {path.parent} --vtk"


def aligned(rows: list[tuple[str, ...]]) -> list[str]:
    """Return rows of cells as lines of columns, the first to the left, the others to the right."""
    widths = [max(len(cell) for cell in column) for column in zip(*rows)]
    return [
        "  ".join(cell.rjust(w) if k else cell.ljust(w) for k, (cell, w) in enumerate(zip(row, widths))) for row in rows
    ]
