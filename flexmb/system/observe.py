"""`observe`: what markers, joints and forces did at every sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from flexmb.math.kernel import entry_kernel, inner_kernel
from flexmb.math.program import PROGRAM
from flexmb.math.structures import ArrayOf, FloatRows, array_type, numba_type, structure
from flexmb.math.tables import FLOATS, INTEGERS, WORK, State, call_row_kernel
from flexmb.math.weights import no_matrix
from flexmb.system.program import constraint_acceleration, constraint_velocity, energies, evaluate
from flexmb.system.system import System

__all__ = ["Observation", "observe", "observe_samples", "observe_signals", "observe_wrenches"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Observation:
    """Quantities over time; nm markers, nj joints, nf forces.

    Parameters
    ----------
    r, v, w, a, alpha : (nt, nm, 3)
        Position, velocity, angular velocity, acceleration, angular acceleration of every marker, in W (m, s, rad).
    R : (nt, nm, 3, 3)
        Axes of every marker in W.
    reaction : (nt, nj, 6), N and N m
        What each joint exerts on the body of its second marker, at that marker, in W.
    force : (nt, nf, 6), N and N m
        What each force exerts on the body of the marker at which it is measured, in W.
    energy : (nt, 3), J
        Kinetic, strain and potential energy (of gravity and springs).
    constraint_error : (nt, 3), m or rad, per s, per s2
        Largest residual of all equations, of positions, velocities and accelerations.
    """

    r: np.ndarray
    R: np.ndarray
    v: np.ndarray
    w: np.ndarray
    a: np.ndarray
    alpha: np.ndarray
    reaction: np.ndarray
    force: np.ndarray
    energy: np.ndarray
    constraint_error: np.ndarray


@structure
class Observed(NamedTuple):
    """What `observe_samples` writes of nt samples, see `Observation`."""

    r: Annotated[np.ndarray, ArrayOf(float, 3)]
    """(nt, nm, 3) m"""
    R: Annotated[np.ndarray, ArrayOf(float, 4)]
    """(nt, nm, 3, 3)"""
    motion: Annotated[np.ndarray, ArrayOf(float, 3)]
    """(nt, nm, 12) v, w, a, alpha"""
    reaction: Annotated[np.ndarray, ArrayOf(float, 3)]
    """(nt, nj, 6)"""
    force: Annotated[np.ndarray, ArrayOf(float, 3)]
    """(nt, nf, 6)"""
    energy: FloatRows
    """(nt, 3) J"""
    error: FloatRows
    """(nt, 3)"""


@inner_kernel
def _observe_markers(work, acceleration, k, seen):
    """Write the marker kinematics of sample k."""
    r, R, motion = seen.r, seen.R, seen.motion
    for m in range(len(work.markers)):
        marker = work.markers[m]
        for i in range(3):
            r[k, m, i] = marker.r[i]
            for j in range(3):
                R[k, m, i, j] = marker.R[i, j]
            motion[k, m, i] = marker.v[i]
            motion[k, m, 3 + i] = marker.w[i]
        for i in range(6):
            total = marker.bias[i]
            start = marker.iJ + i * marker.nu
            for j in range(marker.nu):
                total += work.J[start + j] * acceleration[marker.iu + j]
            motion[k, m, 6 + i] = total


@inner_kernel
def _observe_errors(work, u, a, left, error):
    """Write the largest residuals of the equations, their rates and second rates to `error` (3,)."""
    for n in range(len(left)):
        error[0] = max(error[0], abs(work.equations[n].g))
    constraint_velocity(work, u, left)
    for n in range(len(left)):
        error[1] = max(error[1], abs(left[n]))
    constraint_acceleration(work, a, left)
    for n in range(len(left)):
        error[2] = max(error[2], abs(left[n]))


@entry_kernel(
    PROGRAM,
    WORK,
    array_type(FLOATS),
    *[array_type(FLOATS, 2)] * 5,
    *[array_type(INTEGERS)] * 2,
    array_type(INTEGERS, 2),
    array_type(INTEGERS),
    numba_type(Observed),
)
def observe_samples(program, work, t, q, u, a, lam, signals, second, joint_of, single, measured, seen):
    """Evaluate every sample; `single` (nf, 3) is (kind, first byte, last byte) of every force's own row."""
    left = np.empty(len(work.equations))
    for k in range(len(t)):
        state = State(t[k], q[k], u[k], a[k], lam[k], signals)
        energies(program, state, work)
        _observe_markers(work, a[k], k, seen)
        stored = work.energy[0]
        energy = seen.energy[k]
        energy[0], energy[1], energy[2] = stored.kinetic, stored.strain, stored.potential
        _observe_errors(work, u[k], a[k], left, seen.error[k])
        for n in range(len(work.legs)):
            leg = work.legs[n]
            joint = joint_of[leg.equation]
            if leg.marker == second[joint]:
                for i in range(6):
                    seen.reaction[k, joint, i] += leg.gradient[i] * work.equations[leg.equation].force
        for f in range(len(measured)):
            if measured[f] < 0:
                continue
            wrench = work.markers[measured[f]].wrench
            for i in range(6):
                wrench[i] = 0.0
            rows = program.raw[single[f, 1] : single[f, 2]]
            call_row_kernel(program.forces[single[f, 0]], rows, program.bulk, state, work)
            for i in range(6):
                seen.force[k, f, i] = wrench[i]


def observe(system: System, t, q, u, a, lam, works=None) -> Observation:
    """Return what every marker, joint and force did at the given samples.

    Parameters
    ----------
    system : System
    t : (nt,), s
    q : (nt, nq); u, a : (nt, nu); lam : (nt, ng)
    """
    model = system.model
    work = system.workspace()
    nt, nm = len(t), len(work.markers)
    seen = Observed(
        r=np.zeros((nt, nm, 3)),
        R=np.zeros((nt, nm, 3, 3)),
        motion=np.zeros((nt, nm, 12)),
        reaction=np.zeros((nt, len(model.joints), 6)),
        force=np.zeros((nt, len(model.forces), 6)),
        energy=np.zeros((nt, 3)),
        error=np.zeros((nt, 3)),
    )
    second = np.array([system.marker_index[j.resolved_markers(model)[1]] for j in model.joints], np.int64)
    joint_of = np.zeros(system.ng, np.int64)
    for name, span in system.joint_equations.items():
        joint_of[span] = system.joint_index[name]
    measured = np.full(len(model.forces), -1, np.int64)
    for k, part in enumerate(model.forces):
        marker = part.measure(model)
        if marker is not None:
            measured[k] = system.marker_index[marker]
    signals = np.zeros((max(1, system.n_signals), 3))
    # a stored run may be read with a model that has other sensors, which follow other turns: see System.state
    missing = [] if np.shape(q)[1] >= system.nq else [np.tile(system.q0[np.shape(q)[1] :], (nt, 1))]
    arrays = [np.ascontiguousarray(x, float) for x in (t, np.hstack([q, *missing])[:, : system.nq], u, a, lam)]
    observe_samples(system.program, work, *arrays, signals, second, joint_of, system.force_rows, measured, seen)
    return Observation(
        r=seen.r,
        R=seen.R,
        v=seen.motion[..., 0:3],
        w=seen.motion[..., 3:6],
        a=seen.motion[..., 6:9],
        alpha=seen.motion[..., 9:12],
        reaction=seen.reaction,
        force=seen.force,
        energy=seen.energy,
        constraint_error=seen.error,
    )


def observe_signals(system: System, t, q, u, a, lam) -> np.ndarray:
    """Return the values of all signals (nt, ns), of time and of what is measured, at the given samples."""
    work, found = system.workspace(), np.zeros((len(t), max(1, system.n_signals)))
    no_matrix(work.weights)
    for k in range(len(t)):
        state = system.state(t[k], q[k], u[k], a[k], lam[k])
        evaluate(system.program, state, work)
        found[k] = state.signals[:, 0]
    return found


def observe_wrenches(system: System, markers, t, q, u, a, lam) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what acts at markers (nt, n, 6), N and N m, in W at the marker, and the part of it that joints exert; and
    the amounts of all load shapes (nt, n_loads).

    Parameters
    ----------
    markers : (n,)
        Numbers of markers.
    t, q, u, a, lam
        As in `observe`.
    """
    work, places = system.workspace(), np.array(markers, np.int64)
    every, of_joints = np.zeros((2, len(t), len(places), 6))
    loads = np.zeros((len(t), len(work.loads)))
    own = np.isin(work.legs["marker"], places)
    equations, row = work.legs["equation"][own], np.argmax(work.legs["marker"][own, None] == places, axis=1)
    no_matrix(work.weights)
    for k in range(len(t)):
        evaluate(system.program, system.state(t[k], q[k], u[k], a[k], lam[k]), work)
        every[k] = work.markers["wrench"][places]
        by_leg = work.legs["gradient"][own] * work.equations["force"][equations, None]
        np.add.at(of_joints[k], row, by_leg)
        loads[k] = work.loads
    return every, of_joints, loads
