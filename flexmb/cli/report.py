"""Write a run folder as one web page that needs no other file; several run folders are compared.

Examples:
  flexmb report runs/p55                                  # runs/p55/report.html
  flexmb report runs/p55 runs/p65 -o comparison.html      # curves over one another
  flexmb report runs/rigid runs/elastic --diagram "flap angle over lever angle" --diagram "strut force fx / 8e3"
"""

from __future__ import annotations

import argparse
from pathlib import Path

import flexmb as fmb
from flexmb.cli.model_arguments import add_trust
from flexmb.cli.picture_arguments import add_label_argument, direction, given_labels
from flexmb.cli.run_folder import open_run, stored_verification
from flexmb.errors import FlexmbError, ModelError
from flexmb.files import resolved

NAME = "report"
SUMMARY = "write a run folder, or several compared, as a web page"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", nargs="+", help="run folder")
    add_trust(parser)
    parser.add_argument(
        "-o", "--out", metavar="FILE", help=".html; default: <run>/report.html, of several comparison.html"
    )
    parser.add_argument(
        "--diagram",
        action="append",
        default=[],
        metavar="TEXT",
        help='"TITLE = SENSOR, SENSOR over SENSOR / DIVISOR", all runs on one scale; repeat for each',
    )
    parser.add_argument("--no-pictures", action="store_true", help="leave out the still pictures")
    parser.add_argument(
        "--camera", metavar="X,Y,Z", help="direction to look from; default: chosen by extent and motion"
    )
    add_label_argument(parser)
    parser.add_argument(
        "--hide",
        metavar="PART",
        action="append",
        default=[],
        help="left out of the pictures: a body, or joints, springs, supports; repeat for each",
    )


def execute(arguments: argparse.Namespace) -> int:
    camera, labels = direction(arguments.camera), given_labels(arguments)
    runs = {_name(path, arguments.run): open_run(path, trust=arguments.trust) for path in arguments.run}
    if len(runs) < len(arguments.run):
        raise ModelError(
            "Report",
            found="a run folder is given twice",
            expected="different run folders",
            remedy="Leave one of them out",
        )
    usual = Path(arguments.run[0]) / "report.html" if len(runs) == 1 else Path("comparison.html")
    checks = {}
    for name, solution in runs.items():
        try:
            if solution.model is not None:
                checks[name] = fmb.check(solution.model)
        except FlexmbError as error:  # the rest of the report stands without it
            print(f"No mobility of {name}. {error}")
    kept = {_name(path, arguments.run): stored_verification(path) for path in arguments.run}
    verified = {name: found for name, found in kept.items() if found is not None}
    target = Path(arguments.out) if arguments.out else usual
    written = fmb.view.report(
        runs,
        target,
        checks=checks,
        verified=verified,
        pictures=not arguments.no_pictures,
        camera=camera,
        labels=labels,
        diagrams=arguments.diagram,
        hide=arguments.hide,
    )
    print(f"Report: {written}")
    return 0


def _name(path: str, all_paths: list[str]) -> str:
    """Return the name of a run folder, with as much of its path as tells it from the others."""
    parts = resolved(path).parts
    others = [resolved(other).parts for other in all_paths if resolved(other).parts != parts]
    for count in range(1, len(parts)):
        if all(other[-count:] != parts[-count:] for other in others):
            return "/".join(parts[-count:])
    return path
