"""Work of equations of the user that move by themselves: all of the kinetic energy of a free point mass."""

import warnings

import numpy as np
import pytest

import flexmb as fmb

EQUATIONS = {
    "place": ("p[0] = 0.3*t**2 + 0.1*t", 0.5 * (0.7**2 - 0.1**2)),
    "speed along": ("v[0] = 0.1 + 2*t", 0.5 * (2.1**2 - 0.1**2)),
    "speed": ("v[0]**2 + v[1]**2 + v[2]**2 = (0.1 + t)**2", 0.5 * (1.1**2 - 0.1**2)),
    "autonomous": ("v[0] = 0.1 + 5*p[0]", 0.5 * 0.1**2 * (np.exp(10.0) - 1.0)),
    "none": ("0.3*v[1] + 0.1*v[2]*p[1] = 0.7*v[0]*p[2]", 0.0),
}


@pytest.mark.parametrize("integrator", [fmb.Implicit(), fmb.IDA()], ids=["Implicit", "IDA"])
@pytest.mark.parametrize("name", EQUATIONS)
def test_work_is_the_gain_of_kinetic_energy(name, integrator):
    """Closed forms of v^2/2 after 1 s; no energy that no law explains."""
    equation, expected = EQUATIONS[name]
    mass = fmb.PointMass("b", mass=1.0, at=(0, 0.3, 0), velocity=(0.1, 0, 0))
    over = [fmb.Position("p", marker="b.center"), fmb.Velocity("v", marker="b.center")]
    own = fmb.Constraint("c", over=over, equation=equation)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = fmb.simulate(fmb.Model(bodies=[mass], joints=[own]), t_end=1.0, samples=11, integrator=integrator)
    assert run.phases[0].works[-1, 1] == pytest.approx(expected, rel=1e-3, abs=1e-12)


def test_error_of_the_work_chooses_steps():
    """A sine of 50 periods is no error of a coordinate that is driven; its work is."""
    over = [fmb.Position("p", marker="b.center")]
    own = fmb.Constraint("c", over=over, equation="p[2] = 0.01*sin(314*t)")
    model = fmb.Model(bodies=[fmb.PointMass("b", mass=1.0, velocity=(0, 0, 3.14))], joints=[own])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = fmb.simulate(model, t_end=1.0, samples=41, integrator=fmb.Implicit())
    kinetic = 0.5 * (3.14 * np.cos(314.0 * run.t)) ** 2
    np.testing.assert_allclose(run.phases[0].works[:, 1], kinetic - kinetic[0], atol=0.02 * kinetic[0])
