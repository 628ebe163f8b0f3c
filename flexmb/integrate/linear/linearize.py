"""`linearize`: frequencies, damping, mode shapes and state space about a state, steady rotation included.

Variations dx of the frames are in body axes. The twist varies as ``du = dx' + ad(u) dx``, so a steady motion (constant
twists in body axes) has constant coefficients::

    M dx'' + (D + M ad(u)) dx' + (K + D ad(u) + M ad(a)) dx - L dlam = 0,   G dx = 0

and of rolling G dx' + (G ad(u) + dG/dq u) dx = 0 instead of G dx = 0. Vectors in W (point masses, nodes of cables) turn
with their body: du = dx' + w x dx, da = dx'' + 2 w x dx' + w x (w x dx). The null space N of the equations of places
leaves ``P^T (...) N`` in the independent coordinates z, dx = N z. Theory: formulations.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, overload

import numpy as np

from flexmb.errors import ModelError, ValidityWarning, did_you_mean
from flexmb.integrate.formulations import RANK
from flexmb.integrate.impulsive import refuse_crowds, refuse_impulses
from flexmb.integrate.linear.imbalance import imbalance
from flexmb.integrate.linear.independent import independent
from flexmb.integrate.linear.lost_digits import lost_digits
from flexmb.integrate.linear.observer import OWN_AXES, coefficients, constant_observer
from flexmb.integrate.linear.plant import Plant, plant_of
from flexmb.integrate.linear.spectrum import first_order, modes_of, state_matrix, without_integrals
from flexmb.integrate.linear.steady import steady_motion
from flexmb.integrate.runs.shared_readers import shared_reactions_act
from flexmb.model.model import Model
from flexmb.system import assemble, assemble_as_drawn
from flexmb.system.given_state import given_state
from flexmb.system.holds import refuse_holds
from flexmb.system.mobility import DEPENDENT

__all__ = ["Linearization", "linearize"]

GROWTH, ROUNDING = 1e-7, 1e-12
"""Growth that counts as none, relative to an eigenvalue and to the largest: what the eigenvalue problem rounds."""
CHANGE_WITH_TIME = (
    "the coefficients of this motion change with time in all axes, so the result holds at this instant only; "
    "expected: an equilibrium, or bodies that turn steadily, together or each about an axis of symmetry. "
    "Simulate a small disturbance instead, or start from fmb.statics(model)"
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Linearization:
    """The linear model about a state.

    Parameters
    ----------
    M, C, K : (n, n)
        Mass, damping (gyroscopic part included) and stiffness in the independent coordinates z: M w' + C w + K z = 0
        with z' = w. With rolling contacts more places z than velocities w are free: K is (n, nz). First-order states x
        of forces and blocks are the last of w, and have no place among z.
    Q, F : (nz, n), (nz, nz)
        z' = Q w + F z; the unit matrix and zero unless something rolls or has states.
    basis : (nu, nz)
        Variation of all coordinates per unit of z, frames in body axes.
    velocities : (nu, n)
        Variation of all velocities, and of states, per unit of w.
    eigenvalues : (k,), 1/s
        One of each conjugate pair, and all real ones, by increasing frequency. A motion that continues by itself (a
        free body, a rotor about its axis) is one zero: its free speed is not a mode of its own.
    modes : (nu, k)
        Mode shapes in all coordinates.
    projection : (nu, n)
        Generalised forces on w per force on the coordinates, transposed; `basis` unless loads stiffen or wheels roll.
    markers : mapping of "body.marker" to (int, (6, k))
        First velocity of its body, and its Jacobian in W: translation, rotation.
    observer : str
        In whose axes z is seen, and the frequencies are those: "each body", its own axes, as long as the coefficients
        are constant there; else "W" or a body (a round rotor in a casing), or the precession of a top.
    """

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    Q: np.ndarray
    F: np.ndarray
    basis: np.ndarray
    velocities: np.ndarray
    eigenvalues: np.ndarray
    modes: np.ndarray
    projection: np.ndarray
    markers: Mapping[str, tuple[int, np.ndarray]]
    observer: str = OWN_AXES.name

    def __repr__(self):
        listed = ", ".join(f"{f:.4g}" for f in self.frequencies[self.frequencies > 0.0][:6])
        more = ", ..." if np.sum(self.frequencies > 0.0) > 6 else ""
        found = f"{listed}{more} Hz" if listed else "no oscillation"
        return f"Linearization({len(self.M)} freedoms: {found}; {'stable' if self.stable else 'unstable'})"

    @property
    def frequencies(self) -> np.ndarray:
        """Damped natural frequencies ``|Im s| / 2 pi``, (k,), Hz."""
        return np.abs(self.eigenvalues.imag) / (2.0 * np.pi)

    @property
    def damping_ratios(self) -> np.ndarray:
        """Fractions of critical damping, ``-Re s / |s|``, (k,); negative for an unstable mode."""
        size = np.abs(self.eigenvalues)
        return np.where(size > 0.0, -self.eigenvalues.real / np.where(size > 0.0, size, 1.0), 0.0)

    @property
    def stable(self) -> bool:
        """Does no mode grow?"""
        size = np.abs(self.eigenvalues)
        return bool(np.all(self.eigenvalues.real <= GROWTH * size + ROUNDING * np.max(size, initial=0.0)))

    @property
    def state_space(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """A, B, C, D of x = (z, w), with w = z' unless something rolls.

        Inputs are generalised forces on w, outputs are z.
        """
        nz, n = self.Q.shape
        A = state_matrix(self)
        B = np.vstack([np.zeros((nz, n)), np.linalg.inv(self.M)])
        return A, B, np.hstack([np.eye(nz), np.zeros((nz, n))]), np.zeros((nz, n))

    def motion_of(self, marker: str) -> np.ndarray:
        """Return displacement (m) and rotation (rad) of a marker in W per unit of z, (6, n):
        rows of an output matrix.
        """
        first, jacobian = self._marker(marker)
        return jacobian @ self.basis[first : first + jacobian.shape[1]]

    def force_on(self, marker: str) -> np.ndarray:
        """Return the generalised force on z per unit force (N) and moment (N m) in W at a marker, (n, 6)."""
        first, jacobian = self._marker(marker)
        return self.projection[first : first + jacobian.shape[1]].T @ jacobian.T

    def frequency_response(self, frequencies, force: str, motion: str) -> np.ndarray:
        """Return the response of one marker to a harmonic load on another.

        It is C (i w - A)^-1 B of the state space between the two markers, evaluated as (K + i w C - w^2 M)^-1 where
        z' are the velocities.

        Parameters
        ----------
        frequencies : (nf,), Hz
        force, motion : str
            "body.marker" that is loaded, and that is observed.

        Returns
        -------
        (nf, 6, 6), complex
            Displacement x, y, z (m) and rotation (rad) in W, per force (N) and moment (N m) in W: ``H[:, 2, 2]`` is the
            vertical deflection under a vertical force. Its absolute value is the amplitude, its angle the phase.

        Raises
        ------
        ModelError
            There is no such marker.
        """
        outputs, inputs = self.motion_of(motion), self.force_on(force)
        omega = 2.0 * np.pi * np.atleast_1d(np.asarray(frequencies, float))
        nz, n = self.Q.shape
        unit = np.eye(nz)
        if nz == n:
            stiff = (self.K + 1j * w * self.C - w * w * self.M for w in omega)
            return np.array([outputs @ np.linalg.solve(dynamic, inputs) for dynamic in stiff])
        load = np.vstack([np.zeros((nz, inputs.shape[1])), inputs])
        return np.array(
            [
                outputs
                @ np.linalg.solve(
                    np.block([[1j * w * unit - self.F, -self.Q], [self.K, 1j * w * self.M + self.C]]), load
                )[:nz]
                for w in omega
            ]
        )

    def _marker(self, name: str) -> tuple[int, np.ndarray]:
        if name not in self.markers:
            raise ModelError(
                "Linearization",
                found=f"marker '{name}' does not exist",
                expected=f"One of: {', '.join(self.markers)}",
                remedy=did_you_mean(name, self.markers) or "Write it as 'body.marker'",
            )
        return self.markers[name]


@overload
def linearize(model: Model, about: Any = None) -> Linearization: ...


@overload
def linearize(
    model: Model, about: Any = None, *, inputs: Iterable[str] | str, outputs: Iterable[str] | str | None = None
) -> Plant: ...


@overload
def linearize(model: Model, about: Any = None, *, inputs: None = None, outputs: Iterable[str] | str) -> Plant: ...


def linearize(
    model: Model,
    about: Any = None,
    *,
    inputs: Iterable[str] | str | None = None,
    outputs: Iterable[str] | str | None = None,
) -> Linearization | Plant:
    """Linearise a model about a state.

    Parameters
    ----------
    model : Model
    about : Solution or Instant, optional
        An equilibrium or steady motion: the result of `statics` (its last sample), or an instant of a solution;
        by default the assembled start at rest.
    inputs : names, optional
        Signals of forces and drives, "part.field" ("motor.angle"), "part.field.z" of vectors ("push.force.z"), or
        "part" if it has only one. With inputs or outputs the result is the state space between them, of the others all.
    outputs : names, optional
        Sensors, or one column of a sensor: "tip z".

    Returns
    -------
    Linearization, or a Plant between inputs and outputs

    Raises
    ------
    ModelError
        If `about` is no state of this model, an input or output does not exist, or the state of a plant moves.
    """
    refuse_impulses(model, "linearize")
    refuse_crowds(model, "linearize")
    system, state = _assembled_about(model, about)
    work = system.workspace()
    motion = steady_motion(system, state, work, known=True)
    own = coefficients(system, state, work, motion)
    shared_reactions_act(system, state, state.lam[None])
    rank = DEPENDENT if system.redundant else RANK  # axes parallel but for the digits of a mesh
    states = int(np.sum(system.is_state))
    level, least = system.program.equation_level, system.least_inertia
    bases = partial(independent, level=level, rank=rank, least=least, states=states)
    observer = constant_observer(system, state, motion, own, bases)
    balance = partial(imbalance, system, state, work, motion, own.K.diagonal())
    if told := CHANGE_WITH_TIME if observer is None else balance(observer.velocity):
        warnings.warn(f"Model '{model.name}', linearize: {told}", ValidityWarning, stacklevel=2)
    _undirected(system, work)
    observer = observer or OWN_AXES
    seen, T = observer.seen(system, state, motion, own)
    basis = bases(seen)
    fastest = max((float(np.linalg.norm(w)) for w in motion.spins.values()), default=0.0)
    equations = without_integrals(first_order(seen, basis, fastest, system.lengths.digits), states)
    values, vectors = modes_of(equations)
    shapes = (T @ basis.N)[:, : basis.N.shape[1] - states]
    if doubt := lost_digits(system, seen.K, basis.N[:, : shapes.shape[1]], equations, values, vectors):
        warnings.warn(f"Model '{model.name}', linearize: {doubt}", ValidityWarning, stacklevel=2)
    linear = Linearization(
        M=equations.M,
        C=equations.C,
        K=equations.K,
        Q=equations.Q,
        F=equations.F,
        basis=shapes,
        velocities=T @ basis.N @ basis.Q,
        eigenvalues=values,
        modes=shapes @ vectors,
        projection=T @ basis.P,
        markers=_jacobians(system, work),
        observer=observer.name,
    )
    if inputs is None and outputs is None:
        return linear
    return plant_of(system, state, linear, inputs, outputs)


def _undirected(system, work) -> None:
    """Warn of forces along a line whose ends meet: the motion will give it a direction, which the slopes here lack."""
    places = {name: work.markers[k]["r"] for name, k in system.marker_index.items()}
    for force in system.model.forces:
        if lost := force.undirected(places.__getitem__):
            warnings.warn(
                f"{force.title}, linearize: its markers meet, so its line has no direction, and its {lost} cannot "
                "count; expected: markers that are apart. Use Bushing, which has axes, or a force on a joint",
                ValidityWarning,
                stacklevel=3,
            )


def _assembled_about(model: Model, about: Any):
    """Return the system and the state that a model is linearised about: a given one, or the drawn start."""
    system, state = (assemble_as_drawn if about is None else assemble)(model)
    refuse_holds(system, "linearize")
    return system, state if about is None else given_state(about, system, "linearize")


def _jacobians(system, work) -> dict[str, tuple[int, np.ndarray]]:
    """Return first velocity and Jacobian of every marker at the latest evaluation."""
    found = {}
    for name, k in system.marker_index.items():
        first, size, at = (int(work.markers[k][key]) for key in ("iu", "nu", "iJ"))
        found[name] = (first, work.J[at : at + 6 * size].reshape(6, size).copy())
    return found
