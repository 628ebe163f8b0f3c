"""Closed meshes that pass through themselves, and shells within shells, are named; ipctk is the judge of crossings."""

import numpy as np
import pytest
from surfaces.bodies_of_triangles import ball, box

import flexmb as fmb
from flexmb.integrate.oversights import oversights
from flexmb.surfaces.mesh_crossings import crossings, shells_of


def together(*meshes):
    """Return meshes as one, without joining their vertices."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    vertices = np.concatenate([vertices for vertices, _ in meshes])
    return vertices, np.concatenate([triangles + at for (_, triangles), at in zip(meshes, starts)])


def moved(mesh, shift, size=1.0):
    return size * mesh[0] + shift, mesh[1]


CUBE = box((1, 1, 1))


@pytest.mark.parametrize(
    ("meshes", "said"),
    [
        ((CUBE, moved(CUBE, 0.5)), "passes through or touches itself: 18 pair"),
        ((box((3, 1, 1)), box((1, 3, 0.8))), "passes through or touches itself"),
        ((CUBE, moved(CUBE, 0.0, 0.5)), "1 of the 2 closed shells of its mesh lie within another"),
        ((CUBE, moved(CUBE, 1.5)), ""),
        ((CUBE, (0.5 * CUBE[0], CUBE[1][:, ::-1])), ""),
        ((CUBE, moved(CUBE, (0.13, 0.21, 1.0))), "passes through or touches itself"),
    ],
    ids=("crossing", "bars", "solid in solid", "apart", "cavity", "on it"),
)
def test_what_distances_of_a_mesh_cannot_tell(meshes, said):
    doubt = fmb.TriangleMesh(*together(*meshes)).doubt
    assert said in doubt
    assert bool(said) == bool(doubt)


@pytest.mark.parametrize(
    ("shift", "size", "doubled"),
    [
        ((0.13, 0.21, 1.0), 1.0, 0),
        ((0.13, 0.21, 0.75), 0.5, 0),
        ((0.03, 0.07, 0.25), 0.5, 1),
        ((0.1, 0.1, 0.1), 0.5, 1),
    ],
    ids=("beside", "small beside", "within, at a face", "within"),
)
def test_what_stands_on_a_solid_is_not_within_it(shift, size, doubled):
    assert len(shells_of(*together(CUBE, moved(CUBE, shift, size))).doubled) == doubled


def test_a_shell_turned_inside_out_is_refused():
    """Its volume is hidden in the sum, which is that of a solid."""
    small, triangles = moved(CUBE, 2.0, 0.5)
    with pytest.raises(fmb.MeshError, match=r"1 of 2 closed shells turned inside out.* -0\.125 m3"):
        fmb.TriangleMesh(*together(CUBE, (small, triangles[:, ::-1])))


def test_checks_say_it():
    mesh = fmb.TriangleMesh(*together(CUBE, moved(CUBE, 0.5)))
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1))],
        surfaces=[fmb.Surface("s", marker="b.center", shape=mesh)],
    )
    assert any("Surface 's'" in text and "passes through or touches itself" in text for text in oversights(model))


def ball_on_floor(surfaces, forces):
    law = fmb.Hertz(stiffness=1e6)
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1), at=(0, 0, 0.1))],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            *[fmb.Surface(name, marker="b.center", shape=fmb.Sphere(radius)) for name, radius in surfaces],
        ],
        forces=[fmb.SurfaceContact(name, surfaces=pair, law=law) for name, pair in forces],
        gravity=(0, 0, -9.81),
    )


def test_what_presses_twice_is_named():
    """Each would be twice as stiff as its law says."""
    same = ball_on_floor([("x", 0.1), ("y", 0.1)], [("c", ("floor", ("x", "y")))])
    assert any("surfaces 'x' and 'y' are the same" in text for text in oversights(same))
    both = ball_on_floor([("x", 0.1)], [("c", ("floor", "x")), ("d", ("x", "floor"))])
    assert any("Force 'c' and Force 'd' both join surfaces 'x' and 'floor'" in text for text in oversights(both))
    right = ball_on_floor([("x", 0.1), ("y", 0.05)], [("c", ("floor", "x")), ("d", ("y", "floor"))])
    assert not any("surface" in text for text in oversights(right))


def test_crossings_of_another_library(rng):
    """Balls with corners that are pulled through the other side, or not so far."""
    ipctk = pytest.importorskip("ipctk")
    vertices, triangles = ball(1)
    edges, found = ipctk.edges(triangles), 0
    for _ in range(400):
        pulled = vertices.copy()
        pulled[rng.integers(len(vertices))] *= rng.uniform(-1.5, 1.5)
        pulled[rng.integers(len(vertices))] += rng.normal(size=3) * 0.3
        expected = ipctk.has_intersections(ipctk.CollisionMesh(pulled, edges, triangles), pulled)
        assert (crossings(pulled, triangles)[0] > 0) == expected
        found += expected
    assert 50 < found < 350
