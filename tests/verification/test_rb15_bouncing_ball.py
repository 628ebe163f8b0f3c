"""RB15: a bouncing ball with a constant coefficient of restitution.

Reference: closed form of the times of instantaneous impacts. An event with Impact meets them to 1e-11 s. A contact of
finite duration, a linear spring and damper that does not pull, has a restitution that is the same at every speed
(Schwager & Poeschel 2007, eq. 16), and its impact times tend to the instantaneous ones as it stiffens.
"""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fmb

STIFFNESS = 1e8


def restitution(beta, stiffness, mass):
    """e of m p'' + 2 m beta p' + k p = 0 that ends when the force vanishes."""
    omega = np.sqrt(stiffness / mass - beta**2)
    return np.exp(-beta / omega * (np.pi - np.arctan2(2 * beta * omega, omega**2 - beta**2)))


def test_instantaneous_impacts(reference):
    case = reference("RB15")
    markers = ("ground.origin", "ball.center")
    model = fmb.Model(
        gravity=(0, 0, -case["model"]["g"]),
        bodies=[fmb.Ground(), fmb.PointMass("ball", mass=1.0, at=(0, 0, case["model"]["h"]))],
        sensors=[fmb.Distance("height", markers=markers, along="z")],
        events=[
            fmb.Event(
                "bounce",
                sensor="height",
                below=0.0,
                repeats=True,
                then=fmb.Impact(markers, restitution=case["model"]["e"], along="z"),
            )
        ],
    )
    solution = fmb.simulate(model, case["duration_s"], samples=40001)
    times = [phase.t[-1] for phase in solution.phases[:6]]
    np.testing.assert_allclose(times, case["reference"]["impact_times"], atol=1e-9)
    apexes = [solution["height"][(solution.t > a) & (solution.t < b)].max() for a, b in pairwise(times)]
    np.testing.assert_allclose(apexes, case["reference"]["apex_heights"], atol=1e-7)
    with pytest.raises(fmb.IntegrationError, match="again and again") as caught:
        fmb.simulate(model, 5.0)
    assert caught.value.solution.t[-1] == pytest.approx(case["reference"]["zeno_time_s"], abs=1e-3)


def test_impact_times(reference):
    case = reference("RB15")
    h, e = case["model"]["h"], case["model"]["e"]
    beta = brentq(lambda b: restitution(b, STIFFNESS, 1.0) - e, 1.0, 5e3)
    model = fmb.Model(
        gravity=(0, 0, -case["model"]["g"]),
        bodies=[fmb.Ground(), fmb.PointMass("ball", mass=1.0, at=(0, 0, h))],
        forces=[
            fmb.OneSidedSpring(
                "floor",
                markers=("ground.origin", "ball.center"),
                along="z",
                stiffness=STIFFNESS,
                exponent=1.0,
                damping=2.0 * beta,
                depth=1e-9,
                length=0.0,
            )
        ],
        sensors=[fmb.Position("height", marker="ball.center")],
    )
    times = np.linspace(0.0, 2.7, 5401)
    solution = fmb.simulate(model, 2.7, samples=times, integrator=fmb.GeneralizedAlpha(rtol=1e-11, largest=0.01))
    z = solution["height"][:, 2]
    minima = [k for k in range(1, len(z) - 1) if z[k] < z[k - 1] and z[k] <= z[k + 1]]
    found = times[minima]
    expected = case["reference"]["impact_times"][:5]
    np.testing.assert_allclose(found, expected, atol=2e-3)
    apexes = [z[a:b].max() for a, b in pairwise(minima)]
    np.testing.assert_allclose(apexes, case["reference"]["apex_heights"][: len(apexes)], rtol=2e-3)
