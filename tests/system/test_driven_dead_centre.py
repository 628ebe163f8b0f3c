"""What `check` tells about a mechanism that is drawn at a dead centre and driven from the wrong side.

Reference: a slider crank of 0.1 and 0.3 m with both links in one line has one freedom of velocities that no motion
follows, once the slider is held; a drive of the slider asks for what the links forbid there.
"""

import numpy as np
import pytest

import flexmb as fmb


def slider_crank(angle: float, *drives: fmb.Drive) -> fmb.Model:
    """Crank and rod at an angle of the crank (rad)."""
    pin = np.array((0.1 * np.cos(angle), 0.0, 0.1 * np.sin(angle)))
    end = np.array((pin[0] + np.sqrt(0.09 - pin[2] ** 2), 0.0, 0.0))

    def across(at):
        return fmb.Pose.axes(tuple(at), x=(1, 0, 0), z=(0, 1, 0))

    along = fmb.Pose.axes((0, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    half = 0.5 * (end - pin)
    bodies = [
        fmb.Ground(markers={"o": across((0, 0, 0)), "s": along}),
        fmb.RigidBody(
            "crank",
            mass=1,
            inertia=(1e-3,) * 3,
            at=tuple(0.5 * pin),
            markers={"o": across(-0.5 * pin), "a": tuple(0.5 * pin)},
        ),
        fmb.RigidBody(
            "rod",
            mass=1,
            inertia=(1e-2,) * 3,
            at=tuple(pin + half),
            markers={"a": tuple(-half), "b": across(half)},
        ),
        fmb.RigidBody(
            "slide", mass=1, inertia=(1e-2,) * 3, at=tuple(end), markers={"s": along, "b": across((0, 0, 0))}
        ),
    ]
    joints = [
        fmb.Revolute("O", markers=("ground.o", "crank.o")),
        fmb.Spherical("A", markers=("crank.a", "rod.a")),
        fmb.Revolute("B", markers=("slide.b", "rod.b")),
        fmb.Prismatic("P", markers=("ground.s", "slide.s")),
    ]
    return fmb.Model(bodies=bodies, joints=[*joints, *drives])


def push(name: str, begin: float, speed: float = -0.05) -> fmb.Drive:
    return fmb.Drive(name, joint="P", displacement=fmb.expression(f"{begin} + {speed}*t"))


@pytest.mark.parametrize(("angle", "place"), [(0.0, 0.4), (np.pi, 0.2)], ids=["stretched", "folded"])
def test_it_is_reported(angle, place):
    report = fmb.check(slider_crank(angle, push("push", place)))
    assert report.singular is not None
    assert (report.singular.instantaneous, report.singular.finite) == (1, 0)
    assert {"O", "A", "B", "push"} >= set(report.singular.joints) >= {"push"}
    assert any("no motion goes on from this start" in text and "push" in text for text in report.warnings)
    assert "Warning: no motion goes on" in str(report)


def test_runs_refuse_it():
    with pytest.raises(fmb.CompileError, match=r"push.*dead centre"):
        fmb.simulate(slider_crank(0.0, push("push", 0.4)), 0.1, samples=3)


def test_beside_it_nothing_is_reported():
    angle = 0.3
    place = 0.1 * np.cos(angle) + np.sqrt(0.09 - (0.1 * np.sin(angle)) ** 2)
    report = fmb.check(slider_crank(angle, push("push", place)))
    assert report.singular is None
    assert not any("no motion goes on" in text for text in report.warnings)


def test_drives_that_contradict_each_other_are_an_error():
    """0.05 and 0.02 m/s of one slider: no dead centre explains that."""
    angle = 0.3
    place = 0.1 * np.cos(angle) + np.sqrt(0.09 - (0.1 * np.sin(angle)) ** 2)
    model = slider_crank(angle, push("push", place), push("pull", place, -0.02))
    with pytest.raises(fmb.CompileError, match="contradict"):
        fmb.check(model)


def test_reactions_are_told_as_forces_and_moments():
    """The planar mechanism has one equation too many, across its plane; no names of equations are printed."""
    text = str(fmb.check(slider_crank(0.3)))
    assert "1 dependent equations:\n    P: moment about y" in text
    assert "O: force along y of W, moment about" in text
    for word in ("Coincident", "Perpendicular", "InPlane"):
        assert word not in text
