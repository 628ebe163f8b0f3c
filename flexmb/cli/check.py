"""Check a model without simulating it: degrees of freedom, redundant equations, assembly, first frequencies."""

from __future__ import annotations

import argparse

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings

NAME = "check"
SUMMARY = "count freedoms, name redundant equations, try the assembly"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_model_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    model = fmb.load_model(arguments.model, settings(arguments), trust=arguments.trust)
    print(repr(model))
    report = fmb.check(model)
    print(report)
    if report.mobility > 0:
        print(f"  frequencies about the start: {fmb.first_frequencies(model)}")
    return 0
