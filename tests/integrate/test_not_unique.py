"""Reactions that are not unique are said to be so wherever they are shown; what is probably not meant is noted."""

import warnings

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli.run import summary

HINGES = ("A", "B", "C")


def door(hinges=HINGES, gravity=(0, 0, -9.81), at=(0, 0, 0)):
    """A door of 12 kg on one, two or three hinges in a row."""
    places = {name: (0, 0, 0.5 * k) for k, name in enumerate(hinges)}
    return fmb.Model(
        gravity=gravity,
        bodies=[
            fmb.Ground(markers=places),
            fmb.RigidBody("door", mass=12.0, inertia=(1, 1, 1), center_of_mass=(0.4, 0, 0.5), at=at, markers=places),
        ],
        joints=[fmb.Revolute(name, markers=(f"ground.{name}", f"door.{name}")) for name in hinges],
        sensors=[fmb.Reaction(f"force {name}", joint=name) for name in hinges],
    )


@pytest.mark.parametrize("analyse", [lambda m: fmb.simulate(m, 0.01, samples=2), fmb.statics])
def test_three_hinges_share_a_load_as_nobody_knows(analyse, tmp_path):
    solution = analyse(door())
    assert set(solution.shared_reactions) == set(HINGES)
    assert "InPlane z" in solution.shared_reactions["A"] or "Coincident" in str(solution.shared_reactions["A"])
    assert "reactions not unique: A, B, C" in repr(solution)
    text = summary(solution, tmp_path)
    assert "Reactions are not unique in the joints A, B, C" in text
    assert "(sensors force A, force B, force C)" in text
    assert "flexmb check" in text
    loaded = fmb.Solution.load(solution.save(tmp_path / "door.h5"))
    assert loaded.shared_reactions == solution.shared_reactions
    page = fmb.view.report(solution, tmp_path / "report.html", pictures=False).read_text(encoding="utf-8")
    assert page.count("Revolute (not unique)") == 3
    # their sum is what the weight asks for, however it is shared
    total = sum(solution[f"force {name}"][-1, :3] for name in HINGES)
    assert total[2] == pytest.approx(12.0 * 9.81, rel=1e-6)


def test_who_reads_a_share_is_told():
    """Once, by the sensor that reads it; in a plane linkage the reactions that are not unique carry nothing."""
    solution = fmb.simulate(door(), 0.01, samples=2)
    with pytest.warns(fmb.ValidityWarning, match="Sensor 'force B': reactions of joint 'B' are not unique") as told:
        assert np.any(solution["force B"])
    assert len(told) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.any(solution["force B"])  # known by now
        one = fmb.simulate(door(HINGES[:1]), 0.01, samples=2)
        assert np.any(one["force A"])


def test_a_plane_linkage_is_not_told():
    """Four hinges of parallel axes: what is not unique, forces along the axes and moments across, is zero."""
    places = np.array([(0, 0, 0), (0, 0, 1.0), (2.0, 0, 1.5), (2.0, 0, 0)])
    axis = {"z": (0, 1, 0), "x": (1, 0, 0)}
    bodies = [fmb.Ground(markers={"a": fmb.Pose.axes(places[0], **axis), "d": fmb.Pose.axes(places[3], **axis)})]
    for k, name in enumerate(("crank", "coupler", "rocker")):
        middle, half = 0.5 * (places[k] + places[k + 1]), 0.5 * (places[k + 1] - places[k])
        markers = {"s": fmb.Pose.axes(-half, **axis), "e": fmb.Pose.axes(half, **axis)}
        bodies.append(fmb.RigidBody(name, mass=1.0, inertia=(0.1, 0.1, 0.1), at=middle, markers=markers))
    pins = (("ground.a", "crank.s"), ("crank.e", "coupler.s"), ("coupler.e", "rocker.s"), ("rocker.e", "ground.d"))
    model = fmb.Model(
        bodies=bodies,
        joints=[fmb.Revolute(f"J{k}", markers=pair) for k, pair in enumerate(pins)],
        gravity=(0, 0, -9.81),
        sensors=[fmb.Reaction("r", joint="J1")],
    )
    solution = fmb.simulate(model, 0.1, samples=3)
    assert "J1" in solution.shared_reactions
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.any(solution["r"])


def test_one_hinge_knows_its_load(tmp_path):
    solution = fmb.simulate(door(HINGES[:1]), 0.01, samples=2)
    assert solution.shared_reactions == {}
    assert "not unique" not in repr(solution) + summary(solution, tmp_path)


def test_check_names_what_nothing_holds():
    model = door()
    stray = fmb.RigidBody("stray", mass=1.0, inertia=(1, 1, 1), at=(5, 0, 0))
    text = str(fmb.check(model.with_parts(bodies=[stray])))
    assert "Note: nothing holds 'stray': no joint and no force acts on a marker there" in text
    assert "gravity" not in text
    assert fmb.check(model).notes == ()
    spring = fmb.SpringDamper("s", markers=("ground.A", "stray.center"), stiffness=1.0, length=5.0)
    assert fmb.check(model.with_parts(bodies=[stray], forces=[spring])).notes == ()


def test_check_notes_that_there_is_no_gravity():
    assert "there is no gravity" in str(fmb.check(door(gravity=(0, 0, 0))))


def test_check_notes_a_part_that_was_moved():
    """A door drawn 4 cm beside its hinge, 6 % of the size of the model, is moved there: said with the distance."""
    report = fmb.check(door(HINGES[:1], at=(0.04, 0, 0)))
    (note,) = report.notes
    assert note.startswith("assembly moved the body 'door' by 0.04 m")
    assert np.isclose(report.moved, 0.04)
