"""AN07: the Princeton beam experiment (Dowell & Traybar 1975), a flat aluminium strip loaded at an angle to its axes.

Reference: shooting solution of the geometrically exact beam with these constants; ANSYS within 1 %.
"""

import numpy as np
import pytest
from verification.cantilever_beam import loaded_tip

import flexmb as fmb
from flexmb import fem

CASES = [(8.896, "15"), (8.896, "90"), (13.345, "0"), (13.345, "30"), (13.345, "60")]


@pytest.mark.parametrize(("load", "angle"), CASES)
def test_tip(reference, load, angle):
    """Eight elements, 1e-4 L. The section's z-axis is the stiff direction, the strip's wide side."""
    case = reference("AN07")
    model = case["model"]
    h, w = model["h"], model["w"]
    body = fmb.AncfBeam(
        "b",
        points=((0, 0, 0), (model["L"], 0, 0)),
        elements=8,
        section=fem.Section.values(h * w, w * h**3 / 12, h * w**3 / 12, model["J_StVenant"]),
        material=fmb.Material(young=model["E"], poisson=model["nu"], density=2700.0),
    )
    beta = np.radians(float(angle))
    tip, _ = loaded_tip(body, (0, load * np.sin(beta), load * np.cos(beta)))
    expected = case["reference"]["own_GE"][f"F={load}"][angle]
    np.testing.assert_allclose(tip, [expected["ux"], expected["u_weak"], expected["u_stiff"]], atol=1e-4 * model["L"])
