"""Lumped masses of Nastran's shells and rods have no rotary inertia.

With `m t^2 / 12` at the nodes the first elastic mode of the plate below was 6283 Hz (-0.8 %), and the third mode of
pyNastran's `mode_solid_shell_bar`, whose walls are as thick as they are wide, 120.5 Hz for 125.8.
"""

import numpy as np
import pytest

from flexmb import fem

MSC_FIRST = 6333.012
"""Hz, first elastic mode that MSC Nastran prints for this plate (`plate_py.f06` of pyNastran's models)."""
CELLS = (20, 10)


def read(tmp_path, rows):
    """Read the bulk data of a deck."""
    path = tmp_path / "part.bdf"
    path.write_text("\n".join(["BEGIN BULK", *rows, "ENDDATA", ""]))
    return fem.read_deck(path, show=False)


def plate():
    """Bulk data of a free plate, 2 x 1 x 0.125 in, steel, 20 x 10 CQUAD4."""
    a, b = CELLS
    number = np.arange(1, (a + 1) * (b + 1) + 1).reshape(a + 1, b + 1)
    rows = [f"GRID,{number[i, j]},,{i * 0.1:.1f},{j * 0.1:.1f},0." for i in range(a + 1) for j in range(b + 1)]
    for i in range(a):
        for j in range(b):
            corners = (number[i, j], number[i, j + 1], number[i + 1, j + 1], number[i + 1, j])
            rows.append(f"CQUAD4,{i * b + j + 1},1,{','.join(map(str, corners))}")
    return [*rows, "PSHELL,1,1,.125,1,,1", "MAT1,1,2.9+7,,.32,7.3315-4"]


def test_first_mode_of_a_thick_plate_is_that_of_msc_nastran(tmp_path):
    fe = read(tmp_path, plate())
    assert fem.eigenmodes(fe, n=8).frequencies[6] == pytest.approx(MSC_FIRST, rel=1e-5)


def test_masses_of_shells_and_rods_are_points(tmp_path):
    bar = ["GRID,900,,0.,0.,1.", "GRID,901,,0.,0.,2.", "CROD,900,9,900,901", "PROD,9,1,.1,.01"]
    fe = read(tmp_path, [*plate(), *bar])
    turning = fe.dofs[:, 1] >= 3
    assert fe.M.diagonal()[turning].max() == 0.0
    path = tmp_path / "part.bdf"
    consistent = fem.read_deck(path, show=False, lumped=False)
    assert consistent.M.diagonal()[consistent.dofs[:, 1] >= 3].max() > 0.0


@pytest.mark.parametrize("card", ["CBEAM", "CBAR"])
def test_lumped_masses_beside_the_line_of_nodes(tmp_path, card):
    """Points of half the mass lie at the area centre, those of the non-structural mass at their own.

    Of the first moments only those about the beam's line were kept: the centre of mass was half wrong.
    """
    area, i1, i2, density, extra, length = 2e-3, 3e-6, 1e-6, 7850.0, 4.0, 1.6
    own, other = (0.03, -0.05), (-0.2, 0.1)  # along the local y (here z) and z (here -y)
    values = f"{area},{i1},{i2},0.,1.-6,{extra},+\n+,,,,,,,,,+\n+,YES,1.,,,,,,,+\n+,,,,,,,,,+\n+,,,,,,,,,+\n"
    values += f"+,{other[0]},{other[1]},,,{own[0]},{own[1]}"
    rows = ["GRID,1,,0.,0.,0.", f"GRID,2,,{length},0.,0.", f"{card},1,1,1,2,0.,0.,1.", f"PBEAM,1,1,{values}"]
    fe = read(tmp_path, [*rows, f"MAT1,1,2.+11,,.3,{density}"])
    expected = np.zeros((6, 6))
    for mass, (y, z) in ((density * area, own), (extra, other)):
        for x in (0.0, length):
            place = np.array([x, -z, y])
            motion = np.hstack([np.eye(3), np.cross(np.eye(3), place).T])
            expected += 0.5 * length * mass * motion.T @ motion
    if card == "CBEAM":
        expected[3, 3] += density * (i1 + i2) * length
    full = fe.rigid_motions()
    np.testing.assert_allclose(full.T @ (fe.M @ full), expected, atol=1e-12 * expected.max())
