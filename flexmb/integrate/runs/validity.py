"""Watching validity while a simulation runs, and of equilibria: deformation, load and speed of reduced bodies."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from copy import copy
from typing import Any

import numpy as np

from flexmb.errors import ValidityWarning
from flexmb.integrate.runs.creep_watch import CreepWatch
from flexmb.integrate.runs.off_track import OffTrack
from flexmb.integrate.runs.shared_readers import SharedReaders
from flexmb.math.tables import State
from flexmb.math.weights import no_matrix
from flexmb.results import SHARED, Phase
from flexmb.system.program import evaluate
from flexmb.told import Told

__all__ = ["Validity", "in_equilibrium"]

SHARES, WARNINGS, NOTES = "share of validity", "warnings", "notes"
"""Names in the statistics of a solution."""

ADVICE = {
    "deformation": (
        "deforms by {percent:.0f} % of its size",
        "less than 10 %, where its linear strain holds",
        "Split it into {parts} (flexmb.reduction.split), or use an ANCF body",
    ),
    "load": (
        "carries {value:.2g} times the load under which its reduced stiffness buckles",
        "less than that load",
        "Check the load; for motion past buckling split the body (flexmb.reduction.split), or use an ANCF body",
    ),
    "left out": (
        "carries loads that change its stiffness by up to {percent:.0f} %, which its reduction leaves out",
        "less than 10 %",
        "Reduce it with geometric_stiffness=True (--geometric-stiffness; of a part in a model file geometric_stiffness "
        "= true): it buckles and stiffens then",
    ),
    "inner inertia": (
        "vibrates inside, and in its frame, which is clamped to an interface, that seems to change its stiffness by up "
        "to {fifth:.0f} %, so that it bends wrongly",
        "less than 20 %",
        "Reduce it with frame='buckens', the default, in which nothing of this is left; or give damping to what rings",
    ),
    "speed": (
        "turns {value:.2g} times as fast as its highest retained mode vibrates",
        "retained modes that vibrate faster than the body turns",
        "Keep more modes: reduction.reduce(..., modes=...)",
    ),
}
"""Per measure: what is found, what is expected, what to do."""
BUCKLED = ("load", "softening left out")
"""Measures that are 1 where a body buckles: its load, or the stiffness that loads would take away; the second is told
as "left out"."""


class Validity:
    """Measures the samples of a run as they come, warns once per body and measure, and keeps the largest values.

    Parameters
    ----------
    before : mapping, optional
        Statistics of the run that is continued: its warnings are not repeated.
    since : str
        Words for when a limit was passed, of the time t.
    at_rest : bool
        Equilibria are looked at: past its buckling load a body deforms for that reason.
    """

    def __init__(
        self, before: dict[str, Any] | None = None, since: str = "from t = {t:.4g} s on", at_rest: bool = False
    ):
        before = before or {}
        self.shared: list[str] = list(before.get(SHARED, ()))
        self.largest: dict[str, dict[str, float]] = {k: dict(v) for k, v in before.get(SHARES, {}).items()}
        self.sentences: list[str] = list(before.get(WARNINGS, []))
        self.notes: list[str] = list(before.get(NOTES, []))
        self._system: Any = None
        self._watches: list[Any] = []
        self._work: Any = None
        self._creep: Any = None
        self._readers: Any = None
        self._off_track = OffTrack()
        self._since = since
        self._at_rest = at_rest

    def look(self, system, rows: dict[str, np.ndarray]) -> None:
        """Measure a block of samples."""
        if not len(rows["t"]):
            return
        if system is not self._system:
            self._begin(system)
        self._creep.look(rows)
        self._off_track.look(system, {name: one[-1:] for name, one in rows.items()} if self._at_rest else rows)
        self.look_at_shared(system, rows)
        beyond: dict[str, dict[str, tuple[str, float, str]]] = {}
        for watch in self._watches:
            for title, measure, place, samples, values in watch.measure(rows, lambda k: self._evaluated(rows, k)):
                k = int(np.argmax(values))
                known = self.largest.setdefault(title, {})
                if measure in ADVICE and values[k] > 1.0 >= known.get(measure, 0.0):
                    first = samples[np.flatnonzero(values > 1.0)[0]]
                    since = self._since.format(t=float(rows["t"][first]))
                    beyond.setdefault(title, {})[measure] = place, float(values[k]), since
                known[measure] = max(known.get(measure, 0.0), float(values[k]))
        for title, found in beyond.items():
            if self._at_rest and self.buckles(title):
                found.pop("deformation", None)  # a consequence, and its remedy would be another one
            for measure, given in found.items():
                self._warn(_sentence(title, measure, *given))

    def buckles(self, title: str) -> bool:
        """Does a body carry more than its buckling load, or loads that take its stiffness away?"""
        known = self.largest.get(title, {})
        return any(known.get(measure, 0.0) >= 1.0 for measure in BUCKLED)

    def share(self, joints: list[str]) -> None:
        """Keep the joints whose reactions are not unique in a phase, each with its equations."""
        self.shared += [joint for joint in joints if joint not in self.shared]

    def look_at_shared(self, system, rows: dict[str, np.ndarray]) -> None:
        """Warn of what acts with reactions that are not unique, in rows that need be no samples."""
        if system is not self._system:
            self._begin(system)
        if self._readers:
            _, work = self._evaluated(rows, -1)
            self.tell(self._readers.sentences(rows["lam"], work))

    def tell(self, sentences: list[str]) -> None:
        """Give the warnings that are new."""
        for sentence in sentences:
            if sentence not in self.sentences:
                self._warn(sentence)

    def creeps(self) -> list[str]:
        """Return the warnings about friction that should hold, of the phase until now."""
        return [] if self._creep is None else self._creep.sentences()

    def tell_of_tracks(self) -> None:
        """Tell of loads that travelled beside their tracks: at the end of a run, which they may have reached late."""
        self.tell(self._off_track.sentences())
        self.note(self._off_track.notes())

    def keep(self, told: Iterable[Told]) -> None:
        """Keep warnings that others have given."""
        self.sentences += [text for text in dict.fromkeys(t.text for t in told) if text not in self.sentences]

    def note(self, sentences: list[str]) -> None:
        """Keep what is worth knowing and needs no warning."""
        self.notes += [sentence for sentence in sentences if sentence not in self.notes]

    def saved(self) -> dict[str, Any]:
        """Return what was found until now, for `restore`."""
        return _copies(vars(self))

    def restore(self, saved: dict[str, Any]) -> None:
        """Return to what `saved` has returned: what was found since then is forgotten."""
        vars(self).update(_copies(saved))

    @property
    def statistics(self) -> dict[str, Any]:
        """Largest measures by body, 1 at the limit, if one is watched, the warnings and the notes, if there are any."""
        told = {WARNINGS: self.sentences} if self.sentences else {}
        told |= {SHARED: self.shared} if self.shared else {}
        told |= {NOTES: self.notes} if self.notes else {}
        return {SHARES: self.largest, **told} if self.largest else told

    def _warn(self, sentence: str) -> None:
        self.sentences.append(sentence)
        warnings.warn(sentence, ValidityWarning, stacklevel=2)

    def _begin(self, system) -> None:
        self.tell(self.creeps())  # of the phase before
        kinds = {type(body) for body in system.model.bodies if body.watch is not None}
        self._system, self._work = system, system.workspace()
        self._creep, self._readers = CreepWatch(system, self.sentences), SharedReaders(system)
        self._watches = [kind.watch([b for b in system.model.bodies if type(b) is kind], system) for kind in kinds]
        self.note([sentence for watch in self._watches for sentence in watch.notes])

    def _evaluated(self, rows, k):
        state = State(
            float(rows["t"][k]),
            *(np.ascontiguousarray(rows[name][k]) for name in ("q", "u", "a", "lam")),
            np.zeros((max(1, self._system.n_signals), 3)),
        )
        no_matrix(self._work.weights)
        evaluate(self._system.program, state, self._work)
        return state, self._work


def _copies(own: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes of a `Validity` with copies of what looks change; systems and workspaces are shared."""
    lists = {name: list(own[name]) for name in ("shared", "sentences", "notes")}
    largest = {title: dict(known) for title, known in own["largest"].items()}
    creep = None if own["_creep"] is None else own["_creep"].copied()
    watched = {"_creep": creep, "_readers": copy(own["_readers"]), "_off_track": own["_off_track"].copied()}
    return {**own, **lists, "largest": largest, **watched}


def in_equilibrium(phase: Phase, since: str = "in equilibrium", told: Iterable[str] = ()) -> dict[str, Any]:
    """Return the statistics of validity of equilibria, the samples of a phase.

    What is told of their stability is warned of, too, unless its cause is: the body that moves buckles.
    """
    told = list(told)
    validity = Validity(since=f"{since}, which is unstable" if told else since, at_rest=True)
    validity.look(phase.system, {name: getattr(phase, name) for name in ("t", "q", "u", "a", "lam")})
    buckled = [title for title in validity.largest if validity.buckles(title)]
    validity.tell([sentence for sentence in told if not any(title in sentence for title in buckled)])
    validity.tell_of_tracks()
    return validity.statistics


def _sentence(title: str, measure: str, place: str, value: float, since: str) -> str:
    found, expected, remedy = ADVICE[measure]
    numbers = {"value": value, "percent": 10.0 * value, "fifth": 20.0 * value, "parts": _parts(value)}
    where = f" {place}" if measure == "deformation" else f", {place}," if place else ""
    begins = f"{title} {found.format(**numbers)}{where} {since}"
    return f"{begins}; expected: {expected}. {remedy.format(**numbers)}."


def _parts(value: float) -> str:
    """The deformation of a part, relative to its size, falls with the number of parts."""
    return f"{int(np.ceil(value)) + 1} bodies" if value < 10.0 else "many bodies if this motion is intended"
