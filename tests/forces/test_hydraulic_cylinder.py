"""A cylinder with oil and valve against closed forms (Merritt 1967) and a separate integration of its equations."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import flexmb as fmb
from flexmb.errors import IntegrationError, ModelError

MASS, A, B, STROKE, DEAD = 200.0, 2e-3, 1.2e-3, 0.5, 2e-4
SUPPLY, TANK, BULK, FLOW, DROP = 2e7, 2e5, 1.2e9, 5e-4, 3.5e6
DATA = {
    "areas": (A, B), "stroke": STROKE, "dead_volume": DEAD, "supply": SUPPLY, "tank": TANK, "rated_flow": FLOW,
    "rated_drop": DROP, "bulk": BULK,
}  # fmt: skip
AXIS = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
HALF = 0.2  # m, extension at the start


def press(valve, markers=False, **fields) -> fmb.Model:
    """Return a mass on a rail along x that the cylinder drives, on the rail or between markers."""
    place = {"markers": ("ground.foot", "b.center"), "retracted": 0.7} if markers else {"joint": "rail", "retracted": 0}
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": AXIS, "foot": (-0.7, 0, 0)}),
            fmb.RigidBody("b", mass=MASS, inertia=(1, 1, 1), at=(HALF, 0, 0), markers={"x": AXIS}),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "b.x"))],
        forces=[fmb.HydraulicCylinder("ram", valve=valve, **(DATA | place | fields))],
        sensors=[
            fmb.State("a", of="ram", state="pressure a"),
            fmb.State("b", of="ram", state="pressure b"),
            fmb.JointCoordinate("x", joint="rail"),
            fmb.Energy("energy"),
        ],
    )


def published(valve, pressures, leakage, t_end, at):
    """Return x, x', p_a, p_b: continuity of both chambers, flow through sharp edges, Newton's law."""
    c = FLOW / np.sqrt(DROP)

    def rates(t, y):
        x, v, a, b = y
        u = valve(t)
        root = lambda d: np.sign(d) * np.sqrt(abs(d))  # noqa: E731
        q_a = c * u * (root(SUPPLY - a) if u > 0 else root(a - TANK))
        q_b = -c * u * (root(b - TANK) if u > 0 else root(SUPPLY - b))
        leak = leakage * (a - b)
        return (
            v,
            (A * a - B * b) / MASS,
            BULK / (DEAD + A * x) * (q_a - leak - A * v),
            BULK / (DEAD + B * (STROKE - x)) * (q_b + leak + B * v),
        )

    found = solve_ivp(rates, (0, t_end), (HALF, 0, *pressures), method="Radau", rtol=1e-9, atol=1e-9, t_eval=at)
    assert found.success
    return found.y


@pytest.mark.parametrize("markers", [False, True])
def test_against_the_published_equations(markers):
    """Out and in again, with a leakage: extension to 1e-6 m, pressures to 1e-4 of the supply; the energies balance."""
    pressures, leakage = (6e6, 1e7), 2e-12
    model = press(fmb.expression("0.6*sin(8*t)"), markers, pressures=pressures, leakage=leakage, transition=1e3)
    solution = fmb.simulate(model, 0.8, integrator=fmb.Implicit(rtol=1e-8), samples=81)
    x, _, a, b = published(lambda t: 0.6 * np.sin(8 * t), pressures, leakage, 0.8, solution.t)
    assert np.ptp(x) > 0.05
    assert solution["x"] == pytest.approx(x, abs=1e-6)
    assert solution["a"] == pytest.approx(a, abs=1e-4 * SUPPLY)
    assert solution["b"] == pytest.approx(b, abs=1e-4 * SUPPLY)
    balance = solution["energy"] - solution.phases[0].works @ (1.0, 1.0, -1.0)
    assert balance == pytest.approx(np.full(81, balance[0]), abs=1e-4 * np.ptp(solution.phases[0].works))


def test_shut_valve_is_a_spring():
    """The frequency of the mass on the oil is sqrt(E (A^2/V_a + B^2/V_b) / m)."""
    values = fmb.linearize(press(0.0, pressures=(6e6, 1e7))).eigenvalues
    spring = BULK * (A**2 / (DEAD + A * HALF) + B**2 / (DEAD + B * (STROKE - HALF)))
    assert values.imag.max() == pytest.approx(np.sqrt(spring / MASS), rel=1e-9)


def loaded(force, **fields) -> fmb.Model:
    """Return the mass on the rail, pushed against the cylinder by a force, N."""
    model = press(fields.pop("valve", 0.0), fields.pop("markers", False), **{"pressures": (6e6, 1e7), **fields})
    return replace(model, forces=[*model.forces, fmb.PointLoad("push", marker="b.center", force=(-force, 0, 0))])


@pytest.mark.parametrize("markers", [False, True])
@pytest.mark.parametrize("leakage", [0.0, 1e-12])
def test_oil_behind_a_shut_valve_carries(markers, leakage):
    """The oil is pressed together, p = p_0 + E ln(V_0/V); a leakage makes one room of both chambers."""
    rooms = lambda x: np.array([DEAD + A * x, DEAD + B * (STROKE - x)])  # noqa: E731
    first, load = np.array([6e6, 1e7]), 2e4

    def pressures(x):
        if leakage:
            return np.full(2, BULK * np.log(np.sum(rooms(HALF) * np.exp(first / BULK)) / np.sum(rooms(x))))
        return first - BULK * np.log(rooms(x) / rooms(HALF))

    x = brentq(lambda x: pressures(x) @ (A, -B) - load, 0.1, 0.4, xtol=1e-14)
    solution = fmb.statics(loaded(load, markers=markers, leakage=leakage))
    assert solution["x"][-1] == pytest.approx(x, abs=1e-9)
    assert (solution["a"][-1], solution["b"][-1]) == pytest.approx(tuple(pressures(x)), rel=1e-6)


def test_a_run_from_the_equilibrium_on_oil_stays_there():
    """The cylinder itself takes the pressures over; and the equilibrium from that equilibrium is the same."""
    model = loaded(2e4)
    still = fmb.statics(model)
    run = fmb.simulate(model, 0.05, start="equilibrium", samples=6)
    assert run["x"] == pytest.approx(np.full(6, still["x"][-1]), abs=1e-8)
    assert fmb.statics(model, state=still)["x"][-1] == pytest.approx(still["x"][-1], abs=1e-9)


def test_pressures_that_are_held_and_do_not_balance_are_told():
    """No words about roots and logarithms, but what a cylinder needs."""
    with pytest.raises(
        IntegrationError, match=r"'ram'.*beyond its end.*pressures do not hold the loads.*BiStop"
    ) as told:
        fmb.statics(loaded(2e4), hold_states=True)
    assert "logarithm" not in str(told.value)


def test_poles_of_a_position_loop():
    """A valve that follows the position, u = u_0 - g (x - x_0), with derivatives of the published equations by hand."""
    gain, u, c = 15.0, 0.05, FLOW / np.sqrt(DROP)
    a, b = 1.1e7, 1e7
    root_a, root_b = np.sqrt(SUPPLY - a), np.sqrt(b - TANK)
    soft_a, soft_b = BULK / (DEAD + A * HALF), BULK / (DEAD + B * (STROKE - HALF))
    by_x_a = -soft_a * c * u * root_a * A / (DEAD + A * HALF)
    by_x_b = -soft_b * c * u * root_b * B / (DEAD + B * (STROKE - HALF))
    exact = np.linalg.eigvals(
        np.array(
            [
                [0, 1, 0, 0],
                [0, 0, A / MASS, -B / MASS],
                [by_x_a - gain * soft_a * c * root_a, -soft_a * A, -soft_a * c * u / (2 * root_a), 0],
                [by_x_b + gain * soft_b * c * root_b, soft_b * B, 0, -soft_b * c * u / (2 * root_b)],
            ]
        )
    )
    valve = fmb.formula("u - g*(x - h)", over={"x": "x"}, u=u, g=gain, h=HALF)
    values = fmb.linearize(press(valve, pressures=(a, b), transition=1.0)).eigenvalues
    both = np.concatenate([values, values[values.imag > 0.0].conj()])
    assert np.sort_complex(both) == pytest.approx(np.sort_complex(exact), rel=1e-7)


def test_steady_speed():
    """Without a load p_a A = p_b B, and both edges pass what the piston sweeps: v = u c sqrt(...) / ..."""
    u = 0.3
    solution = fmb.simulate(press(u, pressures=(6e6, 1e7), stroke=5.0, transition=1e3), 2.0, samples=21)
    # Q_a = c u sqrt(S - a) = A v, Q_b = c u sqrt(b - T) = B v, A a = B b
    c = u * FLOW / np.sqrt(DROP)
    speed = c * np.sqrt((A * SUPPLY - B * TANK) / (A**3 + B**3))
    assert np.diff(solution["x"])[-1] / 0.1 == pytest.approx(speed, rel=1e-4)


def test_beyond_its_end():
    """Where a chamber has no volume any more the run ends with a message, not with numbers."""
    with pytest.raises(IntegrationError, match="not finite"):
        fmb.simulate(press(1.0, pressures=(6e6, 1e7)), 5.0, samples=21)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"areas": (1e-3,)}, "areas = "),
        ({"areas": (1e-3, -1e-3)}, "two numbers, of chamber a and of chamber b, positive"),
        ({"pressures": 1e5}, "pressures = 100000.0"),
        ({"tank": 3e7}, "tank = 30000000.0"),
        ({"bulk": 0.0}, "bulk = 0"),
        ({"leakage": -1.0}, "leakage = -1"),
        ({"retracted": "far"}, "retracted = 'far'"),
        ({"valve": "open"}, "valve = 'open'"),
        ({"joint": None}, "neither markers nor joint"),
    ],
)
def test_messages(change, words):
    with pytest.raises(ModelError, match=words):
        fmb.HydraulicCylinder("ram", **{"joint": "rail", "valve": 0.0, **DATA, **change})


def test_out_of_the_cylinder():
    with pytest.raises(ModelError, match=r"extended by 0.8 m as described"):
        fmb.linearize(press(0.0).changed("ram", retracted=-0.6))
