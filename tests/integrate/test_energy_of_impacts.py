"""Energy that Newton's law of restitution makes where friction turns the slip round is told; Poisson's law makes none.

A rod without gravity strikes a floor with its tip at 45 degrees, e = 1. With the mobility D of the tip (tangent,
normal) and what sticks, D P = (-vt, -2 vn): the energy grows by P . (v + v') / 2 = Pt vt / 2. Such impacts were found
by Kane & Levinson (Dynamics, 1985).
"""

import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.runs.energy_watch import EnergyWatch
from flexmb.system import compile

TIP = 1e-5  # m, radius


def rod(slip, law):
    """Return a rod of 1 kg and 1 m, 1 m/s towards the floor, whose tip slips with `slip`, m/s."""
    c = np.sqrt(0.5)
    body = fmb.RigidBody(
        "rod",
        mass=1.0,
        inertia=(1 / 12, 1 / 12, 1e-3),
        at=(0.0, 0.0, 0.5 * c + TIP + 5e-3),
        rotation=np.array([[c, 0, c], [0, 1, 0], [-c, 0, c]]),
        velocity=(slip, 0.0, -1.0),
        markers={"tip": (0.0, 0.0, -0.5)},
    )
    return fmb.Model(
        bodies=[fmb.Ground(), body],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            fmb.Surface("tip", marker="rod.tip", shape=fmb.Sphere(radius=TIP)),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=("floor", "tip"), law=law)],
        sensors=[fmb.Energy("energy")],
    )


def strike(slip, law, *loads):
    """Return the energy before and after, J, and the words about impacts."""
    model = rod(slip, law)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = fmb.simulate(
            replace(model, forces=[*model.forces, *loads]), 0.02, samples=21, integrator=fmb.MoreauJean(step=1e-4)
        )
    kinetic = run["energy"]
    return kinetic[0], kinetic[-1], [str(one.message) for one in caught if "impacts with friction" in str(one.message)]


def test_energy_that_newtons_law_makes_is_told():
    D = np.array([[2.5, -1.5], [-1.5, 2.5]])  # 1/m + r x r / J of the tip, 1/kg
    Pt, Pn = np.linalg.solve(D, (-0.2, 2.0))
    assert abs(Pt) < 0.6 * Pn
    before, after, words = strike(0.2, fmb.Rigid(restitution=1.0, friction=0.6))
    assert after - before == pytest.approx(0.1 * Pt, rel=1e-3)  # 0.0625 J of 0.52 J
    assert len(words) == 1
    assert "Force 'touch': impacts with friction have made 0.0625 J, 11 % of the largest energy" in words[0]
    assert "rule='Poisson'" in words[0]


@pytest.mark.parametrize(
    ("slip", "law"),
    [
        (0.2, fmb.Rigid(restitution=1.0, friction=0.6, rule="Poisson")),
        (0.2, fmb.Rigid(restitution=1.0)),
        (-1.0, fmb.Rigid(restitution=1.0, friction=0.3)),  # friction brakes: D P of slip, Pt against it
    ],
)
def test_other_impacts_make_none(slip, law):
    before, after, words = strike(slip, law)
    assert after <= before * (1.0 + 1e-9)
    assert not words


def test_energy_made_before_a_load_jumps_is_told_too():
    load = fmb.PointLoad("late", marker="rod.center", force=(fmb.step(1e-6, at=0.015), 0.0, 0.0))
    _, _, words = strike(0.2, fmb.Rigid(restitution=1.0, friction=0.6), load)
    assert len(words) == 1
    assert "have made 0.0625 J" in words[0]


@pytest.mark.parametrize("rule", ["Newton", "Poisson"])
def test_the_law_that_is_used_is_named(rule):
    """Poisson's law can make energy too, where several points strike at once (Kane & Levinson)."""
    model = rod(0.2, fmb.Rigid(restitution=1.0, friction=0.6, rule=rule))
    system = compile(model)
    watch = EnergyWatch(system, system.workspace())
    watch.moving, watch.rest = 1.0, 0.0
    (words,) = watch.made_by_impacts(SimpleNamespace(made_by_impacts=np.array([0.5])))
    assert f"{rule}'s law" in words
    assert ("use Rigid(..., rule='Poisson'), or a smaller restitution" in words) == (rule == "Newton")
    assert words.endswith("a smaller restitution.")
