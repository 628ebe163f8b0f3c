"""Groups of geometric stiffness that balance each other: one alone lets vibration grow, and is told of."""

import warnings
from functools import cache

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

TOGETHER = [True, ("inertia", "interface")]
ALONE = [("inertia",), ("interface", "preload")]


@cache
def strip() -> fmb.ModalNeutralData:
    points = np.column_stack([np.linspace(0.0, 0.4, 9), np.zeros(9), np.zeros(9)])
    soft = fmb.Material(young=2e10, poisson=0.3, density=2700.0)
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.03, 0.006), material=soft)
    return reduction.reduce(fe, {"start": [0], "end": [8]}, modes=3, geometric_stiffness=True, stress=False)


@pytest.mark.parametrize("groups", ALONE, ids=str)
def test_one_alone_is_told_of(groups):
    with pytest.warns(fmb.ValidityWarning, match=r"'b' has geometric stiffness of \w+ without that of \w+: .*Use both"):
        fmb.FloatingBody("b", data=strip(), geometric_stiffness=groups)


@pytest.mark.parametrize("groups", [*TOGETHER, False, ("preload",)], ids=str)
def test_both_or_none_without_a_word(groups):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fmb.FloatingBody("b", data=strip(), geometric_stiffness=groups)
