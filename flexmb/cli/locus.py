"""Draw how the poles of a model move with one of its parameters, say where it becomes unstable, and write the table.

Example: flexmb locus arm.toml --over gain=0.01:0.2:39 -o arm_locus.png
"""

from __future__ import annotations

import argparse
from pathlib import Path

from flexmb.cli.model_arguments import add_model_arguments, settings
from flexmb.cli.one_range import add_over, range_of
from flexmb.cli.state_arguments import begins_at_rest

NAME = "locus"
SUMMARY = "draw the poles over a parameter, and say where the model becomes unstable"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_model_arguments(parser)
    add_over(parser, "a value of [parameters]")
    parser.add_argument(
        "--statics",
        action="store_true",
        help="about the equilibrium of each value; default: where runs of the file begin",
    )
    parser.add_argument(
        "-o",
        "--out",
        metavar="FILE",
        help=".png, .svg or .pdf, the table beside it as .csv; default: <model>_locus.png",
    )


def execute(arguments: argparse.Namespace) -> int:
    import flexmb as fmb
    from flexmb import io, view

    fixed = settings(arguments)
    name, values = range_of(arguments.over, fixed)
    file = io.OpenModelFile(arguments.model, trust=arguments.trust)

    def model(value: float) -> fmb.Model:
        return file.model({**fixed, name: value})

    arguments.statics = begins_at_rest(arguments, {**fixed, name: values[0]}, file)
    locus = fmb.root_locus(model, values, about=fmb.statics if arguments.statics else None)
    target = Path(arguments.out) if arguments.out else Path(f"{Path(arguments.model).stem}_locus.png")
    drawn = view.root_loci(locus, target, name=name)
    for value, pole in locus.crossings():
        print(f"Limit of stability: {name} = {value:.9g}, at {abs(pole.imag):.6g} rad/s")
    if not locus.crossings():
        print("Stable at all values" if locus.stable.all() else "No limit of stability between these values")
    print(f"Table: {io.write_poles(locus, target.with_suffix('.csv'), name)}")
    print(f"Root loci: {drawn}")
    return 0
