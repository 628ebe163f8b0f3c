"""Arguments of all verbs that read a model file."""

from __future__ import annotations

import argparse
from typing import Any

__all__ = ["add_model_arguments", "settings"]


def add_model_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the model file and ``--set``."""
    parser.add_argument("model", help="model file (TOML)")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="replace a value of [parameters]; may be given several times",
    )


def settings(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the parameters that were set."""
    from flexmb import io

    return dict(io.parse_setting(text) for text in arguments.set)
