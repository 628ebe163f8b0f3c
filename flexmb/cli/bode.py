"""Draw a Bode plot between signals and sensors of a model, and write its table.

Example: flexmb bode car.toml --input road --output "body z" --from 0.1 --to 50 -o car_bode.png
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np

from flexmb.cli.state_arguments import add_ports, add_state_arguments, plant
from flexmb.errors import ModelError

NAME = "bode"
SUMMARY = "draw gain and phase between signals and sensors, and write their table"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_state_arguments(parser)
    add_ports(parser)
    parser.add_argument("--from", dest="first", type=float, default=0.1, metavar="HZ", help="default: 0.1")
    parser.add_argument("--to", dest="last", type=float, default=100.0, metavar="HZ", help="default: 100")
    parser.add_argument("--points", type=int, default=600, metavar="N", help="frequencies; default: 600")
    parser.add_argument(
        "-o", "--out", metavar="FILE", help=".png, .svg or .pdf, the table beside it as .csv; default: <model>_bode.png"
    )


def execute(arguments: argparse.Namespace) -> int:
    from flexmb import io, view

    first, last, points = arguments.first, arguments.last, arguments.points
    if not (0.0 < first < last and math.isfinite(last) and points >= 2):
        raise ModelError(
            "flexmb bode",
            found=f"{points} frequencies from {first:g} to {last:g} Hz",
            expected="at least 2, from above zero upwards",
            remedy="Write --from 0.1 --to 100",
        )
    found = plant(arguments)
    frequencies = np.geomspace(first, last, points)
    target = Path(arguments.out) if arguments.out else Path(f"{Path(arguments.model).stem}_bode.png")
    print(f"Table: {io.write_response(found, frequencies, target.with_suffix('.csv'))}")
    print(f"Bode plot: {view.bode(found, frequencies, target)}")
    return 0
