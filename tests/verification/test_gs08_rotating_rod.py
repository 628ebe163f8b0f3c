"""GS08: axial stretch and root force of a rotating rod, closed form of E u'' + rho w^2 (R + x + u) = 0."""

import numpy as np
import pytest
from verification.rotating_beams import on_hub

import flexmb as fmb
from flexmb import fem, reduction


@pytest.mark.parametrize("frame", ["buckens", "root"])
@pytest.mark.parametrize("modes", [20, 60])
def test_stretch_and_root_force(reference, frame, modes):
    case = reference("GS08")
    section = fem.Section.values(area=1e-4, inertia_y=1e-7, inertia_z=1e-7, torsion=1e-7)
    fe = fem.frame(
        np.linspace([0, 0, 0], [3, 0, 0], 31),
        section=section,
        shear=False,
        rotary_inertia=False,
        material=fmb.Material(young=70e9, poisson=0.3, density=2700.0),
    )
    data = reduction.reduce(
        fe, {"root": "start", "tip": "end"}, modes, frame=frame, geometric_stiffness=True, stress=False
    )
    model = on_hub(
        fmb.FloatingBody("rod", data=data),
        fmb.expression("100 * t"),
        radius=0.4,
        sensors=[fmb.Position("tip", marker="rod.tip"), fmb.Reaction("root", joint="clamp")],
    )
    steady = fmb.statics(model)
    assert steady["tip"][-1, 0] - 3.4 == pytest.approx(case["reference"]["u_tip"], rel=1e-4)
    assert -steady["root"][-1, 0] == pytest.approx(case["reference"]["N_root"], rel=1e-4)
