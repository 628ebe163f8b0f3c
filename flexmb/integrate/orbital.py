"""What holds in orbit: which integrator is the default, and coordinates that count from the centre of the Earth."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.alpha.generalized_alpha import GeneralizedAlpha
from flexmb.integrate.explicit.explicit import Explicit
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.weights import weigh, weigh_mass
from flexmb.model.connections import places_of
from flexmb.model.model import Model
from flexmb.system.mobility import constraint_matrix, mass_metric
from flexmb.system.program import evaluate

__all__ = ["ORBITAL", "default_integrator", "far_from_origin", "unless_stiff"]

ORBITAL = Explicit(rtol=1e-11, atol=1e-13, drift=1e-12)
"""Default in orbit: its errors, of order eight, stay below 1e-6 of a spacecraft's length over ten orbits."""
CLOSE, CLOSE_EXPLICIT = 1e-10, 1e-8
"""Tolerances up to which a revolution has small errors: `Implicit` 4e-7 m, `Explicit` 6e-9 m, of a craft of 1.8 m."""
LONG = 1e5
"""Radians of the fastest vibration (or times of the fastest decay) in a run that explicit steps can follow: it takes
them some 0.4 to 0.8 steps each."""
ITERATIONS = 30
"""Of the power iteration for that rate: a few per cent are enough."""
FAR = 1e-4
"""Length of an assembly, relative to its distance from the origin, below which relative motion is worse than asked."""


def default_integrator(model: Model):
    """Return what integrates a model unless told otherwise: `ORBITAL` for rigid bodies and points in orbit.

    `GeneralizedAlpha` is at home with stiffness, damping and contacts; over many revolutions its errors add up.
    """
    in_orbit = any(force.lasting for force in model.forces)
    elastic = any(body.n_velocities > (6 if body.has_frame else 3) for body in model.bodies)
    strikes = any(force.strikes for force in model.forces)
    return ORBITAL if in_orbit and not elastic and not strikes else GeneralizedAlpha()


def unless_stiff(integrator, system, state, span: float):
    """Return the integrator for a run of `span` (s), and what to tell: `GeneralizedAlpha` instead of `ORBITAL` where
    springs or dampers are so stiff that explicit steps would hardly end.
    """
    if integrator is not ORBITAL:
        return integrator, _adding_up(integrator, system, state, span)
    rate, owner = _fastest(system, state)
    if not rate * span > LONG:
        return integrator, []
    return GeneralizedAlpha(), [
        f"Model '{system.model.name}': {owner} is held by springs or dampers of up to {rate:.3g} rad/s, too stiff for "
        f"the explicit steps that are the default in orbit, over {span:.4g} s; GeneralizedAlpha is used, whose errors "
        "add up over many revolutions. Make what hardly moves rigid (Fixed), or give an integrator and its tolerance"
    ]


def _adding_up(integrator, system, state, span: float) -> list[str]:
    """Tell of a run over revolutions of an orbit whose integrator keeps errors small in each step, and no more."""
    model, name = system.model, type(integrator).__name__
    period = _period(system, state)
    rtol = None if getattr(integrator, "step", None) is not None else getattr(integrator, "rtol", None)
    close = CLOSE_EXPLICIT if isinstance(integrator, Explicit) else CLOSE
    if not span >= period or (rtol is not None and rtol <= close):
        return []
    how = "steps of a given size" if rtol is None else f"rtol = {rtol:g}"
    rigid = default_integrator(model) is ORBITAL
    better = "leave the integrator out" if rigid else f"give flexmb.Implicit(rtol={CLOSE:g}, atol=1e-12)"
    return [
        f"Model '{model.name}', {name}: the run covers {span / period:.3g} revolutions of {period:.5g} s, over which "
        f"the errors of its steps add up, at {how}: at rtol = 1e-6 bodies 1.8 m apart were off by 2e-3 m after one "
        f"revolution of a low orbit, and by 0.3 m after ten; expected: rtol of at most {close:g}. For relative places "
        f"with more digits {better}"
    ]


def _period(system, state) -> float:
    """Return the time of a revolution, s; infinite if nothing attracts."""
    model = system.model
    if model.origin is not None:
        return model.origin.period
    found = [np.inf]
    for force in (force for force in model.forces if force.attracts):
        far = float(
            np.linalg.norm(state.q[system.body_slices[force.body][0]][:3] - model.marker(force.source, "")[1].at)
        )
        found.append(2.0 * np.pi * far**1.5 / force.mu**0.5)
    return min(found)


def _fastest(system, state) -> tuple[float, str]:
    """Return the largest rate that stiffness or damping give the system, rad/s, and which body has most of it.

    Power iterations with M^-1 K and M^-1 D, constraints kept.
    """
    work, parts = system.workspace(), []
    for damping, stiffness in ((1.0, 0.0), (0.0, 1.0)):
        weigh(work.weights, 0.0, damping, stiffness)
        evaluate(system.program, state, work)
        parts.append(constraint_matrix(system, work)[0].copy())
    weigh_mass(work.weights)
    evaluate(system.program, state, work)
    size = np.sqrt(mass_metric(constraint_matrix(system, work)[0]))
    if lu_factor(work.S, system.program.pattern) >= 0:
        return 0.0, ""
    fastest, owner = 0.0, ""
    for matrix, power in zip(parts, (1.0, 0.5), strict=True):
        x, growth = np.random.default_rng(0).normal(size=system.nu) / size, 0.0
        for _ in range(ITERATIONS):
            right = np.concatenate([matrix @ x, np.zeros(system.ng)])
            lu_solve(work.S, system.program.pattern, right)
            before, x = np.linalg.norm(size * x), right[: system.nu]
            growth = float(np.linalg.norm(size * x) / before)
            if not (growth > 0.0 and np.isfinite(growth)):
                break
            x /= growth * before
        if np.isfinite(growth) and growth**power > fastest:
            fastest, owner = growth**power, system.owner(int(np.argmax(np.abs(size * x))))
    return fastest, owner


def far_from_origin(system) -> list[str]:
    """Tell of an assembly in orbit whose coordinates count from the centre of attraction."""
    model = system.model
    if model.origin is not None or not any(force.attracts for force in model.forces):
        return []
    attracted = {force.body for force in model.forces if force.attracts}
    tied: set[str] = set()
    for part in (*model.joints, *model.forces):
        ends = {place.partition(".")[0] for place in places_of(part, model)} & attracted
        tied |= ends if len(ends) > 1 else set()
    for k, body in enumerate(model.bodies):
        far, length = system.lengths.coordinates[k], system.lengths.bodies[k]
        if body.name in tied and length < FAR * far:
            place, velocity = (tuple(float(f"{x:.12g}") for x in v) for v in (body.at, body.velocity))
            return [
                f"Model '{model.name}': {body.title} is {far:.3g} m from the centre that attracts it, and its "
                f"assembly {length:.3g} m long: errors of steps are kept relative to the orbit, and rounding is "
                f"{1e-16 * far:.1g} m, so that relative motion has few digits. Let the origin follow the orbit: "
                f"Model(origin=flexmb.Orbit({place}, {velocity})), and give places and velocities relative to it"
            ]
    return []
