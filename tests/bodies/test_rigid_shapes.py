"""Mass properties of rigid bodies made from their dimensions."""

import numpy as np
import pytest
from tolerances import MACHINE, SOLVER

import flexmb as fmb
from flexmb.errors import ModelError


def test_slender_rod():
    """m L^2 / 12 across (textbook of the slender rod); along the axis a round rod of L / 100, r^2 m / 2."""
    rod = fmb.RigidBody.rod("rod", length=2.0, mass=3.0)
    np.testing.assert_allclose(np.diag(rod.inertia), [0.5 * 3.0 * 0.02**2, 1.0, 1.0], rtol=MACHINE)
    np.testing.assert_allclose(rod.center_of_mass, (1.0, 0.0, 0.0))


def test_round_rod():
    """Solid cylinder: m r^2 / 2 along, m (3 r^2 + L^2) / 12 across."""
    rod = fmb.RigidBody.rod("rod", length=0.5, mass=2.0, radius=0.1)
    across = 2.0 * (3 * 0.1**2 + 0.5**2) / 12
    np.testing.assert_allclose(np.diag(rod.inertia), [0.5 * 2.0 * 0.1**2, across, across], rtol=MACHINE)


def test_a_slender_rod_swings_in_space():
    """Hung on a ball joint at rest, horizontally: angular acceleration 3 g / (2 L); its own axis is not singular."""
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"O": (0, 0, 0)}), fmb.RigidBody.rod("rod", length=2.0, mass=3.0)],
        joints=[fmb.Spherical("O", markers=("ground.O", "rod.start"))],
    )
    np.testing.assert_allclose(fmb.accelerations(model)["rod"][3:], (0.0, 3 * 9.81 / (2 * 2.0), 0.0), atol=SOLVER)


@pytest.mark.parametrize("radius", [0.0, -0.1])
def test_a_radius_must_be_positive(radius):
    message = r"Body 'rod': radius = -?0\.[01]\. Expected: a number > 0 in SI units\. Give radius a value"
    with pytest.raises(ModelError, match=message):
        fmb.RigidBody.rod("rod", length=1.0, mass=1.0, radius=radius)


@pytest.mark.parametrize("given", [{"mass": 2.0}, {"inertia": (1.0, 1.0, 1.0)}])
def test_a_shape_with_a_density_has_its_mass(given):
    with pytest.raises(ModelError, match=r"Body 'camera': (mass|inertia) = .*density = mass/volume"):
        fmb.RigidBody.box("camera", size=(0.1, 0.1, 0.1), density=100.0, **given)
