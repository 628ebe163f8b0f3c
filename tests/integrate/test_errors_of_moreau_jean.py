"""What `MoreauJean` tells of the errors of its steps, beside closed forms and scipy's DOP853."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from integrate.test_driven_errors import model as driven
from integrate.test_driven_errors import reference
from scipy.integrate import solve_ivp

import flexmb as fmb
from flexmb.integrate.runs.added_error import ADDED_UP, UNKNOWN

GRAVITY = (0, 0, -9.81)


def told(model, seconds, **settings):
    """Return the run and the warnings about errors that have added up."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        run = fmb.simulate(model, seconds, samples=101, integrator=fmb.MoreauJean(**settings))
    return run, [str(one.message) for one in found if "added up" in str(one.message)]


def pendulum():
    """Return a rod of 1 kg and 1 m that falls from the horizontal."""
    return fmb.Model(
        gravity=GRAVITY,
        bodies=[
            fmb.Ground(markers={"pin": (0, 0, 0)}),
            fmb.RigidBody("rod", mass=1.0, inertia=(1e-4, 1 / 12, 1 / 12), at=(0.5, 0, 0), markers={"a": (-0.5, 0, 0)}),
        ],
        joints=[fmb.Spherical("pin", markers=("ground.pin", "rod.a"))],
        sensors=[fmb.Position("tip", marker="rod.center")],
    )


def spring(force=0.0):
    """Return 1 kg on a spring of 100 N/m, 0.2 m beyond its rest; a force sets in at 1.003 s, between two steps."""
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("p", mass=1.0, at=(1.2, 0, 0))],
        forces=[
            fmb.SpringDamper("k", markers=("ground.origin", "p.center"), stiffness=100.0, length=1.0),
            fmb.PointLoad("f", marker="p.center", force=(fmb.expression(f"where(t > 1.003, {force}, 0)"), 0, 0)),
        ],
        sensors=[fmb.Position("x", marker="p.center")],
    )


@pytest.mark.parametrize("force", [0.0, 5.0])
@pytest.mark.parametrize(("step", "warns"), [(0.02, True), (0.005, False)])
def test_the_phase_of_a_vibration(force, step, warns):
    """x = 1 + 0.2 cos 10 t, and f / k (1 - cos 10 (t - 1.003)) after the jump."""
    run, sentences = told(spring(force), 5.0, step=step)
    t = run.t
    exact = 1.0 + 0.2 * np.cos(10 * t) + force / 100 * (1 - np.cos(10 * (t - 1.003))) * (t > 1.003)
    true = np.abs(run["x"][:, 0] - exact).max() / np.abs(run["x"][:, 0] - 1.2).max()
    assert run.statistics[ADDED_UP] == pytest.approx(true, rel=0.2)
    assert bool(sentences) == warns == (true > 0.05)


@pytest.mark.parametrize(("step", "warns"), [(0.1, True), (0.02, False)])
def test_a_rigid_body_without_springs(step, warns):
    """A pendulum that turns by half a turn: theta'' = 3 g / 2 L cos theta."""
    run, sentences = told(pendulum(), 10.0, step=step)
    exact = solve_ivp(lambda t, y: (y[1], 1.5 * 9.81 * np.cos(y[0])), (0, 10), (0, 0), "DOP853", run.t, rtol=1e-12)
    tip = 0.5 * np.stack([np.cos(exact.y[0]), -np.sin(exact.y[0])])
    true = np.abs(run["tip"][:, [0, 2]].T - tip).max()
    assert run.statistics[ADDED_UP] == pytest.approx(true, rel=0.5)
    assert bool(sentences) == warns
    if warns:
        assert "Give a smaller step" in sentences[0]


@pytest.mark.parametrize(("step", "seconds", "warns"), [(0.025, 10.0, True), (0.005, 2.0, False)])
def test_a_driven_double_pendulum(step, seconds, warns):
    """With 400 steps all of the motion is lost, which nothing said; 2 s in shorter steps are right within 0.01 %."""
    run, sentences = told(driven(0.3, 7), seconds, step=step)
    phase = run.phases[0]
    place, speed = phase.system.body_slices["second"]
    p = phase.q[:, place][:, 3:7]
    exact = reference(0.3, 7, run.t, phase.u[0, speed][4])
    true = np.abs((2 * np.arctan2(p[:, 2], p[:, 0]) - exact + np.pi) % (2 * np.pi) - np.pi).max() / np.pi
    assert bool(sentences) == warns == (true > 0.05)
    if not warns:
        assert run.statistics[ADDED_UP] == pytest.approx(true, rel=0.3)


@pytest.mark.parametrize("seconds", [0.4, 0.6])
def test_after_a_contact_it_is_not_known(seconds):
    """A ball that falls on a floor after 0.45 s: exact until then (z = h - g t^2 / 2), and a note from there on."""
    model = fmb.Model(
        gravity=GRAVITY,
        bodies=[fmb.Ground(), fmb.PointMass("ball", mass=1.0, at=(0, 0, 1.1))],
        forces=[fmb.SurfaceContact("touch", surfaces=("floor", "skin"), law=fmb.Rigid(restitution=0.5))],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            fmb.Surface("skin", marker="ball.center", shape=fmb.Sphere(radius=0.1)),
        ],
    )
    run, sentences = told(model, seconds, step=0.004)
    assert not sentences
    noted = any("not known where something touches" in note for note in run.statistics.get("notes", ()))
    assert noted == (seconds > 0.45)
    if noted:
        assert run.statistics[ADDED_UP] == UNKNOWN
    else:
        assert run.statistics[ADDED_UP] < 1e-12


@pytest.mark.parametrize("steps", [1, 3, 4])
def test_inputs_that_change_from_outside(steps):
    """A mass on a spring, pushed by 10 N or not, in turns of so many steps of 0.01 s: the exact way by rotations of
    (x - x0, v / w). Where they change after each step nothing is told.
    """
    model = replace(
        spring(), forces=(spring().forces[0], fmb.PointLoad("f", marker="p.center", force=(fmb.input("push"), 0, 0)))
    )
    w, h, z, true = 10.0, 0.01 * steps, 0.2 + 0j, 0.0
    with fmb.stepper(model, integrator=fmb.MoreauJean(step=0.01), t_end=2.4) as run:
        for k in range(round(2.4 / h)):
            force = 10.0 * (k % 2)
            run.set("push", force)
            run.advance(to=(k + 1) * h)
            z = (z - force / w**2) * np.exp(-1j * w * h) + force / w**2
            true = max(true, abs(run["x"][0] - 1.0 - z.real))
        told = run.solution.statistics.get(ADDED_UP)
    if steps == 1:
        assert told is None
    else:
        assert told == pytest.approx(true / 0.4, rel=0.4)


def test_the_run_itself_stays_the_same():
    """Bit for bit with and without the second motion."""
    integrators = fmb.MoreauJean(step=0.01), fmb.MoreauJean(step=0.01, follow_errors=False)
    run, other = (fmb.simulate(spring(5.0), 2.0, samples=21, integrator=one) for one in integrators)
    np.testing.assert_array_equal(run["x"], other["x"])
    assert ADDED_UP in run.statistics
    assert ADDED_UP not in other.statistics
