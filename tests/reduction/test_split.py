"""Reducing the parts of a split model: interfaces, stations and loads go to the part they lie in."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction


def parts():
    fe = fem.frame(
        np.linspace([0, 0, 0], [2, 0, 0], 9),
        section=fem.Section.rectangle(0.02, 0.03),
        material=fmb.MATERIALS["steel"],
        node_sets={"all": np.arange(9)},
    )
    return fem.split(fe, at=(1.0,))


def test_everything_finds_its_part():
    inner, outer = reduction.split(
        parts(),
        {"root": "start", "tip": (2.0, 0.0, 0.0)},
        3,
        stations={"mid": (1.6, 0, 0)},
        loads={"air": reduction.LineLoad("all", (0, 0, 1))},
    )
    assert inner.marker_names == ("root", "cut_1_2")
    assert outer.marker_names == ("tip", "cut_1_2", "mid")
    assert inner.load_names == outer.load_names == ("air",)
    for data in (inner, outer):  # 1 N/m over 1 m each
        assert data.load_shapes[0, 2] == pytest.approx(1.0, rel=1e-9)
    assert inner.mass + outer.mass == pytest.approx(2 * 0.02 * 0.03 * fmb.MATERIALS["steel"].density, rel=1e-12)


def test_bodies_and_joints():
    bodies = fmb.FloatingBody.split("beam", reduction.split(parts(), {"root": "start", "tip": "end"}, 2), at=(0, 0, 1))
    (joint,) = fmb.Fixed.at_cuts(bodies)
    assert [body.name for body in bodies] == ["beam_1", "beam_2"]
    assert joint.name == "beam_cut_1_2"
    assert joint.markers == ("beam_1.cut_1_2", "beam_2.cut_1_2")
    report = fmb.check(fmb.Model(bodies=[fmb.Ground(), *bodies], joints=[joint]))
    assert report.assembly_error == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(fmb.ModelError, match=r"Marker 'beam_1.cut_1_2'.*no marker of another body"):
        fmb.Fixed.at_cuts(bodies[:1])


@pytest.mark.parametrize(
    ("interfaces", "told"),
    [
        ({"root": "strat"}, "Interface 'root'.*Did you mean 'start'"),
        ({"root": "all"}, r"'all' lies in the parts \[1, 2\]"),
    ],
)
def test_messages(interfaces, told):
    with pytest.raises(fmb.ReductionError, match=told):
        reduction.split(parts(), interfaces)
