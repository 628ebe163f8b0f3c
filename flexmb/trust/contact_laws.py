"""Laws of rigid contact at samples: could forces that obey them give the motion that was computed?

`MoreauJean` finds impulses by projections. Here none of them is used: from the velocities before and after the step
that ends at a sample it is said of every point which force its law permits, and non-negative least squares look for
such forces with the resultants of the sample. What is left of these is what no lawful force explains. Velocities with
which surfaces that touch still approach each other, and penetrations, are looked at as they are.

Permitted is no force where surfaces part, a ray of the cone against a slip, and the whole cone where nothing slips
(`RAYS` rays around it). Moments of rolling and drilling friction are taken as free.

Source of the least squares: Lawson & Hanson, Solving Least Squares Problems, 1974, chapter 23.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmb.integrate.alpha.world_translation import frames_in_world_axes, move, to_body_axes, to_world_axes
from flexmb.integrate.nonsmooth.points import Touching
from flexmb.math.weights import no_matrix
from flexmb.results import Phase
from flexmb.system.program import advance, evaluate

__all__ = ["Lawfulness", "in_the_middle", "lawfulness", "regular_steps"]

RAYS = 24
"""Directions of friction that stand for a round cone; the polygon is around it, 0.9 % wider at its corners."""
MOST = 150
"""Points of contact up to which forces are looked for."""
TOUCHING = 1e-6
"""Gap, relative to the smallest surface, that counts as none."""
ROUNDING = 1e-9
"""Resultants that are less than this, relative to the weight of the model, are none."""


@dataclass(frozen=True)
class Lawfulness:
    """How far the contacts of a phase obey their laws.

    Parameters
    ----------
    force : float
        Largest resultant that no lawful forces explain, relative to the largest of its sample.
    approach : float
        Largest speed at which surfaces that touch still approach, relative to the change of velocities in the step.
    depth : float
        Deepest penetration, relative to the smallest surface.
    at : (float, float, float), s
        When.
    skipped : str
        Why forces were not looked for at some samples, or an empty text.
    """

    force: float
    approach: float
    depth: float
    at: tuple[float, float, float]
    skipped: str = ""


def regular_steps(solution, step: float) -> bool:
    """Has the run taken the steps that its samples and the given one lead to, none shortened or divided?"""
    expected = sum(int(np.sum(np.ceil(np.diff(phase.t) / step * (1.0 - 1e-9)))) for phase in solution.phases)
    return solution.statistics.get("steps") == expected


def _length(phase: Phase, k: int, step: float) -> float:
    """Return the length of the step that ends at sample k, s."""
    before = float(phase.t[k] - phase.t[k - 1])
    return before / max(1.0, np.ceil(before / step * (1.0 - 1e-9)))


def in_the_middle(phase: Phase, system, samples: list[int], step: float) -> tuple[Phase, np.ndarray, np.ndarray]:
    """Return a phase with the middles of the steps that end at these samples, where accelerations and forces are those
    of the samples; the configurations (n, nq) at which contacts were looked for, half a step on with the velocities
    before; and velocities before and after each step, (n, 2, nu), in the axes there.
    """
    world = frames_in_world_axes(system)
    times, configurations, speeds, rates, places, both = [], [], [], [], [], []
    for k in samples:
        h = _length(phase, k, step)
        end, a = phase.u[k].copy(), phase.a[k].copy()
        to_world_axes(world, phase.q[k], end, a)
        start = end - h * a
        mean = 0.5 * (start + end)
        full = system.state(0.0, phase.q[k]).q
        q, u, rate = _moved(system, world, full, -0.5 * h * mean), np.empty(system.nu), np.empty(system.nu)
        to_body_axes(world, q, mean, a, u, rate)
        found = _moved(system, world, _moved(system, world, full, -h * mean), 0.5 * h * start)
        pair, rest, none = [], np.zeros(system.nu), np.empty(system.nu)
        for x in (start, end):
            own = np.empty(system.nu)
            to_body_axes(world, found, x, rest, own, none)
            pair.append(own)
        places.append(found)
        both.append(pair)
        times.append(phase.t[k] - 0.5 * h)
        configurations.append(q)
        speeds.append(u)
        rates.append(rate)
    middle = replace(
        phase,
        t=np.array(times),
        q=np.array(configurations),
        u=np.array(speeds),
        a=np.array(rates),
        lam=phase.lam[samples],
        works=phase.works[samples],
        inputs=None,
    )
    return middle, np.array(places), np.array(both)


def _moved(system, world, q, dx) -> np.ndarray:
    """Return q moved by dx, frames of `world` in W; what a sample keeps beside positions stays."""
    out = np.empty(system.nq)
    advance(system.program, q, dx, 1.0, out)
    move(world, q, dx, out)
    out[system.program.branches :] = q[system.program.branches :]
    return out


def _twists(system, work, t, q, u) -> np.ndarray:
    """Return velocity and spin of all markers (n, 6) at a configuration with the velocities u."""
    no_matrix(work.weights)
    evaluate(system.program, system.state(t, q, u), work)
    return np.column_stack([work.markers["v"], work.markers["w"]])


def lawfulness(phase: Phase, system, samples: list[int], step: float, within: float) -> Lawfulness:
    """Return how far the contacts obey their laws in the steps that end at these samples, not the first one."""
    touching, work = Touching(system), system.workspace()
    middle, places, both = in_the_middle(phase, system, samples, step)
    worst, at, skipped = np.zeros(3), np.full(3, float(phase.t[samples[0]])), ""
    for n, k in enumerate(samples):
        h = _length(phase, k, step)
        before, after = (_twists(system, work, middle.t[n], places[n], u) for u in both[n])
        points = touching.found(work, h, TOUCHING * touching.small).copy()
        found = _of_step(system, points, work.markers["r"].copy(), before, after, h, within, touching.small)
        wrenches = _kept(system, phase.q[k])
        found_force = 0.0
        if np.any([np.any(x) for x in wrenches.values()]):
            if len(found[1]) > MOST:
                skipped = f"forces of more than {MOST} points of contact were not looked for"
            else:
                found_force = _left(system, wrenches, found[1], work.markers["r"])
        no_matrix(work.weights)
        evaluate(system.program, system.state(phase.t[k], phase.q[k], phase.u[k]), work)
        deep = touching.found(work, 0.0, 0.0)["gap"]
        own = (found_force, found[0], max(0.0, -float(deep.min(initial=0.0))) / touching.small)
        for i in range(3):
            if own[i] > worst[i]:
                worst[i], at[i] = own[i], float(phase.t[k])
    force, approach, depth = (float(x) for x in worst)
    when = (float(at[0]), float(at[1]), float(at[2]))
    return Lawfulness(force=force, approach=approach, depth=depth, at=when, skipped=skipped)


def _kept(system, q: np.ndarray) -> dict[tuple[int, int], np.ndarray]:
    """Return the wrench that a sample keeps of every rigid contact and marker."""
    names = {name: k for k, name in enumerate(system.branch_names)}
    first = system.program.branches
    return {
        (owner, system.marker_index[marker]): q[first + np.array([names[title] for title in force.kept_names(marker)])]
        for owner, force in enumerate(system.model.forces)
        if force.impulsive
        for marker in force.touching_markers(system.model)
    }


def _of_step(system, points, places, before, after, h, within, small):
    """Return the largest approach of touching points, relative, and points with the rays (n, 6) of lawful forces."""
    kinds = []
    for point in points:
        xi = []
        for twist in (before, after):
            ends = [twist[m, :3] + np.cross(twist[m, 3:], point["r"] - places[m]) for m in (point["a"], point["b"])]
            xi.append(point["axes"] @ (ends[1] - ends[0]))
        kinds.append(xi)
    if not kinds:
        return 0.0, []
    xi = np.array(kinds)
    scale = float(np.abs(xi[:, 1] - xi[:, 0]).max()) + float(np.linalg.norm(system.model.gravity)) * h
    if not scale > 0.0:
        return 0.0, []
    allowed, approach, rays = within * scale, 0.0, []
    for point, (was, now) in zip(points, xi, strict=True):
        e = max(point["restitution"], point["poisson"])
        left = now[0] + max(point["gap"] - 0.5 * h * was[0], 0.0) / h
        presses = left <= allowed
        if e > 0.0 and point["gap"] <= TOUCHING * small:
            presses |= point["poisson"] > 0.0 or now[0] + e * was[0] <= allowed
        elif e == 0.0:
            approach = max(approach, -left / scale)
        if presses:
            rays.append((point, _rays(point, now[1:], allowed)))
    return approach, rays


def _rays(point, slip: np.ndarray, allowed: float) -> np.ndarray:
    """Return wrenches on b (n, 6), force and moment at the point in W, whose sums with factors >= 0 are lawful."""
    n, t1, t2 = point["axes"]
    mu, size = float(point["friction"]), float(np.linalg.norm(slip))
    if mu == 0.0:
        forces = n[None]
    elif size > allowed:
        forces = (n - mu * (slip[0] * t1 + slip[1] * t2) / size)[None]
    else:
        angle = 2.0 * np.pi * np.arange(RAYS) / RAYS
        around = np.outer(np.cos(angle), t1) + np.outer(np.sin(angle), t2)
        forces = n + mu / np.cos(np.pi / RAYS) * around
    rows = [np.column_stack([forces, np.zeros_like(forces)])]
    for given, axes in (("drilling", (n,)), ("rolling", (t1, t2))):
        if point[given] > 0.0:
            moments = np.concatenate([axes, [-axis for axis in axes]])
            rows.append(np.column_stack([np.zeros_like(moments), moments]))
    return np.concatenate(rows)


def _left(system, wrenches, rays, places) -> float:
    """Return the largest part of the resultants that no sum of rays explains, relative to the largest."""
    from scipy.optimize import nnls

    rows = {key: 6 * n for n, key in enumerate(wrenches)}
    expected = np.concatenate(list(wrenches.values()))
    lever = system.lengths.whole
    weights = np.tile([1.0, 1.0, 1.0, *(1.0 / lever,) * 3], len(rows))
    columns = []
    for point, forces in rays:
        for wrench in forces:
            column = np.zeros(len(expected))
            for marker, sign in ((int(point["b"]), 1.0), (int(point["a"]), -1.0)):
                at = rows[int(point["owner"]), marker]
                column[at : at + 3] += sign * wrench[:3]
                column[at + 3 : at + 6] += sign * (wrench[3:] + np.cross(point["r"] - places[marker], wrench[:3]))
            columns.append(column)
    largest = float(np.abs(weights * expected).max())
    if not largest > ROUNDING * float(np.linalg.norm(system.model.gravity)):
        return 0.0
    if not columns:
        return 1.0
    A = weights[:, None] * np.array(columns).T
    factors, _ = nnls(A, weights * expected / largest, maxiter=50 * A.shape[1])
    return float(np.abs(A @ factors - weights * expected / largest).max())
