"""The same part in other axes, mirrored, or in other units moves alike.

A spinning block on a ball joint under gravity and an end force, with geometric stiffness: large rotations, so that a
wrong invariant or marker shows at once. The outside reference of each motion is the motion of the data as reduced.
"""

import numpy as np
import pytest
from reduction.solids import block
from scipy.spatial.transform import Rotation
from tolerances import SOLVER

import flexmb as fmb
from flexmb import reduction

TURN = Rotation.from_rotvec([0.3, -0.8, 0.5])
MOVE = np.array([0.1, -0.3, 0.2])
MIRROR = np.diag([1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def data():
    return reduction.reduce(
        block((0.8, 0.02, 0.015), (6, 1, 1)),
        {"a": "left", "b": "right"},
        modes=2,
        geometric_stiffness=True,
        loads={"air": "top"},
        compare=0,
    )


def motion(data, *, at=(0.0, 0.0, 0.0), rotation=None, mirror=None, length=1.0, mass=1.0, joint=None):
    """Return the path of b and the stress there, in the units of the data."""
    Q = np.eye(3) if mirror is None else mirror
    s = np.linalg.det(Q)
    anchor = length * Q @ (data.marker_positions[0] if joint is None else joint)
    spin = s * Q @ (4.0, 9.0, -20.0)
    model = fmb.Model(
        gravity=tuple(length * Q @ (0.0, 0.0, -9.81)),
        bodies=[
            fmb.Ground(markers={"O": tuple(anchor)}),
            fmb.FloatingBody(
                "part",
                data=data,
                at=at,
                rotation=rotation,
                damping=0.01,
                angular_velocity=tuple(spin),
                velocity=tuple(np.cross(spin, np.asarray(at) - anchor)),
            ),
        ],
        joints=[fmb.Spherical("O", markers=("ground.O", "part.a"))],
        forces=[fmb.PointLoad("push", marker="part.b", force=tuple(mass * length * Q @ (3.0, 20.0, 5.0)))],
        sensors=[fmb.Position("b", marker="part.b"), fmb.Stress("stress", body="part")],
    )
    solution = fmb.simulate(model, t_end=0.05, samples=6, integrator=fmb.GeneralizedAlpha(step=2.5e-4))
    assert solution.status.ok
    return solution["b"], solution["stress"]


@pytest.fixture(scope="module")
def reference(data):
    path, stress = motion(data)
    assert np.linalg.norm(path[-1] - path[0]) > 0.3
    return path, stress


def assert_alike(found, expected):
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=10 * SOLVER * np.abs(b).max())


def test_other_axes(data, reference):
    """x' = R x + d, and the body placed so that it is where it was."""
    changed = data.rotated(TURN).translated(MOVE)
    back = TURN.inv()
    found = motion(changed, at=tuple(-back.apply(MOVE)), rotation=back, joint=data.marker_positions[0])
    assert_alike(found, reference)


def test_mirror(data, reference):
    """The mirrored part in the mirrored world."""
    path, stress = motion(data.mirrored("xz"), mirror=MIRROR, joint=data.marker_positions[0])
    assert_alike((path @ MIRROR, stress), reference)


def test_units(data, reference):
    """Tonnes and millimetres: forces in N, stress in MPa."""
    path, stress = motion(data.rescaled(length=1e3, mass=1e-3), length=1e3, mass=1e-3, joint=data.marker_positions[0])
    assert_alike((path / 1e3, stress * 1e6), reference)
