"""AN03: a thick cantilever (L/h = 4) under a large dead load at its tip.

Reference: Reissner beam solved by shooting; Nachbagauer et al. 2011.
"""

import numpy as np
import pytest
from verification.cantilever_beam import loaded_tip

import flexmb as fmb
from flexmb import fem


def solved(case, elements):
    model = case["model"]
    h, w = model["h"], model["w"]
    section = fem.Section.values(h * w, h * w**3 / 12, w * h**3 / 12, 1e-4, model["kappa"], model["kappa"])
    body = fmb.AncfBeam(
        "b",
        points=((0, 0, 0), (model["L"], 0, 0)),
        elements=elements,
        section=section,
        material=fmb.Material(young=model["E"], poisson=model["nu"], density=7850.0),
    )
    return body, *loaded_tip(body, (0, -model["F"], 0))


def test_tip_and_root_moment(reference):
    case = reference("AN03")
    body, tip, solution = solved(case, 16)
    np.testing.assert_allclose(tip[:2], case["reference"]["tip_u"], atol=1e-5)
    moment = body.section_forces(solution.final.q, 0.0)[0, 5]
    assert moment == pytest.approx(case["reference"]["root_moment"], rel=1e-3)
    axes = body.section_axes(solution.final.q, 1.0)[1][0]
    assert np.arctan2(axes[1, 0], axes[0, 0]) == pytest.approx(case["reference"]["rotation"], abs=1e-4)


def test_order_of_convergence(reference):
    """The tip converges with the fourth power of the element length."""
    case = reference("AN03")
    error = [abs(solved(case, n)[1][1] - case["reference"]["tip_u"][1]) for n in (2, 4)]
    assert np.log2(error[0] / error[1]) == pytest.approx(4.0, abs=0.5)
