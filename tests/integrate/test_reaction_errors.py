"""Reactions that vibrations make and the steps do not resolve are told, beside closed forms of the vibration.

A block is welded to the ground; a mass on a spring rings against it: the weld carries k x. Another mass flies past,
so that the vibration is small in the motion of the model.
"""

from dataclasses import replace

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb
from flexmb.integrate.runs.reaction_errors import shares_of_reactions
from flexmb.math.weights import no_matrix
from flexmb.system import assemble
from flexmb.system.program import evaluate


def ringing(x0, w, zeta=0.0, weight=0.0, unit=1.0):
    """Return the model: x0 / m, w / (rad/s); `weight` / N pulls on the block; all lengths are times `unit`."""
    ground = fmb.Ground(markers={"o": (0, 0, 0)})
    block = fmb.RigidBody("block", mass=1.0, inertia=0.1 * unit**2 * np.ones(3), markers={"o": (0, 0, 0)})
    mass = fmb.PointMass("mass", mass=1.0, at=((1.0 + x0) * unit, 0, 0))
    other = fmb.PointMass("other", mass=1.0, at=(0, 3.0 * unit, 0), velocity=(unit, 0, 0))
    spring = fmb.SpringDamper(
        "spring",
        markers=("block.o", "mass.center"),
        stiffness=w * w,
        damping=2.0 * zeta * w,
        length=unit,
    )
    pull = fmb.PointLoad("pull", marker="block.o", force=(weight * unit, 0, 0))
    return fmb.Model(
        bodies=[ground, block, mass, other],
        joints=[fmb.Fixed("weld", markers=("ground.o", "block.o"))],
        forces=[spring, pull],
        sensors=[fmb.Reaction("force", joint="weld")],
    )


def closed_form(t, x0, w, zeta, weight):
    """Return the force on the block by the weld along x, N: what spring and damper pull, and the weight."""
    wd = w * np.sqrt(1.0 - zeta * zeta)
    decay = x0 * np.exp(-zeta * w * t)
    x = decay * (np.cos(wd * t) + zeta * w / wd * np.sin(wd * t))
    v = -decay * w * w / wd * np.sin(wd * t)
    return -(w * w * x + 2.0 * zeta * w * v + weight)


def true_share(solution, x0, w, zeta=0.0, weight=0.0, unit=1.0):
    """Return the error of the force, relative to it: the less of mean and mean square."""
    exact = unit * closed_form(solution.t, x0, w, zeta, weight)
    error = solution["force"][:, 0] - exact
    mean = np.abs(error).mean() / np.abs(exact).mean()
    return min(mean, np.sqrt((error**2).mean() / (exact**2).mean()))


def told_and_true(x0, w, seconds, rtol=1e-6, zeta=0.0, weight=0.0, unit=1.0, method=fmb.GeneralizedAlpha):
    """Return the share that is told, the true one, and the notes about it."""
    model = ringing(x0, w, zeta, weight, unit)
    solution = fmb.simulate(model, seconds, samples=401, integrator=method(rtol=rtol))
    words = [note for note in solution.statistics["notes"] if "is not resolved" in note]
    return (
        solution.statistics["errors of reactions"]["Joint 'weld'"],
        true_share(solution, x0, w, zeta, weight, unit),
        words,
    )


def test_where_nothing_is_carried_there_is_no_share():
    """Multipliers that are all zero, beside those of the second motion that are not: no number, and no division."""
    system, state = assemble(ringing(0.0, 10.0))
    work, table = system.workspace(), np.zeros((system.ng, 4))
    no_matrix(work.weights)
    evaluate(system.program, state, work)
    assert shares_of_reactions(system, work, table) == {}
    table[:, [0, 2]] = 1e-9
    assert shares_of_reactions(system, work, table) == {}
    table[:, [1, 3]] = 1e-7
    assert shares_of_reactions(system, work, table)["Joint 'weld'"] == pytest.approx(0.01)


def test_of_a_resumed_run_the_larger_error_stays():
    """The reactions after the cut are not those of the first part."""
    model = ringing(1e-3, 100.0, zeta=0.02)
    alpha = fmb.GeneralizedAlpha()
    first = fmb.simulate(model, 0.2, samples=81, integrator=alpha)
    shares = {**first.statistics["errors of reactions"], "Joint 'weld'": 0.7, "Joint 'gone'": 0.3}
    first.statistics["errors of reactions"] = shares
    for integrator in (alpha, fmb.IDA()):  # which tells none
        rest = fmb.resume(first, 0.3, samples=121, integrator=integrator)
        assert rest.statistics["errors of reactions"] == shares


CASES = {
    "16 periods": (1e-3, 100.0, 1.0),
    "100 periods": (1e-2, 100.0, 6.283),
    "finer": (1e-3, 100.0, 1.0, 1e-8),
    "finer and smaller": (1e-4, 100.0, 1.0, 1e-8),
    "damped": (1e-2, 1000.0, 1.0, 1e-6, 0.02),
    "beside a weight": (1e-3, 100.0, 1.0, 1e-6, 0.0, 50.0),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_the_error_of_a_reaction_is_told(case):
    told, true, words = told_and_true(*case)
    assert told == pytest.approx(true, rel=0.35)
    assert bool(words) == (told > 0.1)


@pytest.mark.parametrize("rtol", [1e-6, 1e-5])
def test_implicit_tells_it_too(rtol):
    """16 periods more or less right; 100 periods of 100 rad/s at both tolerances; 2000 rad/s."""
    for case in ((1e-2, 100.0, 6.283), (1e-3, 2000.0, 0.31))[: 2 if rtol < 1e-5 else 1]:
        told, true, words = told_and_true(*case, rtol, method=fmb.Implicit)
        assert told == pytest.approx(true, rel=0.4)
        assert true > 0.05
        assert bool(words) == (told > 0.1)


def late(solution):
    """Return by how much reactions of MoreauJean are said to be late, %; None if nothing is said."""
    words = [note for note in solution.statistics.get("notes", []) if "are late by about" in note]
    assert len(words) <= 1
    return float(words[0].split("by about ")[1].split(" %")[0]) if words else None


@pytest.mark.parametrize(
    ("case", "steps", "much"),
    [
        ((1e-2, 100.0, 3.14), 1000, True),  # 20 steps in a period
        ((1e-2, 1000.0, 0.5, 0.02), 1000, True),
        ((1e-3, 100.0, 0.5), 1000, False),  # half a step late: 2.5 %
    ],
)
def test_moreau_jean_says_by_how_much_means_over_steps_are_late(case, steps, much):
    """A vibration turns by 2 atan(w h / 2) in a step: half of its change is the sine of half of that."""
    x0, w, seconds, *rest = case
    model, step = ringing(x0, w, *rest), seconds / steps
    solution = fmb.simulate(model, seconds, samples=steps // 5 + 1, integrator=fmb.MoreauJean(step=step))
    told = late(solution)
    assert (told is not None) == much
    if much:
        assert told == pytest.approx(100.0 * np.sin(np.arctan(0.5 * w * step)), rel=0.05)


def lost(solution):
    """Return what MoreauJean says of the phase that is lost, %; None if nothing is said."""
    words = [note for note in solution.statistics.get("notes", []) if "loses its phase in steps" in note]
    assert len(words) <= 1
    if not words:
        return None
    return 100.0 if "all of the reaction" in words[0] else float(words[0].split("about ")[1].split(" %")[0])


@pytest.mark.parametrize(("steps", "much"), [(2000, True), slow(6300, False)])
def test_moreau_jean_says_what_vibrations_lose_of_their_phase(steps, much):
    """Fifty periods by 40 steps each: a phase of w h - 2 atan(w h / 2) is lost in a step, half of it in the mean."""
    case, seconds = (1e-2, 100.0), 3.14159
    solution = fmb.simulate(ringing(*case), seconds, samples=401, integrator=fmb.MoreauJean(step=seconds / steps))
    turn = 100.0 * seconds / steps
    phase = steps * (turn - 2.0 * np.arctan(0.5 * turn))
    told = lost(solution)
    assert (told is not None) == much
    if much:
        assert told == pytest.approx(100.0 * 4.0 / phase * (1.0 - np.cos(0.5 * phase)), rel=0.1)
        assert told == pytest.approx(100.0 * true_share(solution, *case), rel=0.3)


def test_reactions_that_drives_make_lose_no_phase():
    """A rod that a drive swings by sixteen steps a period: it has no freedom that could swing by itself."""
    rod = fmb.RigidBody("rod", mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"a": (-0.5, 0, 0)})
    swung = fmb.Model(
        bodies=[fmb.Ground(markers={"o": (-0.5, 0, 0)}), rod],
        joints=[
            fmb.Revolute("hinge", markers=("ground.o", "rod.a")),
            fmb.Drive("motor", joint="hinge", angle=fmb.expression("0.3 * sin(40 * t)")),
        ],
        forces=[fmb.TorsionSpring("spring", joint="hinge", stiffness=10.0)],
    )
    assert lost(fmb.simulate(swung, 4.0, samples=51, integrator=fmb.MoreauJean(step=0.01))) is None


@pytest.mark.parametrize(
    "force",
    [
        None,
        slow(fmb.PointLoad("load", marker="rod.center", force=(0.0, 0.0, 1.0))),
        slow(fmb.TorsionSpring("damper", joint="hinge", stiffness=0.0, damping=1e-3)),
    ],
    ids=["free", "load", "damper"],
)
def test_a_pendulum_without_springs_is_told_of_no_lost_phase(force):
    """The harmonics of its reaction have the phase of the motion."""
    rod = fmb.RigidBody("rod", mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"a": (-0.5, 0, 0)})
    swinging = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(markers={"o": (-0.5, 0, 0)}), rod],
        joints=[fmb.Revolute("hinge", markers=("ground.o", "rod.a"))],
        forces=[force] if force else [],
    )
    assert lost(fmb.simulate(swinging, 20.0, samples=11, integrator=fmb.MoreauJean(step=0.02))) is None


def test_implicit_says_that_it_does_not_know_where_equations_depend():
    """Two welds of one block share its load: nothing was told, not even that nothing is known."""
    model = ringing(1e-2, 100.0)
    twice = replace(model, joints=[*model.joints, fmb.Fixed("weld2", markers=("ground.o", "block.o"))])
    for once, told in ((model, False), (twice, True)):
        notes = fmb.simulate(once, 0.1, samples=5, integrator=fmb.Implicit()).statistics.get("notes", [])
        assert any("not estimated where equations depend" in note for note in notes) == told


def chain(masses, length=0.5):
    """Return rods on hinges in a row that fall from the horizontal."""
    bodies, joints, before = [fmb.Ground()], [], "ground.origin"
    for k, mass in enumerate(masses):
        ends = {"a": (-length / 2, 0, 0), "b": (length / 2, 0, 0)}
        inertia = (0.1 * mass * length**2,) * 3
        rod = fmb.RigidBody(f"r{k}", mass=mass, inertia=inertia, at=((k + 0.5) * length, 0, 0), markers=ends)
        bodies.append(rod)
        joints.append(fmb.Revolute(f"j{k}", markers=(before, f"r{k}.a")))
        before = f"r{k}.b"
    sensors = [fmb.Reaction(joint.name, joint=joint.name) for joint in joints]
    return fmb.Model(bodies=bodies, joints=joints, gravity=(0, -9.81, 0), sensors=sensors)


@pytest.mark.parametrize(("masses", "steps"), [((1.0, 1.0), 300), ((1.0,), 60)])
def test_reactions_of_a_motion_are_late_by_no_more_than_they_are(masses, steps):
    """Pendulums, none of which vibrates: what one could lose was told, 20 to 30 % of reactions right by 2 to 5."""
    model = chain(masses)
    exact = fmb.simulate(model, 2.0, samples=101, integrator=fmb.IDA(rtol=1e-8))
    solution = fmb.simulate(model, 2.0, samples=101, integrator=fmb.MoreauJean(step=2.0 / steps))
    true = max(
        np.abs(solution[name] - exact[name]).mean() / np.abs(exact[name]).mean()
        for name in [joint.name for joint in model.joints]
    )
    told = late(solution)
    assert told is None or told < 130.0 * true


def test_a_phase_that_is_lost_is_noted():
    """The motion is right to 4e-4 of it, the reaction wrong by all of itself: before, nothing was said."""
    told, true, words = told_and_true(1e-3, 2000.0, 0.3142)
    assert true > 1.0
    assert told > 1.0
    assert "the reaction of Joint 'weld' is not resolved" in words[0]
    assert "by all of the reaction" in words[0]
    assert "give a smaller rtol or step, or damping to what rings" in words[0]


def test_the_unit_of_length_says_nothing():
    metres, small = (told_and_true(1e-3, 100.0, 1.0, unit=unit)[0] for unit in (1.0, 1e-6))
    assert small == pytest.approx(metres, rel=1e-3)


def test_reactions_that_nothing_shakes_are_no_error():
    """A balanced rotor: its bearings carry rounding alone, which is no reaction. A double pendulum: no vibration."""
    ground = fmb.Ground(markers={"o": (0, 0, 0)})
    rotor = fmb.RigidBody(
        "rotor",
        mass=2.0,
        inertia=(0.1, 0.1, 0.2),
        at=(-1e-4, 0, 0),
        velocity=(0, -0.03, 0),
        angular_velocity=(0, 0, 300.0),
        markers={"o": (1e-4, 0, 0)},
    )
    hinge = fmb.Revolute("hinge", markers=("ground.o", "rotor.o"))
    upper = fmb.RigidBody(
        "upper", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(0.5, 0, 0), markers={"a": (-0.5, 0, 0), "b": (0.5, 0, 0)}
    )
    lower = fmb.RigidBody("lower", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(1.5, 0, 0), markers={"a": (-0.5, 0, 0)})
    hinges = [
        fmb.Revolute("first", markers=("ground.o", "upper.a")),
        fmb.Revolute("second", markers=("upper.b", "lower.a")),
    ]
    spinning = fmb.Model(bodies=[ground, rotor], joints=[hinge])
    swinging = fmb.Model(bodies=[ground, upper, lower], joints=hinges, gravity=(0, -9.81, 0))
    for model, integrator, most in (
        (spinning, fmb.GeneralizedAlpha(), 1e-6),
        (swinging, fmb.GeneralizedAlpha(rtol=1e-4), 0.05),
        (swinging, fmb.GeneralizedAlpha(), 5e-3),
    ):
        statistics = fmb.simulate(model, 2.0, samples=101, integrator=integrator).statistics
        shares = statistics["errors of reactions"]
        assert "not resolved" not in " ".join(statistics.get("notes", []))
        assert 0.0 < max(shares.values()) < most


def test_after_an_event_nothing_is_told():
    """The motions meet other equations there: what was known until then stays."""
    ground = fmb.Ground(markers={"o": (0, 0, 0)})
    rod = fmb.RigidBody("rod", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(0.5, 0, 0), markers={"a": (-0.5, 0, 0)})
    lock = fmb.Event("stop", at=0.2, then=[fmb.Lock("hinge")])
    model = fmb.Model(
        bodies=[ground, rod],
        joints=[fmb.Revolute("hinge", markers=("ground.o", "rod.a"))],
        events=[lock],
        gravity=(0, -9.81, 0),
    )
    statistics = fmb.simulate(model, 0.5, samples=51).statistics
    assert 0.0 < statistics["errors of reactions"]["Joint 'hinge'"] < 1e-3
    assert list(statistics["errors of reactions"]) == ["Joint 'hinge'"]
