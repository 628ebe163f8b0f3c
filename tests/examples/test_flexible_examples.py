"""The examples of flexible bodies run and give the numbers that their docstrings promise."""

import runpy
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize(
    ("name", "expected", "tolerance"),
    [
        ("four_bar_flexible", 1.0, 0.02),  # greatest pin force relative to a rigid coupler
        ("rotating_blade", 13.471129933444166, 5e-4),  # case GS05 at eta = 12
    ],
)
def test_number(name, expected, tolerance):
    assert runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"]() == pytest.approx(expected, rel=tolerance)


def shallow_arch(length, rise, width, thickness, young):
    """Loads at the crown, N, at which a hinged sine arch sways over (Fung & Kaplan, NACA TN 2840, 1952)."""
    n = np.arange(1, 60)
    k, s, h = n * np.pi / length, np.sin(0.5 * np.pi * n), np.where(n == 1, rise, 0.0)
    EA, EI = young * width * thickness, young * width * thickness**3 / 12.0
    H = EI * k[1] ** 2
    D = EI * k**4 - (1.0 - 1e-9) * H * k**2
    free, per_load = EI * k**4 * h / D, 2.0 * s / (length * D)
    roots = np.roots(
        [
            -0.25 * EA * np.sum((k * per_load) ** 2),
            0.5 * EA * np.sum(k**2 * free * per_load),
            0.25 * EA * np.sum(k**2 * (h**2 - free**2)) - H,
        ]
    )
    return roots.max(), roots.min()


def test_snapping_strip():
    """Both limit points as in the theory of shallow arches, 2 %;
    a push that grows carries the strip to the other side.
    """
    strip = runpy.run_path(str(EXAMPLES / "snapping_strip.py"))
    path, motion = strip["path"](), strip["snap"]()
    young = motion.model.body("strip").material.young
    over, back = shallow_arch(*(strip[name] for name in ("LENGTH", "RISE", "WIDTH", "THICKNESS")), young)
    assert [point.kind for point in path.limit_points] == ["maximum", "minimum"]
    found = [strip["PUSH"] * point.load for point in path.limit_points]
    assert found[0] == pytest.approx(over, rel=0.02)
    assert found[1] == pytest.approx(back, rel=0.04)
    load, height = strip["RATE"] * motion.t, motion["crown"][:, 2]
    assert height[load < over].min() > 0.8 * strip["RISE"]
    assert height[-1] < -0.5 * strip["RISE"]
