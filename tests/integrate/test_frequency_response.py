"""Frequency response against closed forms, its agreement with the state space, and Campbell diagrams."""

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.results import recover

LENGTH, SIDE = 1.0, 0.01
STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
EI, RHO_A = STEEL.young * SIDE**4 / 12, STEEL.density * SIDE**2


def oscillator(k=400.0, d=3.0, m=2.0):
    slide = fmb.Pose.axes((0, 0, 0), z=(0, 0, 1), x=(1, 0, 0))
    ball = fmb.RigidBody("ball", mass=m, inertia=(1, 1, 1), markers={"a": slide})
    return fmb.Model(
        bodies=[fmb.Ground(markers={"a": slide, "above": (0, 0, 1)}), ball],
        joints=[fmb.Prismatic("guide", markers=("ground.a", "ball.a"))],
        forces=[
            fmb.SpringDamper("spring", markers=("ground.above", "ball.center"), stiffness=k, damping=d, length=1.0)
        ],
    )


def test_one_freedom():
    """H = 1 / (k - m w^2 + i w d)."""
    k, d, m = 400.0, 3.0, 2.0
    frequencies = np.array([0.0, 1.0, np.sqrt(k / m) / (2 * np.pi), 5.0])
    w = 2 * np.pi * frequencies
    found = fmb.linearize(oscillator(k, d, m)).frequency_response(frequencies, "ball.center", "ball.center")
    np.testing.assert_allclose(found[:, 2, 2], 1.0 / (k - m * w**2 + 1j * w * d), rtol=1e-9)
    np.testing.assert_allclose(found[:, 0, 0], 0.0, atol=1e-15)


def cantilever(modes=8, damping=0.0):
    fe = fem.frame(
        np.linspace([0, 0, 0], [LENGTH, 0, 0], 41),
        section=fem.Section.rectangle(SIDE, SIDE),
        material=STEEL,
        shear=False,
        rotary_inertia=False,
    )
    data = reduction.reduce(fe, {"root": "start", "tip": "end"}, modes, stress=False)
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("beam", data=data, damping=damping)],
        joints=[fmb.Fixed("clamp", markers=("ground.origin", "beam.root"))],
    )


def tip_receptance(frequency):
    """Bishop & Johnson, The Mechanics of Vibration (1960), table 7.1: tip of a clamped beam, force at the tip."""
    b = np.sqrt(2 * np.pi * frequency) * (RHO_A / EI) ** 0.25
    x = b * LENGTH
    return (np.sin(x) * np.cosh(x) - np.cos(x) * np.sinh(x)) / (EI * b**3 * (1 + np.cos(x) * np.cosh(x)))


def test_cantilever():
    """Between the resonances and at the antiresonances, up to the third mode (143 Hz)."""
    frequencies = np.array([2.0, 12.0, 30.0, 45.0, 80.0, 120.0])
    found = fmb.linearize(cantilever(16)).frequency_response(frequencies, "beam.tip", "beam.tip")
    np.testing.assert_allclose(found[:, 2, 2].real, tip_receptance(frequencies), rtol=2e-3)
    np.testing.assert_allclose(found[:, 1, 1].real, tip_receptance(frequencies), rtol=2e-3)  # a square section
    linear = fmb.linearize(cantilever())
    zero = brentq(tip_receptance, 20.0, 50.0)
    below, above = linear.frequency_response([0.999 * zero, 1.001 * zero], "beam.tip", "beam.tip")[:, 2, 2].real
    assert below * above < 0.0


def test_state_space_says_the_same():
    linear = fmb.linearize(cantilever(4, damping=0.02))
    A, B, C, D = linear.state_space
    s = 2j * np.pi * 40.0
    H = (
        linear.motion_of("beam.tip")
        @ (C @ np.linalg.solve(s * np.eye(len(A)) - A, B) + D)
        @ linear.force_on("beam.tip")
    )
    np.testing.assert_allclose(
        linear.frequency_response(40.0, "beam.tip", "beam.tip")[0], H, rtol=0, atol=1e-8 * np.abs(H).max()
    )


def test_reciprocity():
    """Maxwell and Betti: the rotation at a by a force at b is the displacement at b by a moment at a."""
    linear = fmb.linearize(cantilever(6))
    there = linear.frequency_response([25.0], "beam.tip", "beam.tip")[0]
    np.testing.assert_allclose(there, there.T, rtol=0, atol=1e-9 * np.abs(there).max())


def test_unknown_marker():
    with pytest.raises(fmb.ModelError, match=r"marker 'beam.tap' does not exist.*Did you mean 'beam.tip'"):
        fmb.linearize(cantilever(0)).frequency_response([1.0], "beam.tap", "beam.tip")


def shaft(speed):
    """A square shaft, clamped in a bearing that turns it about its own axis."""
    axis = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 1, 0))
    clamped = cantilever(4)
    body = clamped.bodies[1].replaced(markers={"root": axis})
    return fmb.Model(
        bodies=[fmb.Ground(markers={"bearing": axis}), body],
        joints=[
            fmb.Revolute("bearing", markers=("ground.bearing", "beam.root")),
            fmb.Drive("spin", joint="bearing", angle=fmb.expression("w * t", w=speed)),
        ],
    )


def test_campbell_of_a_shaft():
    """In the turning frame p + W and |p - W|; a force fixed in space meets p - W = W at half the first frequency."""
    p = 1.87510407**2 * np.sqrt(EI / RHO_A / LENGTH**4)
    diagram = fmb.campbell(shaft, np.linspace(0.02, 0.8, 14) * p, modes=2)
    expected = np.column_stack([p - diagram.speeds, p + diagram.speeds])
    np.testing.assert_allclose(np.sort(2 * np.pi * diagram.frequencies, axis=1), expected, rtol=2e-3)
    assert np.all(np.diff(diagram.frequencies, axis=0) * [-1, 1] > 0)  # modes keep their columns
    ((mode, speed),) = diagram.critical(order=1)
    assert mode == 0
    assert speed == pytest.approx(p / 2, rel=2e-3)
    assert diagram.stable.all()


def test_campbell_messages():
    with pytest.raises(fmb.ModelError, match="at least two, increasing"):
        fmb.campbell(shaft, [1.0])


def test_section_forces_of_a_loaded_beam():
    """M = F (L - x), V = F: statics under a tip force, everywhere in the beam."""
    fe = fem.frame(np.linspace([0, 0, 0], [LENGTH, 0, 0], 5), section=fem.Section.rectangle(SIDE, SIDE), material=STEEL)
    data = reduction.reduce(fe, {"root": "start", "tip": "end"}, 0, frame="root")
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("beam", data=data)],
        joints=[fmb.Fixed("clamp", markers=("ground.origin", "beam.root"))],
        forces=[fmb.PointLoad("F", marker="beam.tip", force=(0, 1e-3, 0))],
    )
    eta = fmb.statics(model).final.q[7:]
    (forces,) = recover.section_forces(data, eta, fe.blocks[0])
    ends = np.column_stack([np.linspace(0, 0.75, 4), np.linspace(0.25, 1, 4)])
    np.testing.assert_allclose(forces[:, :, 1], 1e-3, rtol=1e-6)
    np.testing.assert_allclose(forces[:, :, 5], 1e-3 * (LENGTH - ends), rtol=0, atol=1e-9)
    work = 1e-3**2 * LENGTH**3 / (6 * EI)  # F delta / 2, delta = F L^3 / (3 E I)
    assert recover.strain_energy(data, eta) == pytest.approx(work, rel=1e-3)
    with pytest.raises(fmb.ModelError, match="has no section forces"):
        recover.section_forces(data, eta, None)
