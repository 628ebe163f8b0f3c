"""Elastic bodies that do not fit their joints: named with both distances, and not bent into place without a word.

Reference: the geometry, by hand.
"""

import warnings

import pytest

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import CompileError

BEAM = fem.frame(
    [(0.1 * k, 0, 0) for k in range(11)], section=fem.Section.rectangle(0.02, 0.01), material=fmb.MATERIALS["steel"]
)


@pytest.fixture(scope="module")
def data():
    return reduction.reduce(BEAM, {"a": [0], "b": [10]}, modes=2, compare=0)


def between(data, span, kind=fmb.Spherical, **placed):
    """Return a model of the beam, 1 m, between two ground markers."""
    ground = fmb.Ground(markers={"left": (0, 0, 0), "right": (span, 0, 0)})
    joints = [
        kind("left", markers=("ground.left", "beam.a")),
        fmb.Spherical("right", markers=("ground.right", "beam.b")),
    ]
    sensors = [fmb.Reaction("end", joint="right")]
    return fmb.Model(bodies=[ground, fmb.FloatingBody("beam", data=data, **placed)], joints=joints, sensors=sensors)


def test_a_body_that_is_too_short_is_refused(data):
    message = (
        r"'beam.a' and 'beam.b' are 1 m apart, 'ground.left' and 'ground.right', which .* 1.02 m: 0.02 m do not fit"
    )
    for analysis in (fmb.check, fmb.statics):
        with pytest.raises(CompileError, match=message):
            analysis(between(data, 1.02))


def test_a_small_misfit_is_told(data):
    """Half a millimetre of 1 m: E A d/L = 21 kN in a beam that nobody loads. It is computed, and said."""
    model = between(data, 1.0005)
    assert any("0.0005 m" in line and "strain the body" in line for line in str(fmb.check(model)).splitlines())
    with pytest.warns(fmb.ValidityWarning, match="strain the body by the difference"):
        solution = fmb.statics(model)
    assert abs(solution["end"][-1, 0]) == pytest.approx(210e9 * 2e-4 * 5e-4, rel=2e-3)


def test_what_fits_is_not_mentioned(data):
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.ValidityWarning)
        rest = fmb.statics(between(data, 1.0))
    assert abs(rest["end"][-1, 0]) < 1.0  # N; half a millimetre would be 21 kN
    assert not any("strain the body" in line for line in str(fmb.check(between(data, 1.0))).splitlines())


def test_an_interface_far_from_its_fixed_marker_is_refused(data):
    """A fitting at 1.3 m, the interface at 1 m: of other parameters, most likely."""
    fitting = fmb.RigidBody("fitting", mass=1.0, inertia=(1e-3,) * 3, at=(1.3, 0, 0), markers={"beam": (0, 0, 0)})
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"left": (0, 0, 0)}), fmb.FloatingBody("beam", data=data), fitting],
        joints=[
            fmb.Revolute("left", markers=("ground.left", "beam.a")),
            fmb.Fixed("tip fitting", markers=("beam.b", "fitting.beam")),
        ],
    )
    with pytest.raises(
        CompileError,
        match=r"its 'beam.b' is 0.3 m away from 'fitting.beam', to which Joint 'tip fitting' fixes it: "
        r"they are at \(1, 0, 0\) m and \(1.3, 0, 0\) m",
    ):
        fmb.check(model)
