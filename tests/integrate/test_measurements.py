"""What loops can measure beyond places and velocities: accelerations, forces, reactions, strains, modal coordinates."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from by_turns import slow
from scipy.integrate import solve_ivp

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import CompileError, ModelError
from flexmb.integrate.matrices import tangent_at
from flexmb.system import assemble
from flexmb.system.program import advance, evaluate

MASS, K = 2.0, 1.5
ALONG_X = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
FINE = fmb.Explicit(rtol=1e-9)
ACCELERATION = fmb.Acceleration("a", marker="cart.x")
PULL = fmb.ForceOf("pull", force="spring")


def rail(effort, sensors=(), forces=(), **fields) -> fmb.Model:
    """Return a cart on a rail along x, driven by an actuator."""
    ground = fmb.Ground(markers={"x": ALONG_X, "far": fmb.Pose.axes((-1.2, 0, 0), z=(1, 0, 0))})
    return fmb.Model(
        bodies=[ground, fmb.RigidBody("cart", mass=MASS, inertia=(1, 1, 1), markers={"x": ALONG_X})],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("motor", joint="rail", effort=effort), *forces],
        sensors=[fmb.JointCoordinate("x", joint="rail"), *sensors],
        **fields,
    )


FORMULATIONS = (fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Baumgarte(), fmb.Recursive())
EXPLICIT = (FINE, *(fmb.Explicit(rtol=1e-9, formulation=formulation) for formulation in FORMULATIONS))
ALL = (fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Implicit(), *EXPLICIT)
MOREAU = fmb.MoreauJean(step=2e-3)


@pytest.mark.parametrize("integrator", ALL, ids=repr)
def test_a_force_that_follows_an_acceleration_is_a_mass(integrator):
    """F = 3 - k a gives a = 3 / (m + k)."""
    model = rail(3.0 - K * fmb.measured(ACCELERATION), [ACCELERATION])
    solution = fmb.simulate(model, 1.0, samples=6, integrator=integrator)
    assert solution["a"][:, 0] == pytest.approx(np.full(6, 3.0 / (MASS + K)), rel=1e-12)
    assert solution["x"][-1] == pytest.approx(0.5 * 3.0 / (MASS + K), rel=1e-9)


@pytest.mark.parametrize("integrator", [*ALL, MOREAU], ids=repr)
def test_limits_of_such_a_force(integrator):
    """F = 3 + limit(-k a, -0.5, 0.5): at its limit, a = 2.5 / m."""
    limited = fmb.Limit(-K * fmb.measured(ACCELERATION), limits=(-0.5, 0.5))
    solution = fmb.simulate(rail(3.0 + limited, [ACCELERATION]), 0.5, samples=6, integrator=integrator)
    assert solution["a"][:, 0] == pytest.approx(np.full(6, 2.5 / MASS), rel=1e-9)


STEEP = 3.0 - 5.0 * fmb.table(
    [-10.0, 0.099, 0.101, 10.0], [0.0, 0.0, 1.0, 1.0], of=fmb.measured(ACCELERATION), kind="linear"
)
"""N, of which 5 N are taken away within 2 mm/s2: m a = F at a = 250.5 / 2502 m/s2 only, where whole steps of Newton's
method lead from -1 to 1.5 m/s2 and back."""
NEVER = fmb.formula("3 - where(a[0] > 0.1, 5, 0)", over={"a": ACCELERATION})
"""N, of which 5 N are taken away at once: m a = F nowhere."""


@pytest.mark.parametrize("bound", [2.0, 1.5])
@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), MOREAU], ids=repr)
def test_limits_of_the_whole_force(integrator, bound):
    """F = min(3 - k a, bound), beyond its limit at the first look, where a = 0."""
    wanted = 3.0 - K * fmb.measured(ACCELERATION)
    model = rail(fmb.Limit(wanted, limits=(-1.0, bound)), [ACCELERATION])
    solution = fmb.simulate(model, 0.5, samples=6, integrator=integrator)
    exact = min(3.0 / (MASS + K), bound / MASS)
    assert solution["a"][:, 0] == pytest.approx(np.full(6, exact), rel=1e-9)
    assert solution["x"][-1] == pytest.approx(0.125 * exact, rel=1e-9)


@pytest.mark.parametrize(
    "integrator", [*ALL[:4], *map(slow, ALL[4:7]), ALL[7], fmb.GeneralizedAlpha(step=0.01), MOREAU], ids=repr
)
def test_whole_steps_that_lead_to_and_fro(integrator):
    solution = fmb.simulate(rail(STEEP, [ACCELERATION]), 0.1, samples=3, integrator=integrator)
    assert solution["a"][:, 0] == pytest.approx(np.full(3, 250.5 / 2502.0), rel=1e-9)
    assert solution["x"][-1] == pytest.approx(0.005 * 250.5 / 2502.0, rel=1e-9)


@pytest.mark.parametrize("formulation", [fmb.Augmented(), *FORMULATIONS], ids=repr)
def test_formulations_find_what_there_is_and_refuse_what_is_not(formulation):
    found = fmb.accelerations(rail(STEEP), formulation=formulation)
    assert found["cart"][0] == pytest.approx(250.5 / 2502.0, rel=1e-12)
    with pytest.raises(CompileError, match="leave no unique accelerations"):
        fmb.accelerations(rail(NEVER), formulation=formulation)


@pytest.mark.parametrize("integrator", ALL, ids=repr)
def test_no_start_without_accelerations(integrator):
    with pytest.raises(fmb.FlexmbError, match="leave no unique accelerations"):
        fmb.simulate(rail(NEVER), 0.5, samples=6, integrator=integrator)


@pytest.mark.parametrize("integrator", ALL[:4], ids=repr)
def test_a_force_that_jumps_in_mid_run(integrator):
    """From 0.2 s on the whole of it acts: before, a = 3 / m."""
    late = fmb.step(1.0, at=0.2)
    run = fmb.simulate(rail(3.0 + late * (STEEP - 3.0), [ACCELERATION]), 0.4, samples=5, integrator=integrator)
    assert run["a"][[0, 1, 3, 4], 0] == pytest.approx([1.5, 1.5, 250.5 / 2502.0, 250.5 / 2502.0], rel=1e-9)
    with pytest.raises(fmb.FlexmbError, match=r"at t = 0.2 s: forces that follow accelerations leave no unique"):
        fmb.simulate(rail(3.0 + late * (NEVER - 3.0)), 0.4, samples=5, integrator=integrator)


def hanging(effort) -> fmb.Model:
    """Return a cart with a rod that hangs from it."""
    axes = fmb.Pose.axes((0, 0, 0), z=(0, 1, 0))
    ends = {name: fmb.Pose.axes((x, 0, 0), z=(0, 1, 0)) for name, x in (("top", -0.5), ("tip", 0.5))}
    pose = {"at": (0.0, 0.0, -0.5), "rotation": (0.0, np.pi / 2, 0.0)}
    cart = fmb.RigidBody("cart", mass=MASS, inertia=(1, 1, 1), markers={"x": ALONG_X, "pin": axes})
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": ALONG_X}),
            cart,
            fmb.RigidBody("rod", mass=0.7, inertia=(1e-3, 0.06, 0.06), markers=ends, **pose),
        ],
        joints=[
            fmb.Prismatic("rail", markers=("ground.x", "cart.x")),
            fmb.Revolute("pin", markers=("cart.pin", "rod.top")),
        ],
        forces=[fmb.Actuator("motor", joint="rail", effort=effort)],
        sensors=[fmb.JointCoordinate("x", joint="rail"), fmb.JointCoordinate("angle", joint="pin")],
        gravity=(0, 0, -9.81),
    )


@pytest.mark.parametrize(
    ("integrator", "bound"),
    [(fmb.GeneralizedAlpha(rtol=1e-8), 1e-5), (fmb.IDA(rtol=1e-9), 1e-6), (fmb.Implicit(rtol=1e-8), 1e-6)]
    + [(fmb.Explicit(rtol=1e-9, formulation=formulation), 1e-8) for formulation in (fmb.Augmented(), fmb.Recursive())],
    ids=repr,
)
@pytest.mark.parametrize("limit", [2.0, 100.0])
def test_accelerations_of_two_bodies_in_the_loop(integrator, bound, limit):
    """x and the angle of the rod beside the two equations by hand, with the accelerations as unknowns of the force.

    The lower limit is reached at 0.33 s.
    """
    tip = fmb.Acceleration("tip", marker="rod.tip")
    wanted = 3.0 - K * fmb.measured(ACCELERATION) + 0.4 * fmb.measured(tip)
    model = hanging(fmb.Limit(wanted, limits=(-1.0, limit)))
    found = fmb.simulate(model, 1.0, samples=6, integrator=integrator)
    m, inertia, arm, g = 0.7, 0.06, 0.5, 9.81

    def rates(t, y):
        _, c, v, w = y
        sin, cos = np.sin(c), np.cos(c)
        # at the centre of the rod x'' + arm (c'' cos c - c'^2 sin c), at its tip twice as much more than x''
        M = np.array([[MASS + m, m * arm * cos], [m * arm * cos, inertia + m * arm**2]])
        f = np.array([m * arm * w**2 * sin, -m * g * arm * sin])
        measured = np.array([-K + 0.4, 0.4 * 2.0 * arm * cos])
        constant = 3.0 - 0.4 * 2.0 * arm * w**2 * sin
        free = np.linalg.solve(M - np.outer([1.0, 0.0], measured), f + [constant, 0.0])
        if constant + measured @ free > limit:
            free = np.linalg.solve(M, f + [limit, 0.0])
        return [v, w, *free]

    solved = solve_ivp(
        rates, (0.0, 1.0), np.zeros(4), method="DOP853", rtol=1e-12, atol=1e-14, t_eval=found.t, max_step=2e-3
    )
    assert found["x"] == pytest.approx(solved.y[0], abs=bound)
    assert 0.5 * np.pi - found["angle"] == pytest.approx(solved.y[1], abs=5 * bound)


def test_frequencies_with_accelerations_and_forces_in_the_loop():
    """(m + k) x'' + d x' + c x = 0, and a force that is taken back by 40 %: poles by hand."""
    stiffness, damping = 200.0, 0.7
    spring = fmb.SpringDamper(
        "spring", markers=("ground.far", "cart.x"), stiffness=stiffness, damping=damping, length=1.2
    )
    for effort, by_hand in (
        (-K * fmb.measured(ACCELERATION), [MASS + K, damping, stiffness]),
        (-0.4 * fmb.measured(PULL), [MASS, 0.6 * damping, 0.6 * stiffness]),
        (-0.4 * fmb.measured(fmb.ForceOf("p", force="spring", axes="cart.x"), 2), [MASS, 0.6 * damping, 120.0]),
    ):
        model = rail(effort, [PULL], [spring])
        found = fmb.linearize(model, about=fmb.statics(model)).eigenvalues
        assert found[0] == pytest.approx(np.roots(by_hand)[np.argmax(np.roots(by_hand).imag)], rel=1e-9)


def test_a_force_with_states_in_the_loop():
    """A Maxwell damper c, T, of which 40 % is taken back: x' and F' = c x' - F / T; m s^2 + s / T + 0.6 c = 0."""
    stiffness, time = 200.0, 0.05
    damper = fmb.MaxwellDamper("spring", joint="rail", branches=((stiffness, time),))
    model = rail(-0.4 * fmb.measured(PULL), [PULL], [damper])
    found = np.sort(fmb.linearize(model, about=fmb.statics(model)).eigenvalues.real)
    assert found[:2] == pytest.approx(np.sort(np.roots([MASS, MASS / time, 0.6 * stiffness])), rel=1e-9)


def test_sampled_accelerations_and_reactions():
    """A sampled acceleration in its own loop: a' = (3 - k a) / m. A sampled reaction is that of the sample before."""
    following = fmb.Sampled(3.0 - K * fmb.measured(ACCELERATION), period=0.01)
    found = fmb.simulate(rail(following, [ACCELERATION]), 0.05, samples=6)["a"][:, 0]
    exact = [3.0 / MASS]
    for _ in range(5):
        exact.append((3.0 - K * exact[-1]) / MASS)
    assert found == pytest.approx(exact, rel=1e-9)
    weight = fmb.PointLoad("load", marker="cart.x", force=(0, 0, fmb.ramp(rate=-20.0)))
    carried = fmb.Reaction("carried", joint="rail")
    told = fmb.SignalValue("told", of=fmb.Sampled(fmb.measured(carried, 2), period=0.01))
    side = fmb.SignalValue("side", of=fmb.Sampled(fmb.measured(fmb.Multiplier("l", joint="rail"), 0), period=0.01))
    solution = fmb.simulate(rail(0.0, [carried, told, side], [weight], gravity=(0, 0, -9.81)), 0.05, samples=6)
    assert solution["told"] == pytest.approx(MASS * 9.81 + 20.0 * solution.t, rel=1e-9)
    assert solution["carried"][:, 2] == pytest.approx(MASS * 9.81 + 20.0 * solution.t, rel=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rail(fmb.measured(fmb.Reaction("r", joint="rail"), 2)), "algebraic loop: .*reaction of joint 'rail'"),
        (lambda: rail(fmb.Lag(fmb.measured(fmb.Multiplier("r", joint="rail")), time=1.0)), "algebraic loop"),
        (lambda: rail(fmb.measured(fmb.ForceOf("f", force="motor"))), "follows measurements itself"),
        (lambda: rail(fmb.measured(fmb.ModalCoordinate("q", body="cart"))), "no flexible coordinates"),
        (
            lambda: rail(fmb.measured(fmb.StrainGauge("q", markers=("cart.x", "cart.center")))),
            "no flexible coordinates",
        ),
        (lambda: rail(fmb.measured(ACCELERATION, rate=True)), "the rate of Sensor 'a'"),
        (lambda: rail(fmb.measured(fmb.Energy("e"))), "cannot be measured"),
    ],
)
def test_what_stays_refused(make, message):
    with pytest.raises(ModelError, match=message):
        assemble(make())


def test_a_force_that_takes_the_mass_away():
    """F = m a leaves no equation for the acceleration."""
    model = rail(3.0 + MASS * fmb.measured(ACCELERATION))
    for integrator in (fmb.Implicit(), fmb.Explicit(formulation=fmb.Recursive()), MOREAU):
        with pytest.raises(fmb.FlexmbError, match=r"'cart': .* singular: forces that follow .*F = m a leaves"):
            fmb.simulate(model, 0.1, integrator=integrator)


def test_a_mass_that_is_not_there_is_no_force_that_takes_it_away():
    """The rod without inertia about its length, beside a force that follows an acceleration."""
    made = hanging(3.0 - K * fmb.measured(ACCELERATION))
    bodies = [*made.bodies[:2], replace(made.bodies[2], inertia=(0.0, 0.06, 0.06))]
    joints = [made.joints[0], fmb.Spherical("pin", markers=("cart.pin", "rod.top"))]
    with pytest.raises(fmb.FlexmbError, match=r"'rod': .*no inertia about its x-axis"):
        fmb.simulate(replace(made, bodies=bodies, joints=joints, sensors=[]), 0.1)


def motor(target, **fields) -> fmb.Model:
    """Return the cart with a motor that drives it towards a target."""
    made = rail(0.0)
    drive = fmb.Motor("drive", joint="rail", target=target, stiffness=200.0, damping=6.0, **fields)
    return fmb.Model(bodies=made.bodies, joints=made.joints, forces=[drive], sensors=made.sensors)


def test_a_motor_whose_target_is_measured():
    """s = 0.4 x + 0.3: m x'' + 0.6 c x' + 0.6 k x = 0.3 k; without the rate of the target c acts on x' alone."""
    target, rate = 0.4 * fmb.measured("x") + 0.3, 0.4 * fmb.measured("x", rate=True)
    for told, share in ((rate, 0.6), (0.0, 1.0)):
        model = motor(target, rate=told)
        rest = fmb.statics(model)
        assert rest["x"][-1] == pytest.approx(0.5, rel=1e-9)
        by_hand = np.roots([MASS, 6.0 * share, 120.0])
        assert fmb.linearize(model, about=rest).eigenvalues[0] == pytest.approx(by_hand[0], rel=1e-9)
    held = fmb.simulate(motor(target, rate=rate, limits=(-1.0, 1.0)), 0.5, samples=6, integrator=FINE)
    assert held["x"] == pytest.approx(0.25 * held.t**2, abs=1e-9)  # at its limit of 1 N
    for wrong, message in (((target, {}), "rate = None"), ((0.3, {"rate": 0.0}), "is a function of time")):
        with pytest.raises(ModelError, match=message):
            motor(wrong[0], **wrong[1])


@cache
def beam():
    """Return a steel cantilever along x, 1 m, 20 x 30 mm, reduced with its root, tip and two stations."""
    section = fem.Section.rectangle(0.03, 0.02)
    material = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
    fe = fem.frame(points=np.linspace((0, 0, 0), (1, 0, 0), 11), section=section, material=material)
    stations = {"left": (0.3, 0, 0), "right": (0.4, 0, 0)}
    return reduction.reduce(fe, interfaces={"root": 0, "tip": 10}, modes=4, stations=stations)


def cantilever(tip_force=0.0, sensors=(), forces=()) -> fmb.Model:
    """Return the cantilever with a force along y at its tip."""
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("beam", data=beam(), damping=0.02)],
        joints=[fmb.Fixed("clamp", markers=("ground.origin", "beam.root"))],
        forces=[fmb.PointLoad("load", marker="beam.tip", force=(0.0, tip_force, 0.0)), *forces],
        sensors=sensors,
    )


GAUGE = fmb.StrainGauge("gauge", markers=("beam.left", "beam.right"), offset=(0.0, 0.015, 0.0))


def test_a_strain_gauge_against_beam_theory():
    """Mean bending strain between 0.3 and 0.4 m of a beam of 1 m: -F (L - x) c / (E I) at x = 0.35 m."""
    second_moment = 0.02 * 0.03**3 / 12.0
    for force in (-10.0, 5.0):
        settled = fmb.statics(cantilever(force, [GAUGE]))
        assert settled["gauge"][-1] == pytest.approx(-force * 0.65 * 0.015 / (210e9 * second_moment), rel=1e-4)


def test_values_in_the_loop_are_those_after_the_run():
    """Strains, modal coordinates, deflections and forces: what loops read is what sensors tell."""
    spring = fmb.Bushing(
        "spring", markers=("ground.origin", "beam.tip"), stiffness=(1e3, 2e3, 3e3, 10.0, 20.0, 30.0), damping=(1.0,) * 6
    )
    sensors = {
        "gauge": (GAUGE, 0),
        "mode": (fmb.ModalCoordinate("mode", body="beam", mode=2), 0),
        "bow": (fmb.Deflection("bow", marker="beam.right"), 1),
        "pull": (fmb.ForceOf("pull", force="spring", axes="beam.right"), 1),
        "carried": (fmb.Reaction("carried", joint="clamp"), 1),
        "a": (fmb.Acceleration("a", marker="beam.tip"), 1),
    }
    read = [fmb.SignalValue(f"read {name}", of=fmb.measured(s, k)) for name, (s, k) in sensors.items()]
    shaken = fmb.harmonic(amplitude=50.0, frequency=20.0)
    model = cantilever(shaken, [*(s for s, _ in sensors.values()), *read], [spring])
    solution = fmb.simulate(model, 0.05, samples=21)
    for name, (_, k) in sensors.items():
        told = solution[name] if np.ndim(solution[name]) == 1 else solution[name][:, k]
        assert solution[f"read {name}"] == pytest.approx(told, rel=1e-9, abs=1e-9 * np.abs(told).max()), name


def _freely(effort, forces=()) -> fmb.Model:
    """Return a reduced beam and a rod that turn and fly, with a couple that follows what is measured."""
    rod = fmb.RigidBody.rod("rod", length=0.5, mass=1.0, radius=0.02, at=(1.1, 0.2, 0.3), rotation=(0.3, -0.2, 0.4))
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("beam", data=beam(), rotation=(0.2, 0.1, -0.3)), rod],
        forces=[
            fmb.PointLoad("load", marker="rod.center", axes="rod.center", force=(effort, 0.0, 0.0)),
            fmb.PointLoad("other", marker="rod.center", moment=(0.0, 0.0, 0.3 * effort)),
            *forces,
        ],
    )


BETWEEN = ("beam.tip", "rod.center")
FORCES = {
    "spring": fmb.SpringDamper("f", markers=BETWEEN, stiffness=300.0, damping=4.0, length=0.2),
    "bushing": fmb.Bushing("f", markers=BETWEEN, stiffness=(1e3, 2e3, 3e3, 10.0, 20.0, 30.0), damping=(1.0,) * 6),
    "damper": fmb.MaxwellDamper("f", markers=BETWEEN, branches=((300.0, 0.05), (100.0, 0.2))),
    "load": fmb.PointLoad("f", marker="beam.tip", axes="beam.tip", force=(3.0, 2.0, 1.0)),
}
READ = {
    "gauge": fmb.measured(GAUGE) * 1e4,
    "gauge rate": fmb.measured(GAUGE, rate=True) * 1e3,
    "mode": fmb.measured(fmb.ModalCoordinate("m", body="beam", mode=1)) * 100.0,
    "deflection": fmb.measured(fmb.Deflection("d", marker="beam.tip"), 1) * 100.0,
    **{name: fmb.measured(fmb.ForceOf("r", force="f"), 1) for name in FORCES},
    "moment": fmb.measured(fmb.ForceOf("r", force="f"), 4),
    "axes": fmb.measured(fmb.ForceOf("r", force="f", axes="rod.center"), 2),
    "acceleration": fmb.measured(fmb.Acceleration("a", marker="rod.center"), 2) * 0.2,
}


def _derivatives(model, speed):
    """Return K, D and M of a model in motion by its kernels, and by differences of fourth order of the residual."""
    system, state = assemble(model)
    work, random = system.workspace(), np.random.default_rng(19)
    state.u[:] = speed * random.normal(size=system.nu)
    state.a[:] = random.normal(size=system.nu)
    state.q[system.body_slices["beam"][0]][7:] += 1e-3 * random.normal(size=beam().n_modes)
    tangent = tangent_at(system, state, system.workspace())
    work.weights[0].wanted = 0

    def residual(q, u, a):
        evaluate(system.program, state._replace(q=q, u=u, a=a), work)
        return work.residual.copy()

    found, modes = np.zeros((3, system.nu, system.nu)), system.body_slices["beam"][1]
    for k, unit in enumerate(np.eye(system.nu)):
        h = 2e-5 if modes.start + 6 <= k < modes.stop else 1e-3  # a flexible coordinate of 1 m is a large rotation
        for way, weight in ((1, 8.0), (-1, -8.0), (2, -1.0), (-2, 1.0)):
            q, step = np.zeros(system.nq), way * h * unit
            advance(system.program, state.q, unit, way * h, q)
            moved = (q, state.u, state.a), (state.q, state.u + step, state.a), (state.q, state.u, state.a + step)
            found[:, :, k] += weight / (12.0 * h) * np.array([residual(*at) for at in moved])
    return np.array([tangent.K.toarray(), tangent.D.toarray(), tangent.M.toarray()]), found


@pytest.mark.parametrize("name", READ)
def test_tangents_equal_differences(name):
    """What the signal adds to the derivatives by places, velocities and accelerations.

    The matrices of the bodies leave out small terms of inertia, so those without the signal are subtracted. So do those
    of forces: how their damping changes with places is told at rest alone.
    """
    signal, force = READ[name] + 0.05 * READ[name] * READ[name], FORCES.get(name, FORCES["bushing"])
    of_force = name in (*FORCES, "moment", "axes")
    for speed in (0.0, 1.0):
        ours, exact = (
            a - b
            for a, b in zip(_derivatives(_freely(signal, [force]), speed), _derivatives(_freely(0.0, [force]), speed))
        )
        assert np.abs(exact).max() > 0.1
        for k in range(1 if of_force and speed else 0, 3):
            assert ours[k] == pytest.approx(exact[k], abs=1e-7 * np.abs(exact).max())
