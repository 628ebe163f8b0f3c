"""Plot sensors of a run folder over time, or over another sensor, beside other runs.

Examples:
  flexmb plot runs/p55 "C force" -o force.png
  flexmb plot runs/p55 "C force fx" "tip dz"
  flexmb plot runs/rigid "flap angle" --over "lever angle" --with runs/elastic
  flexmb plot runs/broken "t1_strut force fx" "t2_strut force fx" --per "t1_strut force fx at 0.645"
"""

from __future__ import annotations

import argparse
from pathlib import Path

from flexmb.cli.model_arguments import add_trust
from flexmb.cli.run_folder import open_run

NAME = "plot"
SUMMARY = "plot sensors of a run folder over time or over one another"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", help="run folder")
    add_trust(parser)
    parser.add_argument("sensor", nargs="*", help='sensors, or columns of them: "tip", "tip dz"; default: all')
    parser.add_argument("--over", metavar="SENSOR", help="abscissa, instead of time")
    parser.add_argument("--per", metavar="DIVISOR", help='a number in SI units, or "SENSOR at TIME"')
    parser.add_argument(
        "--with", dest="others", action="append", default=[], metavar="RUN", help="other runs beside it"
    )
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
    if arguments.over or arguments.per or arguments.others:
        runs = {path: open_run(path, trust=arguments.trust) for path in arguments.others}
        all_runs = {arguments.run: solution, **runs}
        wanted = [
            view.Diagram(y=y, x=arguments.over, per=_divisor(arguments.per)) for y in view.of_one_unit(all_runs, names)
        ]
        print(f"Plot: {view.draw_diagrams(all_runs, wanted, target)}")
        return 0
    print(f"Plot: {view.plot(solution, names or None, target)}")
    return 0


def _divisor(text: str | None) -> float | str | None:
    """Return a number where the text is one."""
    try:
        return None if text is None else float(text)
    except ValueError:
        return text
