"""The command line: one file per verb, each a thin layer over the public functions."""

import sys
from collections.abc import Sequence

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``flexmb`` with the given arguments (by default the process's) and return the exit code."""
    try:
        from flexmb.cli import command_line
    except KeyboardInterrupt:  # who presses Ctrl-C while the package is loaded wants no list of its files
        return 130
    except MemoryError:
        print("flexmb: there is not enough memory to begin. Nothing was changed. End other programs", file=sys.stderr)
        return 2
    return command_line.main(arguments)
