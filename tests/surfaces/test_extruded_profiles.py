"""Extruded profiles: distances and forces of the shapes that they equal, derivatives where they equal none."""

from functools import cache

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.surfaces.distances import signed_distance
from flexmb.system import compile
from flexmb.system.program import evaluate

EQUAL = {
    "cylinder": (fmb.ExtrudedProfile(profile=fmb.Disc(radius=0.5), length=1.6), fmb.Cylinder(radius=0.5, length=1.6)),
    "box": (
        fmb.ExtrudedProfile(
            profile=fmb.Outline(
                start=(-0.3, -0.4), pieces=[fmb.Line(to=p) for p in ((0.3, -0.4), (0.3, 0.4), (-0.3, 0.4))]
            ),
            length=1.0,
        ),
        fmb.Cuboid(size=(0.6, 0.8, 1.0)),
    ),
}
CAM = fmb.ExtrudedProfile(
    profile=fmb.Cam(base_radius=0.4, motion=[(2.0, 0.1, "cycloidal"), (2 * np.pi, 0.0, "polynomial")]), length=0.5
)


@cache
def packed(shape):
    return fmb.Surface("s", marker="b.m", shape=shape).packed


def distance(shape, z):
    """Return distance, gradient and second derivative at a point."""
    data = packed(shape)
    n, H = np.empty(3), np.empty((3, 3))
    return signed_distance(data, 0, np.asarray(z, float), np.inf, n, H), n, H


@pytest.mark.parametrize("name", EQUAL)
def test_equal_to_a_primitive(name, rng):
    mine, other = EQUAL[name]
    for z in rng.normal(size=(60, 3)):
        for a, b in zip(distance(mine, z), distance(other, z)):
            np.testing.assert_allclose(a, b, atol=1e-12)
    assert other.reach * (1 - 1e-12) <= mine.reach <= 1.2 * other.reach
    assert mine.samples(0.05)[2].sum() == pytest.approx(other.samples(0.05)[2].sum(), rel=1e-3)


def test_derivatives_of_a_cam(rng):
    data = fmb.Surface("s", marker="b.m", shape=CAM).packed
    h, examined = 1e-5, 0
    for z in rng.normal(size=(60, 3)):
        n, H, other = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
        if signed_distance(data, 0, z, np.inf, n, H) < 0.02:
            continue  # inside the nearest part changes
        ends = np.empty((3, 2, 4))
        for k, e in enumerate(h * np.eye(3)):
            for side, step in enumerate((-e, e)):
                m = np.empty(3)
                ends[k, side, 0] = signed_distance(data, 0, z + step, np.inf, m, other)
                ends[k, side, 1:] = m
        change = (ends[:, 1] - ends[:, 0]) / (2.0 * h)
        np.testing.assert_allclose(n, change[:, 0], atol=1e-8)
        np.testing.assert_allclose(H, change[:, 1:], atol=1e-5)
        examined += 1
    assert examined > 30


def test_samples_and_drawing_lie_on_it():
    places, normals, areas = CAM.samples(0.1)
    for z, m in zip(places, normals):
        assert abs(distance(CAM, z)[0]) < 2e-4 * 0.4  # in the middle of chords of 0.04 rad
        assert distance(CAM, z + 1e-3 * m)[1] @ m > 0.99
    vertices, triangles = CAM.drawing()
    assert max(abs(distance(CAM, v)[0]) for v in vertices) < 1e-9
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    for middle, m in zip((a + b + c) / 3, np.cross(b - a, c - a)):
        assert distance(CAM, middle)[1] @ m > 0.0
    rim = CAM.profile.points(1e-3)
    around = np.linalg.norm(np.diff(rim, axis=0), axis=1).sum()
    assert areas.sum() == pytest.approx(0.5 * around + 2.0 * CAM.profile.area, rel=1e-4)


def test_an_extruded_disc_presses_as_a_cylinder():
    """On a layer: K/h times the integral of the depth over the arc under the floor, 2 R w (R sin phi - (R - d) phi)."""
    radius, depth, length = 0.1, 2e-3, 0.2
    layer = fmb.ElasticFoundation(modulus=1e8, thickness=0.01)
    lying = (np.pi / 2, 0, 0)
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"o": (0, 0, 0)}),
            fmb.RigidBody("b", mass=2.0, inertia=(0.01, 0.01, 0.01), at=(0, 0, radius - depth), rotation=lying),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.o", shape=fmb.Plane()),
            fmb.Surface(
                "disc",
                marker="b.center",
                shape=fmb.ExtrudedProfile(profile=fmb.Disc(radius=radius), length=length),
                spacing=1e-3,
            ),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=("floor", "disc"), law=layer)],
    )
    system = compile(model)
    work = system.workspace()
    evaluate(system.program, system.state(), work)
    found = work.markers["wrench"][system.marker_index["b.center"]]
    phi = np.arccos(1.0 - depth / radius)
    expected = 1e10 * length * 2.0 * radius * (radius * np.sin(phi) - (radius - depth) * phi)
    assert found[2] == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: fmb.ExtrudedProfile(profile="disc", length=1.0), "a Profile"),
        (lambda: fmb.ExtrudedProfile(profile=fmb.Disc(radius=0.1, hollow=True), length=1.0), "around a hole"),
        (
            lambda: fmb.ExtrudedProfile(
                profile=fmb.Outline(start=(0, 0), pieces=[fmb.Line(to=(1, 0))], ends=True), length=1.0
            ),
            "an open profile",
        ),
        (lambda: fmb.ExtrudedProfile(profile=fmb.Disc(radius=0.1), length=0.0), "length = 0.0"),
    ],
)
def test_bad_input_is_refused_by_name(make, words):
    with pytest.raises(ModelError, match=words):
        make()
