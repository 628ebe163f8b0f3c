"""Shapes that bodies are given for drawing: closed surfaces of the right volume, where the body or its marker is."""

import numpy as np
import pytest
from tolerances import MACHINE

import flexmb as fmb
from flexmb import io
from flexmb.errors import ModelError
from flexmb.io.drawn_parts import drawn_parts
from flexmb.io.scene import Scene
from flexmb.io.shape_surfaces import shape_surface

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]  # area 4
STAR = [(r * np.cos(a), r * np.sin(a)) for r, a in zip([0.8, 2.0] * 5, np.pi / 5 * np.arange(10))]
AREAS = {"square": (SQUARE, 1.0), "L": (L_SHAPE, 4.0), "star": (STAR, 5 * 2.0 * 0.8 * np.sin(np.pi / 5))}


def volume(surface):
    """Volume by the divergence theorem, positive if the normals point outwards: sum of r1 . (r2 x r3)/6."""
    triangles = np.vstack([surface.triangles, surface.quads[:, [0, 1, 2]], surface.quads[:, [0, 2, 3]]])
    a, b, c = surface.points[triangles].transpose(1, 0, 2)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize("name", AREAS)
@pytest.mark.parametrize("way", [1, -1])
def test_extrusion_is_closed_and_faces_outwards(name, axis, way):
    outline, area = AREAS[name]
    shape = fmb.Extrusion(outline=outline[::way], depth=(0.7, -0.1), axis=axis)
    surface = shape_surface(shape)
    assert volume(surface) == pytest.approx(0.8 * area, rel=MACHINE)
    assert len(surface.triangles) == 2 * (len(outline) - 2)
    k = "xyz".index(axis)
    assert np.ptp(surface.points[:, k]) == pytest.approx(0.8)


def test_box_and_tube():
    assert volume(shape_surface(fmb.Box(size=(1, 2, 3), at=(5, 0, 0)))) == pytest.approx(6.0)
    sides = 24  # a prism: the area of a regular polygon
    area = 0.5 * sides * np.sin(2 * np.pi / sides) * 0.1**2
    assert volume(shape_surface(fmb.Tube(start=(1, 0, 0), end=(1, 0, 2), radius=0.1))) == pytest.approx(2 * area)


def test_ball():
    """Between the inscribed polyhedron and the ball."""
    assert 0.95 < volume(shape_surface(fmb.Ball(radius=0.2, at=(3, 0, 0)))) / (4.0 / 3.0 * np.pi * 0.2**3) < 1.0


SOLIDS = {
    "wheel": (fmb.RigidBody.cylinder, {"radius": 0.3, "length": 0.15}, (0.6, 0.6, 0.15), (0.0, 0.3, 0.0)),
    "brick": (fmb.RigidBody.box, {"size": (0.2, 0.3, 0.1)}, (0.2, 0.3, 0.1), (0.1, 0.15, -0.05)),
    "ball": (fmb.RigidBody.sphere, {"radius": 0.1}, (0.2, 0.2, 0.2), (0.0, 0.0, 0.1)),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_look_as_they_are_made(name):
    """With a marker on the surface too; a marker outside is shown by a bar, as of a body without a shape."""
    make, sizes, extent, on_it = SOLIDS[name]
    for markers in ({}, {"on": on_it}):
        body = make(name, density=500.0, markers=markers, **sizes)
        (part,) = (p for p in drawn_parts(fmb.Model(bodies=[fmb.Ground(), body]), 1.0) if p.name == name)
        np.testing.assert_allclose(np.ptp(part.points, axis=0), extent, rtol=0.01)
    assert make(name, density=500.0, markers={"far": (0, 0, 2)}, **sizes).shape == ()
    own = fmb.Box(size=(1, 1, 1))
    assert make(name, density=500.0, shape=own, **sizes).shape == (own,)


def test_what_a_surface_shows_is_not_drawn_twice():
    ball = fmb.RigidBody.sphere("ball", radius=0.1, density=500.0)
    for radius, times in ((0.1, 1), (0.3, 2)):
        surface = fmb.Surface("skin", marker="ball.center", shape=fmb.Sphere(radius))
        model = fmb.Model(bodies=[fmb.Ground(), ball], surfaces=[surface])
        assert sum(p.name in ("ball", "skin") for p in drawn_parts(model, 1.0)) == times


@pytest.fixture
def model():
    house = fmb.Box(size=(1, 1, 1), at=(3, 0, 0), on="A")
    ground = fmb.Ground(markers={"A": fmb.Pose((0, 0, 1), (0, 0, np.pi / 2))}, shape=house)
    wing = fmb.RigidBody(
        "wing",
        mass=1,
        inertia=(1, 1, 1),
        at=(0, 0, 1),
        velocity=(0, 0, 2),
        shape=[fmb.Extrusion(outline=SQUARE, depth=(0, 1)), fmb.Box(size=(1, 1, 1))],
    )
    return fmb.Model(bodies=[ground, wing])


def test_a_scene_draws_them(model):
    scene = Scene(fmb.simulate(model, 0.5, samples=2))
    assert {part.name for part in scene.parts} == {"ground", "wing"}
    still = scene.snapshot(scene.part("ground"), 1).points
    np.testing.assert_allclose([still.min(0), still.max(0)], [(-0.5, 2.5, 0.5), (0.5, 3.5, 1.5)], atol=1e-12)
    moved = scene.snapshot(scene.part("wing"), 1).points
    np.testing.assert_allclose([moved.min(0), moved.max(0)], [(-0.5, -0.5, 1.5), (1, 1, 3)], atol=1e-9)


def test_a_contact_is_no_coil(model):
    """Along an axis, markers are not where the shapes touch: nothing is drawn between them, and no foot under them."""
    law = {"markers": ("ground.A", "wing.center"), "stiffness": 1e3}
    line, contact = (fmb.OneSidedSpring("roller", **law), fmb.OneSidedSpring("roller", **law, along="z"))
    parts = [
        {part.name for part in Scene(fmb.simulate(model.with_parts(forces=[force]), 0.01, samples=2)).parts}
        for force in (line, contact)
    ]
    assert parts[0] == {"ground", "wing", "supports", "springs"}
    assert parts[1] == {"ground", "wing"}


def test_they_survive_files_and_placing(model):
    twin = io.read_model_text(io.model_text(model))
    assert [type(s).__name__ for s in twin.body("wing").shape] == ["Extrusion", "Box"]
    assert twin.body("ground").shape[0].on == "A"
    pair = model.placed("left", at=(0, 1, 0)) + model.placed("right", at=(0, -1, 0))
    assert [shape.on for shape in pair.body("ground").shape] == ["left_A", "right_A"]
    assert len(pair.body("right_wing").shape) == 2


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: fmb.Box(size=(1, 0, 1)), "three positive lengths"),
        (lambda: fmb.Tube(start=(0, 0, 0), end=(0, 0, 0), radius=1), "two different ends"),
        (lambda: fmb.Tube(start=(0, 0, 0), end=(0, 0, 1), radius=0), "positive radius"),
        (lambda: fmb.Extrusion(outline=[(0, 0), (1, 0)], depth=(0, 1)), "three or more corners"),
        (lambda: fmb.Extrusion(outline=SQUARE, depth=(1, 1)), "two different numbers"),
        (lambda: fmb.Extrusion(outline=SQUARE, depth=(0, 1), axis="u"), "axis = 'u'"),
        (lambda: fmb.Ground(shape="house"), "one or more of Ball, Box, Extrusion, Tube"),
        (lambda: fmb.Ground(shape=fmb.Box(size=(1, 1, 1), on="roof")), "a shape on the marker 'roof'"),
    ],
)
def test_messages(make, message):
    with pytest.raises(ModelError, match=message):
        make()


def test_a_half_space_is_drawn_larger_than_what_stands_on_it():
    """Of a model without extent but for its surfaces, too: a box of 0.2 m hid a floor of 0.1 m."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody.box("box", density=1700.0, size=(0.2, 0.1, 0.06), at=(0, 0, 0.03))],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            fmb.Surface("sides", marker="box.center", shape=fmb.Cuboid(size=(0.2, 0.1, 0.06))),
        ],
    )
    drawn = {part.name: np.ptp(part.points, axis=0) for part in drawn_parts(model, 0.05)}
    assert np.all(drawn["floor"][:2] > 1.5 * drawn["sides"].max())
