"""What holds in orbit: which integrator is the default, and coordinates that count from the centre of the Earth."""

from __future__ import annotations

from flexmb.integrate.alpha.generalized_alpha import GeneralizedAlpha
from flexmb.integrate.explicit.explicit import Explicit
from flexmb.integrate.oversights import places_of
from flexmb.model.model import Model

__all__ = ["ORBITAL", "default_integrator", "far_from_origin"]

ORBITAL = Explicit(rtol=1e-11, atol=1e-13, drift=1e-12)
"""Default in orbit: its errors, of order eight, stay below 1e-6 of a spacecraft's length over ten orbits."""
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
