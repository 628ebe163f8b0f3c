"""RB21: angular accelerations of a horizontal chain of slender rods at its release; exact rational solution.

Reached: 8e-14 for three links; for ten links 1e-14 of the largest one (the smallest is 1e5 times smaller).
"""

import numpy as np
import pytest

import flexmb as fmb


@pytest.mark.parametrize("n", [3, 10])
def test_accelerations(reference, n):
    expected = np.array(reference("RB21")["reference"][f"n={n}"])
    links = [fmb.RigidBody.rod(f"l{k}", length=1.0, mass=1.0, at=(k, 0, 0)) for k in range(n)]
    names = ["ground.origin"] + [f"l{k}.end" for k in range(n)]
    joints = [fmb.Revolute(f"j{k}", markers=(names[k], f"l{k}.start")) for k in range(n)]
    found = fmb.accelerations(fmb.Model(gravity=(0, -1.0, 0), bodies=[fmb.Ground(), *links], joints=joints))
    angular = np.array([found[f"l{k}"][5] for k in range(n)])
    np.testing.assert_allclose(angular, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
