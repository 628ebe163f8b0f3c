"""Definite and semidefinite matrices of mixed units, tiny, huge and not finite."""

import numpy as np
import pytest

from flexmb.math.definiteness import definite, semidefinite

TURNED = np.array([[2.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 2.0]])  # eigenvalues 2, 2 +- sqrt(2)


@pytest.mark.parametrize("size", [1e-300, 1e-12, 1.0, 1e12, 1e300])
def test_size_does_not_matter(size):
    assert definite(size * TURNED)
    assert semidefinite(size * TURNED)
    assert not definite(size * (TURNED - 0.7 * np.eye(3)))  # 2 - sqrt(2) < 0.7
    assert not semidefinite(size * (TURNED - 0.7 * np.eye(3)))


def test_units_of_rows_do_not_matter():
    scale = np.array([1e-9, 1.0, 1e9])
    assert definite(TURNED * scale * scale[:, None])


def test_singular():
    ones = np.ones((3, 3))
    assert not definite(ones)
    assert semidefinite(ones)
    assert semidefinite(np.zeros((3, 3)))
    assert not definite(np.zeros((3, 3)))


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", [(0, 0), (0, 1)])
def test_not_finite(wrong, place):
    matrix = TURNED.copy()
    matrix[place] = matrix[place[::-1]] = wrong
    assert not definite(matrix)
    assert not semidefinite(matrix)
