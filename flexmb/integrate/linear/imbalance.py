"""Is a state an equilibrium, or part of a steady motion? If not, a linear model about it holds for an instant only."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.linear.driven import driven_accelerations
from flexmb.integrate.linear.steady import SteadyMotion
from flexmb.integrate.matrices import equations_at
from flexmb.math.rotations import euler_to_matrix
from flexmb.model.connections import held_by_ground
from flexmb.system.accelerations import accelerations, settled_accelerations
from flexmb.system.mobility import mass_metric

__all__ = ["imbalance"]

UNBALANCED = 1e-2
"""Acceleration beyond the steady motion's, relative to free bodies', from which a warning is given."""
ROUNDINGS = 100.0
"""Last digits of places that sums of stiff forces may be wrong by."""
STANDING = 1e-7
"""Lengths of the model per second squared: acceleration below this is none."""


def imbalance(
    system, state, work, motion: SteadyMotion, stiffness: np.ndarray, around: np.ndarray | None
) -> str | None:
    """Return a sentence about the body that accelerates most beyond what its steady motion asks for, or None.

    Parameters
    ----------
    state : State
        If its accelerations are zero (an equilibrium), drives that speed up are taken at their speed of the moment.
        They are not read besides, nor are the multipliers.
    motion : SteadyMotion
        That which goes on with the velocities of the state.
    stiffness : (nu,)
        Of the coordinates: what the last digits of places make of forces.
    around : (3,), rad/s, in W, or None
        Angular velocity of the observer for whom the motion is steady; None: each body's own.
    """
    now = state._replace(a=np.zeros(system.nu), lam=np.zeros(system.ng))
    right, sweeps = np.zeros(system.nu + system.ng), 12 if system.redundant else 2
    if accelerations(system.program, now, work, right, sweeps) >= 0:
        return None
    if not settled_accelerations(system, now, work, right):
        return None
    # one that flies on, or falls freely where nothing connects it to the ground, is steady as well, turning as it does
    expected = [motion.a, _gone_round(system, now, np.zeros(3)), _gone_round(system, now, np.zeros(3), falls=True)]
    if around is not None:
        expected.append(_gone_round(system, now, around))
    if not np.any(state.a):
        driven, _ = driven_accelerations(system, now, work)
        expected = [a + driven for a in expected]
    equations = equations_at(system, now, work)
    inertia = np.abs(equations.M.diagonal())
    loads = np.abs(equations.f) / mass_metric(equations.M)
    beyond = [_of_material(system, inertia, now.a - a) for a in expected]
    found = {title: min(of[title] for of in beyond) for title in beyond[0]}
    given = _of_material(system, inertia, loads)
    if not found:
        return None
    length = system.lengths.whole
    fastest = max((float(np.linalg.norm(w)) for w in motion.spins.values()), default=0.0)
    title, largest = max(found.items(), key=lambda item: item[1])
    usual = max(*given.values(), fastest**2 * length)
    units = np.where(system.units > 0.0, system.units, 1.0)
    rounded = _of_material(system, inertia, np.abs(stiffness) / units / mass_metric(equations.M))
    noise = ROUNDINGS * system.lengths.digits * max(rounded.values())
    if not largest > max(UNBALANCED * usual, STANDING * length, noise):
        return None
    return (
        f"{title} accelerates with {largest:.3g} m/s2 (root mean square of its material), so this state is no "
        "equilibrium and no steady motion, and what follows holds at this instant only; expected: accelerations of "
        f"less than {UNBALANCED:g} of those that the loads would give free bodies ({usual:.3g} m/s2). Begin at one: "
        "about=fmb.statics(model)"
    )


def _gone_round(system, state, around: np.ndarray, falls: bool = False) -> np.ndarray:
    """Return the accelerations (nu,) of velocities that turn with the observer, V' = O x V in W, or fall besides."""
    a = np.zeros(system.nu)
    hangs = held_by_ground(system.model) if falls else set()
    for body in (body for body in system.model.bodies if body.n_velocities):
        gravity = np.array(system.model.gravity) * (falls and body.name not in hangs)
        iq, iu = system.body_slices[body.name]
        u = state.u[iu]
        if body.has_frame:
            R = np.empty((3, 3))
            euler_to_matrix(state.q[iq][3:7], R)
            w = R @ u[3:6]
            vectors = u[:6].reshape(2, 3) @ R.T
            a[iu][:6] = (np.cross(around - w, vectors) @ R).ravel()
            a[iu][:3] += gravity @ R
        else:
            a[iu] = np.cross(around, u.reshape(-1, 3)).ravel()
            a[iu].reshape(-1, body.block_size)[:, :3] += gravity
    return a


def _of_material(system, inertia: np.ndarray, a: np.ndarray) -> dict[str, float]:
    """Return the root mean square acceleration, m/s2, by the titles of bodies that have mass."""
    found = {}
    for body in system.model.bodies:
        span = system.body_slices[body.name][1]
        own = inertia[span]
        mass = 0.0
        if len(own):
            mass = own[0] if body.has_frame else float(own.reshape(-1, body.block_size)[:, 0].sum())
        if mass > 0.0:
            found[body.title] = float(np.sqrt(own @ a[span] ** 2 / mass))
    return found
