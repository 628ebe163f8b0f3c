"""Draw a Bode plot between signals and sensors of a model, and write its table.

Example: flexmb bode car.toml --input road --output "body z" --from 0.1 --to 50 -o car_bode.png
"""

from __future__ import annotations

import argparse
from pathlib import Path

from flexmb.cli.state_arguments import add_band, add_ports, add_state_arguments, band, plant

NAME = "bode"
SUMMARY = "draw gain and phase between signals and sensors, and write their table"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_state_arguments(parser)
    add_ports(parser)
    add_band(parser)
    parser.add_argument(
        "-o", "--out", metavar="FILE", help=".png, .svg or .pdf, the table beside it as .csv; default: <model>_bode.png"
    )


def execute(arguments: argparse.Namespace) -> int:
    from flexmb import io, view

    frequencies = band(arguments, "flexmb bode")
    found = plant(arguments)
    target = Path(arguments.out) if arguments.out else Path(f"{Path(arguments.model).stem}_bode.png")
    print(f"Table: {io.write_response(found, frequencies, target.with_suffix('.csv'))}")
    print(f"Bode plot: {view.bode(found, frequencies, target)}")
    return 0
