"""Instances beside the flat deck of the same model, ties over gaps, and equations in turned axes, beside CalculiX."""

import re
import subprocess

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexmb import fem

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")

MATERIAL = (
    "*MATERIAL, NAME=PLY\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n140e9, 10e9, 12e9, .3, .25, .4, 5e9, 4e9,\n3e9\n"
    "*DENSITY\n1600.\n"
)
TURN = Rotation.from_rotvec(np.radians(35.0) * np.array([1.0, 2.0, 2.0]) / 3.0)
AT, SHIFT = np.array([0.3, 0.1, -0.2]), np.array([0.32, 0.03, 0.02])
COUNTS, SIZES = (3, 2, 2), (0.3, 0.1, 0.1)
FIRST, LAST = ([1 + end + 4 * k for k in range(9)] for end in (0, 3))


def words(numbers):
    return ", ".join(f"{x:.15g}" for x in np.atleast_1d(numbers))


def placed(point):
    """The place of a point of the second instance: shifted, then turned about the line through AT."""
    return TURN.apply(point + SHIFT - AT) + AT


def block(first, place=None):
    """Return *NODE and *ELEMENT of three by two by two C3D8; node and element numbers begin at `first`."""
    grids = [np.linspace(0.0, size, count + 1) for size, count in zip(SIZES, COUNTS, strict=True)]
    points = [np.array([x, y, z]) for z in grids[2] for y in grids[1] for x in grids[0]]
    lines = ["*NODE"] + [f"{first + k}, {words(p if place is None else place(p))}" for k, p in enumerate(points)]
    lines += ["*ELEMENT, TYPE=C3D8"]
    corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
    cells = [(i, j, k) for k in range(2) for j in range(2) for i in range(3)]
    for number, (i, j, k) in enumerate(cells):
        row = [first + i + a + 4 * (j + b) + 12 * (k + c) for a, b, c in corners]
        lines.append(f"{first + number}, " + ", ".join(map(str, row)))
    return "\n".join(lines) + "\n"


def named(tag, first, turn=None):
    """Return sets, surfaces, orientation and *TRANSFORM of a block; `tag` distinguishes them in a flat deck."""
    axes = [np.array(v) for v in ([1.0, 0.4, 0.2], [-0.3, 1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.5])]
    a, b, c, d = (words(v if turn is None else turn.apply(v)) for v in axes)
    ends = {name: "\n".join(f"{n + first - 1}," for n in nodes) for name, nodes in (("F", FIRST), ("L", LAST))}
    tops = "\n".join(f"{first + k}, S4" for k in (2, 5, 8, 11))
    return (
        f"*ELSET, ELSET={tag}E, GENERATE\n{first}, {first + 11}\n*NSET, NSET={tag}F\n{ends['F']}\n*NSET, NSET={tag}L\n"
        f"{ends['L']}\n*SURFACE, NAME={tag}SL\n{tops}\n*SURFACE, NAME={tag}SF, TYPE=NODE\n{tag}F,\n"
        f"*ORIENTATION, NAME={tag}O\n{a}, {b}\n*SOLID SECTION, ELSET={tag}E, MATERIAL=PLY, ORIENTATION={tag}O\n"
        f"*TRANSFORM, NSET={tag}L, TYPE=R\n{c}, {d}\n"
    )


def two(join, flat):
    """Return the deck of two blocks joined by keywords in which {1} and {2} stand for the instances."""
    if flat:
        text = block(1) + named("A", 1) + block(1001, placed) + named("B", 1001, TURN)
        join = re.sub(r"\{([12])\}(\d+)", lambda m: str(int(m[2]) + 1000 * (m[1] == "2")), join)
        return f"{text}{join.replace('{1}', 'A').replace('{2}', 'B')}{MATERIAL}*BOUNDARY\nAF, 1, 3\n"
    axis = words([*AT, *(AT + np.array([1.0, 2.0, 2.0]) / 3.0)])
    text = f"*PART, NAME=P\n{block(1)}{named('', 1)}*END PART\n*ASSEMBLY, NAME=S\n"
    text += "*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n"
    text += f"*INSTANCE, NAME=J, PART=P\n{words(SHIFT)}\n{axis}, 35.\n*END INSTANCE\n"
    join = join.replace("{1}", "I.").replace("{2}", "J.")
    return f"{text}{join}*NSET, NSET=FIX\nI.F,\n*END ASSEMBLY\n{MATERIAL}*BOUNDARY\nFIX, 1, 3\n"


PAIRS = list(zip(LAST, FIRST, strict=True))
REFERENCES = f"*NODE\n900, .33, .05, .05\n*NODE\n901, {words(placed(np.array([0.0, 0.05, 0.05])))}\n"
COUPLED = (
    REFERENCES + "*COUPLING, REF NODE=900, SURFACE={1}SL, CONSTRAINT NAME=CA\n*DISTRIBUTING\n1, 3\n"
    "*COUPLING, REF NODE=901, SURFACE={2}SF, CONSTRAINT NAME=CB\n*KINEMATIC\n1, 3\n*MPC\nBEAM, 900, 901\n"
)
WEIGHTED = (
    REFERENCES
    + "*ELEMENT, TYPE=DCOUP3D, ELSET=DC\n9000, 900\n*DISTRIBUTING COUPLING, ELSET=DC\n"
    + "".join(f"{{1}}{node}, {1 + k % 3}.\n" for k, node in enumerate(LAST))
    + "*COUPLING, REF NODE=901, SURFACE={2}SF, CONSTRAINT NAME=CB\n*KINEMATIC\n1, 6\n*MPC\nTIE, 901, 900\n"
)
JOINS = {
    "tie": "*TIE, NAME=T, POSITION TOLERANCE=1.\n{2}SF, {1}SL\n",
    "equation": "".join(f"*EQUATION\n2\n{{1}}{a}, {d}, 1., {{2}}{b}, {d}, -1.\n" for a, b in PAIRS for d in (1, 2, 3)),
    "pin": "".join(f"*MPC\nPIN, {{2}}{b}, {{1}}{a}\n" for a, b in PAIRS),
    "coupled": COUPLED.replace("*DISTRIBUTING\n1, 3\n", "*KINEMATIC\n1, 3\n").replace(
        "BEAM, 900, 901", "TIE, 900, 901"
    ),
    "weighted": WEIGHTED,
    "rigid": "*NODE\n900, .35, .05, .05\n*NSET, NSET=RB\n{1}L, {2}F\n*RIGID BODY, REF NODE=900, NSET=RB\n",
}


def frequencies(folder, text):
    (folder / "part.inp").write_text(text)
    return fem.eigenmodes(fem.read_deck(folder / "part.inp", show=False), "boundary", n=6).frequencies


@pytest.mark.parametrize("kind", JOINS)
def test_instances_are_the_flat_deck(tmp_path, kind):
    """A part with orientation, *TRANSFORM, sets and surfaces of its own, once in place and once moved and turned."""
    flat, placed_ = (frequencies(tmp_path, two(JOINS[kind], flat)) for flat in (True, False))
    np.testing.assert_allclose(placed_, flat, rtol=1e-10)


@pytest.mark.parametrize("kind", ["tie", "equation", "rigid"])
def test_joined_blocks_beside_calculix(ccx, tmp_path, kind):
    """Measured 1e-6. Without ADJUST the tied nodes stayed where they were: 152 Hz instead of 82."""
    text = two(JOINS[kind], flat=True)
    if kind == "rigid":  # CalculiX has rigid bodies in axes of its own only
        text = re.sub(r"\*TRANSFORM.*\n.*\n", "", text)
    (tmp_path / "job.inp").write_text(text + "*STEP\n*FREQUENCY\n6\n*END STEP\n")
    subprocess.run([ccx, "job"], cwd=tmp_path, capture_output=True, check=True, timeout=60)
    table = (tmp_path / "job.dat").read_text().split("P A R T I C I P A T I O N")[0]
    theirs = [float(row[2]) for row in re.findall(r"^\s+\d+\s+(\S+)\s+(\S+)\s+(\S+)\s+(\S+)\s*$", table, re.MULTILINE)]
    np.testing.assert_allclose(frequencies(tmp_path, text), theirs, rtol=1e-5)


def test_nodes_that_are_not_adjusted_are_told(tmp_path):
    told = {}
    for word in ("YES", "NO"):
        text = two(JOINS["tie"].replace("NAME=T,", f"NAME=T, ADJUST={word},"), flat=True)
        (tmp_path / "part.inp").write_text(text)
        told[word] = " ".join(fem.read_deck(tmp_path / "part.inp", show=False).source["approximated"])
    assert "moved onto 'ASL', by up to" in told["YES"]
    assert "tied over gaps of up to" in told["NO"]


def test_a_tie_of_shells_over_a_gap_holds_in_rigid_motions(tmp_path):
    """Faces of shells lie half a thickness off their nodes: the gap of 3 mm is an arm, and nothing is strained."""
    plates = ""
    for first, x0, z, n in ((1, 0.0, 0.0, 2), (101, 0.02, 0.003, 3)):
        grid = [(x0 + 0.1 * i / n, 0.1 * j / n, z) for j in range(n + 1) for i in range(n + 1)]
        plates += "*NODE\n" + "".join(f"{first + k}, {words(p)}\n" for k, p in enumerate(grid))
        plates += f"*ELEMENT, TYPE=S4, ELSET=P{first}\n"
        for k in range(n * n):
            corner = first + k % n + (n + 1) * (k // n)
            plates += f"{first + k}, {corner}, {corner + 1}, {corner + n + 2}, {corner + n + 1}\n"
        plates += f"*SHELL SECTION, ELSET=P{first}, MATERIAL=AL\n.003\n"
    text = plates + (
        "*NSET, NSET=N\n101, 105, 109\n*SURFACE, NAME=S, TYPE=NODE\nN,\n*SURFACE, NAME=M\nP1, SPOS\n"
        "*TIE, NAME=T, POSITION TOLERANCE=.01\nS, M\n*MATERIAL, NAME=AL\n*ELASTIC\n70e9, .3\n*DENSITY\n2700.\n"
    )
    (tmp_path / "part.inp").write_text(text)
    fe = fem.read_deck(tmp_path / "part.inp", show=False)
    motions = fe.rigid_motions()
    assert np.abs(fe.K @ motions).max() < 1e-9 * np.abs(fe.K).max()
    arm = fe.field(motions[:, 4:5])[:, :3, 0]  # a turn about y moves the upper plate along x
    assert arm[np.isclose(fe.nodes[:, 2], 0.003), 0] == pytest.approx(0.003, rel=1e-9)
    assert not any("TIE" in what for what in fe.source["approximated"])


def test_nastran_equations_in_turned_axes(tmp_path):
    """Three MPC of one grid point with a CD of its own: each freedom could be the one of each equation."""
    head = (
        "BEGIN BULK\nCORD2R,7,,0.,0.,0.,.1,.2,1.,+\n+,1.,.3,.2\nMAT1,1,2.1+11,,.3,7850.\nPBAR,1,1,1.-4,1.-8,2.-8,2.-8\n"
    )
    bars = "CBAR,1,1,1,2,0.,0.,1.\nCBAR,2,1,4,3,0.,0.,1.\nSPC1,1,123456,1\n"
    grids = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.,{cd}\nGRID,3,,1.,0.,0.,{cd}\nGRID,4,,2.,.5,0.\n"
    mpc = "".join(f"MPC,6,3,{d},1.,2,{d},-1.\n" for d in range(1, 7))
    found = []
    for cd in ("", "7"):
        (tmp_path / "part.bdf").write_text(head + grids.format(cd=cd) + bars + mpc + "ENDDATA\n")
        found.append(fem.eigenmodes(fem.read_deck(tmp_path / "part.bdf", show=False), "spc_1", n=4).frequencies)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9)
