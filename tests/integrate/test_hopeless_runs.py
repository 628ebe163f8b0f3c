"""A run whose end is years away says so, with the state it has reached; a long one says what is left, and goes on."""

import warnings

import pytest

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
        fmb.simulate(pendulum, t_end=1e15, samples=10_000_001, integrator=integrator)
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
    message = r"Model 'model', \w+: \d+ steps have reached t = .* s of 1000000 s; .* \(\d+ steps of about .* would take"
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.SlowRunWarning)
        with pytest.raises(fmb.SlowRunWarning, match=message) as told:
            fmb.simulate(pendulum, t_end=1e6, samples=1001, integrator=integrator)
    assert "the fastest is Body 'bar', " in str(told.value)
    assert "rad/s2)" in str(told.value) or "m/s2)" in str(told.value)


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
