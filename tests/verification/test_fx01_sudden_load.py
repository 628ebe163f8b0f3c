"""FX01: cantilever under a suddenly applied tip force, closed-form modal series (linear dynamics)."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction


@pytest.mark.parametrize("frame", ["buckens", "root"])
def test_tip_displacement(reference, frame):
    case = reference("FX01")
    steel = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
    fe = fem.frame(
        np.linspace([0, 0, 0], [1, 0, 0], 11),
        section=fem.Section.rectangle(0.02, 0.01),
        material=steel,
        shear=False,
        rotary_inertia=False,
    )
    data = reduction.reduce(fe, {"root": "start", "tip": "end"}, 6, frame=frame, stress=False)
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("beam", data=data)],
        joints=[fmb.Fixed("clamp", markers=("ground.origin", "beam.root"))],
        forces=[fmb.PointLoad("push", marker="beam.tip", force=(0, 0, case["model"]["F"]))],
        sensors=[fmb.Position("tip", marker="beam.tip")],
    )
    times = [float(t) for t in case["reference"]["t"]]
    motion = fmb.simulate(
        model, times[-1], samples=[0.0, *times], integrator=fmb.GeneralizedAlpha(rho_inf=0.95, rtol=1e-7)
    )
    expected = list(case["reference"]["t"].values())
    np.testing.assert_allclose(motion["tip"][1:, 2], expected, rtol=0, atol=5e-3 * max(expected))
    assert fmb.statics(model)["tip"][-1, 2] == pytest.approx(case["reference"]["static"], rel=1e-4)
