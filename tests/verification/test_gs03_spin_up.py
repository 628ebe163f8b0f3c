"""GS03: spin-up of Simo & Vu-Quoc (J. Appl. Mech. 53, 1986); reference: geometrically exact elastica.

The body frame may be Buckens' or clamped at the root: the motion is the same.
"""

import numpy as np
import pytest
from verification.rotating_beams import spin_up, spin_up_beam

LENGTH = 10.0


def beam(**options):
    return spin_up_beam(LENGTH, 2.8e7, 1.4e4, 1.2, **options)


@pytest.fixture(scope="module")
def motion():
    return spin_up(beam(), LENGTH)


def test_lag(reference, motion):
    case, (t, u) = reference("GS03")["reference"], motion
    lowest = int(u[:, 1].argmin())
    assert u[lowest, 1] == pytest.approx(case["max_tip_lag"], rel=0.01)
    assert t[lowest] == pytest.approx(case["t_max"], abs=0.06)
    for time, (_, across) in case["samples"].items():
        assert u[np.searchsorted(t, float(time) - 1e-9), 1] == pytest.approx(across, abs=2e-3)


def test_steady_stretch(reference, motion):
    t, u = motion
    stretch = reference("GS03")["reference"]["steady_stretch_first_order_rho_w2_L3_over_3EA"]
    assert u[t > 16.0, 0].mean() == pytest.approx(stretch, rel=0.01)


def test_buckens_and_clamped_frame_agree(motion):
    t, u = motion
    _, clamped = spin_up(beam(frame="root"), LENGTH)
    np.testing.assert_allclose(clamped[t < 15.0, 1], u[t < 15.0, 1], rtol=0, atol=2e-3 * np.abs(u[:, 1]).max())


def test_without_geometric_stiffness_it_diverges():
    _, u = spin_up(beam(frame="root"), LENGTH, geometric_stiffness=False, rtol=1e-5)
    assert np.abs(u[:, 1]).max() > 100.0 * LENGTH


def test_reactions_at_the_support_stiffen_nothing():
    """The unit loads are balanced at the root: what stiffens the free beam are the inertia loads alone."""
    few = beam()
    _, inertia = spin_up(few, LENGTH, t_end=8.0, samples=81, geometric_stiffness=("inertia",))
    _, everything = spin_up(few, LENGTH, t_end=8.0, samples=81)
    np.testing.assert_allclose(inertia, everything, rtol=0, atol=1e-9)
