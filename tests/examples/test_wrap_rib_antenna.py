"""The antenna of examples/wrap_rib_antenna.py: what free motion keeps, and the same motion in other coordinates."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import flexmb as fmb

ANTENNA = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "wrap_rib_antenna.py"))


def test_it_unwinds_and_keeps_its_momenta():
    motion = ANTENNA["run"](0.5, ribs=2, segments=4)
    start, end = (np.linalg.norm(motion["tip"][k] - motion["hub"][k]) for k in (0, -1))
    assert end > start + 0.4
    momenta = motion["momentum"]  # of one rib against the other: of the order of 1 kg m/s and kg m2/s
    np.testing.assert_allclose(momenta, 0.0, atol=1e-6)
    assert np.all(np.diff(motion["energy"]) <= 1e-9 * motion["energy"][0])  # the springs are damped


def test_the_default_run_shows_the_ribs_stretched():
    """Rods on joints reach no farther than their lengths together, and do after 1.6 s."""
    motion = ANTENNA["run"]()
    reach = np.linalg.norm(motion["tip"] - motion["hub"], axis=1)
    stretched = ANTENNA["RADIUS"] + 4 * ANTENNA["SEGMENT"]
    assert 0.995 * stretched < reach.max() <= stretched
    assert motion.t[reach.argmax()] == pytest.approx(1.6, abs=0.05)


@pytest.mark.parametrize("other", [fmb.Explicit(), fmb.Implicit(rtol=1e-8)], ids=["all bodies", "implicit"])
def test_the_same_motion_otherwise(other):
    motions = [ANTENNA["run"](0.3, how, ribs=2, segments=3) for how in (None, other)]
    for name in ("tip", "hub"):
        one, two = (motion[name] for motion in motions)
        np.testing.assert_allclose(one, two, atol=1e-6)
    moved = np.linalg.norm(motions[0]["hub"] - motions[0]["hub"][0], axis=1).max()
    assert moved > 2e-5
