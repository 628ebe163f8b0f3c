"""Tests of many combinations: by default every second one, the others with the long tests."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import pytest


def slow(*values, **more):
    """Return parameters of a test that are long ones: what they show, others by default do too."""
    return pytest.param(*values, marks=pytest.mark.slow, **more)


def every_second(*choices: Iterable) -> list:
    """Return all combinations as parameters of a test; every second one is marked slow.

    Those that stay have an even sum of places: with three lists or more, any two choices of different lists meet, of
    two lists each choice meets every second one of the other.
    """
    listed = [list(each) for each in choices]
    return [
        pytest.param(*(own[k] for own, k in zip(listed, places)), marks=[pytest.mark.slow] if sum(places) % 2 else [])
        for places in itertools.product(*(range(len(own)) for own in listed))
    ]
