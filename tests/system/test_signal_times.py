"""Times at which steps end for several signals: one for those that are nearly the same, and none lost."""

import numpy as np

import flexmb as fmb
from flexmb.system.signal_times import SignalTimes

PROGRESS = fmb.ramp(1.0 / 0.9, rise=0.1) + fmb.ramp(-1.0 / 0.9, rise=0.1, start=0.9)
KNOTS = np.linspace(0.0, 1.0, 11)


def times_of(*signals):
    return SignalTimes(tuple(s.program() for s in signals), tuple("abc"[: len(signals)])).between(0.0, 1.0)


def test_tables_that_end_with_no_rate_share_their_cells():
    """The last knot is reached at t = 1 with no rate, so rounding ends each signal a little earlier: 1e-8 to 1e-6 s.
    Cells of all of them had a mark each, and steps as short as the differences."""
    smooth = [fmb.table(KNOTS, np.cos(k * KNOTS), of=PROGRESS, kind="cubic") for k in (1, 2)]
    signals = [PROGRESS, *smooth]
    each = [times_of(signal).fine for signal in signals]
    together = times_of(*signals).fine
    assert max(len(times) for times in each) > 10
    assert np.diff(np.unique(np.concatenate(each))).min() < 1e-6  # what every signal alone would add up to
    assert np.diff(together).min() > 1e-4
    for times in each:  # none is lost: a mark stands for it, a thousandth of its cell away
        near = np.min(np.abs(times[:, None] - np.concatenate([[0.0, 1.0], together])), axis=1)
        assert near.max() < 1e-3 * 0.1


def test_pulses_of_two_signals_keep_their_times():
    pulses = [fmb.expression(f"exp(-((t - {at})/1e-5)**2)") for at in (0.5, 0.50001)]
    together = times_of(*pulses).fine
    for at in (0.5, 0.50001):
        assert np.min(np.abs(together - at)) < 2e-5
        assert np.sum(np.abs(together - at) < 1e-4) > 3
