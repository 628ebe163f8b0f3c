"""Shells, beams and solids as one part: composite beams in closed form, links, geometric stiffness, messages."""

from dataclasses import replace

import numpy as np
import pytest
from fem.beams import plate, straight
from fem.structured import structured
from tolerances import MACHINE

from flexmb import fem, reduction
from flexmb.errors import MeshError
from flexmb.fem.meshes.mesh import Mesh
from flexmb.model.material import Material

PLAIN = Material(young=70e9, poisson=0.0, density=2700.0)  # no lateral contraction: beam theory is exact
LENGTH, WIDTH, THICKNESS = 1.0, 0.08, 0.003
HEIGHT, WEB = 0.03, 0.004
BETWEEN = 0.5 * (HEIGHT + THICKNESS)  # from the middle of the sheet to that of the stringer


def panel(elements=16):
    """Return a sheet along x with a rectangular stringer below it, on the nodes of its middle line."""
    skin = fem.shell(plate(elements, 2, LENGTH, WIDTH, "quad"), PLAIN, THICKNESS)
    points = straight(elements, LENGTH) + [0.0, 0.5 * WIDTH, 0.0]
    section = fem.Section.rectangle(WEB, HEIGHT).with_offsets(
        area_center=(0.0, -BETWEEN), shear_center=(0.0, -BETWEEN), mass_center=(0.0, -BETWEEN)
    )
    stringer = fem.frame(points, section=section, material=PLAIN, shear=False)
    fe = fem.joined(skin, stringer, name="panel")
    ends = {"left": np.flatnonzero(fe.nodes[:, 0] < 1e-9), "right": np.flatnonzero(fe.nodes[:, 0] > LENGTH - 1e-9)}
    return replace(fe, node_sets={**fe.node_sets, **ends}), skin, stringer


def composite_bending_stiffness():
    """E I about the common neutral axis, N m2 (parallel axes)."""
    sheet, web = WIDTH * THICKNESS, WEB * HEIGHT
    own = (WIDTH * THICKNESS**3 + WEB * HEIGHT**3) / 12.0
    return PLAIN.young * (own + sheet * web / (sheet + web) * BETWEEN**2)


def test_common_nodes_are_one_node_and_masses_add_up():
    fe, skin, stringer = panel()
    assert len(fe.nodes) == len(skin.nodes)
    assert fe.ndof == skin.ndof
    mass = fe.rigid_motions()[:, 0] @ fe.M @ fe.rigid_motions()[:, 0]
    volume = LENGTH * (WIDTH * THICKNESS + WEB * HEIGHT)
    assert mass == pytest.approx(PLAIN.density * volume, rel=MACHINE)
    assert set(fe.node_sets["start"]) <= set(fe.node_sets["left"])
    assert [block.cell_type for block in fe.blocks] == ["quad", "line"]
    assert np.allclose(fe.nodes[fe.blocks[1].connectivity], stringer.nodes[stringer.blocks[0].connectivity])


def test_stiffened_sheet_bends_as_the_composite_beam():
    fe, _, _ = panel()
    ends = fe.node_sets["right"]
    hub = fem.with_rigid_link(fe, (LENGTH, 0.5 * WIDTH, -0.01), ends, "hub")
    load = np.zeros((len(hub.nodes), 6, 1))
    load[hub.node_sets["hub"], 2] = 1.0
    u = hub.field(fem.static(hub, hub.forces(load), "left"))[hub.node_sets["hub"][0], 2, 0]
    assert u == pytest.approx(LENGTH**3 / (3.0 * composite_bending_stiffness()), rel=5e-3)


def test_stiffened_sheet_buckles_as_the_composite_column():
    """Euler's column, clamped and free, under an axial force at the neutral axis; also through an interface."""
    fe, _, _ = panel()
    sheet, web = WIDTH * THICKNESS, WEB * HEIGHT
    neutral = -BETWEEN * web / (sheet + web)
    euler = 0.25 * np.pi**2 * composite_bending_stiffness() / LENGTH**2
    hub = fem.with_rigid_link(fe, (LENGTH, 0.5 * WIDTH, neutral), "right", "hub")
    load = np.zeros((len(hub.nodes), 6, 1))
    load[hub.node_sets["hub"], 0] = -1.0
    factors, shapes = fem.buckling(hub, hub.forces(load)[:, 0], "left", 6)
    bending = [abs(hub.field(shape)[hub.node_sets["hub"][0], 2, 0]) > 0.5 for shape in shapes.T]
    assert factors[bending][0] == pytest.approx(euler, rel=0.01)

    data = reduction.reduce(
        fe,
        {
            "a": reduction.Rigid("left", at=(0.0, 0.5 * WIDTH, neutral)),
            "b": reduction.Rigid("right", at=(LENGTH, 0.5 * WIDTH, neutral)),
        },
        modes=12,
        geometric_stiffness=True,
        frame="a",
        compare=0,
    )
    G = -data.geometric.interface[1, 0]
    found = 1.0 / np.linalg.eigvals(-np.linalg.solve(data.stiffness, G)).real.max()
    lowest = min(factors[factors > 0.0])
    assert found == pytest.approx(lowest, rel=0.01)


def test_beam_on_a_face_of_solids_is_one_cantilever():
    """A bar, half solid and half beam, tied over the face: tip deflection of the whole bar (nu = 0)."""
    side, half = 0.02, 0.25
    x, y, z = (np.linspace(0.0, s, n + 1) for s, n in ((half, 10), (side, 1), (side, 1)))
    points = np.array([(a, b, c) for c in z for b in y for a in x]) - [0.0, side / 2, side / 2]
    number = np.arange(len(points)).reshape(2, 2, 11)
    cells = np.array(
        [
            [
                number[c, b, i + a]
                for c, b, a in ((0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0))
            ]
            for i in range(10)
        ]
    )
    ends = {"foot": np.flatnonzero(points[:, 0] < 1e-9), "face": np.flatnonzero(points[:, 0] > half - 1e-9)}
    block = fem.solid(Mesh(points=points, cells=(("hexahedron", cells),), node_sets=ends), PLAIN)
    bar = fem.frame([(half, 0, 0), (2 * half, 0, 0)], section=fem.Section.rectangle(side, side), material=PLAIN)
    fe = fem.with_rigid_link(fem.joined(block, bar), "start", "face")
    load = np.zeros((len(fe.nodes), 6, 1))
    load[fe.node_sets["end"], 2] = 1.0
    u = fe.field(fem.static(fe, fe.forces(load), "foot"))[fe.node_sets["end"][0], 2, 0]
    inertia, shear = side**4 / 12.0, 5.0 / 6.0 * side**2 * PLAIN.young / 2.0
    assert u == pytest.approx((2 * half) ** 3 / (3.0 * PLAIN.young * inertia) + 2 * half / shear, rel=2e-3)


def test_geometric_stiffness_of_joined_blocks_is_their_sum(rng):
    fe, _skin, stringer = panel(4)
    field = 1e-5 * rng.standard_normal((len(fe.nodes), 6))
    whole = sum(block.geometric_stiffness(field, fe.dofs) for block in fe.blocks)
    modes = rng.standard_normal((fe.ndof, 3))
    projected = sum(b.projected_geometric_stiffness(field[:, :, None], fe.field(modes)) for b in fe.blocks)[0]
    assert np.abs(modes.T @ whole @ modes - projected).max() < MACHINE * np.abs(projected).max()
    number = fe.blocks[1].number
    own = stringer.blocks[0].geometric_stiffness(field[number], stringer.dofs)
    alone = fe.blocks[1].geometric_stiffness(field, fe.dofs)
    assert alone.sum() == pytest.approx(own.sum())
    assert alone.nnz == own.nnz


def test_station_on_the_skin_does_not_hang_on_the_stringer():
    fe, _, _ = panel(8)
    point = (0.5 * LENGTH + 0.01, 0.002, 0.0)  # near the edge of the sheet, off its nodes
    data = reduction.reduce(fe, {"a": "left", "b": "right"}, modes=4, stations={"edge": point}, compare=0)
    corner = int(np.argmin(np.linalg.norm(fe.nodes - [0.5 * LENGTH, 0.0, 0.0], axis=1)))
    rotation = data.rotation_shapes[corner]
    edge = data.marker_names.index("edge")
    assert np.allclose(data.marker_rotations[edge], rotation, atol=1e-9 * np.abs(rotation).max())


def test_joined_models_are_cut_like_others():
    """Parts of a stiffened sheet on a block of solids: their masses and stiffness add up to the whole."""
    fe, _, _ = panel(8)
    mesh = structured("hexahedron", (2, 1, 1), (LENGTH, WIDTH, 0.05))
    fe = fem.joined(fe, fem.solid(mesh, PLAIN))
    first, second = fem.split(fe, at=(0.49 * LENGTH,))
    assert {block.cell_type for block in first.blocks} == {"quad", "line", "hexahedron"}
    total = fe.rigid_motions().T @ fe.M @ fe.rigid_motions()
    parts = sum(part.rigid_motions().T @ part.M @ part.rigid_motions() for part in (first, second))
    np.testing.assert_allclose(parts, total, atol=1e-12 * np.abs(total).max())
    for part in (first, second):  # free, and able to be cut again
        assert np.abs(part.K @ part.rigid_motions()).max() < 1e-9 * abs(part.K).max()
    assert len(fem.split(second, at=(0.75 * LENGTH,))) == 2


def test_cells_of_some_sets():
    sheet = plate(2, 1, 2.0, 1.0, "quad")
    sets = {"left": (np.array([0]), np.zeros(0, int)), "edge": (np.zeros(0, int), np.array([0]))}
    mesh = Mesh(
        points=sheet.points,
        cells=(("quad", sheet.cells[0][1]), ("line", np.array([[4, 5]]))),
        cell_sets=sets,
        node_sets={"corner": np.array([5]), "origin": np.array([0])},
        facet_sets={"both": sheet.cells[0][1]},
    )
    left = mesh.only("left")
    assert len(left.points) == 4
    assert len(left.cells_of("quad")) == 1
    assert not len(left.cells_of("line"))
    assert set(left.node_sets) == {"origin"}
    assert left.facet_sets["both"].shape == (1, 4)
    assert set(left.cell_sets) == {"left"}
    assert len(mesh.only("left", "edge").points) == 6
    with pytest.raises(MeshError, match="'lft' does not exist"):
        mesh.only("lft")


def test_messages():
    _fe, skin, stringer = panel(4)
    with pytest.raises(MeshError, match="1 models"):
        fem.joined(skin)
    with pytest.raises(MeshError, match="links"):
        fem.joined(fem.with_rigid_link(skin, (0, 0, 1), [0, 1, 2]), stringer)
    doubled = replace(stringer, nodes=np.vstack([stringer.nodes[:-1], stringer.nodes[:1]]))
    with pytest.raises(MeshError, match="several nodes at"):
        fem.joined(skin, doubled)
    with pytest.raises(MeshError, match="several nodes at"):
        fem.joined(doubled, skin)
