"""Bricks as the program of a deck has them: C3D20R and C3D8 beside CalculiX, and no motion without strain."""

import re
import subprocess
import warnings

import numpy as np
import pytest

from flexmb import fem
from flexmb.fem.solids.elements import HEX, HEX_EDGES

STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n210e9, .3\n*DENSITY\n7850.\n"
BRICK = np.vstack([HEX, [HEX[list(edge)].mean(axis=0) for edge in HEX_EDGES]])
ABAQUS = [*range(12), 16, 17, 18, 19, 12, 13, 14, 15]
"""Abaqus writes the midsides of the top before those of the sides, as meshio has them: the order of BRICK."""


def deck(kind, cubes, size=(1.0, 1.0, 1.0), skew=0.0):
    """Return the deck of unit cubes at whole places, scaled and moved by a smooth field, and its points."""
    count = 8 if kind.startswith("C3D8") else 20
    places, cells = {}, []
    for cube in cubes:
        at = np.round(2 * (BRICK[:count] + cube)).astype(int)
        cells.append([places.setdefault(tuple(p), len(places) + 1) for p in at])
    points = np.array(list(places)) / 2.0
    x, y, z = points.T
    points = (points + skew * np.column_stack([np.sin(y + z), x * z / 4, np.cos(x - y)])) * size
    lines = ["*NODE, NSET=ALL"] + [f"{n}, {p[0]:.12g}, {p[1]:.12g}, {p[2]:.12g}" for n, p in enumerate(points, 1)]
    lines += [f"*ELEMENT, TYPE={kind}, ELSET=E"]
    for n, cell in enumerate(cells, 1):
        words = [str(n), *map(str, cell)]
        lines += [", ".join(words[:11]) + ("," if len(words) > 11 else "")]
        lines += [", ".join(words[11:])] if len(words) > 11 else []
    bottom = [n for n, place in enumerate(places, 1) if place[2] == 0]
    lines += ["*NSET, NSET=FOOT", *(f"{n}," for n in bottom), "*SOLID SECTION, ELSET=E, MATERIAL=STEEL"]
    return "\n".join(lines) + f"\n{STEEL}*BOUNDARY\nFOOT, 1, 3\n", points


def read(folder, text):
    (folder / "part.inp").write_text(text)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        return fem.read_deck(folder / "part.inp", show=False), " ".join(str(w.message) for w in told)


BEAM = [(i, j, k) for k in range(4) for j in range(2) for i in range(2)]


@pytest.mark.parametrize(("kind", "tolerance"), [("C3D20R", 2e-6), ("C3D20", 2e-6), ("C3D8", 2e-6), ("C3D8I", 5e-4)])
def test_a_loaded_block_beside_calculix(ccx, tmp_path, kind, tolerance):
    """Two by two by four skew bricks, clamped below, a force on the last node. Measured 1e-7 to 4e-7 of the largest
    displacement, where C3D20R moves 25 % more than C3D20 and C3D8 12 % less than C3D8I (whose incompatible modes differ
    by 2e-4 on skew bricks)."""
    text, points = deck(kind, BEAM, size=(0.1, 0.1, 0.1), skew=0.08)
    last = len(points)
    step = f"*STEP\n*STATIC\n*CLOAD\n{last}, 1, 1e5\n{last}, 3, 2e5\n*NODE PRINT, NSET=ALL\nU\n*END STEP\n"
    (tmp_path / "job.inp").write_text(text + step)
    subprocess.run([ccx, "job"], cwd=tmp_path, capture_output=True, check=True, timeout=60)
    rows = re.findall(r"^\s+(\d+)\s+(\S+)\s+(\S+)\s+(\S+)\s*$", (tmp_path / "job.dat").read_text(), re.MULTILINE)
    theirs = np.array([[float(x) for x in row[1:]] for row in rows])
    fe, told = read(tmp_path, text)
    force = np.zeros((len(points), 6, 1))
    force[last - 1, [0, 2], 0] = 1e5, 2e5
    u = fem.static(fe, fe.forces(force)[:, 0], fem.fixed_freedoms(fe, "boundary"))
    ours = fe.field(u[:, None])[:, :3, 0]
    assert np.abs(ours - theirs).max() < tolerance * np.abs(theirs).max()
    assert ("far too stiff" in told) == (kind == "C3D8")


ROW = [(0, 0, k) for k in range(4)]
ANGLE = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 1), (0, 0, 2)]
RING = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (2, 2, 0), (1, 2, 0), (0, 2, 0), (0, 1, 0)]


@pytest.mark.parametrize(("cubes", "full"), [(ROW, 4), (ANGLE, 2), (RING, 4), (BEAM, 0), ([(0, 0, 0)], 1)])
def test_reduced_integration_leaves_no_motion_without_strain(tmp_path, cubes, full):
    """A row of four C3D20R has eleven motions without strain (CalculiX and Abaqus alike), a single one twelve: such
    bricks are fully integrated and told, so that every free body has six."""
    fe, _ = read(tmp_path, deck("C3D20R", cubes, skew=0.05)[0])
    values = np.linalg.eigvalsh(fe.K.toarray())
    assert (values < 1e-9 * values[-1]).sum() == 6
    told = sum(n for words, n in fe.source["approximated"].items() if "one element wide" in words)
    assert told == full


def test_first_order_bricks_of_reduced_integration_are_told(tmp_path):
    fe, _ = read(tmp_path, deck("C3D8R", BEAM)[0])
    assert fe.source["approximated"] == {"C3D8R with incompatible modes, integrated fully": 16}
