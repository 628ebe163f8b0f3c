"""A beam as one floating body and as several: large static deflection (AN02), spin-up, and frequencies.

Each part deforms little in its own frame, so what one body cannot describe comes out right with some parts.
"""

from functools import cache

import numpy as np
import pytest
from verification.fast_spin_up import LENGTH as SPAN
from verification.fast_spin_up import ancf, exact, floating, lag
from verification.rotating_beams import angular_frequencies, slender

import flexmb as fmb
from flexmb import fem, reduction

LENGTH, EI = 2.0, 50.0


@cache
def beam(parts, length=LENGTH, EA=1e6 * EI / LENGTH**2, bending=EI, flap=EI, rhoA=1.0, modes=4):
    """Return the bodies of a clamped beam and the joints between them."""
    fe = slender(length, EA, bending, flap, rhoA, elements=48)
    pieces = fem.split(fe, at=length * np.arange(1, parts) / parts)
    data = reduction.split(pieces, {"root": "start", "tip": "end"}, modes, stress=False)
    bodies = fmb.FloatingBody.split("beam", data)
    return bodies, fmb.Fixed.at_cuts(bodies)


def tip_under(load, parts):
    bodies, joints = beam(parts)
    solution = fmb.statics(
        fmb.Model(
            bodies=[fmb.Ground(), *bodies],
            joints=[fmb.Fixed("clamp", markers=("ground.origin", "beam_1.root")), *joints],
            forces=[fmb.PointLoad("P", marker=f"beam_{parts}.tip", force=(0, 0, load))],
            sensors=[fmb.Position("tip", marker=f"beam_{parts}.tip")],
        )
    )
    return solution["tip"][-1] / LENGTH


@pytest.mark.parametrize("alpha", ["1", "4", "10"])
def test_elastica(reference, alpha):
    """Bisshopp & Drucker 1945; the error falls with the square of the number of parts, 12 parts meet 1e-3 L."""
    deflection, shortening, _ = reference("AN02")["reference"][alpha]
    expected = np.array([1.0 - shortening, 0.0, deflection])
    load = float(alpha) * EI / LENGTH**2
    errors = [np.linalg.norm(tip_under(load, parts) - expected) for parts in (3, 6, 12)]
    assert errors[2] < 1e-3
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((orders > 1.6) & (orders < 2.5))


@pytest.mark.slow
def test_spin_up_at_twice_the_first_frequency():
    """Against the geometrically exact chain, spun up so fast that the tip lags by 31 % of the length: three parts are
    within 2 % of the peak, six within a quarter of that, as an error of second order has it, ANCF within 0.3 %."""
    expected = exact(2.0)
    peak = np.abs(expected).max()
    assert peak > 0.3 * SPAN
    three, six, cable = (np.abs(lag(beam, 2.0) - expected).max() / peak for beam in (floating(3), floating(6), ancf()))
    assert three < 0.02
    assert six < 0.3 * three
    assert cable < 3e-3


def test_one_body_is_enough_where_it_bends_little():
    """Spun up to a quarter of that speed it lags by 8 %: one floating body and ANCF agree with the chain within 1 %."""
    expected = exact(0.5)
    peak = np.abs(expected).max()
    assert 0.05 * SPAN < peak < 0.1 * SPAN
    for beam in (floating(1), ancf()):
        assert np.abs(lag(beam, 0.5) - expected).max() < 0.01 * peak


@pytest.mark.parametrize("parts", [2, 5])
def test_frequencies_of_the_cantilever(parts):
    """(beta L)^2 sqrt(E I / (rho A L^4)), beta L = 1.87510407, 4.69409113, 7.85475744: clamped uniform beam."""
    (first, *others), joints = beam(parts, modes=6, flap=1e4 * EI)
    found = angular_frequencies(first, 0.0, bodies=others, joints=joints)[:3]
    expected = np.array([1.87510407, 4.69409113, 7.85475744]) ** 2 * np.sqrt(EI / LENGTH**4)
    np.testing.assert_allclose(found, expected, rtol=2e-4)
