"""FE02: eigenfrequencies of a Timoshenko cantilever, L / h = 10 (spectral Ritz solution of Timoshenko's
theory)."""

import numpy as np
from fem.beams import STEEL, straight

from flexmb import fem

TOLERANCE = 1e-5
SECTION = fem.Section.rectangle(0.1, 0.05)  # bends in x-y; shear factor 5/6


def frequencies(elements):
    fe = fem.frame(straight(elements), section=SECTION, material=STEEL)
    planar = fem.with_supports(fem.with_supports(fe, "start"), directions=(0, 2, 3, 4))
    return fem.eigenmodes(planar, None, 5).frequencies


def test_frequencies(reference):
    expected = np.array(reference("FE02")["reference"]["f_Hz"])
    np.testing.assert_allclose(frequencies(600), expected, rtol=TOLERANCE)


def test_elements_shorter_than_the_height_converge_with_order_two(reference):
    expected = np.array(reference("FE02")["reference"]["f_Hz"])
    errors = [np.abs(frequencies(elements) / expected - 1.0) for elements in (40, 80)]
    order = np.log2(errors[0][1:] / errors[1][1:])
    np.testing.assert_allclose(order, 2.0, atol=0.1)
