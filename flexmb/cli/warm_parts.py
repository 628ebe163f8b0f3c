"""A meshed part, bodies that touch, and driven joints, whose analyses need the kernels that other models do not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import flexmb as fmb
from flexmb import fem, reduction

__all__ = ["driven", "meshed", "orbit", "sampled", "skins", "torques", "touching"]

MESH = Path(__file__).parent / "demo_data" / "lever_arm.msh"


def meshed() -> fmb.Solution:
    """Reduce the lever of the demo, let it swing, and write its stress for ParaView."""
    fe = fem.solid(fem.read_mesh(MESH), fmb.MATERIALS["titanium"])
    bores = {"root": "bore_root", "tip": "bore_tip"}
    data = reduction.reduce(fe, interfaces=bores, modes=2, geometric_stiffness=True)
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"O": (0, 0, 0)}), fmb.FloatingBody("lever", data=data)],
        joints=[fmb.Spherical("root", markers=("ground.O", "lever.root"))],
        sensors=[fmb.Stress("stress", body="lever")],
    )
    solution = fmb.simulate(model, 0.01, samples=3)
    with TemporaryDirectory() as folder:
        fmb.write_vtk(solution, Path(folder) / "lever.pvd", surface=True)
    return solution


def touching() -> fmb.Solution:
    """Let balls, boxes and a rod fall on each other: rigid contact with friction, rolling and drilling."""
    names = ("ball", "second", "box", "other", "rod")
    heights = (0.1001, 0.3003, 0.1001, 0.3003, 0.0501)
    body = {"mass": 1.0, "inertia": (4e-3, 4e-3, 4e-3), "velocity": (0.1, 0, 0)}
    ball, box = fmb.Sphere(radius=0.1), fmb.Cuboid(size=(0.2, 0.2, 0.2))
    shapes = (ball, ball, box, box, fmb.Cylinder(radius=0.05, length=0.4))
    law = {"friction": 0.3, "restitution": 0.0}
    return fmb.simulate(
        fmb.Model(
            gravity=(0, 0, -9.81),
            bodies=[
                fmb.Ground(),
                *[
                    fmb.RigidBody(
                        name, at=(0.5 * k if k < 4 else 5.0, 0, z), rotation=(0, 0.5 * np.pi * (k == 4), 0), **body
                    )
                    for name, k, z in zip(names, (0, 0, 1, 1, 4), heights, strict=True)
                ],
            ],
            surfaces=[
                fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
                *[
                    fmb.Surface(name, marker=f"{name}.center", shape=shape)
                    for name, shape in zip(names, shapes, strict=True)
                ],
            ],
            forces=[
                fmb.SurfaceContact(
                    "balls", surfaces=(("floor", "second"), "ball"), law=fmb.Rigid(rolling=1e-3, drilling=1e-3, **law)
                ),
                fmb.SurfaceContact("boxes", surfaces=(("floor", "other"), "box"), law=fmb.Rigid(**law)),
                fmb.SurfaceContact("rod", surfaces=("floor", "rod"), law=fmb.Rigid(**law)),
            ],
        ),
        0.02,
        samples=3,
        integrator=fmb.MoreauJean(step=5e-4),
    )


def skins() -> np.ndarray:
    """Press two crossing beams on each other and return the state of their contact: force, area and pressure first."""
    r = 0.01
    section = fem.Section.solid_circle(2.0 * r)

    def rod(name: str, start: tuple, end: tuple) -> fmb.AncfBeam:
        skin = fmb.Skin(spacing=1.5e-3, radius=r, between=(0.4, 0.6), faces=True)
        points, steel = (start, end), fmb.MATERIALS["steel"]
        return fmb.AncfBeam(name, points=points, elements=2, section=section, material=steel, skins={"side": skin})

    law = fmb.ElasticFoundation(modulus=1e9, thickness=0.01, friction=0.3, damping=0.1)
    height = 2.0 * r - 1e-4
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(),
            rod("over", (-0.1, 0, height), (0.1, 0, height)),
            rod("under", (0, -0.1, 0), (0, 0.1, 0)),
        ],
        surfaces=[fmb.SkinSurface(name, skin=f"{name}.side") for name in ("over", "under")],
        forces=[fmb.SkinContact("touch", surfaces=("over", "under"), law=law)],
        sensors=[fmb.ContactState("state", force="touch")],
    )
    return fmb.simulate(model, 1e-5, samples=2)["state"]


def sampled() -> fmb.Solution:
    """Damp a slider by a sampled measurement of its speed, and look for an event that does not come."""
    place = fmb.JointCoordinate("place", joint="slide")
    speed = fmb.Sampled(fmb.measured(place, rate=True), period=1e-3)
    brake = fmb.Actuator("brake", joint="slide", effort=-2.0 * speed)
    model = replace(
        _slider(brake), sensors=[place], events=[fmb.Event("far", sensor="place", below=-9.0, then=fmb.Stop())]
    )
    return fmb.simulate(model, 0.01, samples=3)


def orbit() -> np.ndarray:
    """Return the table of an orbit about a flattened centre."""
    return fmb.Orbit(place=(7e6, 0, 0), velocity=(0, 7.5e3, 100.0), j2=1.0826267e-3, turns=0.1).table


def driven() -> fmb.Solution:
    """Move a slider as wanted."""
    return fmb.kinematics(
        _slider(fmb.Drive("push", joint="slide", displacement=fmb.harmonic(0.1, 2.0))), 0.1, samples=3
    )


def torques() -> np.ndarray:
    """Return the force that a slider needs for a motion; products and the Jacobian are asked for as well."""
    tree, q, v = fmb.JointTree(_slider()), [0.1], [0.2]
    tree.mass_solution(q, tree.mass_product(q, v))
    tree.jacobian("cart.center", q)
    tree.marker_acceleration("cart.center", q, v)
    return tree.torques(q, v, [0.3])


def _slider(*parts) -> fmb.Model:
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.RigidBody("cart", mass=1.0, inertia=(1e-2, 1e-2, 1e-2))],
        joints=[
            fmb.Prismatic("slide", markers=("ground.origin", "cart.center")),
            *[part for part in parts if isinstance(part, fmb.Drive)],
        ],
        forces=[part for part in parts if not isinstance(part, fmb.Drive)],
    )
