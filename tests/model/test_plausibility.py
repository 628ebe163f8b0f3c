"""Numbers that can hardly be meant are told where they are given, and numbers that may be meant are not."""

import warnings

import numpy as np
import pytest
from fem.beams import STEEL, straight

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.fem import Section

SECTION = Section.rectangle(0.02, 0.01)


def reduced(**fields):
    fe = fem.frame(straight(4), section=SECTION, material=STEEL, name="bar")
    return reduction.reduce(fe, {"a": "start", "b": "end"}, 4, **fields)


@pytest.mark.parametrize("damping", [5.0, reduction.Bands(((100.0, 0.01), (1e3, 5.0)))])
def test_a_percent_given_as_a_fraction_is_told(damping):
    with pytest.warns(fmb.ValidityWarning, match=r"a ratio of 5 is 500 % of critical.* write 0.05"):
        reduced(damping=damping)


def test_percents_of_a_body_are_told():
    data = reduced()
    with pytest.warns(fmb.ValidityWarning, match=r"'arm'.*a ratio of 2 is 200 % of critical.* write 0.02"):
        fmb.FloatingBody("arm", data=data, damping=2.0)


@pytest.mark.parametrize("damping", [None, 0.05, 1.0, reduction.Rayleigh(mass=0.0, stiffness=1e-2)])
def test_ratios_that_may_be_meant_are_silent(damping):
    """Stiffness-proportional damping of fast modes is far above critical, and nobody wrote that number."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        reduced(damping=damping)
    assert not [each for each in told if "critical" in str(each.message)]


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_an_inertia_that_no_mass_has_is_told(scale):
    fe = fem.frame(straight(4), section=SECTION, material=STEEL)
    with pytest.warns(fmb.ValidityWarning, match="in no mass is one larger than the sum"):
        fem.with_mass(fe, 2, 1.0, inertia=tuple(scale * np.array([1.0, 1.0, 5.0])))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fem.with_mass(fe, 2, 1.0, inertia=(scale, 0.0, 0.0))  # the inertia about one axis alone, as of a disc's spin
        fem.with_mass(fe, 2, 1.0, inertia=tuple(scale * np.array([1.0, 1.0, 2.0])))
