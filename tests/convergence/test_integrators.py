"""DAE2: orders of convergence of the integrators on a pendulum from 60 degrees; closed form.

Reached with generalized-alpha, rho 0.8, from h = 1/100 to 1/1600: positions, velocities and rod force 2.00. At 1/800
the rod force errs by 5.3e-5 N of 5.5 N, which is what the error of the velocity, 2.8e-5 m/s of 1.9 m/s, makes of it.
IDA at rtol 1e-6 to 1e-10: 3e-4 to 1e-8 m.
Explicit methods: RK45 4.8 to 5.3, Radau 4.2 to 5.5 for h = 1/5 to 1/160; DOP853 7.5 to 10 for h = 1/4 to 1/32 (7.0 for
the velocity from 1/6 to 1/12, where its error is small by chance at the coarser step).
"""

import numpy as np
import pytest

import flexmb as fmb


@pytest.fixture
def pendulum():
    start = np.radians(60.0)
    return fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), fmb.PointMass("mass", mass=1.0, at=(-np.sin(start), -np.cos(start), 0))],
        joints=[fmb.Rod("rod", markers=("ground.origin", "mass.center"), length=1.0)],
        sensors=[
            fmb.Position("p", marker="mass.center"),
            fmb.Velocity("v", marker="mass.center"),
            fmb.Reaction("force", joint="rod"),
        ],
    )


def errors(model, case, integrator):
    """Return the errors of position (m), velocity (m/s) and rod force (N) at t = 1 s."""
    theta, tension = case["reference"]["theta_exact_t1"], case["reference"]["tension_exact_t1"]
    # energy gives the speed: v^2 = 2 g (cos theta - cos 60 deg); at this time the mass still swings up
    speed = np.sqrt(2 * 9.81 * (np.cos(theta) - 0.5))
    out = fmb.simulate(model, 1.0, samples=3, integrator=integrator)
    along = np.array([np.cos(theta), np.sin(theta), 0.0])
    velocity = np.linalg.norm(out["v"][-1] - speed * along * np.sign(out["v"][-1] @ along))
    position = np.linalg.norm(out["p"][-1] - [np.sin(theta), -np.cos(theta), 0.0])
    return np.array([position, velocity, abs(np.linalg.norm(out["force"][-1]) - tension)])


@pytest.mark.parametrize("rho", [0.5, 0.7, 0.8])
def test_generalized_alpha_is_of_order_two(pendulum, reference, rho):
    """The factor from h = 1/800 to 1/1600, where the multipliers have reached the asymptotic range for all rho."""
    coarse, fine = (
        errors(pendulum, reference("DAE2"), fmb.GeneralizedAlpha(step=1 / n, rho_inf=rho)) for n in (800, 1600)
    )
    np.testing.assert_allclose(np.log2(coarse / fine), 2.0, atol=0.15)


def force_errors(model, times, integrator):
    """Return the largest errors of the rod force (N, from the height by energy) and of the velocity along the rod."""
    out = fmb.simulate(model, times[-1], samples=times, integrator=integrator)
    tension = 9.81 * (-3.0 * out["p"][:, 1] - 1.0)  # m (g cos + v^2), v^2 = 2 g (cos - cos 60 deg), cos = -y
    along = np.abs(np.sum(out["p"] * out["v"], axis=1))
    return np.abs(np.linalg.norm(out["force"], axis=1) - tension).max(), along.max()


def test_multipliers_are_of_order_two_from_the_first_step(pendulum):
    coarse, fine = (force_errors(pendulum, np.arange(11) * h, fmb.GeneralizedAlpha(step=h)) for h in (4e-3, 2e-3))
    assert np.log2(coarse[0] / fine[0]) > 1.9


def test_multipliers_are_of_order_two_when_the_step_size_changes(pendulum):
    """Samples that do not fit the step make it change at every sample, by up to a half."""
    times = np.cumsum(np.r_[0.0, np.tile([0.0105, 0.0161, 0.0042, 0.0198], 6)])
    coarse = force_errors(pendulum, times, fmb.GeneralizedAlpha(step=4e-3))
    fine = force_errors(pendulum, times, fmb.GeneralizedAlpha(step=1e-3))
    assert np.log2(coarse[0] / fine[0]) / 2 > 1.8


def test_samples_satisfy_the_constraints_of_velocities(pendulum):
    times = np.linspace(0.0, 1.0, 38)
    assert force_errors(pendulum, times, fmb.GeneralizedAlpha(step=1e-2))[1] < 1e-6
    assert force_errors(pendulum, times, fmb.GeneralizedAlpha())[1] < 1e-7


def test_reactions_of_adaptive_runs(pendulum):
    """Multipliers of samples are as accurate as the positions, although the steps change."""
    assert force_errors(pendulum, np.linspace(0.0, 2.0, 51), fmb.GeneralizedAlpha())[0] < 1e-3 * 2 * 9.81


def test_errors_at_the_default(pendulum, reference):
    found = errors(pendulum, reference("DAE2"), fmb.GeneralizedAlpha(step=1 / 800))
    assert np.all(found < [3e-6, 3e-5, 6e-5])


def test_reactions_of_a_driven_crank_do_not_depend_on_the_step_size():
    """Crank with the angle 0.8 sin 5t: the torque J phi'' + m g r cos phi follows from the angle alone."""
    crank = fmb.RigidBody(
        "crank", mass=2.0, inertia=(0.01, 0.03, 0.03), center_of_mass=(0.4, 0, 0), markers={"pin": (0, 0, 0)}
    )
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), crank],
        joints=[
            fmb.Revolute("pin", markers=("ground.origin", "crank.pin")),
            fmb.Drive("motor", joint="pin", angle=fmb.expression("0.8*sin(5*t)")),
        ],
        sensors=[fmb.Reaction("torque", joint="motor")],
    )
    t = np.linspace(0.0, 1.0, 26)
    out = fmb.simulate(model, 1.0, samples=t, integrator=fmb.GeneralizedAlpha(step=0.02))
    angle, rate2 = 0.8 * np.sin(5 * t), -20.0 * np.sin(5 * t)
    torque = (0.03 + 2.0 * 0.4**2) * rate2 + 2.0 * 9.81 * 0.4 * np.cos(angle)
    np.testing.assert_allclose(np.abs(out["torque"][:, 5]), np.abs(torque), atol=1e-8 * np.abs(torque).max())


def test_adaptive_steps_follow_the_tolerance(pendulum, reference):
    """Local errors of order three make the global error follow rtol^(2/3): a factor 21.5 per two decades."""
    found = [errors(pendulum, reference("DAE2"), fmb.GeneralizedAlpha(rtol=rtol))[0] for rtol in (1e-5, 1e-7, 1e-9)]
    assert found[0] < 1e-2
    assert found[0] / found[2] > 100.0


@pytest.mark.parametrize(
    ("method", "order", "steps"), [("RK45", 5, 40), ("Radau", 5, 20), ("DOP853", 8, 8)], ids=["RK45", "Radau", "DOP853"]
)
def test_orders_of_explicit(pendulum, reference, method, order, steps):
    """Positions, velocities and multipliers; tolerances so wide that the largest step is taken always.

    Steps end at the sample in the middle of the second: their number is even.
    """
    settings = {"method": method, "rtol": 1e3, "atol": 1e3}
    coarse, fine = (
        errors(pendulum, reference("DAE2"), fmb.Explicit(**settings, largest=1 / n)) for n in (steps, 2 * steps)
    )
    assert np.all(np.log2(coarse / fine) > order - 0.5)


def test_ida_follows_the_tolerance(pendulum, reference):
    found = [errors(pendulum, reference("DAE2"), fmb.IDA(rtol=tol, atol=tol)) for tol in (1e-6, 1e-8, 1e-10)]
    for error, limit in zip(found, (1e-3, 1e-5, 1e-7), strict=True):
        assert np.all(error < 10 * limit)
        assert error[0] < limit
