"""The examples of flexible bodies run and give the numbers that their docstrings promise."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize(("name", "expected", "tolerance"), [
    ("four_bar_flexible", 1.0, 0.02),  # greatest pin force relative to a rigid coupler
    ("rotating_blade", 13.471129933444166, 5e-4),  # case GS05 at eta = 12
])  # fmt: skip
def test_number(name, expected, tolerance):
    assert runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"]() == pytest.approx(expected, rel=tolerance)
