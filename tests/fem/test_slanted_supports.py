"""Supports across the axes: rollers on slopes, sectors held in cylindrical axes, nodes that links move."""

import numpy as np
import pytest

from flexmb import fem
from flexmb.errors import MeshError

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")

E, G, LENGTH, SIDE, SLOPE, LOAD = 210e9, 210e9 / 2.6, 2.0, 0.05, 25.0, 1200.0
AREA, INERTIA = SIDE**2, SIDE**4 / 12


def nastran(tmp_path, bulk, control="SPC = 1", **options):
    path = tmp_path / "part.bdf"
    path.write_text(f"SOL 103\nCEND\n{control}\nBEGIN BULK\n{bulk}\nENDDATA\n")
    return fem.read_deck(path, show=False, **options)


def abaqus(tmp_path, text, **options):
    path = tmp_path / "part.inp"
    path.write_text(text)
    return fem.read_deck(path, show=False, **options)


def beam(count=8, slope=SLOPE, more=""):
    """Return a beam along x whose end rolls on a slope in x-z: displacement system 5 there is turned about y."""
    c, s = np.cos(np.radians(slope)), np.sin(np.radians(slope))
    rows = [f"GRID,{k + 1},,{LENGTH * k / count},0.,0.{',5' if k == count else ''}" for k in range(count + 1)]
    rows += [f"CBAR,{k + 1},1,{k + 1},{k + 2},0.,1.,0." for k in range(count)]
    rows += [f"PBAR,1,1,{AREA},{INERTIA:.15e},{INERTIA:.15e},{2 * INERTIA:.15e}", f"MAT1,1,{E},,.3,7850."]
    rows += [f"CORD2R,5,,0.,0.,0.,{-s:.12f},0.,{c:.12f},+", f"+,{c:.12f},0.,{s:.12f}"]
    rows += ["SPC1,1,1234,1", f"SPC1,1,23,{count + 1}", more]
    return "\n".join(rows)


def middle_load(fe, count=8, load=LOAD):
    field = np.zeros((len(fe.nodes), 6, 1))
    field[count // 2, 2, 0] = -load
    return fe.forces(field)[:, 0]


@pytest.mark.parametrize("units", [None, "mm, t, s"])
def test_a_roller_on_a_slope(tmp_path, units):
    """A load P in the middle of a beam whose end rolls on a slope: the roller pushes along the beam with P tan(a) / 2.

    The end moves H l / E A along the beam and tan(a) of it up; bending is that of a simply supported beam (closed form,
    statics of the plane).
    """
    fe = nastran(tmp_path, beam(), units=units)
    scale = 1.0 if units is None else 1e-3
    load = LOAD if units is None else LOAD * 1e3 * 1e-3  # t mm / s2 is N
    stiff = 1.0 if units is None else 1e6 * 1e-6  # E in t / mm / s2 = 1e6 Pa, A in mm2 = 1e-6 m2
    u = fe.field(fem.static(fe, middle_load(fe, load=load), "spc"))[:, :, 0]
    tangent = np.tan(np.radians(SLOPE))
    along = -0.5 * load * tangent * LENGTH * scale / (stiff * E * AREA)
    np.testing.assert_allclose(u[-1, [0, 2]], [along, along * tangent], rtol=1e-9)
    bending = load * LENGTH**3 / (48 * E * INERTIA) * (1.0 if units is None else scale**3 / (1e6 * 1e-12))
    assert u[4, 2] == pytest.approx(-bending + 0.5 * along * tangent, rel=1e-8)  # shear of a PBAR is stiff, not none
    with pytest.raises(MeshError, match=r"1 directions across the axes"):
        fem.fixed_freedoms(fe, "spc")


def test_supports_across_the_axes_in_a_mapping_or_a_list(tmp_path):
    """Before, {"spc": None} held the freedoms of nodes and left the roller out: the beam slid without rising."""
    fe = nastran(tmp_path, beam())
    alone = "Give 'spc' alone, not in a mapping|Give that name alone, without directions: 'spc'"
    for fixed in ({"spc": None}, {"spc": "xyz"}, {0: "x", "spc": None}, ["spc"], ["spc", "spc"]):
        for act in (fem.with_supports, fem.fixed_freedoms, lambda fe, fixed: fem.static(fe, middle_load(fe), fixed)):
            with pytest.raises(MeshError, match=alone):
                act(fe, fixed)
    with pytest.raises(MeshError, match="'spc' are supports of the deck, which have directions of their own"):
        fem.fixed_freedoms(fe, ["spc"])


def test_slopes_of_right_angles_are_the_axes(tmp_path):
    """A displacement system turned by 90 degrees holds a freedom itself; frequencies with a slope lie between."""
    found = []
    for slope in (0.0, 40.0, 90.0):
        fe = nastran(tmp_path, beam(slope=slope), lumped=False)
        assert ("spc" in fe.slanted) == (slope == 40.0)
        found.append(fem.eigenmodes(fe, "spc", 3))
    low, between, high = (modes.frequencies[0] for modes in found)
    assert low < between < high or high < between < low
    slid = found[1].shapes
    end = fe.field(slid)[8]
    c, s = np.cos(np.radians(40.0)), np.sin(np.radians(40.0))
    assert np.abs(c * end[2] - s * end[0]).max() < 1e-9 * np.abs(fe.field(slid)[:, :3]).max()


def test_a_ring_held_in_cylindrical_axes(tmp_path):
    """A quarter of a ring under pressure between planes of symmetry at 20 and 110 degrees: u = p r^2 / (E A)."""
    n, radius, pressure = 60, 0.4, 3.0e4
    angles = 20.0 + 90.0 * np.arange(n + 1) / n
    rows = ["CORD2C,7,,0.,0.,0.,0.,0.,1.,+", "+,1.,0.,0."]
    rows += [f"GRID,{k + 1},7,{radius},{a:.10f},0.,7" for k, a in enumerate(angles)]
    rows += [f"CBAR,{k + 1},1,{k + 1},{k + 2},0.,0.,1." for k in range(n)]
    rows += [f"PBAR,1,1,{AREA},{INERTIA:.15e},{INERTIA:.15e},{2 * INERTIA:.15e}", f"MAT1,1,{E},,.3,7850."]
    rows += [f"SPC1,1,2456,1,{n + 1}", "SPC1,1,3,1,THRU,61"]
    fe = nastran(tmp_path, "\n".join(rows))
    field = np.zeros((len(fe.nodes), 6, 1))
    unit = fe.nodes[:, :2] / radius
    share = np.full(n + 1, radius * np.radians(90.0) / n)
    share[[0, -1]] *= 0.5
    field[:, :2, 0] = pressure * share[:, None] * unit
    u = fe.field(fem.static(fe, fe.forces(field)[:, 0], "spc"))[:, :3, 0]
    np.testing.assert_allclose((u[:, :2] * unit).sum(axis=1), pressure * radius**2 / (E * AREA), rtol=1e-3)
    around = np.column_stack([-unit[:, 1], unit[:, 0]])[[0, n]]
    assert np.abs((u[[0, n], :2] * around).sum(axis=1)).max() < 1e-12


def test_a_support_of_a_node_that_a_link_moves(tmp_path):
    """A beam on a rigid foot whose far node is clamped is a clamped beam; before, the support was passed over."""
    rows = ["GRID,91,,-.3,0.,.2", "RBE2,92,1,123456,91"]
    free = beam(slope=0.0, more="\n".join(rows)).replace("SPC1,1,1234,1\n", "").replace("SPC1,1,23,9\n", "")
    fe = nastran(tmp_path, free + "\nSPC1,1,123456,91")
    tip = np.zeros((len(fe.nodes), 6, 1))
    tip[8, 2, 0] = LOAD
    for fixed in ("spc", [list(fe.labels).index(91)]):
        u = fe.field(fem.static(fe, fe.forces(tip)[:, 0], fixed))[:, :, 0]
        assert u[8, 2] == pytest.approx(LOAD * LENGTH**3 / (3 * E * INERTIA), rel=1e-9)
    both = nastran(tmp_path, free + "\nSPC1,1,123456,91,1")  # equations that say the same twice
    np.testing.assert_allclose(
        fem.static(both, both.forces(tip)[:, 0], "spc"), fem.static(fe, fe.forces(tip)[:, 0], "spc")
    )


SPRINGS = """GRID,1,,0.,0.,0.,5
GRID,2,,0.,0.,0.
CORD2R,5,,0.,0.,0.,0.,0.,1.,+
+,.8,.6,0.
CELAS2,1,3.+6,1,1
CELAS2,2,5.+6,1,2
CELAS2,3,1.+6,1,3
CELAS2,4,2.+6,2,1
CELAS2,5,7.+6,2,2
CELAS2,6,1.+6,2,3
CONM2,7,1,,1.
CONM2,8,2,,1.
"""


@pytest.mark.parametrize("link", ["MPC,1,1,1,1.,2,1,-1.", "RBAR,9,2,1,123456,,,1", "RBE2,9,2,1,1"])
def test_links_of_a_turned_displacement_system(tmp_path, link):
    """Direction 1 of node 1, turned by atan(3/4), follows node 2: in x (MPC), or along itself (RBAR and RBE2).

    Forces on node 2: stiffness 2e6 along x and 7e6 along y of its own, and 3e6 of the spring that follows.
    """
    fe = nastran(tmp_path, SPRINGS + link, "MPC = 1")
    if link.startswith("MPC"):
        stiffness = np.diag([2e6 + 3e6, 7e6])
    else:
        row = np.array([0.8, 0.6])
        stiffness = np.diag([2e6, 7e6]) + 3e6 * np.outer(row, row)
    field = np.zeros((2, 6, 1))
    field[1, :2, 0] = [100.0, 40.0]
    u = fe.field(fem.static(fe, fe.forces(field)[:, 0], None))[:, :, 0]
    np.testing.assert_allclose(u[1, :2], np.linalg.solve(stiffness, [100.0, 40.0]), rtol=1e-9)
    own = u[0, :2] @ [0.8, 0.6]
    assert own == pytest.approx(u[1, 0] if link.startswith("MPC") else u[1, :2] @ [0.8, 0.6], rel=1e-9)


ABAQUS = """*NODE
{nodes}
*ELEMENT, TYPE=B33, ELSET=ALL
{elements}
*BEAM GENERAL SECTION, ELSET=ALL, DENSITY=7850.
{area}, {inertia}, 0., {inertia}, {torsion}
0., 1., 0.
{young}, {shear}
*NSET, NSET=END
9
*TRANSFORM, NSET=END
{c}, 0., {s}, 0., 1., 0.
*BOUNDARY
1, 1, 4
9, 2, 3
"""


def test_a_boundary_of_a_transform(tmp_path):
    """*BOUNDARY in the axes of *TRANSFORM: the roller on a slope again (closed form as above)."""
    c, s = np.cos(np.radians(SLOPE)), np.sin(np.radians(SLOPE))
    text = ABAQUS.format(
        nodes="\n".join(f"{k + 1}, {LENGTH * k / 8}, 0., 0." for k in range(9)),
        elements="\n".join(f"{k + 1}, {k + 1}, {k + 2}" for k in range(8)),
        area=AREA,
        inertia=INERTIA,
        torsion=2 * INERTIA,
        young=E,
        shear=G,
        c=c,
        s=s,
    )
    fe = abaqus(tmp_path, text)
    assert not fe.warnings
    u = fe.field(fem.static(fe, middle_load(fe), "boundary"))[:, :, 0]
    tangent = np.tan(np.radians(SLOPE))
    along = -0.5 * LOAD * tangent * LENGTH / (E * AREA)
    np.testing.assert_allclose(u[-1, [0, 2]], [along, along * tangent], rtol=1e-9)


def test_a_coupling_in_an_orientation(tmp_path):
    """*KINEMATIC with direction 1 only, in the axes of ORIENTATION: the node follows along (0.8, 0.6) alone."""
    text = """*NODE
1, 0., 0., 0.
2, 0., 0., 0.
*ELEMENT, TYPE=SPRING1, ELSET=SX
1, 2
*ELEMENT, TYPE=SPRING1, ELSET=SY
2, 2
*ELEMENT, TYPE=SPRING1, ELSET=RX
3, 1
*ELEMENT, TYPE=SPRING1, ELSET=RY
4, 1
*ELEMENT, TYPE=MASS, ELSET=M
5, 2
*SPRING, ELSET=SX
1
3.E6
*SPRING, ELSET=SY
2
5.E6
*SPRING, ELSET=RX
1
2.E6
*SPRING, ELSET=RY
2
7.E6
*MASS, ELSET=M
1.
*ORIENTATION, NAME=O
.8, .6, 0., -.6, .8, 0.
*SURFACE, NAME=S, TYPE=NODE
2,
*COUPLING, REF NODE=1, SURFACE=S, CONSTRAINT NAME=C, ORIENTATION=O
*KINEMATIC
1, 1
"""
    fe = abaqus(tmp_path, text)
    assert not any("orientation" in word for word in fe.source["approximated"])
    field = np.zeros((2, 6, 1))
    field[0, :2, 0] = [100.0, 40.0]
    u = fe.field(fem.static(fe, fe.forces(field)[:, 0], fe.dofs[:, 1] > 1))[:, :2, 0]
    row = np.array([0.8, 0.6])
    full = np.zeros((5, 5))  # u1, u2 and the force of the coupling
    full[:4, :4] = np.diag([2e6, 7e6, 3e6, 5e6])
    full[4, :2], full[4, 2:4] = row, -row
    full[:4, 4] = full[4, :4]
    expected = np.linalg.solve(full, [100.0, 40.0, 0.0, 0.0, 0.0])[:4].reshape(2, 2)
    np.testing.assert_allclose(u, expected, rtol=1e-9, atol=1e-15)
