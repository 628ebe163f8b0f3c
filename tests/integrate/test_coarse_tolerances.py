"""Coarse tolerances of generalized-alpha in long chains of small links: tolerances are relative to the length of the
whole.

References: the energy, which does not change, and the explicit method of order eight at a tolerance of 1e-8. Reached:
energy 3e-4 of the greatest kinetic energy, the free end 2e-4 of the length. With rotations judged by the length of the
whole, such runs ended in errors or with half as much energy again.
"""

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb


def falling(n: int) -> fmb.Model:
    """Return a horizontal chain of n rods of 0.1 m on ball joints, held at one end."""
    rods = [fmb.RigidBody.rod(f"r{k}", length=0.1, mass=0.1, radius=0.01, at=(0.1 * k, 0, 0)) for k in range(n)]
    names = ["ground.origin"] + [f"r{k}.end" for k in range(n)]
    joints = [fmb.Spherical(f"j{k}", markers=(names[k], f"r{k}.start")) for k in range(n)]
    sensors = [fmb.Energy("total"), fmb.Energy("kinetic", kind="kinetic"), fmb.Position("tip", marker=f"r{n - 1}.end")]
    return fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), *rods], joints=joints, sensors=sensors)


@pytest.mark.parametrize(("n", "rtol"), every_second([30, 60], [1e-2, 1e-3, 1e-4]))
def test_a_falling_chain_keeps_its_energy(n, rtol):
    run, exact = (
        fmb.simulate(falling(n), 0.5, samples=6, integrator=integrator)
        for integrator in (fmb.GeneralizedAlpha(rtol=rtol), fmb.Explicit(rtol=1e-8, atol=1e-9))
    )
    assert np.ptp(run["total"]) < 1e-3 * run["kinetic"].max()
    np.testing.assert_allclose(run["tip"], exact["tip"], atol=5e-4 * 0.1 * n)


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha, fmb.Implicit, fmb.IDA, fmb.Explicit])
def test_a_tolerance_that_is_a_whole_number(integrator):
    """Compiled steps know tolerances as floats: an integer ended in an error of the compiler."""
    runs = [fmb.simulate(falling(2), 0.05, samples=3, integrator=integrator(rtol=rtol)) for rtol in (1, 1.0)]
    assert np.array_equal(runs[0]["tip"], runs[1]["tip"])
