"""Simulate a model file for many values of its parameters, beside each other, and write one table.

Examples:
  flexmb sweep flap.toml --over pressure=3e3:6e3:7 --over mass=200,250 --output "max(strut force fx)"
  flexmb sweep flap.toml --latin 100 --over pressure=3e3:6e3 --over mass=200:300 --out runs/hundred
  flexmb sweep flap.toml --list variants.csv --keep
  flexmb sweep linkage.py:peak_force --over link=0.2:0.4:9

The folder holds results.csv, and with --keep a run folder per variant. The same command continues an interrupted sweep
and does not repeat finished rows.
"""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import flexmb as fmb
from flexmb.cli.model_arguments import add_model_arguments, settings
from flexmb.cli.progress import ProgressBar
from flexmb.errors import ModelError, duration

NAME = "sweep"
SUMMARY = "simulate many variants of a model on all cores, or on a Dask cluster"

FAILED = 2
TABLE = "results.csv"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_model_arguments(parser)
    plan = parser.add_argument_group("variants")
    plan.add_argument(
        "--over",
        action="append",
        default=[],
        metavar="NAME=VALUES",
        help="start:stop:count, or values separated by commas; several --over make a grid",
    )
    plan.add_argument("--list", metavar="FILE", help="CSV file: names, then one line per variant")
    plan.add_argument("--latin", type=int, metavar="N", help="Latin hypercube of N variants; --over NAME=low:high")
    plan.add_argument("--seed", type=int, default=0, help="of the Latin hypercube; default: 0")
    parser.add_argument(
        "--output",
        action="append",
        metavar="REDUCTION(SENSOR)",
        help=f"what to keep, with one of {', '.join(fmb.study.REDUCTIONS)}; 'TITLE = max(...)' names the column; "
        "default: max, min and final of every sensor",
    )
    parser.add_argument("--out", metavar="FOLDER", help="default: runs/<name of the model file>_sweep")
    parser.add_argument("--keep", action="store_true", help="keep a run folder for every variant")
    parser.add_argument("--retry", action="store_true", help="compute rows that failed once more")
    parser.add_argument("--jobs", type=int, metavar="N", help="processes or threads; default: one per core")
    parser.add_argument(
        "--engine",
        default="processes",
        help="compiled: many short runs of one small mechanism, in this process; default: processes",
    )
    parser.add_argument("--timeout", type=float, metavar="SECONDS", help="end variants that take longer")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="Dask scheduler, instead of processes of this machine")
    parser.add_argument("--t-end", type=float, metavar="SECONDS", help="end time; default: as in [simulation]")
    parser.add_argument("--samples", type=int, metavar="N", help="default: as in [simulation]")
    parser.add_argument(
        "--time-limit",
        type=float,
        metavar="SECONDS",
        help="end a variant's run after so much clock time: its row has failed",
    )


def execute(arguments: argparse.Namespace) -> int:
    source, stem = arguments.model, Path(arguments.model).stem
    if ".py:" in source:
        source, stem = fmb.study.function_in(source), source.rpartition(":")[2]
    plan = _plan(arguments)
    folder = Path(arguments.out) if arguments.out else Path("runs") / f"{stem}_sweep"
    with ExitStack() as stack:
        executor = None
        if arguments.scheduler:
            executor = stack.enter_context(fmb.study.dask_executor(arguments.scheduler))
        bar = stack.enter_context(ProgressBar())
        try:
            results = fmb.sweep(
                source,
                plan,
                outputs=arguments.output,
                parameters=settings(arguments),
                trust=arguments.trust,
                t_end=arguments.t_end,
                samples=arguments.samples,
                time_limit=arguments.time_limit,
                folder=folder,
                keep_runs=arguments.keep,
                retry=arguments.retry,
                jobs=arguments.jobs,
                timeout=arguments.timeout,
                executor=executor,
                engine=arguments.engine,
                progress=lambda now: bar(_progress_text(now), now.done / now.total),
            )
        except KeyboardInterrupt:
            if (folder / TABLE).is_file():
                print(f"The rows so far are in {folder}; the same command continues from there", file=sys.stderr)
            raise
    print(results)
    print(f"Table: {folder / TABLE}")
    if arguments.keep:
        print(f"Run folders: {folder / 'runs'}")
    return FAILED if results.failed else 0


def _progress_text(now) -> str:
    text = f"{now.done} of {now.total}"
    if now.failed:
        text += f", {now.failed} without a result"
    return text if now.seconds_left is None else f"{text}, {duration(now.seconds_left)} left"


def _plan(arguments: argparse.Namespace):
    """Return the variants that the options ask for."""
    study, over = fmb.study, [_named(text) for text in arguments.over]
    if arguments.list:
        if over or arguments.latin is not None:
            raise ModelError(
                "--list",
                found="--over or --latin beside it",
                expected="one way to say which variants",
                remedy="Put all parameters into the list",
            )
        return study.read_plan(arguments.list)
    names = [name for name, _ in over]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ModelError(
            f"--over {twice}",
            found="the parameter is given twice",
            expected="each parameter once",
            remedy=f"Write {twice}=1,2,3",
        )
    if arguments.latin is not None:
        return study.latin_hypercube(
            {name: tuple(_numbers(name, text)) for name, text in over}, arguments.latin, seed=arguments.seed
        )
    return study.grid({name: _values(name, text) for name, text in over})


def _named(text: str) -> tuple[str, str]:
    name, equals, values = text.partition("=")
    if not equals or not name.strip():
        raise ModelError(
            f"--over {text}",
            found="no name and values",
            expected="NAME=start:stop:count or NAME=a,b,c",
            remedy="Write --over pressure=3e3:6e3:7",
        )
    return name.strip(), values.strip()


def _values(name: str, text: str) -> list[Any]:
    if ":" in text:
        pieces = _numbers(name, text)
        if len(pieces) != 3:
            raise ModelError(
                f"Range of '{name}'",
                found=f"'{text}'",
                expected="start:stop:count",
                remedy=f"Write {name}=3e3:6e3:7; without the count it is a range of --latin",
            )
        return fmb.study.range_values(name, *pieces)
    return [fmb.io.parse_setting(f"{name}={piece}")[1] for piece in text.split(",") if piece.strip()]


def _numbers(name: str, text: str) -> list[Any]:
    """Read "3e3:6e3:7": numbers or expressions; what is neither stays text and is refused as a range."""
    return [fmb.io.parse_setting(f"{name}={piece or '?'}")[1] for piece in text.split(":")]
