"""Watching validity: Euler's column, a cantilever bent too far, a body that turns too fast."""

import warnings

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

STEEL = fmb.MATERIALS["steel"]
LENGTH, WIDTH, HEIGHT = 1.0, 0.02, 0.01
EULER = np.pi**2 * STEEL.young * WIDTH * HEIGHT**3 / 12 / (4 * LENGTH**2)


def cantilever(load, frame="buckens", **options):
    """A steel strip clamped at its root; `load` (3,) acts at its tip."""
    fe = fem.frame(
        np.linspace([0, 0, 0], [LENGTH, 0, 0], 11),
        section=fem.Section.rectangle(WIDTH, HEIGHT),
        material=STEEL,
        shear=False,
    )
    data = reduction.reduce(fe, {"root": "start", "tip": "end"}, 6, geometric_stiffness=True, stress=False, frame=frame)
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("strip", data=data, damping=0.5, **options)],
        joints=[fmb.Fixed("clamp", markers=("ground.origin", "strip.root"))],
        forces=[fmb.PointLoad("load", marker="strip.tip", force=load)],
    )


def largest(solution, measure):
    return solution.statistics["share of validity"]["Body 'strip'"][measure]


@pytest.mark.parametrize("frame", ["root", "buckens"])
def test_half_the_buckling_load_is_silent(frame):
    """Euler's formula for the column that a joint clamps to the ground, whatever its frame is."""
    push = fmb.step(-0.5 * EULER, at=0.0, rise=0.02)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solution = fmb.simulate(cantilever((push, 0, 0), frame), 0.04)
    assert largest(solution, "load") == pytest.approx(0.5, rel=0.02)
    assert largest(solution, "deformation") < 0.1


def test_past_the_buckling_load():
    push = fmb.step(-1.6 * EULER, at=0.0, rise=0.02)
    told = r"Body 'strip' carries 1\.\d+ times the load .*from interface 'tip', from t = 0\.0.*reduction.split"
    with pytest.warns(fmb.ValidityWarning, match=told):
        solution = fmb.simulate(cantilever((push, 0, 0), "root"), 0.03)
    assert [w for w in solution.statistics["warnings"] if "interface 'tip'" in w]


def test_bent_too_far():
    """F L^3 / (3 E I) = 0.2 L, seen from a frame that is clamped at the root; a mean frame turns with the strip and
    sees less of it."""
    force = 0.2 * 3 * STEEL.young * WIDTH * HEIGHT**3 / 12 / LENGTH**2
    told = r"deforms by \d\d % of its size at \(1, 0, 0\) m from.*less than 10 %.*Split it into \d bodies"
    with pytest.warns(fmb.ValidityWarning, match=told):
        solution = fmb.simulate(cantilever((0, 0, force), "root"), 0.3)
    assert largest(solution, "deformation") == pytest.approx(2.0, rel=0.2)  # with its overshoot
    mean = fmb.simulate(cantilever((0, 0, force)), 0.3)
    assert largest(mean, "deformation") < 1.0


def test_each_warning_comes_once(tmp_path):
    """Also in a run that is continued from its file, where the warning is kept."""
    force = 0.3 * 3 * STEEL.young * WIDTH * HEIGHT**3 / 12 / LENGTH**2
    model, path = cantilever((0, 0, force), "root"), tmp_path / "run.h5"
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        fmb.simulate(model, 0.2, samples=1001, output=path)
        stored = fmb.Solution.load(path, model=model)
        solution = fmb.resume(stored, 0.3)
    assert len([w for w in seen if "deforms" in str(w.message)]) == 1
    assert [w for w in stored.statistics["warnings"] if "deforms" in w] == solution.statistics["warnings"]


def test_faster_than_its_modes():
    """One bending pair of a strip, free-free about 52 Hz; it turns with 100 Hz."""
    fe = fem.frame(
        np.linspace([0, 0, 0], [LENGTH, 0, 0], 11), section=fem.Section.rectangle(HEIGHT, HEIGHT), material=STEEL
    )
    data = reduction.reduce(fe, {"root": "start", "tip": "end"}, 0, geometric_stiffness=True, stress=False)
    body = fmb.FloatingBody("strip", data=data, modes=2, angular_velocity=(0, 0, 200 * np.pi))
    told = "turns .* times as fast as its highest retained mode.*Keep more modes"
    with pytest.warns(fmb.ValidityWarning, match=told):
        solution = fmb.simulate(fmb.Model(bodies=[fmb.Ground(), body]), 0.001)
    assert largest(solution, "speed") == pytest.approx(100.0 / data.frequencies[1], rel=0.02)


def test_rigid_bodies_are_not_watched():
    ball = fmb.RigidBody("ball", mass=1.0, inertia=(1, 1, 1))
    assert "share of validity" not in fmb.simulate(fmb.Model(bodies=[fmb.Ground(), ball]), 0.1).statistics
