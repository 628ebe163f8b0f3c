"""Loops whose pin axes are parallel but for some digits: they move as if the axes were parallel, in all formulations.

Reference: the plane four-bar linkage, its two equations of closure differentiated by hand.
"""

import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from verification.mechanisms import four_bars

import flexmb as fmb
from flexmb.errors import FlexmbError
from flexmb.integrate.matrices import equations_at
from flexmb.system import assemble
from flexmb.system.mobility import still_dependent

TILTED = Rotation.from_rotvec((0.3, -0.7, 0.5)).as_matrix()
POINTS = np.array(((0.0, 0.0), (0.3, 0.9), (2.3, 1.7), (2.5, 0.0)))
TURNS = (0.0, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7)
FORMULATIONS = (
    fmb.NullSpace(),
    fmb.UdwadiaPhohomsiri(),
    fmb.Recursive(),
    fmb.Baumgarte(fmb.Augmented(), 1e-3, 1e-3),
    fmb.Baumgarte(fmb.NullSpace(), 1e-3, 1e-3),
)


def linkage(eps: float) -> fmb.Model:
    """Four bars of 1 kg in a tilted plane; the far pin of each is turned out of it by about `eps` (rad)."""

    def bar(name, k, turn):
        p, q = (TILTED @ (*POINTS[i], 0.0) for i in (k, k + 1))
        length, z = np.linalg.norm(q - p), TILTED[:, 2]
        x = (q - p) / length
        off = Rotation.from_rotvec((turn, 0.3 * turn, 0.0)).as_matrix()
        return fmb.RigidBody(
            name,
            mass=1.0,
            inertia=(0.01, 0.1, 0.1),
            at=tuple((p + q) / 2),
            rotation=np.column_stack([x, np.cross(z, x), z]),
            markers={"l": (-length / 2, 0, 0), "r": fmb.Pose((length / 2, 0, 0), off)},
        )

    ends = {name: fmb.Pose(tuple(TILTED @ (*POINTS[k], 0.0)), TILTED) for name, k in (("A", 0), ("D", 3))}
    bodies = [fmb.Ground(markers=ends), bar("c", 0, eps), bar("k", 1, -eps), bar("r", 2, 2 * eps)]
    pins = (("ground.A", "c.l"), ("c.r", "k.l"), ("k.r", "r.l"), ("r.r", "ground.D"))
    joints = [fmb.Revolute(name, markers=pair) for name, pair in zip("ABCD", pins, strict=True)]
    return fmb.Model(bodies=bodies, joints=joints, gravity=tuple(TILTED @ (0, -9.81, 0)))


def by_hand() -> np.ndarray:
    """Angular accelerations of the three bars from rest: M a = Q + A^T lam, A a = 0 in their angles."""
    d = np.diff(POINTS, axis=0)
    across = np.column_stack([-d[:, 1], d[:, 0]])  # d(end)/d(angle)
    M, Q = 0.1 * np.eye(3), np.zeros(3)
    for k in range(3):
        J = np.zeros((2, 3))
        J[:, :k], J[:, k] = across[:k].T, 0.5 * across[k]
        M, Q = M + J.T @ J, Q + J.T @ (0.0, -9.81)
    whole = np.block([[M, -across], [across.T, np.zeros((2, 2))]])
    return np.linalg.solve(whole, np.concatenate([Q, np.zeros(2)]))[:3]


@pytest.mark.parametrize("eps", TURNS)
def test_all_formulations_move_as_the_plane_linkage(eps):
    model, exact = linkage(eps), by_hand()
    reference = fmb.accelerations(model)
    np.testing.assert_allclose(reference.a[5::6], exact, rtol=1e-6)
    for formulation in FORMULATIONS:
        found = fmb.accelerations(model, formulation=formulation)
        np.testing.assert_allclose(found.a[5::6], exact, rtol=1e-6, err_msg=repr(formulation))
        np.testing.assert_allclose(found.lam, reference.lam, rtol=0, atol=1e-6 * np.abs(reference.lam).max())


@pytest.mark.parametrize("eps", TURNS)
def test_the_matrices_know_the_same_freedom(eps):
    found, exact = fmb.equations(linkage(eps)), by_hand()
    solved = found.solve()
    assert (solved.rank, found.complement.shape) == (17, (18, 1))
    np.testing.assert_allclose(solved.a[5::6], exact, rtol=1e-6)
    np.testing.assert_allclose(found.M @ solved.a, found.Q + found.A.T @ solved.multipliers, atol=2e-6 * 9.81)
    assert np.abs(solved.multipliers).max() < 20.0  # the weight of the bars is 29 N
    assert np.abs(found.A @ found.complement).max() < 10.0 * max(eps, 1e-15)
    assert np.linalg.matrix_rank(found.A_pinv, rtol=1e-10) == 17
    turned = found.in_euler_parameters()
    np.testing.assert_allclose((turned.B @ turned.solve().a + turned.Bdot_u)[5::6], exact, rtol=1e-6)
    for cut in ((), ("B",)):
        turns = found.in_joint_coordinates(cut).solve().a
        assert len(turns) == 3
        np.testing.assert_allclose(turns[0], exact[0], rtol=1e-6)


@pytest.mark.parametrize("formulation", [fmb.NullSpace(), fmb.UdwadiaPhohomsiri()], ids=("null space", "udwadia"))
def test_runs_end_where_those_of_parallel_axes_do(formulation):
    ends = [
        fmb.simulate(linkage(eps), t_end=0.3, samples=3, integrator=fmb.Explicit(formulation=formulation)).final.q
        for eps in (0.0, 1e-8)
    ]
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-6)
    assert np.abs(ends[1][:3] - np.array(linkage(0.0).bodies[1].at)).max() > 1e-2


@pytest.mark.parametrize("eps", [1e-9, 1e-7])
def test_linearisation_keeps_the_freedom(eps):
    exact, found = (np.sort(fmb.linearize(linkage(x)).eigenvalues.real) for x in (0.0, eps))
    assert len(found) == 2
    np.testing.assert_allclose(found, exact, rtol=1e-5)


def test_a_dead_centre_that_is_left_depends_no_longer():
    """A rhomboid laid flat: its closure along the bars depends on the rest there, and nowhere else."""
    ground = fmb.Ground(markers={"A": (0, 0, 0), "D": (2, 0, 0)})
    bars = [
        fmb.RigidBody(n, mass=1.0, inertia=(0.1, 0.1, 0.1), at=at, markers={"l": (-h, 0, 0), "r": (h, 0, 0)})
        for n, at, h in (("c", (0.5, 0, 0), 0.5), ("k", (2.0, 0, 0), 1.0), ("r", (2.5, 0, 0), 0.5))
    ]
    pins = (("ground.A", "c.l"), ("c.r", "k.l"), ("k.r", "r.r"), ("r.l", "ground.D"))
    model = fmb.Model(bodies=[ground, *bars], joints=[fmb.Revolute(n, markers=p) for n, p in zip("ABCD", pins)])
    system, flat = assemble(model)
    assert len(system.redundant) == 4
    turn, q = 0.4, flat.q.copy()
    for k, place in enumerate(((0.5, 0.0), (1.0, 0.0), (2.0, 0.0))):
        at = 7 * k
        if k == 1:
            q[at : at + 2] = np.cos(turn) + 1.0, np.sin(turn)
            continue
        q[at : at + 2] = place[0] + 0.5 * np.cos(turn) - (0.5 if k == 0 else 0.0), 0.5 * np.sin(turn)
        q[at + 3 : at + 7] = np.cos(turn / 2), 0, 0, np.sin(turn / 2)
    for state, count in ((flat, 4), (flat._replace(q=q), 3)):
        e = equations_at(system, state, system.workspace())
        assert len(still_dependent(system, e.M, e.G)) == count
        assert len(e.dependent) == count


def test_rounding_is_no_contradiction():
    """b of 1e-17 beside accelerations of 3 m/s^2 is what remains of terms that cancel; 1e-3 is none."""
    A = ((1.0, 1.0, 0.0), (1.0, 1.0, 0.0))
    found = fmb.udwadia.solve(np.eye(3), (1.0, 2.0, 3.0), A, (0.0, 1e-17))
    np.testing.assert_allclose(found.a, (-0.5, 0.5, 3.0), atol=1e-15)
    with pytest.raises(FlexmbError, match="has no solution"):
        fmb.udwadia.solve(np.eye(3), (1.0, 2.0, 3.0), A, (0.0, 1e-3))
    with pytest.raises(FlexmbError, match=r"rank = 3.*whole number from 0 to 2"):
        fmb.udwadia.solve(np.eye(3), (1.0, 2.0, 3.0), A, (0.0, 0.0), rank=3)


def test_many_equations_are_searched_as_few_are(monkeypatch):
    """Row by row, and by singular values; as many loops as take minutes by the latter take a second by the former."""
    system, state = assemble(four_bars(12))
    e = equations_at(system, state, system.workspace())
    found = []
    for most in (0, 10**9):
        monkeypatch.setattr(sys.modules[still_dependent.__module__], "DENSE", most)
        found.append(still_dependent(system, e.M, e.G).tolist())
    assert found[0] == found[1] == list(system.redundant)
    assert len(found[0]) == 3 * 12
