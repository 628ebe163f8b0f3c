"""Arguments of all verbs that draw: camera, size, scale, hidden parts, labels."""

from __future__ import annotations

import argparse
from typing import Any

from flexmb.errors import ModelError

__all__ = [
    "add_label_argument",
    "add_look_arguments",
    "add_picture_arguments",
    "direction",
    "given_labels",
    "look_settings",
    "picture_settings",
]


def add_picture_arguments(parser: argparse.ArgumentParser) -> None:
    """Add ``--camera``, ``--size`` and ``--scale``."""
    parser.add_argument(
        "--camera", metavar="X,Y,Z", help="direction to look from; default: chosen by extent and motion"
    )
    parser.add_argument("--size", default="1600x900", metavar="WIDTHxHEIGHT", help="pixels; default: 1600x900")
    parser.add_argument("--scale", type=float, default=1.0, help="factor on elastic displacements")


def picture_settings(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return camera, size and scale."""
    size = tuple(int(x) for x in _numbers("--size", arguments.size, "x", 2, "1600x900"))
    return {"camera": direction(arguments.camera), "size": size, "scale": arguments.scale}


def add_look_arguments(parser: argparse.ArgumentParser) -> None:
    """Add ``--hide`` and ``--label``."""
    parser.add_argument(
        "--hide",
        metavar="NAME",
        action="append",
        default=[],
        help="a body, a surface, or joints, springs, supports; repeat for each",
    )
    add_label_argument(parser)


def add_label_argument(parser: argparse.ArgumentParser) -> None:
    """Add ``--label``."""
    parser.add_argument(
        "--label",
        metavar="TEXT=PLACE",
        action="append",
        default=[],
        help="a text at a marker or at the middle of a body; repeat for each; bodies: the names of all bodies",
    )


def look_settings(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what is hidden, and the labels."""
    return {"hide": arguments.hide, "labels": given_labels(arguments)}


def given_labels(arguments: argparse.Namespace) -> dict[str, str]:
    """Return the labels: texts, and the markers or bodies they stand at."""
    labels = {}
    for given in arguments.label:
        text, _, marker = (given, "", given) if given == "bodies" else given.partition("=")
        if not (text and marker):
            raise ModelError(
                f"--label {given}",
                found=f"'{given}'",
                expected="a text and a marker or body; or bodies",
                remedy='Write --label "track 2=t2_carriage.F" or --label bodies',
            )
        labels[text] = marker
    return labels


def direction(text: str | None) -> tuple[float, ...] | None:
    """Return the direction of ``--camera``, or None if it was not given."""
    return _numbers("--camera", text, ",", 3, "1,-2,0.5") if text else None


def _numbers(option: str, text: str, separator: str, count: int, example: str) -> tuple[float, ...]:
    """Read "1600x900" or "1,-2,0.5"."""
    try:
        numbers = tuple(float(piece) for piece in text.split(separator))
    except ValueError:
        numbers = ()
    if len(numbers) != count or not any(numbers) or (option == "--size" and min(numbers) < 1):
        raise ModelError(
            f"{option} {text}",
            found=f"'{text}'",
            expected=f"{count} numbers separated by '{separator}'",
            remedy=f"Write {option} {example}",
        )
    return numbers
