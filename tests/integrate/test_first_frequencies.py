"""The first frequencies of models of any size: chains with closed forms, through the sparse path and the dense one."""

import sys
import warnings

import numpy as np
import pytest
from scipy.special import roots_laguerre

import flexmb as fmb


def masses_on_springs(n, stiffness=1000.0):
    """n equal masses of 1 kg in a row, free at both ends: w_j = 2 sqrt(k / m) sin(j pi / 2 n), j = 0, 1, ..."""
    ground = fmb.Ground()
    masses = [fmb.PointMass(f"m{k}", mass=1.0, at=(0.1 * k, 0, 0)) for k in range(n)]
    springs = [
        fmb.SpringDamper(f"s{k}", markers=(f"m{k}.center", f"m{k + 1}.center"), stiffness=stiffness)
        for k in range(n - 1)
    ]
    return fmb.Model(bodies=[ground, *masses], forces=springs)


@pytest.mark.parametrize("n", [8, 150])
def test_masses_on_springs(n):
    """Two thirds of the freedoms have no stiffness."""
    found = fmb.first_frequencies(masses_on_springs(n))
    exact = 2.0 * np.sqrt(1000.0) * np.sin(np.arange(1, 7) * np.pi / (2 * n)) / (2 * np.pi)
    assert found.frequencies == pytest.approx(exact, rel=1e-6)
    assert found.more
    assert found.free == (None if n == 150 else found.free)
    assert "Hz (without damping; equal ones once)" in str(found) or n == 8


@pytest.mark.parametrize("n", [8, 150])
def test_the_report_of_check_stands_for_the_start(n, monkeypatch):
    model = masses_on_springs(n)
    report, exact = fmb.check(model), fmb.first_frequencies(model)
    if n == 150:  # small ones are linearised whole, from the start on
        module = sys.modules["flexmb.integrate.linear.first_frequencies"]
        monkeypatch.setattr(module, "assemble_as_drawn", lambda _: pytest.fail("assembled once more"))
    found = fmb.first_frequencies(model, about=report)
    assert np.array_equal(found.frequencies, exact.frequencies)
    assert (found.free, found.more) == (exact.free, exact.more)
    with pytest.raises(fmb.ModelError, match=r"report of another model, .*about=flexmb.check\(model\)"):
        fmb.first_frequencies(masses_on_springs(n), about=report)


def test_stiff_and_soft_parts_in_one_model():
    """Nine decades of stiffness; a mass that hangs on a soft spring has the lowest frequency."""
    chain = masses_on_springs(110, stiffness=1e9)
    soft = fmb.SpringDamper("soft", markers=("ground.far", "m0.center"), stiffness=1.0)
    ground = fmb.Ground(markers={"far": (-1, 0, 0)})
    model = fmb.Model(bodies=[ground, *chain.bodies[1:]], forces=[*chain.forces, soft])
    found = fmb.first_frequencies(model).frequencies
    assert found[0] == pytest.approx(np.sqrt(1.0 / 110.0) / (2 * np.pi), rel=1e-5)
    assert found[1] == pytest.approx(2.0 * np.sqrt(1e9) * np.sin(np.pi / 220) / (2 * np.pi), rel=1e-5)


@pytest.mark.parametrize("n", [12, 120])
def test_hanging_chain(n):
    """n equal masses on massless rods: w2 l / g are the zeros of the Laguerre polynomial of degree n (Lagrange)."""
    length, g = 0.1, 9.81
    masses = [fmb.PointMass(f"m{k}", mass=0.5, at=(0, 0, -length * (k + 1))) for k in range(n)]
    above = ["ground.top", *(f"{mass.name}.center" for mass in masses)]
    rods = [fmb.Rod(f"r{k}", markers=(above[k], above[k + 1])) for k in range(n)]
    model = fmb.Model(gravity=(0, 0, -g), bodies=[fmb.Ground(markers={"top": (0, 0, 0)}), *masses], joints=rods)
    found = fmb.first_frequencies(model).frequencies
    different = found[np.diff(found, prepend=-1.0) > 1e-6 * found]  # the small model lists both directions
    exact = np.sqrt(roots_laguerre(n)[0] * g / length) / (2 * np.pi)
    assert different == pytest.approx(exact[: len(different)], rel=1e-6)
    assert len(different) == (6 if n == 120 else 3)


@pytest.mark.parametrize("n", [12, 120])
def test_a_drive_that_is_about_to_start_changes_no_equilibrium(n):
    """The hanging chain on a carriage that begins to rise with 8 m/s2: the equilibrium knows g alone, in both paths."""
    length, g = 0.1, 9.81
    masses = [fmb.PointMass(f"m{k}", mass=0.5, at=(0, 0, -length * (k + 1))) for k in range(n)]
    carriage = fmb.RigidBody("carriage", mass=1.0, inertia=(1, 1, 1), at=(0, 0, 0))
    above = ["carriage.center", *(f"{mass.name}.center" for mass in masses)]
    rods = [fmb.Rod(f"r{k}", markers=(above[k], above[k + 1])) for k in range(n)]
    guide = fmb.Prismatic("guide", markers=("ground.origin", "carriage.center"))
    lift = fmb.Drive("lift", joint="guide", displacement=fmb.expression("4*t**2"))
    model = fmb.Model(gravity=(0, 0, -g), bodies=[fmb.Ground(), carriage, *masses], joints=[guide, *rods, lift])
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.ValidityWarning)
        found = fmb.first_frequencies(model, about=fmb.statics(model)).frequencies
    exact = np.sqrt(roots_laguerre(n)[0] * g / length) / (2 * np.pi)
    different = found[np.diff(found, prepend=-1.0) > 1e-6 * found]
    assert different == pytest.approx(exact[: len(different)], rel=1e-6)
    assert len(different) == (6 if n == 120 else 3)


def test_a_large_model_without_stiffness():
    bodies = [fmb.RigidBody(f"b{k}", mass=1.0, inertia=(1, 1, 1), at=(k, 0, 0)) for k in range(60)]
    found = fmb.first_frequencies(fmb.Model(bodies=bodies))
    assert len(found.frequencies) == 0
    assert str(found) == "none found"
