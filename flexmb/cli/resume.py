"""Continue the simulation of a run folder from its last sample: after a kill, an interruption, or past its end.

The run folder stays one run: samples are added to its solution, its sensor table is written again.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path

import flexmb as fmb
from flexmb.cli.run import computed, exit_code, kept, summary
from flexmb.cli.run_folder import LOG, MODEL, SOLUTION, Log, open_run

NAME = "resume"
SUMMARY = "continue a run that was cut off, or past its end"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", help="run folder")
    parser.add_argument("--t-end", type=float, metavar="SECONDS", help="end time; default: that of the run")
    parser.add_argument("--samples", type=int, metavar="N", help="number of samples of the whole run")


def execute(arguments: argparse.Namespace) -> int:
    folder = Path(arguments.run)
    open_run(folder)  # says what is wrong with the folder
    simulation = fmb.load_simulation(folder / MODEL, {}, t_end=arguments.t_end, samples=arguments.samples)
    settings = {name: value for name, value in simulation.keywords().items() if name != "start"}
    files = {"read_model": fmb.read_model_text, "write_model": fmb.model_text}
    with Log(folder / LOG, goes_on=True) as log:
        log.line(shlex.join(["flexmb", *sys.argv[1:]]))
        solution = computed(
            lambda progress: fmb.resume(folder / SOLUTION, **settings, **files, progress=progress),
            lambda: open_run(folder),
            log,
        )
        kept(solution, folder, log)
    print(summary(solution, folder))
    return exit_code(solution)
