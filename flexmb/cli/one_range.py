"""``--over NAME=START:STOP:COUNT`` of the verbs that look at a model over one of its parameters."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from flexmb.errors import ModelError

__all__ = ["add_over", "range_of"]


def add_over(parser: argparse.ArgumentParser, meaning: str) -> None:
    """Add ``--over``."""
    parser.add_argument("--over", required=True, metavar="NAME=START:STOP:COUNT", help=meaning)


def range_of(text: str, fixed: Mapping[str, Any]) -> tuple[str, list[float]]:
    """Return the name and the values of "gain=0:10:21"; ModelError where ``--set`` has given it a value."""
    from flexmb import io, study

    name, _, given = text.partition("=")
    pieces = given.split(":")
    if not name.strip() or len(pieces) != 3:
        raise ModelError(
            f"--over {text}",
            found="no name, or no range",
            expected="NAME=START:STOP:COUNT",
            remedy="Write --over gain=0.01:0.2:39",
        )
    numbers = [io.parse_setting(f"{name}={piece or '?'}")[1] for piece in pieces]
    name = name.strip()
    if name in fixed:
        raise ModelError(
            f"--over {name}", found=f"--set {name} beside it", expected="one of the two", remedy="Leave --set out"
        )
    return name, [float(value) for value in study.range_values(name, *numbers)]
