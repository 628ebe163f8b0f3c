"""Open a run folder in a window: turn it with the mouse, move through time with the slider, Space plays.

Example: flexmb view runs/p55 --scale 20
"""

from __future__ import annotations

import argparse

import flexmb as fmb
from flexmb.cli.model_arguments import add_trust
from flexmb.cli.picture_arguments import add_picture_arguments, picture_settings
from flexmb.cli.run_folder import open_run

NAME = "view"
SUMMARY = "open a run folder in a window with a time slider"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", help="run folder")
    add_trust(parser)
    add_picture_arguments(parser)
    parser.add_argument("--duration", type=float, default=5.0, metavar="SECONDS", help="of playing it once; default: 5")


def execute(arguments: argparse.Namespace) -> int:
    settings = picture_settings(arguments)
    solution = open_run(arguments.run, trust=arguments.trust)
    print(fmb.view.KEYS)
    fmb.view.window(solution, **settings, duration=arguments.duration)
    return 0
