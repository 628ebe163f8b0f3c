"""The same motion in picoseconds and in thousands of years: steps are compared with the time, not with a second."""

import numpy as np
import pytest

import flexmb as fmb


def bouncing(second: float) -> fmb.Model:
    """Return a stone on a spring that bounces on a ball, where a unit of time has so many seconds."""
    return fmb.Model(
        gravity=(0, 0, -9.81 / second**2),
        bodies=[fmb.Ground(), fmb.PointMass("stone", mass=2.0, at=(0.05, 0, 0.3), velocity=(0.1 / second, 0, 0))],
        forces=[
            fmb.Contact("ball", markers=("ground.origin", "stone.center"), radius=0.1, stiffness=1e7 / second**2),
            fmb.SpringDamper(
                "spring",
                markers=("ground.origin", "stone.center"),
                stiffness=100.0 / second**2,
                damping=0.5 / second,
                length=0.2,
            ),
        ],
        sensors=[fmb.Position("place", marker="stone.center")],
    )


@pytest.mark.parametrize("second", [1e-12, 1e9])
def test_events_are_found_as_closely(second):
    """It falls by 0.1 m from rest: t = sqrt(0.2 / 9.81) s."""
    stone = fmb.PointMass("stone", mass=2.0, at=(0, 0, 1.0))
    model = fmb.Model(
        gravity=(0, 0, -9.81 / second**2),
        bodies=[fmb.Ground(), stone],
        sensors=[fmb.Position("place", marker="stone.center")],
        events=[fmb.Event("low", sensor="place", column=2, below=0.9, then=fmb.Stop())],
    )
    solution = fmb.simulate(model, t_end=second, samples=5, integrator=fmb.Explicit())
    assert solution.t[-1] / second == pytest.approx(np.sqrt(0.2 / 9.81), rel=1e-9)


@pytest.mark.parametrize("second", [1e-12, 1e9])
@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.Implicit()])
def test_steps_do_not_depend_on_the_unit_of_time(integrator, second):
    runs = [fmb.simulate(bouncing(s), t_end=s, samples=5, integrator=integrator) for s in (1.0, second)]
    assert runs[0].statistics["steps"] == pytest.approx(runs[1].statistics["steps"], rel=0.02)
    assert np.allclose(runs[0]["place"], runs[1]["place"], rtol=0, atol=1e-5)


@pytest.mark.parametrize("second", [1.0, 1e6, 1e9])
def test_speeds_of_slow_motions_are_resolved_by_ida(second):
    """x = 0.01 (1 - cos w t) with w = 10 rad by the unit: to 1e-3 also where a period is 7 days or 20 years."""
    w = 10.0 / second
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("p", mass=1.0, at=(1.0, 0, 0))],
        forces=[
            fmb.SpringDamper("k", markers=("ground.origin", "p.center"), stiffness=w * w, length=1.0),
            fmb.PointLoad("f", marker="p.center", force=(0.01 * w * w, 0, 0)),
        ],
        sensors=[fmb.Position("x", marker="p.center")],
    )
    run = fmb.simulate(model, 2.0 * second, samples=21, integrator=fmb.IDA())
    np.testing.assert_allclose(run["x"][:, 0], 1.01 - 0.01 * np.cos(w * run.t), atol=1.2e-5)
