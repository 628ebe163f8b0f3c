"""A run whose end is years away says so, with the state it has reached; a long one says what is left, and goes on."""

import warnings
from dataclasses import replace

import pytest
from by_turns import slow

import flexmb as fmb
from flexmb.integrate.runs import pace
from flexmb.integrate.runs.fastest import unchanged
from flexmb.integrate.runs.pace import Pace
from flexmb.system import assemble


@pytest.fixture
def pendulum():
    bar = fmb.RigidBody("bar", mass=1.0, inertia=(1e-3, 0.1, 0.1), at=(0.5, 0, 0), markers={"A": (-0.5, 0, 0)})
    return fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(markers={"A": (0, 0, 0)}), bar],
        joints=[fmb.Revolute("hinge", markers=("ground.A", "bar.A"))],
    )


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(step=1e-3), fmb.GeneralizedAlpha()])
def test_years(pendulum, integrator, monkeypatch):
    monkeypatch.setattr(pace, "WINDOW", 0.0)
    monkeypatch.setattr(pace, "STEPS", 100)
    with pytest.raises(
        fmb.IntegrationError, match=r"\d+ steps have reached t = .* would take .* years.*SI units"
    ) as caught:
        fmb.simulate(pendulum, t_end=1e15, samples=100_001, integrator=integrator)
    assert 0.0 <= caught.value.solution.t[-1] < 1e12


def test_hours_are_none_of_ours(pendulum, monkeypatch):
    monkeypatch.setattr(pace, "WINDOW", 0.0)
    monkeypatch.setattr(pace, "STEPS", 10)
    assert fmb.simulate(pendulum, t_end=2.0, samples=3).status.ok


INTEGRATORS = [
    fmb.GeneralizedAlpha(),
    fmb.Explicit(),
    fmb.Explicit(method="RK45"),
    fmb.Implicit(),
    fmb.IDA(most_steps=10**9),
]


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_long_run_is_told(pendulum, integrator, monkeypatch):
    """The part that moves fastest is named, and asking for it does not disturb the run."""
    monkeypatch.setattr(pace, "FIRST", 0.0)
    monkeypatch.setattr(pace, "LONG", 1.0)  # s: a fast machine has less left of these 1e6 s than a user would mind
    message = r"Model 'model', \w+: \d+ steps have reached t = .* s of 1000000 s; .* \(\d+ steps of about .* would take"
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.SlowRunWarning)
        with pytest.raises(fmb.SlowRunWarning, match=message) as told:
            fmb.simulate(pendulum, t_end=1e6, samples=1001, integrator=integrator)
    assert "the fastest is Body 'bar', " in str(told.value)
    assert "rad/s2)" in str(told.value) or "m/s2)" in str(told.value)


def test_a_long_run_in_joint_coordinates_says_why_its_steps_are_slow(pendulum, monkeypatch):
    """Friction by reactions makes the steps of `Recursive` those of Python: the way out is `Implicit`."""
    monkeypatch.setattr(pace, "FIRST", 0.0)
    monkeypatch.setattr(pace, "FEW", 1)
    monkeypatch.setattr(pace, "LONG", 0.0)
    rubbing = fmb.JointFriction("rub", joint="hinge", moving=0.1, radius=0.02, from_reaction=True)
    held = replace(pendulum, forces=[rubbing])
    with pytest.warns(fmb.SlowRunWarning) as told:
        fmb.simulate(held, t_end=2.0, samples=21, formulation=fmb.Recursive())
    sentence = str(told[0].message)
    assert "the recursion is over bodies: Force 'rub': a force that depends on reactions" in sentence
    assert "slower than those of Implicit()" in sentence
    with pytest.warns(fmb.SlowRunWarning) as told:
        fmb.simulate(pendulum, t_end=2.0, samples=21, formulation=fmb.Recursive())
    assert "recursion" not in str(told[0].message)


def test_telling_changes_nothing(pendulum, monkeypatch):
    alone = fmb.simulate(pendulum, t_end=2.0, samples=21)
    monkeypatch.setattr(pace, "FIRST", 0.0)
    monkeypatch.setattr(pace, "FEW", 1)
    monkeypatch.setattr(pace, "LONG", 0.0)
    with pytest.warns(fmb.SlowRunWarning):
        told = fmb.simulate(pendulum, t_end=2.0, samples=21)
    assert (told.phases[0].q == alone.phases[0].q).all()
    assert any("steps have reached" in note for note in told.statistics["notes"])


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


def run_of(*pieces):
    """Return the pace of a run to t = 1 s: pieces of (seconds of work, time reached, steps, steps in vain)."""
    clock = Clock()
    found = Pace(0.0, 1.0, clock)
    found.look(0.0, {})
    begun, t, steps, vain = 0.0, 0.0, 0, 0
    for work, to, more, lost in pieces:
        for k in range(1, 21):
            clock.now = 100.0 + begun + work * k / 20
            found.look(t + (to - t) * k / 20, {"steps": steps + more * k // 20, "rejected": vain + lost * k // 20})
        begun, t, steps, vain = begun + work, to, steps + more, vain + lost
    return found


def test_a_collapse_of_the_steps_is_seen_by_the_latest_pace():
    quick = (1.0, 0.5, 1000, 0)
    assert not run_of(quick).hopeless
    assert not run_of(quick, (9.0, 0.5 + 1e-9, 100_000, 0)).hopeless  # not yet ten seconds
    stuck = run_of(quick, (12.0, 0.5 + 1e-9, 100_000, 0))
    assert stuck.hopeless
    assert stuck.left == pytest.approx(0.5 / 1e-9 * 12.0, rel=0.2)
    assert "years" in stuck.sentence()


def test_steps_in_vain_are_steps_too():
    stuck = run_of((1.0, 0.5, 1000, 0), (12.0, 0.5, 0, 50_000))
    assert stuck.hopeless
    assert "in vain) the end would take countless years" in stuck.sentence()


def test_few_long_steps_are_left_alone():
    """A step of a second each, as of a large model: the pace of the first ones says nothing yet."""
    assert not run_of((60.0, 1e-9, 60, 0)).hopeless


def test_slow_is_told_once_and_again_when_it_is_much_worse():
    slow = run_of((5.0, 1e-3, 100, 0))
    assert slow.left == pytest.approx(0.999 / 1e-3 * 5.0)
    assert slow.long()
    assert not slow.long()
    worse = run_of((5.0, 1e-3, 100, 0))
    assert worse.long()
    worse._clock.now += 20.0
    worse.look(1e-3 + 1e-8, {"steps": 300})
    assert worse.long()


def test_a_run_of_minutes_is_not_told():
    assert not run_of((5.0, 0.05, 100, 0)).long()


def test_scratch_arrays_are_given_back_where_a_look_fails():
    """The run goes on with what it had, also after an error in a look at it."""
    system, _ = assemble(fmb.Model(bodies=[fmb.Ground(), fmb.PointMass("p", mass=1.0)]))
    work = system.workspace()
    before = work.residual.tolist()

    def look():
        with unchanged(system, work):
            work.residual[:] = 7.0
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        look()
    assert work.residual.tolist() == before


def held_cart(law, period=None):
    """Return a cart on a rail, 0.1 m from where a controller wants it."""
    place = fmb.JointCoordinate("x", joint="rail")
    effort = fmb.formula(law, over={"x": place})
    rail = fmb.Pose.axes(z=(1, 0, 0))
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"m": rail}),
            fmb.RigidBody("cart", mass=2.0, inertia=(1, 1, 1), at=(0.1, 0, 0), markers={"m": rail}),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.m", "cart.m"))],
        forces=[
            fmb.Actuator("motor", joint="rail", effort=fmb.Sampled(effort, period=period) if period else effort),
            fmb.SpringDamper("rest", markers=("ground.m", "cart.m"), stiffness=1.0, damping=0.1, length=0.05),
        ],
        sensors=[place],
    )


METHODS = [fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.IDA(), fmb.Explicit()]


@pytest.mark.parametrize("integrator", [slow(METHODS[0]), *METHODS[1:]], ids=lambda one: type(one).__name__)
def test_a_gain_that_a_sampler_cannot_hold_is_named(integrator):
    """-k x held for T is stable up to k T^2 / m of a few units; here it is 5."""
    said = r"Body 'cart', .*, grows without bound: .*what follows measurements: Force 'motor';"
    with pytest.raises(fmb.IntegrationError, match=said) as caught:
        fmb.simulate(held_cart("-1e5*x", 0.01), 100.0, samples=1001, integrator=integrator)
    assert "lower gains" in str(caught.value)
    assert len(caught.value.solution.t) > 1


@pytest.mark.parametrize("integrator", METHODS, ids=lambda one: type(one).__name__)
def test_what_is_fed_back_with_the_wrong_sign_does_not_run_for_ever(integrator, monkeypatch):
    """x'' = (w^2 + ...) x with w = 45 rad/s: in 100 s it would be e^4500."""
    monkeypatch.setattr(pace, "SOON", 0.0)
    monkeypatch.setattr(pace, "SLOW", 1.0)
    with pytest.raises(fmb.IntegrationError, match=r"grows without bound: .*Force 'motor'"):
        fmb.simulate(held_cart("4e3*x"), 100.0, samples=101, integrator=integrator)


def test_what_is_only_quick_goes_on(monkeypatch):
    """A body that has left its model by 1e7 lengths, at one speed, is no controller that fails."""
    monkeypatch.setattr(pace, "SOON", 0.0)
    monkeypatch.setattr(pace, "SLOW", 0.0)
    monkeypatch.setattr(pace, "FEW", 0)
    stone = fmb.PointMass("stone", mass=2.0, velocity=(1e7, 0, 0))
    push = fmb.PointLoad("push", marker="stone.center", force=(-1e-9 * fmb.measured("v"), 0, 0))
    model = fmb.Model(bodies=[fmb.Ground(), stone], forces=[push], sensors=[fmb.Velocity("v", marker="stone.center")])
    run = fmb.simulate(model, 10.0, samples=11, integrator=fmb.GeneralizedAlpha(step=1e-3))
    assert run.status.ok
    assert 1.0 - run["v"][-1, 0] / 1e7 == pytest.approx(5e-9, rel=1e-3)  # v' = -1e-9 v / 2 kg, for 10 s
