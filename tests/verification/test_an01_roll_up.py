"""AN01: a cantilever that an end moment M bends into a circle of radius EI / M, up to two full circles.

Reference: closed form; the axial force is zero, so a beam with engineering strain has the exact shape.
"""

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb
from flexmb import fem


def rolled_up(model, moment, elements):
    """Return position of the tip (3,) and its direction (3,) at an end moment, N m."""
    inertia = model["EI"] / model["E"]
    body = fmb.AncfCable(
        "beam",
        points=((0, 0, 0), (model["L"], 0, 0)),
        elements=elements,
        section=fem.Section.values(model["EA"] / model["E"], inertia, inertia, 2 * inertia),
        material=fmb.Material(young=model["E"], poisson=model["nu"], density=1000.0),
    )
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(), body),
            gravity=(0, 0, 0),
            joints=(fmb.Fixed("clamp", markers=("ground.origin", "beam.start")),),
            forces=(fmb.PointLoad("M", marker="beam.end", moment=(0, 0, moment)),),
            sensors=(fmb.Position("tip", marker="beam.end"),),
        )
    )
    return solution["tip"][-1], solution.final.q[-3:]


@pytest.mark.parametrize(
    ("share", "elements"), [("0.125", 16), slow("0.25", 16), ("0.5", 16), slow("1.0", 16), ("2.0", 24)]
)
def test_tip(reference, share, elements):
    """1e-3 L with 16 elements for one circle, 24 for two."""
    case = reference("AN01")
    expected = case["reference"][share]
    tip, direction = rolled_up(case["model"], expected["M"], elements)
    np.testing.assert_allclose(tip, [*expected["tip"], 0.0], atol=1e-3 * case["model"]["L"])
    angle = expected["tip_rotation"]
    np.testing.assert_allclose(direction, [np.cos(angle), np.sin(angle), 0.0], atol=1e-3 * max(1.0, angle))


def test_order_of_convergence(reference):
    """The error of the tip at half a circle falls with the fourth power of the element length."""
    case = reference("AN01")
    half = case["reference"]["0.5"]
    error = [np.linalg.norm(rolled_up(case["model"], half["M"], n)[0][:2] - half["tip"]) for n in (6, 12)]
    assert np.log2(error[0] / error[1]) == pytest.approx(4.0, abs=0.4)
