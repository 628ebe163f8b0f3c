"""Plot sensors of a run folder over time.

Example: flexmb plot runs/p55 "C force" -o force.png
"""

from __future__ import annotations

import argparse
from pathlib import Path

from flexmb.cli.model_arguments import add_trust
from flexmb.cli.run_folder import open_run

NAME = "plot"
SUMMARY = "plot sensors of a run folder over time"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", help="run folder")
    add_trust(parser)
    parser.add_argument("sensor", nargs="*", help="names of sensors; default: all")
    parser.add_argument(
        "-o",
        "--out",
        metavar="FILE",
        help=".png, .svg or .pdf; default: <run>/<sensor>.png or <run>/sensors.png",
    )


def execute(arguments: argparse.Namespace) -> int:
    from flexmb import view

    solution = open_run(arguments.run, trust=arguments.trust)
    names = arguments.sensor
    title = "".join(c if c.isalnum() or c in "-_" else "_" for c in names[0]) if len(names) == 1 else "sensors"
    target = Path(arguments.out) if arguments.out else Path(arguments.run) / f"{title}.png"
    print(f"Plot: {view.plot(solution, names or None, target)}")
    return 0
