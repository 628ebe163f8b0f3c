"""Find the equilibrium of a model and print what its sensors read there.

Examples:
  flexmb statics crane.toml
  flexmb statics crane.toml --time 2.5 -o crane_at_rest.csv --vtk crane_at_rest.pvd
"""

from __future__ import annotations

import argparse

import numpy as np

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings

NAME = "statics"
SUMMARY = "find the equilibrium, print what the sensors read"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_model_arguments(parser)
    parser.add_argument("--time", type=float, default=0.0, metavar="SECONDS", help="of loads and drives; default: 0")
    parser.add_argument("-o", "--out", metavar="FILE", help="the readings as a table (.csv)")
    parser.add_argument("--vtk", metavar="FILE", help="the state for ParaView (.pvd)")


def execute(arguments: argparse.Namespace) -> int:
    model = fmb.load_model(arguments.model, settings(arguments), trust=arguments.trust)
    rest = fmb.statics(model, t=arguments.time).last()
    print(f"Equilibrium of '{model.name}' at t = {arguments.time:g} s")
    for name in rest.sensor_names:
        values = np.ravel(rest[name])
        titles = rest.column_titles(name)
        print(f"  {name}: " + ", ".join(f"{title} = {x:.6g}" for title, x in zip(titles, values, strict=True)))
    if arguments.out:
        print(f"Sensors: {fmb.write_table(rest, arguments.out)}")
    if arguments.vtk:
        print(f"Open in ParaView: {fmb.write_vtk(rest, arguments.vtk)}")
    return 0
