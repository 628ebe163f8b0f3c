"""Say how far a run can be trusted: a second opinion by ways that the integrator has not gone.

The equations at samples, the constraints and the energy are looked at, and the run is repeated with a tenth of the
tolerance, by another integrator, with other modes and meshes. It takes about ten times as long as the run. What was
found is kept in the run folder, and `flexmb report` shows it. The exit code is 1 if something does not hold.

Examples:
  flexmb verify runs/p55
  flexmb verify runs/p55 --within 0.05 --window 0.2:0.4
"""

from __future__ import annotations

import argparse
from pathlib import Path

import flexmb as fmb
from flexmb.cli.model_arguments import add_trust
from flexmb.cli.run_folder import VERIFICATION, open_run
from flexmb.errors import ModelError
from flexmb.files import check_regular

NAME = "verify"
SUMMARY = "say how far a run can be trusted"

HOLDS, DOES_NOT = 0, 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", help="run folder")
    add_trust(parser)
    parser.add_argument(
        "--within",
        type=float,
        default=0.01,
        metavar="SHARE",
        help="tolerance of the answers, as a share; default 0.01",
    )
    parser.add_argument(
        "--window",
        metavar="FROM:TO",
        help="seconds that another integrator repeats; default: all of a run of usual length",
    )


def execute(arguments: argparse.Namespace) -> int:
    folder = Path(arguments.run)
    solution = open_run(folder, trust=arguments.trust)
    check_regular(folder / VERIFICATION, f"Run folder '{folder}'")  # before the work, which takes long
    found = fmb.verify(
        solution,
        within=arguments.within,
        window=_window(arguments.window),
        progress=lambda text: print(f"  {text}", flush=True),
    )
    print(found)
    print(f"Kept in {found.save(folder / VERIFICATION)}; `flexmb report {folder}` shows it.")
    return HOLDS if found.ok else DOES_NOT


def _window(text: str | None) -> tuple[float, float] | None:
    """Return the two times of "0.2:0.4"."""
    if text is None:
        return None
    try:
        first, last = (float(part) for part in text.split(":"))
    except ValueError:
        raise ModelError(
            "--window", found=f"'{text}'", expected="two times in s, FROM:TO", remedy="Write --window 0.2:0.4"
        ) from None
    return first, last
