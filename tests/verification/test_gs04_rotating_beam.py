"""GS04: frequencies of a rotating uniform cantilever, flap and chord (Wright et al. 1982, recomputed by Ritz)."""

import numpy as np
import pytest
from by_turns import every_second
from verification.rotating_beams import angular_frequencies, slender

import flexmb as fmb
from flexmb import reduction


def body(plane, modes, frame="buckens"):
    """A unit beam that bends in one plane only."""
    stiff = 1e4
    chord, flap = (1.0, stiff) if plane == "chord" else (stiff, 1.0)
    data = reduction.reduce(
        slender(1.0, 1e8, chord, flap, 1.0),
        {"root": "start"},
        modes,
        frame=frame,
        geometric_stiffness=True,
        stress=False,
    )
    return fmb.FloatingBody("beam", data=data)


@pytest.mark.parametrize(("plane", "frame"), every_second(["flap", "chord"], ["buckens", "root"]))
def test_frequencies_against_speed(reference, plane, frame):
    beam = body(plane, 12, frame)
    for eta in (0, 2, 6, 12):
        found = angular_frequencies(beam, eta)[:3]
        np.testing.assert_allclose(found, reference("GS04")["reference"][plane][str(eta)], rtol=1e-3)


@pytest.mark.parametrize("plane", ["flap", "chord"])
def test_few_modes_at_moderate_speed(reference, plane):
    beam = body(plane, 4)
    for eta in (1, 3, 5):
        found = angular_frequencies(beam, eta)[:3]
        np.testing.assert_allclose(found, reference("GS04")["reference"][plane][str(eta)], rtol=1e-3)


def test_southwell_coefficients(reference):
    """w^2 = w0^2 + S eta^2 for slow rotation."""
    beam = body("flap", 8)
    slow = (angular_frequencies(beam, 0.5)[:3] ** 2 - angular_frequencies(beam, 0.0)[:3] ** 2) / 0.25
    np.testing.assert_allclose(slow, reference("GS04")["reference"]["southwell_flap"], rtol=2e-3)
