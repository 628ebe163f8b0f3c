"""Friction that should hold: what its regularised law lets creep is told, and only that.

Reference: the law itself. On a slope of the angle b a slide with mu N tanh(v / v_t) creeps at v_t artanh(tan b / mu).
"""

import warnings
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.runs.creep_watch import CreepWatch
from flexmb.system import compile

SLOPE, G = 0.2, 9.81
ALONG = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 0, 1))


def on_a_slope(*forces, speed=0.0, slope=SLOPE) -> fmb.Model:
    """A block of 1 kg on a slide down a slope."""
    block = fmb.RigidBody("block", mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"s": ALONG}, velocity=(speed, 0, 0))
    return fmb.Model(
        gravity=(G * np.sin(slope), 0, -G * np.cos(slope)),
        bodies=[fmb.Ground(markers={"s": ALONG}), block],
        joints=[fmb.Prismatic("slide", markers=("ground.s", "block.s"))],
        forces=list(forces),
        sensors=[fmb.Position("x", marker="block.s")],
    )


def told(model, t_end, **settings):
    """Return the run and what it tells of creep."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        run = fmb.simulate(model, t_end, **settings)
    return run, [str(one.message) for one in found if "regularised" in str(one.message)]


def way(sentence: str) -> float:
    """Return how far it goes."""
    return float(sentence.split("it goes ")[1].split()[0])


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.IDA()], ids=lambda i: type(i).__name__
)
def test_what_should_stand_and_creeps_is_told(integrator):
    run, sentences = told(on_a_slope(fmb.JointFriction("f", joint="slide", moving=0.3)), 10.0, integrator=integrator)
    crept = 1e-3 * np.arctanh(np.tan(SLOPE) / 0.3) * 10.0
    assert run["x"][-1, 0] == pytest.approx(crept, rel=5e-3)
    (sentence,) = sentences
    assert "Force 'f'" in sentence
    assert way(sentence) == pytest.approx(crept, rel=1e-2)
    assert sentence in run.statistics["warnings"]


def test_another_warning_about_the_force_does_not_silence_it():
    """Only what was told of its creep is not told again, whatever else begins with its name and "in"."""
    system = compile(on_a_slope(fmb.JointFriction("f", joint="slide", moving=0.3)))
    assert CreepWatch(system, ["Force 'f': in the equilibrium at the start it does not hold"]).told == set()
    creeps = "Force 'f': in 10 s in which it is slower than its transition of 0.001 m/s it goes 0.008 m"
    assert CreepWatch(system, [creeps]).told == {"Force 'f'"}


def test_a_smaller_transition_as_it_says_holds():
    """0.4 mm of a way that was 8 mm: what the sentence asks for is enough."""
    assert not told(on_a_slope(fmb.JointFriction("f", joint="slide", moving=0.3, transition=5e-5)), 10.0)[1]


def test_what_slides_and_swings_is_not_told():
    slides = on_a_slope(fmb.JointFriction("f", joint="slide", moving=0.1))
    swings = on_a_slope(
        fmb.JointFriction("f", joint="slide", moving=0.02),
        fmb.Bushing("k", markers=("ground.s", "block.s"), stiffness=(0, 0, 100.0, 0, 0, 0)),
        speed=2.0,
        slope=0.0,
    )
    slid, sentences = told(slides, 3.0)
    assert not sentences
    assert slid["x"][-1, 0] == pytest.approx(0.5 * G * (np.sin(SLOPE) - 0.1 * np.cos(SLOPE)) * 9.0, rel=1e-3)
    swung, sentences = told(swings, 3.0, samples=301)
    assert not sentences
    # 1/2 k x^2 + mu m g x = 1/2 m v^2 at the first turn
    first = (np.sqrt((0.02 * G) ** 2 + 100.0 * 4.0) - 0.02 * G) / 100.0
    assert swung["x"][:, 0].max() == pytest.approx(first, rel=5e-3)


def test_a_brake_that_turns_tells_radians():
    """4 N m on a brake of 10 N m: v_t artanh(0.4) of 0.01 rad/s in 5 s are 0.021 rad, more than a twentieth of 0.2."""
    wheel = fmb.RigidBody("wheel", mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"hub": (0, 0, 0)})
    model = fmb.Model(
        bodies=[fmb.Ground(), wheel],
        joints=[fmb.Revolute("axle", markers=("ground.origin", "wheel.hub"))],
        forces=[
            fmb.Actuator("load", joint="axle", effort=4.0),
            fmb.JointFriction("brake", joint="axle", moving=0.5, radius=0.1, preload=200.0, transition=0.01),
        ],
    )
    (sentence,) = told(model, 5.0)[1]
    assert "Force 'brake'" in sentence
    assert " rad; expected" in sentence
    assert way(sentence) == pytest.approx(0.05 * np.arctanh(0.4), rel=1e-2)


@pytest.mark.parametrize("transition", [1e-3, 1e-6])
def test_a_ball_that_stands_by_contact(transition):
    """A ball on a slope that may not roll: contact with friction creeps by v_t / sqrt((mu / tan b)^2 - 1)."""
    ball = fmb.RigidBody("ball", mass=1.0, inertia=(4e-3, 4e-3, 4e-3), at=(0, 0, 0.1))
    model = fmb.Model(
        gravity=(G * np.sin(SLOPE), 0, -G * np.cos(SLOPE)),
        bodies=[fmb.Ground(), ball],
        forces=[
            fmb.Contact(
                "floor",
                markers=("ground.origin", "ball.center"),
                radius=0.1,
                stiffness=1e6,
                damping=10.0,
                friction=0.5,
                transition=transition,
            ),
            fmb.Bushing("lock", markers=("ground.origin", "ball.center"), stiffness=(0, 0, 0, 1e5, 1e5, 1e5)),
        ],
    )
    sentences = told(model, 5.0, samples=201)[1]
    assert len(sentences) == (transition > 1e-4)
    if sentences:
        crept = transition / np.sqrt((0.5 / np.tan(SLOPE)) ** 2 - 1.0) * 5.0
        assert way(sentences[0]) == pytest.approx(crept, rel=0.05)


def in_two_phases(*, late: bool = False) -> fmb.Model:
    """The block of the first test, in a model that loses a joint of another body, which stays in its bushing."""
    slope = on_a_slope(fmb.JointFriction("f", joint="slide", moving=0.3))
    other = fmb.RigidBody("other", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(0, 0, 0))
    also = fmb.Bushing(
        "also",
        markers=("ground.origin", "other.center"),
        stiffness=(1e7, 1e7, 1e7, 1e5, 1e5, 1e5),
        damping=(1e4, 1e4, 1e4, 1e2, 1e2, 1e2),
    )
    return replace(
        slope,
        bodies=[*slope.bodies, other],
        joints=[*slope.joints, fmb.Fixed("held", markers=("ground.origin", "other.center"))],
        forces=[*slope.forces, also],
        events=[fmb.Event("gone", at=9.9 if late else 5.0, then=fmb.Release("held"))],
    )


@pytest.mark.filterwarnings("ignore::flexmb.ValidityWarning")
def test_a_run_of_phases_tells_once():
    run, sentences = told(in_two_phases(), 10.0)
    assert len(run.phases) == 2
    assert len(sentences) == 1


@pytest.mark.filterwarnings("ignore::flexmb.ValidityWarning")
def test_a_stepper_tells_of_every_phase():
    """Nearly all of the way lies before the event; what comes after it is too short to tell."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        with fmb.stepper(in_two_phases(late=True), keep=True) as run:
            for t in np.linspace(0.5, 9.95, 20):
                run.advance(to=float(t))
    (sentence,) = [str(one.message) for one in found if "regularised" in str(one.message)]
    assert way(sentence) == pytest.approx(1e-3 * np.arctanh(np.tan(SLOPE) / 0.3) * 9.9, rel=0.05)


@pytest.mark.filterwarnings("ignore::flexmb.ValidityWarning")
def test_a_stepper_tells_it_again_on_another_branch():
    """The phase before the event has crept; what a branch has told of it is untold where the branch is taken back."""
    with fmb.stepper(in_two_phases(late=True)) as run:
        run.advance(to=9.0)
        moment = run.save()
        for _ in range(3):
            run.advance(to=9.95)
            assert sum("regularised" in text for text in run.solution.statistics["warnings"]) == 1
            run.restore(moment)


@pytest.mark.parametrize("transition", [1e-3, 0.97e-3, 4.2e-3])
def test_the_transition_that_is_asked_for_is_enough(transition):
    (sentence,) = told(on_a_slope(fmb.JointFriction("f", joint="slide", moving=0.3, transition=transition)), 10.0)[1]
    asked = float(sentence.split("Give a transition of ")[1].split()[0])
    assert not told(on_a_slope(fmb.JointFriction("f", joint="slide", moving=0.3, transition=asked)), 10.0)[1]
