"""CQUAD4 and CTRIA3 of decks do not turn in their plane: closed forms of the weak spring and of what hangs on it."""

import numpy as np
import pytest

from flexmb import fem

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")

E, NU, T = 70e9, 0.25, 0.01
SHEAR = E / (2 * (1 + NU))


def read(tmp_path, cells, points, extra="", thickness=T, nu=NU, card="CQUAD4"):
    """Read shells on points (x, y); 1 m, 1 kg/m3."""
    rows = [f"GRID,{k},,{x},{y},0." for k, (x, y) in enumerate(points, 1)]
    rows += [f"{card},{100 + k},1,{','.join(map(str, cell))}" for k, cell in enumerate(cells)]
    rows += [f"PSHELL,1,1,{thickness},1,,1", f"MAT1,1,{E:.9e},,{nu},2700.", extra]
    path = tmp_path / "shells.bdf"
    path.write_text("\n".join(["BEGIN BULK", *rows, "ENDDATA", ""]))
    return fem.read_deck(path, show=False, lumped=False)


def energy(fe, field):
    """Return twice the strain energy of nodal displacements (n, 6)."""
    u = np.array([field[n, d] for n, d in fe.dofs])
    return float(u @ fe.K @ u)


UNIT = [(0.0, 0.0), (0.4, 0.0), (0.4, 0.3), (0.0, 0.3)]
WARPED = [(0.0, 0.0), (0.4, 0.05), (0.35, 0.3), (-0.05, 0.25)]


@pytest.mark.parametrize(("extra", "share"), [("", 1e-4), ("PARAM,K6ROT,1.+4", 1e-2), ("PARAM,K6ROT,0.", 1e-6)])
@pytest.mark.parametrize("triangles", [False, True])
def test_spring_against_turning(tmp_path, extra, share, triangles):
    """All corners turn by theta while the plane stays: 1e-6 K6ROT G t A theta^2 (MSC Nastran, PARAM K6ROT)."""
    cells, card = ([(1, 2, 3), (1, 3, 4)], "CTRIA3") if triangles else ([(1, 2, 3, 4)], "CQUAD4")
    fe = read(tmp_path, cells, WARPED, extra, card=card)
    field = np.zeros((4, 6))
    field[:, 5] = 1.0
    x, y = np.array(WARPED).T
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    assert energy(fe, field) == pytest.approx(share * SHEAR * T * area, rel=1e-9)


@pytest.mark.parametrize(("card", "cells"), [("CQUAD4", [(1, 2, 3, 4)]), ("CTRIA3", [(1, 2, 3), (1, 3, 4)])])
def test_constant_strain(tmp_path, card, cells):
    """u linear in x and y with the rotation of the plane at the nodes: the energy of the plane state of stress."""
    fe = read(tmp_path, cells, WARPED, card=card)
    gradient = np.array([[1.0, 0.7], [-0.4, 0.3]]) * 1e-3
    field = np.zeros((4, 6))
    field[:, :2] = np.array(WARPED) @ gradient.T
    field[:, 5] = 0.5 * (gradient[1, 0] - gradient[0, 1])
    strain = np.array([gradient[0, 0], gradient[1, 1], gradient[0, 1] + gradient[1, 0]])
    plane = E / (1 - NU**2) * np.array([[1, NU, 0], [NU, 1, 0], [0, 0, 0.5 * (1 - NU)]])
    x, y = np.array(WARPED).T
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    assert energy(fe, field) == pytest.approx(T * area * strain @ plane @ strain, rel=1e-9)


def test_row_of_rectangles_bends_in_its_plane(tmp_path):
    """End couple on a row of CQUAD4: v = M l^2 / 2 E I (closed form); the weak spring takes less than a thousandth."""
    count, length, height = 6, 1.2, 0.1
    points = [(length * k / count, height * j) for j in range(2) for k in range(count + 1)]
    cells = [(k + 1, k + 2, k + count + 3, k + count + 2) for k in range(count)]
    fe = read(tmp_path, cells, points)
    load = np.zeros((len(points), 6, 1))
    load[count, 0], load[-1, 0] = -1e3, 1e3
    held = np.zeros(fe.ndof, bool)
    held[[k for k, (n, d) in enumerate(fe.dofs) if d in (2, 3, 4) or (n in (0, count + 1) and d == 0)]] = True
    held[[k for k, (n, d) in enumerate(fe.dofs) if n == 0 and d == 1]] = True
    moved = fe.field(fem.static(fe, fe.forces(load)[:, 0], held))[count, 1, 0]
    expected = -(1e3 * height) * length**2 / (2 * E * T * height**3 / 12)
    assert abs(moved) == pytest.approx(abs(expected), rel=1e-3)


def test_bar_on_the_edge_of_a_shell_is_held_at_points(tmp_path):
    """A bar along an edge and beyond: a rigid plate holds it at two nodes, F l^2 (l + a) / (3 E I) at its end."""
    a, reach = 0.4, 0.5
    bars = ["GRID,5,,0.9,0.,0.", "CBAR,1,2,1,2,0.,0.,1.", "CBAR,2,2,2,5,0.,0.,1."]
    bars += ["PBAR,2,1,1.-4,1.-9,1.-9,1.-9", "PARAM,K6ROT,1."]
    fe = read(tmp_path, [(1, 2, 3, 4)], UNIT, "\n".join(bars), thickness=0.05)
    load = np.zeros((5, 6, 1))
    load[4, 1] = 1.0
    held = np.array([n in (2, 3) or d in (2, 3, 4) for n, d in fe.dofs])
    moved = fe.field(fem.static(fe, fe.forces(load)[:, 0], held))[4, 1, 0]
    assert moved == pytest.approx(reach**2 * (reach + a) / (3 * E * 1e-9), rel=3e-2)
