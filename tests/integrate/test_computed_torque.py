"""An arm of ten links whose torques come from outside every millisecond: errors fall as those of a linear system."""

import numpy as np
import pytest

import flexmb as fmb

N, LENGTH, MASS, GRAVITY = 10, 0.3, 1.0, 9.81
INERTIA = MASS * LENGTH**2 / 12.0
STIFFNESS, DAMPING = 400.0, 40.0
SUMS = np.tril(np.ones((N, N)))
"""Of joint angles: the angles of the links against the ground."""


def arm() -> fmb.Model:
    """Return ten rods in a row along x, on hinges about y, each driven by an input."""

    def hinge(at):
        return fmb.Pose.axes((at, 0, 0), z=(0, 1, 0))

    bodies, joints, forces, sensors = [fmb.Ground(markers={"o": hinge(0.0)})], [], [], []
    for k in range(N):
        ends = {"a": hinge(-0.5 * LENGTH), "b": hinge(0.5 * LENGTH)}
        at = ((k + 0.5) * LENGTH, 0, 0)
        bodies.append(fmb.RigidBody(f"l{k}", mass=MASS, inertia=(1e-3, INERTIA, INERTIA), at=at, markers=ends))
        joints.append(fmb.Revolute(f"j{k}", markers=(f"l{k - 1}.b" if k else "ground.o", f"l{k}.a")))
        forces.append(fmb.Actuator(f"m{k}", joint=f"j{k}", effort=fmb.input(f"t{k}")))
        sensors += [fmb.JointCoordinate(f"q{k}", joint=f"j{k}"), fmb.AngularVelocity(f"w{k}", marker=f"l{k}.a")]
    return fmb.Model(bodies=bodies, joints=joints, forces=forces, sensors=sensors, gravity=(0, 0, -GRAVITY))


def torques(q: np.ndarray, w: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Return the torques (N m) by the closed form of a chain in a plane; w: speeds of the links against the ground."""
    beyond = N - 1.0 - np.arange(N)
    coupling = MASS * LENGTH**2 * (np.minimum.outer(beyond, beyond) + np.where(np.eye(N) == 1, 0.25, 0.5))
    angles = SUMS @ q
    between = angles[:, None] - angles[None]
    wanted = SUMS @ (STIFFNESS * (goal - q) - DAMPING * np.diff(w, prepend=0.0))
    inertia = (coupling * np.cos(between) + INERTIA * np.eye(N)) @ wanted
    weight = MASS * GRAVITY * LENGTH * (beyond + 0.5) * np.cos(angles)
    return SUMS.T @ (inertia + (coupling * np.sin(between)) @ w**2 - weight)


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(step=1e-3), fmb.Explicit()], ids=repr)
def test_errors_fall_as_those_of_a_linear_system(integrator):
    """e'' + 40 e' + 400 e = 0: e = e0 (1 + 20 t) exp(-20 t), but for the delay of half a sample."""
    goal = 0.2 * np.cos(np.arange(N))
    with fmb.stepper(arm(), integrator=integrator, t_end=1.0, keep=False) as run:
        for k in range(100):
            q, w = (np.array([run[f"{name}{i}"] for i in range(N)]) for name in "qw")
            run.set({f"t{i}": float(x) for i, x in enumerate(torques(q, w[:, 1], goal))})
            run.advance(to=1e-3 * (k + 1))
        left = goal - np.array([run[f"q{i}"] for i in range(N)])
    assert left == pytest.approx(goal * 3.0 * np.exp(-2.0), rel=0.02)
