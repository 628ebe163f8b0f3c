"""Rotors in casings: linear models whose joint couples axes that turn against each other.

References: rigid rotors on isotropic bearings in closed form (Genta, Dynamics of Rotating Systems, 2005, ch. 2),
Euler's equations linearised about the spin.
"""

import numpy as np
import pytest

import flexmb as fmb

K, KR, M, HUB, HUB_J, SPEED = 1e5, 500.0, 2.0, 1.0, 1e-3, 200.0


def rotor(inertia, stiffness=(K, K, K, KR, KR, KR), hub=HUB, speed=SPEED) -> fmb.Model:
    """A disc that turns about z in a hub on springs, which does not turn."""
    bodies = [
        fmb.Ground(),
        fmb.RigidBody("hub", mass=hub, inertia=(HUB_J,) * 3),
        fmb.RigidBody("disc", mass=M, inertia=inertia, angular_velocity=(0, 0, speed)),
    ]
    return fmb.Model(
        name="rotor",
        bodies=bodies,
        joints=[fmb.Revolute("bearing", markers=("hub.center", "disc.center"))],
        forces=[fmb.Bushing("springs", markers=("ground.origin", "hub.center"), stiffness=stiffness)],
    )


def test_a_round_rotor_in_a_casing():
    """Whirl seen from W: J p^2 - Jp w p - k = 0 forwards and backwards; lateral and axial sqrt(k / m);
    the hub's own turn.
    """
    linear = fmb.linearize(rotor((0.01, 0.01, 0.018)))
    whirl = np.abs(np.roots([0.01 + HUB_J, -0.018 * SPEED, -KR]))
    bounce = np.sqrt(K / (M + HUB))
    expected = np.sort([0.0, *whirl, bounce, bounce, bounce, np.sqrt(KR / HUB_J)]) / (2.0 * np.pi)
    assert linear.observer == "W"
    np.testing.assert_allclose(linear.frequencies, expected, rtol=1e-9, atol=1e-9)
    assert linear.stable


def test_its_whirl_is_that_of_a_simulation():
    """The same rotor, disturbed a little: the tilt of the hub is made of the two whirls of the closed form,
    within 1 %.
    """
    model = (
        rotor((0.01, 0.01, 0.018))
        .changed("hub", angular_velocity=(1e-4, 0, 0))
        .changed("disc", angular_velocity=(1e-4, 0, SPEED))
    )
    model = fmb.Model(
        bodies=model.bodies,
        joints=model.joints,
        forces=model.forces,
        sensors=[fmb.Orientation("tilt", marker="hub.center")],
    )
    solution = fmb.simulate(model, 0.4, samples=4001, integrator=fmb.GeneralizedAlpha(step=1e-4, rho_inf=0.95))
    tilt = 2.0 * (solution["tilt"][:, 1] + 1j * solution["tilt"][:, 2])
    whirl = np.roots([0.01 + HUB_J, -0.018 * SPEED, -KR])
    shapes = np.exp(1j * np.outer(solution.t, whirl))
    parts, left = np.linalg.lstsq(shapes, tilt, rcond=None)[:2]
    assert np.sqrt(left[0] / len(tilt)) < 1e-2 * np.abs(parts).max()
    np.testing.assert_allclose(
        np.sort(np.abs(whirl)) / (2.0 * np.pi), fmb.linearize(rotor((0.01, 0.01, 0.018))).frequencies[[1, 5]], rtol=1e-9
    )


def test_a_rotor_that_is_not_round_is_seen_from_its_own_axes():
    """Euler's equations in its axes, I1 w1' + (I3 - I2) W w2 = m1 and so on, w1 = t1' - W t2, w2 = t2' + W t1; the hub,
    round, turns against these axes."""
    first, second, polar = 0.013, 0.01, 0.018
    linear = fmb.linearize(rotor((first, second, polar)))
    assert linear.observer == "Body 'disc'"
    W, E, S = SPEED, np.eye(2), np.array([[0.0, -1.0], [1.0, 0.0]])
    A, gyro = np.diag([first, second]), np.diag([polar - second, first - polar])
    # w = t' + W S t; the moment of inertia forces: A w' + W gyro (w2, w1)
    swap = np.array([[0.0, 1.0], [1.0, 0.0]])
    mass = A + HUB_J * E
    damping = W * A @ S + W * gyro @ swap + 2.0 * W * HUB_J * S
    stiffness = W * W * gyro @ swap @ S - W * W * HUB_J * E + KR * E
    system = np.block([[np.zeros((2, 2)), E], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]])
    tilts = np.abs(np.linalg.eigvals(system).imag)
    bounce = np.sqrt(K / (M + HUB))
    rates = [0.0, *np.unique(np.round(tilts, 8)), bounce, abs(bounce - W), bounce + W, np.sqrt(KR / HUB_J)]
    np.testing.assert_allclose(linear.frequencies, np.sort(rates) / (2.0 * np.pi), rtol=1e-8, atol=1e-9)


def test_rotors_in_gear_are_seen_from_rest():
    """Two round wheels on one sprung casing, 100 and -200 rad/s:
    the casing tilts with their angular momenta, J, Jp w.
    """
    at = (0.3, 0.0, 0.0)
    bodies = [
        fmb.Ground(),
        fmb.RigidBody("case", mass=1.0, inertia=(0.02,) * 3, markers={"b": at}),
        fmb.RigidBody("one", mass=1e-6, inertia=(4e-3, 4e-3, 8e-3), angular_velocity=(0, 0, 100.0)),
        fmb.RigidBody("two", mass=1e-6, inertia=(1e-3, 1e-3, 2e-3), at=at, angular_velocity=(0, 0, -200.0)),
    ]
    joints = [
        fmb.Revolute("a", markers=("case.center", "one.center")),
        fmb.Revolute("b", markers=("case.b", "two.center")),
        fmb.Coupler("mesh", joints=("a", "b"), ratio=-0.5),
    ]
    model = fmb.Model(
        bodies=bodies,
        joints=joints,
        forces=[fmb.Bushing("springs", markers=("ground.origin", "case.center"), stiffness=(1e6, 1e6, 1e6, KR, KR, 0))],
    )
    linear = fmb.linearize(model)
    tilts = np.abs(np.roots([0.02 + 5e-3, -(8e-3 * 100.0 - 2e-3 * 200.0), -KR])) / (2.0 * np.pi)
    assert linear.observer == "W"
    for tilt in tilts:
        assert np.min(np.abs(linear.frequencies / tilt - 1.0)) < 1e-5


@pytest.mark.parametrize("precession", [3.0, 40.0])
def test_a_top_nutates_about_its_precession(precession):
    """J W^2 cos t - J3 w3 W + m g l = 0; the nutation is w^2 = V''(t) / J with the effective potential
    V = (p - p3 cos t)^2 / (2 J sin^2 t) + m g l cos t (Goldstein, Classical Mechanics, sect. 5.7)."""
    mass, lever, g, J, J3, tilt = 0.5, 0.03, 9.81, 0.0008, 0.0005, 0.6
    about = J + mass * lever**2
    spin = (about * precession**2 * np.cos(tilt) + mass * g * lever) / (J3 * precession)
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    w = spin * axis + precession * (np.array([0.0, 0.0, 1.0]) - np.cos(tilt) * axis)
    top = fmb.RigidBody(
        "top",
        mass=mass,
        inertia=(J, J, J3),
        center_of_mass=(0, 0, lever),
        rotation=(0, tilt, 0),
        angular_velocity=w,
        markers={"tip": (0, 0, 0)},
    )
    model = fmb.Model(
        gravity=(0, 0, -g),
        bodies=[fmb.Ground(), top],
        joints=[fmb.Spherical("tip", markers=("ground.origin", "top.tip"))],
    )
    linear = fmb.linearize(model)
    p, p3 = about * precession * np.sin(tilt) ** 2 + J3 * spin * np.cos(tilt), J3 * spin

    def potential(t):
        return (p - p3 * np.cos(t)) ** 2 / (2.0 * about * np.sin(t) ** 2) + mass * g * lever * np.cos(t)

    h = 1e-3  # differences of the fourth order
    second = np.dot([-1.0, 16.0, -30.0, 16.0, -1.0], [potential(tilt + k * h) for k in range(-2, 3)]) / (12.0 * h * h)
    assert linear.observer == "the precession of Body 'top'"
    assert linear.frequencies[-1] == pytest.approx(np.sqrt(second / about) / (2.0 * np.pi), rel=1e-6)
    np.testing.assert_allclose(linear.frequencies[:-1], 0.0, atol=1e-5)


def test_coefficients_that_change_with_time_are_told():
    """Neither rotor nor bearing is round: the equations are Mathieu's for every observer."""
    stiffness = (K, 3.0 * K, K, KR, 3.0 * KR, KR)
    with pytest.warns(
        fmb.ValidityWarning, match="Model 'rotor', linearize: the coefficients of this motion change with time"
    ):
        fmb.linearize(rotor((0.013, 0.01, 0.018), stiffness))
