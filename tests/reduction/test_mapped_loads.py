"""Loads of tables and of surfaces on meshes that know nothing of them: resultants, and closed forms of beams.

References: deflections of cantilevers (Roark's Formulas for Stress and Strain, table 8.1), Archimedes' principle.
"""

import numpy as np
import pytest
from reduction.solids import block
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import MeshError, ReductionError
from flexmb.reduction.load_clouds import LoadCloud
from flexmb.reduction.load_tables import MappedLoad

L = 2.0
STEEL = fmb.MATERIALS["steel"]
SECTION = fem.Section.rectangle(0.05, 0.02)
EI = STEEL.young * 0.05 * 0.02**3 / 12.0


class Given(MappedLoad):
    """A load that is given as a cloud."""

    def __init__(self, cloud, on=None, reach=100.0):
        self.given, self.on, self.reach = cloud, on, reach

    def cloud(self, spacing):
        return self.given


def beam(elements=8, bent=False):
    x = np.linspace(0.0, L, elements + 1)
    points = np.column_stack([x, 0.3 * np.sin(x) if bent else 0 * x, 0.1 * x**2 if bent else 0 * x])
    return fem.frame(points, section=SECTION, material=STEEL, orientation=(0, 1, 0), shear=False)


def plate(size=0.25):
    x, y = np.meshgrid(np.linspace(0, 2, round(2 / size) + 1), np.linspace(0, 1, round(1 / size) + 1), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), 0.2 * x.ravel() * y.ravel()])
    number = np.arange(x.size).reshape(x.shape)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    return fem.shell(fem.Mesh(points=points, cells=[("quad", quads)]), STEEL, 0.01)


def solid():
    return block(), "skin"


def resultant(fe, field):
    moment = field[:, 3:] + np.cross(fe.nodes, field[:, :3])
    return np.concatenate([field[:, :3].sum(axis=0), moment.sum(axis=0)])


def tip(fe, load, fixed=0):
    """Deflection and rotation of the last node of a cantilever, (6,)."""
    u = fe.field(fem.static(fe, load.forces(fe, "load")[:, None], [fixed]))
    return u[-1, :, 0]


@pytest.mark.parametrize("structure", ["beam", "plate", "solid"])
def test_force_and_moment_are_kept(structure, rng):
    """300 forces and moments at random points around the structure, to 1e-12."""
    fe, on = {"beam": lambda: (beam(bent=True), None), "plate": lambda: (plate(), None), "solid": solid}[structure]()
    low, high = fe.nodes.min(axis=0) - 0.1, fe.nodes.max(axis=0) + 0.1
    cloud = LoadCloud(rng.uniform(low, high, (300, 3)), rng.normal(size=(300, 3)), rng.normal(size=(300, 3)))
    found = resultant(fe, Given(cloud, on).nodal(fe, "load"))
    expected = np.concatenate(cloud.resultant())
    size = np.abs(cloud.forces).sum() * (1.0 + np.abs(high).max())
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-13 * size)
    assert np.abs(Given(cloud, on).forces(fe, "load")).max() > 0.0


def test_a_uniform_line_is_a_line_load():
    """Table of two equal stations: the nodal forces and moments of `LineLoad`, q L^4 / (8 E I) at the tip."""
    fe, q = beam(), 120.0
    table = reduction.LineTable(points=[(0, 0, 0), (L, 0, 0)], force=(0, 0, q))
    same = reduction.LineLoad(np.arange(len(fe.nodes)), (0, 0, 1)).nodal(fe, "load")
    np.testing.assert_allclose(table.nodal(fe, "load"), q * same, atol=1e-11 * q)
    assert tip(fe, table)[2] == pytest.approx(q * L**4 / (8 * EI), rel=1e-9)


def test_tapered_and_eccentric_lines():
    """Falling to zero at the tip: q0 L^4 / (30 E I). In front of the beam by e: a twist of q e L^2 / (2 G J) too.

    A line of moments about the beam does the same."""
    fe, q, e = beam(), 90.0, 0.3
    falling = reduction.LineTable(points=[(0, 0, 0), (L, 0, 0)], force=(0, 0, [q, 0.0]))
    assert tip(fe, falling)[2] == pytest.approx(q * L**4 / (30 * EI), rel=1e-6)
    twist = q * e * L**2 / (2.0 * STEEL.shear * SECTION.torsion)
    ahead = reduction.LineTable(points=[(0, e, 0), (L, e, 0)], force=(0, 0, q))
    assert tip(fe, ahead)[3] == pytest.approx(twist, rel=1e-9)
    assert tip(fe, ahead)[2] == pytest.approx(q * L**4 / (8 * EI), rel=1e-9)
    turned = reduction.LineTable(points=[(0, 0, 0), (L, 0, 0)], moment=(q * e, 0, 0))
    assert tip(fe, turned)[3] == pytest.approx(twist, rel=1e-9)


def test_a_force_inside_a_beam():
    """P at a between nodes of a cantilever: tip deflection P a^2 (3 L - a) / (6 E I), exact for cubic beams; a moment
    there: M a (2 L - a) / (2 E I)."""
    fe, a, P = beam(elements=3), 0.9, 50.0
    force = Given(LoadCloud(np.array([(a, 0, 0)]), np.array([(0, 0, P)]), np.zeros((1, 3))))
    assert tip(fe, force)[2] == pytest.approx(P * a**2 * (3 * L - a) / (6 * EI), rel=1e-9)
    moment = Given(LoadCloud(np.array([(a, 0, 0)]), np.zeros((1, 3)), np.array([(0, -P, 0)])))
    assert tip(fe, moment)[2] == pytest.approx(P * a * (2 * L - a) / (2 * EI), rel=1e-9)


def test_pressure_over_span_and_chord():
    """Force and moment of a bilinear pressure on a swept, tapered surface by fine sums; a plate under its own."""
    corners = np.array([(0, 0, 0), (2.4, 0, 0.1), (2.5, 5, 0.3), (1.0, 5, 0.2)])
    span, chord = [0.0, 0.4, 1.0], [0.0, 0.3, 0.7, 1.0]
    pressure = np.array([[500.0, 900, 300, 0], [400, 800, 250, 0], [100, 300, 50, 0]])
    table = reduction.PressureTable(corners=corners, span=span, chord=chord, pressure=pressure)
    n = 700
    v, u = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n, indexing="ij")
    from scipy.interpolate import RegularGridInterpolator

    p = RegularGridInterpolator((span, chord), pressure)(np.stack([v, u], axis=-1))
    a, b, c, d = corners
    x = (1 - u[..., None]) * ((1 - v[..., None]) * a + v[..., None] * d) + u[..., None] * (
        (1 - v[..., None]) * b + v[..., None] * c
    )
    normal = np.cross(
        (1 - v[..., None]) * (b - a) + v[..., None] * (c - d), (1 - u[..., None]) * (d - a) + u[..., None] * (c - b)
    )
    force = p[..., None] * normal / n**2
    found = table.cloud(10.0).resultant()
    np.testing.assert_allclose(found[0], force.sum(axis=(0, 1)), rtol=1e-5)
    np.testing.assert_allclose(found[1], np.cross(x, force).sum(axis=(0, 1)), rtol=1e-5, atol=1e-3)
    for spacing in (0.3, 0.02):  # however fine
        np.testing.assert_allclose(np.concatenate(table.cloud(spacing).resultant()), np.concatenate(found), rtol=1e-12)
    fe = plate()
    uniform = reduction.PressureTable(corners=fe.nodes[[0, -5, -1, 4]], span=[0], chord=[0], pressure=[[700.0]])
    u = [
        fe.field(fem.static(fe, f[:, None], np.flatnonzero(fe.nodes[:, 0] < 1e-9)))[-1, 2, 0]
        for f in (uniform.forces(fe, "p"), fem.pressure_load(fe, fe.blocks[0].connectivity, -700.0))
    ]
    assert u[0] == pytest.approx(u[1], rel=2e-3)


def test_a_flow_solvers_surface():
    """A box in water: the pressures rho g depth on its six sides push it up with the weight of the water (Archimedes).

    At its centre of volume, however the structure is meshed; on a beam inside it as on the solid."""
    size, density, g = np.array([0.4, 0.06, 0.04]), 1000.0, 9.81
    corner = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)], float) * size
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([side[:3] for side in sides] + [(side[0], side[2], side[3]) for side in sides])
    pressure = density * g * (1.0 - corner[:, 2])
    weight = density * g * np.prod(size)
    fe, on = solid()
    load = reduction.SurfacePressure(points=corner, pressure=pressure, triangles=triangles, on=on)
    expected = np.concatenate([(0, 0, weight), np.cross(size / 2.0, (0, 0, weight))])
    size_of_terms = pressure.max() * size[0] * size[1]
    np.testing.assert_allclose(resultant(fe, load.nodal(fe, "load")), expected, atol=1e-12 * size_of_terms)
    axis = np.column_stack([np.linspace(0, size[0], 5), np.full((5, 2), size[1:] / 2.0)])
    inside = fem.frame(axis, section=SECTION, material=STEEL)
    load = reduction.SurfacePressure(points=corner, pressure=pressure, triangles=triangles)
    np.testing.assert_allclose(resultant(inside, load.nodal(inside, "load")), expected, atol=1e-12 * size_of_terms)


def closed_surface(size, centre):
    """Return points (n, 3) and triangles, outward, of a convex surface in a box, pressures (n,) that vary over it, and
    force and moment about the origin of what is linear on every triangle: int r p dA = A/12 sum_ij (1 + d_ij) r_i p_j.
    """
    from scipy.spatial import ConvexHull

    points = np.random.default_rng(5).normal(size=(120, 3))
    points = points / np.linalg.norm(points, axis=1)[:, None] * np.multiply(size, 0.6) + centre
    triangles = ConvexHull(points).simplices.copy()
    corners = points[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normal, corners.mean(axis=1) - centre) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    x, y, z = ((points - centre) / size).T
    pressure = 30.0 + 200.0 * np.sin(3.0 * x) * z - 50.0 * x * y
    corners, p = points[triangles], pressure[triangles]
    area = np.linalg.norm(normal, axis=1)[:, None] / 2.0
    outward = np.where(inward[:, None], -normal, normal) / (2.0 * area)
    arm = area / 12.0 * (corners.sum(axis=1) * p.sum(axis=1)[:, None] + np.einsum("tij,ti->tj", corners, p))
    force = -(area * p.mean(axis=1)[:, None] * outward).sum(axis=0)
    return points, triangles, pressure, force, -np.cross(arm, outward).sum(axis=0)


@pytest.mark.parametrize("structure", ["beam", "plate", "solid"])
def test_the_foot_carries_what_the_flow_gives(structure, tmp_path):
    """Surface file, mapping, reduction, a body that stands askew: force and moment at its clamp."""
    import meshio

    fe, root, on = {
        "beam": lambda: (beam(bent=True), [0], None),
        "plate": lambda: (plate(), [0, 1, 2, 3, 4], None),
        "solid": lambda: (block(), "left", "skin"),
    }[structure]()
    low, high = fe.nodes.min(axis=0), fe.nodes.max(axis=0)
    size = np.maximum(high - low, 0.2 * np.linalg.norm(high - low))
    points, triangles, pressure, force, moment = closed_surface(size, (low + high) / 2.0)
    meshio.write(tmp_path / "flow.vtu", meshio.Mesh(points, [("triangle", triangles)], point_data={"p": pressure}))
    flow = reduction.SurfacePressure(**fem.read_surface(tmp_path / "flow.vtu"), on=on)
    data = reduction.reduce(
        fe, {"root": root}, modes=4, loads={"flow": flow}, residual_vectors="all", compare=0, stress=False
    )
    turn = Rotation.from_rotvec((0.4, -1.1, 0.7))
    body = fmb.FloatingBody("body", data=data, at=(1.0, 2.0, 3.0), rotation=turn.as_rotvec())
    at = np.array(body.marker_poses()["root"].at)
    x, z = turn.apply([(1, 0, 0), (0, 0, 1)])
    foot = fmb.Pose.axes(tuple(turn.apply(at) + (1.0, 2.0, 3.0)), x=tuple(x), z=tuple(z))
    share = 1e-4  # small deflections: the load stays where it is
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"foot": foot}), body],
        joints=[fmb.Fixed("clamp", markers=("ground.foot", "body.root"))],
        forces=[fmb.Pressure("flow", load="body.flow", amount=share)],
        sensors=[fmb.Reaction("clamp", joint="clamp")],
    )
    found = turn.inv().apply(fmb.statics(model)["clamp"][-1].reshape(2, 3)).ravel() / share
    np.testing.assert_allclose(found[:3], -force, atol=1e-6 * np.abs(force).max())
    np.testing.assert_allclose(found[3:], np.cross(at, force) - moment, atol=2e-5 * np.abs(moment).max())


def test_files_of_flow_solvers(tmp_path, rng):
    """A table of points and a mesh of triangles give what the arrays give; bad ones are named."""
    points, areas = rng.uniform(0, 2, (40, 3)), rng.normal(size=(40, 3))
    pressure = rng.uniform(0, 1e3, 40)
    direct = reduction.SurfacePressure(points=points, pressure=pressure, areas=areas).cloud(1.0).resultant()
    size = np.linalg.norm(areas, axis=1)
    tables = {
        "vectors.csv": ("x,y,z,p,ax,ay,az", np.column_stack([1e3 * points, pressure, 1e6 * areas]), ","),
        "normals.dat": (
            "x y z cp area nx ny nz",
            np.column_stack([1e3 * points, pressure, 1e6 * size, areas / size[:, None]]),
            " ",
        ),
    }
    for name, (titles, rows, separator) in tables.items():
        np.savetxt(tmp_path / name, rows, delimiter=separator, header=titles, comments="", fmt="%.17g")
        table = fem.read_surface(tmp_path / name, "cp" if "cp" in titles else "", scale=1e-3)
        found = reduction.SurfacePressure(**table).cloud(1.0).resultant()
        np.testing.assert_allclose(np.concatenate(found), np.concatenate(direct), rtol=1e-10)
    import meshio

    cells = rng.permutation(40)[:39].reshape(13, 3)
    for place in ("point_data", "cell_data"):
        values = {"point_data": {"p": pressure}, "cell_data": {"p": [pressure[:13]]}}[place]
        meshio.write(tmp_path / "surface.vtu", meshio.Mesh(points, [("triangle", cells)], **{place: values}))
        read = fem.read_surface(tmp_path / "surface.vtu")
        given = reduction.SurfacePressure(
            points=points,
            triangles=cells,
            pressure=values["p"] if place == "point_data" else values["p"][0],
            by_triangle=place == "cell_data",
        )
        one, two = (load.cloud(1.0).resultant() for load in (reduction.SurfacePressure(**read), given))
        np.testing.assert_allclose(np.concatenate(one), np.concatenate(two), rtol=1e-12)
    (tmp_path / "bad.csv").write_text("x,y,z,q\n1,2,3,4\n")
    with pytest.raises(MeshError, match="the fields x, y, z, q"):
        fem.read_surface(tmp_path / "bad.csv")
    (tmp_path / "bad.csv").write_text("x,y,z,p\n1,2,3,4\n")
    with pytest.raises(MeshError, match="the columns x, y, z, p"):
        fem.read_surface(tmp_path / "bad.csv")
    (tmp_path / "bad.csv").write_text("x,y,z,p,ax,ay,az\n1,2,3,4\n")
    with pytest.raises(MeshError, match="7 titles over rows"):
        fem.read_surface(tmp_path / "bad.csv")
    (tmp_path / "bad.csv").write_text("x,y,z,p,ax,ay,az\n1,2,3,4,5,6,seven\n")
    with pytest.raises(MeshError, match="cannot be read"):
        fem.read_surface(tmp_path / "bad.csv")


@pytest.mark.parametrize(
    ("make", "found"),
    [
        (lambda: reduction.LineTable(points=[(0, 0, 0)]), "points = "),
        (lambda: reduction.LineTable(points=[(0, 0, 0), (0, 0, 0)]), "same place"),
        (lambda: reduction.LineTable(points=[(0, 0, 0), (1, 0, 0)], force=(1, [1, 2, 3], 0)), "force = "),
        (lambda: reduction.LineTable(points=[(0, 0, 0), (1, 0, 0)], reach=-1.0), "reach = -1.0"),
        (lambda: reduction.PressureTable(corners=[(0, 0, 0)], span=[0], chord=[0], pressure=[[1]]), "corners"),
        (
            lambda: reduction.PressureTable(corners=np.eye(4, 3), span=[0, 0], chord=[0], pressure=[[1], [2]]),
            "span = ",
        ),
        (lambda: reduction.PressureTable(corners=np.eye(4, 3), span=[0, 1], chord=[0], pressure=[[1]]), "table of"),
        (lambda: reduction.SurfacePressure(points=np.eye(3), pressure=[1, 2, 3]), "neither areas nor triangles"),
        (lambda: reduction.SurfacePressure(points=np.eye(3), pressure=[1, 2], areas=np.eye(3)), "pressures .2,."),
        (
            lambda: reduction.SurfacePressure(points=np.eye(3), pressure=[1, np.nan, 2], areas=np.eye(3)),
            "pressures .0,.",
        ),
        (lambda: reduction.SurfacePressure(points=np.eye(3), pressure=[1, 2, 3], triangles=[(0, 1, 3)]), "triangles"),
    ],
)
def test_messages(make, found):
    with pytest.raises(ReductionError, match=found):
        make()


def test_a_surface_that_is_somewhere_else():
    """Millimetres taken as metres: the message names the farthest point."""
    far = Given(LoadCloud(np.array([(1e3, 0, 0), (0.1, 0, 0)]), np.ones((2, 3)), np.zeros((2, 3))), reach=1.0)
    with pytest.raises(ReductionError, match=r"1 of 2 points farther than 1 m .* the farthest at .1000.0"):
        far.nodal(beam(), "load")
    with pytest.raises(ReductionError, match="no beam, shell or facet"):
        Given(far.given, on=[0]).nodal(beam(), "load")
