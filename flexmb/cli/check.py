"""Check a model without simulating it: degrees of freedom, redundant equations, assembly, first frequencies.

The frequencies are those about the start that the file describes: as drawn, or the equilibrium that its table
[simulation] asks for with start = "equilibrium".
"""

from __future__ import annotations

import argparse

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings
from flexmb.cli.state_arguments import begins_at_rest

NAME = "check"
SUMMARY = "count freedoms, name redundant equations, try the assembly"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_model_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    given = settings(arguments)
    file = fmb.io.OpenModelFile(arguments.model, trust=arguments.trust)
    model = file.model(given)
    if table := file.tables.get("simulation"):
        file.simulation(given, t_end=None if "t_end" in table else 1.0)  # what a run would refuse is told here
    print(repr(model))
    report = fmb.check(model)
    print(report)
    rigid = next((force.title for force in model.forces if force.impulsive), "")
    if rigid and report.mobility > 0:
        print(f"  frequencies: not looked for, {rigid} has a rigid law, which has impulses and no stiffness")
    elif report.mobility > 0:
        arguments.statics = rests = begins_at_rest(arguments, given, file)  # no remedy then
        about, where = (fmb.statics(model), "equilibrium at the start") if rests else (report, "start")
        print(f"  frequencies about the {where}: {fmb.first_frequencies(model, about=about)}")
    return 0
