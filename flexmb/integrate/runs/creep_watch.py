"""Watching friction that should hold: a regularised law lets what stands creep with a part of its transition speed."""

from __future__ import annotations

from collections.abc import Iterable
from copy import copy, deepcopy
from typing import Any

import numpy as np

from flexmb.integrate.runs.switching import PassedOver, new_switching, read_switches
from flexmb.math.switches import SLIP
from flexmb.math.weights import no_matrix
from flexmb.system.program import evaluate

__all__ = ["SHARE", "CreepWatch"]

SHARE = 0.05
"""Of the largest motion, from which on a run tells how far what stands has crept."""
LEAST, TURN = 0.1, 0.2
"""Lengths of the model, or rad, that motion counts as at the least: what stands may creep by a twentieth of it."""
BEGINS, GOES_ON = ": in ", " s in which it is slower than its transition of "
"""Between the name of a force and the time, and behind it: no other warning has both."""


class CreepWatch:
    """How far contacts and joints with friction go while they are slower than the transition of their law.

    Parameters
    ----------
    system : System
        Of the phase; without friction of that kind nothing is looked at.
    given : list of str
        Warnings of the run so far: a force is told once.

    The way is the integral over the samples, of those alone between which a place stands; to and fro cancel.
    """

    def __init__(self, system, given: Iterable[str] = ()):
        units = {f.title: unit for f in system.model.forces if (unit := f.slip_unit(system.model))}
        self.system = system
        crept = [text for text in given if GOES_ON in text]
        self.told = {title for title in units if any(text.startswith(f"{title}{BEGINS}") for text in crept)}
        self.rows = np.flatnonzero([owner in units for owner in system.switch_owners])
        if not len(self.rows):
            return
        self.places = [(system.switch_owners[k], units[system.switch_owners[k]]) for k in self.rows]
        n = len(self.rows)
        self.way, self.crept = np.zeros((n, 3)), np.zeros(n)
        self.stood, self.path, self.speed = np.zeros(n), np.zeros(n), np.zeros(n)
        self.moved = self.least = LEAST * float(system.lengths.whole)
        self._last: tuple[float, np.ndarray, np.ndarray] | None = None
        self._begin: np.ndarray | None = None
        self._work: Any = None
        self._switching: Any = None

    def copied(self) -> CreepWatch:
        """Return a watch that has seen the same, and goes on by itself."""
        twin = copy(self)
        twin.told = set(self.told)
        if len(self.rows):
            for name in ("way", "crept", "stood", "path", "speed"):
                setattr(twin, name, getattr(self, name).copy())
            twin._switching = deepcopy(self._switching)
        return twin

    def look(self, rows: dict[str, np.ndarray]) -> None:
        """Take a block of samples."""
        if not len(self.rows) or not len(rows["t"]):
            return
        frames = self.system.program.frames[:, 0]
        places = rows["q"][:, (frames[:, None] + np.arange(3)).ravel()]
        if self._begin is None:
            self._begin, self._work = places[0], self.system.workspace()
        self.moved = max(self.moved, float(np.abs(places - self._begin).max(initial=0.0)))
        for t, q, u, a, lam in zip(*(rows[name] for name in ("t", "q", "u", "a", "lam")), strict=True):
            self._take(float(t), *self._slips(float(t), q, u, a, lam))

    def _slips(self, t: float, q, u, a, lam) -> tuple[np.ndarray, np.ndarray]:
        """Return the slips (n, 3) of a sample, and which of them are slower than their transition (n,)."""
        state = self.system.state(t, *(np.ascontiguousarray(x) for x in (q, u, a, lam)))
        no_matrix(self._work.weights)
        evaluate(self.system.program, state, self._work)
        if self._last is None:
            self._switching = new_switching(self.system, state, self._work, PassedOver())
        read_switches(self.system.program, self._switching, state, self._work)
        now = self._switching.then[self.rows]
        slips = np.where(now[:, :1] == SLIP, now[:, 4:7], 0.0)
        self.speed[:] = np.maximum(self.speed, now[:, 8])
        return slips, (now[:, 0] == SLIP) & (np.linalg.norm(slips, axis=1) < now[:, 8])

    def _take(self, t: float, slips: np.ndarray, stands: np.ndarray) -> None:
        if self._last is not None and t > self._last[0]:  # a run that is taken back goes on from there
            before, were, stood = self._last
            h = t - before
            self.path += 0.5 * h * (np.linalg.norm(slips, axis=1) + np.linalg.norm(were, axis=1))
            on = stands & stood
            self.way[on] += 0.5 * h * (slips + were)[on]
            self.stood[on] += h
            ended = ~stands & stood
            self.crept[ended] += np.linalg.norm(self.way[ended], axis=1)
            self.way[ended] = 0.0
        self._last = t, slips, stands

    def sentences(self) -> list[str]:
        """Return the warning about each force whose places creep too far: its worst place."""
        if not len(self.rows) or self._last is None:
            return []
        crept = self.crept + np.linalg.norm(self.way, axis=1)
        told: dict[str, tuple[float, str]] = {}
        for k, (title, unit) in enumerate(self.places):
            motion = max(TURN if unit == "rad" else self.moved, self.path[k])
            share = float(crept[k] / motion)
            if title in self.told or share <= max(SHARE, told.get(title, (0.0, ""))[0]):
                continue
            least = TURN if unit == "rad" else max(self.least, self.moved - crept[k])
            # with a smaller transition it does not creep: that way is no motion then
            enough = _rounded_down(float(self.speed[k] * SHARE * max(least, self.path[k] - crept[k]) / crept[k]))
            told[title] = (
                share,
                f"{title}{BEGINS}{self.stood[k]:.3g}{GOES_ON}"
                f"{self.speed[k]:.3g} {unit}/s it goes {crept[k]:.3g} {unit}; expected: less than {SHARE * motion:.2g} "
                f"{unit}, {100.0 * SHARE:g} % of the motion. Its law is regularised: what should stand creeps, and "
                f"slow motion meets less than the full friction. Give a transition of {enough:g} {unit}/s or less; in "
                "joints LuGre sticks.",
            )
        self.told |= set(told)
        return [sentence for _, sentence in told.values()]


def _rounded_down(x: float) -> float:
    """Return a positive number with one digit, not above it."""
    place = 10.0 ** np.floor(np.log10(x))
    return float(max(np.floor(x / place * (1.0 + 1e-9)), 1.0) * place)
