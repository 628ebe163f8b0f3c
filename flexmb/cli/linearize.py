"""Write the state space between signals and sensors of a model, x' = A x + B u, y = C x + D u, for MATLAB and scipy.

Examples:
  flexmb linearize crane.toml --statics --input winch --output "load x" -o crane.mat
  flexmb linearize car.toml
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from flexmb.cli.state_arguments import add_ports, add_state_arguments, plant

NAME = "linearize"
SUMMARY = "write the state space between signals and sensors (.mat)"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_state_arguments(parser)
    add_ports(parser)
    parser.add_argument("-o", "--out", metavar="FILE", help="MATLAB file; default: <model>_plant.mat")


def execute(arguments: argparse.Namespace) -> int:
    from flexmb import io

    target = io.plant_path(arguments.out or f"{Path(arguments.model).stem}_plant.mat")
    found = every = plant(arguments)
    if arguments.output is None:  # those that are named are refused
        found = every.with_proper_outputs()
    print(f"{len(found.A)} states")
    print(f"  inputs: {', '.join(found.inputs)}")
    for name, unit, share in zip(found.outputs, found.units, found.accuracy, strict=True):
        print(f"  output: {name} [{unit}], slopes accurate to {share:.1e}")
    improper = [name for name in every.outputs if name not in found.outputs]
    if improper:
        print(f"  left out, as they follow the rates of an input, which no state space can say: {', '.join(improper)}")
    for pole in sorted(found.poles, key=lambda s: (abs(s.imag), s.real)):
        if pole.imag >= 0.0:
            print(f"  pole: {_written(pole)} 1/s")
    print(f"State space: {io.write_plant(found, target)}")
    return 0


def _written(pole: complex) -> str:
    return f"{pole.real:.6g}" if pole.imag == 0.0 else f"{pole.real:.6g} +- {np.abs(pole.imag):.6g}i"
