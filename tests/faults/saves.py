"""A program that moves a run on and saves what it has reached again and again, ended before and inside every write."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from faults.bench import Bench, Counts
from faults.children import begin, ended, shim

import flexmb as fmb
from flexmb.errors import FlexmbError

__all__ = ["kill_saves"]

SAVES = 8
STEP = 0.005
"""s, simulated between two of them."""


def _save_again_and_again(arguments: list[str]) -> int:
    """Save a stepped run in a loop; after each, a byte is added to a file elsewhere."""
    model, target, noted = arguments
    settings = fmb.load_simulation(model)
    with fmb.stepper(fmb.load_model(model), integrator=settings.integrator, t_end=1.0) as run:
        for _ in range(SAVES):
            run.advance(by=STEP)
            run.solution.save(target, write_model=fmb.model_text)
            with open(noted, "ab", buffering=0) as stream:
                os.write(stream.fileno(), b".")
    return 0


def kill_saves(bench: Bench) -> Counts:
    """End it at each call that changes a file, every second time in the middle of a write."""
    counts, library = Counts(), shim()
    if library is None:
        return counts
    folder, noted = bench.folder / "saves", bench.folder / "noted"
    folder.mkdir(exist_ok=True)
    target = folder / "state.h5"

    def started(number: int):
        for left in (*folder.iterdir(), noted):
            left.unlink(missing_ok=True)
        before = lambda: library.faults_begin(str(folder).encode(), number, number % 2)  # noqa: E731
        return begin([str(bench.model), str(target), str(noted)], before, _save_again_and_again)

    whole = ended(started(-1))
    assert whole.code == 0, whole.text
    assert len(_read(target)) == SAVES + 1
    for number in bench.chosen(whole.calls):
        end = ended(started(number))
        counts.cases += 1
        counts.take(end, f"write {number}")
        counts.crashes += end.code not in (-signal.SIGKILL, 0)
        saved = noted.stat().st_size if noted.exists() else 0
        try:
            found = len(_read(target)) - 1 if target.exists() else 0
        except FlexmbError as error:
            found = -1
            counts.notes.append(f"write {number}: {error}")
        if found < saved:
            counts.lost += 1
            counts.notes.append(f"write {number}: {found} of {saved} saves")
    return counts


def _read(path: Path):
    """Return the times of a complete solution."""
    solution = fmb.Solution.load(path, read_model=fmb.read_model_text)
    if not solution.status.ok:
        raise FlexmbError(str(path), found=str(solution.status), expected="a complete file", remedy="")
    return solution.t
