"""Targets of motors with kinks: their damping follows the rate of the target, which jumps there.

Reference: the step response of a damped oscillator, by scipy.signal.
"""

import numpy as np
import pytest
from scipy.signal import TransferFunction, step

import flexmb as fmb

STIFFNESS, DAMPING, LENGTH, RADIUS, BEGIN, END = 100.0, 3.0, 1.0, 0.02, 0.05, 0.2


def motor(rise: float) -> fmb.Model:
    """A rod turned about its end by a motor whose target goes from 0 to 1 rad within `rise`, s."""
    target = fmb.table([0.0, BEGIN, BEGIN + rise, 1.0], [0.0, 0.0, 1.0, 1.0], kind="linear")
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"o": (0, 0, 0)}),
            fmb.RigidBody.rod("rod", length=LENGTH, mass=1.0, radius=RADIUS),
        ],
        joints=[fmb.Revolute("pin", markers=("ground.o", "rod.start"))],
        forces=[fmb.Motor("motor", joint="pin", target=target, stiffness=STIFFNESS, damping=DAMPING)],
        sensors=[fmb.JointCoordinate("angle", joint="pin")],
    )


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Explicit(), fmb.Implicit()], ids=lambda i: type(i).__name__
)
def test_target_that_rises_at_once(integrator):
    """3 Nms act within a nanosecond. A stage that reads the rate on the other side of the kink makes 2 rad and more."""
    about_x = 0.5 * RADIUS**2
    inertia = LENGTH**2 / 3.0 + 0.5 * about_x  # of a solid cylinder about its end
    times = np.linspace(0.0, END - BEGIN, 301)
    _, expected = step(TransferFunction([DAMPING, STIFFNESS], [inertia, DAMPING, STIFFNESS]), T=times)
    solution = fmb.simulate(motor(1e-9), END, samples=11, integrator=integrator)
    np.testing.assert_allclose(solution["angle"][-1], expected[-1], rtol=1e-4)
