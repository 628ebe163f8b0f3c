"""`fmb.udwadia.solve` and `fmb.equations`: any mass matrix, any coordinates.

References: Newton and Euler by hand, closed forms, Udwadia & Phohomsiri's formula as printed (numpy's pseudo-inverse).
"""

import numpy as np
import pytest
from integrate.test_random_constraints import random_model
from scipy import sparse
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.errors import FlexmbError, ModelError


def printed(M, Q, A, b):
    """Udwadia & Phohomsiri 2006, eq. 3.13, as it stands."""
    project = np.eye(len(M)) - np.linalg.pinv(A) @ A
    return np.linalg.pinv(np.vstack([project @ M, A])) @ np.concatenate([Q, b])


@pytest.mark.parametrize("seed", range(8))
def test_formula_as_printed_for_singular_masses_and_dependent_constraints(seed):
    """Rank 5 of 7, three of five constraints independent."""
    rng = np.random.default_rng(seed)
    n, m, rank = 7, 5, 3
    half = rng.normal(size=(n, 5))
    M, Q = half @ half.T, rng.normal(size=n)
    A = rng.normal(size=(m, rank)) @ rng.normal(size=(rank, n))
    b = A @ rng.normal(size=n)
    found = fmb.udwadia.solve(M, Q, A, b)
    assert (found.rank, found.rank_of_both) == (rank, n)
    np.testing.assert_allclose(found.a, printed(M, Q, A, b), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(M @ found.a, Q + A.T @ found.multipliers, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(A @ found.a, b, rtol=1e-10, atol=1e-10)


def test_units_do_not_decide_ranks():
    """A mass of 1e-9 kg beside one of 1e9, and constraints in mm and km."""
    M, Q = np.diag((1e-9, 1e9, 2.0)), np.array((1.0, 2.0, 3.0))
    A, b = np.array(((1e-12, 1e-12, 0.0), (0.0, 1e9, 1e9))), np.array((1e-12, 0.0))
    found = fmb.udwadia.solve(M, Q, A, b)
    # x + y = 1, y = -z: with z free, (1e-9 + 1e9 + 2) z = load of z = 1e-9 * ... by hand
    z = (1.0 - 2.0 + 3.0 - 1e-9) / (1e-9 + 1e9 + 2.0)
    np.testing.assert_allclose(found.a, (1.0 + z, -z, z), rtol=1e-10)
    assert found.rank == 2


def test_conditions_that_fail_are_named():
    solve = fmb.udwadia.solve
    with pytest.raises(FlexmbError, match=r"rank \[M; A\] = 1 of 2: a motion, most of coordinate 1"):
        solve(np.diag((1.0, 0.0)), (0, 0), [[1.0, 0.0]], [0.0])
    with pytest.raises(FlexmbError, match=r"A a = b has no solution: row [01] misses"):
        solve(np.eye(2), (0, 0), [[1.0, 0.0], [2.0, 0.0]], [1.0, 1.0])
    with pytest.raises(FlexmbError, match="negative eigenvalue"):
        solve(np.diag((1.0, -1.0)), (0, 0), [[1.0, 0.0]], [0.0])
    with pytest.raises(FlexmbError, match="differs from its transpose"):
        solve([[1.0, 0.5], [0.0, 1.0]], (0, 0), [[1.0, 0.0]], [0.0])
    with pytest.raises(FlexmbError, match=r"A of shape \(1, 3\)"):
        solve(np.eye(2), (0, 0), [[1.0, 0.0, 0.0]], [0.0])
    with pytest.raises(FlexmbError, match="no numbers"):
        solve(np.eye(2), (0, np.nan), [[1.0, 0.0]], [0.0])
    with pytest.raises(FlexmbError, match=r"weights\[1\] = -1"):
        solve(np.eye(2), (0, 0), [[1.0, 0.0]], [0.0], weights=(1.0, -1.0))


def test_no_constraints_is_newton():
    np.testing.assert_allclose(fmb.udwadia.solve(np.diag((2.0, 4.0)), (2, 2), np.zeros((0, 2)), ()).a, (1.0, 0.5))


def test_singular_mass_of_euler_parameters_is_newton_and_euler():
    """A free body: M has rank 6 of 7; w' = J^-1 (tau - w x J w) from p'' = 1/2 p o (0, w') - |p'|^2 p."""
    rng = np.random.default_rng(3)
    J, w, v, R = np.diag((1.0, 2.0, 2.5)), rng.normal(size=3), rng.normal(size=3), rng.normal(size=3)
    body = fmb.RigidBody("b", mass=2.0, inertia=np.diag(J), rotation=R, velocity=v, angular_velocity=w)
    load = fmb.PointLoad("load", marker="b.center", force=(1, 2, 3), moment=(0.3, -0.2, 0.5))
    model = fmb.Model(bodies=[body], forces=[load], gravity=(0, 0, -9.81))
    found = fmb.equations(model).in_euler_parameters()
    assert np.linalg.matrix_rank(found.M) == 6
    solved = found.solve()
    p = found.state.q[3:7]
    turn = Rotation.from_quat(np.roll(p, -1)).as_matrix()
    own = turn.T @ w
    rate = np.linalg.solve(J, turn.T @ (0.3, -0.2, 0.5) - np.cross(own, J @ own))

    def product(a, b):
        return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])

    dp = 0.5 * product(p, np.concatenate([[0.0], own]))
    ddp = 0.5 * product(p, np.concatenate([[0.0], rate])) - dp @ dp * p
    np.testing.assert_allclose(found.u[3:], dp, atol=1e-14)
    np.testing.assert_allclose(solved.a[:3], np.array((1, 2, 3)) / 2.0 + (0, 0, -9.81), rtol=1e-12)
    np.testing.assert_allclose(solved.a[3:], ddp, rtol=1e-11, atol=1e-12)


def four_bar(more=()) -> fmb.Model:
    """A closed loop with a ball that turns freely on its coupler, planar: three dependent equations."""
    rng = np.random.default_rng(5)
    inertia = (0.01, 0.02, 0.03)
    links = {
        "crank": ((0, 0, 0), (0, 0.1, 0)),
        "rod": ((0, 0.1, 0), (0.3, 0.2, 0)),
        "rocker": ((0.3, 0.2, 0), (0.3, 0, 0)),
    }
    bodies = [fmb.Ground(markers={"A": (0, 0, 0), "D": (0.3, 0, 0)})]
    for name, (start, end) in links.items():
        way = tuple(np.subtract(end, start))
        bodies.append(
            fmb.RigidBody(name, mass=1.0 + rng.uniform(), inertia=inertia, at=start, markers={"s": (0, 0, 0), "e": way})
        )
    bodies.append(
        fmb.RigidBody(
            "ball", mass=0.3, inertia=inertia, at=(0.3, 0.2, 0), markers={"s": (0, 0, 0)}, angular_velocity=(1, 2, 3)
        )
    )
    joints = [
        fmb.Revolute("A", markers=("ground.A", "crank.s")),
        fmb.Revolute("B", markers=("crank.e", "rod.s")),
        fmb.Revolute("C", markers=("rod.e", "rocker.s")),
        fmb.Revolute("D", markers=("rocker.e", "ground.D")),
        fmb.Spherical("S", markers=("rod.e", "ball.s")),
        *more,
    ]
    return fmb.Model(bodies=bodies, joints=joints, gravity=(0.5, -9.81, 0.2))


@pytest.mark.parametrize("driven", [False, True])
def test_all_coordinates_give_the_same_accelerations(driven):
    more = [fmb.Drive("motor", joint="A", angle=fmb.expression("3*t + t**2"))] if driven else []
    model = four_bar(more)
    expected = fmb.accelerations(model)
    bodies = fmb.equations(model)
    for found in (bodies, bodies.in_euler_parameters(), bodies.in_joint_coordinates()):
        solved = found.solve()
        np.testing.assert_allclose(found.B @ solved.a + found.Bdot_u, expected.a, rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(found.velocity, 0.0, atol=1e-9)
        np.testing.assert_allclose(found.A @ found.complement, 0.0, atol=1e-9)
        partial, rate = found.partial_velocity("ball.center")
        np.testing.assert_allclose((partial @ solved.a + rate)[:3], expected["ball"][:3], rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(found.A @ found.A_pinv @ found.A, found.A, atol=1e-9)
    names = bodies.in_joint_coordinates().equation_names
    assert len(names) <= 6
    assert bodies.in_euler_parameters().M.shape == (28, 28)


def test_only_velocities_of_bodies_are_turned_into_others():
    turned = fmb.equations(four_bar()).in_euler_parameters()
    with pytest.raises(ModelError, match="other coordinates than velocities of bodies"):
        turned.in_joint_coordinates()
    with pytest.raises(ModelError, match=r"ball\.nose"):
        turned.partial_velocity("ball.nose")


def test_sparse_matrices_are_the_same_numbers():
    """In velocities, Euler-parameter rates and joint coordinates; a chain of 60 bodies is mostly empty."""
    model = random_model(np.random.default_rng(44), 4)
    full, thin = fmb.equations(model), fmb.equations(model, as_sparse=True)
    for one, two in (
        (full, thin),
        (full.in_euler_parameters(), thin.in_euler_parameters()),
        (full.in_joint_coordinates(), thin.in_joint_coordinates()),
    ):
        assert one.names == two.names
        for name in ("M", "A", "L", "B"):
            assert sparse.issparse(getattr(two, name))
            np.testing.assert_allclose(getattr(two, name).toarray(), getattr(one, name), atol=1e-14)
        np.testing.assert_allclose(two.solve().a, one.solve().a, atol=1e-11)
        N, P = one.complement, two.complement  # bases of one space
        np.testing.assert_allclose(P @ P.T, N @ N.T, atol=1e-10)
        np.testing.assert_allclose(two.A_pinv, one.A_pinv, atol=1e-12)
        np.testing.assert_allclose(two.partial_velocity("b0.e")[0], one.partial_velocity("b0.e")[0], atol=1e-14)
    links = [fmb.RigidBody.rod(f"l{k}", length=1.0, mass=1.0, radius=0.01, at=(k, 0, 0)) for k in range(60)]
    pins = [fmb.Revolute(f"j{k}", markers=(f"l{k}.end", f"l{k + 1}.start")) for k in range(59)]
    chain = fmb.equations(fmb.Model(bodies=links, joints=pins), as_sparse=True)
    assert chain.M.nnz + chain.A.nnz < 0.05 * (360 * 360 + chain.A.shape[0] * 360)
