"""Tries damaged and hostile input in large numbers and prints a table: ``python tests/fuzz/run.py --help``."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from fuzz import campaign, data_files, decks, extremes, model_files, new_kinds
from fuzz.record import Record

GROUPS = {
    "models": (lambda seed: model_files.model_campaign(seed=seed), 100_000),
    "bodies": (lambda seed: data_files.data_campaign("bodies", data_files.BODIES, seed=seed), 10_000),
    "runs": (lambda seed: data_files.data_campaign("runs", data_files.RUNS, seed=seed), 10_000),
    "texts": (lambda seed: data_files.data_campaign("texts", data_files.TEXTS, seed=seed), 20_000),
    "meshes": (lambda seed: data_files.data_campaign("meshes", data_files.MESHES, seed=seed), 40_000),
    "matrices": (lambda seed: data_files.data_campaign("matrices", data_files.MATRICES, seed=seed), 20_000),
    "decks": (lambda seed: decks.deck_campaign(seed=seed), 10_000),
    "described": (lambda seed: new_kinds.described_campaign(seed=seed), 10_000),
    "surfaces": (lambda seed: new_kinds.surface_campaign(seed=seed), 10_000),
    "units": (lambda seed: new_kinds.unit_campaign(seed=seed), 5_000),
    "extremes": (lambda seed: extremes.extreme_campaign(seed=seed), 5_000),
}
"""Campaigns, and how many inputs make a long run."""

PIECE = 500
"""Inputs between two notes of what has been done."""

Piece = tuple[str, int, int]
"""Group, number of the first input, how many."""


def pieces(names: list[str], first: int, count: int | None, share: float) -> list[Piece]:
    """Return what is to be tried, in pieces."""
    found = []
    for name in names:
        end = first + (count or max(1, round(share * GROUPS[name][1])))
        found += [(name, k, min(PIECE, end - k)) for k in range(first, end, PIECE)]
    return found


def work(todo: list[Piece], record: Record, keep: Path | None) -> None:
    """Try pieces, those of one group after each other, and note each when it is done."""
    for name in dict.fromkeys(name for name, _, _ in todo):
        with campaign.prepared(
            GROUPS[name][0](record.seed), warmed=sum(n for g, _, n in todo if g == name) > PIECE
        ) as tried:
            for first, count in ((first, count) for group, first, count in todo if group == name):
                if (name, first, count) in record.done():  # by another command, meanwhile
                    continue
                began = _processor_time()
                outcome = tried(first, count, keep)
                record.add(name, first, count, outcome, _processor_time() - began)


def _processor_time() -> float:
    """Return the seconds that this process and the workers that have ended took."""
    return sum(os.times()[:4])


def shared_out(todo: list[Piece], record: Record, keep: Path | None, jobs: int) -> None:
    """Let several processes do pieces in turn."""
    children = []
    for job in range(jobs):
        child = os.fork()
        if child == 0:
            code = 1
            try:
                work(todo[job::jobs], record, keep)
                code = 0
            finally:
                os._exit(code)
        children.append(child)
    if any(os.waitpid(child, 0)[1] for child in children):
        raise SystemExit("a process of the campaign ended before its work was done: the same command goes on")


def _state() -> str:
    """Return the commit that is tried, with a mark if the package differs from it."""
    root = Path(__file__).parents[2]
    ask = lambda *words: subprocess.run(["git", "-C", root, *words], capture_output=True, text=True).stdout.strip()  # noqa: E731
    return (ask("rev-parse", "--short", "HEAD") or "no commit") + " changed" * bool(
        ask("status", "--porcelain", "flexmb")
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("groups", nargs="*", choices=[[], *GROUPS], help="what to try; default: everything")
    parser.add_argument("--share", type=float, default=1.0, help="part of the long run, 0.01 for a hundredth")
    parser.add_argument("--count", type=int, help="number of inputs of each group instead")
    parser.add_argument("--first", type=int, default=0, help="number of the first input; default: 0")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder for inputs that end badly")
    parser.add_argument("--jobs", type=int, default=1, help="processes; default: 1")
    parser.add_argument("--state", type=Path, help="file that notes what is done: the same command goes on behind it")
    parser.add_argument("--table", action="store_true", help="print the table of the state file, try nothing")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        record = Record(given.state or Path(folder) / "state", given.seed, "" if given.table else _state())
        if not given.table:
            todo = pieces(given.groups or [*GROUPS], given.first, given.count, given.share)
            done = record.done()
            todo = [piece for piece in todo if piece not in done]
            if given.jobs > 1:
                shared_out(todo, record, given.keep, given.jobs)
            else:
                work(todo, record, given.keep)
        print(record.table([*GROUPS]))
        return record.bad() > 0


if __name__ == "__main__":
    sys.exit(main())
