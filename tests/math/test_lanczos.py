"""Block Lanczos against closed forms and dense algebra."""

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import eigh
from tolerances import MACHINE

from flexmb.math.factor import factor
from flexmb.math.lanczos import lowest_modes


def square(n):
    D = sparse.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(n, n))
    eye = sparse.eye(n)
    return (sparse.kron(D, eye) + sparse.kron(eye, D)).tocsr()


@pytest.mark.parametrize("count", [1, 7, 40, 150])
def test_square_membrane_with_its_double_modes(count):
    """Finite-difference membrane: w2 = 4 - 2 cos(i pi / (n+1)) - 2 cos(j pi / (n+1)); (i, j) and (j, i) coincide."""
    n = 20
    one = 2.0 - 2.0 * np.cos(np.arange(1, n + 1) * np.pi / (n + 1))
    expected = np.sort((one[:, None] + one).ravel())[:count]
    K = square(n)
    w2, X = lowest_modes(factor(K).solve, lambda x: x, n * n, count)
    np.testing.assert_allclose(w2, expected, rtol=MACHINE)
    assert np.abs(X.T @ X - np.eye(count)).max() < MACHINE
    assert np.abs(K @ X - X * w2).max() < 1e-7


def test_generalised_problem_with_a_start(rng):
    n = 120
    A, B = rng.standard_normal((2, n, n))
    K, M = A @ A.T + n * np.eye(n), B @ B.T + n * np.eye(n)
    expected, shapes = eigh(K, M)
    w2, X = lowest_modes(lambda b: np.linalg.solve(K, b), lambda x: M @ x, n, 10, start=shapes[:, :10] + 1e-3)
    np.testing.assert_allclose(w2, expected[:10], rtol=1e-10)
    assert np.abs(X.T @ M @ X - np.eye(10)).max() < 10 * MACHINE


def test_fewer_masses_than_asked_modes():
    """Ten masses on a string of forty points: ten modes exist, equal to those of the condensed flexibility."""
    K = sparse.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(40, 40)).tocsr()
    mass = np.r_[np.ones(10), np.zeros(30)]
    w2, X = lowest_modes(factor(K).solve, lambda x: mass[:, None] * x, 40, 30)
    flexibility = np.linalg.inv(K.toarray())[:10, :10]
    np.testing.assert_allclose(w2, 1.0 / eigh(flexibility, eigvals_only=True)[::-1], rtol=1e-10)
    assert X.shape == (40, 10)


def test_a_body_of_which_nothing_with_mass_moves_has_no_modes():
    w2, X = lowest_modes(lambda x: 0.0 * x, lambda x: x, 12, 6)
    assert w2.shape == (0,)
    assert X.shape == (12, 0)
