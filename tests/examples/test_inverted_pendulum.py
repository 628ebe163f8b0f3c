"""The inverted pendulum: poles of the regulator by scipy, and a fall that is caught."""

import runpy
from pathlib import Path

EXAMPLE = Path(__file__).parents[2] / "examples" / "inverted_pendulum.py"


def test_the_regulator_has_its_poles_and_holds_the_rod():
    """The linearised model with its controller has the eigenvalues of A - B K; the rod comes to rest upright."""
    apart, left = runpy.run_path(str(EXAMPLE))["main"]()
    assert apart < 1e-9
    assert left < 1e-3
