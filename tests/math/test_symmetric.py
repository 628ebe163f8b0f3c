"""Symmetry of matrices is judged by their own size: parts of a millimetre have inertias of 1e-15 kg m2."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.math.definiteness import symmetric

J = np.array([[2.0, 0.5, 0.0], [0.5, 3.0, -0.2], [0.0, -0.2, 2.5]])


@pytest.mark.parametrize("unit", [1e-18, 1.0, 1e18])
def test_the_unit_says_nothing(unit):
    wrong = J.copy()
    wrong[0, 1] = 0.4
    assert symmetric(unit * J)
    assert not symmetric(unit * wrong)
    assert symmetric(unit * (J + 1j * np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 0]])))  # Hermitian


def test_rows_of_other_units_are_not_compared():
    """A stiffness of 1e6 N/m beside 1e-3 N m/rad, of which a product is wrong by a tenth."""
    K = np.diag([1e6, 1e6, 1e6, 2e-3, 2e-3, 2e-3])
    K[3, 4] = K[4, 3] = 1e-3
    assert symmetric(K)
    K[3, 4] = 0.9e-3
    assert not symmetric(K)


def test_small_parts_with_unsymmetric_inertia_are_refused():
    """Before, tensors below 1e-8 kg m2 were taken as symmetric: products of one half were lost without a word."""
    wrong = 1e-15 * J
    wrong[0, 1] = 0.0
    message = r"inertia with J_xy = 0 and J_yx = 5e-16 kg m2\. Expected: .* symmetric"
    with pytest.raises(fmb.ModelError, match=message):
        fmb.RigidBody("b", mass=1e-6, inertia=wrong)
    fmb.RigidBody("b", mass=1e-6, inertia=1e-15 * J)
    stiffness = 1e-9 * np.diag(np.arange(1.0, 7.0))
    stiffness[0, 1] = 5e-10
    with pytest.raises(fmb.ModelError, match="symmetric"):
        fmb.Bushing("b", markers=("ground.origin", "b.center"), stiffness=stiffness)


def test_inertia_in_single_precision_is_made_symmetric(rng):
    """Of a part of a few centimetres, computed in 32 bits: products differ by 1e-7 of the moments."""
    apart = 0.0
    for R in Rotation.from_rotvec(rng.normal(size=(20, 3))).as_matrix():
        given = np.float32(R @ np.diag([1e-3, 2e-3, 2.5e-3])) @ np.float32(R.T)
        apart = max(apart, np.abs(given - given.T).max())
        kept = fmb.RigidBody("b", mass=1.0, inertia=given).inertia
        np.testing.assert_array_equal(kept, kept.T)
        np.testing.assert_allclose(kept, R @ np.diag([1e-3, 2e-3, 2.5e-3]) @ R.T, rtol=0.0, atol=2.5e-9)
    assert apart > 1e-11


def test_the_entries_that_are_too_far_apart_are_named():
    """Not those that differ most: the moments beside them permit it."""
    wrong = np.diag([1.0, 2.0, 2.5])
    wrong[2, 1] = 2e-6  # of sqrt(2.0 * 2.5) = 2.2
    wrong[0, 1] = 1.8e-6  # of sqrt(1.0 * 2.0) = 1.4
    with pytest.raises(fmb.ModelError, match=r"J_xy = 1\.8e-06 and J_yx = 0 kg m2"):
        fmb.RigidBody("b", mass=1.0, inertia=wrong)
