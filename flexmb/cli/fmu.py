"""Write a model as a functional mock-up unit (FMI) for co-simulation in other programs.

Inputs are the model's (input = { name = "torque" } in place of a signal), outputs all columns of its sensors.

Examples:
  flexmb fmu crane.toml
  flexmb fmu crane.toml --fmi 2 -o units/crane.fmu
  flexmb fmu crane.toml --parameter rope=rope.stiffness --tunable load=load.mass
  flexmb fmu crane.toml --linear
"""

from __future__ import annotations

import argparse
from pathlib import Path

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings
from flexmb.errors import ModelError

NAME = "fmu"
SUMMARY = "write a model as a unit for co-simulation (.fmu)"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_model_arguments(parser)
    parser.add_argument("--fmi", type=int, choices=(3, 2), default=3, help="version of FMI; default: 3")
    parser.add_argument(
        "--parameter",
        action="append",
        default=[],
        metavar="NAME=PART.FIELD",
        help="a number that hosts may set before the start; may be given several times",
    )
    parser.add_argument(
        "--tunable",
        action="append",
        default=[],
        metavar="NAME=PART.FIELD",
        help="a number that hosts may also set between steps; may be given several times",
    )
    parser.add_argument(
        "--linear",
        action="store_true",
        help="put the state space at the start as drawn beside the model: resources/plant.mat in the unit",
    )
    parser.add_argument("--t-end", type=float, metavar="SECONDS", help="about the end; default: as in [simulation]")
    parser.add_argument("-o", "--out", metavar="FILE", help="default: <model>.fmu")


def execute(arguments: argparse.Namespace) -> int:
    path, given = Path(arguments.model), settings(arguments)
    model = fmb.load_model(path, given, trust=arguments.trust)
    simulation = fmb.load_simulation(path, given, t_end=arguments.t_end)
    out = Path(arguments.out) if arguments.out else Path(f"{path.stem}.fmu")
    inputs, outputs = fmb.fmi.ports(model)
    print(f"Inputs: {', '.join(inputs) or 'none'}")
    print(f"Outputs: {', '.join(outputs) or 'none'}")
    places = dict(_named(text, "parameter") for text in arguments.parameter)
    changing = dict(_named(text, "tunable") for text in arguments.tunable)
    plant = fmb.linearize(model, outputs=[sensor.name for sensor in model.sensors]) if arguments.linear else None
    made = fmb.fmi.write_fmu(
        model, out, settings=simulation, version=arguments.fmi, parameters=places, tunable=changing, plant=plant
    )
    if places or changing:
        print(f"Parameters: {', '.join((*places, *changing))}")
    print(f"FMI {arguments.fmi} unit: {made}")
    print("  runs in hosts that load Python with flexmb in it, as FMPy does")
    return 0


def _named(text: str, option: str) -> tuple[str, str]:
    """Return name and place of "stiffness=spring.stiffness"."""
    name, equals, place = text.partition("=")
    if not equals or not name.strip() or not place.strip():
        raise ModelError(
            f"--{option} {text}",
            found="no name and place",
            expected="NAME=PART.FIELD",
            remedy=f"Write --{option} stiffness=spring.stiffness",
        )
    return name.strip(), place.strip()
