"""Arguments of all verbs that look at a model about a state: which state, and between which inputs and outputs."""

from __future__ import annotations

import argparse
import math
from typing import Any

import numpy as np

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings
from flexmb.errors import ModelError

__all__ = ["add_band", "add_ports", "add_state_arguments", "band", "model_and_state", "plant"]


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


def add_band(parser: argparse.ArgumentParser) -> None:
    """Add ``--from``, ``--to`` and ``--points``."""
    parser.add_argument("--from", dest="first", type=float, default=0.1, metavar="HZ", help="default: 0.1")
    parser.add_argument("--to", dest="last", type=float, default=100.0, metavar="HZ", help="default: 100")
    parser.add_argument("--points", type=int, default=600, metavar="N", help="frequencies; default: 600")


def band(arguments: argparse.Namespace, verb: str) -> np.ndarray:
    """Return the frequencies, Hz, that are asked for, evenly on a logarithmic axis."""
    first, last, points = arguments.first, arguments.last, arguments.points
    if not (0.0 < first < last and math.isfinite(last) and points >= 2):
        raise ModelError(
            verb,
            found=f"{points} frequencies from {first:g} to {last:g} Hz",
            expected="at least 2, from above zero upwards",
            remedy="Write --from 0.1 --to 100",
        )
    return np.geomspace(first, last, points)


def model_and_state(arguments: argparse.Namespace) -> tuple[fmb.Model, Any]:
    """Return the model, and its equilibrium where that is asked for."""
    model = fmb.load_model(arguments.model, settings(arguments), trust=arguments.trust)
    return model, fmb.statics(model) if arguments.statics else None


def plant(arguments: argparse.Namespace):
    """Return the plant between the inputs and outputs that are asked for, all of those that are not."""
    model, about = model_and_state(arguments)
    outputs = arguments.output or [sensor.name for sensor in model.sensors]
    return fmb.linearize(model, about, inputs=arguments.input, outputs=outputs)
