"""Meshes as surfaces: distances against closed forms and another library, what is refused, mutants."""

from itertools import product

import numpy as np
import pytest
from surfaces.bodies_of_triangles import ball, box

import flexmb as fmb
from flexmb.errors import FlexmbError
from flexmb.surfaces.distances import signed_distance


def distance(surface, z, within=np.inf):
    n, H = np.empty(3), np.empty((3, 3))
    return signed_distance(surface.packed, 0, np.asarray(z, float), within, n, H), n, H


def surface(shape, **more):
    return fmb.Surface("s", marker="b.m", shape=shape, **more)


def test_a_box_of_triangles_is_a_cuboid(rng):
    """Distance, gradient and second derivative at points outside and inside, where they are unique."""
    size = (0.9, 1.3, 0.6)
    mesh, cuboid = surface(fmb.TriangleMesh(*box(size))), surface(fmb.Cuboid(size=size))
    for z in rng.normal(size=(2000, 3)):
        expected, n, H = distance(cuboid, z)
        inside = np.sort(np.abs(np.abs(z) - 0.5 * np.array(size)))[:2] @ (-1, 1)
        if expected < 0.0 and inside < 1e-3:
            continue  # two faces are nearest
        found = distance(mesh, z)
        assert found[0] == pytest.approx(expected, abs=1e-12)
        np.testing.assert_allclose(found[1], n, atol=1e-10)
        np.testing.assert_allclose(found[2], H, atol=1e-9 * (1.0 + np.abs(H).max()))
        assert distance(mesh, z, abs(expected))[0] == pytest.approx(expected, abs=1e-12)


def test_the_sign_at_inward_corners(rng):
    """An L of two boxes: outside and inside by its definition, near edges and corners too."""
    outline = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], float)
    vertices = np.concatenate([np.column_stack([outline, np.full(6, h)]) for h in (0.0, 1.0)])
    top = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    triangles = [(6 + a, 6 + b, 6 + c) for a, b, c in top] + [(a, c, b) for a, b, c in top]
    for k in range(6):
        m = (k + 1) % 6
        triangles += [(k, m, 6 + m), (k, 6 + m, 6 + k)]
    mesh = surface(fmb.TriangleMesh(vertices, triangles))
    for z in rng.uniform((-0.5, -0.5, -0.5), (2.5, 2.5, 1.5), size=(3000, 3)):
        x, y, h = z
        inside = 0 < h < 1 and ((0 < x < 2 and 0 < y < 1) or (0 < x < 1 and 0 < y < 2))
        assert (distance(mesh, z)[0] < 0.0) == inside


@pytest.mark.parametrize("count", [400, pytest.param(10_000, marks=pytest.mark.slow)])
def test_distances_of_another_library(rng, count):
    """Points outside a bumpy ball of 5120 triangles against those of coal."""
    coal = pytest.importorskip("coal")
    vertices, triangles = ball(4, bumps=0.3)
    mesh = surface(fmb.TriangleMesh(vertices, triangles))
    other = coal.BVHModelOBBRSS()
    other.beginModel(len(triangles), len(vertices))
    places, corners = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for v in vertices:
        places.append(v)
    for t in triangles:
        corners.append(coal.Triangle(*(int(k) for k in t)))
    other.addSubModel(places, corners)
    other.endModel()
    point = coal.Sphere(1e-6)
    examined = 0
    for z in rng.normal(size=(count, 3)) * 1.5:
        found = distance(mesh, z)[0]
        if found < 1e-3:
            continue
        result = coal.DistanceResult()
        expected = coal.distance(
            other, coal.Transform3s(), point, coal.Transform3s(np.eye(3), z), coal.DistanceRequest(), result
        )
        assert found == pytest.approx(expected + 1e-6, abs=1e-8)
        examined += 1
    assert examined > 0.5 * count


def test_hull_of_points(rng):
    """The hull of the corners of a box and points inside is the box."""
    size = np.array((0.9, 1.3, 0.6))
    points = np.concatenate([0.5 * size * np.array(list(product((-1, 1), repeat=3))), rng.uniform(-0.2, 0.2, (30, 3))])
    hull, cuboid = surface(fmb.Hull(points)), surface(fmb.Cuboid(size=tuple(size)))
    assert len(hull.shape.corners()[0]) == 8
    for z in rng.normal(size=(300, 3)):
        assert distance(hull, z)[0] == pytest.approx(distance(cuboid, z)[0], abs=1e-12)


def test_samples_of_a_mesh():
    """Centres of the triangles, divided down to the spacing, with areas of the box."""
    for spacing in (10.0, 0.05):
        places, normals, areas = fmb.TriangleMesh(*box((0.9, 1.3, 0.6))).samples(spacing)
        assert areas.sum() == pytest.approx(2 * (0.9 * 1.3 + 0.9 * 0.6 + 1.3 * 0.6), rel=1e-12)
        assert np.abs(np.einsum("ij,ij->i", places, normals) - np.abs(normals) @ (0.45, 0.65, 0.3)).max() < 1e-12
    assert len(areas) > 12 * 100


def test_forces_do_not_depend_on_the_order_of_the_mesh(rng):
    """A ball of triangles in a layer, its vertices and triangles shuffled, and turned in their corners."""
    vertices, triangles = ball(3)
    found = []
    for shuffled in (False, True):
        if shuffled:
            order = rng.permutation(len(vertices))
            triangles = np.argsort(order)[triangles][rng.permutation(len(triangles))]
            triangles = np.array([np.roll(t, rng.integers(3)) for t in triangles])
            vertices = vertices[order]
        found.append(pressed(fmb.TriangleMesh(vertices, triangles), 0.05, 0.02))
    np.testing.assert_allclose(found[0], found[1], atol=1e-9 * np.abs(found[0]).max())


def pressed(shape, depth, spacing):
    """Return the wrench on a body of radius 1 pressed into a layer."""
    from flexmb.system import compile
    from flexmb.system.program import evaluate

    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"o": (0, 0, 0)}),
            fmb.RigidBody("b", mass=1, inertia=(1, 1, 1), at=(0, 0, 1.0 - depth), rotation=(0.3, 0.2, 0.1)),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.o", shape=fmb.Plane()),
            fmb.Surface("ball", marker="b.center", shape=shape, spacing=spacing),
        ],
        forces=[
            fmb.SurfaceContact("f", surfaces=("floor", "ball"), law=fmb.ElasticFoundation(modulus=1e6, thickness=1))
        ],
    )
    system = compile(model)
    work = system.workspace()
    evaluate(system.program, system.state(), work)
    return work.markers["wrench"][system.marker_index["b.center"]]


def test_a_mesh_in_a_layer():
    """pi K/h R d^2 of a ball of 20480 triangles, whose vertices lie on it and their centres 4e-4 R deeper."""
    assert pressed(fmb.TriangleMesh(*ball(5)), 0.05, 10.0)[2] == pytest.approx(np.pi * 1e6 * 0.05**2, rel=2e-2)


def test_files(tmp_path):
    """STL (its vertices three times), OBJ and PLY in mm are one surface; a model file names one relative to itself."""
    meshio = pytest.importorskip("meshio")
    vertices, triangles = box((0.9, 1.3, 0.6))
    for name in ("a.stl", "a.obj", "a.ply"):
        meshio.write(tmp_path / name, meshio.Mesh(1e3 * vertices, [("triangle", triangles)]))
        shape = fmb.TriangleMesh(file=tmp_path / name, scale=1e-3)
        assert distance(surface(shape), (2.0, 0.1, 0.1))[0] == pytest.approx(1.55, abs=1e-6)
    (tmp_path / "m.toml").write_text(
        '[[body]]\nkind = "Ground"\nmarkers = { o = [0, 0, 0] }\n[[surface]]\nkind = "Surface"\nname = "s"\n'
        'marker = "ground.o"\nshape = { kind = "TriangleMesh", file = "a.stl", scale = 1e-3 }\n'
    )
    model = fmb.load_model(tmp_path / "m.toml")
    assert distance(model.surface("s"), (2.0, 0.1, 0.1))[0] == pytest.approx(1.55, abs=1e-6)
    fmb.save_model(model, tmp_path / "again.toml")
    assert fmb.load_model(tmp_path / "again.toml").surface("s").shape.scale == 1e-3
    assert 'file = "a.stl"' in (tmp_path / "again.toml").read_text()
    (tmp_path / "models").mkdir()
    fmb.save_model(model, tmp_path / "models" / "m.toml")
    assert 'file = "../a.stl"' in (tmp_path / "models" / "m.toml").read_text()
    moved = tmp_path.rename(tmp_path.with_name("elsewhere"))
    assert fmb.load_model(moved / "models" / "m.toml").surface("s").shape.scale == 1e-3
    moved.rename(tmp_path)


def without(k):
    vertices, triangles = box((1, 1, 1))
    return vertices, np.delete(triangles, k, axis=0)


def flipped(*k):
    vertices, triangles = box((1, 1, 1))
    triangles = triangles.copy()
    triangles[list(k)] = triangles[list(k)][:, ::-1]
    return vertices, triangles


def moved(k, to):
    vertices, triangles = box((1, 1, 1))
    vertices = vertices.copy()
    vertices[k] = to
    return vertices, triangles


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (without(3), r"3 edge\(s\) of one triangle only.*open"),
        (flipped(*range(12)), "a volume of -1 m3"),
        (flipped(2), "neighbours of opposite sense at 3 edge"),
        (moved(0, (np.nan, 0, 0)), "vertex 0 at"),
        (moved(0, (-0.5, -0.5, 0.5)), "without area"),
        ((box((1, 1, 1))[0], np.concatenate([box((1, 1, 1))[1], [(0, 1, 2)]])), "more than two triangles|one triangle"),
        ((box((1, 1, 1))[0], box((1, 1, 1))[1] + 1), "a triangle of the vertices 1 to 8"),
        ((np.zeros((8, 2)), box((1, 1, 1))[1]), r"vertices of the shape \(8, 2\)"),
        ((np.zeros((8, 3)), box((1, 1, 1))[1]), "all vertices at one place"),
        (box((1, 1, 2e-10)), "it has no thickness|without area"),
        (
            (((0, 0, 0), (1, 0, 0), (0, 1, 0), (0.3, 0.3, 2e-9)), ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))),
            "thickness",
        ),
    ],
)
def test_meshes_that_are_refused(given, said):
    with pytest.raises(fmb.MeshError, match=said):
        fmb.TriangleMesh(*given)


def test_other_messages(tmp_path):
    with pytest.raises(fmb.ModelError, match="neither a file nor vertices"):
        fmb.TriangleMesh()
    with pytest.raises(fmb.MeshError, match="no such file"):
        fmb.TriangleMesh(file=tmp_path / "none.stl")
    with pytest.raises(fmb.MeshError, match="do not lie in a plane"):
        fmb.Hull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])
    (tmp_path / "bad.stl").write_text("solid x\n facet\n")
    with pytest.raises(FlexmbError):
        fmb.TriangleMesh(file=tmp_path / "bad.stl")


def mutants(rng, count):
    """Damage meshes at random: what is made must tell distances, all else an error of ours."""
    made = 0
    for _ in range(count):
        vertices, triangles = (array.copy() for array in (box((1, 2, 3)) if rng.random() < 0.5 else ball(1)))
        for _ in range(rng.integers(1, 4)):
            kind, k, v = rng.integers(7), rng.integers(len(triangles)), rng.integers(len(vertices))
            if kind == 0:
                vertices[v, rng.integers(3)] = rng.choice([np.nan, np.inf, 1e300, -1e17, 0.0, 1e-300])
            elif kind == 1:
                vertices[v] += rng.normal(size=3) * 10.0 ** rng.uniform(-14, 2)
            elif kind == 2:
                triangles[k, rng.integers(3)] = rng.integers(-2, len(vertices) + 2)
            elif kind == 3:
                triangles = np.delete(triangles, k, axis=0)
            elif kind == 4:
                triangles[k] = triangles[k][::-1]
            elif kind == 5:
                triangles = np.concatenate([triangles, triangles[k : k + 1]])
            else:
                vertices[v] = vertices[rng.integers(len(vertices))]
        try:
            own = surface(fmb.TriangleMesh(vertices, triangles), spacing=1.0)
        except FlexmbError:
            continue
        made += 1
        for z in (*rng.normal(size=(3, 3)), vertices[0]):
            gap, n, H = distance(own, z)
            assert np.isfinite(gap)
            assert np.all(np.isfinite(n))
            assert np.all(np.isfinite(H))
    return made


def test_mutants(rng):
    assert mutants(rng, 300) > 10


@pytest.mark.slow
def test_ten_thousand_mutants(rng):
    assert mutants(rng, 10_000) > 300


def test_no_sample_is_left_out(rng):
    """The tree finds the samples that a loop over all of them finds, on convex and other surfaces, and the nearest."""
    from flexmb.surfaces.detection import find_areas, nearest_sample
    from flexmb.surfaces.records import CONTACT

    bumpy, hull = fmb.TriangleMesh(*ball(3, bumps=0.3)), fmb.Hull(rng.normal(size=(30, 3)))
    assert hull.convex
    assert not bumpy.convex
    for first, second in ((bumpy, hull), (hull, bumpy), (hull, hull)):
        one, two = (surface(shape, spacing=0.2) for shape in (first, second))
        data = np.concatenate([one.packed, two.packed])
        for _ in range(4):
            Q, d = np.linalg.qr(rng.normal(size=(3, 3)))[0], 0.5 * rng.normal(size=3)
            Q *= np.linalg.det(Q)
            found = np.zeros(len(one.points[0]) + len(two.points[0]) + 2, CONTACT)
            count = find_areas(data, 0, len(one.packed), 0.0, d, Q, found)
            of_b = np.array([distance(one, d + Q @ y)[0] for y in two.points[0]])
            of_a = np.array([distance(two, Q.T @ (y - d))[0] for y in one.points[0]])
            gaps = np.sort(found[:count]["gap"])
            every = np.sort(np.concatenate([of_a, of_b]))
            assert count > 20
            assert np.all(np.isin(np.round(gaps, 9), np.round(every[every < 0.0], 9)))
            # those that face away count nothing and are left out
            n_b = np.array([Q @ m @ distance(one, d + Q @ y)[1] for y, m in zip(two.points[0], two.points[1])])
            n_a = np.array([Q @ distance(two, Q.T @ (y - d))[1] @ m for y, m in zip(one.points[0], one.points[1])])
            assert count == np.sum((of_b < 0.0) & (n_b < 0.0)) + np.sum((of_a < 0.0) & (n_a < 0.0))
            nearest_sample(data, 0, len(one.packed), np.inf, d, Q, found)
            assert found[0]["gap"] == pytest.approx(every[0], abs=1e-12)


PLY = """ply
format ascii 1.0
element vertex 4
property double x
property double y
property double z
element face 2
property list uint8 int32 vertex_indices
end_header
0 0 0
1 0 0
0 1 0
0 0 1
"""


@pytest.mark.parametrize(
    ("head", "message"),
    [
        ("ply\nformat ascii 1.0\nelement vertex 4\n", "its header has no end"),
        ("ply\nformat ascii 1.0\nelement vertex 400000000\nproperty float x\nend_header\n", "more than it holds"),
        ("ply\nformat ascii 1.0\nelement nonsense\nend_header\n", "cannot be read"),
    ],
)
def test_damaged_headers(tmp_path, head, message):
    """meshio looks for their end for ever, or ends the process."""
    (tmp_path / "solid.ply").write_text(head)
    with pytest.raises(fmb.MeshError, match=message):
        fmb.TriangleMesh(file=tmp_path / "solid.ply")


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("solid.off", "OFF", "no line of counts"),
        ("solid.off", "OFF\n# 4 4 6\n\n", "no line of counts"),
        ("solid.off", "OFF\n400000000 1 0\n", "more than it holds"),
        ("solid.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 " + "9" * 400 + "\n", "not numbers"),
        ("solid.ply", PLY + "3   2 4\n3 0 1 2\n", "'triangle' with"),
        ("solid.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "corners of cells.* 8. Expected: .* from 0 to 2"),
        ("solid.obj", "v 0 0 0 1 0\nv 1 0 0 1 0\nv 0 1 0 1 0\nf 1 2 3\n", r"points of the shape \(3, 5\)"),
    ],
)
def test_damaged_texts_of_surfaces(tmp_path, name, text, said):
    """An OFF file without counts was read for ever; numbers beyond 64 bits ended as an overflow."""
    pytest.importorskip("meshio")
    (tmp_path / name).write_text(text)
    with pytest.raises(fmb.MeshError, match=said):
        fmb.TriangleMesh(file=tmp_path / name)


def test_a_file_of_text_is_read_without_a_word(tmp_path, recwarn):
    """Its first letters, read as the number of triangles of a binary file, are more than 32 bits hold bytes of."""
    points, triangles = box((1.0, 1.0, 1.0))
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in np.asarray(points, float)[row].tolist())
        + "endloop\nendfacet\n"
        for row in triangles
    )
    (tmp_path / "box.stl").write_text("solid Created by Gmsh " + "x" * 80 + "\n" + facets + "endsolid\n")
    mesh = surface(fmb.TriangleMesh(file=tmp_path / "box.stl"))
    assert distance(mesh, (0.0, 0.0, 0.75))[0] == pytest.approx(0.25)
    assert not recwarn.list
