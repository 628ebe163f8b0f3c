"""The row "modes" of `verify`: dynamic shapes are left out, static ones are not."""

from __future__ import annotations

import numpy as np
import pytest
from tolerances import SOLVER
from trust.test_verify import cantilever

import flexmb as fmb
from flexmb.model.subspace_data import in_subspace, own_shapes
from flexmb.trust.fewer_modes import _held_modes, without_highest


@pytest.fixture(scope="module")
def bar():
    return cantilever(None).bodies[1].data


def test_modes_with_held_ends_are_those_of_a_clamped_beam(bar):
    """f = 22.373 / (2 pi L^2) sqrt(EI / rho A), in both planes: 0.01 and 0.02 m; the mesh has eight elements."""
    steel = fmb.MATERIALS["steel"]
    _, w2 = _held_modes(bar)
    weak = 22.373 / (2.0 * np.pi) * np.sqrt(steel.young / steel.density / 12.0) * 0.01
    np.testing.assert_allclose(np.sqrt(w2[:2]) / (2.0 * np.pi), [weak, 2.0 * weak], rtol=0.01)


def test_static_deformation_stays(bar):
    """The deflection of the tip held at the root is the same to rounding; one of four modes is left out."""
    less, _ = without_highest(bar)
    assert less.n_modes == bar.n_modes - 1

    def tip(data):
        model = fmb.Model(
            bodies=[fmb.Ground(markers={"O": (0, 0, 0)}), fmb.FloatingBody("bar", data=data)],
            joints=[fmb.Fixed("clamp", markers=("ground.O", "bar.root"))],
            forces=[fmb.PointLoad("pull", marker="bar.tip", force=(1.0, 2.0, 0.5))],
            sensors=[fmb.Position("tip", marker="bar.tip")],
        )
        return fmb.statics(model)["tip"][-1] - (1.0, 0.0, 0.0)

    # the frame turns by what a shape that is left out turns: forces of second order act there
    np.testing.assert_allclose(tip(less), tip(bar), rtol=1e-6)


def test_a_body_that_bends_rightly_raises_no_alarm():
    """All ten coordinates bend the bar as its mesh does; leaving out static ones told 18 %."""
    found = fmb.verify(fmb.simulate(cantilever(None), 0.02, samples=11))
    assert any("9 for 10" in text for text in found.runs)
    assert found.answers[0].course["modes"] < 0.01


def test_in_other_coordinates_it_is_the_same_body(bar):
    """Any ten independent combinations of ten shapes: the same accelerations under gravity, turning."""
    mixed = in_subspace(bar, own_shapes(bar, np.random.default_rng(7).normal(size=(10, 10))))
    np.testing.assert_allclose(mixed.frequencies, bar.frequencies, rtol=1e-9)
    np.testing.assert_allclose(mixed.damping_ratios, bar.damping_ratios, rtol=1e-6, atol=1e-12)
    found = []
    for data in (bar, mixed):
        body = fmb.FloatingBody("bar", data=data, damping=0.0, angular_velocity=(1.0, 20.0, 30.0))
        model = fmb.Model(
            gravity=(0, 0, -9.81),
            bodies=[fmb.Ground(markers={"O": (0, 0, 0)}), body],
            joints=[fmb.Spherical("ball", markers=("ground.O", "bar.root"))],
        )
        found.append(fmb.accelerations(model)["bar"])
    np.testing.assert_allclose(found[1], found[0], rtol=SOLVER)


def course_of_modes(solution) -> float:
    return fmb.verify(solution).answers[0].course["modes"]


def test_a_run_that_begins_in_motion_begins_so_with_other_shapes():
    """The shapes of a smaller basis are none of the larger: the answer was told to be 200 times off."""
    first = fmb.simulate(cantilever(None), 0.02, samples=11)
    going = fmb.simulate(cantilever(None), 0.04, t_start=0.02, start=first.final, samples=11)
    assert course_of_modes(going) < 0.01


def test_states_of_forces_are_no_motion(bar):
    """A force behind a lag of 10 N: the bar rests, however large the number of the state is."""
    pull = (0.0, 0.0, fmb.Lag(of=fmb.expression("10 + where(t < 0.01, 0, 5)"), time=0.01))
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"O": (0, 0, 0)}), fmb.FloatingBody("bar", data=bar, damping=0.02)],
        joints=[fmb.Fixed("clamp", markers=("ground.O", "bar.root"))],
        forces=[fmb.PointLoad("pull", marker="bar.tip", force=pull)],
        sensors=[fmb.Deflection("bow", marker="bar.tip")],
    )
    run = fmb.simulate(model, 0.03, samples=13, start="equilibrium")
    assert run.phases[0].u[0].max() == pytest.approx(10.0)
    assert course_of_modes(run) < 0.01
