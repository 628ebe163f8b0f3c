"""First-order states of forces: every integrator at its order, statics, linearisation, restart, storage.

Reference: a point of mass m on a spring k and a damper c in a row. With the elongation z of the damper,
m x'' = -k (x - z), z' = k / c (x - z) is linear, and its solution the matrix exponential.
"""

from __future__ import annotations

import numpy as np
import pytest
from maxwell_force import Maxwell
from scipy.linalg import expm
from tolerances import MACHINE, SOLVER

import flexmb as fmb
from flexmb.errors import ModelError

MASS, STIFFNESS, DAMPING, START = 2.0, 300.0, 8.0, 0.02
A = np.array([[0, 1, 0], [-STIFFNESS / MASS, 0, STIFFNESS / MASS], [STIFFNESS / DAMPING, 0, -STIFFNESS / DAMPING]])
X0 = np.array([0.1, 0.0, START])


def model(**more) -> fmb.Model:
    """Return the point between its spring and damper."""
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("p", mass=MASS, at=(0.1, 0, 0))],
        forces=[Maxwell("row", marker="p.center", stiffness=STIFFNESS, damping=DAMPING, start=START)],
        sensors=[fmb.State("damper", of="row"), fmb.Position("p", marker="p.center")],
        **more,
    )


def found(solution) -> np.ndarray:
    """Return position, velocity and state at the end."""
    final = solution.final
    return np.array([final.q[0], final.u[0], final.u[3]])


@pytest.mark.parametrize(
    ("integrator", "steps", "order"),
    [
        (fmb.GeneralizedAlpha, (0.01, 0.005), 2.0),
        (lambda step: fmb.GeneralizedAlpha(rho_inf=0.3, step=step), (0.01, 0.005), 2.0),
        (fmb.Implicit, (0.02, 0.01), 4.0),
    ],
)
def test_order_of_convergence(integrator, steps, order):
    """Errors of position, velocity and state fall with the order of the method."""
    exact = expm(A) @ X0
    errors = [
        np.abs(found(fmb.simulate(model(), t_end=1.0, integrator=integrator(step=h), samples=3)) - exact) for h in steps
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx([order] * 3, abs=0.06)


@pytest.mark.parametrize(
    ("integrator", "tolerance"),
    [
        (fmb.GeneralizedAlpha(rtol=1e-8), 1e-6),
        (fmb.Implicit(rtol=1e-8), 1e-8),
        (fmb.IDA(rtol=1e-8), 1e-7),
        (fmb.Explicit(rtol=1e-10), 1e-10),
        (fmb.Explicit(rtol=1e-10, formulation=fmb.Recursive()), 1e-10),
        (fmb.Explicit(rtol=1e-10, formulation=fmb.UdwadiaPhohomsiri()), 1e-9),
        (fmb.Explicit(rtol=1e-10, formulation=fmb.NullSpace()), 1e-9),
    ],
)
def test_error_control(integrator, tolerance):
    """States take part in the control of the error, and are read by their sensor."""
    solution = fmb.simulate(model(), t_end=1.0, integrator=integrator, samples=101)
    assert found(solution) == pytest.approx(expm(A) @ X0, abs=tolerance)
    exact = np.array([expm(A * t) @ X0 for t in solution.t])
    assert solution["damper"] == pytest.approx(exact[:, 2], abs=tolerance)
    between = solution.state(0.055)
    assert between.u[3] == pytest.approx((expm(A * 0.055) @ X0)[2], abs=1e-5)  # Hermite, 0.01 s between samples


def test_a_fast_state_sets_the_step():
    """A state that is faster than all bodies decides about the step size."""
    slow = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("p", mass=1e6, at=(0.1, 0, 0))],
        forces=[Maxwell("row", marker="p.center", stiffness=300.0, damping=0.3, start=0.0)],
        sensors=[fmb.State("damper", of="row")],
    )
    solution = fmb.simulate(slow, t_end=0.01, integrator=fmb.GeneralizedAlpha(rtol=1e-7), samples=11)
    assert solution["damper"] == pytest.approx(0.1 * (1.0 - np.exp(-1000.0 * solution.t)), abs=5e-6)


def test_linearisation_has_the_eigenvalues_of_the_states():
    """The poles are those of the equations by hand; two motions across are free, double zeros each."""
    still = fmb.statics(model())
    held = fmb.Model(
        bodies=[fmb.Ground(markers={"x": fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))}),
                fmb.RigidBody("p", mass=MASS, inertia=(1, 1, 1), markers={"x": fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))})],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "p.x"))],
        forces=[Maxwell("row", marker="p.center", stiffness=STIFFNESS, damping=2.0 * DAMPING),
                fmb.Actuator("spring", joint="rail", effort=fmb.table([-1, 1], [40, -40], of="rail"))],
    )  # fmt: skip
    k, c = STIFFNESS, 2.0 * DAMPING
    exact = np.linalg.eigvals(np.array([[0, 1, 0], [-(k + 40.0) / MASS, 0, k / MASS], [k / c, 0, -k / c]]))
    values = fmb.linearize(held).eigenvalues
    both = np.concatenate([values, values[values.imag > 0.0].conj()])
    assert np.sort_complex(both) == pytest.approx(np.sort_complex(exact), rel=1e-9)
    assert still.final.q[0] == pytest.approx(still.final.u[3], abs=1e-12)  # the spring is slack


def test_statics_settles_or_holds_states():
    """Where the rate of the state is zero the spring is slack; with the state held it pulls the point there."""
    held = fmb.statics(model(), hold_states=True)
    assert held.final.q[0] == pytest.approx(START, abs=1e-9)
    assert held.final.u[3] == START


def test_resume_and_files(tmp_path):
    """A run that continues, and one that is read again, have the states."""
    integrator = fmb.Explicit(rtol=1e-10)
    whole = fmb.simulate(model(), t_end=1.0, integrator=integrator, samples=11)
    half = fmb.simulate(model(), t_end=0.5, integrator=integrator, samples=6)
    assert fmb.resume(half, 1.0, integrator=integrator, samples=11)["damper"] == pytest.approx(
        whole["damper"], abs=1e-10
    )
    whole.save(tmp_path / "run.h5")
    assert fmb.Solution.load(tmp_path / "run.h5")["damper"] == pytest.approx(whole["damper"], rel=MACHINE)


def test_energy_of_a_force_with_states_is_accounted():
    """What the damper dissipates is known: the balance closes, and no warning comes."""
    solution = fmb.simulate(
        fmb.Model(
            bodies=model().bodies,
            forces=model().forces,
            sensors=[fmb.Energy("energy")],
        ),
        t_end=1.0,
        integrator=fmb.Implicit(rtol=1e-9),
        samples=101,
    )
    phase = solution.phases[0]
    given = phase.works @ (1.0, 1.0, -1.0)
    assert solution["energy"] - given == pytest.approx(np.full(101, solution["energy"][0]), abs=SOLVER)


def test_events_carry_states_on():
    """The phase after an event begins with the states of the one before."""
    split = model(events=[fmb.Event("look", at=0.3, then=fmb.Change("p", mass=MASS))])
    solution = fmb.simulate(split, t_end=1.0, integrator=fmb.Explicit(rtol=1e-10), samples=11)
    assert len(solution.phases) == 2
    assert found(solution) == pytest.approx(expm(A) @ X0, abs=1e-9)


def test_analyses_without_states_refuse_them_by_name():
    """A path of loads knows no states; and a sensor names what there is."""
    with pytest.raises(ModelError, match="Force 'row' has states of its own: damper"):
        fmb.statics(model(), t=1.0, path=fmb.LoadSteps(steps=2))
    wrong = fmb.Model(bodies=model().bodies, forces=model().forces, sensors=[fmb.State("z", of="rov")])
    with pytest.raises(ModelError, match="Did you mean 'row'"):
        fmb.simulate(wrong, t_end=0.01, samples=2)
