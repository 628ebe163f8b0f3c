"""Arguments of all verbs that look at a model about a state: which state, and between which inputs and outputs."""

from __future__ import annotations

import argparse
from typing import Any

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings

__all__ = ["add_ports", "add_state_arguments", "model_and_state", "plant"]


def add_state_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the model and ``--statics``."""
    add_model_arguments(parser)
    parser.add_argument(
        "--statics",
        action="store_true",
        help="about the equilibrium, found first; default: the start as drawn, at rest",
    )


def add_ports(parser: argparse.ArgumentParser) -> None:
    """Add ``--input`` and ``--output``."""
    for what, meaning in (
        ("input", 'signal of a force or drive: "part", "part.field" or "part.field.z"'),
        ("output", 'sensor, or one column of it: "tip", "tip z"'),
    ):
        parser.add_argument(
            f"--{what}", action="append", metavar="NAME", help=f"{meaning}; may be given several times; default: all"
        )


def model_and_state(arguments: argparse.Namespace) -> tuple[fmb.Model, Any]:
    """Return the model, and its equilibrium where that is asked for."""
    model = fmb.load_model(arguments.model, settings(arguments), trust=arguments.trust)
    return model, fmb.statics(model) if arguments.statics else None


def plant(arguments: argparse.Namespace):
    """Return the plant between the inputs and outputs that are asked for, all of those that are not."""
    model, about = model_and_state(arguments)
    outputs = arguments.output or [sensor.name for sensor in model.sensors]
    return fmb.linearize(model, about, inputs=arguments.input, outputs=outputs)
