"""The command line: one file per verb, each a thin layer over the public functions."""

import sys
from collections.abc import Sequence

from flexmb.ctrl_c import ignore_from_now_on, let_termination_interrupt
from flexmb.errors import caused_by_interrupt

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``flexmb`` with the given arguments (by default the process's) and return the exit code."""
    try:
        let_termination_interrupt()  # before anything is loaded, which takes most of a second
        from flexmb.cli import command_line

        return command_line.main(arguments)
    except (KeyboardInterrupt, SystemError, RuntimeError, ImportError) as error:
        if not caused_by_interrupt(error):  # a class that is being made gives it another kind, as a cause
            raise
        print("flexmb: interrupted", file=sys.stderr)  # who presses Ctrl-C then wants no list of the package's files
        return 130
    except MemoryError:
        print("flexmb: there is not enough memory to begin. Nothing was changed. End other programs", file=sys.stderr)
        return 2
    finally:
        if arguments is None:  # the process ends with this; a second Ctrl-C must not give it another code
            ignore_from_now_on()
