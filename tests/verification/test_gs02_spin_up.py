"""GS02: spin-up of Kane, Ryan & Banerjee (J. Guidance 10, 1987), planar; reference: geometrically exact elastica.

With geometric stiffness the reference, without it a beam that bends too far, and in the frame clamped at the root (the
floating frame of the textbooks) flies apart once the speed passes its first bending frequency, 2.9 rad/s.
"""

import numpy as np
import pytest
from verification.rotating_beams import spin_up, spin_up_beam

LENGTH, YOUNG, AREA, INERTIA, DENSITY = 8.0, 6.895e10, 7.2968e-5, 8.2181e-9, 2766.67


def beam(**options):
    return spin_up_beam(LENGTH, YOUNG * AREA, YOUNG * INERTIA, DENSITY * AREA, **options)


@pytest.mark.parametrize(("frame", "residual"), [("buckens", 1.1e-2), ("root", 1e-2)])
def test_with_geometric_stiffness(reference, frame, residual):
    """The residual vibration is what the vibrations of the start and of the end of the spin-up, 8 and 6 mm, leave of
    each other: a phase error of a few degrees, from a deflection of a tenth of the length, shows in it."""
    case = reference("GS02")["reference"]
    t, u = spin_up(beam(frame=frame), LENGTH)
    lowest = int(u[:, 1].argmin())
    assert u[lowest, 1] == pytest.approx(case["max_tip_lag"], rel=0.01)
    assert t[lowest] == pytest.approx(case["t_max"], abs=0.06)
    assert np.abs(u[t > 15.0, 1]).max() < residual
    for time, (_, across) in case["samples"].items():
        assert u[np.searchsorted(t, float(time) - 1e-9), 1] == pytest.approx(across, abs=8e-3)


def test_clamped_frame_without_it_diverges():
    _, u = spin_up(beam(frame="root"), LENGTH, geometric_stiffness=False, rtol=1e-5)
    assert np.abs(u[:, 1]).max() > 100.0 * LENGTH


def test_buckens_frame_without_it_is_wrong(reference):
    """That frame turns with the beam, which holds a part of the stiffening: no break-down, but a third too much lag."""
    _, u = spin_up(beam(), LENGTH, geometric_stiffness=False, rtol=1e-5)
    assert u[:, 1].min() < 1.3 * reference("GS02")["reference"]["max_tip_lag"]
