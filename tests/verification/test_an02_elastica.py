"""AN02: a cantilever under a transverse dead load P at its tip, P L^2 / EI up to 10.

Reference: Bisshopp & Drucker 1945; Mattiasson 1981 (elliptic integrals): inextensible, rigid in shear.
"""

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb
from flexmb import fem

LENGTH, EI = 2.0, 50.0


@pytest.mark.parametrize("alpha", ["0.25", slow("1"), slow("4"), "10"])
def test_tip(reference, alpha):
    """1e-4 L with 32 elements; EA L^2 / EI = 1e6 leaves a stretch of 1e-5."""
    deflection, shortening, rotation = reference("AN02")["reference"][alpha]
    young = 1e9
    area, inertia = 1e6 * EI / LENGTH**2 / young, EI / young
    body = fmb.AncfCable(
        "beam",
        points=((0, 0, 0), (LENGTH, 0, 0)),
        elements=32,
        section=fem.Section.values(area, inertia, inertia, 2 * inertia),
        material=fmb.Material(young=young, poisson=0.0, density=1000.0),
    )
    load = float(alpha) * EI / LENGTH**2
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(), body),
            gravity=(0, 0, 0),
            joints=(fmb.Fixed("clamp", markers=("ground.origin", "beam.start")),),
            forces=(fmb.PointLoad("P", marker="beam.end", force=(0, 0, load)),),
            sensors=(fmb.Position("tip", marker="beam.end"), fmb.Reaction("root", joint="clamp")),
        )
    )
    tip = solution["tip"][-1]
    np.testing.assert_allclose(tip / LENGTH, [1.0 - shortening, 0.0, deflection], atol=1e-4)
    x, _, z = solution.final.q[-3:]
    assert np.arctan2(z, x) == pytest.approx(rotation, abs=2e-4)
    # the clamp holds the load and its moment about the root
    expected = np.array([0.0, 0.0, -load, 0.0, load * tip[0], 0.0])
    np.testing.assert_allclose(solution["root"][-1], expected, atol=1e-4 * load * LENGTH)
