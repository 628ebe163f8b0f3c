"""Contact of surfaces against closed forms: impact by Hertz, layers under balls and crossed cylinders.

References: Johnson, Contact Mechanics, sections 4.2 and 4.3; Timoshenko & Goodier, Theory of Elasticity, section 142
(impact of spheres).
"""

import numpy as np
import pytest
from by_turns import slow
from surfaces.bodies_of_triangles import ball

import flexmb as fmb
from flexmb.system import compile
from flexmb.system.program import evaluate


def pressed(first, second, place, at, *, spacing, modulus, rotation=None):
    """Return the force between two surfaces, N, the first on a ground marker, and the area in contact, m2."""
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"o": place}),
            fmb.RigidBody("b", mass=1, inertia=(1, 1, 1), at=at, rotation=rotation),
        ],
        surfaces=[
            fmb.Surface("p", marker="ground.o", shape=first),
            fmb.Surface("q", marker="b.center", shape=second, spacing=spacing),
        ],
        forces=[
            fmb.SurfaceContact(
                "f", surfaces=("p", "q"), law=fmb.ElasticFoundation(modulus=modulus, thickness=1.0, damping=0.0)
            )
        ],
        sensors=[fmb.ContactState("s", force="f")],
    )
    system = compile(model)
    work = system.workspace()
    evaluate(system.program, system.state(), work)
    area = fmb.simulate(model, t_end=1e-9, samples=2)["s"][0, 1]
    return work.markers["wrench"][system.marker_index["b.center"]][:3], area


def test_impact_of_a_steel_ball():
    """Ball of 20 mm radius at 1 m/s on a half-space, both of steel.

    Depth (5 m v^2 / 4 k)^0.4, force k d^1.5, duration 2.943 d / v.
    k = 4/3 E* sqrt(R) = 2.17571e10 N/m^1.5; depth 46.9616e-6 m, force 7001.90 N, duration 138.22e-6 s.
    """
    R, mass = 0.02, 7850.0 * 4 / 3 * np.pi * 0.02**3
    steel = fmb.Material(young=2.1e11, poisson=0.3, density=7850.0)
    k = fmb.Contact.hertz_stiffness(R, steel)
    assert k == pytest.approx(2.175713172881684e10, rel=1e-12)
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"o": (0, 0, 0)}),
            fmb.RigidBody("b", mass=mass, inertia=(1e-4,) * 3, at=(0, 0, R + 1e-5), velocity=(0, 0, -1.0)),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.o", shape=fmb.Plane()),
            fmb.Surface("ball", marker="b.center", shape=fmb.Sphere(R)),
        ],
        forces=[fmb.SurfaceContact("hit", surfaces=("floor", "ball"), law=fmb.Hertz(stiffness=k))],
        sensors=[fmb.ContactState("s", force="hit"), fmb.Velocity("v", marker="b.center")],
    )
    solution = fmb.simulate(model, t_end=2e-4, samples=2001, integrator=fmb.GeneralizedAlpha(rtol=1e-7))
    force, depth = solution["s"][:, 0], solution["s"][:, 3]
    assert depth.max() == pytest.approx(4.696157457464013e-05, rel=5e-3)
    assert force.max() == pytest.approx(7001.895359217755, rel=5e-3)
    assert np.sum(force > 0.0) * 1e-7 == pytest.approx(0.0001382208370225648, rel=5e-3)
    assert solution["v"][-1, 2] == pytest.approx(1.0, rel=5e-3)


@pytest.mark.parametrize(("first", "second"), [slow(0.1, 0.1), (0.1, 0.04)])
def test_crossed_cylinders_in_a_layer(first, second):
    """The gap is x^2 / 2 R + y^2 / 2 R': the force pi K/h sqrt(R R') d^2, the area 2 pi sqrt(R R') d."""
    d, k = 5e-4, 1e10
    F, area = pressed(
        fmb.Cylinder(radius=first, length=0.5),
        fmb.Cylinder(radius=second, length=0.5),
        fmb.Pose((0, 0, 0), (0, np.pi / 2, 0)),
        (0, 0, first + second - d),
        rotation=(np.pi / 2, 0, 0),
        spacing=1e-3,
        modulus=k,
    )
    assert F[2] == pytest.approx(np.pi * k * np.sqrt(first * second) * d**2, rel=1e-2)
    assert np.abs(F[:2]).max() < 1e-6 * F[2]
    assert area == pytest.approx(2 * np.pi * np.sqrt(first * second) * d, rel=5e-2)


@pytest.mark.slow
def test_the_force_of_hertz_by_a_layer_at_one_depth():
    """With K/h = 4 E* / (3 pi sqrt(R d)) a mesh of 81 920 triangles (side R / 60) has Hertz's force within 2 %, and
    twice the area of Hertz's circle, pi R d: a layer is not a half-space."""
    vertices, triangles = ball(6)
    d, modulus = 2e-2, 1e7
    k = 4.0 * modulus / (3.0 * np.pi * np.sqrt(d))
    F, area = pressed(
        fmb.Plane(), fmb.TriangleMesh(vertices, triangles), (0, 0, 0), (0, 0, 1.0 - d), spacing=10.0, modulus=k
    )
    assert F[2] == pytest.approx(4 / 3 * modulus * d**1.5, rel=2e-2)
    assert area == pytest.approx(2 * np.pi * d, rel=5e-2)
