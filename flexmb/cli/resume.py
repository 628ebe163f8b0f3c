"""Continue the simulation of a run folder from its last sample: after a kill, an interruption, or past its end.

The run folder stays one run: samples are added to its solution, its sensor table is written again. A run that was cut
off after its last sample is completed.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from functools import partial
from pathlib import Path

import flexmb as fmb
from flexmb.cli.model_arguments import add_trust
from flexmb.cli.run import chosen_settings, computed, exit_code, kept, still_stored, summary
from flexmb.cli.run_folder import LOG, MODEL, SOLUTION, TABLE, Log, alone, open_run
from flexmb.files import check_regular

NAME = "resume"
SUMMARY = "continue a run that was cut off, or past its end"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", help="run folder")
    add_trust(parser)
    parser.add_argument("--t-end", type=float, metavar="SECONDS", help="end time; default: as in the run")
    parser.add_argument("--samples", type=int, metavar="N", help="number of samples of the whole run")
    parser.add_argument("--time-limit", type=float, metavar="SECONDS", help="as run")


def execute(arguments: argparse.Namespace) -> int:
    folder = Path(arguments.run)
    open_run(folder, trust=arguments.trust)  # says what is wrong with the folder
    for name in (TABLE, LOG):
        check_regular(folder / name, f"Run folder '{folder}'")
    with alone(folder):
        return _continued(folder, arguments)


def _continued(folder: Path, arguments: argparse.Namespace) -> int:
    before = open_run(folder, trust=arguments.trust)
    simulation = fmb.load_simulation(folder / MODEL, {}, **chosen_settings(arguments))
    settings = {name: value for name, value in simulation.keywords().items() if name != "start"}
    files = {"read_model": partial(fmb.read_model_text, trust=arguments.trust), "write_model": fmb.model_text}
    with Log(folder / LOG, goes_on=True) as log:
        log.line(shlex.join(["flexmb", *sys.argv[1:]]))
        if before.status.ok and not before.t[-1] < settings["t_end"] and _lacks_table(folder):
            solution = kept(before, folder, log)  # it was cut off between its last sample and its table
            print(summary(solution, folder))
            return exit_code(solution)
        solution = computed(
            lambda progress: fmb.resume(folder / SOLUTION, **settings, **files, progress=progress),
            lambda: open_run(folder, trust=arguments.trust),
            log,
        )
        solution = still_stored(kept(solution, folder, log), simulation, folder, log)
    print(summary(solution, folder))
    return exit_code(solution)


def _lacks_table(folder: Path) -> bool:
    """Is there no sensor table, or one that is older than the solution?"""
    table, solution = folder / TABLE, folder / SOLUTION
    return not table.is_file() or table.stat().st_mtime_ns < solution.stat().st_mtime_ns
