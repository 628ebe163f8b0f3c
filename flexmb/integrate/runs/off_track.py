"""Loads that travel over a track of a body, and stand beside it: without force there, which nothing else says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.results import Phase, Series

__all__ = ["OffTrack"]


@dataclass
class _Seen:
    """Where a load has stood, m along its track: from, to, the track's ends, and when it was off.

    samples, on : how many samples there were, and how many of them found it on the track
    crossed : was it on the track at some time, if only between two samples?
    last : its place at the last sample
    left : time of the first sample off the track after one on it, s
    """

    load: str
    track: str
    first: float
    end: float
    given: bool
    least: float = np.inf
    most: float = -np.inf
    samples: int = 0
    on: int = 0
    crossed: bool = False
    last: float = np.nan
    left: float | None = None


class OffTrack:
    """Watches loads that travel (`Force.travels`) over the samples of a run, and tells at its end."""

    def __init__(self) -> None:
        self._system: Any = None
        self._groups: dict[tuple[str, str], list[Any]] = {}
        self._seen: dict[tuple[str, str], _Seen] = {}
        self._unknown: dict[str, None] = {}

    def copied(self) -> OffTrack:
        """Return a watch that has seen the same, and goes on by itself."""
        twin = OffTrack()
        twin._system, twin._groups, twin._unknown = self._system, self._groups, dict(self._unknown)
        twin._seen = {key: _Seen(**vars(one)) for key, one in self._seen.items()}
        return twin

    def look(self, system: Any, rows: dict[str, np.ndarray]) -> None:
        """Take a block of samples."""
        if system is not self._system:
            self._begin(system)
        if not self._groups or not len(rows["t"]):
            return
        t, q, u, a, lam = (np.asarray(rows[name]) for name in ("t", "q", "u", "a", "lam"))
        works = np.zeros((len(t), 3))
        series = Series(Phase(model=system.model, system=system, t=t, q=q, u=u, a=a, lam=lam, works=works))
        for key, shares in self._groups.items():
            if shares[0].places is None:
                self._unknown[shares[0].load] = None
                continue
            try:
                places = np.asarray(shares[0].places(series), float)
            except FlexmbError:  # a sensor that reads what samples alone do not tell
                self._unknown[shares[0].load] = None
                continue
            self._take(key, shares, t, places)

    def _begin(self, system: Any) -> None:
        self._system, self._groups = system, {}
        for force in system.model.forces:
            share = force.travels(system.model)
            if share is not None:
                self._groups.setdefault((share.load, share.track), []).append(share)

    def _take(self, key: tuple[str, str], shares: list[Any], t: np.ndarray, places: np.ndarray) -> None:
        begins, ends = min(one.begins for one in shares), max(one.ends for one in shares)
        seen = self._seen.setdefault(
            key,
            _Seen(*key, min(one.at for one in shares), max(one.at for one in shares), shares[0].given),
        )
        on = (places > begins) & (places < ends)
        before = np.concatenate([[seen.last if np.isfinite(seen.last) else places[0]], places[:-1]])
        seen.crossed |= bool(np.any((np.minimum(before, places) < ends) & (np.maximum(before, places) > begins)))
        was_on = (before > begins) & (before < ends)
        gone = np.flatnonzero(was_on & ~on)
        if seen.left is None and len(gone):
            seen.left = float(t[gone[0]])
        seen.samples, seen.on = seen.samples + len(places), seen.on + int(on.sum())
        seen.least, seen.most = min(seen.least, float(places.min())), max(seen.most, float(places.max()))
        seen.last = float(places[-1])

    def sentences(self) -> list[str]:
        """Return the warnings: of loads that were never on their track, or whose joint has left it."""
        told = []
        for seen in self._seen.values():
            if not seen.crossed:
                told.append(
                    f"{_title(seen)}: it was never on its track, so that it had no force: it stood {_range(seen)}, "
                    f"{_away(seen):.3g} m off the nearest end; expected: {_expected(seen)}. Its place counts from the "
                    "first node of the track, in metres: look at its start, its direction and its unit."
                )
            elif _passed_by(seen):
                told.append(
                    f"{_title(seen)}: it was on its track at {seen.on} of {seen.samples} samples: it stood "
                    f"{_range(seen)}; expected: {_expected(seen)}. Its place counts from the first node of the track, "
                    "in metres: look at its start, its direction and its unit, or take more samples."
                )
            elif seen.left is not None and not seen.given:
                told.append(
                    f"{_title(seen)}: from t = {seen.left:.4g} s on it was off its track, where it has no force, up to "
                    f"{_away_most(seen):.3g} m; expected: {_expected(seen)}. Let the track reach further, or keep what "
                    "carries the load on it."
                )
        return told

    def notes(self) -> list[str]:
        """Return what is worth knowing: loads that were meant to leave their track, and those nobody could watch."""
        told = [
            f"{_title(seen)}: off its track from t = {seen.left:.4g} s on, up to {_away_most(seen):.3g} m, "
            "without force."
            for seen in self._seen.values()
            if seen.crossed and not _passed_by(seen) and seen.left is not None and seen.given
        ]
        unknown = [name for name in self._unknown if not any(seen.load == name for seen in self._seen.values())]
        told += [
            f"Moving load '{name}': where it stands follows from a formula or from inputs; whether that is on its "
            "track was not looked at."
            for name in unknown
        ]
        return told


def _title(seen: _Seen) -> str:
    return f"Moving load '{seen.load}' on track '{seen.track}'"


def _passed_by(seen: _Seen) -> bool:
    """Did it cross the track so fast that it had no time to act?"""
    return seen.on == 0 or (seen.on == 1 and seen.left is not None)


def _range(seen: _Seen) -> str:
    same = seen.most - seen.least <= 1e-9 * max(abs(seen.most), abs(seen.least))
    return f"at {seen.least:.4g} m" if same else f"at {seen.least:.4g} to {seen.most:.4g} m"


def _expected(seen: _Seen) -> str:
    return f"places from {seen.first:.4g} to {seen.end:.4g} m"


def _away(seen: _Seen) -> float:
    """How near a load that was never on its track came to it, m."""
    return max(seen.least - seen.end, seen.first - seen.most)


def _away_most(seen: _Seen) -> float:
    return max(seen.most - seen.end, seen.first - seen.least)
