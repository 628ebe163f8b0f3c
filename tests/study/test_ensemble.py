"""The engine "compiled": variants of one mechanism in this process, with the digits of `simulate`."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb
from flexmb.errors import ModelError, ValidityWarning
from flexmb.integrate import Family
from flexmb.model.block import Block

RECURSIVE = fmb.Explicit(formulation=fmb.Recursive())
ROWS = ("t", "q", "u", "a", "lam", "works")


def cart(mass=0.5, length=0.5, stiffness=2.0, speed=0.0, tilt=0.05):
    """A pole on a cart, held by a spring: two joints, no loop."""
    rail = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 1, 0))
    pin = {"z": (0, 1, 0), "x": (1, 0, 0)}
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"rail": rail}),
            fmb.RigidBody(
                "cart",
                mass=1.0,
                inertia=(1e-3, 1e-3, 1e-3),
                velocity=(speed, 0, 0),
                markers={"rail": rail, "pin": fmb.Pose.axes((0, 0, 0), **pin)},
            ),
            fmb.RigidBody(
                "pole",
                mass=mass,
                inertia=(1e-2, 1e-2, 1e-3),
                at=(tilt, 0, length / 2),
                velocity=(speed, 0, 0),
                markers={"pin": fmb.Pose.axes((-tilt, 0, -length / 2), **pin), "tip": (0, 0, length / 2)},
            ),
        ],
        joints=[
            fmb.Prismatic("rail", markers=("ground.rail", "cart.rail")),
            fmb.Revolute("pin", markers=("cart.pin", "pole.pin")),
        ],
        forces=[
            fmb.SpringDamper(
                "spring", markers=("ground.rail", "pole.tip"), stiffness=stiffness, damping=0.05, length=0.5
            )
        ],
        sensors=[fmb.Position("tip", marker="pole.tip")],
    )


def four_bar(mass=0.5, stiffness=2.0, reach=0.3, driven=False):
    """Four revolute joints in a plane: three equations depend on others; `reach` moves the pin of the rocker."""

    def bar(name, at, ends):
        return fmb.RigidBody(name, mass=mass, inertia=(1e-3, 1e-3, 1e-3), at=at, markers=ends)

    joints = [
        fmb.Revolute("A", markers=("ground.A", "crank.A")),
        fmb.Revolute("B", markers=("crank.B", "coupler.B")),
        fmb.Revolute("C", markers=("coupler.C", "rocker.C")),
        fmb.Revolute("D", markers=("ground.D", "rocker.D")),
    ]
    motor = [fmb.Drive("motor", joint="A", angle=fmb.ramp(rate=stiffness, rise=0.1))]
    return fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[
            fmb.Ground(markers={"A": (0, 0, 0), "D": (reach, 0, 0)}),
            bar("crank", (0, 0.05, 0), {"A": (0, -0.05, 0), "B": (0, 0.05, 0)}),
            bar("coupler", (reach / 2, 0.15, 0), {"B": (-reach / 2, -0.05, 0), "C": (reach / 2, 0.05, 0)}),
            bar("rocker", (reach, 0.1, 0), {"C": (0, 0.1, 0), "D": (0, -0.1, 0)}),
        ],
        joints=joints + (motor if driven else []),
        forces=[fmb.TorsionSpring("spring", joint="D", stiffness=stiffness, damping=0.01, free_angle=1.0)],
        sensors=[fmb.Position("place", marker="coupler.C"), fmb.Reaction("force", joint="C")],
    )


def bouncing(stiffness=1e4, height=0.3):
    """A mass on a stop with a gap: its steps end where the contact begins."""
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"floor": (0, 0, 0)}),
            fmb.RigidBody("ball", mass=1.0, inertia=(1e-3, 1e-3, 1e-3), at=(0, 0, height)),
        ],
        joints=[fmb.Prismatic("guide", markers=("ground.floor", "ball.center"))],
        forces=[fmb.BiStop("stop", joint="guide", travel=(0.0, 1.0), stiffness=stiffness)],
        sensors=[fmb.Position("ball", marker="ball.center")],
    )


def rows_of(solution):
    (phase,) = solution.phases
    return [getattr(phase, name) for name in ROWS]


VARIED = {
    "cart": (cart, [{}, {"mass": 0.7, "stiffness": 3.0}, {"length": 0.6, "tilt": 0.1}, {"speed": 0.3}]),
    "four bar": (four_bar, [{}, {"mass": 0.8, "stiffness": 3.0}, {"reach": 0.35}, {"mass": 1e-3}]),
    "driven": (lambda **p: four_bar(driven=True, **p), [{}, {"stiffness": 3.0}, {"mass": 0.9}]),
    "stop": (bouncing, [{}, {"stiffness": 3e4}, {"height": 0.25}]),
}


METHODS = {
    "alpha": fmb.GeneralizedAlpha(),
    "recursive": RECURSIVE,
    "explicit": fmb.Explicit(),
    "implicit": fmb.Implicit(),
    "ida": fmb.IDA(),
}


@pytest.mark.parametrize(("name", "method"), every_second(VARIED, METHODS))
def test_every_digit_is_that_of_simulate(name, method):
    """Masses, loads, lengths, speeds and loops that change: the same steps, the same numbers."""
    family, integrator = Family(), METHODS[method]
    make, variants = VARIED[name]
    for given in variants:
        model = make(**given)
        alone = fmb.simulate(model, 0.25, integrator=integrator, samples=7)
        together = family.solution(model, 0.25, integrator=integrator, samples=7)
        for one, two in zip(rows_of(alone), rows_of(together), strict=True):
            np.testing.assert_array_equal(one, two)
        assert {**alone.statistics, "seconds": 0.0} == {**together.statistics, "seconds": 0.0}


@pytest.mark.parametrize("integrator", [fmb.Implicit(), fmb.IDA()], ids=["implicit", "ida"])
def test_threads_of_implicit_methods_do_not_meet(integrator, capsys):
    """Eight variants in four threads: each is what it is alone, and what is printed later is printed."""
    made = [four_bar(mass=m) if k % 2 else bouncing(height=m) for k, m in enumerate(np.linspace(0.2, 0.5, 8))]
    alone = [fmb.simulate(model, 0.3, integrator=integrator, samples=7) for model in made]
    family = Family()
    with ThreadPoolExecutor(4) as executor:
        found = list(executor.map(lambda model: family.solution(model, 0.3, integrator=integrator, samples=7), made))
    for one, two in zip(alone, found, strict=True):
        for own, other in zip(rows_of(one), rows_of(two), strict=True):
            np.testing.assert_array_equal(own, other)
    print("still here")
    assert capsys.readouterr().out == "still here\n"


def test_what_is_known_of_the_first_variant_is_used():
    """Else all is as slow as before, and nobody notices."""
    family = Family()
    family.solution(four_bar(), 0.01, samples=2)
    known = family._alikes
    assert known.assembled(four_bar(mass=0.7, stiffness=5.0), 0.0) is not None
    assert known.assembled(four_bar(reach=0.35), 0.0) is None  # a loop that is drawn otherwise is looked at again
    assert known.assembled(four_bar(mass=1e-6), 0.0) is None
    family = Family()
    family.solution(cart(), 0.01, samples=2)
    assert family._alikes.assembled(cart(length=0.7), 0.0) is not None
    assert family._alikes.assembled(bouncing(), 0.0) is None


def test_variants_of_six_alternating_structures_share_what_is_known(monkeypatch):
    """In the second round no pattern is sought and nothing is assembled from the start; the digits are the same."""
    from flexmb.integrate.runs import family as runs
    from flexmb.system import sparsity

    def variant(k, mass):
        springs = [
            fmb.SpringDamper(f"more {n}", markers=("ground.rail", "pole.tip"), stiffness=0.1, damping=0.01, length=0.4)
            for n in range(k % 3)
        ]
        model = cart(mass=mass)
        more = [fmb.PointMass(f"bob {n}", mass=0.1, at=(0.0, 1.0 + n, 0.0)) for n in range(k // 3)]
        return model.with_parts(bodies=more, forces=springs)

    begun = []
    drawn = runs.assemble_as_drawn
    monkeypatch.setattr(runs, "assemble_as_drawn", lambda *a, **k: begun.append(a) or drawn(*a, **k))
    family = Family()
    for k in range(6):
        family.solution(variant(k, 0.5), 0.02, samples=2)
    first, sought = len(begun), sparsity._of_few.cache_info().misses
    assert first == 6
    for k in range(6):
        found = family.solution(variant(k, 0.6), 0.02, samples=2)
        np.testing.assert_array_equal(found.final.q, fmb.simulate(variant(k, 0.6), 0.02, samples=2).final.q)
    assert len(begun) == first
    assert sparsity._of_few.cache_info().misses == sought


def test_variants_that_need_a_word_get_it():
    """A joint drawn open by a hand, a velocity that a joint does not allow: what `simulate` says is said."""
    family, good = Family(), cart()
    family.solution(good, 0.01, samples=2)
    wrong = good.changed("pole", at=(0.4, 0.0, 0.25))
    with pytest.raises(fmb.CompileError, match="as described it is open by") as alone:
        fmb.simulate(wrong, 0.01)
    with pytest.raises(fmb.CompileError) as together:
        family.solution(wrong, 0.01)
    assert str(alone.value) == str(together.value)
    sideways = good.changed("cart", velocity=(0.0, 0.2, 0.0))
    with pytest.warns(ValidityWarning, match="contradicts"):
        family.solution(sideways, 0.01, samples=2)


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "cart.toml"
    fmb.save_model(cart(), path, fmb.Simulation(t_end=0.2, samples=11))
    text = path.read_text().replace("mass = 0.5", 'mass = "= 1 / (2 - load)"')
    text = text.replace("stiffness = 2.0", 'stiffness = "= spring"')
    path.write_text(text + "\n[parameters]\nload = 0.0\nspring = 2.0\n")
    return path


def test_a_sweep_gives_the_rows_of_the_processes(table, tmp_path):
    """One variant has no mass: its row says so, the others are there, with the digits of the other way."""
    over = {"spring": [1.0, 2.0, 4.0], "load": [0.0, 2.0, 1.0]}
    seen = []
    together = fmb.sweep(
        table, over, outputs=["peak(tip x)"], engine="compiled", jobs=2, folder=tmp_path / "out", progress=seen.append
    )
    with ThreadPoolExecutor(1) as executor:
        apart = fmb.sweep(table, over, outputs=["peak(tip x)"], executor=executor)
    assert [row.status for row in together.rows] == [row.status for row in apart.rows] == ["done", "failed", "done"] * 3
    assert [row.values for row in together.rows] == [row.values for row in apart.rows]
    assert [row.error for row in together.rows] == [row.error for row in apart.rows]
    assert [step.done for step in seen] == list(range(10))
    kept = [json.loads(line) for line in (tmp_path / "out" / "rows.jsonl").read_text().splitlines()]
    assert sorted(row["number"] for row in kept) == list(range(1, 10))


def test_variants_that_choose_one_of_two_parts_of_a_name(tmp_path):
    """Free fall over 0.2 s, from the place that the parameter chooses: h - g t^2 / 2."""
    path = tmp_path / "choice.toml"
    path.write_text("""
gravity = [0, 0, -10.0]
[parameters]
high = true
[[body]]
kind = "Ground"
[[body]]
if = "= high"
kind = "PointMass"
name = "p"
mass = 1.0
at = [0, 0, 5.0]
[[body]]
unless = "= high"
kind = "PointMass"
name = "p"
mass = 1.0
at = [0, 0, 2.0]
[[sensor]]
kind = "Position"
name = "z"
marker = "p.center"
[simulation]
t_end = 0.2
samples = 3
""")
    results = fmb.sweep(path, {"high": [True, False, True]}, outputs=["final(z z)"], engine="compiled", jobs=1)
    assert [row.error for row in results.rows] == [""] * 3
    found = [next(iter(row.values.values())) for row in results.rows]
    np.testing.assert_allclose(found, [4.8, 1.8, 4.8], atol=1e-6)


def test_an_interrupted_sweep_goes_on(table, tmp_path):
    """The user stops at the third row: what was computed stays, and only the rest is computed then."""
    over, out = {"spring": [1.0, 1.5, 2.0, 2.5, 3.0, 3.5]}, tmp_path / "out"

    def stop(step):
        if step.done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fmb.sweep(table, over, engine="compiled", folder=out, progress=stop)
    stored = (out / "rows.jsonl").read_text().splitlines()
    assert len(stored) == 3
    seen = []
    results = fmb.sweep(table, over, engine="compiled", folder=out, progress=seen.append)
    assert [step.done for step in seen] == [3, 4, 5, 6]
    assert not results.failed
    assert (out / "rows.jsonl").read_text().splitlines()[:3] == stored


def test_warnings_belong_to_their_variant():
    plan = {"speed": [0.0, 0.2, 0.0, 0.3]}
    results = fmb.sweep(_pushed, plan, t_end=0.02, samples=3, engine="compiled", jobs=2)
    assert ["contradicts" in row.warnings for row in results.rows] == [False, True, False, True]


def _pushed(speed):
    return cart().changed("cart", velocity=(0.0, speed, 0.0))


def _push(t, d, v, R, w):
    return np.zeros(3), np.zeros(3)


def _stiff(speed):
    return 2.0 * speed


@dataclass(frozen=True, eq=False)
class _Falling(Block):
    """A state whose rate is a function of Python, as those of units for model exchange."""

    name, word = "falling", "falling"

    def states(self):
        return {"x": 1.0}

    def rates(self):
        return (fmb.Function([self.state("x")], function=_negative),)

    def output(self):
        return self.state("x")


def _negative(t, x):
    return -float(x[0])


@pytest.mark.parametrize("place", ["formula", "sensor", "rate of a block"])
def test_functions_are_found_wherever_they_are(place):
    """Threads would run them between each other's calls, and a unit's states belong to one of them only."""
    function = fmb.Function([fmb.JointCoordinate("x", joint="rail")], function=_negative)
    model = cart()
    if place == "sensor":
        model = model.with_parts(sensors=[fmb.SignalValue("answer", of=function)])
    else:
        effort = fmb.formula("2*y", over={"y": function}) if place == "formula" else 2.0 * _Falling()
        model = model.with_parts(forces=[fmb.Actuator("motor", joint="rail", effort=effort)])
    with pytest.raises(ModelError, match="Function calls a function of Python"):
        Family().solution(model, 0.1, samples=2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"engine": "fast"}, r"engine = 'fast'.*'processes', 'compiled'"),
        ({"timeout": 2.0}, r"timeout is given: threads cannot be ended"),
        ({"keep_runs": True, "folder": "out"}, r"keep_runs is given: files are written under one lock"),
        ({"executor": object()}, r"executor is given"),
    ],
)
def test_what_it_cannot_do_is_refused_before(table, change, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ModelError, match=message):
        fmb.sweep(table, {"spring": [1.0]}, **{"engine": "compiled", **change})
    assert not (tmp_path / "out").exists()


def test_what_a_variant_cannot_do_is_its_error():
    family = Family()
    with pytest.raises(ModelError, match=r"integrator = MoreauJean.*whose steps are Python's.*GeneralizedAlpha"):
        family.solution(cart(), 0.1, integrator=fmb.MoreauJean(step=1e-3))
    with pytest.raises(ModelError, match="whose steps are Python's"):
        family.solution(cart(), 0.1, integrator=fmb.Explicit(method="RK45"))
    push = fmb.UserForce("push", markers=("ground.rail", "pole.tip"), function=_push)
    model = cart().with_parts(forces=[push])
    with pytest.raises(ModelError, match=r"Force 'push'.*calls a function of Python"):
        family.solution(model, 0.1)
    rows = fmb.sweep(_stiff, {"speed": [1.0]}, t_end=1.0, engine="compiled").rows
    assert "it returns float. Expected: a Model, for the engine 'compiled'" in rows[0].error
