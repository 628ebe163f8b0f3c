"""Changes of a mechanism itself that must not change its motion: split bodies, joints twice, far bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from metamorphic.analyses import END, INTEGRATORS, SAMPLES, SLOW
from metamorphic.seen import PLAIN, turn

import flexmb as fmb

Results = dict[str, np.ndarray]
FAR = 1000.0
"""m: distance of a body that has nothing to do with the others."""


def run(model: fmb.Model, how: str) -> fmb.Solution:
    """Return the motion of a mechanism."""
    return fmb.simulate(model, END, samples=SAMPLES, integrator=INTEGRATORS[how](PLAIN))


def results(solution: fmb.Solution, model: fmb.Model) -> Results:
    """Return what the sensors of the first model read; energies of the whole are not compared."""
    return {s.name: solution[s.name] for s in model.sensors if type(s).__name__ != "Energy"}


def with_marker(model: fmb.Model, rng) -> fmb.Model:
    """A marker and a sensor on it."""
    rigid = [b for b in model.bodies if isinstance(b, fmb.RigidBody)]
    if not rigid:
        return model
    body = rigid[int(rng.integers(len(rigid)))]
    marked = body.replaced(markers={**body.markers, "seen": fmb.Pose(tuple(rng.normal(size=3)), turn(rng))})
    bodies = tuple(marked if b.name == body.name else b for b in model.bodies)
    sensor = fmb.Acceleration("more", marker=f"{body.name}.seen")
    return replace(model, bodies=bodies, sensors=(*model.sensors, sensor))


def with_far_body(model: fmb.Model, rng) -> fmb.Model:
    """A body that falls somewhere else."""
    at = FAR * rng.normal(size=3)
    body = fmb.RigidBody("far", mass=2.0, inertia=(1.0, 1.0, 1.0), at=tuple(at))
    return replace(model, bodies=(*model.bodies, body))


def split(model: fmb.Model, rng) -> fmb.Model:
    """Every rigid body in two, joined by Fixed: a ball of a fifth of its mass inside, and the rest.

    What pulls at a body by its mass pulls at both.
    """
    bodies, joints, forces = [], list(model.joints), list(model.forces)
    for body in model.bodies:
        if not isinstance(body, fmb.RigidBody):
            bodies.append(body)
            continue
        share, d = 0.2, rng.normal(size=3) * 0.01
        m, c, J = body.mass, np.asarray(body.center_of_mass), np.asarray(body.inertia, float)
        J = np.diag(J) if J.ndim == 1 else J
        inner, outer = share * m, (1.0 - share) * m
        c_in = c + d
        c_out = (m * c - inner * c_in) / outer
        rest = J - share * J - inner * _parallel(c_in - c) - outer * _parallel(c_out - c)
        hole = fmb.Pose(tuple(c), turn(rng))
        bodies.append(
            body.replaced(mass=outer, center_of_mass=tuple(c_out), inertia=rest, markers={**body.markers, "hole": hole})
        )
        bodies.append(
            fmb.RigidBody(
                f"{body.name}_inner",
                mass=inner,
                center_of_mass=tuple(c_in),
                inertia=share * J,
                at=body.at,
                rotation=body.rotation,
                markers={"hole": hole},
            )
        )
        pulls = [f for f in model.forces if isinstance(f, fmb.CentralGravity) and f.body == body.name]
        forces += [replace(f, name=f"{f.name}_inner", body=f"{body.name}_inner") for f in pulls]
        joints.append(fmb.Fixed(f"{body.name}_glue", markers=(f"{body.name}.hole", f"{body.name}_inner.hole")))
    return replace(model, bodies=tuple(bodies), joints=tuple(joints), forces=tuple(forces))


def _parallel(d: np.ndarray) -> np.ndarray:
    return d @ d * np.eye(3) - np.outer(d, d)


def with_redundant_joint(model: fmb.Model, rng) -> fmb.Model:
    """A joint twice."""
    joints = [j for j in model.joints if type(j).__name__ in ("Spherical", "Revolute", "Fixed", "Universal", "Planar")]
    twice = joints[int(rng.integers(len(joints)))] if joints else None
    if twice is None:
        return model
    return replace(model, joints=(*model.joints, replace(twice, name="again")))


def whole_reactions(solution: fmb.Solution, model: fmb.Model) -> Results:
    """Return the results, reactions of a joint that is there twice as their sum."""
    found = results(solution, model)
    again = [j for j in solution.model.joints if j.name == "again"]
    for joint in again:
        first = next(j for j in model.joints if j.markers == joint.markers)
        if f"{first.name} reaction" in found:
            found[f"{first.name} reaction"] += solution[fmb.Reaction("r", joint="again")]
    return found


RELATIONS: dict[str, Callable] = {
    "marker": with_marker,
    "far body": with_far_body,
    "split": split,
    "redundant joint": with_redundant_joint,
}


def differs(model: fmb.Model, changed: fmb.Model, how: str) -> tuple[float, str]:
    """Return the largest difference of two motions, relative to the largest value of its kind, and its name."""
    one, other = results(run(model, how), model), whole_reactions(run(changed, how), model)
    return apart(one, other)


def apart(one: Results, other: Results) -> tuple[float, str]:
    """Return the largest difference of results, relative to the largest value of their kind, and its name."""
    worst, where = 0.0, "none"
    scales: dict[str, float] = {}
    for name, values in one.items():
        kind = name.rpartition(" ")[2]
        scales[kind] = max(scales.get(kind, 0.0), float(np.abs(values).max(initial=0.0)))
    scales["speed"] = max(scales.get("speed", 0.0), SLOW)
    for name, values in one.items():
        scale = scales[name.rpartition(" ")[2]]
        share = float(np.abs(values - other[name]).max(initial=0.0)) / scale if scale > 0.0 else 0.0
        if not share <= worst:
            worst, where = share, name
    return worst, where
