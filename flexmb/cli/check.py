"""Check a model without simulating it: degrees of freedom, redundant equations, assembly, first frequencies."""

from __future__ import annotations

import argparse

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings

NAME = "check"
LISTED = 6
SUMMARY = "count freedoms, name redundant equations, try the assembly"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_model_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    model = fmb.load_model(arguments.model, settings(arguments))
    print(repr(model))
    report = fmb.check(model)
    print(report)
    if report.mobility > 0:
        print(f"  frequencies about the start: {_frequencies(model)}")
    return 0


def _frequencies(model: fmb.Model) -> str:
    """Return the lowest natural frequencies of the assembled model, linearised where it starts, as text.

    Freedoms without stiffness (a free crank, a rigid body in space) have none.
    """
    linear = fmb.linearize(model)
    found = [f"{frequency:.4g}" for frequency in linear.frequencies if frequency > 0.0]
    free = len(linear.frequencies) - len(found)
    listed = ", ".join(found[:LISTED]) + (", ..." if len(found) > LISTED else "")
    others = f"{free} without oscillation" if free else ""
    return "; ".join(text for text in (f"{listed} Hz" if listed else "", others) if text)
