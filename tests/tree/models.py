"""Trees and loops of rigid and flexible bodies, at random consistent states."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from contracts.random_models import beam, moved, put_together, units

import flexmb as fmb
from flexmb.system import assemble


def chain(n: int, joint=fmb.Revolute, **fields) -> fmb.Model:
    """Return n slender rods of 1 m and 1 kg along x, each hung on the end of the one before."""
    rods = [fmb.RigidBody.rod(f"b{k}", length=1.0, mass=1.0, radius=0.05, at=(k, 0, 0)) for k in range(n)]
    ends = ["ground.origin"] + [f"b{k}.end" for k in range(n)]
    joints = [joint(f"j{k}", markers=(ends[k], f"b{k}.start")) for k in range(n)]
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[fmb.Ground(), *rods], joints=joints, **fields)


def flexible_chain(n: int, **fields) -> fmb.Model:
    """Return n reduced beams, each hung on the tip of the one before, on alternating joints."""
    bodies = [fmb.FloatingBody(f"f{k}", data=beam(), at=(k, 0, 0), damping=0.01, **fields) for k in range(n)]
    ends = ["ground.origin"] + [f"f{k}.tip" for k in range(n)]
    kinds = (fmb.Revolute, fmb.Spherical, fmb.Prismatic)
    joints = [kinds[k % 3](f"j{k}", markers=(ends[k], f"f{k}.root")) for k in range(n)]
    load = fmb.PointLoad("pull", marker=f"f{n - 1}.tip", force=(80.0, 20.0, 30.0))
    return fmb.Model(gravity=(1, -9.81, 2), bodies=[fmb.Ground(), *bodies], joints=joints, forces=[load])


def branched() -> fmb.Model:
    """Return a floating root with rigid and flexible branches, a point mass on a spring, a slide with a drive."""
    ends = {
        "cross": fmb.Pose((0.5, 0, 0), (np.pi / 2, 0, 0)),
        "w": fmb.Pose((-0.5, 0, 0), (0.3, 0.2, 0)),
        "n": (0, 0.5, 0),
        "s": (0, -0.5, 0.1),
    }
    bodies = [
        fmb.Ground(),
        fmb.RigidBody("hub", mass=3.0, inertia=(0.4, 0.5, 0.6), center_of_mass=(0.02, 0.01, 0), markers=ends),
        fmb.FloatingBody("wing", data=beam(), at=(0.5, 0, 0)),
        fmb.RigidBody.rod("tail", length=0.7, mass=0.4, radius=0.02, at=(-0.5, 0, 0), rotation=(0.3, 0.2, 0)),
        fmb.RigidBody.rod("rod", length=0.6, mass=0.5, radius=0.02, at=(0, 0.5, 0), rotation=(0, 0, 1.5)),
        fmb.FloatingBody("fin", data=beam(), at=(0, -0.5, 0.1), rotation=(0, 0, -1.2), geometric_stiffness=False),
        fmb.RigidBody.sphere("ball", radius=0.05, density=3000.0, at=(1.5, 0, 0)),
        fmb.PointMass("dust", mass=0.3, at=(0, 0, 1.0)),
        fmb.RigidBody.sphere("free", radius=0.1, density=500.0, at=(3, 3, 3)),
    ]
    joints = [
        fmb.Universal("a", markers=("hub.cross", "wing.root")),
        fmb.Cylindrical("b", markers=("hub.w", "tail.start")),
        fmb.Spherical("c", markers=("rod.start", "hub.n")),
        fmb.Fixed("d", markers=("hub.s", "fin.root")),
        fmb.Revolute("e", markers=("wing.tip", "ball.center")),
        fmb.Drive("f", joint="b", displacement=fmb.expression("0.1 + 0.3*t + t**2")),
    ]
    forces = [
        fmb.SpringDamper("s", markers=("hub.center", "dust.center"), stiffness=50.0, damping=1.0, length=0.8),
        fmb.PointLoad("p", marker="fin.tip", force=(30.0, -20.0, 5.0)),
    ]
    drawn = fmb.Model(gravity=(0.5, -9.81, 1.0), bodies=bodies, joints=joints, forces=forces)
    return put_together(drawn)


def loops() -> fmb.Model:
    """Return a flexible four-bar with a redundant hinge, geared to a crank that moves a pendulum by a rod."""
    ground = fmb.Ground(
        markers={"A": (0, 0, 0), "A2": (0, 0, 0.2), "D": (1.0, 0, 0), "E": (0.3, -0.4, 0.1), "F": (0.6, -0.4, 0.1)}
    )
    bodies = [
        ground,
        fmb.RigidBody(
            "crank",
            mass=1.0,
            inertia=(0.02, 0.08, 0.08),
            rotation=(0, 0, np.pi / 2),
            markers={"A": (0, 0, 0), "A2": (0, 0, 0.2), "B": (0.8, 0, 0)},
        ),
        fmb.FloatingBody("coupler", data=beam(), at=(0, 0.8, 0)),
        fmb.RigidBody.rod("rocker", length=0.8, mass=0.7, radius=0.03, at=(1.0, 0, 0), rotation=(0, 0, np.pi / 2)),
        fmb.RigidBody.rod("bob", length=0.3, mass=0.2, radius=0.02, at=(0.6, -0.4, 0.1), rotation=(0, 0, 1.0)),
        fmb.RigidBody.rod("wheel", length=0.3, mass=0.6, radius=0.03, at=(0.3, -0.4, 0.1)),
    ]
    joints = [
        fmb.Revolute("A", markers=("ground.A", "crank.A")),
        fmb.Revolute("A2", markers=("ground.A2", "crank.A2")),
        fmb.Revolute("B", markers=("crank.B", "coupler.root")),
        fmb.Spherical("C", markers=("coupler.tip", "rocker.end")),
        fmb.Revolute("D", markers=("ground.D", "rocker.start")),
        fmb.Revolute("E", markers=("ground.E", "wheel.start")),
        fmb.Spherical("F", markers=("ground.F", "bob.start")),
        fmb.Coupler("gear", joints=("A", "E"), ratio=0.5),
        fmb.Rod("link", markers=("wheel.end", "bob.end")),
    ]
    return fmb.Model(gravity=(0, -9.81, 0), bodies=bodies, joints=joints)


def flap_station(**parameters) -> fmb.Model:
    """Return the demonstration with few modes of its lever."""
    data = Path(fmb.__file__).parent / "cli" / "demo_data"
    return fmb.load_model(data / "flap_station.toml", {"lever_modes": 6, **parameters})


def random_consistent(model: fmb.Model, rng, spread: float = 0.1, strain: float = 1e-3):
    """Return the system and a random state on its constraints: displaced, deformed, in motion."""
    system, start = assemble(model)
    size = units(system, strain)
    there = moved(system, start, size * rng.normal(size=system.nu), spread, u=size * rng.normal(size=system.nu))
    for iq, _, count, flexible in system.program.vectors:
        if flexible:
            there.q[iq : iq + count] = strain * rng.normal(size=count)
    placed = {name: (there.q[iq], there.u[iu]) for name, (iq, iu) in system.body_slices.items()}
    return assemble(model, state=placed)
