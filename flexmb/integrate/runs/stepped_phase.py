"""One phase of a run that is moved on from outside: the integrator between two events, and what it has computed."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from flexmb.errors import IntegrationError
from flexmb.integrate.runs import contradiction, inversion
from flexmb.integrate.runs.added_error import ADDED_UP, UNKNOWN, is_of_a_pole, started_again, told_of
from flexmb.integrate.runs.after_event import assembled_after
from flexmb.integrate.runs.arrival import arrived, is_as_asked
from flexmb.integrate.runs.block_start import copied, scratch, shared
from flexmb.integrate.runs.breaks import just_after, with_breaks, with_fine
from flexmb.integrate.runs.chatter import chattering
from flexmb.integrate.runs.coarse_contacts import CoarseContacts
from flexmb.integrate.runs.continuity import require_continuity
from flexmb.integrate.runs.contradiction import Scratch, first_contradiction
from flexmb.integrate.runs.counts import numbers_of, together
from flexmb.integrate.runs.energy_watch import EnergyWatch
from flexmb.integrate.runs.growth_watch import GrowthWatch
from flexmb.integrate.runs.held import Switching, require_seen, sampled_on, with_held
from flexmb.integrate.runs.impact import velocities_after
from flexmb.integrate.runs.inversion import first_inversion, may_invert
from flexmb.integrate.runs.prescribed_jumps import PrescribedJump, sentences_about, speeds_after
from flexmb.integrate.runs.reading import Readings
from flexmb.integrate.runs.reasons import failed_with
from flexmb.integrate.runs.record import joined_rows
from flexmb.integrate.runs.sunk_surfaces import SunkSurfaces
from flexmb.integrate.runs.turned import require_unturned
from flexmb.integrate.runs.unknown_value import unknown_on_the_way, unknown_value
from flexmb.integrate.runs.vanishing import Gradients
from flexmb.integrate.runs.watch import Watch, carried, next_phase
from flexmb.results import Instant, Phase, Status
from flexmb.system.assembly import consistent_start
from flexmb.system.holds import held_from

__all__ = ["SteppedPhase", "new_phase"]

PATIENCE = 0.3
"""s: after so long the integrator comes back, so that Ctrl-C is heard."""
LOOKS = 10
"""Sensors of events are looked at so many times in a step at least."""
SAME = 1e-13
"""Times that differ by less, relative to them, are the same."""

Rows = dict[str, Any]


class SteppedPhase:
    """The run between two events. Made by `new_phase`."""

    def __init__(self, model, system, integrator, t_end: float, works: np.ndarray, keep: bool, passed):
        self.model, self.system, self.integrator, self.keep = model, system, integrator, keep
        self.work, self.planned, self.works = system.workspace(), t_end, works
        self.variables: Any = None
        self.error_told = False
        self.lost: float | None = None
        """Time, s, of the last state before a force or drive has no value, where that has ended the run."""
        self.last: Rows = {}
        self.rows: list[Rows] = []
        self.given: list[list[float]] = []
        self.looked = 0
        self.energy = EnergyWatch(system, system.workspace())
        self.watch = Watch(model, system, integrator, self.work, passed)
        self.ended = "finished"
        self.timed = [event for event in model.events if event.sensor is None]
        self.may_invert = may_invert(model)
        self._first_places = np.array([places[0] for places in system.inputs.values()], int)
        self._readings: Readings | None = None
        self._looking: Any = None
        self._gradients = Gradients(system)
        self.jumped = False
        self.jumps: list[PrescribedJump] = []
        self.contacts, self.contact_counts = CoarseContacts(integrator), {}
        self.sunk = SunkSurfaces()
        self.growth = GrowthWatch(system)

    @property
    def t(self) -> float:
        """Present time, s."""
        return float(self.last["t"][-1])

    @property
    def inputs(self) -> dict[str, float]:
        """The values of all inputs by name."""
        args = self.system.program.signals.args
        return {name: float(args[places[0]]) for name, places in self.system.inputs.items()}

    def set(self, values: Mapping[str, float]) -> None:
        """Set inputs; what changes makes accelerations jump."""
        args = self.system.program.signals.args
        for name, value in values.items():
            places = self.system.inputs[name]
            if args[places[0]] != value:
                args[places] = value
                self.jumped = True

    def begin(self, state) -> None:
        """Start the integrator at a consistent state."""
        self._look_at_contacts()
        before = self._steps()
        self.variables = started_again(self.integrator, self.variables, (self.system, state, self.work, self.planned))
        self.growth.begin(state, before - self._steps())
        self.jumped = False

    def advance(self, goal: float) -> Status | SteppedPhase | None:
        """Integrate to `goal`; or to an event before, which makes the phase that is returned, or the end of the run."""
        if goal > self.planned:
            self.planned = goal + 0.5 * (goal - float(self.rows[0]["t"][0] if self.rows else self.t))
            self._begin_anew(self.t)
        elif self.jumped:
            self._jump()
        due = min((e for e in self.timed if e.at <= goal), key=lambda e: e.at, default=None) if self.timed else None
        end = goal if due is None else max(due.at, self.t)
        marks, anew = self._marks(end)
        for mark in marks:
            while self.t < mark:
                found = self._to(mark)
                if found is None:
                    break
                if not isinstance(found[0], Switching):
                    return self._happened(*found)
                self._begin_anew(self.t, found[0].title)
            if mark in anew:
                self._begin_anew(float(just_after(mark)))
        self._kept()
        if self.growth.is_due():
            self.growth.require_followed([*self.rows, self.last], self.t, self._steps())
        return None if due is None else self._happened(due, self.last)

    def _marks(self, end: float) -> tuple[list[float], frozenset[float]]:
        """Return the times to stop at after the present one: at which signals are not smooth, and `end`; and those at
        which to begin anew.
        """
        begin = self.t
        known = self.system.signal_times.between(begin, max(self.planned, end))
        smooth = not len(known.breaks) and not len(known.fine)
        if not end > begin:
            return [], frozenset()
        if smooth and not self.watch.events and not self._gradients.numbers:
            return [end], frozenset()
        times, anew = np.array([begin, end]), np.empty(0)
        if not smooth:
            times, anew = with_breaks(self.system, times, getattr(self.integrator, "remembers", False))
            times = with_fine(self.system, times)
        if self.watch.events:
            parts = [np.linspace(a, b, LOOKS + 1)[:-1] for a, b in pairwise(times)]
            times = np.concatenate([*parts, times[-1:]])
        if self._gradients.numbers:
            self._gradients.look(self.last)
            times = self._gradients.resolved(times, 1, len(times))
        return times[1:].tolist(), frozenset(anew.tolist())

    def _to(self, mark: float):
        """Integrate to a time; return (event, row just past it) if one happens before."""
        rows: Rows = {}
        samples = np.array([self.t, mark])
        while not rows or not len(rows["t"]):
            outcome = self.integrator.run(self.system, self.work, self.variables, samples, 1, 2, PATIENCE)
            rows = outcome.rows
            if not is_as_asked(rows, mark):
                ended = rows["t"].copy()  # just before a jump, which is told from its two sides
                outcome = arrived(self.system, outcome, samples[1:])
                rows = {**outcome.rows, "t": ended[: len(outcome.rows["t"])]}
            if outcome.failure:
                known = rows if len(rows["t"]) else self.last
                q, u, begin = known["q"][-1], known["u"][-1], float(known["t"][-1])
                a, unknown = known["a"][-1], unknown_value(self.system, q, u, begin, mark)
                unknown = unknown or unknown_on_the_way(self.system, begin, q, u, a, outcome.reached)
                self.lost = begin if unknown else None
                gone = None if unknown else self.growth.at_failure(known, outcome.reached)
                ending = None if unknown or gone else self._gradients.ending(outcome)
                wrong = ending or failed_with(self.model, outcome, unknown, gone)
                raise IntegrationError(
                    f"Model '{self.model.name}'",
                    found=wrong.message,
                    expected="a motion that the integrator can follow",
                    remedy=f"{wrong.remedy}; look at the inputs: {self.inputs}",
                )
        row = {**rows, "works": rows["works"] + self.works}
        self._require_sound(row)
        before, self.last = self.last, row
        if not self.watch.events:
            return None
        found = self.watch.first(joined_rows([before, row]), begins=False)
        if found is None:
            require_seen(self.system, self.variables)
            return None
        event, after = self.watch.locate(found[0], before, row)
        self.watch.happened(event, after)
        self.last = after
        return event, after

    def _require_sound(self, row: Rows) -> None:
        """Raise IntegrationError where no later state means anything."""
        require_unturned(self.system, self.variables)
        self._gradients.look(row)
        wrong = first_inversion(self.system, row["q"]) if self.may_invert else None
        if wrong is not None:
            raise IntegrationError(wrong.title, found=wrong.found, expected=inversion.EXPECTED, remedy=inversion.REMEDY)
        if not self.system.redundant:
            return
        if self._looking is None:
            self._looking = Scratch.of(self.system)
        apart = first_contradiction(self.system, row, self.planned, self._looking)
        if apart is not None:
            raise IntegrationError(
                apart.title, found=apart.found, expected=contradiction.EXPECTED, remedy=contradiction.REMEDY
            )

    def _happened(self, event, row: Rows) -> Status | SteppedPhase:
        """Return the phase after an event, or how it has ended the run."""
        self._kept()
        self.ended = event.name
        following = next_phase(self.model, event, self.watch.series(row))
        if following is None:
            return Status.stopped(event.name, self.t)
        inputs = self.inputs
        u = velocities_after(self.system, event, self.t, row["q"][-1], row["u"][-1])
        state = carried(self.system, following, row["q"][-1], u)
        system, begin = assembled_after(event, self.model, following, self.t, state)
        require_continuity(event, system, state, begin.q)
        works, passed = row["works"][-1], self.watch.passed
        return new_phase(
            following,
            system,
            begin,
            self.integrator,
            self.planned,
            self.keep,
            works=works,
            passed=passed,
            inputs=inputs,
        )

    def _jump(self) -> None:
        """Continue with the accelerations that the inputs now make."""
        again = getattr(self.integrator, "jumped", None)
        if again is None or not again(self.system, self.work, self.variables):
            self._begin_anew(self.t)
        self.jumped = False

    def _begin_anew(self, t: float, passed: str = "") -> None:
        sampled = None if passed else sampled_on(self.integrator, self.system, self.work, self.variables, t, self.last)
        if sampled is not None:
            self.last = sampled
            return
        self.last = with_held(self.system, self.work, t, self.last, passed)
        self.works = self.last["works"][-1]
        q, left = self.last["q"][-1], float(self.last["t"][-1])
        u, jumps = speeds_after(self.system, self.work, q, self.last["u"][-1], t, left)
        self.jumps += jumps
        self.energy.jumped |= bool(jumps)
        self.begin(consistent_start(self.system, self.system.state(t, q, u), self.work))

    def _kept(self) -> None:
        given = self.system.program.signals.args[self._first_places].tolist()
        if self.keep:
            self.rows.append(self.last)
            self.given.append(given)
        else:
            self.rows[1:], self.given[1:] = (self.last,), (given,)
            self.looked = min(self.looked, 1)

    def saved(self) -> tuple[Any, ...]:
        """Return all that the steps after this depend on."""
        kept = [array.copy() for array in scratch(self.system, self.work)]
        try:
            variables = self._copied(self.variables)
        except TypeError:  # the solver of IDA keeps its state to itself
            variables = None
        args = self.system.program.signals.args.copy()
        watched = self._watched(), self.looked
        return variables, kept, args, dict(self.last), self.works, self.jumped, self.planned, watched

    def restore(self, saved: tuple[Any, ...], samples: int) -> None:
        """Return to what `saved` has returned, when so many samples were kept."""
        variables, arrays, args, self.last, self.works, self.jumped, self.planned, (watched, looked) = saved
        self.system.program.signals.args[:] = args
        del self.rows[samples:], self.given[samples:]
        self.looked = min(looked, samples)
        self.watch.last, passed = dict(watched[0]), watched[1]
        self.watch.passed.clear()
        self.watch.passed.update(passed)
        self.contacts, self.energy = copy.deepcopy(watched[2:4], self._same())
        self.contact_counts, growth, jumps, self.error_told, self.lost, sunk = watched[4:]
        del self.jumps[jumps:]
        self.sunk.told = set(sunk)
        self.ended = "finished"
        self._gradients.last = None
        for array, kept in zip(scratch(self.system, self.work), arrays, strict=True):
            array[...] = kept
        self.variables = None if variables is None else self._copied(variables)
        if variables is None:
            self._begin_anew(self.t)
        self.growth.restore(growth, self._steps())

    def _watched(self):
        copies = copy.deepcopy((self.contacts, self.energy), self._same())
        growth = self.growth.saved(self._steps())
        told = self.error_told, self.lost, frozenset(self.sunk.told)
        passed = dict(self.watch.last), dict(self.watch.passed)
        return *passed, *copies, self.contact_counts, growth, len(self.jumps), *told

    def _same(self) -> dict[int, Any]:
        """Return what copies of what watches the run share with it, by identity."""
        return {id(one): one for one in (self.integrator, self.system, self.energy.work)}

    def _copied(self, variables: Any) -> Any:
        """Return the integrator's variables with arrays of their own; the system and its workspace stay the same."""
        return copied(variables, shared(self.integrator, self.system, self.work))

    def readings(self) -> Readings:
        """Return what reads sensors at the present time."""
        if self._readings is None:
            self._readings = Readings(self.system)
        return self._readings

    def instant(self) -> Instant:
        """Return the present state."""
        row = self.last
        return Instant(t=self.t, **{k: row[k][-1].copy() for k in ("q", "u", "a", "lam", "works")}, model=self.model)

    def last_row(self) -> Phase:
        """Return the present state as a phase of one sample."""
        return Phase(model=self.model, system=self.system, **self.last)

    def result(self) -> Phase:
        """Return what was kept, with the inputs that led to each sample."""
        rows, inputs = joined_rows(self.rows), np.array(self.given)
        return Phase(model=self.model, system=self.system, ended=self.ended, inputs=inputs, **rows)

    def statistics(self) -> dict[str, Any]:
        """Return the numbers of the integrator since it began."""
        error = told_of(self.integrator, self.system, self.variables)
        added = {} if error is None else {ADDED_UP: UNKNOWN if is_of_a_pole(error, self.lost) else error.number}
        self._look_at_contacts()
        return {**numbers_of(self.integrator, self.system, self.variables), **added, **self.contact_counts}

    def _steps(self) -> int:
        """Return how many steps the integrator has taken since it began."""
        return 0 if self.variables is None else int(self.integrator.statistics(self.variables).get("steps", 0))

    def _look_at_contacts(self) -> None:
        found = self.contacts.look(self.system, getattr(self.variables, "switching", None))
        self.contact_counts = together(self.contact_counts, found)

    def look(self, validity) -> None:
        """Give the warnings about the states since the last look."""
        rows = self.rows[self.looked :]
        if rows:
            block = joined_rows(rows)
            validity.look(self.system, block)
            self.energy.look(block, getattr(self.variables, "switching", None))
            self.looked = len(self.rows)
        self._look_at_contacts()
        steps = self._steps()
        validity.tell(self.growth.sentences([*self.rows, self.last], self.t, steps))
        error = told_of(self.integrator, self.system, self.variables)
        error = None if error is None or is_of_a_pole(error, self.lost) else error
        if error is not None and not self.error_told and (sentences := error.sentences(self.integrator)):
            self.error_told = True
            validity.tell(sentences)
        self.energy.tell(self.integrator, self.variables, steps, validity)
        chatters = chattering(self.system, getattr(self.variables, "switching", None), steps)
        validity.tell([*sentences_about(self.jumps), *chatters])
        validity.tell(self.sunk.look(self.system, getattr(self.variables, "switching", None)))
        validity.tell(self.contacts.sentences(self.t - float(self.rows[0]["t"][0])))


def new_phase(
    model, system, state, integrator, t_end: float, keep: bool, *, works=None, passed=None, inputs=None
) -> SteppedPhase:
    """Return the phase that begins at a consistent state, with inputs as they were before."""
    works = np.zeros(3) if works is None else works
    phase = SteppedPhase(model, system, integrator, t_end, works, keep, {} if passed is None else passed)
    phase.set({name: value for name, value in (inputs or {}).items() if name in system.inputs})
    if system.holds:
        state = system.state(state.t, held_from(system, phase.work, state.t, state.q, state.u), state.u)
    if phase.jumped or system.holds:
        state = consistent_start(system, state, phase.work)
    phase.begin(state)
    row = {name: np.array(getattr(state, name))[None] for name in ("q", "u", "a", "lam")}
    phase.last = {"t": np.array([state.t]), **row, "works": works[None]}
    phase.rows, phase.given = [phase.last], [list(phase.inputs.values())]
    phase.watch.first(phase.last, begins=True)
    return phase
