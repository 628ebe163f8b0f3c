"""Interfaces of a reduced body get the axes that a joint needs; their places stay those of the data."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import ModelError


@pytest.fixture(scope="module")
def data():
    points = np.linspace((0, 0, 0), (1, 0, 0), 5)
    beam = fem.frame(points=points, section=fem.Section.rectangle(0.04, 0.02), material=fmb.MATERIALS["steel"])
    return reduction.reduce(beam, {"a": (0, 0, 0), "b": (1, 0, 0)}, modes=2)


def test_a_pendulum_about_another_axis(data):
    """The same swing with other axes on both markers, and with everything turned in W."""
    R = fmb.Pose.axes(z=(0, 1, 0), x=(1, 0, 0)).matrix

    def swing(gravity, hinge, **body):
        beam = fmb.FloatingBody("beam", data=data, rigid=True, **body)
        model = fmb.Model(
            gravity=gravity,
            bodies=[fmb.Ground(markers={"A": hinge}), beam],
            joints=[fmb.Revolute("A", markers=("ground.A", "beam.a"))],
            sensors=[fmb.JointCoordinate("angle", joint="A")],
        )
        report = fmb.check(model)
        assert (report.mobility, report.redundant) == (1, ())
        assert report.assembly_error < 1e-12
        return fmb.simulate(model, 0.2, samples=11)["angle"]

    plain = swing((0, -9.81, 0), (0, 0, 0))
    quarter = fmb.Pose.axes(z=(0, 0, 1), x=(0, 1, 0))
    turned = swing((0, -9.81, 0), quarter, markers={"a": quarter})
    assert np.abs(plain).max() > 0.05
    np.testing.assert_allclose(turned, plain, atol=1e-9)
    whole = swing(tuple(R @ (0, -9.81, 0)), fmb.Pose((0, 0, 0), R), rotation=R)
    np.testing.assert_allclose(whole, plain, atol=1e-9)
    free = swing(tuple(R @ (0, -9.81, 0)), fmb.Pose((0, 0, 0), R @ quarter.matrix), rotation=R, markers={"a": quarter})
    np.testing.assert_allclose(free, plain, atol=1e-9)


def test_a_place_with_the_digits_of_a_mesh(data):
    """Bores of a mesh lie a few nanometres beside where they were drawn: described places may be the drawn ones."""
    body = fmb.FloatingBody("beam", data=data, markers={"b": fmb.Pose((1.0 + 2e-8, 1e-8, 0))})
    np.testing.assert_array_equal(body.marker_poses()["b"].at, (1.0, 0.0, 0.0))
    with pytest.raises(ModelError, match=r"marker b at \(1.00001, 0, 0\) m.*its place in the data, \(1, 0, 0\) m"):
        fmb.FloatingBody("beam", data=data, markers={"b": fmb.Pose((1.0 + 1e-5, 0, 0))})


def test_messages(data):
    with pytest.raises(ModelError, match=r"turns 'c', which the data does not have.*Interfaces and stations: a, b"):
        fmb.FloatingBody("beam", data=data, markers={"c": fmb.Pose.axes(z=(1, 0, 0))})
    with pytest.raises(ModelError, match=r"marker b at .*its place in the data.*add a station"):
        fmb.FloatingBody("beam", data=data, markers={"b": fmb.Pose((0.1, 0.2, 0.3))})
