"""Mechanisms of many kinds, for what integrators tell of the errors of their steps.

Each entry is (model, time / s): rigid and elastic, driven and free, stiff, damped and sensitive ones.
"""

from __future__ import annotations

import runpy
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from verification.mechanisms import four_bars
from verification.test_very_large_and_small import top

import flexmb as fmb
from flexmb import fem, reduction

EXAMPLES = Path(__file__).parents[2] / "examples"
Y = fmb.Pose.axes((0, 0, 0), x=(1, 0, 0), z=(0, 1, 0))
"""Axes of a hinge about y."""
G = (0.0, 0.0, -9.81)
STEEL = fmb.MATERIALS["steel"]


def hinge(at=(0.0, 0.0, 0.0)) -> fmb.Pose:
    """Return a pose at a place whose z-axis is the y-axis of the body."""
    return fmb.Pose(tuple(at), Y.rotation)


def spring(k=100.0, c=0.0, x0=0.2, v0=0.0) -> fmb.Model:
    """1 kg on a spring of 1 m along x."""
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("p", mass=1.0, at=(1.0 + x0, 0, 0), velocity=(v0, 0, 0))],
        forces=[fmb.SpringDamper("k", markers=("ground.origin", "p.center"), stiffness=k, damping=c, length=1.0)],
    )


def chain(n: int, drive=None, masses=()) -> fmb.Model:
    """n rods of 0.5 m on hinges about y, from the horizontal; the first may be driven."""
    joints, bodies, before = [], [fmb.Ground(markers={"pin": hinge()})], "ground.pin"
    for k in range(n):
        mass = masses[k] if masses else 1.0
        rod = fmb.RigidBody.rod(f"r{k}", length=0.5, mass=mass, radius=0.02, at=(0.5 * k, 0, 0))
        ends = {"a": hinge(rod.marker_poses()["start"].at), "b": hinge(rod.marker_poses()["end"].at)}
        bodies.append(replace(rod, markers={**rod.markers, **ends}))
        joints.append(fmb.Revolute(f"j{k}", markers=(before, f"r{k}.a")))
        before = f"r{k}.b"
    if drive is not None:
        joints.append(fmb.Drive("motor", joint="j0", angle=drive))
    return fmb.Model(gravity=G, bodies=bodies, joints=joints)


@cache
def reduced_bar(modes=6, length=0.4, side=0.01):
    """A bar of steel along x between its ends."""
    fe = fem.frame(np.linspace([0, 0, 0], [length, 0, 0], 9), section=fem.Section.rectangle(side, side), material=STEEL)
    return reduction.reduce(fe, {"root": "start", "tip": "end"}, modes, geometric_stiffness=True, stress=False)


def bar_pendulum(damping=0.0) -> fmb.Model:
    """A reduced bar falls from the horizontal on a ball joint."""
    return fmb.Model(
        gravity=G,
        bodies=[fmb.Ground(), fmb.FloatingBody("bar", data=reduced_bar(), damping=damping)],
        joints=[fmb.Spherical("ball", markers=("ground.origin", "bar.root"))],
    )


def bar_body_bar(damping=0.0) -> fmb.Model:
    """A bar on a ball joint, a cube on it, and another bar on the cube."""
    cube = fmb.RigidBody(
        "cube", mass=0.5, inertia=1e-4 * np.ones(3), at=(0.41, 0, 0), markers={"l": (-0.01, 0, 0), "r": (0.01, 0, 0)}
    )
    first = fmb.FloatingBody("bar", data=reduced_bar(), damping=damping)
    return fmb.Model(
        gravity=G,
        bodies=[fmb.Ground(), first, cube, replace(first, name="other", at=(0.42, 0, 0))],
        joints=[
            fmb.Spherical("ball", markers=("ground.origin", "bar.root")),
            fmb.Fixed("weld", markers=("bar.tip", "cube.l")),
            fmb.Fixed("weld2", markers=("cube.r", "other.root")),
        ],
    )


def bars_on_balls(body: bool) -> fmb.Model:
    """Two undamped bars in a row on ball joints, with a cube between them or without."""
    first = fmb.FloatingBody("bar", data=reduced_bar(), damping=0.0)
    model = fmb.Model(
        gravity=G,
        bodies=[fmb.Ground(), first, replace(first, name="other", at=(0.4, 0, 0))],
        joints=[
            fmb.Spherical("ball", markers=("ground.origin", "bar.root")),
            fmb.Spherical("ball2", markers=("bar.tip", "other.root")),
        ],
    )
    if not body:
        return model
    cube = bar_body_bar().body("cube")
    return replace(
        model,
        bodies=[fmb.Ground(), first, cube, replace(first, name="other", at=(0.42, 0, 0))],
        joints=[
            model.joints[0],
            fmb.Spherical("ball2", markers=("bar.tip", "cube.l")),
            fmb.Spherical("ball3", markers=("cube.r", "other.root")),
        ],
    )


def cantilever(load, damping=0.0) -> fmb.Model:
    """A clamped reduced bar with a load on its end."""
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("bar", data=reduced_bar(), damping=damping)],
        joints=[fmb.Fixed("clamp", markers=("ground.origin", "bar.root"))],
        forces=[fmb.PointLoad("load", marker="bar.tip", force=load)],
    )


def bushed_pendulum() -> fmb.Model:
    """A rod that falls on a stiff damped bushing."""
    rod = fmb.RigidBody.rod("rod", length=1.0, mass=1.0, radius=0.02)
    bushing = fmb.Bushing(
        "b",
        markers=("ground.origin", "rod.start"),
        stiffness=(1e7, 1e7, 1e7, 0, 0, 0),
        damping=(1e3, 1e3, 1e3, 0, 0, 0),
    )
    return fmb.Model(gravity=G, bodies=[fmb.Ground(), rod], forces=[bushing])


def cable(damping=0.0) -> fmb.Model:
    """A soft rope of 1 m falls from the horizontal."""
    rope = fmb.AncfCable(
        "rope",
        points=[(0, 0, 0), (1, 0, 0)],
        elements=6,
        section=fem.Section.solid_circle(0.02),
        material=fmb.Material(young=1e7, poisson=0.3, density=1000.0),
        axial_damping=damping,
        markers={"a": 0.0},
    )
    return fmb.Model(
        gravity=G,
        bodies=[fmb.Ground(), rope],
        joints=[fmb.Spherical("ball", markers=("ground.origin", "rope.a"))],
    )


def free_body(spin) -> fmb.Model:
    """A body of three different moments of inertia flies and turns."""
    return fmb.Model(
        bodies=[
            fmb.RigidBody("b", mass=2.0, inertia=(0.1, 0.15, 0.2), angular_velocity=spin, velocity=(1, 2, 3)),
        ]
    )


def forced(stiffness, damping, force) -> fmb.Model:
    """1 kg in a bushing along x under a force of time."""
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("p", mass=1.0, at=(0, 0, 0))],
        forces=[
            fmb.Bushing(
                "k",
                markers=("ground.origin", "p.center"),
                stiffness=(stiffness, 0, 0, 0, 0, 0),
                damping=(damping, 0, 0, 0, 0, 0),
            ),
            fmb.PointLoad("f", marker="p.center", force=(fmb.expression(force), 0, 0)),
        ],
    )


def toggle() -> fmb.Model:
    """Two springs in a flat roof of 2 m by 0.1 m snap through under a weight that grows."""
    mass = fmb.PointMass("p", mass=1.0, at=(0, 0, 0.1))
    ground = fmb.Ground(markers={"l": (-1, 0, 0), "r": (1, 0, 0)})
    length = float(np.hypot(1.0, 0.1))
    return fmb.Model(
        bodies=[ground, mass],
        forces=[
            *(
                fmb.SpringDamper(s, markers=(f"ground.{s}", "p.center"), stiffness=2e3, damping=2.0, length=length)
                for s in ("l", "r")
            ),
            fmb.PointLoad("load", marker="p.center", force=(0, 0, fmb.expression("-4*t"))),
        ],
    )


def pair() -> fmb.Model:
    """Two masses on a spring tumble about each other."""
    return fmb.Model(
        bodies=[
            fmb.PointMass("a", mass=1.0, at=(0, 0, 0), velocity=(0, -1, 0)),
            fmb.PointMass("b", mass=3.0, at=(1, 0, 0), velocity=(0, 1, 0.3)),
        ],
        forces=[fmb.SpringDamper("k", markers=("a.center", "b.center"), stiffness=50.0, length=0.8)],
    )


def slider_crank(speed=20.0) -> fmb.Model:
    """A driven crank of 0.15 m, a rod of 0.3 m and a slider on a spring."""
    crank = fmb.RigidBody.rod("crank", length=0.15, mass=0.2, radius=0.01)
    rod = fmb.RigidBody.rod("rod", length=0.3, mass=0.15, radius=0.01, at=(0.15, 0, 0))
    slider = fmb.RigidBody("slider", mass=0.1, inertia=1e-4 * np.ones(3), at=(0.45, 0, 0))
    along = fmb.Pose.axes((0, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"pin": (0, 0, 0), "rail": along}),
            crank,
            rod,
            replace(slider, markers={"pin": (0, 0, 0), "rail": along}),
        ],
        joints=[
            fmb.Revolute("main", markers=("ground.pin", "crank.start")),
            fmb.Drive("motor", joint="main", angle=fmb.expression(f"{speed}*t")),
            fmb.Revolute("big", markers=("crank.end", "rod.start")),
            fmb.Spherical("small", markers=("rod.end", "slider.pin")),
            fmb.Prismatic("rail", markers=("ground.rail", "slider.rail")),
        ],
        forces=[fmb.SpringDamper("k", markers=("ground.origin", "slider.pin"), stiffness=1e3, damping=1.0, length=0.3)],
    )


def rubbing() -> fmb.Model:
    """A rod that swings on a hinge with friction."""
    model = chain(1)
    return replace(
        model,
        forces=[fmb.JointFriction("f", joint="j0", standing=0.1, moving=0.08, radius=0.05, transition=0.01)],
    )


def snapping_strip() -> fmb.Model:
    """An arched strip of spring steel that snaps to its other side under a push on its crown."""
    return runpy.run_path(str(EXAMPLES / "snapping_strip.py"))["model"]("-4*t")


def spinner() -> tuple[fmb.Model, float]:
    """A fast top of 5 cm, three turns of its spin."""
    model, _ = top(50e-3)
    return model, 3 * 2 * np.pi / float(np.linalg.norm(model.body("top").angular_velocity))


TILT = (300.0, 0.0, 100.0)
CASES = {
    "oscillator, 32 periods": (spring(), 20.0),
    "oscillator, lightly damped": (spring(c=0.2), 20.0),
    "overdamped spring": (spring(1e4, 1e3), 5.0),
    "stiff damped spring, thrown": (spring(1e6, 1e3, 0.0, 1.0), 0.02),
    "pendulum": (chain(1), 10.0),
    "double pendulum": (chain(2), 3.0),
    "driven double pendulum": (chain(2, drive=fmb.expression("sin(5*t)")), 5.0),
    "driven triple pendulum": (chain(3, drive=fmb.expression("0.5*sin(3*t)")), 3.0),
    "chain of eight": (chain(8), 1.5),
    "heavy and light rods": (chain(3, masses=(1e-3, 1.0, 10.0)), 2.0),
    "four-bar": (four_bars(1), 5.0),
    "slider-crank": (slider_crank(), 2.0),
    "free body, slow": (free_body((1.0, 0.1, 0.1)), 20.0),
    "free body, tumbling": (free_body((0.01, 5.0, 0.01)), 10.0),
    "fast top": spinner(),
    "bar on a ball joint": (bar_pendulum(), 0.5),
    "bar on a ball joint, damped": (bar_pendulum(0.02), 0.5),
    "bar, body, bar": (bar_body_bar(), 0.5),
    "bar, body, bar, damped": (bar_body_bar(0.02), 0.5),
    "two bars on balls": (bars_on_balls(False), 0.5),
    "bar, body, bar on balls": (bars_on_balls(True), 0.5),
    "cantilever, ringing across": (cantilever((0, 0, fmb.step(10.0, at=0.01, rise=0.01))), 0.3),
    "cantilever, along": (cantilever((fmb.step(1e4, at=0.01, rise=0.002), 0, 1.0)), 0.1),
    "cantilever, damped": (cantilever((0, 0, fmb.step(10.0, at=0.01, rise=0.01)), 0.05), 0.3),
    "rod on a stiff bushing": (bushed_pendulum(), 3.0),
    "rope": (cable(), 1.0),
    "rope, damped": (cable(10.0), 1.0),
    "resonance": (forced(100.0, 0.5, "10*cos(10*t)"), 20.0),
    "creeping damper": (forced(0.0, 1e4, "100*sin(t)"), 10.0),
    "snapping roof": (toggle(), 3.0),
    "tumbling pair": (pair(), 20.0),
    "hinge with friction": (rubbing(), 5.0),
    "snapping strip": (snapping_strip(), 0.6),
}
"""By name, (model, time / s)."""
