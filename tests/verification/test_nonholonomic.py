"""Classical non-holonomic problems, each against its reduced equations, written by hand and integrated by scipy.

Neimark & Fufaev 1972: sleigh, rolling disc, Appell and Hamel's machine, ball on a turning plate; Bloch 2003:
snakeboard.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb

TIGHT = {"rtol": 1e-12, "atol": 1e-13}
EXPLICIT = fmb.Explicit(rtol=1e-10)
INTEGRATORS = [(EXPLICIT, 1e-7), (fmb.IDA(rtol=1e-8, atol=1e-10), 1e-5), (fmb.GeneralizedAlpha(rtol=1e-7), 1e-4)]


@pytest.mark.parametrize(("integrator", "within"), INTEGRATORS)
def test_chaplygin_sleigh(integrator, within):
    """Edge l behind the centre of mass: u' = l w^2, (J + m l^2) w' = -m l u w; side force m (u w + l w')."""
    m, J, l, u0, w0 = 2.0, 0.15, 0.3, 1.0, 2.0
    body = fmb.RigidBody(
        "s",
        mass=m,
        inertia=(1, 1, J),
        markers={"edge": (-l, 0, 0)},
        velocity=(u0, w0 * l, 0),
        angular_velocity=(0, 0, w0),
    )
    edge = fmb.Velocity("v", marker="s.edge", axes="s.edge")
    joints = [
        fmb.Planar("plane", markers=("ground.origin", "s.center")),
        fmb.Constraint("edge", over=[edge], equation="v[1]"),
    ]
    sensors = [fmb.AngularVelocity("w", marker="s.edge"), edge, fmb.Multiplier("side", joint="edge")]
    run = fmb.simulate(
        fmb.Model(bodies=[fmb.Ground(), body], joints=joints, sensors=sensors), 3.0, samples=13, integrator=integrator
    )
    own = solve_ivp(
        lambda t, y: (l * y[1] ** 2, -m * l * y[0] * y[1] / (J + m * l * l)), (0, 3), (u0, w0), t_eval=run.t, **TIGHT
    )
    u, w = own.y
    np.testing.assert_allclose(run["v"][:, 0], u, atol=within)
    np.testing.assert_allclose(run["w"][:, 2], w, atol=within)
    side = m * (u * w - l * m * l * u * w / (J + m * l * l))
    np.testing.assert_allclose(run["side"], side, atol=1e2 * within)


@pytest.mark.parametrize(("integrator", "within"), INTEGRATORS)
def test_appell_and_hamel_nonlinear_constraint(integrator, within):
    """z'^2 = c^2 (x'^2 + y'^2), Appell 1911: a weight on a thread that a rolling wheel winds up.

    With the horizontal speed s: (1 + c^2) s' = -c g for z' = c s, so both speeds fall at constant rates.
    """
    c, g, s0 = 0.4, 9.81, 3.0
    way = np.array((0.6, 0.8))
    point = fmb.PointMass("p", mass=1.7, velocity=(*(s0 * way), c * s0))
    speed = fmb.Velocity("v", marker="p.center")
    law = fmb.Constraint("law", over=[speed], equation="v[2]**2 = c**2*(v[0]**2 + v[1]**2)", parameters={"c": c})
    model = fmb.Model(bodies=[point], joints=[law], gravity=(0, 0, -g), sensors=[speed])
    run = fmb.simulate(model, 0.5, samples=6, integrator=integrator)
    s = s0 - c * g / (1 + c * c) * run.t
    np.testing.assert_allclose(run["v"], np.column_stack([np.outer(s, way), c * s]), atol=within)


def test_rolling_disc_on_a_slope_from_velocities_of_its_contact():
    """The disc of `Rolling` (touching and no slip) on a plane tilted by 0.3 rad, upright: x'' = 2/3 g sin(0.3)."""
    m, r, tilt = 1.5, 0.2, 0.3
    disc = fmb.RigidBody(
        "d", mass=m, inertia=(m * r * r / 4, m * r * r / 4, m * r * r / 2), at=(0, 0, r), rotation=(-np.pi / 2, 0, 0)
    )
    velocity = fmb.Velocity("v", marker="d.center")
    spin = fmb.AngularVelocity("w", marker="d.center")
    place = fmb.Position("p", marker="d.center")
    joints = [
        fmb.Constraint("height", over=[place], equation="p[2] = r", parameters={"r": r}),
        fmb.Constraint("along", over=[velocity, spin], equation="v[0] = r*w[1]", parameters={"r": r}),
        fmb.Constraint("across", over=[velocity, spin], equation="v[1] + r*w[0]", parameters={"r": r}),
    ]
    g = 9.81 * np.array((np.sin(tilt), 0, -np.cos(tilt)))
    model = fmb.Model(
        bodies=[disc], joints=joints, gravity=g, sensors=[velocity, fmb.Multiplier("friction", joint="along")]
    )
    run = fmb.simulate(model, 1.0, samples=5, integrator=EXPLICIT)
    a = 2.0 / 3.0 * g[0]
    np.testing.assert_allclose(run["v"][:, 0], a * run.t, atol=1e-8)
    np.testing.assert_allclose(run["friction"], -m * g[0] / 3.0, rtol=1e-8)


def test_ball_on_a_turning_plate_goes_in_circles():
    """A solid sphere that rolls on a plate turning at W goes in a circle at 2/7 W (Milne 1948, Neimark & Fufaev).

    The contact of the plate moves with W x r: v - r w x n = W x p, v_x - r w_y = -W p_y, v_y + r w_x = W p_x.
    """
    m, r, W = 0.7, 0.1, 2.0
    start, v0 = np.array((0.5, 0.0)), np.array((0.1, 0.3))
    # rolling at the start: w_y = (v_x + W p_y) / r, w_x = (W p_x - v_y) / r
    w0 = ((W * start[0] - v0[1]) / r, (v0[0] + W * start[1]) / r, 0.0)
    ball = fmb.RigidBody(
        "b", mass=m, inertia=(0.4 * m * r * r,) * 3, at=(*start, r), velocity=(*v0, 0), angular_velocity=w0
    )
    over = [
        fmb.Position("p", marker="b.center"),
        fmb.Velocity("v", marker="b.center"),
        fmb.AngularVelocity("w", marker="b.center"),
    ]
    numbers = {"r": r, "W": W}
    joints = [
        fmb.Constraint("height", over=over[:1], equation="p[2] = r", parameters={"r": r}),
        fmb.Constraint("x", over=over, equation="v[0] - r*w[1] + W*p[1]", parameters=numbers),
        fmb.Constraint("y", over=over, equation="v[1] + r*w[0] - W*p[0]", parameters=numbers),
    ]
    run = fmb.simulate(
        fmb.Model(bodies=[ball], joints=joints, sensors=over[:1], gravity=(0, 0, -9.81)),
        5.0,
        samples=11,
        integrator=EXPLICIT,
    )
    k = 2.0 / 7.0 * W  # v' = k z x v
    c, s = np.cos(k * run.t), np.sin(k * run.t)
    x = start[0] + (v0[0] * s - v0[1] * (1 - c)) / k
    y = start[1] + (v0[1] * s + v0[0] * (1 - c)) / k
    np.testing.assert_allclose(run["p"][:, :2], np.column_stack([x, y]), atol=1e-7)


def test_pursuit_curve():
    """A dog of constant speed that always runs towards a hare on a straight line (Bouguer 1732).

    Two equations of velocities: |v| = V (not linear), and v across the line of sight zero. Without other forces the
    path is that of the kinematics, d' = V (hare - d) / |hare - d|.
    """
    V, hare = 2.0, 1.0
    dog = fmb.PointMass("dog", mass=3.0, velocity=(V, 0, 0))
    over = [fmb.Position("p", marker="dog.center"), fmb.Velocity("v", marker="dog.center")]
    numbers = {"V": V, "h": hare}
    joints = [
        fmb.Constraint("speed", over=over[1:], equation="v[0]**2 + v[1]**2 + v[2]**2 = V**2", parameters=numbers),
        fmb.Constraint("sight", over=over, equation="v[0]*(h*t - p[1]) - v[1]*(2 - p[0])", parameters=numbers),
        fmb.Constraint("plane", over=over[:1], equation="p[2]"),
    ]
    run = fmb.simulate(fmb.Model(bodies=[dog], joints=joints, sensors=over), 1.0, samples=6, integrator=EXPLICIT)

    def chase(t, d):
        sight = np.array((2.0, hare * t)) - d
        return V * sight / np.linalg.norm(sight)

    own = solve_ivp(chase, (0, 1), (0, 0), t_eval=run.t, **TIGHT)
    np.testing.assert_allclose(run["p"][:, :2], own.y.T, atol=1e-7)


def test_snakeboard_with_its_rotor_driven():
    """Bloch 2003: board (m, J) with wheels l ahead and behind at angles p and -p, rotor Jr turned by psi(t).

    With the speed u along the board, w = k u, k = -tan p / l; virtual motions are (1, k), so that
    m u' + k ((J + Jr) w' + Jr psi'') = 0.
    """
    m, J, Jr, l = 3.0, 0.2, 0.05, 0.4

    def wheel(t):
        return 0.5 + 0.2 * np.sin(2 * t), 0.4 * np.cos(2 * t)

    def hand(t, y):
        p, dp = wheel(t)
        k = -np.tan(p) / l
        dk = -dp / (l * np.cos(p) ** 2)
        u = y[0]
        psi2 = -3.0 * np.sin(3.0 * t) * 3.0
        du = -(k * ((J + Jr) * dk * u + Jr * psi2)) / (m + k * k * (J + Jr))
        return (du, k * u)

    u0 = 1.0
    k0 = -np.tan(0.5) / l
    board = fmb.RigidBody(
        "b",
        mass=m,
        inertia=(1, 1, J),
        markers={"front": (l, 0, 0), "back": (-l, 0, 0), "axle": (0, 0, 0)},
        velocity=(u0, 0, 0),
        angular_velocity=(0, 0, k0 * u0),
    )
    rotor = fmb.RigidBody(
        "r",
        mass=1e-9,
        inertia=(Jr, Jr, Jr),
        markers={"axle": (0, 0, 0)},
        velocity=(u0, 0, 0),
        angular_velocity=(0, 0, k0 * u0 + 3.0),
    )
    front = fmb.Velocity("f", marker="b.front", axes="b.front")
    back = fmb.Velocity("k", marker="b.back", axes="b.back")
    turned = {"c": fmb.expression("cos(0.5 + 0.2*sin(2*t))"), "s": fmb.expression("sin(0.5 + 0.2*sin(2*t))")}
    joints = [
        fmb.Planar("plane", markers=("ground.origin", "b.axle")),
        fmb.Revolute("axle", markers=("b.axle", "r.axle")),
        fmb.Drive("rotor", joint="axle", angle=fmb.expression("sin(3*t)")),
        fmb.Constraint("front wheel", over=[front], equation="f[1]*c + f[0]*s", parameters=turned),
        fmb.Constraint("back wheel", over=[back], equation="k[1]*c - k[0]*s", parameters=turned),
    ]
    sensors = [front, fmb.AngularVelocity("w", marker="b.axle")]
    run = fmb.simulate(
        fmb.Model(bodies=[fmb.Ground(), board, rotor], joints=joints, sensors=sensors),
        3.0,
        samples=13,
        integrator=EXPLICIT,
    )
    own = solve_ivp(hand, (0, 3), (u0, 0.0), t_eval=run.t, **TIGHT)
    np.testing.assert_allclose(run["f"][:, 0], own.y[0], atol=1e-6)


def test_servo_constraint_on_a_figure_of_eight_is_inverse_dynamics():
    """A point that two equations hold on x = sin t, y = sin 2t: their multipliers are m a - m g by hand."""
    m, g = 1.3, np.array((0.5, -9.81, 0.0))
    point = fmb.PointMass("p", mass=m, velocity=(1, 2, 0))
    place = fmb.Position("q", marker="p.center")
    joints = [
        fmb.Constraint(name, over=[place], equation=equation)
        for name, equation in (("x", "q[0] = sin(t)"), ("y", "q[1] = sin(2*t)"), ("z", "q[2]"))
    ]
    sensors = [place, *(fmb.Multiplier(f"force {name}", joint=name) for name in "xy")]
    model = fmb.Model(bodies=[point], joints=joints, gravity=g, sensors=sensors)
    run = fmb.simulate(model, 2.0, samples=9, integrator=fmb.GeneralizedAlpha(rtol=1e-7))
    np.testing.assert_allclose(run["force x"], m * (-np.sin(run.t) - g[0]), atol=1e-5)
    np.testing.assert_allclose(run["force y"], m * (-4.0 * np.sin(2 * run.t) - g[1]), atol=1e-5)
