"""What counts as an impact: `before` and `after` are rates of a gap, negative where it closes."""

import pytest

from flexmb.math.impact_steps import STRIKING, strikes


@pytest.mark.parametrize(
    ("before", "after", "impact"),
    [
        (-1.0, -3.5, True),
        (-1.0, -4.5, True),
        (-1.0, -5.1, False),  # pressed: it got more than four fifths of its speed in this step
        (-1.0, 2.9, True),
        (-1.0, 3.1, False),
        (1.0, 4.9, True),
        (1.0, -3.1, False),
        (0.0, -1.0, False),
    ],
)
def test_speeds_that_a_short_step_does_not_make_itself(before, after, impact):
    """A change of at most four times the speed before; all that is fast, or in longer steps, strikes."""
    assert strikes(before, after, True, 1.0, 1.0) == impact
    assert strikes(1e3 * before, 1e3 * after, True, 1.0, 1.0) == (impact or 1e3 * abs(before) > STRIKING)
    assert strikes(before, after, False, 1.0, 1.0)
