"""Compliant contact of surfaces: tangents against differences, forces and motions against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from by_turns import every_second
from contracts.random_models import moved, random_state
from contracts.test_tangents import H, assert_tangent

import flexmb as fmb
from flexmb.forces.relative import relative_motion
from flexmb.forces.surface_contact import ROW
from flexmb.model.spots import ALONE
from flexmb.surfaces.detection import find_areas
from flexmb.surfaces.records import CONTACT
from flexmb.system import compile
from flexmb.system.program import evaluate

LAYER = fmb.ElasticFoundation(modulus=1e8, thickness=0.01)


def over_the_floor(shape, height, *, spacing=None, law=LAYER, rotation=None, floor=None, **body):
    """Return a body of 2 kg above a plane."""
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"o": (0, 0, 0)}),
            fmb.RigidBody("b", mass=2.0, inertia=(0.01, 0.01, 0.01), at=(0, 0, height), rotation=rotation, **body),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.o", shape=floor or fmb.Plane()),
            fmb.Surface("ball", marker="b.center", shape=shape, spacing=spacing),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=("floor", "ball"), law=law)],
        sensors=[fmb.Position("at", marker="b.center"), fmb.ForceOf("F", force="touch"), fmb.Energy("E")],
    )


def wrench(model, marker="b.center"):
    """Return the wrench on the body at its marker at the start, and the energies."""
    system = compile(model)
    work = system.workspace()
    evaluate(system.program, system.state(), work)
    return work.markers["wrench"][system.marker_index[marker]].copy(), work.energy[0]


def test_ball_in_a_layer():
    """A ball in a Winkler layer: f = pi K/h R d^2, with area weighted points on the ball itself (Johnson, 4.3: for
    small d / R the paraboloid has the same)."""
    R, d = 0.1, 1e-3
    (_, _, force, *moment), energy = wrench(over_the_floor(fmb.Sphere(R), R - d, spacing=8e-4))
    assert force == pytest.approx(np.pi * 1e10 * R * d**2, rel=2e-3)
    assert energy.potential == pytest.approx(np.pi * 1e10 * R * d**3 / 3, rel=5e-3)
    np.testing.assert_allclose(moment, 0.0, atol=1e-3 * force * R)


def test_box_on_a_layer():
    """f = K/h A d at each depth, without a moment; its sides do not count."""
    box = fmb.Cuboid(size=(0.2, 0.1, 0.06))
    F, energy = wrench(over_the_floor(box, 0.03 - 2e-4, spacing=0.01))
    np.testing.assert_allclose(F, (0, 0, 1e10 * 0.02 * 2e-4, 0, 0, 0), atol=1e-6)
    assert energy.potential == pytest.approx(0.5 * 1e10 * 0.02 * 4e-8, rel=1e-12)


def test_either_surface_may_be_sampled():
    """Points of the ball against the box: pi K/h R d^2. Points of the box against the ball, where the depth is taken
    along the ball's normal: pi K/h (R - d) d^2. Both: their mean."""
    R, d = 0.1, 2e-3
    box = fmb.Cuboid(size=(0.3, 0.3, 0.1))
    at = fmb.Pose((0, 0, -0.05))
    expected = np.pi * 1e10 * R * d**2
    found = []
    for floor, ball in ((None, 1e-3), (1e-3, None), (1e-3, 1e-3)):
        model = fmb.Model(
            bodies=[
                fmb.Ground(markers={"o": at}),
                fmb.RigidBody("b", mass=2.0, inertia=(0.01,) * 3, at=(0.01, 0.02, R - d)),
            ],
            surfaces=[
                fmb.Surface("floor", marker="ground.o", shape=box, spacing=floor),
                fmb.Surface("ball", marker="b.center", shape=fmb.Sphere(R), spacing=ball),
            ],
            forces=[fmb.SurfaceContact("touch", surfaces=("floor", "ball"), law=LAYER)],
        )
        found.append(wrench(model)[0][2])
    np.testing.assert_allclose(found, expected * np.array([1.0, 1.0 - d / R, 1.0 - 0.5 * d / R]), rtol=1e-3)


SHAPES = {
    "Sphere": fmb.Sphere(1.3),
    "Cylinder": fmb.Cylinder(radius=1.2, length=2.6),
    "Capsule": fmb.Capsule(radius=1.1, length=1.0),
    "Cuboid": fmb.Cuboid(size=(2.3, 1.9, 2.1)),
    "Cone": fmb.Cone(radius=1.4, length=2.2, top=0.5),
    "Torus": fmb.Torus(radius=1.2, tube=0.5),
}


def contacts_of(system, state):
    """Return the contacts of the one pair of a model at a state."""
    work = system.workspace()
    evaluate(system.program, state, work)
    data = system.program.bulk
    row = system.program.raw[system.force_rows[0, 1] : system.force_rows[0, 2]].view(ROW)[0]
    a, b, _, at_a, at_b = (int(x) for x in data[row["pairs"] : row["pairs"] + 5])
    motion, Q, found = np.empty(9), np.empty((3, 3)), np.zeros(row["capacity"], CONTACT)
    relative_motion(work.markers[a], work.markers[b], motion, Q)
    return found[: find_areas(data, at_a, at_b, 0.0, motion[:3], Q, found)]


def smooth(system, state, h):
    """Do the same samples touch the same parts of the surfaces around a state?"""
    here = contacts_of(system, state)
    if len(here) == 0 or here["area"].max() == 0.0:
        return False
    for e in np.eye(system.nu):
        for x in (-h, h):
            there = contacts_of(system, moved(system, state, e, x))
            if len(there) != len(here) or np.abs(there["n"] - here["n"]).max() > 0.3:
                return False
    return True


@pytest.mark.parametrize(("sampled", "second", "first"), every_second(["a", "b"], SHAPES, ["Plane", *SHAPES]))
def test_tangent(first, second, sampled, rng):
    """Derivatives of the residual by sixth-order differences, with friction, where no sample begins or ceases to touch
    within the differences."""
    if first == "Plane" and sampled == "a":
        pytest.skip("a half-space is not sampled")
    law = fmb.ElasticFoundation(modulus=30.0, thickness=0.5, damping=0.02, friction=0.3, transition=2.0)
    seat = {"m": fmb.Pose((0.1, 0.2, 0.0), (0.2, 0.1, 0.3))}
    shapes = {"p": SHAPES.get(first, fmb.Plane()), "q": SHAPES[second]}
    spacing = {"p": 1.6 if sampled == "a" else None, "q": 1.6 if sampled == "b" else None}
    for _ in range(200):
        model = fmb.Model(
            bodies=[
                fmb.RigidBody("a", mass=1, inertia=(1, 1.2, 1.4), markers=seat),
                fmb.RigidBody(
                    "b", mass=1, inertia=(1, 1.2, 1.4), at=rng.normal(size=3) + (0, 0, 1.2), rotation=rng.normal(size=3)
                ),
            ],
            surfaces=[
                fmb.Surface(name, marker=marker, shape=shapes[name], spacing=spacing[name])
                for name, marker in (("p", "a.m"), ("q", "b.center"))
            ],
            forces=[fmb.SurfaceContact("f", surfaces=("p", "q"), law=law)],
        )
        system, state = random_state(model, rng)
        if smooth(system, state, 4 * H):
            break
    else:
        raise AssertionError("no smooth state found")
    assert_tangent(system, state._replace(u=np.zeros(system.nu)))
    assert_tangent(system, state, blocks=("D",))


def test_hertz_equals_contact(rng):
    """The same stiffness, damping and friction give the wrench of `Contact`, on tumbling balls."""
    fields = {"stiffness": 3e4, "damping": 0.2, "friction": 0.3, "transition": 0.1}
    for _ in range(5):
        bodies = [
            fmb.RigidBody(
                name,
                mass=1,
                inertia=(0.1,) * 3,
                at=at,
                rotation=rng.normal(size=3),
                velocity=rng.normal(size=3),
                angular_velocity=rng.normal(size=3) * 5,
                markers={"m": fmb.Pose(rng.normal(size=3) * 0.1, rng.normal(size=3))},
            )
            for name, at in (("a", (0, 0, 0)), ("b", (0.1, 0.2, 0.3)))
        ]
        surfaces = [
            fmb.Surface("p", marker="a.m", shape=fmb.Sphere(0.6)),
            fmb.Surface("q", marker="b.m", shape=fmb.Sphere(0.5)),
        ]
        own = fmb.SurfaceContact("f", surfaces=("p", "q"), law=fmb.Hertz(**fields))
        old = fmb.Contact("f", markers=("a.m", "b.m"), radius=0.5, other_radius=0.6, against="sphere", **fields)
        one, two = (wrench(fmb.Model(bodies=bodies, surfaces=surfaces, forces=[f]), "b.m") for f in (own, old))
        assert np.abs(two[0]).max() > 100.0
        np.testing.assert_allclose(one[0], two[0], atol=1e-12 * np.abs(two[0]).max())
        assert one[1].potential == pytest.approx(two[1].potential, rel=1e-12)
        assert one[1].dissipation == pytest.approx(two[1].dissipation, rel=1e-12)


def test_a_law_at_one_point_names_no_listed_point():
    """Also where the other surface has points of its own: it has no area, and its pressure is the force."""
    model = over_the_floor(fmb.Sphere(0.1), 0.0999, law=fmb.Hertz(stiffness=1e6))
    solution = fmb.simulate(model, t_end=1e-6, samples=2)
    first = next(iter(model.force("touch").spots(solution.series(0))))
    assert first.point.tolist() == [ALONE]
    assert first.area.tolist() == [1.0]
    assert first.pressure[0] == pytest.approx(1e6 * 1e-4**1.5, rel=1e-9)


@pytest.mark.parametrize(("friction", "slides"), [(0.42, False), (0.41, True), (0.2, True)])
def test_block_on_an_incline(friction, slides):
    """tan(22.5 deg) = 0.41421: above, it creeps below the transition; below, it slides with g (sin - mu cos)."""
    angle, g, u0 = np.radians(22.5), 9.81, 1e-5
    box = fmb.Cuboid(size=(0.2, 0.1, 0.01))
    law = fmb.ElasticFoundation(modulus=1e6, thickness=0.01, damping=5.0, friction=friction, transition=u0)
    depth = 2.0 * g * np.cos(angle) / 2e6  # K/h = 1e8 Pa/m on 0.02 m2 under 2 kg
    model = over_the_floor(box, 0.005 - depth, spacing=0.02, law=law)
    model = replace(model, gravity=(g * np.sin(angle), 0.0, -g * np.cos(angle)))
    x = fmb.simulate(model, t_end=0.5, samples=51)["at"][:, 0]
    if slides:
        a = g * (np.sin(angle) - friction * np.cos(angle))
        assert x[-1] - x[0] == pytest.approx(0.5 * a * 0.25, rel=2e-2)
    else:  # v / sqrt(v^2 + u0^2) = tan(angle) / mu
        share = np.tan(angle) / friction
        assert x[-1] - x[-11] == pytest.approx(0.1 * u0 * share / np.sqrt(1 - share**2), rel=1e-2)


def test_messages():
    ball = fmb.Sphere(0.1)
    with pytest.raises(fmb.ModelError, match="neither 'floor' nor 'ball' is sampled"):
        over_the_floor(ball, 1.0)
    with pytest.raises(fmb.ModelError, match="a Sphere with the law of Hertz"):
        over_the_floor(fmb.Cylinder(radius=0.1, length=0.2), 1.0, law=fmb.Hertz(stiffness=1e6))
    with pytest.raises(fmb.ModelError, match="both half-spaces"):
        over_the_floor(fmb.Plane(), 1.0, spacing=0.1)
    with pytest.raises(fmb.ModelError, match="law = 3"):
        fmb.SurfaceContact("f", surfaces=("a", "b"), law=3)
    with pytest.raises(fmb.ModelError, match="surfaces = 'a'"):
        fmb.SurfaceContact("f", surfaces="a", law=LAYER)
    with pytest.raises(fmb.ModelError, match=r"friction = -0\.1"):
        fmb.ElasticFoundation(modulus=1.0, thickness=1.0, friction=-0.1)
    with pytest.raises(fmb.ModelError, match="surface 'flor' does not exist"):
        over_the_floor(ball, 1.0, spacing=0.1).changed("touch", surfaces=("flor", "ball"))
    model = over_the_floor(ball, 1.0, spacing=0.1)
    with pytest.raises(fmb.ModelError, match="on one body"):
        model.changed("touch", surfaces=("ball", "ball"))
