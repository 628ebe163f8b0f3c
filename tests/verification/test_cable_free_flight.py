"""A curved, soft cable tumbles in free flight for ten thousand steps: momentum and energy are laws.

The trapezoidal rule (rho_inf = 1) on a constant mass matrix keeps linear momentum to rounding; angular momentum and
energy vary by an error of second order that does not grow.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem


def flight(step):
    """Return the largest relative changes of P, L and T + U over 2 s, and the largest share of U."""
    rope = fmb.AncfCable(
        "rope",
        points=((0, 0, 0), (0.5, 0.1, 0.05), (1, 0, 0.1)),
        elements=12,
        section=fem.Section.solid_circle(0.02),
        velocity=(1.0, 0.5, 2.0),
        angular_velocity=(3.0, 2.0, 9.0),
        material=fmb.Material(young=3e5, poisson=0.3, density=1000.0),
    )
    model = fmb.Model(
        bodies=(fmb.Ground(), rope),
        gravity=(0, 0, 0),
        sensors=(fmb.Momentum("p"), fmb.Energy("kinetic", kind="kinetic"), fmb.Energy("strain", kind="strain")),
    )
    found = fmb.simulate(model, t_end=2.0, samples=101, integrator=fmb.GeneralizedAlpha(rho_inf=1.0, step=step))
    p, energy = found["p"], found["kinetic"] + found["strain"]
    changes = [np.abs(x - x[0]).max() / np.linalg.norm(x[0]) for x in (p[:, :3], p[:, 3:])]
    return *changes, np.abs(energy / energy[0] - 1.0).max(), (found["strain"] / energy).max(), found.statistics["steps"]


def test_laws_over_ten_thousand_steps():
    linear, angular, energy, strained, steps = flight(2e-4)
    assert steps == 10000
    assert strained > 0.01  # it deforms
    assert linear < 1e-12
    assert angular < 1e-6
    assert energy < 5e-6
    twice = flight(4e-4)
    assert twice[1] / angular == pytest.approx(4.0, rel=0.1)
