"""The command ``flexmb``: reads the arguments, runs a verb, turns errors into messages and exit codes.

Exit codes: 0 done, 1 what `verify` looked at does not hold, 2 an error that the message explains, 124 a run that its
limit of time has ended, 130 interrupted.
"""

from __future__ import annotations

import _thread
import argparse
import codecs
import os
import signal
import sys
import threading
import unicodedata
import warnings
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from types import ModuleType

from flexmb.cli import (
    bode,
    cache,
    campbell,
    check,
    demo,
    export,
    fmu,
    linearize,
    locus,
    modes,
    plot,
    psd,
    reduce,
    render,
    report,
    resume,
    run,
    show,
    statics,
    sweep,
    verify,
    view,
    warm,
)
from flexmb.cli.harmless_output import harmless_output
from flexmb.cli.parser import Parser
from flexmb.cli.reduction_lines import ReductionLines
from flexmb.cli.remedies import in_files_and_options
from flexmb.cli.written_files import add_overwrite, refuse_to_lose
from flexmb.ctrl_c import let_termination_interrupt
from flexmb.errors import FlexmbError, ModelError, caused_by_interrupt

__all__ = ["VERBS", "main"]

VERBS: tuple[ModuleType, ...] = (
    *(reduce, show, check, run, resume, verify, sweep),
    *(statics, modes, linearize, bode, psd, locus, campbell),
    *(export, fmu, plot, render, view, report, cache, warm, demo),
)
"""Every verb is a module with NAME, SUMMARY, `add_arguments(parser)` and `execute(arguments) -> exit code`."""

NAMED = {"run": "run folder", "out": "file or folder to write"}
"""What arguments name that need not be a file."""
FAILED, INTERRUPTED = 2, 130
MEMORY = 64_000_000
"""Bytes that must be left of a limit: with less, the compiler of the kernels ends the process without a word."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``flexmb`` with the given arguments (by default the process's) and return the exit code."""
    with harmless_output():
        return _executed(arguments)


def _executed(arguments: Sequence[str] | None) -> int:
    """Return the exit code of a verb; what ends it is told."""
    shown, warnings.showwarning = warnings.showwarning, _shows_warnings()
    lost, sys.unraisablehook = sys.unraisablehook, _strike_again
    command = "flexmb"
    try:
        let_termination_interrupt()
        _write_what_the_terminal_can()
        _require_memory()
        words = sys.argv[1:] if arguments is None else list(arguments)
        given = _parser(words).parse_args(words)
        command = f"flexmb {given.verb}"
        warnings.showwarning.options = _options(command)  # type: ignore[attr-defined]
        warnings.showwarning.given = given  # type: ignore[attr-defined]
        _check_names(given)
        refuse_to_lose(given)
        from flexmb.parts import watching  # numba comes with it, which nobody waits for who asks for help

        with watching(ReductionLines()):
            code = given.execute(given)
        sys.stdout.flush()  # here, where it can be said that the disk is full
        return code
    except FlexmbError as error:
        told = in_files_and_options(str(error), "--statics" in _options(command), _at_rest(given))
        print(f"{command}: {told.removeprefix(f'{command}: ')}", file=sys.stderr)
        return FAILED
    except (KeyboardInterrupt, SystemError, RuntimeError, ImportError) as error:
        if not caused_by_interrupt(error):  # which struck in the first call of a compiled function, or in an import
            raise
        told = f": {error}" if isinstance(error, KeyboardInterrupt) and str(error) else ""
        print(f"{command}: interrupted{told}", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of a pipe has closed it: flexmb check ... | head
        _close_output()
        return 0
    except OSError as error:
        print(f"{command}: {_told(error)}", file=sys.stderr)
        if error.filename is None:
            _close_output()  # what waits to be printed would fail once more
        return FAILED
    except MemoryError as error:
        print(
            f"{command}: there is not enough memory ({error or 'none left'}). What was written before is "
            "kept. Take fewer samples, fewer modes or a coarser mesh",
            file=sys.stderr,
        )
        return FAILED
    finally:
        warnings.showwarning, sys.unraisablehook = shown, lost


def _check_names(given: argparse.Namespace) -> None:
    """Raise ModelError for an argument that no file and no parameter can be called: a program may pass one."""
    for name, value in vars(given).items():
        if name in ("model", "run", "data", "mesh", "out") and "" in (value if isinstance(value, list) else [value]):
            raise ModelError(
                f"flexmb {given.verb}",
                found="an empty name",
                expected=f"the name of a {NAMED.get(name, 'file')}",
                remedy="Is a variable of the shell empty?",
            )
        for text in value if isinstance(value, list | tuple) else [value]:
            if isinstance(text, str) and "\0" in text:
                raise ModelError(
                    f"Argument '{name}'",
                    found=f"{text[:60]!r}, with a zero byte",
                    expected="a text without one",
                    remedy="Correct the name",
                )


def _told(error: OSError) -> str:
    """Return an error of the file system as a sentence."""
    where = f"'{error.filename}'" if error.filename is not None else "The output"
    if isinstance(error, FileNotFoundError) and not _there():
        return (
            "The working folder: it does not exist any more. Expected: a folder that is there. Go to another one (cd)"
        )
    return (
        f"{where}: cannot be read or written ({error.strerror or error}). Expected: an existing place with the "
        "permission to use it, and free space. Correct the path, or free space"
    )


def _there() -> bool:
    """Is the working folder still there?"""
    try:
        os.getcwd()
    except OSError:
        return False
    return True


def _close_output() -> None:
    """Let go of what could not be printed."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _strike_again(unraisable: sys.UnraisableHookArgs) -> None:
    """Let an interruption come once more that has struck where exceptions are lost, in a destructor."""
    if unraisable.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(unraisable)
        return
    later = threading.Timer(0.02, _thread.interrupt_main, (signal.SIGTERM,))
    later.daemon = True
    later.start()


def _require_memory() -> None:
    """Raise FlexmbError if the limit of the process's memory (ulimit -v) leaves too little to load the kernels."""
    try:
        import resource

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    except (ImportError, OSError):  # another system
        return
    if limit != resource.RLIM_INFINITY and limit - used < MEMORY:
        raise FlexmbError(
            "Memory",
            found=f"{max(limit - used, 0) / 1e6:.1f} MB are left of the limit of {limit / 1e6:.0f} MB",
            expected=f"at least {MEMORY / 1e6:.0f} MB to load the kernels",
            remedy="Raise the limit (ulimit -v), or leave it out",
        )


def _write_what_the_terminal_can() -> None:
    """Print letters that the terminal's encoding lacks without their accents, or as a question mark."""

    def plain(error):
        if not isinstance(error, UnicodeEncodeError):
            raise error
        lacking = error.object[error.start : error.end]
        known = unicodedata.normalize("NFKD", lacking).encode("ascii", "ignore").decode()
        return known or "?" * len(lacking), error.end

    codecs.register_error("flexmb.plain", plain)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="flexmb.plain")


def _shows_warnings():
    """Return a function that shows a warning as a sentence, each text once: two analyses of a verb may say the same.

    The place in the source helps no user.
    """
    seen: set[str] = set()

    def show(message, category, filename, lineno, file=None, line=None) -> None:
        if str(message) not in seen:
            seen.add(str(message))
            options, given = show.options, show.given  # type: ignore[attr-defined]
            told = in_files_and_options(str(message), "--statics" in options, _at_rest(given))
            print(f"flexmb: warning: {told}", file=file or sys.stderr)

    show.seen = seen  # type: ignore[attr-defined]  # a summary need not give them again
    show.options = ()  # type: ignore[attr-defined]  # of the verb, once that is known
    show.given = None  # type: ignore[attr-defined]  # its arguments, once they are read
    return show


def _at_rest(given: argparse.Namespace | None) -> bool:
    """Return whether the verb looks at the equilibrium."""
    return bool(getattr(given, "statics", False))


def _options(command: str) -> tuple[str, ...]:
    """Return the options of a verb, of which a remedy may speak."""
    parser = argparse.ArgumentParser()
    for verb in VERBS:
        if command == f"flexmb {verb.NAME}":
            verb.add_arguments(parser)
    return tuple(parser._option_string_actions)


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """Return the parser of a command line; verbs that are not in it have no arguments, which import what they name."""
    parser = Parser(
        prog="flexmb",
        description="Flexible multibody dynamics from finite element meshes.",
        epilog="`flexmb VERB --help` says more; `flexmb demo` shows it at work.",
    )
    parser.add_argument("--version", action="version", version=_version())
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for verb in VERBS:
        own = verbs.add_parser(
            verb.NAME,
            help=verb.SUMMARY,
            description=verb.__doc__,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if verb.NAME in words:
            verb.add_arguments(own)
            add_overwrite(verb.NAME, own)
        own.set_defaults(execute=verb.execute)
    return parser


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return f"flexmb {version('flexmb')}"
    except PackageNotFoundError:  # run from a source tree that is not installed
        return "flexmb"
