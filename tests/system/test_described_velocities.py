"""A velocity that contradicts its joint is told as it is described: in world axes, without digits that are rounding."""

import numpy as np
import pytest

import flexmb as fmb


def test_it_is_told_in_world_axes():
    """A slide along x holds a body that is drawn turned about z; of (3, 4, 0) m/s along it, (3, 0, 0) stays."""
    turned = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    along = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 0, 1)).matrix
    slider = fmb.RigidBody(
        "slider",
        mass=1.0,
        inertia=(1, 1, 1),
        rotation=turned,
        velocity=(3.0, 4.0, 0.0),
        markers={"along": fmb.Pose((0, 0, 0), turned.T @ along)},
    )
    rail = fmb.Ground(markers={"along": fmb.Pose((0, 0, 0), along)})
    model = fmb.Model(bodies=[rail, slider], joints=[fmb.Prismatic("slide", markers=("ground.along", "slider.along"))])
    with pytest.warns(fmb.ValidityWarning, match="contradicts") as caught:
        fmb.simulate(model, 0.01, samples=2)
    words = next(str(w.message) for w in caught if "contradicts" in str(w.message))
    assert "its velocity as described, (3, 4, 0) m/s, contradicts Joint 'slide', and became (3, 0, 0) m/s" in words
