"""The rods of examples/three_rods.py, beside the closed form of Banerjee 1993."""

import runpy
from pathlib import Path


def test_stiffness_of_the_motion():
    assert runpy.run_path(str(Path(__file__).parents[2] / "examples" / "three_rods.py"))["main"]() < 1e-6
