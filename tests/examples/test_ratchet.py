"""The ratchet lets its wheel forwards only, and holds it where its docstring says."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import flexmb as fmb

RATCHET = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "ratchet.py"))


def test_held_after_whole_pitches():
    """Three pitches, less the press of the torque into the face, T / R^2 / k; the notch gives way as well, by 10 %."""
    pitches = RATCHET["main"]()
    press = 0.5 / 0.04305**2 / RATCHET["STIFFNESS"]
    assert (3.0 - pitches) * RATCHET["PITCH"] == pytest.approx(press, rel=0.15)


def test_forwards_by_clicks():
    """The pawl rises 8 mm over each tooth: an angle of 8 mm / 45 mm, once for every pitch."""
    solution = fmb.simulate(RATCHET["model"](), t_end=0.25, samples=251)
    lift = -solution["pawl"]
    assert lift.max() == pytest.approx(0.178, abs=0.02)
    falls = np.sum((lift[:-1] > 0.1) & (lift[1:] <= 0.1))
    assert falls == np.floor(solution["angle"][-1] / RATCHET["PITCH"])
    assert np.all(np.diff(solution["angle"]) > -1e-3)
