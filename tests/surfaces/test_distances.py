"""Signed distances of the shapes: closed forms at chosen points, and derivatives against differences."""

from functools import lru_cache

import numpy as np
import pytest

import flexmb as fmb
from flexmb.surfaces.distances import signed_distance

SHAPES = {
    "Plane": fmb.Plane(),
    "Sphere": fmb.Sphere(0.7),
    "Cylinder": fmb.Cylinder(radius=0.5, length=1.6),
    "Capsule": fmb.Capsule(radius=0.4, length=1.1),
    "Cuboid": fmb.Cuboid(size=(0.9, 1.3, 0.6)),
    "Cone": fmb.Cone(radius=0.7, length=1.2, top=0.2),
    "Torus": fmb.Torus(radius=0.8, tube=0.3),
    "RevolvedProfile": fmb.RevolvedProfile(
        profile=fmb.Outline(
            start=(0.3, -0.4),
            pieces=[fmb.Line(to=(0.9, -0.4)), fmb.Arc(center=(0.9, 0.0), sweep=np.pi), fmb.Line(to=(0.3, 0.4))],
        )
    ),
}


@lru_cache(maxsize=1)
def packed(shape):
    """Return the numbers of a shape: points come one after the other."""
    return fmb.Surface("s", marker="b.m", shape=shape).packed


def distance(shape, z):
    """Return distance, gradient and second derivative at a point."""
    n, H = np.empty(3), np.empty((3, 3))
    return signed_distance(packed(shape), 0, np.asarray(z, float), np.inf, n, H), n, H


@pytest.mark.parametrize(
    ("name", "z", "gap"),
    [
        ("Plane", (3.0, -2.0, 0.25), 0.25),
        ("Sphere", (0.0, 0.3, 0.4), -0.2),
        ("Sphere", (0.0, 3.0, 4.0), 4.3),
        ("Cylinder", (0.3, 0.4, 0.1), 0.0),
        ("Cylinder", (0.0, 0.8, 1.2), 0.5),
        ("Cylinder", (0.1, 0.0, -0.7), -0.1),
        ("Capsule", (0.0, 0.0, -1.0), 0.05),
        ("Capsule", (0.6, 0.8, 0.2), 0.6),
        ("Cuboid", (0.45 + 2.0, 0.65 + 3.0, -0.3 - 6.0), 7.0),
        ("Cuboid", (0.0, 0.6, 0.0), -0.05),
        ("Cone", (0.0, 0.0, 1.0), 0.4),
        ("Cone", (0.45 + 1.2, 0.0, 0.5), 1.3),
        ("Cone", (0.0, -0.7 - 0.3, -0.6 - 0.4), 0.5),
        ("Torus", (0.48, 0.64, 0.5), 0.2),
        ("Torus", (0.0, 0.0, 0.6), 0.7),
        ("RevolvedProfile", (0.0, 1.6, 0.0), 0.3),
        ("RevolvedProfile", (0.0, 0.0, 0.0), 0.3),
    ],
)
def test_closed_forms(name, z, gap):
    assert distance(SHAPES[name], z)[0] == pytest.approx(gap, abs=1e-14)


@pytest.mark.parametrize("name", SHAPES)
def test_derivatives(name, rng):
    """Central differences of sixth order; a step over an edge of the inside is left out by its size."""
    h = 1e-3
    stencil = {-3: -1 / 60, -2: 9 / 60, -1: -45 / 60, 1: 45 / 60, 2: -9 / 60, 3: 1 / 60}
    examined = 0
    while examined < 40:
        z = rng.normal(size=3)
        _, n, H = distance(SHAPES[name], z)
        near = [distance(SHAPES[name], z + k * h * e)[2] for k in (-4, 4) for e in np.eye(3)]
        if max(np.abs(near - H).max() for near in near) > 0.05 * (1.0 + np.abs(H).max()):
            continue  # another part of the surface is nearest within the differences
        gradient = [
            sum(w * distance(SHAPES[name], z + k * h * e)[0] for k, w in stencil.items()) / h for e in np.eye(3)
        ]
        second = [sum(w * distance(SHAPES[name], z + k * h * e)[1] for k, w in stencil.items()) / h for e in np.eye(3)]
        np.testing.assert_allclose(n, gradient, atol=1e-9)
        np.testing.assert_allclose(H, second, atol=1e-7 * (1.0 + np.abs(H).max() ** 6))
        examined += 1


@pytest.mark.parametrize("name", [name for name in SHAPES if name != "Plane"])
def test_samples_lie_on_the_surface(name):
    """Distance zero, the gradient is the normal, and areas sum up to that of the solid."""
    places, normals, areas = SHAPES[name].samples(0.05)
    for z, m in zip(places, normals):
        gap, n, _ = distance(SHAPES[name], z + 1e-9 * m)
        assert abs(gap) < 2e-3  # samples of curved parts lie on them, those of cells between
        assert n @ m > 0.999
    r, h = 0.5, 1.6
    area = {
        "Sphere": 4 * np.pi * 0.49,
        "Cylinder": 2 * np.pi * r * (r + h),
        "Capsule": 4 * np.pi * 0.16 + 2 * np.pi * 0.4 * 1.1,
        "Cuboid": 2 * (0.9 * 1.3 + 0.9 * 0.6 + 1.3 * 0.6),
        "Cone": np.pi * (0.49 + 0.04 + 0.9 * 1.3),
        "Torus": 4 * np.pi**2 * 0.8 * 0.3,
        "RevolvedProfile": 2 * np.pi * (0.81 - 0.09 + 0.3 * 0.8 + np.pi * 0.4 * (0.9 + 0.8 / np.pi)),
    }[name]
    assert areas.sum() == pytest.approx(area, rel=1e-4 if name in ("Torus", "RevolvedProfile") else 1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_drawn_triangles_lie_on_the_surface_and_face_outward(name):
    vertices, triangles = SHAPES[name].drawing()
    assert max(abs(distance(SHAPES[name], v)[0]) for v in vertices) < 1e-12
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    for middle, m in zip((a + b + c) / 3, normal):
        if np.linalg.norm(m) > 1e-9:
            assert distance(SHAPES[name], middle + 1e-6 * m)[1] @ m > 0.0


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: fmb.Sphere(-1.0), "radius = -1.0"),
        (lambda: fmb.Sphere(np.nan), "radius = nan"),
        (lambda: fmb.Cuboid(size=(1, 2)), "three lengths"),
        (lambda: fmb.Cylinder(radius=1.0, length=0.0), "length = 0.0"),
        (lambda: fmb.Surface("s", marker="b.m", shape="Sphere"), "shape = 'Sphere'"),
        (lambda: fmb.Surface("s", marker="b.m", shape=fmb.Sphere(1.0), spacing=0.0), "spacing = 0.0"),
        (lambda: fmb.Surface("s", marker="b.m", shape=fmb.Sphere(1.0), spacing=1e-6), "at most about"),
        (lambda: fmb.Surface("s", marker="b.m", shape=fmb.Sphere(16.0), spacing=0.05), "at most about"),
        (lambda: fmb.Surface("s", marker="b.m", shape=fmb.Sphere(1.0), spacing=1e-200), "at most about"),
        (lambda: fmb.Surface("s", marker="b.m", shape=fmb.Capsule(1e-12, 1.0), spacing=1e-6), "at most about"),
        (lambda: fmb.Surface("s", marker="b.m", shape=fmb.Plane(), spacing=0.1).points, "finite area"),
    ],
)
def test_messages(make, said):
    with pytest.raises(fmb.ModelError, match=said):
        make()


def test_slender_shapes_are_sampled_by_their_area():
    """A rope of 10 m and 2 cm has 0.63 m2, in spacings of 2 mm some 157 000 points: a ball around it would have 3e8."""
    rope = fmb.Surface("s", marker="b.m", shape=fmb.Capsule(radius=0.01, length=10.0), spacing=2e-3)
    assert rope.points[2].sum() == pytest.approx(2.0 * np.pi * 0.01 * 10.0 + 4.0 * np.pi * 1e-4, rel=1e-9)
    assert len(rope.points[0]) == pytest.approx(0.629575 / 4e-6, rel=0.02)


def test_revolved_disc_is_a_sphere(rng):
    """A profile that crosses the axis is revolved as a solid; on the axis too."""
    mine, other = fmb.RevolvedProfile(profile=fmb.Disc(radius=0.7)), fmb.Sphere(0.7)
    for z in [*rng.normal(size=(30, 3)), (0, 0, 1.2), (0, 0, -0.3), (0, 0, 0.7)]:
        for a, b in zip(distance(mine, z), distance(other, z)):
            np.testing.assert_allclose(a, b, atol=1e-9)
    assert mine.samples(0.05)[2].sum() == pytest.approx(4 * np.pi * 0.49, rel=1e-4)
    tip = fmb.Cone(radius=0.5, length=1.2)
    assert tip.samples(0.05)[2].sum() == pytest.approx(np.pi * (0.25 + 0.5 * 1.3), rel=1e-12)
    assert distance(tip, (0, 0, 0.9))[0] == pytest.approx(0.3, abs=1e-14)


def test_foot_on_the_joint_of_two_arcs():
    """A circle is two arcs; a point on their joint, whose coordinates are rounded, has a foot there."""
    disc = fmb.Disc(radius=0.7)
    for point in ((-0.7, 0.0), (-0.7, -1e-300), (0.7, 0.0)):
        gap, normal, _ = disc.distance(point)
        assert gap == pytest.approx(0.0, abs=1e-15)
        np.testing.assert_allclose(normal, (np.sign(point[0]), 0.0), atol=1e-12)


def test_height_field():
    """A plane slope of heights: the distance of a plane; volume and normals of a closed mesh."""
    x = np.linspace(-1.0, 1.0, 5)
    heights = np.repeat(0.5 * x[:, None], 4, axis=1)
    ground = fmb.HeightField(heights=heights, size=(2.0, 1.0), depth=0.5)
    c = 1.0 / np.hypot(1.0, 0.5)
    gap, n, _ = distance(ground, (0.1, 0.2, 0.4))
    assert gap == pytest.approx((0.4 - 0.05) * c, abs=1e-14)
    np.testing.assert_allclose(n, (-0.5 * c, 0, c), atol=1e-14)
    vertices, triangles = ground.drawing()
    a, b, d = (vertices[triangles[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, d)) / 6.0 == pytest.approx(2.0 * (0.5 + 0.5), rel=1e-12)
    bumps = fmb.HeightField(heights=[[0, 0, 0], [0, 0.3, 0], [0, 0, 0]], size=(2.0, 2.0), depth=0.5)
    assert distance(bumps, (0.0, 0.0, 0.8))[0] == pytest.approx(0.5, abs=1e-14)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: fmb.Torus(radius=0.1, tube=0.2), "less than the radius"),
        (lambda: fmb.Cone(radius=0.1, length=0.2, top=-1.0), "a radius >= 0"),
        (lambda: fmb.RevolvedProfile(profile=fmb.Disc(radius=0.2, center=(0.1, 0))), "halves differ by 0.2 m"),
        (lambda: fmb.RevolvedProfile(profile=fmb.Disc(radius=0.2, center=(1, 0), hollow=True)), "around a hole"),
        (lambda: fmb.HeightField(heights=[[1, 2]], size=(1, 1), depth=1.0), "2 or more each"),
        (lambda: fmb.HeightField(heights=[[1, 2], [np.nan, 0]], size=(1, 1), depth=1.0), "2 or more each"),
    ],
)
def test_refused_shapes(make, message):
    with pytest.raises(fmb.ModelError, match=message):
        make()


@pytest.mark.parametrize(
    "shape", [fmb.Sphere(0.1), fmb.Capsule(radius=0.1, length=0.2)], ids=lambda s: type(s).__name__
)
def test_a_spacing_beyond_all_sizes_gives_the_fewest_points(shape):
    surface = fmb.Surface("s", marker="b.m", shape=shape, spacing=1e300)
    assert 4 <= len(surface.points[0]) < 20
