"""Messages of models with hundreds of parts name those that are near, not all."""

import pytest

import flexmb as fmb
from flexmb.errors import ModelError, listed


def test_few_names_are_shown_in_full():
    assert listed("x", ["one", "two"]) == "one, two"
    assert listed("x", []) == "none"


def test_of_many_names_the_nearest():
    names = [f"slat_{k}_front roller" for k in range(200)] + ["strut of track 2"]
    text = listed("strut of track 3", names)
    assert text.startswith("strut of track 2, ")
    assert text.endswith("... (201 in all)")
    assert len(text.split(", ")) == 13


def test_a_part_to_release_among_many():
    joints = [fmb.Revolute(f"hinge {k}", markers=("ground.origin", f"b{k}.center")) for k in range(40)]
    bodies = [fmb.Ground(), *(fmb.RigidBody(f"b{k}", mass=1, inertia=(1, 1, 1)) for k in range(40))]
    with pytest.raises(ModelError) as caught:
        fmb.Model(bodies=bodies, joints=joints, events=[fmb.Event("break", at=0.1, then=fmb.Release("hinge 4O"))])
    assert "(40 in all)" in str(caught.value)
    assert "Did you mean 'hinge 4'?" in str(caught.value)
    assert len(str(caught.value)) < 400
