"""Start poses of bodies as Euler parameters: drawn in the axes of W, they are those that the kernel gives."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.math.rotations import matrix_to_euler

TILTED = Rotation.from_rotvec([0.0, 1e-9, 0.0]).as_matrix()


@pytest.mark.parametrize("R", [np.eye(3), -0.0 + np.eye(3) * np.ones(3), TILTED], ids=["none", "signed", "tilted"])
def test_pose_of_a_body_is_that_of_the_kernel(R):
    q, _ = fmb.RigidBody("body", mass=1.0, inertia=(1, 1, 1), at=(1, 2, 3), rotation=R).initial_state()
    p = np.empty(4)
    matrix_to_euler(np.ascontiguousarray(R), p)
    assert q[3:].tobytes() == p.tobytes()
    x, y, z, w = Rotation.from_matrix(R).as_quat()
    np.testing.assert_allclose(q, [1, 2, 3, w, x, y, z], atol=1e-15)
