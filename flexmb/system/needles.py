"""Needles: bodies whose mass and moments of inertia do not go together, as lumped masses and flywheels have them.

Dependence is geometry, but lengths and angles are compared in the metric of the masses. In that of a lumped mass of
1 kg with 1e-12 kg m2, on an arm of 1 m, a turn is all that moves, and in that of a flywheel of 1e-12 kg with 1 kg m2 a
shift: joints in different places then look alike.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from flexmb.told import tell

__all__ = ["least_inertia", "longest_arms", "warn_of_needles", "without_needles"]

SLENDER = 1e-3
"""Least radius of gyration in the metric, relative to the length of the assembly and to the body's greatest; also the
assembly's least length relative to that radius."""
BLUNT = 1e-2
"""Least radius of gyration, relative to the arms of joints, with which equations that close loops are judged."""
FEATHER = 1e-5
"""Least mass of a body, relative to the heaviest that joints join with it, with which they are judged; its moments of
inertia grow with it."""
DIGITS = 1e-13
"""A moment of inertia below this, relative to the mass times the square of an arm, has hardly a digit beside it."""
ROUNDING = 1e-14
"""A moment of inertia about an oblique axis below this, relative to the body's greatest, is zero but for rounding."""


def without_needles(metric: np.ndarray, frames: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the metric (nu,) with the masses and moments of inertia raised that are too small beside the others.

    Parameters
    ----------
    metric : (nu,), kg and kg m2
    frames : (nf,) of int
        First of the six velocities of each frame.
    lengths : (nf,), m
        Of the assembly to which each frame belongs.
    """
    metric = metric.copy()
    shifts, turns = frames[:, None] + np.arange(3), frames[:, None] + np.arange(3, 6)
    mass, inertia = np.max(metric[shifts], axis=1, initial=0.0), np.max(metric[turns], axis=1, initial=0.0)
    scale = lengths**2
    metric[shifts] = np.maximum(metric[shifts], (SLENDER**2 * inertia / scale)[:, None])
    metric[turns] = np.maximum(metric[turns], (SLENDER**2 * np.maximum(inertia, mass * scale))[:, None])
    return metric


def least_inertia(system) -> np.ndarray:
    """Return the least masses and moments of inertia (nu,), kg and kg m2, with which the dependence of equations is
    judged; 0 of velocities of no frame.

    What closes a loop is condensed to multipliers by the inverse inertias of the bodies. Where a lumped mass turns with
    1e-8 of its mass times arm squared, or a dummy part has 1e-8 of the others' mass, that is 1e8 in one direction, and
    all other equations look dependent beside it.
    """
    found, slices = np.zeros(system.nu), system.slices
    arms = longest_arms(system.model)
    inertias = {name: system.model.body(name).rest_inertia() for name in arms}
    heaviest = _heaviest(system.model, {name: mass for name, (mass, _, _) in inertias.items()})
    for name, (mass, _, moments) in inertias.items():
        least = max(mass, FEATHER * heaviest[name])
        grown = np.diag(moments) * (least / mass if mass > 0.0 else 1.0)
        first = slices[name][1].start
        found[first : first + 3] = least
        found[first + 3 : first + 6] = np.maximum(grown, least * (BLUNT * arms[name]) ** 2)
    return found


def _heaviest(model, masses: dict[str, float]) -> dict[str, float]:
    """Return the largest mass among the bodies that joints join with each of them, other than by the ground, kg."""
    if min(masses.values(), default=0.0) >= FEATHER * max(masses.values(), default=0.0):  # no group has a lighter one
        return masses
    number = {name: k for k, name in enumerate(masses)}
    pairs = [
        [number[p.partition(".")[0]] for p in j.resolved_markers(model) if p.partition(".")[0] in number]
        for j in model.joints
    ]
    ends = np.array([(one[0], other) for one in pairs if one for other in one[1:]], int).reshape(-1, 2).T
    joined = sparse.csr_matrix((np.ones(ends.shape[1]), (ends[0], ends[1])), shape=(len(number), len(number)))
    _, group = connected_components(joined, directed=False)
    largest = np.zeros(len(number))
    np.maximum.at(largest, group, list(masses.values()))
    return dict(zip(masses, largest[group].tolist(), strict=True))


def longest_arms(model) -> dict[str, float]:
    """Return how far from its origin the farthest joint holds each body with a frame, m, by its name."""
    bodies = {body.name: body for body in model.bodies if body.has_frame and body.n_velocities}
    poses = {name: body.marker_poses() for name, body in bodies.items()}
    arms = dict.fromkeys(bodies, 0.0)
    for joint in model.joints:
        for path in joint.resolved_markers(model):
            name, _, marker = path.partition(".")
            if name in bodies:
                arms[name] = max(arms[name], float(np.linalg.norm(poses[name][marker].at)))
    return arms


def warn_of_needles(system, least: np.ndarray) -> None:
    """Warn of bodies with a moment of inertia that is lost in the digits beside mass times arm squared.

    least : (nu,), as `least_inertia` found them
    """
    slices, near = system.slices, {}
    for body in system.model.bodies:
        if not (body.has_frame and body.n_velocities) or body.n_vector:
            continue
        first = slices[body.name][1].start
        moments = body.rest_inertia()[2]
        diagonal = moments.diagonal()
        smallest = diagonal.min() if np.array_equal(moments, np.diag(diagonal)) else np.linalg.eigvalsh(moments)[0]
        if smallest < DIGITS / BLUNT**2 * least[first + 3 : first + 6].max():
            near[body.name] = body
    for joint in system.model.joints if near else ():
        for path in joint.resolved_markers(system.model):
            name, _, marker = path.partition(".")
            if name in near and _warned_of(near[name], marker, joint):
                del near[name]


def _warned_of(body, marker: str, joint) -> bool:
    """Warn of a body if an axis has a moment of inertia without digits beside the arm of a joint; return if so."""
    mass, _, inertia = body.rest_inertia()
    moments, axes = np.linalg.eigh(inertia)
    known = moments > (ROUNDING * moments[-1] if np.any(inertia - np.diag(inertia.diagonal())) else 0.0)
    beside = mass * np.sum(np.cross(axes.T, body.marker_poses()[marker].at) ** 2, axis=1)
    lost = known & (moments < DIGITS * beside)
    if np.any(lost):
        k = int(np.argmax(lost * beside))
        tell(
            f"{body.title} has a moment of inertia of {moments[k]:.3g} kg m2 beside {beside[k]:.3g} kg m2, its mass "
            f"times the square of the arm of joint '{joint.name}': no digit of their sum knows of it, and reactions "
            f"can be wrong; expected: more than {DIGITS:g} of that. Write 0 for the inertia of a lumped mass that "
            "joints hold, or use a PointMass"
        )
    return bool(np.any(lost))
