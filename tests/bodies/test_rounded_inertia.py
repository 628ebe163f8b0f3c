"""Inertia tensors of slender bodies that are turned in space, in numbers of few digits.

Reference: the principal values that the tensor was made of; a rod without a moment about its axis turns about it by no
law.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmb as fmb

MOMENTS = (0.0, 1 / 12, 1 / 12)


def turned(seed, moments, written):
    """Return the rotation (3, 3) and the tensor in turned axes, written in some way."""
    turn = Rotation.random(random_state=seed).as_matrix()
    return turn, written(turn @ np.diag(moments) @ turn.T)


def single(J):
    return J.astype(np.float32).astype(float)


def decimals(digits):
    return np.vectorize(lambda x: float(f"{x:.{digits - 1}e}"))


@pytest.mark.parametrize("written", [single, decimals(7), decimals(8), lambda J: J])
@pytest.mark.parametrize("seed", range(3))
def test_a_free_turn_about_an_axis_without_inertia_is_named(written, seed):
    """In 32 bits such rods turned at 4 to 2 000 000 rad/s after 0.5 s, without a word."""
    turn, J = turned(seed, MOMENTS, written)
    end = tuple(turn @ (-0.5, 0, 0))
    rod = fmb.RigidBody("rod", mass=1.0, inertia=J, at=(0.5, 0, 0), rotation=turn.T, markers={"a": end})
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), rod],
        joints=[fmb.Spherical("j", markers=("ground.origin", "rod.a"))],
    )
    with pytest.raises(fmb.errors.CompileError, match="no inertia about its"):
        fmb.simulate(model, 0.1, samples=3)


@pytest.mark.parametrize(
    ("moments", "written"),
    [((1e-5, 1, 1), single), ((1e-5, 1, 1), decimals(7)), ((2e-3, 1, 1), decimals(4)), ((1e-9, 1, 1), lambda J: J)],
)
def test_a_moment_that_has_digits_is_kept(moments, written):
    """Slender, but told from rounding: the numbers stay as they are."""
    _, J = turned(1, moments, written)
    np.testing.assert_array_equal(fmb.RigidBody("b", mass=1.0, inertia=J).inertia, 0.5 * (J + J.T))


def test_whole_numbers_are_meant():
    J = [[1, 0.999, 0], [0.999, 1, 0], [0, 0, 1.999]]
    assert np.linalg.eigvalsh(fmb.RigidBody("b", mass=1.0, inertia=J).inertia)[0] == pytest.approx(1e-3)
