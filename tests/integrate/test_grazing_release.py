"""A mass on a hard stop, far from the origin, is lifted by a force that hardly exceeds its weight.

It leaves with so little speed that the change of speed in a step disappears in the rounding of positions. Steps go on,
and the motion is that of SciPy's DOP853.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb

WEIGHT, STIFFNESS, FAR = 9.81, 1e8, 30.0
TIMES, END = (0.0, 0.01, 0.02, 1.0), 0.03


def lifting(excess: float) -> tuple[float, ...]:
    """Return the force at `TIMES`, N: it grows to more than the weight and falls below it."""
    return (0.0, WEIGHT * (1.0 + excess), WEIGHT * (1.0 - 2.0 * excess), WEIGHT * (1.0 - 2.0 * excess))


def height(excess: float) -> float:
    """Return the height at the end above the untouched stop, m, by SciPy, from kink to kink of the force."""
    y = np.array([-WEIGHT / STIFFNESS, 0.0])
    for t0, t1 in ((0.0, 0.01), (0.01, 0.02), (0.02, END)):
        first, last = np.interp((t0, t1), TIMES, lifting(excess))

        def rates(t, y, first=first, slope=(last - first) / (t1 - t0), t0=t0):
            return [y[1], first + slope * (t - t0) - WEIGHT + STIFFNESS * max(0.0, -y[0])]

        # a sixtieth of a period of the stop; steps of 2e-6 s change the height by 2e-15 m
        y = solve_ivp(rates, (t0, t1), y, method="DOP853", rtol=1e-12, atol=1e-16, max_step=1e-5).y[:, -1]
    return float(y[0])


@pytest.mark.parametrize("excess", [1e-2, 1e-4])
def test_the_motion_goes_on(excess):
    lift = fmb.table(TIMES, lifting(excess), kind="linear")
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"stop": (FAR, 0, 0), "origin": (0, 0, 0)}),
            fmb.PointMass("mass", mass=1.0, at=(FAR, 0, 1.0 - WEIGHT / STIFFNESS)),
        ],
        forces=[
            fmb.OneSidedSpring(
                "touch", markers=("ground.stop", "mass.center"), stiffness=STIFFNESS, exponent=1.0, length=1.0
            ),
            fmb.PointLoad("lift", marker="mass.center", force=(0, 0, lift)),
        ],
        sensors=[fmb.Position("place", marker="mass.center")],
        gravity=(0, 0, -WEIGHT),
    )
    solution = fmb.simulate(model, END, samples=3, integrator=fmb.GeneralizedAlpha(rtol=1e-10))
    reached, expected = solution["place"][-1, 2] - 1.0, height(excess)

    assert abs(reached - expected) < 3e-9  # rtol of the 30 m between the parts
    assert solution.statistics["steps"] < 9000  # 10 000 to 13 000 where rounding shortened them
