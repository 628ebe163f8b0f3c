"""Muscles against Thelen's equations solved by scipy, and their ways against geodesics found by minimisation."""

import numpy as np
import pytest
from contracts.random_models import body
from contracts.test_tangents import assert_tangent
from forces.described_markers import Described
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, least_squares

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.forces.muscle_curves import contraction
from flexmb.forces.path_fields import described_length
from flexmb.system import compile
from flexmb.system.program import evaluate

F0, L0, LT, AP, VMAX = 1200.0, 0.1, 0.2, 0.3, 10.0
AF, FLEN, GAMMA, KPE, EPE, ETEN = 0.25, 1.4, 0.45, 5.0, 0.6, 0.04


def fl(x):
    return np.exp(-((x - 1.0) ** 2) / GAMMA)


def fpe(x):
    return 0.0 if x < 1.0 else (np.exp(KPE * (x - 1.0) / EPE) - 1.0) / (np.exp(KPE) - 1.0)


def ft(e):
    toe = 0.609 * ETEN
    if e <= 0.0:
        return 0.0
    return 0.33 / (np.exp(3.0) - 1.0) * (np.exp(3.0 * e / toe) - 1.0) if e <= toe else 1.712 / ETEN * (e - toe) + 0.33


def thelen_velocity(a, force, x):
    """Return the velocity in optimal lengths per second for the force of the active part (equation 6)."""
    isometric = a * fl(x)
    b = isometric + force / AF if force <= isometric else (2 + 2 / AF) * (isometric * FLEN - force) / (FLEN - 1)
    return (0.25 + 0.75 * a) * VMAX * (force - isometric) / b


def damped_velocity(a, force, x, damping):
    """Return the velocity at which Thelen's active force and the damping make the force, by a search."""
    fastest = (0.25 + 0.75 * a) * VMAX

    def active(v):  # the inverse of equation 6, by a search as well
        if v == 0.0:
            return a * fl(x)
        ends = (-AF * (1 - 1e-13), 1.0) if v < 0.0 else (1.0, FLEN * (1 - 1e-13))
        return brentq(lambda f: thelen_velocity(a, f, x) - v, *(a * fl(x) * y for y in ends), xtol=1e-16, rtol=1e-15)

    return brentq(lambda v: active(v) + damping * v / VMAX - force, -99 * fastest, 99 * fastest, xtol=1e-13)


def fields(**more):
    return {"excitation": 0.6, "strength": F0, "fibre": L0, "tendon": LT, "pennation": AP} | more


def hanging(length=0.3, mass=None, **more) -> fmb.Model:
    """Return a muscle along x from the ground to a body at a distance, held or free on a rail."""
    along = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
    rail = [fmb.Prismatic("rail", markers=("ground.x", "b.x"))]
    held = [] if mass else [fmb.Drive("hold", joint="rail", displacement=length)]
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": along}),
            fmb.RigidBody("b", mass=mass or 1.0, inertia=(1, 1, 1), at=(length, 0, 0), markers={"x": along}),
        ],
        joints=[*rail, *held],
        forces=[fmb.Muscle("m", through=("ground.x", "b.x"), **fields(**more))],
        sensors=[
            fmb.State("a", of="m", state="activation"),
            fmb.State("l", of="m", state="fibre length"),
            fmb.JointCoordinate("x", joint="rail"),
            fmb.ForceOf("force", force="m"),
            fmb.Energy("energy"),
        ],
    )


def reference(a, fibre, length, u, damping):
    """Return the rates of activation and fibre, and the force of the tendon."""
    along = np.sqrt(fibre**2 - (L0 * np.sin(AP)) ** 2)
    force = ft((length - along - LT) / LT)
    net, x = force * fibre / along - fpe(fibre / L0), fibre / L0
    v = thelen_velocity(a, net, x) if damping == 0.0 else damped_velocity(a, net, x, damping)
    scale = 0.5 + 1.5 * a
    return (u - a) / (0.015 * scale) if u > a else (u - a) * scale / 0.05, L0 * v, F0 * force


@pytest.mark.parametrize("excitation", [0.05, 0.5, 1.0])
def test_isometric_steady_state(excitation):
    """At rest: a = u, and tendon force = (a f_l + f_PE) cos alpha, for short, optimal and long fibres."""
    for length in (0.27, 0.3, 0.34, 0.38):
        model = hanging(length, excitation=excitation)
        final = fmb.statics(model.changed("m", activation=0.3))
        fibre, along = final["l"][-1], np.sqrt(final["l"][-1] ** 2 - (L0 * np.sin(AP)) ** 2)
        expected = F0 * (excitation * fl(fibre / L0) + fpe(fibre / L0)) * along / fibre
        assert final["a"][-1] == pytest.approx(excitation, abs=1e-9)
        assert -final["force"][-1, 0] == pytest.approx(expected, rel=1e-6)
        assert F0 * ft((length - along - LT) / LT) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_a_twitch_follows_thelens_equations(damping):
    """A burst of excitation on a way of given length that changes, against the equations of the paper by scipy."""
    burst = fmb.table([0.0, 0.05, 0.06, 0.2, 0.21, 0.4], [0.1, 0.1, 0.9, 0.9, 0.2, 0.2], kind="linear")
    model = hanging(0.3, excitation=burst, damping=damping)
    model = model.changed("hold", displacement=fmb.expression("0.3 - 0.01*sin(9*t)"))
    solution = fmb.simulate(model, t_end=0.4, integrator=fmb.Implicit(rtol=1e-9), samples=81)

    def rates(t, x):
        u = np.interp(t, [0.0, 0.05, 0.06, 0.2, 0.21, 0.4], [0.1, 0.1, 0.9, 0.9, 0.2, 0.2])
        return reference(*x, 0.3 - 0.01 * np.sin(9 * t), u, damping)[:2]

    start = (solution["a"][0], solution["l"][0])
    exact = solve_ivp(rates, (0, 0.4), start, "LSODA", solution.t, rtol=1e-9, atol=1e-12, max_step=5e-3).y
    force = [reference(*x, 0.3 - 0.01 * np.sin(9 * t), 0.5, 0.0)[2] for t, x in zip(solution.t, exact.T)]
    np.testing.assert_allclose(solution["a"], exact[0], atol=2e-6)
    np.testing.assert_allclose(solution["l"], exact[1], atol=2e-7)
    np.testing.assert_allclose(-solution["force"][:, 0], force, atol=2e-5 * F0)


def test_force_and_velocity_of_the_curves():
    """The closed root of force and velocity is the published equation without damping, a searched root with it."""
    for a in (0.05, 0.4, 1.0):
        for x in (0.6, 1.0, 1.4):
            isometric, fastest = a * fl(x), (0.25 + 0.75 * a) * VMAX
            for share in (-0.2, 0.0, 0.3, 0.99, 1.0, 1.01, 1.3, 1.39):
                force = share * isometric
                z = contraction(force, isometric, 0.0, FLEN)
                assert fastest * z == pytest.approx(thelen_velocity(a, force, x), rel=1e-9, abs=1e-12)
            for share in (0.0, 0.7, 1.2, 2.0):
                z = contraction(share * isometric, isometric, 0.1 * fastest / VMAX, FLEN)
                assert fastest * z == pytest.approx(damped_velocity(a, share * isometric, x, 0.1), rel=1e-8, abs=1e-10)


def test_energy_balances():
    """Kinetic and stored energy change by the work of the active fibre less what its damping takes."""
    model = hanging(0.31, mass=3000.0, excitation=fmb.expression("0.5 + 0.4*sin(12*t)"), activation=0.2)
    solution = fmb.simulate(model, t_end=0.3, integrator=fmb.Implicit(rtol=1e-9), samples=31)
    balance = solution["energy"] - solution.phases[0].works @ (1.0, 1.0, -1.0)
    moved_energy = np.ptp(solution["energy"])
    assert moved_energy > 1.0
    np.testing.assert_allclose(balance, balance[0], atol=1e-6 * moved_energy)


# ------------------------------------------------------------------------------------------------ ways over cylinders


def leg(P, S, radius, tilt=None, **more) -> fmb.Model:
    """Return a muscle from the ground around the z-axis of a marker on a bone, to a second body."""
    given = fields(tendon=0.5, fibre=1.0, tendon_strain=0.5, pennation=0.1, strength=40.0) | more
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"o": P}),
            fmb.RigidBody("bone", mass=1.0, inertia=(1, 1, 1), markers={"knee": fmb.Pose((0, 0, 0), tilt)}),
            fmb.RigidBody("shank", mass=1.0, inertia=(1, 1, 1), at=S, markers={"m": (0, 0, 0)}),
        ],
        forces=[fmb.Muscle("m", through=("ground.o", "bone.knee", "shank.m"), radii=(0, radius, 0), **given)],
    )


def shortest(P, S, radius, turn):
    """Return the length of the shortest way from P to S over the cylinder that turns by about `turn`, by a search."""
    P, S = np.array(P, float), np.array(S, float)
    first = np.arctan2(P[1], P[0])
    share = np.linspace(0.0, 1.0, 5)

    def length(y):
        angles, heights = y[:2], y[2:]
        on = [np.array([radius * np.cos(a), radius * np.sin(a), z]) for a, z in zip(angles, heights)]
        arc = np.hypot(radius * (angles[1] - angles[0]), heights[1] - heights[0])
        return np.linalg.norm(P - on[0]) + arc + np.linalg.norm(S - on[1])

    # the length is stationary, not least: a contact that is moved back makes a line through the cylinder
    one, two = (np.sign(turn) * np.arccos(radius / np.hypot(*x[:2])) for x in (P, S))
    start = np.array([first + one, first + turn - two, *np.interp([0.3, 0.7], share, P[2] + share * (S[2] - P[2]))])
    return least_squares(lambda y: approx_slopes(length, y), start, xtol=1e-15, ftol=1e-15, gtol=1e-15).x, length


def approx_slopes(f, y):
    """Return the gradient by complex-free central differences of fourth order."""
    out = np.empty(len(y))
    for k in range(len(y)):
        e = 1e-3 * (np.arange(len(y)) == k)
        out[k] = (8 * (f(y + e) - f(y - e)) - (f(y + 2 * e) - f(y - 2 * e))) / 12e-3
    return out


WAYS = {
    "a quarter": ((0.8, -0.3, 0.2), (-0.5, 0.6, 0.7), 0.4, 2.6),
    "half a turn and more": ((0.5, 0.1, 0.0), (0.1, -0.7, -0.9), 0.4, 4.7),
    "the other way": ((-0.6, 0.5, 0.3), (0.9, -0.2, 0.1), -0.3, -2.7),
}


@pytest.mark.parametrize("name", WAYS)
def test_the_way_is_a_geodesic(name):
    """Its length is stationary among ways of two straight lines and a helix, found by a search over both contacts."""
    P, S, radius, turn = WAYS[name]
    angle = np.sign(turn) * ((np.sign(turn) * (np.arctan2(S[1], S[0]) - np.arctan2(P[1], P[0]))) % (2 * np.pi))
    y, length = shortest(P, S, abs(radius), angle)
    assert np.abs(approx_slopes(length, y)).max() < 1e-8
    model = leg(P, S, radius)
    found = described_length(model.forces[0], Described(model))
    assert found == pytest.approx(length(y), rel=1e-9)
    assert found > np.linalg.norm(np.subtract(P, S)) * 1.007


def test_a_way_that_does_not_touch_is_straight():
    model = leg((0.8, -0.3, 0.2), (0.7, 0.6, 0.7), 0.4)
    assert described_length(model.forces[0], Described(model)) == pytest.approx(np.linalg.norm((0.1, -0.9, -0.5)))


SCENES = {
    "around": leg((0.8, -0.3, 0.2), (-0.5, 0.6, 0.7), 0.4, tilt=(0.2, -0.1, 0.3)),
    "around, far": leg((0.5, 0.1, 0.0), (0.1, -0.7, -0.9), 0.4),
    "the other way": leg((-0.6, 0.5, 0.3), (0.9, -0.2, 0.1), -0.3, tilt=(0.1, 0.2, -0.3)),
    "beside": leg((0.8, -0.3, 0.2), (0.7, 0.9, 0.7), 0.4),
    "through": leg((0.8, -0.3, 0.2), (-0.7, 0.9, 0.7), 0.0),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("fibre", [1.3, 0.8])
def test_tangent(name, fibre):
    """The iteration matrix is the derivative of the residual by places, velocities and states."""
    system = compile(SCENES[name].changed("m", fibre_length=fibre, activation=0.4))
    assert_tangent(system, system.state())


def test_the_last_body_may_bend(rng):
    """The same where the way ends on a reduced beam, bends over a plate's marker, and begins on a cable."""
    beam_, tip = body("floating", "a", rng)
    bone = fmb.RigidBody("bone", mass=1.0, inertia=(1, 1, 1), at=(3.0, 0, 0), markers={"knee": (0, 0, 0)})
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"o": (6.0, 0.6, 0.2)}), beam_, bone],
        forces=[
            fmb.Muscle(
                "m",
                through=("ground.o", "bone.knee", tip),
                radii=(0, -0.4, 0),
                **fields(tendon=4.0, fibre=1.5, tendon_strain=0.5, strength=40.0, fibre_length=1.4, activation=0.3),
            )
        ],
    )
    system = compile(model)
    assert_tangent(system, system.state())


@pytest.mark.parametrize("name", SCENES)
def test_action_is_reaction_and_the_start_is_at_rest(name):
    system = compile(SCENES[name])
    state, work = system.state(), system.workspace()
    evaluate(system.program, state, work)
    count = len(system.marker_index)  # the markers of states follow
    force, moment, r = (work.markers[:count][x] for x in ("wrench", "wrench", "r"))
    force, moment = force[:, :3], moment[:, 3:]
    assert np.abs(force).max() > 1.0
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose((moment + np.cross(r, force)).sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(work.markers[count:]["wrench"], 0.0, atol=1e-9)


def test_the_way_winds_over_full_turns():
    """An arm turns by a turn and a half about the axis of a drum: the way grows by the radius times the angle."""
    radius, arm, turn = 0.05, 0.3, 3.0 * np.pi
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"axis": (0, 0, 0), "o": (0.0, -0.4, 0.1)}),
            fmb.RigidBody("arm", mass=1.0, inertia=(1, 1, 1), markers={"axis": (0, 0, 0), "end": (arm, 0, 0)}),
        ],
        joints=[
            fmb.Revolute("turn", markers=("ground.axis", "arm.axis")),
            fmb.Drive("drive", joint="turn", angle=fmb.table([0, 1, 9], [0, turn, turn], kind="linear")),
        ],
        forces=[
            fmb.Muscle(
                "m",
                through=("ground.o", "ground.axis", "arm.end"),
                radii=(0, radius, 0),
                **fields(tendon=0.35, tendon_strain=1.0, damping=0.0),
            )
        ],
        sensors=[fmb.State("l", of="m", state="fibre length")],
    )
    start = 0.5 * np.pi - np.arccos(radius / 0.4) - np.arccos(radius / arm)
    plane = np.sqrt(0.4**2 - radius**2) + np.sqrt(arm**2 - radius**2) + radius * (start + turn)
    solution = fmb.simulate(model, t_end=9.0, integrator=fmb.Implicit(rtol=1e-8), samples=10)
    assert solution.t[-1] == 9.0
    expected = model.forces[0].resting_fibre(np.hypot(plane, 0.1), 0.6)
    assert solution["l"][-1] == pytest.approx(expected, rel=1e-6)


def test_energy_balances_where_the_way_leaves_its_cylinder():
    """A shank swings under its weight and a muscle over the knee, which it touches and leaves again."""
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[
            fmb.Ground(markers={"knee": (0, 0, 0), "origin": (0.03, 0.4, 0.0)}),
            fmb.RigidBody(
                "shank",
                mass=3.0,
                inertia=(0.03, 0.03, 0.03),
                at=(0.2, 0, 0),
                markers={"knee": (-0.2, 0, 0), "tibia": (-0.13, 0.02, 0.01)},
            ),
        ],
        joints=[fmb.Revolute("hinge", markers=("ground.knee", "shank.knee"))],
        forces=[
            fmb.Muscle(
                "m",
                through=("ground.origin", "ground.knee", "shank.tibia"),
                radii=(0, -0.025, 0),
                excitation=0.03,
                strength=300.0,
                fibre=0.1,
                tendon=0.28,
            )
        ],
        sensors=[fmb.Energy("energy"), fmb.JointCoordinate("angle", joint="hinge")],
    )
    solution = fmb.simulate(model, t_end=1.0, integrator=fmb.Implicit(rtol=1e-9), samples=101)
    balance = solution["energy"] - solution.phases[0].works @ (1.0, 1.0, -1.0)
    np.testing.assert_allclose(balance, balance[0], atol=1e-6 * np.ptp(solution["energy"]))


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"through": ("ground.o",)}, "2 to 12 different names"),
        ({"radii": (0, 0.1)}, "a number for each marker"),
        ({"radii": (0.1, 0, 0)}, "cylinders between markers"),
        ({"radii": (0, 0.9, 0)}, "a place outside"),
        ({"tendon": 9.0}, "taut"),
        ({"strength": -1.0}, "strength"),
        ({"lengthening": 1.0}, "a number above 1"),
        ({"activation": 1.5}, "from 0 to 1"),
        ({"fibre_length": 0.01}, "more than"),
        ({"pennation": 2.0}, "below 1.4 rad"),
    ],
)
def test_bad_input_is_told(changes, told):
    with pytest.raises(ModelError, match=told):
        compile(leg((0.8, 0.3, 0.2), (-0.5, 0.3, 0.7), 0.3).changed("m", **changes))


def test_a_way_through_a_cylinder_from_behind_is_told():
    with pytest.raises(ModelError, match="cuts the cylinder"):
        compile(leg((0.5, -0.3, 0.2), (0.5, 0.35, 0.7), -0.55))
