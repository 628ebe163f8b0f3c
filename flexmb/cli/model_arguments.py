"""Arguments of all verbs that read a model file."""

from __future__ import annotations

import argparse
from typing import Any

__all__ = ["add_model_arguments", "add_trust", "settings"]


def add_model_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the model file, ``--set`` and ``--trust``."""
    parser.add_argument("model", help="model file (TOML)")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="replace a value of [parameters]; may be given several times",
    )
    add_trust(parser)


def add_trust(parser: argparse.ArgumentParser) -> None:
    """Add ``--trust``."""
    parser.add_argument(
        "--trust",
        action="store_true",
        help="import and run Python functions that the model names (UserForce); only for files whose author you know",
    )


def settings(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the parameters that were set."""
    from flexmb import io

    return dict(io.parse_setting(text) for text in arguments.set)
