"""`linearize`: frequencies, damping, mode shapes and state space about a state, steady rotation included.

Variations dx are those of the frames in body axes. The twist varies as ``du = dx' + ad(u) dx``, so a steady motion
(constant twists in body axes) has constant coefficients::

    M dx'' + (D + M ad(u)) dx' + (K + D ad(u) + M ad(a)) dx - L dlam = 0,   G dx = 0

Vectors in W (point masses, nodes of cables) turn with their body: du = dx' + w x dx, da = dx'' + 2 w x dx' + w x (w x
dx) and the null space N of G leaves ``P^T (...) N`` in the independent coordinates z, dx = N z. Theory: formulations.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import eig, null_space
from scipy.sparse import csr_matrix

from flexmb.errors import ModelError, ValidityWarning, did_you_mean
from flexmb.integrate.formulations import RANK
from flexmb.integrate.observer import OWN_AXES, coefficients, constant_observer
from flexmb.integrate.steady import steady_motion
from flexmb.model.model import Model
from flexmb.system import assemble
from flexmb.system.given_state import given_state
from flexmb.system.mobility import DEPENDENT, mass_metric

__all__ = ["Linearization", "linearize"]

CHANGE_WITH_TIME = (
    "the coefficients of this motion change with time, whoever looks at it, and what follows holds "
    "at this instant only; "
    "expected: an equilibrium, or bodies that turn steadily, together or each about an axis of "
    "symmetry. Simulate a small "
    "disturbance instead, or start from fmb.statics(model)"
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Linearization:
    """The linear model about a state.

    Parameters
    ----------
    M, C, K : (n, n)
        Mass, damping (gyroscopic part included) and stiffness in the independent coordinates z.
    basis : (nu, n)
        Variation of all coordinates per unit of z, frames in body axes.
    eigenvalues : (k,), 1/s
        One of each conjugate pair, and all real ones, by increasing frequency.
    modes : (nu, k)
        Mode shapes in all coordinates.
    projection : (nu, n)
        Generalised forces on z per force on the coordinates, transposed; `basis` unless loads stiffen.
    markers : mapping of "body.marker" to (int, (6, k))
        First velocity of its body, and its Jacobian in W: translation, rotation.
    observer : str
        In whose axes z is seen, and the frequencies are those: "each body", its own axes, as long as the coefficients
        are constant there; else "W" or a body (a round rotor in a casing), or the precession of a top.
    """

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    basis: np.ndarray
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
        return bool(np.all(self.eigenvalues.real <= 1e-7 * (1.0 + np.abs(self.eigenvalues))))

    @property
    def state_space(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """A, B, C, D of x = (z, z'): inputs are generalised forces on z, outputs are z."""
        n = len(self.M)
        inverse = np.linalg.inv(self.M)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ self.K, -inverse @ self.C]])
        B = np.vstack([np.zeros((n, n)), inverse])
        return A, B, np.hstack([np.eye(n), np.zeros((n, n))]), np.zeros((n, n))

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

        It is C (i w - A)^-1 B of the state space between the two markers, evaluated as (K + i w C - w^2 M)^-1.

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
        return np.array([outputs @ np.linalg.solve(self.K + 1j * w * self.C - w * w * self.M, inputs) for w in omega])

    def _marker(self, name: str) -> tuple[int, np.ndarray]:
        if name not in self.markers:
            raise ModelError(
                "Linearization",
                found=f"marker '{name}' does not exist",
                expected=f"One of: {', '.join(self.markers)}",
                remedy=did_you_mean(name, self.markers) or "Write it as 'body.marker'",
            )
        return self.markers[name]


def linearize(model: Model, about: Any = None) -> Linearization:
    """Linearise a model about a state.

    Parameters
    ----------
    model : Model
    about : Solution or Instant, optional
        An equilibrium or steady motion: the result of `statics` (its last sample), or an instant of a solution;
        by default the assembled start at rest.

    Returns
    -------
    Linearization

    Raises
    ------
    ModelError
        If `about` is no state of this model.
    """
    system, state = assemble(model)
    if about is not None:
        state = given_state(about, system, "linearize")
    work = system.workspace()
    motion = steady_motion(system, state, work, known=True)
    own = coefficients(system, state, work, motion)
    bases = partial(_bases, rank=DEPENDENT if system.misfits else RANK)  # axes parallel but for the digits of a mesh
    observer = constant_observer(system, state, motion, own, bases)
    if observer is None:
        warnings.warn(f"Model '{model.name}', linearize: {CHANGE_WITH_TIME}", ValidityWarning, stacklevel=2)
        observer = OWN_AXES
    seen, T = observer.seen(system, state, motion, own)
    N, P = bases(seen)
    reduced = [P.T @ X @ N for X in (seen.M, seen.C, seen.K)]
    values, vectors = _eigen(*reduced)
    return Linearization(
        M=reduced[0],
        C=reduced[1],
        K=reduced[2],
        basis=T @ N,
        eigenvalues=values,
        modes=T @ N @ vectors,
        projection=T @ P,
        markers=_jacobians(system, work),
        observer=observer.name,
    )


def _bases(of, rank: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the null spaces of G and of L^T, scaled by inertias."""
    scale = 1.0 / np.sqrt(mass_metric(csr_matrix(of.M)))
    if not len(of.G):
        return np.diag(scale), np.diag(scale)
    N = scale[:, None] * null_space(of.G * scale, rcond=rank)
    return N, scale[:, None] * null_space((of.L * scale[:, None]).T, rcond=rank)


def _jacobians(system, work) -> dict[str, tuple[int, np.ndarray]]:
    """Return first velocity and Jacobian of every marker at the latest evaluation."""
    found = {}
    for name, k in system.marker_index.items():
        first, size, at = (int(work.markers[k][key]) for key in ("iu", "nu", "iJ"))
        found[name] = (first, work.J[at : at + 6 * size].reshape(6, size).copy())
    return found


def _eigen(M, C, K) -> tuple[np.ndarray, np.ndarray]:
    n = len(M)
    if n == 0:
        return np.zeros(0, complex), np.zeros((0, 0), complex)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    values, vectors = eig(A)
    tiny = 1e-9 * (1.0 + np.abs(values).max())
    keep = values.imag > tiny
    real = np.flatnonzero(np.abs(values.imag) <= tiny)
    # real eigenvalues in pairs: a rigid freedom gives two near zero, an overdamped or unstable mode two real ones
    pairs = real[np.argsort(np.abs(values[real]))]
    order = np.array([max(pairs[k : k + 2], key=lambda i: values[i].real) for k in range(0, len(pairs), 2)], int)
    chosen = np.concatenate([order, np.flatnonzero(keep)]).astype(int)
    chosen = chosen[np.argsort(np.abs(values[chosen].imag) + 1e-12 * np.abs(values[chosen].real), kind="stable")]
    return values[chosen], vectors[:n, chosen]
