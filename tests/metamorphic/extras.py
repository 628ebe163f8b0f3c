"""What can be added to a random mechanism: contacts, friction, stops, equations of the user, central gravity.

Drawn from numbers of their own, so that the mechanism of a seed is the same with and without them.
"""

from __future__ import annotations

import numpy as np

import flexmb as fmb

__all__ = ["KINDS_AND_PLATES", "add_extras", "plate"]

KINDS_AND_PLATES = ("rigid", "rigid", "rigid", "point", "reduced", "cable", "beam", "plate")
DOWN = np.array([1.0, -2.0, -9.0]) / np.linalg.norm([1.0, -2.0, -9.0])
"""Direction of gravity in the mechanisms."""
TURNING = ("Revolute", "Cylindrical", "Planar")
BALL, OTHER = 0.02, 0.05
"""m: radii of the ball on a body, and of the one that stands still."""


def plate(builder, name: str, at, A) -> np.ndarray:
    """Add a plate that begins with a corner at a place; return where its opposite corner is."""
    s = builder.seen
    corners = np.array([[(0.0, 0.0, 0.0), (0.0, 0.2, 0.01)], [(0.4, 0.0, 0.02), (0.4, 0.2, 0.0)]])
    builder.bodies.append(
        fmb.AncfPlate(
            s.name(name),
            points=[[tuple(s.within(p)) for p in row] for row in corners],
            elements=(2, 1),
            thickness=0.03 * s.length,
            material=fmb.Material(young=2e6 * s.force / s.length**2, poisson=0.3, density=900.0 * s.mass / s.length**3),
            damping=1e-3 * s.time,
            at=tuple(s.point(at)),
            rotation=s.rotation(A),
            markers={"start": (0.0, 0.0), "end": (1.0, 1.0)},
        )
    )
    return at + A @ corners[1, 1]


def add_extras(builder, seed: int) -> None:
    """Add some of them to a mechanism, where they fit."""
    rng = np.random.default_rng([seed, 77])
    for add in rng.permutation([_on_a_ball, _on_a_plane, _friction, _stop, _equation, _attraction])[:4]:
        add(builder, rng)


def _tip(builder, rng) -> tuple[str, np.ndarray]:
    """Return the end of a body: its marker, and its place in W, m."""
    parent, place = builder.tips[int(rng.integers(len(builder.tips)))]
    body, _, end = parent.rpartition(" ")[2].partition(".")
    return f"{builder.seen.name(body)}.{end}", place


def _touching(builder, rng, name: str, place, axes, **shape) -> None:
    s = builder.seen
    marker, tip = _tip(builder, rng)
    gap = rng.uniform(0.001, 0.01)
    own = builder.ground_marker(name, tip + (gap + place) * DOWN, axes)
    builder.forces.append(
        fmb.Contact(
            s.name(name),
            markers=(own, marker),
            radius=BALL * s.length,
            stiffness=2e3 * s.force / s.length**1.5,
            damping=0.5 * s.time / s.length,
            friction=0.2,
            transition=0.05 * s.length / s.time,
            **shape,
        )
    )
    builder.sensors.append(fmb.ForceOf(s.name(f"{name} force"), force=s.name(name)))


def _on_a_ball(builder, rng) -> None:
    _touching(builder, rng, "ball", BALL + OTHER, np.eye(3), against="sphere", other_radius=OTHER * builder.seen.length)


def _on_a_plane(builder, rng) -> None:
    x = np.cross(DOWN, [0.0, 1.0, 0.0])
    x /= np.linalg.norm(x)
    axes = np.column_stack([x, np.cross(-DOWN, x), -DOWN])
    if builder.seen.mirror:  # reflected axes have a z-axis that points to the other side, but the body stays above
        axes = axes @ np.diag([1.0, -1.0, -1.0])
    _touching(builder, rng, "plane", BALL, axes)


def _of_kind(builder, rng, *kinds: str):
    joints = [j for j in builder.joints if type(j).__name__ in kinds]
    driven = {j.joint for j in builder.joints if isinstance(j, fmb.Drive)}
    joints = [j for j in joints if j.name not in driven]
    return joints[int(rng.integers(len(joints)))] if joints else None


def _friction(builder, rng) -> None:
    s, joint = builder.seen, _of_kind(builder, rng, *TURNING)
    if joint is None:
        return
    builder.forces.append(
        fmb.JointFriction(
            s.name("friction"),
            joint=joint.name,
            freedom="turn",
            moving=0.2,
            standing=0.3,
            radius=0.02 * s.length,
            stribeck=0.5 / s.time,
            transition=0.1 / s.time,
            preload=1.0 * s.force,
        )
    )


def _stop(builder, rng) -> None:
    s, joint = builder.seen, _of_kind(builder, rng, *TURNING)
    if joint is None:
        return
    builder.forces.append(
        fmb.BiStop(
            s.name("stop"),
            joint=joint.name,
            freedom="turn",
            travel=(-0.02, 0.02),
            stiffness=50.0 * s.energy,
            damping=0.05 * s.energy * s.time,
            depth=1e-3,
        )
    )


def _equation(builder, rng) -> None:
    """Let the distance of a tip from a place vary as it is told, on a chain that can follow."""
    s = builder.seen
    free = [j for j in builder.joints if type(j).__name__ in ("Spherical", "Rod")]
    if len(free) != len(builder.joints):
        return
    marker, tip = _tip(builder, rng)
    place = tip + rng.normal(size=3) * 0.2
    far = builder.ground_marker("away", place, np.eye(3))
    builder.joints.append(
        fmb.Constraint(
            s.name("tether"),
            over=[fmb.Distance("d", markers=(far, marker))],
            equation="d**2 = L**2",
            parameters={"L": builder.signal(float(np.linalg.norm(place - tip)), 0.0, 1.0, s.length)},
        )
    )


def _attraction(builder, rng) -> None:
    s = builder.seen
    heavy = [b for b in builder.bodies if isinstance(b, fmb.RigidBody | fmb.PointMass)]
    if not heavy:
        return
    centre = builder.ground_marker("sun", rng.normal(size=3) * 3.0, np.eye(3))
    builder.forces.append(
        fmb.CentralGravity(s.name("sun pull"), body=heavy[0].name, mu=20.0 * s.length**3 / s.time**2, source=centre)
    )
