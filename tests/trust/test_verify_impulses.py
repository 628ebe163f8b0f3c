"""`verify` on runs with rigid contacts: sound ones hold, and what was tampered with is found."""

from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb
from flexmb.trust.checks import of_impulses

G = 9.81


def sliding(friction=0.3, velocity=(2.0, 0.5, 0), restitution=0.0):
    """A block that slides and stops, on the floor, and a ball that rolls on it."""
    block = fmb.RigidBody("block", mass=2.0, inertia=(0.02, 0.03, 0.03), at=(0, 0, 0.1), velocity=velocity)
    ball = fmb.RigidBody(
        "ball", mass=1.0, inertia=(4e-3,) * 3, at=(0, 1, 0.1), velocity=(1, 0, 0), angular_velocity=(0, 0, 5.0)
    )
    return fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(), block, ball],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            fmb.Surface("block", marker="block.center", shape=fmb.Cuboid(size=(0.4, 0.3, 0.2))),
            fmb.Surface("ball", marker="ball.center", shape=fmb.Sphere(0.1)),
        ],
        forces=[
            fmb.SurfaceContact(
                "touch",
                surfaces=("floor", ("block", "ball")),
                law=fmb.Rigid(friction=friction, restitution=restitution),
            )
        ],
        sensors=[fmb.Position("p", marker="block.center"), fmb.Position("b", marker="ball.center")],
    )


METHOD = fmb.MoreauJean(step=2e-3)


@pytest.fixture(scope="module")
def run():
    return fmb.simulate(sliding(), 1.0, integrator=METHOD, samples=51)


def checks(solution, number=0):
    found, notes = of_impulses(solution, number, [5, 20, 35, 49], METHOD, 0.01)
    return {check.name: check for check in found}, notes


def test_a_sound_run_holds(run):
    told = fmb.verify(run)
    assert all(check.holds for check in told.checks)
    assert not any("equations from energies" in note for note in told.notes)
    names = {check.name: check.share for check in told.checks}
    assert names["equations of motion"] < 1e-6
    assert names["laws of contact"] < 1e-5
    assert names["penetration"] < 1e-6
    assert names["surfaces that touch still approach"] < 1e-6


def with_rows(run, **rows):
    return replace(run, phases=(replace(run.phases[0], **rows),))


def test_forces_that_were_changed_are_found(run):
    """Twice the friction of the sliding block: the equations are left open, and it lies outside of the cone."""
    system, q = run.series(0).system, run.phases[0].q.copy()
    fx = next(k for k, name in enumerate(system.branch_names) if "fx on block" in name)
    q[:, system.program.branches + fx] *= 2.0
    found, _ = checks(with_rows(run, q=q))
    assert found["equations of motion"].share > 0.1
    assert found["laws of contact"].share > 0.05


def test_another_friction_is_found(run):
    """A model that claims less friction than acted: the motion obeys the equations, and not the law."""
    wrong = sliding(friction=0.2)
    found, _ = checks(replace(run, phases=(replace(run.phases[0], model=wrong, system=None),)))
    assert found["equations of motion"].holds
    assert found["laws of contact"].share > 0.05


def test_a_body_that_was_sunk_is_found(run):
    q = run.phases[0].q.copy()
    system = run.series(0).system
    q[:, system.body_slices["ball"][0].start + 2] -= 0.005
    found, _ = checks(with_rows(run, q=q))
    assert found["penetration"].share == pytest.approx(0.05, rel=0.1)


def test_bounces_hold():
    """An impact in the step before a sample is lawful too."""
    solution = fmb.simulate(
        sliding(velocity=(1.0, 0, 1.0), restitution=0.5), 0.5, integrator=fmb.MoreauJean(step=1e-3), samples=501
    )
    struck = np.flatnonzero(np.abs(solution.phases[0].a).max(axis=1) > 100.0)
    assert len(struck)
    found, notes = of_impulses(solution, 0, [int(k) for k in struck[:4]], fmb.MoreauJean(step=1e-3), 0.01)
    assert not notes
    shares = {check.name: check.share for check in found}
    assert shares["equations of motion"] < 5e-3  # contacts act where half a step with the velocities before leads
    assert shares["laws of contact"] < 1e-5
