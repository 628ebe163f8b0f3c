"""Work of loads that follow a place: what a spring of the same stiffness stores, in closed form."""

import warnings

import numpy as np
import pytest

import flexmb as fmb
from flexmb.system import compile as compile_model
from flexmb.system.accelerations import accelerations

STIFFNESS, SPEED = 100.0, 0.1  # of 1 kg: 10 rad/s
PERIODS = 8
END = PERIODS * 2.0 * np.pi / 10.0

LOADS = {
    "measured": lambda: fmb.Actuator("motor", joint="rail", effort=-STIFFNESS * fmb.measured("x")),
    "table": lambda: fmb.Actuator("motor", joint="rail", effort=fmb.table([-1.0, 1.0], [100.0, -100.0], of="rail")),
    "servo": lambda: fmb.Motor("motor", joint="rail", target=0.0, stiffness=STIFFNESS, damping=1e-9),
    "Python": lambda: fmb.UserForce(
        "motor", markers=("ground.x", "m.x"), function=lambda t, d, v, R, w: (-STIFFNESS * d, (0.0, 0.0, 0.0))
    ),
    "at a point": lambda: fmb.PointLoad("pull", marker="m.x", force=(-STIFFNESS * fmb.measured("x"), 0.0, 0.0)),
}


def model(load) -> fmb.Model:
    """Return a mass on a rail that is pulled back to where it starts with a speed."""
    along = fmb.Pose.axes(z=(1, 0, 0))
    mass = fmb.RigidBody("m", mass=1.0, inertia=(1, 1, 1), at=(0, 0, 0), velocity=(SPEED, 0, 0), markers={"x": along})
    return fmb.Model(
        bodies=[fmb.Ground(markers={"x": along}), mass],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "m.x"))],
        forces=[LOADS[load]()],
        sensors=[fmb.JointCoordinate("x", joint="rail")],
    )


def largest_error(solution) -> float:
    """Return by how much the work of the load errs, relative to the energy: it is -k x^2 / 2."""
    x = solution["x"]
    x = x if x.ndim == 1 else x[:, 0]
    work = np.concatenate([phase.works[:, 0] for phase in solution.phases])
    return float(np.max(np.abs(work + 0.5 * STIFFNESS * x**2)) / (0.5 * SPEED**2))


@pytest.mark.parametrize("load", LOADS)
def test_work_of_a_load_that_follows_a_place(load):
    """Evaluated before the last correction of a step it would err by 2.45 %, with a warning of lost energy."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solution = fmb.simulate(model(load), t_end=END, integrator=fmb.GeneralizedAlpha())
    assert largest_error(solution) < 4e-3


def test_a_single_load_that_follows_accelerations_is_solved():
    """The root of a + 2 a^3 = 5 by Newton's method, with the sweeps of linear equations asked for."""
    body = fmb.RigidBody("m", mass=1.0, inertia=(1, 1, 1))
    measured = fmb.measured("acceleration ax")
    pull = fmb.PointLoad("pull", marker="m.center", force=(fmb.formula("5 - 2*a*a*a", over={"a": measured}), 0, 0))
    sensor = fmb.Acceleration("acceleration", marker="m.center")
    system = compile_model(fmb.Model(bodies=[fmb.Ground(), body], forces=[pull], sensors=[sensor]))
    state, work = system.state(), system.workspace()
    assert accelerations(system.program, state, work, np.zeros(system.nu + system.ng), 2) < 0
    assert state.a[0] == pytest.approx(max(np.roots([2.0, 0.0, 1.0, -5.0]).real), rel=1e-12)
