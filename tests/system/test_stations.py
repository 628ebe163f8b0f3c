"""Joints on stations of reduced bodies are told: a propped cantilever, 3/8 q L at its prop, no force along it."""

import warnings

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

SIDE, LENGTH = 0.02, 1.0
STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)


def propped(interfaces: dict, stations: dict, joint: bool = True):
    """Return the statics of a cantilever on a prop or under a load at its tip, and what is told."""
    points = np.column_stack([np.linspace(0.0, LENGTH, 21), np.zeros(21), np.zeros(21)])
    beam = fem.frame(points=points, section=fem.Section.rectangle(SIDE, SIDE), material=STEEL)
    data = reduction.reduce(beam, interfaces, 8, stations=stations)
    tip = [fmb.Spherical("prop", markers=("ground.prop", "beam.tip"))] if joint else []
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"prop": (LENGTH, 0, 0)}), fmb.FloatingBody("beam", data=data)],
        joints=[fmb.Fixed("root", markers=("ground.origin", "beam.root")), *tip],
        sensors=[fmb.Reaction("R", joint="prop")] if joint else [fmb.Position("tip", marker="beam.tip")],
    )
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        run = fmb.statics(model)
    return run, [str(one.message) for one in told if "stations" in str(one.message)]


def test_a_joint_on_a_station_is_told():
    run, (sentence,) = propped({"root": "start"}, {"tip": "end"})
    assert "'prop' on 'beam.tip'" in sentence
    assert "interface" in sentence
    expected = 0.375 * 7850.0 * SIDE**2 * 9.81 * LENGTH
    assert abs(run["R"][-1, 2] / expected - 1.0) > 0.02  # what is told


def test_a_joint_on_an_interface_is_not():
    run, told = propped({"root": "start", "tip": "end"}, {})
    assert not told
    assert run["R"][-1, 2] == pytest.approx(0.375 * 7850.0 * SIDE**2 * 9.81 * LENGTH, rel=5e-4)


def test_a_station_that_observes_is_not():
    assert not propped({"root": "start"}, {"tip": "end"}, joint=False)[1]
