"""Springs whose markers meet have no line: `linearize` says what then does not count.

A mass on a guide, with a spring and a damper between two markers that meet at rest, obeys m x'' + c x' + k x = 0.
"""

from __future__ import annotations

import numpy as np
import pytest

import flexmb as fmb

STIFFNESS, DAMPING = 2.0, 3.0


def guided(force: fmb.Force, velocity: float = 0.0) -> fmb.Model:
    """Return 1 kg on a guide along x."""
    along = fmb.Pose.axes(z=(1, 0, 0))
    body = fmb.RigidBody("mass", mass=1.0, inertia=(1, 1, 1), velocity=(velocity, 0, 0), markers={"end": along})
    return fmb.Model(
        bodies=[fmb.Ground(markers={"guide": along}), body],
        joints=[fmb.Prismatic("slide", markers=("ground.guide", "mass.end"))],
        forces=[force],
        sensors=[fmb.JointCoordinate("x", joint="slide")],
    )


def spring(**given) -> fmb.SpringDamper:
    """Return a spring between two markers that meet."""
    return fmb.SpringDamper("spring", markers=("ground.guide", "mass.end"), stiffness=STIFFNESS, **given)


@pytest.mark.parametrize(
    ("given", "lost"),
    [
        ({"damping": DAMPING}, "its damping cannot count"),
        ({"damping": DAMPING, "length": 0.0}, "its damping cannot count"),
        ({"preload": 1.0}, "its preload cannot count"),
        ({"length": 0.1}, "its length cannot count"),
    ],
)
def test_what_has_no_direction_is_told(given, lost):
    with pytest.warns(fmb.ValidityWarning, match=f"'spring', linearize: its markers meet.*{lost}"):
        fmb.linearize(guided(spring(**given)))


@pytest.mark.filterwarnings("error::flexmb.ValidityWarning")
def test_a_spring_without_length_needs_none():
    values = fmb.linearize(guided(spring())).eigenvalues
    np.testing.assert_allclose(values, [1j * STIFFNESS**0.5], rtol=1e-9)


@pytest.mark.filterwarnings("error::flexmb.ValidityWarning")
def test_a_bushing_has_axes():
    bushing = fmb.Bushing(
        "mount",
        markers=("ground.guide", "mass.end"),
        stiffness=(0, 0, STIFFNESS, 0, 0, 0),
        damping=(0, 0, DAMPING, 0, 0, 0),
    )
    values = fmb.linearize(guided(bushing)).eigenvalues  # s^2 + 3 s + 2 = 0
    np.testing.assert_allclose(np.sort(values.real), [-2.0, -1.0], rtol=1e-9)


@pytest.mark.filterwarnings("error::flexmb.ValidityWarning")
def test_the_motion_gives_it_a_direction():
    """x = v (e^-t - e^-2t), the closed form of s^2 + 3 s + 2."""
    run = fmb.simulate(guided(spring(damping=DAMPING), 1.0), 1.0, samples=3)
    np.testing.assert_allclose(run["x"], np.exp(-run.t) - np.exp(-2.0 * run.t), atol=2e-4)
