"""Equilibria that the smallest push ends are told. Reference: a rod on its end falls with sqrt(3 g / (2 L)), Euler."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)


def pendulum(tilt, **force):
    """A rod of 1 m on a ball joint at its end, tilted from where it stands on its head."""
    rod = fmb.RigidBody.rod("rod", length=1.0, mass=1.0, radius=0.02, rotation=(0.0, tilt - np.pi / 2, 0.0))
    joint = fmb.Spherical("foot", markers=("ground.origin", "rod.start"))
    return fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), rod], joints=[joint], **force)


def told(caught):
    return [str(w.message) for w in caught if "is unstable" in str(w.message)]


@pytest.mark.parametrize("tilt", [0.0, 1e-9, 0.1])
def test_a_rod_on_its_head(tilt, recwarn):
    solution = fmb.statics(pendulum(tilt))
    (text,) = told(recwarn)
    assert solution.statistics["warnings"] == [text]
    seconds = float(text.partition("every ")[2].partition(" s;")[0])
    assert seconds == pytest.approx(np.sqrt(2.0 * (1.0 + 0.02**2 * 3 / 4) / (3.0 * 9.81)), rel=5e-3)
    assert "Body 'rod', rotation about its" in text


@pytest.mark.parametrize("down", [False, True])
def test_a_stiff_beam_on_its_head(down, recwarn):
    """Its own stiffness is 1e8 times that by its weight."""
    section = fem.Section.solid_circle(0.05)
    beam = fmb.AncfBeam(
        "b", points=((0, 0, 0), (0, 0, -1.0 if down else 1.0)), elements=2, section=section, material=STEEL
    )
    joint = fmb.Spherical("foot", markers=("ground.origin", "b.start"))
    fmb.statics(fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), beam], joints=[joint]))
    assert len(told(recwarn)) == (not down)


def test_a_rod_that_hangs(recwarn):
    """It turns freely about its own axis, which is no instability."""
    for tilt in (1.0, 2.0, np.pi):
        fmb.statics(pendulum(tilt))
    assert told(recwarn) == []


@pytest.mark.parametrize("part", [0.9, 1.1])
def test_a_column_beside_its_buckling_load(part, recwarn):
    """Clamped at its foot: pi^2 EI / (4 L^2)."""
    points, diameter = np.column_stack([np.linspace(0.0, 1.0, 13), np.zeros((13, 2))]), 0.01
    sets = {"a": [0], "b": [12]}
    fe = fem.frame(points, section=fem.Section.solid_circle(diameter), material=STEEL, node_sets=sets)
    data = reduction.reduce(fe, {"a": "a", "b": "b"}, 4, geometric_stiffness=True)
    load = part * np.pi**2 * 210e9 * np.pi * diameter**4 / 64.0 / 4.0
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("b", data=data)],
        joints=[fmb.Fixed("hold", markers=("ground.origin", "b.a"))],
        forces=[fmb.PointLoad("press", marker="b.b", force=(-load, 0.0, 0.0))],
    )
    fmb.statics(model)
    assert len(told(recwarn)) == (part > 1.0)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_in_any_unit_of_length(scale, recwarn):
    """A point mass between two springs that are pressed: it leaves their line where they push more than they hold."""

    def model(pressed):
        point = fmb.PointMass("m", mass=1.0, at=(scale, 0, 0))
        ends = fmb.Ground(markers={"a": (0, 0, 0), "b": (2.0 * scale, 0, 0)})
        springs = [
            fmb.SpringDamper(
                f"s{k}", markers=(f"ground.{k}", "m.center"), stiffness=1e3, length=scale * (1.0 + pressed)
            )
            for k in "ab"
        ]
        return fmb.Model(bodies=[ends, point], forces=springs)

    fmb.statics(model(-0.1))
    assert told(recwarn) == []
    fmb.statics(model(0.1))
    assert len(told(recwarn)) == 1
