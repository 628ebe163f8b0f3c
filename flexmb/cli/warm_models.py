"""Small models whose analyses need every kernel that is compiled when it is first called."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.cli import warm_parts

__all__ = ["ANALYSES"]


def swing() -> fmb.Model:
    """Return a driven crank with a rocker, a spring and all kinds of sensors that kernels recover."""
    link = {"inertia": (1e-3, 1e-2, 1e-2)}
    return fmb.Model(
        gravity=(1.0, 0, 9.81),  # it hangs, and swings to the side
        bodies=[
            fmb.Ground(markers={"A": _hinge(0, 0), "D": _hinge(1, 0)}),
            fmb.RigidBody("crank", mass=1.0, markers={"A": _hinge(0, 0), "B": _hinge(0, 0.4)}, **link),
            fmb.RigidBody("coupler", mass=1.0, at=(0, 0, 0.4), markers={"B": _hinge(0, 0), "C": _hinge(1, 0)}, **link),
            fmb.RigidBody("rocker", mass=1.0, at=(1, 0, 0), markers={"D": _hinge(0, 0), "C": _hinge(0, 0.4)}, **link),
        ],
        joints=[
            fmb.Revolute("A", markers=("ground.A", "crank.A")),
            fmb.Revolute("B", markers=("crank.B", "coupler.B")),
            fmb.Spherical("C", markers=("coupler.C", "rocker.C")),
            fmb.Revolute("D", markers=("ground.D", "rocker.D")),
        ],
        forces=[fmb.SpringDamper("spring", markers=("ground.D", "coupler.B"), stiffness=10.0, damping=0.1)],
        sensors=[fmb.Position("place", marker="coupler.C"), fmb.Reaction("force", joint="A"), fmb.Energy("energy")],
    )


def _hinge(x: float, z: float) -> fmb.Pose:
    return fmb.Pose.axes((x, 0, z), z=(0, 1, 0), x=(1, 0, 0))


def arm(data: fmb.ModalNeutralData | None = None) -> fmb.Model:
    """Return two arms, one on the other, both rigid or of reduced data."""
    places = {"start": _hinge(0, 0), "end": _hinge(1, 0)}
    rigid = fmb.RigidBody("one", mass=1.0, inertia=(1e-3, 1e-2, 1e-2), markers=places)
    bodies = [rigid, fmb.RigidBody("two", mass=1.0, inertia=(1e-3, 1e-2, 1e-2), at=(1, 0, 0), markers=places)]
    if data is not None:
        bodies[1] = fmb.FloatingBody("two", data=data, at=(1, 0, 0))
    between = fmb.Revolute if data is None else fmb.Spherical  # markers of data have the axes of their body
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"O": _hinge(0, 0)}), *bodies],
        joints=[
            fmb.Revolute("O", markers=("ground.O", "one.start")),
            between("P", markers=("one.end", "two.start")),
        ],
    )


def beam() -> fmb.ModalNeutralData:
    """Return a reduced frame."""
    points = np.column_stack([np.linspace(0.0, 1.0, 5), np.zeros(5), np.zeros(5)])
    section = fem.Section.rectangle(0.02, 0.03)
    fe = fem.frame(points=points, section=section, material=fmb.MATERIALS["steel"])
    return reduction.reduce(fe, interfaces={"start": [0], "end": [4]}, modes=3, geometric_stiffness=True)


def simulated(integrator, model: Callable[[], fmb.Model] = swing) -> Callable[[], object]:
    """Return the call of a short simulation."""
    return lambda: fmb.simulate(model(), 0.01, samples=3, integrator=integrator())


def _accelerations() -> None:
    for formulation in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri()):
        fmb.accelerations(swing(), formulation=formulation)
    fmb.accelerations(arm(), formulation=fmb.Recursive())


ANALYSES: Mapping[str, Callable[[], object]] = {
    "generalized alpha": simulated(lambda: fmb.GeneralizedAlpha()),
    "joint coordinates": simulated(lambda: fmb.Explicit(formulation=fmb.Recursive())),
    "IDA": simulated(lambda: fmb.IDA()),
    "implicit": simulated(lambda: fmb.Implicit()),
    "explicit": simulated(lambda: fmb.Explicit()),
    "flexible arm": simulated(lambda: fmb.Explicit(formulation=fmb.Recursive()), lambda: arm(beam())),
    "statics": lambda: fmb.statics(arm()),
    "linearize": lambda: fmb.linearize(swing(), fmb.statics(swing())),
    "check": lambda: fmb.check(swing()),
    "accelerations": _accelerations,
    "meshed part": warm_parts.meshed,
    "rigid contact": warm_parts.touching,
    "contact of skins": warm_parts.skins,
    "sampled signal": warm_parts.sampled,
    "kinematics": warm_parts.driven,
    "joint torques": warm_parts.torques,
    "orbit": warm_parts.orbit,
}
"""What is done to have its kernels compiled."""
