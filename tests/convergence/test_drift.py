"""Energy, momentum and constraints over 1e5 steps of generalized-alpha: bounded, and smaller with the step size.

Reached with rho 0.8. Two bodies on a hinge in free flight, h = 1e-3 and 5e-4: energy 1.1e-6 and 2.8e-7 of 0.42 J,
without growth; momenta 1.5e-10 and 1.1e-11 kg m/s (the tolerance of the iteration), 1.0e-6 and 2.5e-7 kg m2/s;
constraints 1e-14. Double pendulum in space, h = 1e-3 and 5e-4: energy 3.2e-3 and 2.9e-4 of 21 J without growth,
constraints 2e-14 m.
"""

import numpy as np
import pytest

import flexmb as fmb

STEPS = 100_000


def flying() -> fmb.Model:
    """Two bodies on a skew hinge, no gravity."""
    hinge = (0.3, 0.2, 0.1)
    a = fmb.RigidBody(
        "a",
        mass=2.0,
        inertia=(0.02, 0.05, 0.06),
        angular_velocity=(3.0, 1.0, -2.0),
        markers={"j": fmb.Pose((0.3, 0, 0), hinge)},
    )
    b = fmb.RigidBody(
        "b",
        mass=1.0,
        inertia=(0.01, 0.03, 0.025),
        at=(0.5, 0.1, 0),
        velocity=(0.2, 0.5, -0.3),
        angular_velocity=(-1.0, 2.0, 4.0),
        markers={"j": fmb.Pose((-0.2, -0.1, 0), hinge)},
    )
    sensors = [fmb.Energy("energy"), fmb.Momentum("momentum"), fmb.ConstraintError("gap")]
    return fmb.Model(bodies=[fmb.Ground(), a, b], joints=[fmb.Revolute("j", markers=("a.j", "b.j"))], sensors=sensors)


def pendulum() -> fmb.Model:
    """Two rods on ball joints, under gravity."""
    rods = [
        fmb.RigidBody.rod("a", length=1.0, mass=1.0, radius=0.05),
        fmb.RigidBody.rod("b", length=0.7, mass=0.5, radius=0.04, at=(1.0, 0, 0), rotation=(0, 0, 0.5)),
    ]
    joints = [
        fmb.Spherical("u", markers=("ground.origin", "a.start")),
        fmb.Spherical("v", markers=("a.end", "b.start")),
    ]
    sensors = [fmb.Energy("energy"), fmb.ConstraintError("gap")]
    return fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), *rods], joints=joints, sensors=sensors)


def bounded(values, limit: float) -> None:
    """Check that a conserved quantity (nt,) stays within a limit, and does not leave it steadily."""
    off = np.abs(values - values[0])
    assert off.max() < limit
    half = len(off) // 2
    assert off[half:].max() < 3.0 * off[:half].max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "step", "energy", "momentum"),
    [
        (flying(), 1e-3, 3e-6, 3e-6),
        (flying(), 5e-4, 8e-7, 8e-7),
        (pendulum(), 1e-3, 1e-2, None),
        (pendulum(), 5e-4, 1e-3, None),
    ],
    ids=["flying", "flying, half step", "pendulum", "pendulum, half step"],
)
def test_a_hundred_thousand_steps(model, step, energy, momentum):
    solution = fmb.simulate(model, STEPS * step, samples=1001, integrator=fmb.GeneralizedAlpha(step=step))
    assert solution.statistics["steps"] >= STEPS
    assert solution["gap"].max() < 1e-12
    bounded(solution["energy"], energy)
    if momentum is not None:
        off = np.abs(solution["momentum"] - solution["momentum"][0])
        assert off[:, :3].max() < 1e-8
        assert off.max() < momentum


@pytest.mark.parametrize(
    "integrator", [fmb.Explicit(rtol=1e-9, atol=1e-10), fmb.IDA(rtol=1e-8, atol=1e-8)], ids=["explicit", "IDA"]
)
def test_other_integrators_keep_the_joints_closed(integrator):
    """Projection (1e-10 of the size) and stabilised index two (the tolerance) over ten seconds of free flight."""
    solution = fmb.simulate(flying(), 10.0, samples=101, integrator=integrator)
    assert solution["gap"].max() < 1e-7
    bounded(solution["energy"], 2e-6)
    assert np.abs(solution["momentum"] - solution["momentum"][0]).max() < 1e-5
