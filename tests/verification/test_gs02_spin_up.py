"""GS02: spin-up of Kane, Ryan & Banerjee (J. Guidance 10, 1987), planar; reference: geometrically exact elastica.

With geometric stiffness the reference, without it a beam that bends too far, and in the frame clamped at the root (the
floating frame of the textbooks) flies apart once the speed passes its first bending frequency, 2.9 rad/s.
"""

import numpy as np
import pytest
from verification.rotating_beams import (
    DRIVE,
    angle,
    in_rotating_frame,
    on_hub,
    slender,
    spin_up,
    spin_up_beam,
)

import flexmb as fmb
from flexmb import fem, reduction

LENGTH, YOUNG, AREA, INERTIA, DENSITY = 8.0, 6.895e10, 7.2968e-5, 8.2181e-9, 2766.67


def beam(**options):
    return spin_up_beam(LENGTH, YOUNG * AREA, YOUNG * INERTIA, DENSITY * AREA, **options)


@pytest.mark.parametrize(("frame", "residual"), [("buckens", 1.1e-2), ("root", 1e-2)])
def test_with_geometric_stiffness(reference, frame, residual):
    """One body: the lag, 9.4 % of the length, is 0.24 % too large, whatever the modes and the tolerance, because the
    deformation is of first order in its frame. The residual vibration is what the vibrations of the start and of the
    end of the spin-up, 8 and 6 mm, leave of each other: a phase error of a few degrees shows in it."""
    case = reference("GS02")["reference"]
    t, u = spin_up(beam(frame=frame), LENGTH)
    lowest = int(u[:, 1].argmin())
    assert u[lowest, 1] == pytest.approx(case["max_tip_lag"], rel=4e-3)
    assert t[lowest] == pytest.approx(case["t_max"], abs=0.06)
    assert np.abs(u[t > 15.0, 1]).max() < residual
    for time, (_, across) in case["samples"].items():
        assert u[np.searchsorted(t, float(time) - 1e-9), 1] == pytest.approx(across, abs=4e-3)


@pytest.mark.slow
def test_four_parts_meet_the_reference(reference):
    """The errors of one body fall with the square of the number of parts: 0.24, 0.10, 0.027 and 0.007 % of the lag for
    1, 2, 4 and 8."""
    case = reference("GS02")["reference"]
    fe = slender(LENGTH, YOUNG * AREA, YOUNG * INERTIA, 50 * YOUNG * INERTIA, DENSITY * AREA)
    parts = reduction.split(fem.split(fe, at=(2.0, 4.0, 6.0)), {"root": "start", "tip": "end"}, 4, stress=False)
    bodies = fmb.FloatingBody.split("beam", parts)
    model = on_hub(
        bodies[0],
        fmb.expression(DRIVE),
        bodies=bodies[1:],
        joints=fmb.Fixed.at_cuts(bodies),
        sensors=[fmb.Position("tip", marker="beam_4.tip")],
    )
    motion = fmb.simulate(model, 20.0, integrator=fmb.GeneralizedAlpha(rtol=1e-6), samples=2001)
    across = in_rotating_frame(motion["tip"], angle(motion.t), LENGTH)[:, 1]
    lowest = int(across.argmin())
    assert across[lowest] == pytest.approx(case["max_tip_lag"], rel=4e-4)
    assert motion.t[lowest] == pytest.approx(case["t_max"], abs=0.01)
    assert 0.5 * np.ptp(across[motion.t > 15.0]) == pytest.approx(case["after_spinup_u2_amplitude"], rel=0.06)
    for time, (_, expected) in case["samples"].items():
        assert across[np.searchsorted(motion.t, float(time) - 1e-9)] == pytest.approx(expected, abs=5e-4)


def test_clamped_frame_without_it_diverges():
    _, u = spin_up(beam(frame="root"), LENGTH, geometric_stiffness=False, rtol=1e-5)
    assert np.abs(u[:, 1]).max() > 100.0 * LENGTH


def test_buckens_frame_without_it_is_wrong(reference):
    """That frame turns with the beam, which holds a part of the stiffening: no break-down, but a third too much lag."""
    _, u = spin_up(beam(), LENGTH, geometric_stiffness=False, rtol=1e-5)
    assert u[:, 1].min() < 1.3 * reference("GS02")["reference"]["max_tip_lag"]
