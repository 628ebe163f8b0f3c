"""Jumps of prescribed motions: positions may not jump, velocities do by impulses, and are told."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from flexmb.errors import ModelError
from flexmb.integrate.runs.breaks import just_after, just_before
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.weights import weigh_mass
from flexmb.system.program import constraint_acceleration, constraint_velocity, evaluate

__all__ = ["PrescribedJump", "prescribed_jump", "require_no_jumps", "sentences_about", "speeds_after"]

JUMP = 1e-6
"""Change of an equation, relative to its length (or rad; of its rate, to that per second), that is a jump: less comes
from the digits of the numbers in a signal."""
SOLVES = 3
"""Of the equations of impulses: dependent equations are soft."""


@dataclass(frozen=True, kw_only=True)
class PrescribedJump:
    """What a prescribed motion does at a time.

    Parameters
    ----------
    title : str
        The part that prescribes.
    t : float, s
    place, speed : float, m or rad, m/s or rad/s
        Jump of what the worst equation asks for; zero without a jump.
    unit : str
    """

    title: str
    t: float
    place: float
    speed: float
    unit: str

    def require_place(self) -> None:
        """Raise ModelError if positions jump."""
        if self.place:
            raise ModelError(
                self.title,
                found=f"the motion that it prescribes jumps by {self.place:.6g} {self.unit} at t = {self.t:.9g} s",
                expected="positions that go on: no force moves a body at once",
                remedy="Lead over in a finite time: fmb.step(value, at=..., rise=...), fmb.ramp or a table",
            )


def sentences_about(jumps: Iterable[PrescribedJump]) -> list[str]:
    """Return what an analysis says about the jumps of speed: a sentence for each part, with its largest."""
    by_part: dict[str, list[PrescribedJump]] = {}
    for jump in jumps:
        by_part.setdefault(jump.title, []).append(jump)
    found = []
    for title, own in by_part.items():
        largest = max(own, key=lambda jump: jump.speed)
        often = f" ({len(own)} jumps, the largest)" if len(own) > 1 else ""
        found.append(
            f"{title}: the speed that it prescribes jumps by {largest.speed:.6g} {largest.unit}/s at "
            f"t = {largest.t:.9g} s{often}; expected: speeds that go on. The impulse of a jump acts at once: it "
            "changes the energy, and no reaction shows it. Where its force matters, give the change a time: "
            "fmb.ramp(rate, rise=...), fmb.step(..., rise=...), or a cubic table."
        )
    return found


def prescribed_jump(system, work, q: np.ndarray, u: np.ndarray, t: float, left: float | None = None):
    """Return the PrescribedJump at a time, with the configuration q (nq,) and velocities u (nu,) there; None if none.

    `left` is the time on the left, by default just before `t`.
    """
    if system.prescribing.stop <= system.prescribing.start:
        return None
    sides = []
    for at in (just_before(t) if left is None else left, just_after(t)):
        work.weights[0].wanted = 0
        evaluate(system.program, system.state(at, q, u), work)
        (rate, change), places = np.zeros((2, system.ng)), system.program.equation_level == 0
        constraint_velocity(work, u, rate)
        constraint_acceleration(work, np.zeros(system.nu), change)
        # the bodies stand still while the signals go on: the rate that matters is theirs
        own = np.abs(work.equations["rate"])
        sides.append((np.where(places, work.equations["g"], 0.0), rate, own, np.abs(change)))
    (g0, v0, own0, change0), (g1, v1, own1, change1) = sides
    lengths, moved = system.lengths.equations, 4.0 * (just_after(t) - just_before(t))
    place, speed = np.abs(g1 - g0), np.abs(v1 - v0)
    turns = np.where(system.lengths.are_lengths, 0.0, np.rint(place / (2.0 * np.pi)))  # half a turn away, left is right
    place = np.abs(place - 2.0 * np.pi * turns)
    place = np.where(place > JUMP * lengths + moved * np.maximum(own0, own1), place, 0.0)
    least = JUMP * np.maximum(lengths, np.maximum(np.abs(v0), np.abs(v1)))
    speed = np.where(speed > least + moved * np.maximum(change0, change1), speed, 0.0)
    if not (np.any(place) or np.any(speed)):
        return None
    k = int(np.argmax((place if np.any(place) else speed) / lengths))
    name = next(n for n, rows in system.joint_equations.items() if rows.start <= k < rows.stop)
    title = next((joint.title for joint in system.model.joints if joint.name == name), f"Joint '{name}'")
    unit = "m" if system.lengths.are_lengths[k] else "rad"
    return PrescribedJump(title=title, t=float(t), place=float(place[k]), speed=float(speed[k]), unit=unit)


def require_no_jumps(system, start, end: float) -> list[PrescribedJump]:
    """Return the jumps of prescribed speeds from the start of a run to its end (s); ModelError if a position jumps.

    It is found at the configuration of the start. What depends on the configuration is looked at again in the run, and
    what follows events, which may replace drives.
    """
    if system.prescribing.stop <= system.prescribing.start or any(e.sensor is not None for e in system.model.events):
        return []
    begin = float(start.t)
    end = min([end, *(e.at for e in system.model.events)])
    breaks = system.signal_times.between(begin, end).breaks
    work, found = system.workspace(), []
    for t in (begin, *breaks[(breaks > begin) & (breaks <= end)]):
        jump = prescribed_jump(system, work, start.q, start.u, t, begin if t == begin else None)
        if jump is not None:
            jump.require_place()
            found.append(jump)
    return found


def speeds_after(
    system, work, q: np.ndarray, u: np.ndarray, t: float, left: float
) -> tuple[np.ndarray, list[PrescribedJump]]:
    """Return the velocities (nu,) after what prescribed speeds do between `left` and t, and the jump, if there is one.

    Raises
    ------
    ModelError
        If a prescribed position jumps.
    """
    jump = prescribed_jump(system, work, q, u, t, left)
    if jump is None:
        return u, []
    jump.require_place()
    return _velocities_with_impulses(system, work, system.state(just_after(t), q, u)), [jump]


def _velocities_with_impulses(system, work, state) -> np.ndarray:
    """Return the velocities (nu,) that satisfy the equations after impulses of the multipliers:
    M du = G^T P, G (u + du) + dg/dt = 0.
    """
    weigh_mass(work.weights)
    evaluate(system.program, state, work)
    lu_factor(work.S, system.program.pattern)
    u, rate = np.array(state.u), np.zeros(system.ng)
    for _ in range(SOLVES):
        constraint_velocity(work, u, rate)
        right = np.concatenate([np.zeros(system.nu), -rate])
        lu_solve(work.S, system.program.pattern, right)
        u += right[: system.nu]
    return u
