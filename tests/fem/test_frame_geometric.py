"""Geometric stiffness of frames: the second variation of a geometrically exact beam, and classical buckling
loads.

Columns are in tests/verification/test_fe14_frame_columns.py.
"""

import numpy as np
import pytest
from fem.beams import STEEL, solve, straight
from tolerances import MACHINE

from flexmb import fem
from flexmb.fem import Section

STRIP = Section.rectangle(0.05, 0.002)  # stiff in x-y
GJ, EI = STEEL.shear * STRIP.torsion, STEEL.young * STRIP.inertia_y


def buckling_factor(fe, field):
    """Smallest positive load factor of a stress state given by a nodal field."""
    geometric = fe.blocks[0].geometric_stiffness(field, fe.dofs).toarray()
    from scipy.linalg import eigh

    values = eigh(geometric, fe.K.toarray(), eigvals_only=True)
    return -1.0 / values[0]


def test_lateral_buckling_under_an_end_force():
    """Timoshenko & Gere, Theory of Elastic Stability, art. 6.3: P = 4.0126 sqrt(E I G J) / L^2 (narrow
    strip)."""
    fe = fem.with_supports(fem.frame(straight(32), section=STRIP, material=STEEL), "start")
    factor = buckling_factor(fe, solve(fe, 32, (0, 1, 0, 0, 0, 0)))
    assert factor == pytest.approx(4.0126 * np.sqrt(EI * GJ), rel=1e-3)


@pytest.mark.parametrize("direction", [(1, 0, 0), (1, 2, 3)])
def test_lateral_buckling_under_end_moments(direction):
    """Fork supports, uniform moment: M = pi sqrt(E I G J) / L (Timoshenko & Gere, art. 6.2), in any
    direction of space."""
    count = 16
    x = np.asarray(direction, float) / np.linalg.norm(direction)
    side = np.cross((0.0, 0.0, 1.0), x)
    side /= np.linalg.norm(side)
    fe = fem.frame(straight(count, direction=x), section=STRIP, material=STEEL, orientation=side)
    up = np.cross(x, side)
    stiff = 1e12 * np.outer(side, side) + 1e12 * np.outer(up, up)
    fork = np.zeros((6, 6))
    fork[:3, :3], fork[3:, 3:] = stiff, 1e12 * np.outer(x, x)
    for node in (0, count):
        fe = fem.with_spring(fe, node, fork)
    fe = fem.with_spring(fe, 0, np.block([[1e12 * np.outer(x, x), np.zeros((3, 3))], [np.zeros((3, 6))]]))
    load = np.zeros((count + 1, 6, 1))
    load[0, 3:, 0], load[count, 3:, 0] = -up, up
    field = fe.field(np.linalg.solve(fe.K.toarray(), fe.forces(load)))[..., 0]
    assert buckling_factor(fe, field) == pytest.approx(np.pi * np.sqrt(EI * GJ), rel=2e-3)


def test_torsional_buckling_by_axial_force():
    """A column free to twist only: N = G J A / I_p (Wagner; Timoshenko & Gere, art. 5.4, free warping)."""
    section = Section.values(1e-3, 1e-6, 2e-6, 1e-9)
    fe = fem.frame(straight(4), section=section, material=STEEL)
    fe = fem.with_supports(fem.with_supports(fe, "start"), directions=(1, 2, 4, 5))
    factor = buckling_factor(fe, solve(fe, 4, (-1, 0, 0, 0, 0, 0)))
    assert factor == pytest.approx(STEEL.shear * 1e-9 * 1e-3 / 3e-6, rel=1e-9)


def test_shear_flexible_column_is_engessers():
    """1 / P = 1 / P_Euler + 1 / (G A_s): the axial force acts along the line of nodes, as in a solid."""
    section = Section.rectangle(0.2, 0.1)
    fe = fem.with_supports(fem.frame(straight(40), section=section, material=STEEL), "start")
    factor = buckling_factor(fe, solve(fe, 40, (-1, 0, 0, 0, 0, 0)))
    euler = np.pi**2 / 4 * STEEL.young * section.inertia_y
    assert factor == pytest.approx(1 / (1 / euler + 1 / (STEEL.shear * section.area * 5 / 6)), rel=1e-5)


def test_linear_in_the_load_and_symmetric(rng):
    fe = fem.frame(np.cumsum(rng.random((5, 3)), axis=0), section=STRIP, material=STEEL)
    block, (a, b) = fe.blocks[0], rng.standard_normal((2, 5, 6))
    one, two, both = (block.geometric_stiffness(u, fe.dofs) for u in (a, b, 2.0 * a - 3.0 * b))
    assert abs(both - 2.0 * one + 3.0 * two).max() < MACHINE * abs(both).max()
    assert abs(one - one.T).max() == 0.0


def test_projection_is_the_assembled_matrix(rng):
    fe = fem.frame(np.cumsum(rng.random((5, 3)), axis=0), section=STRIP, material=STEEL)
    loads, modes = rng.standard_normal((5, 6, 2)), rng.standard_normal((fe.ndof, 4))
    found = fe.blocks[0].projected_geometric_stiffness(loads, fe.field(modes))
    for case in range(2):
        expected = modes.T @ fe.blocks[0].geometric_stiffness(loads[..., case], fe.dofs) @ modes
        np.testing.assert_allclose(found[case], expected, atol=1e-11 * np.abs(expected).max())


def test_rigid_motion_causes_no_stress(rng):
    fe = fem.frame(np.cumsum(rng.random((5, 3)), axis=0), section=STRIP, material=STEEL)
    rigid = fe.field(fe.rigid_motions() @ rng.standard_normal(6))[..., 0]
    stressed = fe.blocks[0].geometric_stiffness(rng.standard_normal((5, 6)), fe.dofs)
    assert abs(fe.blocks[0].geometric_stiffness(rigid, fe.dofs)).max() < 1e-11 * abs(stressed).max()


def test_rotating_a_stressed_frame_turns_the_loads(rng):
    """Moment equilibrium: K_g times a rigid rotation is the turned load, K_g P_k = P_k x f for forces
    without moments.

    For nodal forces f of a stressed frame, the forces that must turn with it are e_k x f_i; nodal moments m
    (semitangential) contribute e_k x m / 2. An exact statement of the second variation, for every stress
    state.
    """
    fe = fem.frame(np.cumsum(rng.random((5, 3)), axis=0), section=STRIP, material=STEEL)
    u = rng.standard_normal((5, 6, 1))
    loads = fe.field(fe.K @ fe.vectors(u))[..., 0]
    geometric = fe.blocks[0].geometric_stiffness(u[..., 0], fe.dofs)
    for k in range(3):
        found = fe.field(geometric @ fe.rigid_motions()[:, 3 + k])[..., 0]
        expected = np.cross(np.eye(3)[k], loads[:, :3])
        np.testing.assert_allclose(found[:, :3], expected, atol=1e-9 * np.abs(loads).max())
