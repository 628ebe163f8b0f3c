"""Sensors, solution file and ParaView files of simulated mechanisms: laws of mechanics that hold between sensors."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import pyvista
from scipy.integrate import cumulative_simpson
from tolerances import MACHINE, SOLVER

import flexmb as fmb
from flexmb import fem, io, reduction
from flexmb.results import Solution
from flexmb.results.run_file import ROWS
from flexmb.system import observe


@pytest.fixture(scope="module")
def beam():
    """An aluminium strip 1 m long in ten beam elements, two ends as interfaces."""
    section = fem.Section.rectangle(0.02, 0.03)
    points = np.stack([np.linspace(0, 1, 11), np.zeros(11), np.zeros(11)], 1)
    material = fmb.Material(young=70e9, poisson=0.3, density=2700.0)
    fe = fem.frame(points=points, section=section, material=material)
    return reduction.reduce(fe, interfaces={"root": [0], "tip": [10]}, modes=4, stations={"mid": (0.5, 0, 0)})


@pytest.fixture(scope="module")
def pendulum(beam):
    """A flexible pendulum with a mass at its tip, driven sideways by a spring; gravity along -y."""
    model = fmb.Model(
        name="pendulum",
        gravity=(0, -9.81, 0),
        bodies=[
            fmb.Ground(markers={"hinge": (0, 0, 0), "far": (2.0, 0.5, 0.3)}),
            fmb.FloatingBody("beam", data=beam),
            fmb.PointMass("ball", mass=0.5, at=(1, 0, 0)),
        ],
        joints=[
            fmb.Revolute("hinge", markers=("ground.hinge", "beam.root")),
            fmb.Spherical("ball joint", markers=("beam.tip", "ball.center")),
        ],
        forces=[
            fmb.SpringDamper("spring", markers=("ground.far", "beam.mid"), stiffness=4000.0, damping=2.0, length=1.0)
        ],
        sensors=[
            fmb.Position("r", marker="beam.tip"),
            fmb.Velocity("v", marker="beam.tip"),
            fmb.Acceleration("a", marker="beam.tip"),
            fmb.Reaction("hinge", joint="hinge"),
            fmb.Reaction("ball joint", joint="ball joint"),
            fmb.ForceOf("spring", force="spring"),
            fmb.Momentum("momentum"),
            fmb.Energy("total"),
            fmb.Energy("dissipated", kind="dissipated"),
            fmb.Deflection("bow", marker="beam.mid"),
            fmb.JointCoordinate("angle", joint="hinge"),
            fmb.ConstraintError("g"),
            fmb.Orientation("p", marker="beam.tip"),
        ],
    )
    # samples every 20 microseconds: the integrals below see the body's highest modes, at 10 kHz
    return fmb.simulate(model, t_end=0.04, samples=2001, integrator=fmb.GeneralizedAlpha(rtol=1e-8))


def integral(values, t):
    return cumulative_simpson(values, x=t, axis=0, initial=0.0)


def test_velocity_is_the_derivative_of_position(pendulum):
    t = pendulum.t
    np.testing.assert_allclose(pendulum["r"], pendulum["r"][0] + integral(pendulum["v"], t), rtol=0, atol=1e-6)
    np.testing.assert_allclose(pendulum["v"], pendulum["v"][0] + integral(pendulum["a"], t), rtol=0, atol=1e-4)


def test_newton_for_the_ball(pendulum):
    """m a = reaction + m g: acceleration and reaction are evaluated on different ways."""
    weight = 0.5 * np.array([0, -9.81, 0])
    force = 0.5 * pendulum["a"] - weight
    np.testing.assert_allclose(pendulum["ball joint"][:, :3], force, rtol=0, atol=1e-3 * np.abs(force).max())


def test_momentum_follows_the_external_loads(pendulum):
    """P(t) - P(0) = int F dt and L(t) - L(0) = int (r x F + M) dt, flexible body included."""
    t, model = pendulum.t, pendulum.model
    mass = model.body("beam").data.mass
    weight = (mass + 0.5) * np.array([0, -9.81, 0])
    hinge, spring = pendulum["hinge"], pendulum["spring"]
    P = integral(hinge[:, :3] + spring[:, :3] + weight, t)
    scale = np.abs(P).max()
    momentum = pendulum["momentum"] - pendulum["momentum"][0]
    np.testing.assert_allclose(momentum[:, :3], P, rtol=0, atol=2e-3 * scale)
    mid = pendulum[fmb.Position("mid", marker="beam.mid")]
    L = integral(np.cross(mid, spring[:, :3]) + spring[:, 3:] + hinge[:, 3:], t)
    # the moment of the weight acts at the centre of mass, which moves with the modes
    ser = pendulum.series()
    q, _ = ser.coordinates("beam")
    R = fmb.results.recover.rotation_matrices(q[:, 3:7])
    I = model.body("beam").reduced.invariants
    first = model.body("beam").data.mass * model.body("beam").data.center_of_mass + q[:, 7:] @ I.vn.T
    moment = np.cross(np.einsum("tij,tj->ti", R, first) + mass * q[:, :3] + 0.5 * pendulum["r"], (0, -9.81, 0))
    L += integral(moment, t)
    np.testing.assert_allclose(momentum[:, 3:], L, rtol=0, atol=2e-3 * np.abs(L).max())


def test_energy_balance(pendulum):
    change = pendulum["total"] - pendulum["total"][0] + pendulum["dissipated"]
    kinetic = pendulum[fmb.Energy("kinetic", kind="kinetic")]
    assert np.abs(change).max() < 1e-4 * kinetic.max()
    assert pendulum["g"].max() < 1e-9


def test_deflection_by_markers_and_by_modes(pendulum):
    body = pendulum.model.body("beam").reduced
    shape = body.marker_translations[body.marker_names.index("mid")]
    modal = pendulum.series().modal_coordinates("beam") @ shape.T
    np.testing.assert_allclose(pendulum["bow"], modal, rtol=0, atol=MACHINE)
    assert np.abs(modal).max() > 1e-4


def test_turns_are_counted(beam):
    """Twelve turns at 40 samples are told from the angular velocity at the samples."""
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"O": (0, 0, 0)}), fmb.RigidBody.rod("rod", length=1.0, mass=1.0, radius=0.02)],
        joints=[
            fmb.Revolute("hinge", markers=("ground.O", "rod.start")),
            fmb.Drive("motor", joint="hinge", angle=fmb.ramp(rate=75.0, rise=0.1)),
        ],
        sensors=[fmb.JointCoordinate("angle", joint="hinge")],
    )
    solution = fmb.simulate(model, t_end=1.05, samples=9)
    assert solution["angle"][-1] == pytest.approx(75.0, rel=SOLVER)
    assert np.diff(solution["angle"]).max() > 9.0


def test_written_while_simulating_and_read_back(pendulum, tmp_path):
    """The file that `simulate` streams gives the same solution, and its model runs the same sensors."""
    path = tmp_path / "run.h5"
    live = fmb.simulate(pendulum.model, t_end=0.02, samples=21, output=path, write_model=io.model_text)
    loaded = Solution.load(path, read_model=io.read_model_text)
    assert loaded.status == live.status
    np.testing.assert_array_equal(loaded.phases[0].q, live.phases[0].q)
    for name in live.sensor_names:
        np.testing.assert_array_equal(loaded[name], live[name])
    again = loaded[fmb.Deflection("again", marker="beam.mid")]
    np.testing.assert_allclose(again, live["bow"], rtol=0, atol=MACHINE)


def test_the_state_between_samples_fulfils_the_constraints(pendulum):
    """The cubic state lies on the constraints to the order of the interpolation."""
    middle = pendulum.state(0.5 * (pendulum.t[500] + pendulum.t[501]))
    arrays = (x[None] for x in (middle.q, middle.u, middle.a, middle.lam))
    seen = observe(pendulum.phases[0].system, [middle.t], *arrays)
    assert seen.constraint_error[0, 0] < 1e-9


@pytest.mark.slow
def test_killed_simulation_leaves_a_readable_file(beam, tmp_path):
    """The process dies in mid-run; all but the last 256 samples at most are there."""
    beam.save(tmp_path / "beam.h5")
    code = f"""
import flexmb as fmb
from flexmb import io
beam = fmb.ModalNeutralData.load({str(tmp_path / "beam.h5")!r})
model = fmb.Model(gravity=(0, -9.81, 0),
                  bodies=[fmb.Ground(markers={{"O": (0, 0, 0)}}), fmb.FloatingBody("beam", data=beam)],
                  joints=[fmb.Revolute("hinge", markers=("ground.O", "beam.root"))],
                  sensors=[fmb.Position("tip", marker="beam.tip")])
fmb.simulate(model, t_end=1000.0, samples=10_000_001, output={str(tmp_path / "run.h5")!r}, write_model=io.model_text,
             integrator=fmb.GeneralizedAlpha(step=1e-4), progress=lambda t, t_end: print(t, flush=True))
"""
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={**os.environ})
    seen = 0.0
    while seen < 0.1:
        seen = float(child.stdout.readline())
    child.send_signal(signal.SIGKILL)
    child.wait()
    child.stdout.close()
    solution = Solution.load(tmp_path / "run.h5", read_model=io.read_model_text)
    assert solution.status.kind == "interrupted"
    assert solution.t[-1] >= seen - ROWS * 1e-4
    tip = solution["tip"]
    assert np.linalg.norm(tip[-1]) == pytest.approx(1.0, abs=0.02)


def test_export_of_a_simulation(pendulum, tmp_path):
    """The nodes that ParaView shows at the ends of the beam are where the markers are."""
    short = Solution(phases=pendulum.phases)
    reader = pyvista.get_reader(fmb.write_vtk(short, tmp_path / "pendulum.pvd", every=1000))
    reader.set_active_time_value(reader.time_values[1])
    beam = reader.read()[0]
    k = int(np.argmin(np.abs(pendulum.t - reader.time_values[1])))
    np.testing.assert_allclose(beam.points[10], pendulum["r"][k], rtol=0, atol=1e-6)
    assert np.abs(beam["displacement"]).max() > 1e-5


def test_what_acts_at_a_marker_is_of_joints_drives_and_forces_on_joints():
    """A rod of 3 kg and 2 m, held level by a drive that a spring on the same hinge helps: m g and m g L / 2 in all."""
    rod = fmb.RigidBody.rod("rod", length=2.0, mass=3.0)
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), rod],
        joints=[
            fmb.Revolute("hinge", markers=("ground.origin", "rod.start")),
            fmb.Drive("motor", joint="hinge", angle=0.0),
        ],
        forces=[fmb.TorsionSpring("spring", joint="hinge", stiffness=50.0, free_angle=0.1)],
    )
    series = fmb.simulate(model, 0.1, samples=3).series()
    every, of_joints, _ = series.wrenches(["rod.start", "ground.origin"])
    weight, spring = 3.0 * 9.81, 50.0 * 0.1
    held = np.array([0.0, weight, 0.0, 0.0, 0.0, weight])
    np.testing.assert_allclose(every[-1, 0], held, atol=1e-6)
    np.testing.assert_allclose(of_joints[-1, 0], held - np.array([0, 0, 0, 0, 0, spring]), atol=1e-6)
    np.testing.assert_allclose(every[:, 1], -every[:, 0], atol=1e-6)
