"""Motions whose rates are at the end of the range of numbers: every integrator ends at once, and says where."""

import pytest

import flexmb as fmb


def falling(speed: float, *, floor: bool) -> fmb.Model:
    """2 kg on a spring of 1000 N/m at a speed (m/s) whose square is no number, perhaps over a floor of 1e308 N/m."""
    markers = ("ground.origin", "stone.center")
    contact = fmb.Contact("floor", markers=markers, radius=0.1, stiffness=1e308, damping=10.0, friction=0.2)
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("stone", mass=2.0, at=(0.1, 0.2, 0.3), velocity=(1.0, 0, -speed))],
        forces=[
            fmb.SpringDamper("spring", markers=markers, stiffness=1000.0, length=0.2),
            *([contact] if floor else []),
        ],
    )


INTEGRATORS = [
    fmb.Explicit(),
    fmb.Explicit(method="RK45"),
    fmb.Explicit(method="Radau"),
    fmb.Explicit(formulation=fmb.NullSpace()),
    fmb.Explicit(formulation=fmb.Baumgarte()),
    fmb.Explicit(formulation=fmb.Recursive()),
    fmb.Implicit(),
    fmb.IDA(),
    fmb.GeneralizedAlpha(),
    fmb.GeneralizedAlpha(step=1e-3),
]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("floor", [False, True])
@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_run_that_gets_nowhere_ends(integrator, floor):
    with pytest.raises(fmb.IntegrationError, match=r"at t = .* s"):
        fmb.simulate(falling(1.2541e184, floor=floor), 0.2, samples=21, integrator=integrator)
