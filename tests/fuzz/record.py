"""What a campaign has done, in a file of lines: it goes on after it was ended, and shows its table at any time."""

from __future__ import annotations

import json
import os
from collections import Counter
from datetime import datetime
from pathlib import Path

from fuzz.campaign import KINDS, Outcome

__all__ = ["Record"]


class Record:
    """A file of JSON lines: the seed and the commit that are tried, then a line for each piece that is done.

    Several processes may add to it: a line is one write at the end of the file.

    Parameters
    ----------
    path : Path
        Made with its first line if it is not there.
    seed : int
    state : str, optional
        What is tried; a file that was begun with another seed or state ends by SystemExit. Without it, only the table
        is asked for.
    """

    def __init__(self, path: Path, seed: int, state: str = ""):
        self.path, self.seed = path, seed
        if state and not path.exists():
            self._write({"seed": seed, "state": state, "begun": _now()})
        begun = self._lines()[0]
        if state and (begun["seed"], begun["state"]) != (seed, state):
            raise SystemExit(
                f"{path} was begun with seed {begun['seed']} at {begun['state']}, this is seed {seed} at {state}"
            )

    def add(self, group: str, first: int, count: int, outcome: Outcome, seconds: float) -> None:
        """Note a piece, with the time when it was done, its causes as text and its seconds of the processor."""
        told = {"counts": dict(outcome.counts), "bad": outcome.bad, "causes": outcome.report(), "s": round(seconds, 2)}
        self._write({"group": group, "first": first, "count": count, "at": _now(), **told})

    def done(self) -> set[tuple[str, int, int]]:
        """Return group, first number and count of all pieces that are there."""
        return {(line["group"], line["first"], line["count"]) for line in self._lines()[1:]}

    def bad(self) -> int:
        """Return how many inputs ended as none may end."""
        return sum(line["bad"] for line in self._lines()[1:])

    def table(self, groups: list[str]) -> str:
        """Return the counts of each group as a table, with what was tried when, and the causes behind it."""
        head, *lines = self._lines()
        sums: dict[str, Counter[str]] = {}
        for line in lines:
            sums.setdefault(line["group"], Counter()).update(line["counts"])
        rows = [
            f"| {group} | {sums[group].total()} | {' | '.join(str(sums[group][kind]) for kind in KINDS)} |"
            for group in groups
            if group in sums
        ]
        last = max((line["at"] for line in lines), default="nothing yet")
        causes = [f"{line['group']}: {line['causes']}" for line in lines if line["causes"]]
        titles = f"| input | tried | {' | '.join(KINDS)} |\n" + "|---" * (len(KINDS) + 2) + "|"
        begun = f"seed {head['seed']}, state {head['state']}, {head['begun']} to {last}\n"
        return "\n".join([begun, titles, *rows, "", *causes])

    def _lines(self) -> list[dict]:
        return [json.loads(line) for line in self.path.read_text(encoding="utf-8").splitlines()]

    def _write(self, line: dict) -> None:
        target = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            os.write(target, (json.dumps(line) + "\n").encode())
        finally:
            os.close(target)


def _now() -> str:
    return f"{datetime.now():%Y-%m-%d %H:%M}"
