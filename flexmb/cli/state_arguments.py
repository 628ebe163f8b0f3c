"""Arguments of all verbs that look at a model about a state: which state, and between which inputs and outputs."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings
from flexmb.errors import ModelError

__all__ = ["add_band", "add_ports", "add_state_arguments", "band", "begins_at_rest", "model_and_state", "plant"]


def add_state_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the model and ``--statics``."""
    add_model_arguments(parser)
    parser.add_argument(
        "--statics",
        action="store_true",
        help="about the equilibrium, found first; default: where runs of the file begin, as drawn if it does not say",
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


def begins_at_rest(arguments: argparse.Namespace, given: Mapping[str, Any], file: fmb.io.OpenModelFile) -> bool:
    """Is the equilibrium asked for, or does the file's table [simulation] begin there?"""
    if getattr(arguments, "statics", False):
        return True
    # t_end is not used: with one, the table [simulation] may be missing
    return file.simulation(given, t_end=1.0).start == "equilibrium"


def model_and_state(arguments: argparse.Namespace) -> tuple[fmb.Model, Any]:
    """Return the model, and the equilibrium where it is asked for or runs of the file begin in it."""
    given = settings(arguments)
    file = fmb.io.OpenModelFile(arguments.model, trust=arguments.trust)
    model = file.model(given)
    arguments.statics = begins_at_rest(arguments, given, file)  # remedies do not propose what the file says
    return model, fmb.statics(model) if arguments.statics else None


def plant(arguments: argparse.Namespace):
    """Return the plant between the inputs and outputs that are asked for, all of those that are not."""
    model, about = model_and_state(arguments)
    outputs = arguments.output or [sensor.name for sensor in model.sensors]
    return fmb.linearize(model, about, inputs=arguments.input, outputs=outputs)
