"""`Deflection` of a beam on two supports: what it is measured against, and that this is told."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

LENGTH, SIDE, YOUNG, DENSITY, G = 2.0, 0.02, 70e9, 2700.0, 9.81


@pytest.fixture(scope="module")
def data():
    line = fem.frame(
        np.linspace((0.0, 0.0, 0.0), (LENGTH, 0.0, 0.0), 9),
        section=fem.Section.rectangle(SIDE, SIDE),
        material=fmb.Material(young=YOUNG, poisson=0.3, density=DENSITY),
        shear=False,
    )
    return reduction.reduce(line, {"a": "start", "b": "end"}, 8, stations={"mid": [4]})


def beam(data, joints=True) -> fmb.Model:
    across = fmb.Pose.axes(z=(0.0, 1.0, 0.0))
    ground = fmb.Ground(markers={"a": across, "b": fmb.Pose.axes((LENGTH, 0.0, 0.0), z=(1.0, 0.0, 0.0))})
    supports = [fmb.Revolute("a", markers=("ground.a", "beam.a")), fmb.InLine("b", markers=("ground.b", "beam.b"))]
    return fmb.Model(
        gravity=(0.0, 0.0, -G),
        bodies=[ground, fmb.FloatingBody("beam", data=data, markers={"a": across})],
        joints=supports if joints else [],
        sensors=[
            fmb.Deflection("floating", marker="beam.mid"),
            fmb.Deflection("end", marker="beam.b"),
            fmb.Position("place", marker="beam.mid"),
        ],
    )


def test_what_floating_axes_show_of_a_sag(data):
    """5 q l^4 / 384 EI in W; against axes of the mean motion it is less by the mean of the sag, 16 f / 25 of it."""
    model = beam(data)
    still = fmb.statics(model)
    inertia, load = SIDE**4 / 12.0, DENSITY * SIDE**2 * G
    sag = 5.0 * load * LENGTH**4 / (384.0 * YOUNG * inertia)
    assert still["place"][-1, 2] == pytest.approx(-sag, rel=2e-3)
    assert still["floating"][-1, 2] == pytest.approx(-(1.0 - 16.0 / 25.0) * sag, rel=5e-3)
    (note,) = (text for text in fmb.check(model).notes if "mean motion of body" in text)
    assert note.startswith("Sensor 'floating', Sensor 'end': ")
    assert "relative_to='beam.<marker>'" in note


def test_free_bodies_and_clamped_frames_have_no_doubt(data):
    """Where nothing holds the body, its bow is meant; in a frame clamped at an end it is the way of the other one."""
    assert not any("mean motion" in text for text in fmb.check(beam(data, joints=False)).notes)
    model = beam(data)
    own = model.changed("floating", relative_to="beam.a").changed("end", relative_to="beam.a")
    assert not any("mean motion" in text for text in fmb.check(own).notes)
