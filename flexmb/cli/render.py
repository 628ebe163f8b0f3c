"""Draw a run folder: one state as a picture, or the motion as an animation.

Example: flexmb render runs/p55 -o p55.gif --scale 20
"""

from __future__ import annotations

import argparse
from pathlib import Path

from flexmb.cli.run_folder import open_run
from flexmb.errors import ModelError

NAME = "render"
SUMMARY = "draw a run folder: picture (png) or animation (gif, mp4)"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", help="run folder")
    parser.add_argument(
        "-o", "--out", metavar="FILE", help=".png, .jpg, .gif or .mp4; default: <run>/<name>.png"
    )
    parser.add_argument(
        "--time",
        type=float,
        action="append",
        metavar="SECONDS",
        help="state to draw (default: the last); several are drawn in one picture, the earlier ones translucent",
    )
    parser.add_argument(
        "--camera", metavar="X,Y,Z", help="direction to look from; default: chosen by the shape"
    )
    parser.add_argument(
        "--size", default="1600x900", metavar="WIDTHxHEIGHT", help="pixels; default: 1600x900"
    )
    parser.add_argument("--scale", type=float, default=1.0, help="factor on elastic displacements")
    parser.add_argument(
        "--rate",
        type=float,
        default=25.0,
        metavar="N",
        help="pictures per second of an animation; default: 25",
    )


def execute(arguments: argparse.Namespace) -> int:
    from flexmb import view

    solution = open_run(arguments.run)
    name = Path(arguments.run).resolve().name
    target = Path(arguments.out) if arguments.out else Path(arguments.run) / f"{name}.png"
    size = tuple(int(x) for x in _numbers("--size", arguments.size, "x", 2, "1600x900"))
    camera = arguments.camera and _numbers("--camera", arguments.camera, ",", 3, "1,-2,0.5")
    common = {"camera": camera, "size": size, "scale": arguments.scale}
    times = arguments.time
    if times and len(times) > 1 and target.suffix not in (".gif", ".mp4"):
        picture = view.overlay(solution, target, times=times, **common)
    else:
        picture = view.render(solution, target, times=times, rate=arguments.rate, **common)
    print(f"Picture: {picture}")
    return 0


def _numbers(option: str, text: str, separator: str, count: int, example: str) -> tuple[float, ...]:
    """Read "1600x900" or "1,-2,0.5"."""
    try:
        numbers = tuple(float(piece) for piece in text.split(separator))
    except ValueError:
        numbers = ()
    if len(numbers) != count or not any(numbers) or (option == "--size" and min(numbers) < 1):
        raise ModelError(
            f"{option} {text}",
            found=f"'{text}'",
            expected=f"{count} numbers separated by '{separator}'",
            remedy=f"Write {option} {example}",
        )
    return numbers
