"""The second motion beside a run: its begin, and its continuation over a new start."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.variables import Apart, Controls, Motions, Variables
from flexmb.integrate.alpha.world_translation import to_body_axes, turn
from flexmb.integrate.runs.gap import begin_again, new_gap
from flexmb.integrate.runs.reaction_errors import ENDED, new_comparison
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import State
from flexmb.math.weights import weigh, weigh_mass
from flexmb.system.mobility import constraint_matrix
from flexmb.system.program import advance, evaluate

__all__ = ["beside", "known", "taken_over"]

MANY = 0.1
"""Part of the steps that the motion beside may fail to take."""

SHARED = ("extent", "reach", "signals", "pace", "world", "switching", "axes")
"""What both motions have in common."""


def beside(system, own: Variables, followed: bool) -> Motions:
    """Return the motion of a run at its start, and the one without local errors, which still is the same.

    It stays as it is where it shall not be followed.
    """
    copied = {name: getattr(own, name).copy() for name in own._fields if name not in SHARED}
    return Motions(
        own=own,
        corrected=own._replace(**copied),
        apart=Apart(
            dx=np.zeros(system.nu),
            du=np.zeros(system.nu),
            q=np.zeros(system.nq),
            u=np.zeros(system.nu),
            a=np.zeros(system.nu),
            second=np.zeros(system.ng),
            early=np.zeros(system.ng),
            earlier=np.zeros(system.ng),
            x=np.zeros(system.nu),
            y=np.zeros(system.nu),
            q_start=own.q.copy(),
            reactions=new_comparison(system),
            run=new_gap(system, followed),
        ),
    )


def known(motions: Motions) -> bool:
    """Could the motion beside take nearly all steps? Where it cannot, it only keeps its distance."""
    run = motions.corrected.run[0]
    return bool(run["rejected_by_iteration"] <= MANY * max(run["steps"], 1))


def taken_over(system, before: Motions, now: Motions, c: Controls) -> Motions:
    """Return a new start with the distance that the motions had; in a model with other coordinates its size alone is
    known.

    A new start takes steps a hundred times shorter than those before. What of the distance the steps before could not
    resolve, stiff bushings and velocities that joints forbid, is no error of the motion; it would be resolved now, as a
    vibration that it never had, and grow with the steps.
    """
    now.apart.run[:] = before.apart.run
    for name in ("steps", "rejected_by_iteration"):
        now.corrected.run[name] = before.corrected.run[name]
    now.apart.reactions[:] = ENDED  # the distance of the motions meets other equations: nothing is told from here on
    if before.own.q.shape != now.own.q.shape or before.own.u.shape != now.own.u.shape:
        begin_again(now.apart.run)
        return now
    now.apart.q_start[:] = before.apart.q_start
    place = _increment(system.program, before.own.q, before.corrected.q)
    speed, rest = np.zeros((2, system.nu))
    to_body_axes(before.own.world, before.own.q, before.corrected.u - before.own.u, np.zeros(system.nu), speed, rest)
    if np.any(place) or np.any(speed):
        place, speed = _resolved(system, now.own, float(before.own.run["last_step"][0]), c, (place, speed))
        turn(now.own.world, now.own.q, speed)
        advance(system.program, now.own.q, place, 1.0, now.corrected.q)
        now.corrected.u[:] += speed
    return now


def _increment(program, q: np.ndarray, then: np.ndarray) -> np.ndarray:
    """Return the small increment (nu,) in body axes that leads from one configuration (nq,) to another."""
    x = np.zeros(
        int(max(np.max(program.frames[:, 1] + 6, initial=0), np.max(program.vectors[:, 1:3].sum(1), initial=0)))
    )
    for iq, iu in program.frames[:, :2]:
        s, v = q[iq + 3], q[iq + 4 : iq + 7]
        s1, v1 = then[iq + 3], then[iq + 4 : iq + 7]
        euler_to_matrix(q[iq + 3 : iq + 7], R := np.empty((3, 3)))
        x[iu : iu + 3] = R.T @ (then[iq : iq + 3] - q[iq : iq + 3])
        x[iu + 3 : iu + 6] = 2.0 * np.sign(s * s1 + v @ v1) * (s * v1 - s1 * v - np.cross(v, v1))
    for iq, iu, size in program.vectors[:, :3]:
        x[iu : iu + size] = then[iq : iq + size] - q[iq : iq + size]
    return x


def _resolved(system, own: Variables, h: float, c: Controls, distances):
    """Return what steps of the size before, h, follow of distances (nu,): with P = S^-1 M, (3 - 2 P) P^2 x.

    With y = beta (w h)^2, a vibration of the frequency w keeps 1 - 3 y^2 of itself if it is slow, 3 / y^2 if it is
    stiff. What equations forbid goes.
    """
    work = system.workspace()
    scale = h * h * c.beta * (1.0 - c.alpha_f) / (1.0 - c.alpha_m)
    u, a = np.zeros((2, system.nu))
    to_body_axes(own.world, own.q, own.u, own.a, u, a)
    state = State(float(own.run["t"][0]), own.q, u, a, own.lam, own.signals)
    weigh_mass(work.weights)
    evaluate(system.program, state, work)
    mass = constraint_matrix(system, work)[0]
    weigh(work.weights, 1.0, scale * c.gamma / (c.beta * h), scale)
    evaluate(system.program, state, work)
    if lu_factor(work.S, system.program.pattern) >= 0:
        return distances
    kept = []
    for x in distances:
        smooth = [x]
        for _ in range(3):
            right = np.zeros(system.nu + system.ng)
            right[: system.nu] = mass @ smooth[-1]
            lu_solve(work.S, system.program.pattern, right)
            smooth.append(right[: system.nu])
        resolved = 3.0 * smooth[2] - 2.0 * smooth[3]
        kept.append(resolved if np.all(np.isfinite(resolved)) else x)
    return kept
