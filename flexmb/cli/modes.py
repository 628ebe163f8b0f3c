"""Print the natural frequencies and damping of a whole mechanism, and write its mode shapes for ParaView.

Examples:
  flexmb modes crane.toml --statics
  flexmb modes crane.toml --vtk crane_modes --count 4
  flexmb modes crane.toml --picture crane_modes
"""

from __future__ import annotations

import argparse
from pathlib import Path

import flexmb as fmb
from flexmb.cli.state_arguments import add_state_arguments, model_and_state
from flexmb.errors import ModelError

MANY = 12
"""Pictures from which on it is said how many there are: each takes a second or more."""
UNDAMPED = 1e-12
"""Damping ratio below which rounding is all there is of it."""
NAME = "modes"
SUMMARY = "print frequencies and damping of a mechanism, draw its mode shapes, write them for ParaView"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_state_arguments(parser)
    parser.add_argument("--count", type=int, metavar="N", help="the first so many oscillations; default: all")
    parser.add_argument(
        "--picture",
        metavar="FOLDER",
        help="draw each oscillation, its ends and the middle over one another: FOLDER/mode_<n>.png",
    )
    parser.add_argument("--vtk", metavar="FOLDER", help="write each oscillation over one period: FOLDER/mode_<n>.pvd")


def execute(arguments: argparse.Namespace) -> int:
    if arguments.count is not None and arguments.count < 1:
        raise ModelError(
            "flexmb modes",
            found=f"--count {arguments.count}",
            expected="a whole number >= 1",
            remedy="Leave it out for all",
        )
    model, about = model_and_state(arguments)
    linear = fmb.linearize(model, about)
    chosen = [k for k, f in enumerate(linear.frequencies) if f > 0.0]
    chosen = chosen if arguments.count is None else chosen[: arguments.count]
    print(f"  {'mode':>4} {'frequency [Hz]':>16} {'damping ratio':>14}")
    for n, k in enumerate(chosen, start=1):
        ratio = linear.damping_ratios[k]
        print(f"  {n:4d} {linear.frequencies[k]:16.6g} {0.0 if abs(ratio) < UNDAMPED else ratio:14.4g}")
    without = int((linear.frequencies == 0.0).sum())
    if without:
        print(f"  {without} without oscillation")
    print(f"  about the {'start as drawn' if about is None else 'equilibrium'}")
    print("stable" if linear.stable else "unstable: a mode grows")
    if arguments.picture:
        from flexmb import view

        if arguments.count is None and len(chosen) > MANY:
            print(f"drawing {len(chosen)} modes; --count {MANY} draws the first {MANY}", flush=True)
        for n, k in enumerate(chosen, start=1):
            motion = fmb.mode_motion(model, about, mode=k)
            half, target = motion.t[len(motion.t) // 2], Path(arguments.picture) / f"mode_{n}.png"
            target.parent.mkdir(parents=True, exist_ok=True)
            hertz = f"mode {n}: {linear.frequencies[k]:.4g} Hz"
            print(f"{hertz}: {view.overlay(motion, target, times=[half, half / 2.0, 0.0])}")
    if arguments.vtk:
        for n, k in enumerate(chosen, start=1):
            motion = fmb.mode_motion(model, about, mode=k)
            print(f"Open in ParaView: {fmb.write_vtk(motion, Path(arguments.vtk) / f'mode_{n}.pvd')}")
    return 0
