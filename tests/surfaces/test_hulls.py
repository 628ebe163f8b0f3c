"""Planes between convex solids and edges that cross, beside the distances and normals of coal (GJK and EPA)."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.surfaces.edge_pairs import find_corners, find_crossings
from flexmb.surfaces.edges import edges_of_solid, packed_edges
from flexmb.surfaces.hull_pairs import find_between_hulls, have_faces, plane_between_hulls
from flexmb.surfaces.records import CONTACT


def random_hull(rng):
    return fmb.Hull(points=rng.normal(size=(rng.integers(4, 20), 3)) * rng.uniform(0.3, 1.0, 3))


def of_coal(coal, hull):
    vertices, triangles = hull.drawing()
    points, cells = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for point in vertices:
        points.append(point)
    for cell in triangles:
        cells.append(coal.Triangle(*map(int, cell)))
    return coal.Convex(points, cells)


def pair(rng):
    """Return two hulls with the pose of the second one."""
    first, second = random_hull(rng), random_hull(rng)
    return (
        first,
        second,
        rng.normal(size=3) * rng.uniform(0.5, 2.5),
        Rotation.from_rotvec(rng.normal(size=3)).as_matrix(),
    )


def distance_by_coal(coal, first, second, d, Q):
    """Return distance, or negative depth, and the normal from the first to the second."""
    result = coal.DistanceResult()
    poses = coal.Transform3s(), coal.Transform3s(Q, d)
    hulls = of_coal(coal, first), of_coal(coal, second)
    found = coal.distance(hulls[0], poses[0], hulls[1], poses[1], coal.DistanceRequest(), result)
    return found, np.array(result.normal)


@pytest.mark.parametrize("count", [150, pytest.param(10_000, marks=pytest.mark.slow)])
def test_planes_between_hulls_of_another_library(rng, count):
    """The gap is at most coal's distance, equal to it where a face or two edges are nearest, and equal to its depth
    where hulls overlap; so are the normals. The deepest point has this gap, and none is deeper.
    """
    coal = pytest.importorskip("coal")
    contacts, n, kinds = np.zeros(200, CONTACT), np.empty(3), np.zeros(3, int)
    apart, deep, equal = 0, 0, 0
    for _ in range(count):
        first, second, d, Q = pair(rng)
        own = packed_edges(first.edges)
        data, other = np.concatenate([own, packed_edges(second.edges)]), len(own)
        gap, kind, _, _ = plane_between_hulls(data, 0, other, 1e-9, np.inf, d, Q, n)
        kinds[kind] += 1
        expected, normal = distance_by_coal(coal, first, second, d, Q)
        if gap > 0.0:
            apart += 1
            assert gap <= expected + 1e-6
            if abs(gap - expected) < 1e-7:
                equal += 1
                assert n == pytest.approx(normal, abs=2e-3)
            continue
        deep += 1
        assert gap == pytest.approx(expected, abs=1e-9)
        assert n == pytest.approx(normal, abs=1e-6)
        found = contacts[: find_between_hulls(data, 0, other, 1e-9, 0.0, d, Q, contacts)]
        assert found["gap"].min() == pytest.approx(gap, abs=1e-9)
    assert min(apart, deep) > 0.2 * count
    assert equal > 0.2 * count
    assert kinds.min() > 0.1 * count


@pytest.mark.parametrize("count", [150, pytest.param(10_000, marks=pytest.mark.slow)])
def test_corners_and_edges_beside_another_library(rng, count):
    """As meshes that are not convex are looked at: of hulls that are apart the least gap of corners and edges is the
    distance; where it is between edges there is no other way to see it.
    """
    coal = pytest.importorskip("coal")
    contacts, by_edges, apart = np.zeros(2000, CONTACT), 0, 0
    for _ in range(count):
        first, second, d, Q = pair(rng)
        expected, normal = distance_by_coal(coal, first, second, d, Q)
        if not expected > 1e-3:
            continue
        apart += 1
        surfaces = [fmb.Surface(name, marker="b.m", shape=s) for name, s in (("a", first), ("b", second))]
        data, at = np.concatenate([s.packed for s in surfaces]), len(surfaces[0].packed)
        edges, other = np.concatenate([packed_edges(s.shape.edges) for s in surfaces]), len(packed_edges(first.edges))
        least = contacts[: find_corners(edges, 0, other, data, 0, at, np.inf, d, Q, contacts)]["gap"].min()
        if find_crossings(edges, 0, other, data, 0, at, np.inf, True, d, Q, contacts, 0) and contacts[0]["gap"] < least:
            by_edges += 1
            least = contacts[0]["gap"]
            assert contacts[0]["n"] == pytest.approx(normal, abs=2e-3)
        assert least == pytest.approx(expected, abs=1e-6)
    assert by_edges > 0.2 * apart > 0.05 * count


def angle_bracket():
    """Return vertices and triangles of an L of 1 m thickness."""
    outline = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], float)
    vertices = np.vstack([np.column_stack([outline, np.full(6, z)]) for z in (0.0, 1.0)])
    cap = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])
    sides = [t for k in range(6) for m in [(k + 1) % 6] for t in ((k, m, m + 6), (k, m + 6, k + 6))]
    return vertices, np.vstack([cap[:, ::-1], cap + 6, sides])


@pytest.mark.parametrize("tilt", [0.0, 0.2, 0.5, 1.0, -1.0])
def test_a_tilted_knife_cuts_the_rims_of_a_face(tilt):
    """A blade of 0.5 rad, longer than an L is wide, touches both rims; their nearest points are beside it."""
    wide = 0.5 * np.tan(0.25)
    knife = np.array([(x, y, z) for y in (-1, 1.5) for x, z in ((0, 0), (wide, 0.5), (-wide, 0.5))])
    surfaces = [
        fmb.Surface("a", marker="x.y", shape=fmb.TriangleMesh(*angle_bracket())),
        fmb.Surface("b", marker="x.y", shape=fmb.Hull(points=knife)),
    ]
    data, at = np.concatenate([s.packed for s in surfaces]), len(surfaces[0].packed)
    edges = [s.packed_edges for s in surfaces]
    turn, contacts, depth = Rotation.from_rotvec((0, tilt, 0)).as_matrix(), np.zeros(100, CONTACT), 1e-4
    d = np.array((1.5, 0.0, 1.0 - depth))
    count = find_crossings(np.concatenate(edges), 0, len(edges[0]), data, 0, at, 1e-3, False, d, turn, contacts, 0)
    assert sorted(contacts["x"][:count, 1]) == pytest.approx([0.0, 1.0], abs=1e-12)
    assert contacts["gap"][:count] == pytest.approx(np.full(2, -depth), rel=1e-9)
    assert contacts["n"][:count] == pytest.approx(np.tile((0.0, 0.0, 1.0), (2, 1)), abs=1e-12)


def test_contacts_that_fill_their_room_stay_as_they_are(rng):
    """What is looked at and is none is not left in the place of the last one."""
    surface = fmb.Surface("a", marker="x.y", shape=fmb.TriangleMesh(*angle_bracket()))
    data, edges = np.tile(surface.packed, 2), np.tile(surface.packed_edges, 2)
    at, other, filled = len(surface.packed), len(surface.packed_edges), 0
    for _ in range(900):
        d, Q, found = 1.5 * rng.normal(size=3), Rotation.from_rotvec(rng.normal(size=3)).as_matrix(), []
        for room in (200, None):  # more than enough, and just enough
            contacts = np.zeros(room or max(1, len(found[0])), CONTACT)
            count = find_corners(edges, 0, other, data, 0, at, 0.01, d, Q, contacts)
            count = find_crossings(edges, 0, other, data, 0, at, 0.01, False, d, Q, contacts, count)
            found.append(contacts[:count])
        assert count >= len(found[0])  # or more is asked for
        if 0 < count == len(contacts):
            filled += 1
            np.testing.assert_array_equal(*found)
    assert filled > 4


def test_faces_and_edges_of_solids():
    """A cube of triangles has 12 edges and 6 faces; of an L 17 edges stand out and one does not."""
    cube = fmb.Hull(points=fmb.Cuboid(size=(1, 1, 1)).drawing()[0]).edges
    assert len(cube.lines) == 12
    assert sorted(map(len, cube.outlines)) == [4] * 6
    bracket = edges_of_solid(*angle_bracket(), 1.0, False)
    assert len(bracket.lines) == 17
    assert not len(bracket.outlines)
    inner = np.all(np.isclose(bracket.lines[:, [0, 1, 3, 4]], 1.0), axis=1)
    assert not inner.any()


def test_round_solids_are_not_looked_at_face_by_face():
    """Of two balls of 320 triangles there are 230 400 pairs of edges."""
    rng = np.random.default_rng(1)
    points = rng.normal(size=(200, 3))
    ball = packed_edges(fmb.Hull(points=points / np.linalg.norm(points, axis=1, keepdims=True)).edges)
    cube = packed_edges(fmb.Cuboid(size=(1, 1, 1)).edges)
    assert have_faces(np.concatenate([ball, cube]), 0, len(ball))
    assert not have_faces(np.concatenate([ball, ball]), 0, len(ball))
