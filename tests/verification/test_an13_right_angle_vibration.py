"""AN13: a right-angle cantilever, pushed out of its plane at the elbow, vibrates freely with amplitudes like its legs.

Reference: Simo & Vu-Quoc 1988, figures: the tip swings by about ten; the energy of the free motion is kept.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem


@pytest.mark.slow
def test_energy_and_amplitude():
    """Less than 2 % drift of the energy with rho = 0.9 and steps of 0.05 s; amplitudes within 10 % of the figure."""
    section = fem.Section.values(1.0, 1e-3, 1e-3, 2e-3, 2.0, 2.0)
    material = fmb.Material(young=1e6, poisson=0.0, density=1.0)
    common = {"elements": 5, "section": section, "material": material, "rotary_inertia": (10.0, 10.0)}
    first = fmb.AncfBeam("first", points=((0, 0, 0), (10, 0, 0)), **common)
    second = fmb.AncfBeam("second", points=((10, 0, 0), (10, 10, 0)), **common)
    own = second.marker_poses()["start"].matrix
    second = fmb.AncfBeam("second", points=((10, 0, 0), (10, 10, 0)), markers={"start": (0.0, own.T)}, **common)
    push = fmb.expression("where(t < 1, 50*t, where(t < 2, 100 - 50*t, 0))")
    solution = fmb.simulate(
        fmb.Model(
            bodies=(fmb.Ground(), first, second),
            gravity=(0, 0, 0),
            joints=(
                fmb.Fixed("clamp", markers=("ground.origin", "first.start")),
                fmb.Fixed("corner", markers=("first.end", "second.start")),
            ),
            forces=(fmb.PointLoad("push", marker="first.end", force=(0, 0, push)),),
            sensors=(
                fmb.Position("elbow", marker="first.end"),
                fmb.Position("tip", marker="second.end"),
                fmb.Energy("E"),
            ),
        ),
        t_end=30.0,
        samples=301,
        integrator=fmb.GeneralizedAlpha(rho_inf=0.9, step=0.05),
    )
    free = solution["E"][solution.t >= 2.0]
    assert np.ptp(free) < 0.02 * free[0]
    assert np.abs(solution["tip"][:, 2]).max() == pytest.approx(10.0, rel=0.15)
    assert np.abs(solution["elbow"][:, 2]).max() > 4.0
