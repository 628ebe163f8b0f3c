"""A run through the phases that events divide it into."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import Any

import numpy as np

from flexmb.errors import CompileError, IntegrationError, ModelError
from flexmb.integrate.runs.added_error import started_again, tell_of
from flexmb.integrate.runs.after_event import assembled_after
from flexmb.integrate.runs.arrival import arrived
from flexmb.integrate.runs.block_start import BlockStart
from flexmb.integrate.runs.breaks import jumps_at_once, just_after
from flexmb.integrate.runs.chatter import chattering
from flexmb.integrate.runs.coarse_contacts import CoarseContacts
from flexmb.integrate.runs.continuity import require_continuity, require_known_states
from flexmb.integrate.runs.counts import numbers_of, together
from flexmb.integrate.runs.fastest import present_rows
from flexmb.integrate.runs.happened import Happened
from flexmb.integrate.runs.held import Switching, require_seen, sampled_on, with_held
from flexmb.integrate.runs.impact import velocities_after
from flexmb.integrate.runs.interruption import Interruption
from flexmb.integrate.runs.kept_rows import KeptRows
from flexmb.integrate.runs.marks import SAME
from flexmb.integrate.runs.memory import may_stop, memory_of, remember_again, rounding
from flexmb.integrate.runs.outgrown import looked_at, unstable_at_end, unstable_in_steps
from flexmb.integrate.runs.outlook import Outlook
from flexmb.integrate.runs.phase_times import PhaseTimes, times_of_phase
from flexmb.integrate.runs.prescribed_jumps import PrescribedJump, sentences_about, speeds_after
from flexmb.integrate.runs.reasons import LASTING, divided_steps, failed_with, missed_times
from flexmb.integrate.runs.record import Recorder, counted_on, joined_rows
from flexmb.integrate.runs.unknown_value import what_is_unknown
from flexmb.integrate.runs.validity import Validity
from flexmb.integrate.runs.watch import LOOKS, Watch, carried, next_phase
from flexmb.math.tables import State
from flexmb.model.model import Model
from flexmb.results import Status
from flexmb.system import System
from flexmb.system.assembly import consistent_start
from flexmb.system.holds import held_from
from flexmb.system.mobility import shared_reactions
from flexmb.told import listening

__all__ = ["Phases"]

ENDLESS = 1e-9
"""Share of the time of the run in which a relay may not change as often."""
CHUNK = 0.2
"""Seconds between looks at progress, interruption and the file, where samples come in time."""
PATIENCE = 0.3
"""Seconds after which an integrator comes back without a sample."""
HOLD = 10.0
"""Seconds without a sample after which the state that was reached is kept."""


class Phases:
    """A run through the phases that events divide it into.

    `before` are the statistics of the run that is continued, if one is, and `planned` all its samples; `whole` asks for
    all samples at once; after `time_limit` seconds of the clock it ends.
    """

    def __init__(
        self,
        integrator,
        recorder: Recorder,
        times: np.ndarray,
        progress,
        before=None,
        whole=False,
        planned=None,
        time_limit=None,
    ):
        self.integrator, self.recorder, self.times, self.progress = integrator, recorder, times, progress
        self.planned = times if planned is None else planned
        self.span = float(self.planned[-1] - self.planned[0])
        self.statistics: dict[str, Any] = {}
        self.variables: Any = None
        self.validity = Validity(before)
        self.whole = whole
        self.jumps: list[PrescribedJump] = []
        self.kept = KeptRows(recorder, self.validity, times)
        self.recording = False
        self.interruption = Interruption(time_limit)
        self.passed: dict[str, float] = {}
        self.happened = Happened()
        self.outlook = Outlook(float(times[0]), float(times[-1]))
        self.contacts = CoarseContacts(integrator)
        self.lost: float | None = None
        """Time, s, of the last sample before a force or drive has no value, where that has ended the run."""

    @property
    def t(self) -> float:
        """The time, s, that has been reached."""
        return self.kept.t

    @t.setter
    def t(self, t: float) -> None:
        self.kept.t = t

    def run(self, model: Model, assembled: tuple[System, State], works=None, goes_on=None) -> Status:
        """Run all phases and return how the run ended.

        The first begins at a state that `assemble` made; it may continue a phase, `goes_on`. What goes
        wrong later (an event leaves a mechanism that cannot move on) ends the run, and what was computed is kept.
        """
        try:
            with self.interruption, self._hearing():
                return self._run(model, assembled, works, goes_on)
        except KeyboardInterrupt:
            if self._has_nothing():
                raise
            status = self.interruption.status(self.t)
            if self.recording:
                self.recorder.end(status.kind)
            return status
        except (ModelError, CompileError, IntegrationError) as error:
            if self._has_nothing():
                raise
            if self.recording:
                self.recorder.end("failed")
            return Status.failed(
                f"{error.part} at t = {self.t:.9g} s: {error.found}; expected: {error.expected}", error.remedy
            )

    def _has_nothing(self) -> bool:
        """Is there no sample yet that an end of the run could keep?"""
        return not self.recorder.phases and not self.recorder.rows

    @contextmanager
    def _hearing(self):
        with listening() as told:
            try:
                yield
            finally:
                self.validity.keep(told)

    def _run(self, model: Model, assembled, works, goes_on) -> Status:
        works = np.zeros(3) if works is None else works
        while True:
            system, start = assembled
            self.recorder.begin(model, system)
            self.validity.share(shared_reactions(system))
            self.recording = True
            ended = self._phase(model, system, start, works, goes_on)
            goes_on = None
            if not isinstance(ended, tuple):
                self.recorder.end(ended.kind)
                return ended
            event, rows, watch = ended
            self.recorder.end(event.name)
            self.recording = False
            began = self.t = float(rows["t"][-1])
            works = rows["works"][-1]
            following = next_phase(model, event, watch.series(rows))
            if following is None:
                return Status.stopped(event.name, began)
            if self.happened.too_often(event, began, self.span / LOOKS):
                return Status.failed(f"{event.title} happens again and again at t = {began:.9g} s", LASTING)
            u = velocities_after(system, event, began, rows["q"][-1], rows["u"][-1])
            before, model, state = model, following, carried(system, following, rows["q"][-1], u)
            if began >= self.times[-1] - SAME * abs(self.times[-1]):
                return Status.finished(began)
            assembled = assembled_after(event, before, model, began, state)
            require_continuity(event, assembled[0], state, assembled[1].q)
            require_known_states(event, system, assembled[0])

    def _switched(self, event, row, system, work, times) -> tuple[np.ndarray, Any]:
        """Let a held value change at a row, and begin anew there; return the works until then, and the row."""
        self.t = t = float(row["t"][-1])
        if self.happened.too_often(event, t, self.span * ENDLESS):
            raise IntegrationError(
                event.title,
                found=f"it switches again and again at t = {t:.9g} s",
                expected="time between two changes",
                remedy="Set its limits farther apart, or give a hysteresis",
            )
        works, row = self._begin_anew(system, work, t, row, event.title)
        self._keep(row, times)
        return works, row

    def _phase(self, model, system, start, works, goes_on):
        """Run one phase; return the status if the run ends in it, else (event, its rows, watch)."""
        work = system.workspace()
        start, late = self._just_after_jumps(system, start, work)
        self._start(system, start, work)
        self.kept.begin(system)
        self.outlook.new_phase()
        self.block_start = BlockStart(self.integrator, system, work)
        watch = Watch(model, system, self.integrator, work, self.passed, self.interruption.look_now)
        if goes_on is not None:
            watch.recall(goes_on)
            remember_again(self.integrator, system, self.variables, start, goes_on, late)
        due, end, times, marks, breaks = self._times(model, system, goes_on, bool(watch.events))
        self.kept.divide(times)
        first, block, last_row, begun = 0, len(marks) if self.whole else 1, None, -1
        before = self.statistics.get("steps", 0)
        try:
            while first < len(marks):
                marks = self.kept.gradients.planned(marks, first)
                anew = np.append(np.searchsorted(marks, breaks), len(marks))
                last = min(int(anew[np.searchsorted(anew, first, side="right")]), first + block)
                last = min(last, self.kept.block_end(marks, first), self.kept.gradients.until)
                clock = time.perf_counter()
                if first in anew and first != begun:
                    works, last_row = self._go_on(system, work, just_after(marks[first]), last_row, works)
                    begun = first
                if watch.events:
                    self.block_start.keep(self.variables, marks, first)
                outcome = self.integrator.run(system, work, self.variables, marks, first, last, PATIENCE)
                outcome = arrived(system, outcome, marks[first:])
                self.kept.require_half_turns(outcome.rows, getattr(self.variables, "switching", None))
                rows = counted_on(outcome.rows, works, marks[first], first in anew or (late and first == 0))
                if found := self._first_event(watch, rows, last_row, times):
                    event, after = found
                    if isinstance(event, Switching):
                        works, last_row = self._switched(event, after, system, work, times)
                        reached = int(np.searchsorted(marks, self.t, side="right"))
                        first, block = reached, max(1, min(block, 2 * (reached - first)))  # switches come in rows
                        continue
                    self.recorder.add(after)
                    self.validity.look_at_shared(system, after)
                    return event, after, watch
                try:
                    require_seen(system, self.variables)
                finally:  # which forgets what has touched
                    self._keep(rows, times)
                if outcome.failure:
                    return self._failed(model, system, start, work, rows if len(rows["t"]) else last_row, outcome)
                if len(rows["t"]):
                    last_row, first = _row(rows, -1), first + len(rows["t"])
                    self.t = float(marks[first - 1])
                now = max(self.t, outcome.reached)
                if self.progress is not None:
                    self.progress(now, float(self.times[-1]))
                if may_stop(self.integrator, marks, first, self.t, now, watch.events and self.interruption.in_grace):
                    self._hold(now, last_row if watch.events else None, system, work, works)
                    if first < len(marks) or due is not None:  # what is complete is not cut off
                        self.interruption.look()
                if early := self.outlook.look(self.integrator, system, work, self.variables, now, self.validity):
                    return early
                block = self._next_block(block, time.perf_counter() - clock, len(marks))
        except KeyboardInterrupt:
            if self._has_nothing():
                raise
            return self.interruption.status(self.t)
        finally:
            self._tell(system)
        gone = self._grown(system, work, start, last_row, end, self.statistics.get("steps", 0) - before)
        return gone or ((due, last_row, watch) if due is not None else Status.finished(end))

    def _grown(self, system, work, start, last_row, end: float, steps: int):
        """Return how a phase ends in whose steps a motion grows that they pass over; None if none does."""
        blocks = [*self.recorder.rows, *([] if last_row is None else [last_row])]
        given = system, work, start, blocks, end, steps
        gone, stands = looked_at(self.interruption, self.validity, unstable_in_steps, *given) or (None, [])
        self.validity.tell(stands)
        return gone

    def _first_event(self, watch, rows, before, times):
        """Keep what comes until the first event in new rows, and return it with its row; None if nothing happens."""
        if not watch.events or not len(rows["t"]):
            return None
        looked = rows if before is None else joined_rows([before, rows])
        found = watch.first(looked, begins=before is None)
        if found is None:
            return None
        events, k = found
        event, after, ahead = events[0], _row(looked, k), k if before is None else k - 1
        self.variables = self.block_start.back(self.variables, ahead)
        if k > 0:
            event, after = watch.locate(events, _row(looked, k - 1), after)
        watch.happened(event, after)
        self._keep({name: x[:ahead] for name, x in rows.items()}, times)
        return event, after

    def _keep(self, rows, times) -> None:
        self.kept.keep(rows, times, getattr(self.variables, "switching", None))

    def _just_after_jumps(self, system, start, work):
        """Return the start of a phase behind the jumps of prescribed speeds there, with what is held, and if any is."""
        late = jumps_at_once(system, self.t)
        if late:
            u = self._over_jump(system, work, start.q, start.u, self.t, self.t)
            start = consistent_start(system, system.state(just_after(self.t), start.q, u), work)
        if system.holds:
            q = held_from(system, work, start.t, start.q, start.u)
            start = consistent_start(system, system.state(start.t, q, start.u), work)
        return start, late

    def _times(self, model, system, goes_on, watches: bool) -> PhaseTimes:
        """Return the times of a phase that begins now, or that goes on; `watches`: it has events to look at."""
        begun_at = self.t if goes_on is None else float(goes_on.t[0])
        remembers, longest = getattr(self.integrator, "remembers", False), self.span / LOOKS if watches else None
        found = times_of_phase(model, system, self.t, self.times, self.planned, begun_at, remembers, longest)
        self.validity.tell(missed_times(system, found.samples))
        return found

    def _failed(self, model, system, start, work, known, outcome):
        """Return how a run ends that its integrator gives up; `known` is the last row there is, or None."""
        gone = self.outlook.far_gone(self.integrator, system, work, self.variables, outcome.reached)
        unknown = what_is_unknown(system, start, known, outcome.reached, gone, self.t, self.times)
        at_end = unstable_at_end, system, work, start, known, outcome.reached
        gone = gone or looked_at(self.interruption, self.validity, *at_end)
        ending = None if unknown or gone else self.kept.gradients.ending(outcome)
        self.lost = self.t if unknown else None
        return ending or failed_with(model, outcome, unknown, gone)

    def _next_block(self, block: int, spent: float, most: int) -> int:
        """Return how many samples are asked for next; after Ctrl-C to the next one only."""
        longer = 0.0 if self.interruption.asked else min(4.0, CHUNK / max(spent, 1e-4))
        return min(most, max(1, int(block * longer)))

    def _tell(self, system) -> None:
        """Count what the integrator did in a phase, and give the warnings about it."""
        self._count(system)
        self.kept.look(getattr(self.variables, "switching", None))
        if self.kept.energy is not None:
            steps = self.integrator.statistics(self.variables).get("steps", 0)
            self.kept.energy.tell(self.integrator, self.variables, steps, self.validity)
            self.validity.tell(chattering(system, getattr(self.variables, "switching", None), steps))
        divided = divided_steps(self.integrator, self.statistics, self.t)
        coarse = self.contacts.sentences(self.t - float(self.times[0]))
        self.validity.tell([*divided, *sentences_about(self.jumps), *self.validity.creeps(), *coarse])
        tell_of(self.integrator, system, self.variables, self.statistics, self.validity, lost=self.lost)

    def _hold(self, now: float, row, system, work, works) -> None:
        """Keep the state that has been reached, and what the integrator knows: now and then while no samples come, and
        where the user asks for the end.

        Parameters
        ----------
        now : float, s
            The time of the integrator.
        row
            In a phase that waits for events, the last row at which they were looked for; else None.
        """
        self.recorder.look()
        self.interruption.look_at_clock()
        if not self.recorder.rows or not (self.interruption.asked or time.monotonic() - self.recorder.latest > HOLD):
            return
        last = _row(self.recorder.rows[-1], -1)
        if row is None and now <= last["t"][-1] + rounding(last["t"][-1]):  # or just after it, where a signal jumps
            row = last
        if row is None:
            rows = present_rows(self.integrator, system, work, self.variables, now)
            row = {**rows, "works": rows["works"] + works}
        if len(row["t"]):
            at = float(row["t"][-1])
            known = memory_of(self.integrator, self.variables) if now <= at + rounding(at) else None
            self.recorder.hold(row, known)
            self.t = at

    def _go_on(self, system, work, t: float, before, works) -> tuple[np.ndarray, Any]:
        """Go on behind a sample of blocks, or begin anew; return as `_begin_anew`."""
        held = sampled_on(self.integrator, system, work, self.variables, float(t), before)
        return self._begin_anew(system, work, t, before) if held is None else (works, held)

    def _begin_anew(self, system, work, t: float, before, passed: str = "") -> tuple[np.ndarray, Any]:
        """Start the integrator again, where a signal jumps or kinks, from the row before;
        return the works until then, and the row with what is held from now on.
        """
        self._count(system)
        before = with_held(system, work, t, before, passed)
        q, left = before["q"][-1], float(before["t"][-1])
        u = self._over_jump(system, work, q, before["u"][-1], t, left)
        state = consistent_start(system, system.state(t, q, u), work)
        self._start(system, state, work, within=True)
        self.outlook.new_phase()
        return before["works"][-1], before

    def _over_jump(self, system, work, q: np.ndarray, u: np.ndarray, t: float, left: float) -> np.ndarray:
        """Return the velocities after a jump of the prescribed speeds between `left` and t; no position may jump."""
        u, jumps = speeds_after(system, work, q, u, t, left)
        self.jumps += jumps
        if jumps and self.kept.energy is not None:
            self.kept.energy.jumped = True
        return u

    def _start(self, system, state, work, within: bool = False) -> None:
        """Start the integrator, perhaps within a phase; errors until then stay known."""
        start = system, state, work, float(self.times[-1])
        self.variables = started_again(self.integrator, self.variables, start, within)

    def _count(self, system) -> None:
        """Add the numbers of the integrator's run to the totals, and tell what would be forgotten with it."""
        switching = getattr(self.variables, "switching", None)
        self.validity.tell(self.kept.sunk.look(system, switching))
        contacts = self.contacts.look(system, switching)
        self.statistics = together(self.statistics, {**numbers_of(self.integrator, system, self.variables), **contacts})


def _row(rows, k: int) -> dict[str, np.ndarray]:
    return {name: x[k:][:1] if k >= 0 else x[-1:] for name, x in rows.items()}
