"""Draw a run folder: one state as a picture, or the motion as an animation.

Example: flexmb render runs/p55 -o p55.gif --scale 20
"""

from __future__ import annotations

import argparse
from pathlib import Path

from flexmb.cli.model_arguments import add_trust
from flexmb.cli.picture_arguments import add_look_arguments, add_picture_arguments, look_settings, picture_settings
from flexmb.cli.run_folder import open_run
from flexmb.files import resolved

NAME = "render"
SUMMARY = "draw a run folder: picture (png) or animation (gif, mp4)"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", help="run folder")
    add_trust(parser)
    parser.add_argument("-o", "--out", metavar="FILE", help=".png, .jpg, .gif or .mp4; default: <run>/<name>.png")
    parser.add_argument(
        "--times",
        "--time",
        dest="times",
        type=float,
        action="append",
        metavar="SECONDS",
        help="state to draw (default: the last); several are drawn in one picture, the earlier ones translucent",
    )
    add_picture_arguments(parser)
    add_look_arguments(parser)
    parser.add_argument(
        "--rate",
        type=float,
        default=25.0,
        metavar="N",
        help="pictures per second of an animation; default: 25",
    )


def execute(arguments: argparse.Namespace) -> int:
    from flexmb import view

    solution = open_run(arguments.run, trust=arguments.trust)
    name = resolved(arguments.run).name
    target = Path(arguments.out) if arguments.out else Path(arguments.run) / f"{name}.png"
    common = {**picture_settings(arguments), **look_settings(arguments)}
    times = arguments.times
    if times and len(times) > 1 and target.suffix not in (".gif", ".mp4"):
        picture = view.overlay(solution, target, times=times, **common)
    else:
        picture = view.render(solution, target, times=times, rate=arguments.rate, **common)
    print(f"Picture: {picture}")
    return 0
