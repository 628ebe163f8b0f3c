"""Draw the frequencies of a rotating model over its speed, say where they meet its orders, and write the table.

Example: flexmb campbell rotor.toml --over speed=0:400:41 --order 1 -o rotor_campbell.png
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from flexmb.cli.model_arguments import add_model_arguments, settings
from flexmb.cli.one_range import add_over, range_of
from flexmb.errors import ModelError

NAME = "campbell"
SUMMARY = "draw the frequencies of a rotating model over its speed, with its critical speeds"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_model_arguments(parser)
    add_over(parser, 'the speed, rad/s, a value of [parameters]; a drive turns with it: angle = "= speed*t"')
    parser.add_argument(
        "--order",
        type=float,
        action="append",
        metavar="N",
        help="excitation of N times the speed; may be given several times; default: 1",
    )
    parser.add_argument("--modes", type=int, default=6, metavar="N", help="the lowest N at the first speed; default: 6")
    parser.add_argument(
        "-o",
        "--out",
        metavar="FILE",
        help=".png, .svg or .pdf, the table beside it as .csv; default: <model>_campbell.png",
    )


def execute(arguments: argparse.Namespace) -> int:
    import flexmb as fmb
    from flexmb import io, view

    if arguments.modes < 1:
        raise ModelError(
            "flexmb campbell",
            found=f"--modes {arguments.modes}",
            expected="a whole number >= 1",
            remedy="Leave it out for 6",
        )
    fixed = settings(arguments)
    name, speeds = range_of(arguments.over, fixed)
    if len(speeds) < 2 or min(np.diff(speeds)) <= 0.0:
        raise ModelError(
            f"--over {arguments.over}",
            found=f"{len(speeds)} speeds from {speeds[0]:g} to {speeds[-1]:g} rad/s",
            expected="two or more, increasing",
            remedy=f"Write --over {name}=0:300:31",
        )
    file = io.OpenModelFile(arguments.model, trust=arguments.trust)
    diagram = fmb.campbell(lambda speed: file.model({**fixed, name: speed}), np.array(speeds), modes=arguments.modes)
    orders = tuple(dict.fromkeys(arguments.order or [1.0]))
    print(f"Frequencies observed from {diagram.observer}")
    for order in orders:
        found = sorted(diagram.critical(order), key=lambda one: one[1])
        for mode, speed in found:
            print(f"Order {order:g}: mode {mode + 1} at {speed:.6g} rad/s, {speed * 30.0 / np.pi:.6g} rpm")
        if not found:
            print(f"Order {order:g}: no critical speed between these")
    grows = np.flatnonzero(~diagram.stable)
    if len(grows):
        print(f"Unstable from {diagram.speeds[grows[0]]:.6g} rad/s on: a mode grows")
    target = Path(arguments.out) if arguments.out else Path(f"{Path(arguments.model).stem}_campbell.png")
    drawn = view.campbell_diagram(diagram, target, orders=orders)
    print(f"Table: {io.write_campbell(diagram, target.with_suffix('.csv'))}")
    print(f"Campbell diagram: {drawn}")
    return 0
