"""A body that falls through a floor because units or laws do not fit is named; one that rests is not.

Reference: a box of side s on an elastic foundation sinks by m g thickness / (modulus s^2), uniform pressure.
"""

import warnings

import numpy as np
import pytest

import flexmb as fmb

G = 9.81


def box_on_floor(side, modulus, thickness, height=1e-3):
    """Return a box of 1 kg above a floor."""
    shape = fmb.Cuboid(size=(side,) * 3)
    law = fmb.ElasticFoundation(modulus=modulus, thickness=thickness, damping=1.0)
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("box", mass=1.0, inertia=(1e-2,) * 3, at=(0, 0, 0.5 * side + height))],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            fmb.Surface("skin", marker="box.center", shape=shape, spacing=0.1 * side),
        ],
        forces=[fmb.SurfaceContact("stand", surfaces=("floor", "skin"), law=law)],
        sensors=[fmb.Position("r", marker="box.center")],
        gravity=(0, 0, -G),
    )


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Explicit()], ids=repr)
def test_a_box_in_other_units_than_its_floor_falls_through_and_is_named(integrator):
    """A side of 0.2 mm for 0.2 m: at rest it would lie 9.81 * 0.1 / (1e7 * 4e-8) = 2.45 m deep."""
    with pytest.warns(fmb.ValidityWarning, match="'floor' and 'skin' have sunk .* reach of the smaller"):
        solution = fmb.simulate(box_on_floor(2e-4, 1e7, 0.1, height=0.01), 0.3, samples=4, integrator=integrator)
    assert solution["r"][-1, 2] < -0.1
    assert sum("have sunk" in text for text in solution.statistics["warnings"]) == 1


def test_a_layer_pressed_to_more_than_its_thickness_is_named():
    """It would rest at 9.81 * 0.01 / (100 * 0.04) = 25 mm in a layer of 10 mm."""
    with pytest.warns(fmb.ValidityWarning, match=r"thickness of the layer, 0\.01 m, beyond which no law"):
        fmb.simulate(box_on_floor(0.2, 100.0, 0.01), 0.3, samples=31)


def test_a_box_at_rest_is_not_named():
    model = box_on_floor(0.2, 1e5, 0.01)
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.ValidityWarning)
        solution = fmb.simulate(model, 0.5, samples=11)
        resting = fmb.statics(model)
    depth = G * 0.01 / (1e5 * 0.2**2)
    assert 0.1 - resting["r"][-1, 2] == pytest.approx(depth, rel=0.02)
    assert np.all(0.1 - solution["r"][:, 2] < 5e-3)


def test_steps_from_outside_name_it():
    run = fmb.stepper(box_on_floor(2e-4, 1e7, 0.1), integrator=fmb.GeneralizedAlpha())
    run.advance(by=0.2)
    with pytest.warns(fmb.ValidityWarning, match="have sunk into each other"):
        assert run.solution.statistics["warnings"]
