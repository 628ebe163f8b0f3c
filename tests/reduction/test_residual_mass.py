"""Rubin's and MacNeal's shapes are the same; only one has the mass of the residual.

A beam of frame elements, ends clamped by joints that the basis does not know. Own sums with the full matrices
(LAPACK): free modes and residual flexibility of both ends, as the papers of 1971 and 1975 have them. The package's
basis must be the one with mass.
"""

import numpy as np
import pytest
from scipy.linalg import eigh, null_space

import flexmb as fmb
from flexmb import fem, reduction

FREE, RIGID = 4, 6


@pytest.fixture(scope="module")
def fe():
    points = np.column_stack([np.linspace(0.0, 1.0, 31), np.zeros((31, 2))])
    return fem.frame(points=points, section=fem.Section.rectangle(0.02, 0.03), material=fmb.MATERIALS["steel"])


def clamped(K, M, motions) -> np.ndarray:
    """Return the squared frequencies, lowest first, where the motions (n, coordinates) of the ends are zero."""
    still = null_space(motions / np.abs(motions).max(axis=0))
    still = still / np.abs(motions).max(axis=0)[:, None]
    mu = eigh(still.T @ M @ still, still.T @ K @ still, eigvals_only=True)[::-1]
    return 1.0 / mu[mu > 1e-13 * mu[0]]


def test_mass_of_the_residual_is_worth_two_digits(fe):
    K, M = fe.K.toarray(), fe.M.toarray()
    size = len(K)
    ends = np.r_[0:6, size - 6 : size]
    inner = np.setdiff1d(np.arange(size), ends)
    exact = eigh(K[np.ix_(inner, inner)], M[np.ix_(inner, inner)], eigvals_only=True)[:4]
    squared, modes = eigh(K, M)
    kept, rest = modes[:, : RIGID + FREE], modes[:, RIGID + FREE :]
    basis = np.hstack([kept, rest / squared[RIGID + FREE :] @ rest[ends].T])
    stiffness, rubin = basis.T @ K @ basis, basis.T @ M @ basis
    macneal = rubin.copy()
    macneal[RIGID + FREE :], macneal[:, RIGID + FREE :] = 0.0, 0.0
    assert np.linalg.matrix_rank(macneal) == len(macneal) - len(ends)
    errors = {
        name: np.sqrt(clamped(stiffness, mass, basis[ends])[:4] / exact) - 1.0
        for name, mass in (("Rubin", rubin), ("MacNeal", macneal))
    }
    np.testing.assert_allclose(errors["MacNeal"], [0.0036, 0.0036, 0.0043, 0.0042], atol=1e-4)
    assert np.all(errors["Rubin"] > 0.0)
    assert np.all(100.0 * errors["Rubin"] < errors["MacNeal"])

    body = fmb.FloatingBody("beam", data=reduction.reduce(fe, {"a": [0], "b": [30]}, FREE, basis="Rubin", compare=0))
    ground = fmb.Ground(markers={"a": (0.0, 0.0, 0.0), "b": (1.0, 0.0, 0.0)})
    joints = [fmb.Fixed(f"at {end}", markers=(f"ground.{end}", f"beam.{end}")) for end in "ab"]
    found = fmb.linearize(fmb.Model(bodies=[ground, body], joints=joints)).frequencies[:4]
    np.testing.assert_allclose(2.0 * np.pi * found / np.sqrt(exact) - 1.0, errors["Rubin"], atol=1e-7)
