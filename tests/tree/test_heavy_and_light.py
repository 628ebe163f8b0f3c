"""Loops of far heavier and far lighter bodies: what a heavy one follows is no dependent equation."""

from dataclasses import replace

import numpy as np
import pytest
from tree.models import loops, random_consistent
from tree.test_links import linked

import flexmb as fmb
from flexmb.system import assemble
from flexmb.tree.rigid.motion import link_rates

PULL = 3.0


def held_by_a_light_rod(heavy: float, light: float, angle: float = 0.0) -> fmb.Model:
    """Return a heavy slider that a light rod on a hinge holds against its weight, and a pendulum on a string.

    The rod lies at an angle to the slide; its end is held in its plane (at an angle), or along the slide.
    """
    rail = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
    end = (np.cos(angle), np.sin(angle), 0.0)
    ground = fmb.Ground(markers={"rail": rail, "far": (3.0, 0, 0), "end": end, "A": (0, 5, 0), "B": (1.2, 4.5, 0)})
    slider = fmb.RigidBody("slider", mass=heavy, inertia=(0.1 * heavy,) * 3, markers={"rail": rail, "pin": (0, 0, 0)})
    rod = fmb.RigidBody.rod("rod", length=1.0, mass=light, radius=0.01, rotation=(0, 0, angle))
    tie = fmb.Spherical("tie", markers=("ground.end", "rod.end"))
    joints = [
        fmb.Prismatic("slide", markers=("ground.rail", "slider.rail")),
        fmb.Revolute("pin", markers=("slider.pin", "rod.start")),
        tie if angle else fmb.Rod("tie", markers=("ground.far", "rod.end")),
        fmb.Spherical("ball", markers=("ground.A", "pendulum.start")),
        fmb.Rod("string", markers=("pendulum.end", "ground.B")),
    ]
    pendulum = fmb.RigidBody.rod("pendulum", length=1.0, mass=1.0, radius=0.01, at=(0, 5, 0))
    return fmb.Model(bodies=[ground, slider, rod, pendulum], joints=joints, gravity=(-PULL, -9.81, 0))


@pytest.mark.parametrize(("heavy", "light"), [(1.0, 1.0), (1e4, 1e-4), (1e6, 1e-3), (1e6, 1e-6)])
@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_light_rod_holds_a_heavy_slider(heavy, light, angle):
    """It does not fall; from a ratio of 1e7 on, the rod's equation was taken for a dependent one.

    At an angle the equations of the rod's end differ by the inverse mass of the slider, beside that of the rod.
    """
    rounded = 10.0 * np.finfo(float).eps * PULL * (heavy / light if angle else 1.0)
    model = held_by_a_light_rod(heavy, light, angle)
    system, state = assemble(model)
    unknowns, work = linked(system, state)
    x, v, _ = unknowns.of(state)
    assert link_rates(unknowns.links, work, 0.0, x, v) == -1
    assert abs(unknowns.links.a[unknowns.tree.rate_places["slide.slide"]]) < 1e-12 + rounded
    found = fmb.accelerations(model, formulation=fmb.Recursive())
    assert np.abs(found["slider"]).max() < 1e-9
    # along the slide: the weight of slider and rod, less what the pin carries of the rod
    assert np.abs(found.reactions["tie"][0]) == pytest.approx(PULL * (heavy + light), rel=1e-6)


def test_a_heavy_slider_rests_in_a_run():
    model = held_by_a_light_rod(1e6, 1e-3, 0.7)
    run = fmb.simulate(model, 0.2, samples=3, integrator=fmb.Explicit(formulation=fmb.Recursive()))
    assert np.abs(run.final.q[:3]).max() < 1e-9  # of the first moving body


@pytest.mark.parametrize("factors", [(1e6, 1.0, 1.0), (1.0, 1.0, 1e5), (1e5, 1e-3, 1.0), (1.0, 1e-5, 1e3)], ids=str)
def test_a_flexible_loop_between_heavy_and_light_bodies(factors, rng):
    """A four-bar with a flexible coupler, geared to a pendulum on a rod, beside the sparse solution."""
    scale = dict(zip(("crank", "rocker", "wheel"), factors, strict=True))
    model = loops()
    bodies = [
        replace(b, mass=b.mass * scale[b.name], inertia=np.asarray(b.inertia) * scale[b.name]) if b.name in scale else b
        for b in model.bodies
    ]
    system, state = random_consistent(replace(model, bodies=bodies), rng, spread=0.02)
    unknowns, work = linked(system, state)
    state.a[:], state.lam[:] = fmb.Augmented().accelerate(system, state, system.workspace())
    x, v, a = unknowns.of(state)
    assert link_rates(unknowns.links, work, 0.0, x, v) == -1
    np.testing.assert_allclose(unknowns.links.a, a, atol=1e-9 * np.abs(a).max())


def test_loops_that_stay_open_are_named(monkeypatch):
    """Not silently: where no factorisation of all bodies is found either."""

    def no_multipliers(tables, values, mobility):
        return np.zeros_like, np.zeros((len(mobility), 0))

    monkeypatch.setattr("flexmb.tree.recursive.closer", no_multipliers)
    monkeypatch.setattr("flexmb.tree.recursive.solved_accelerations", lambda *_: None)
    with pytest.raises(
        fmb.CompileError, match=r"do not close the loops of string, tie\..*masses whose ratio.*cut other"
    ):
        fmb.accelerations(held_by_a_light_rod(1e6, 1e-3), formulation=fmb.Recursive())
