"""Reduced bodies as links that touch, are driven, close loops and come loose: beside the sparse solution of all
equations, accelerations at random states and runs from the same start.
"""

from dataclasses import replace

import numpy as np
import pytest
from by_turns import slow
from tree.models import flexible_chain, loops
from tree.test_flexible_links import assert_same_rates

import flexmb as fmb

CLOSELY = {"rtol": 1e-11, "atol": 1e-13}


def touching(deep: float, law) -> fmb.Model:
    """Return two beams in a row, the balls at whose tips are pressed into a plane and into a ball of the ground."""
    model = flexible_chain(2)
    ground = fmb.Ground(markers={"below": (1.0, 0.0, -0.2 + deep), "beside": (2.0, 0.2 - deep, 0.0)})
    surfaces = [
        fmb.Surface("floor", marker="ground.below", shape=fmb.Plane()),
        fmb.Surface("post", marker="ground.beside", shape=fmb.Sphere(0.1)),
        fmb.Surface("elbow", marker="f0.tip", shape=fmb.Sphere(0.2)),
        fmb.Surface("end", marker="f1.tip", shape=fmb.Sphere(0.1)),
    ]
    contacts = [
        fmb.SurfaceContact("down", surfaces=("floor", "elbow"), law=law),
        fmb.SurfaceContact("aside", surfaces=("post", "end"), law=law),
    ]
    bodies = [ground, *model.bodies[1:]]
    return replace(model, bodies=bodies, surfaces=surfaces, forces=(*model.forces, *contacts))


SOFT = fmb.Hertz(stiffness=1e6, damping=0.3, friction=0.4, transition=0.05)


def driven(model: fmb.Model) -> fmb.Model:
    """Return a chain whose hinge at the ground and whose slide between two beams are driven."""
    drives = [
        fmb.Drive("turn", joint="j0", angle=fmb.expression("0.3 * t + t**2")),
        fmb.Drive("reach", joint="j2", displacement=fmb.expression("0.02 * t + 0.2 * t**2")),
    ]
    return model.with_parts(joints=drives)


def test_accelerations_with_contacts(rng):
    unknowns = assert_same_rates(touching(0.05, SOFT), rng, spread=1e-3)
    energy = unknowns.work.energy[0]
    assert energy.potential > 1.0  # J, in the contacts: they press


def test_accelerations_with_drives(rng):
    assert_same_rates(driven(flexible_chain(3)), rng, spread=0.0)


def driven_loop() -> fmb.Model:
    """Return the loops with a driven crank and a ball on the coupler that is pressed into the ground."""
    model = loops()
    ground = replace(model.bodies[0], markers={**model.bodies[0].markers, "bed": (0.4, 0.0, 0.0)})
    surfaces = [
        fmb.Surface("bed", marker="ground.bed", shape=fmb.Sphere(0.5)),
        fmb.Surface("belly", marker="coupler.mid", shape=fmb.Sphere(0.34)),
    ]
    touch = fmb.SurfaceContact("touch", surfaces=("bed", "belly"), law=SOFT)
    drive = fmb.Drive("turn", joint="D", angle=fmb.expression("1.5707963267948966 + 0.2 * t + 5 * t**2"))
    changed = replace(model, bodies=[ground, *model.bodies[1:]], surfaces=surfaces)
    return changed.with_parts(forces=[touch], joints=[drive])


def falling() -> fmb.Model:
    """Return two beams near a floor and a post, the second of which comes loose as its end is 5 mm aside."""
    model = touching(-0.01, SOFT)
    loose = fmb.Event("loose", sensor="height", column=1, above=0.005, then=fmb.Release("j1"))
    sensors = [fmb.Position("place", marker="f1.mid"), fmb.Position("height", marker="f1.tip")]
    return replace(model, gravity=(0, 0, -9.81), sensors=sensors, events=[loose])


MOTIONS = {
    "contacts": (lambda: replace(touching(-1e-3, SOFT), gravity=(0.0, 0.0, -9.81)), 0.03),
    "drives": (lambda: driven(flexible_chain(3)), 0.02),
    "a drive and a contact in a loop": (driven_loop, 0.006),
}


@pytest.mark.parametrize("name", [slow("contacts"), slow("drives"), "a drive and a contact in a loop"])
def test_motion_as_in_absolute_coordinates(name):
    """Both by steps of order 8 with the same tolerances, and by implicit steps in joint coordinates."""
    make, t_end = MOTIONS[name]
    model = make()
    reference = fmb.simulate(model, t_end, samples=3, integrator=fmb.Explicit(**CLOSELY, drift=1e-12))
    joints = fmb.simulate(model, t_end, samples=3, integrator=fmb.Explicit(**CLOSELY, formulation=fmb.Recursive()))
    implicit = fmb.simulate(model, t_end, samples=3, integrator=fmb.Implicit(rtol=1e-8))
    unit = np.abs(reference.final.u).max()
    for solution, close in ((joints, 1e-9), (implicit, 2e-6)):
        np.testing.assert_allclose(solution.final.q, reference.final.q, atol=close)
        np.testing.assert_allclose(solution.final.u, reference.final.u, atol=10.0 * close * unit)
        np.testing.assert_allclose(solution.phases[0].works[-1], reference.phases[0].works[-1], atol=100.0 * close)
    if model.surfaces:
        assert reference.phases[0].works[-1][2] > 0.01  # J, what contacts have taken


@pytest.mark.slow
def test_a_beam_that_comes_loose():
    """The event is at the same time, and the motion after it the same."""
    runs = [
        fmb.simulate(falling(), 0.1, samples=3, integrator=fmb.Explicit(**CLOSELY, formulation=formulation))
        for formulation in (fmb.Augmented(), fmb.Recursive())
    ]
    assert [len(run.phases) for run in runs] == [2, 2]
    assert runs[0].phases[0].t[-1] == pytest.approx(runs[1].phases[0].t[-1], abs=1e-9)
    np.testing.assert_allclose(runs[1].final.q, runs[0].final.q, atol=1e-8)
