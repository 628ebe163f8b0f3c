"""The command line: one file per verb, each a thin layer over the public functions."""

import sys
from collections.abc import Sequence

from flexmb.errors import caused_by_interrupt

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``flexmb`` with the given arguments (by default the process's) and return the exit code."""
    try:
        from flexmb.cli import command_line
    except (KeyboardInterrupt, SystemError, RuntimeError, ImportError) as error:
        if not caused_by_interrupt(error):  # a class that is being made gives it another kind, as a cause
            raise
        return 130  # who presses Ctrl-C while the package is loaded wants no list of its files
    except MemoryError:
        print("flexmb: there is not enough memory to begin. Nothing was changed. End other programs", file=sys.stderr)
        return 2
    return command_line.main(arguments)
