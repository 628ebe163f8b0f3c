"""Stiffness by interbody loads (Banerjee 1993, eqs. 7 and 41): the pull of an outer body stiffens the inner one.

Closed form of the first case: a massless beam under tension T with a mass at its tip has the lateral stiffness
T / (L - tanh(k L) / k), k^2 = T / (E I) (beam-column). In the second case two halves of the uniform blade of GS04 are
joined; the inner half carries the pull of the outer one through its interface.
"""

import numpy as np
import pytest
from verification.rotating_beams import angular_frequencies, on_hub, slender

import flexmb as fmb
from flexmb import reduction


def light_beam(stiffening=True):
    """A unit beam, E I = 1 in both planes, with a thousandth of the tip's mass."""
    data = reduction.reduce(
        slender(1.0, 1e6, 1.0, 1.0, 1e-5),
        {"root": "start", "tip": "end"},
        6,
        frame="root",
        geometric_stiffness=True,
        stress=False,
    )
    return fmb.FloatingBody("beam", data=data, geometric_stiffness=stiffening)


def with_tip_mass(body, angle, **options):
    ball = fmb.RigidBody("ball", mass=1.0, inertia=(1e-7, 1e-7, 1e-7), at=(1, 0, 0))
    return on_hub(
        body, angle, bodies=[ball], joints=[fmb.Fixed("weld", markers=("beam.tip", "ball.center"))], **options
    )


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0, 4.0])
def test_mass_on_a_light_beam(speed):
    model = with_tip_mass(light_beam(), fmb.expression("speed * t", speed=speed))
    chord, flap = 2 * np.pi * fmb.linearize(model, fmb.statics(model)).frequencies[:2]
    tension = speed**2
    k = np.sqrt(tension)
    stiffness = tension / (1.0 - np.tanh(k) / k)
    assert flap**2 == pytest.approx(stiffness, rel=3e-4)
    assert chord**2 == pytest.approx(stiffness - speed**2, rel=1e-3)


def test_inertia_loads_alone_let_it_fly_apart():
    """3 E I / (m L^3) = 3 < speed^2: without the matrices of the interface the chord motion is unstable."""
    still = fmb.expression("4 * t")
    inertia_only = with_tip_mass(light_beam(("inertia",)), still)
    assert not fmb.linearize(inertia_only, fmb.statics(inertia_only)).stable
    everything = with_tip_mass(light_beam(), still)
    assert fmb.linearize(everything, fmb.statics(everything)).stable


LEFT = {"up": {"above": 2.1}, "down": {"below": -2.1}}


@pytest.mark.parametrize("stiffening", [True, ("inertia",)])
def test_spin_up_of_the_chain(stiffening):
    """Spun up to 4 rad/s in 20 s the tip stays near the hub's direction; without the interface it leaves."""
    angle = fmb.expression("where(t < 20, 0.2*(t**2/2 + (10/pi)**2*(cos(pi*t/10) - 1)), 4*t - 40)")
    left = [fmb.Event(f"left {name}", sensor="bend", column=1, then=fmb.Stop(), **way) for name, way in LEFT.items()]
    bend = [fmb.Deflection("bend", marker="beam.tip")]
    model = with_tip_mass(light_beam(stiffening), angle, sensors=bend, events=left)
    motion = fmb.simulate(model, 22.0, samples=45, integrator=fmb.GeneralizedAlpha(step=0.02))
    bend = np.abs(motion["bend"][:, 1]).max()
    assert bend < 0.2 if stiffening is True else bend > 2.0


def halves(stiffening=True):
    """Return the inner and the outer half of the unit blade of GS04 that bends in the x-z plane."""
    bodies = []
    for number, name in enumerate(("inner", "outer")):
        fe = slender(0.5, 1e8, 1e4, 1.0, 1.0, elements=20)
        data = reduction.reduce(
            fe, {"root": "start", "tip": "end"}, 8, geometric_stiffness=True, stress=False, frame="root"
        )
        bodies.append(fmb.FloatingBody(name, data=data, at=(0.5 * number, 0, 0), geometric_stiffness=stiffening))
    return bodies


def chain(stiffening=True):
    inner, outer = halves(stiffening)
    return inner, {"bodies": [outer], "joints": [fmb.Fixed("bolts", markers=("inner.tip", "outer.root"))]}


def test_two_halves_are_the_whole_blade(reference):
    inner, rest = chain()
    for eta in (0, 3, 6, 12):
        expected = reference("GS04")["reference"]["flap"][str(eta)]
        np.testing.assert_allclose(angular_frequencies(inner, eta, **rest)[:3], expected, rtol=1e-3)


def test_two_halves_without_the_interface_are_too_soft(reference):
    inner, rest = chain(("inertia",))
    first = angular_frequencies(inner, 12, **rest)[0]
    assert first < 0.9 * reference("GS04")["reference"]["flap"]["12"][0]
