"""Spin-up of a beam to 0.3, 0.8 and 2 times its first bending frequency against an own geometrically exact chain."""

import numpy as np
import pytest
from verification.elastica_chain import extrapolated_lag
from verification.rotating_beams import in_rotating_frame, on_hub, spin_up_beam

import flexmb as fmb

LENGTH, EA, EI, RHO_A, RISE = 10.0, 2.8e7, 1.4e4, 1.2, 15.0
FIRST = 3.516015268666903 * np.sqrt(EI / RHO_A) / LENGTH**2


def rotation(speed):
    """Return angle and rate of a smooth start to `speed`, rad/s, in 15 s."""

    def angle(t):
        rising = speed / RISE * (t**2 / 2 + (RISE / 2 / np.pi) ** 2 * (np.cos(2 * np.pi * t / RISE) - 1))
        return np.where(t < RISE, rising, speed * (t - RISE / 2))

    def rate(t):
        return np.where(t < RISE, speed / RISE * (t - RISE / 2 / np.pi * np.sin(2 * np.pi * t / RISE)), speed)

    return angle, rate


def test_reference_itself(reference):
    """The chain meets the spectral reference of GS03 (6 rad/s)."""
    case = reference("GS03")["reference"]
    times = np.array([float(t) for t in case["samples"]])
    lag = extrapolated_lag(LENGTH, EI, RHO_A, *rotation(6.0), times, 24)
    np.testing.assert_allclose(lag, [u[1] for u in case["samples"].values()], rtol=0, atol=5e-4)


@pytest.mark.parametrize("fraction", [0.3, pytest.param(0.8, marks=pytest.mark.slow), 2.0])
def test_lag(fraction):
    speed = fraction * FIRST
    angle, rate = rotation(speed)
    times = np.linspace(0.0, 20.0, 201)
    expected = extrapolated_lag(LENGTH, EI, RHO_A, angle, rate, times, 24)
    text = "where(t < T, W/T*(t**2/2 + (T/2/pi)**2*(cos(2*pi*t/T) - 1)), W*(t - T/2))"
    model = on_hub(
        fmb.FloatingBody("beam", data=spin_up_beam(LENGTH, EA, EI, RHO_A)),
        fmb.expression(text, W=speed, T=RISE),
        sensors=[fmb.Position("tip", marker="beam.tip")],
    )
    motion = fmb.simulate(model, 20.0, samples=times, integrator=fmb.GeneralizedAlpha(rtol=1e-6))
    across = in_rotating_frame(motion["tip"], angle(times), LENGTH)[:, 1]
    np.testing.assert_allclose(across, expected, rtol=0, atol=0.02 * np.abs(expected).max())
