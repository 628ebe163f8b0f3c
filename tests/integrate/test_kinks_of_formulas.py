"""Kinks and jumps of formulas and tables of measurements: steps end there. Closed forms of a cart on a rail."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.system import assemble

MASS, STIFF, WIDTH = 2.0, 5000.0, 5e-4
ALONG_X = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
PLACE = fmb.JointCoordinate("place", joint="rail")
X, V = fmb.measured(PLACE), fmb.measured(PLACE, rate=True)
ALPHA, IMPLICIT, IDA = fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.IDA()
EXPLICIT, RK45 = fmb.Explicit(rtol=1e-9), fmb.Explicit(rtol=1e-9, method="RK45")
EVERY = [ALPHA, IMPLICIT, EXPLICIT, RK45, IDA]


def rail(effort, x=0.0, v=0.0, **more) -> fmb.Model:
    """Return a cart at x with the speed v, driven by an actuator."""
    marks, at, velocity = {"x": ALONG_X}, (x, 0, 0), (v, 0, 0)
    cart = fmb.RigidBody("cart", mass=MASS, inertia=(1, 1, 1), markers=marks, at=at, velocity=velocity)
    return fmb.Model(
        bodies=[fmb.Ground(markers={"x": ALONG_X}), cart],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("motor", joint="rail", effort=effort)],
        sensors=[fmb.JointCoordinate("x", joint="rail"), fmb.Velocity("v", marker="cart.x")],
        **more,
    )


def formula(text: str, **parameters) -> fmb.Formula:
    return fmb.formula(text, over={"x": X, "v": V}, **parameters)


def rebound():
    """A spring on one side: the cart comes back with its speed."""
    return rail(formula("-k*max(x, 0)", k=STIFF), -0.3, 1.0), 1.0, -1.0


def triangle():
    """A push of 1 ms with three corners: work and kinetic energy."""
    push = formula("f*max(0, 1 - abs(x - 0.5)/b)", f=2000.0, b=WIDTH)
    return rail(push, 0.0, 1.0), 1.0, np.sqrt(1.0 + 2.0 * 2000.0 * WIDTH / MASS)


def rectangle():
    """A push of 1 ms with two jumps."""
    push = formula("where(x > 0.5 - b and x < 0.5 + b, f, 0)", f=1000.0, b=WIDTH)
    return rail(push, 0.0, 1.0), 1.0, np.sqrt(1.0 + 4.0 * 1000.0 * WIDTH / MASS)


def polygon():
    """A characteristic of straight pieces: the cart comes back with its speed."""
    points = [-1.0, 0.0, 0.02, 1.0], [0.0, 0.0, -8.0, -8.0 - 4000.0 * 0.98]
    return rail(fmb.table(*points, of=PLACE, kind="linear"), -0.3, 1.0), 1.0, -1.0


def brake():
    """Damping that acts in one direction, under a constant force: exponential, then a straight line."""
    g, r = 2.0 / MASS, 30.0 / MASS
    turns = np.log(1.0 + r / g) / r
    return rail(formula("-2 - 30*max(v, 0)"), 0.0, 1.0), 1.0, -g * (1.0 - turns)


def friction():
    """Dry friction on an oscillator: half waves about +-F/k; this one ends in the middle of the third."""
    k, f = 200.0, 3.0
    w = np.sqrt(k / MASS)
    return rail(formula("-k*x - f*sign(v)", k=k, f=f), 0.1, 0.0), 2.5 * np.pi / w, -(0.1 - 5.0 * f / k) * w


OFF = {  # of speeds: allowed, in the order of EVERY
    rebound: (4e-5, 5e-6, 1e-10, 1e-8, 2e-4),
    triangle: (3e-5, 1e-7, 1e-10, 1e-8, 5e-5),
    rectangle: (3e-5, 2e-5, 1e-8, 2e-8, 5e-5),
    polygon: (4e-5, 3e-6, 1e-10, 1e-8, 5e-5),
    brake: (2e-4, 2e-5, 1e-10, 1e-8, 2e-6),
    friction: (2e-5, 1e-6, 1e-9, 1e-8, 2e-5),
}


@pytest.mark.parametrize(("case", "number"), [(case, n) for case in OFF for n in range(len(EVERY))])
def test_the_speed_behind_kinks_is_that_of_the_closed_form(case, number):
    model, t_end, speed = case()
    solution = fmb.simulate(model, t_end, samples=11, integrator=EVERY[number])
    assert solution["v"][-1, 0] == pytest.approx(speed, abs=OFF[case][number])


@pytest.mark.parametrize("integrator", [IMPLICIT, EXPLICIT], ids=repr)
def test_a_kink_is_as_good_as_an_event_made_by_hand(integrator):
    """The three corners of the push as three events that change the force."""
    model, t_end, speed = triangle()
    rising, falling = formula("f*(1 + (x - 0.5)/b)", f=2e3, b=WIDTH), formula("f*(1 - (x - 0.5)/b)", f=2e3, b=WIDTH)
    efforts = {0.5 - WIDTH: rising, 0.5: falling, 0.5 + WIDTH: 0.0}
    events = [
        fmb.Event(f"corner {k}", sensor="x", above=x, then=fmb.Change("motor", effort=effort))
        for k, (x, effort) in enumerate(efforts.items())
    ]
    by_hand = replace(model, forces=[replace(model.forces[0], effort=0.0)], events=events)
    found, other = (
        abs(fmb.simulate(one, t_end, samples=11, integrator=integrator)["v"][-1, 0] - speed) for one in (model, by_hand)
    )
    assert found <= 10.0 * other + 1e-11


def test_a_periodic_table_is_located_in_every_period():
    """Force over place in triangles, period 0.1: after whole periods the potential is that of the start."""
    teeth = fmb.table([0.0, 0.05, 0.1], [0.0, 40.0, 0.0], of=PLACE, kind="linear", periodic=True)
    solution = fmb.simulate(rail(teeth - 20.0, 0.0, 3.0), 1.0, samples=501, integrator=EXPLICIT)
    x, v = solution["x"], solution["v"][:, 0]
    in_one = np.mod(x, 0.1)
    work = np.where(in_one < 0.05, 400.0 * in_one**2, 2.0 - 400.0 * (0.1 - in_one) ** 2) - 20.0 * in_one
    assert x[-1] > 2.9
    assert 0.5 * MASS * v**2 - work == pytest.approx(np.full(501, 9.0), abs=1e-9)


def test_only_what_acts_and_can_change_is_located():
    """One corner used by two forces is one; those of sensors alone, and of held values, are none."""
    corner = formula("max(x, 0)")
    watched = fmb.SignalValue("watched", of=formula("abs(x)"))
    held = fmb.formula("abs(y)", over={"y": fmb.Sampled(X, period=0.1)})
    model = rail(corner + held)
    more = fmb.Actuator("second", joint="rail", effort=formula("2*max(x, 0)"))
    model = replace(model, forces=[*model.forces, more], sensors=[*model.sensors, watched])
    system, _ = assemble(model)
    assert len(system.switch_owners) == 1
    assert not system.unlocated
    assert not len(assemble(rail(formula("-3*x - v + sin(x)")))[0].switch_owners)


def test_what_is_not_located_is_noted():
    inside = fmb.Function(X, function=lambda t, x: np.where(np.real(x[0]) > 0.0, -3.0, 3.0) + 0.0 * x[0])
    solution = fmb.simulate(rail(inside, 0.3), 0.01, samples=2)
    assert any("Force 'motor': steps do not end where its Function" in note for note in solution.statistics["notes"])
    for law, jumps in (("where(a[0] > 2, -1, 1)", True), ("max(a[0], 2)", False)):
        following = fmb.formula(law, over={"a": fmb.Acceleration("a", marker="cart.x")})
        notes = fmb.simulate(rail(following), 0.01, samples=2).statistics.get("notes", [])
        told = [note for note in notes if "Force 'motor': steps do not end where it jumps with an acceleration" in note]
        assert len(told) == jumps
        corners = [
            note for note in notes if "Force 'motor': steps do not end at its corners over an acceleration" in note
        ]
        assert len(corners) == (not jumps)
    many = [formula(" + ".join(f"max(x - {k + n}, 0)" for k in range(0, 201, 3) if k + n < 201)) for n in range(3)]
    solution = fmb.simulate(rail(many[0] + many[1] + many[2], -0.3), 0.01, samples=2)
    assert any("have 201 kinks and jumps; steps end at the first 200" in note for note in solution.statistics["notes"])


@pytest.mark.parametrize("integrator", EVERY, ids=lambda one: type(one).__name__)
def test_a_table_over_two_signals_is_located(integrator):
    """A ridge of 1 ms over place, half as high at the second signal: its work is kinetic energy."""
    places = [0.0, 0.5 - WIDTH, 0.5, 0.5 + WIDTH, 2.0]
    ridge = [[0.0, 0.0], [0.0, 0.0], [0.0, 4000.0], [0.0, 0.0], [0.0, 0.0]]
    effort = fmb.table2(places, [0.0, 1.0], ridge, of=(PLACE, 0.5), kind="linear")
    run = fmb.simulate(rail(effort, 0.0, 1.0), 1.0, samples=11, integrator=integrator)
    assert run["v"][-1, 0] == pytest.approx(np.sqrt(1.0 + 2.0 * 2000.0 * WIDTH / MASS), abs=1e-4)


@pytest.mark.parametrize(("integrator", "t_end"), [(ALPHA, 0.7), (IMPLICIT, 0.503)], ids=["alpha", "implicit"])
def test_a_sign_that_chatters_at_rest_is_told(integrator, t_end):
    """Friction as a formula stops a cart after 0.5 s, and holds nothing then; smooth friction is not told of."""
    for law, chatters in (("-4*sign(v)", True), ("-4*tanh(v/0.001)", False)):
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            run = fmb.simulate(rail(formula(law), 0.0, 1.0), t_end, samples=3, integrator=integrator)
        sentences = [str(one.message) for one in found if "chatters" in str(one.message)]
        assert bool(sentences) == chatters
        assert run["x"][-1] == pytest.approx(0.25, abs=1e-3)  # v^2 m / (2 F)
        if chatters:
            assert sentences[0].startswith("Force 'motor': its formula has passed one jump or kink ")


@pytest.mark.parametrize("integrator", [fmb.Explicit(), fmb.Implicit(rtol=1e-4)], ids=lambda one: type(one).__name__)
def test_a_sign_that_a_swing_passes_does_not_chatter(integrator):
    """Weak friction F of a cart on a spring k takes 4 F / k of the amplitude in a period."""
    periods, force, stiffness = 60, 0.2, 400.0 * MASS
    effort = formula(f"-{stiffness}*x - {force}*sign(v)")
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        run = fmb.simulate(rail(effort, 1.0), periods * np.pi / 10.0, samples=2, integrator=integrator)
    assert not [one for one in found if "chatters" in str(one.message)]
    assert run["x"][-1] == pytest.approx(1.0 - 4.0 * periods * force / stiffness, abs=0.02)


def test_measured_quantities_are_compared_in_formulas_but_not_in_equations():
    with pytest.raises(ModelError, match="no derivative everywhere"):
        replace(
            rail(0.0), joints=[*rail(0.0).joints, fmb.Constraint("c", equation="where(x > 0, x, 0)", over={"x": "x"})]
        )
    assert len(assemble(rail(formula("where(x > 0, 1, 2)")))[0].switch_owners) == 1


def bead(force: str, x=0.0, v=1.0) -> fmb.Model:
    """Return a bead on a straight wire, an equation, with what the wire gives along it."""
    over = {"p": fmb.Position("p", marker="bead.center"), "v": fmb.Velocity("v", marker="bead.center")}
    wires = [
        fmb.Constraint("wire", over=over, equation="p[2] = 0", forces={"v[0]": force}),
        fmb.Constraint("plane", over=over, equation="p[1] = 0"),
    ]
    mass = fmb.PointMass("bead", mass=MASS, at=(x, 0, 0), velocity=(v, 0, 0))
    return fmb.Model(bodies=[fmb.Ground(), mass], joints=wires, sensors=[over["v"]], gravity=(0, 0, -9.81))


@pytest.mark.parametrize("integrator", [ALPHA, IMPLICIT, EXPLICIT, IDA], ids=lambda i: type(i).__name__)
@pytest.mark.parametrize(
    ("force", "work"),
    [
        (f"2000*max(0, 1 - abs(p[0] - 0.5)/{WIDTH})", 2000.0 * WIDTH),
        (f"where(p[0] > 0.5 - {WIDTH} and p[0] < 0.5 + {WIDTH}, 1000, 0)", 2000.0 * WIDTH),
    ],
    ids=["corners", "jumps"],
)
def test_kinks_of_the_forces_of_a_constraint_end_steps(integrator, force, work):
    """A push of 1 ms: its work is kinetic energy, from 1 m/s to 1.4142 m/s."""
    run = fmb.simulate(bead(force), 1.0, samples=11, integrator=integrator)
    assert run["v"][-1, 0] == pytest.approx(np.sqrt(1.0 + 2.0 * work / MASS), rel=1e-3)


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(step=1e-3), fmb.Implicit(step=1e-3)], ids=repr)
def test_steps_of_fixed_size_look_for_jumps_and_not_for_corners(integrator):
    """They go over corners, so these are not read; a jump still is passed over with accelerations from behind it."""
    for text, looked_for in (("-k*max(x, 0)", 0), ("-k*sign(x)", 1)):
        system, state = assemble(rail(formula(text, k=STIFF), -0.3, 1.0))
        variables = integrator.start(system, state, system.workspace(), 1.0)
        switching = getattr(variables, "switching", None) or variables.own.switching
        assert len(switching.now) == looked_for, text
        assert len(switching.kinds) == looked_for, text
    adaptive = replace(integrator, step=None).start(system, state, system.workspace(), 1.0)
    assert len((getattr(adaptive, "switching", None) or adaptive.own.switching).now) == 1
