"""The Craig-Bampton basis and its orthonormalisation in the chosen body frame (Craig & Bampton 1968)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, eigh, qr

from flexmb.errors import ReductionError
from flexmb.math.lanczos import lowest_modes
from flexmb.reduction.checks import beside_largest, mechanism
from flexmb.reduction.statics import HeldBody

__all__ = [
    "Basis",
    "NormalModes",
    "available_modes",
    "free_modes",
    "normal_modes",
    "orthonormal_basis",
    "with_residuals",
]

LEAST = 1e-200
"""A stiffness, N/m, below which a mass that is divided by it is no number."""
HELD = 1e-10
"""A response whose part outside the modes is smaller than this, in mass norms, is held by them: the rest is what the
factorisation rounds."""
ALIKE = 1e-12
"""Square of the part of a response, of unit mass, that others do not hold, below which it is left out."""


@dataclass(frozen=True, eq=False)
class NormalModes:
    """Fixed-interface normal modes: vectors (ndof, k), M-orthonormal, and w2 (k,), 1/s2, ascending."""

    vectors: np.ndarray
    w2: np.ndarray


@dataclass(frozen=True, eq=False)
class Basis:
    """Flexible shapes of the body frame: ``shapes`` (ndof, m), ``w2`` (m,), and what they are made of.

    ``content`` (nq + k, m): coordinates of each shape in constraint modes and normal modes.
    ``reduced_mass`` (nq + k, nq + k): mass matrix of the Craig-Bampton coordinates.
    """

    shapes: np.ndarray
    w2: np.ndarray
    content: np.ndarray
    reduced_mass: np.ndarray


def normal_modes(body: HeldBody, count: int, start: np.ndarray | None = None) -> NormalModes:
    """Return the `count` lowest modes with all interfaces held; ReductionError if there are not so many."""
    modes = available_modes(body, count, start) if count <= len(body.interior) else None
    if modes is None or len(modes.w2) < count:
        raise ReductionError(
            f"FE model '{body.fe.name}'",
            found=f"{count} fixed-interface modes asked for",
            expected=f"at most {len(body.interior) if modes is None else len(modes.w2)}, the freedoms with mass behind "
            "the interfaces",
            remedy="Ask for fewer modes or name fewer interfaces, or refine the mesh",
        )
    return modes


def available_modes(body: HeldBody, count: int, start: np.ndarray | None = None) -> NormalModes:
    """Return the `count` lowest modes with all interfaces held, or as many as there are."""
    fe, count = body.fe, min(count, len(body.interior))
    if count == 0:
        return NormalModes(np.zeros((fe.ndof, 0)), np.zeros(0))
    w2, vectors = lowest_modes(body.solve, lambda x: fe.M @ x, fe.ndof, count, start=start)
    return NormalModes(vectors, w2)


def free_modes(body: HeldBody, count: int, start: np.ndarray | None = None) -> NormalModes:
    """Return the lowest elastic modes of the full, free body (the reference for the reduced ones)."""
    fe = body.fe
    count = min(count, fe.ndof - body.rigid.shape[1])
    w2, vectors = lowest_modes(body.solve_free, lambda x: fe.M @ x, fe.ndof, count, start=start)
    return NormalModes(vectors, w2)


def _unit_mass(fe, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vectors (ndof, k) divided by their mass norms, and these norms (k,); zero vectors stay."""
    norms = np.sqrt(np.maximum(np.einsum("ij,ij->j", vectors, fe.M @ vectors), 0.0))
    return vectors / np.where(norms > 0.0, norms, 1.0), norms


def with_residuals(body: HeldBody, modes: NormalModes, forces: np.ndarray) -> NormalModes:
    """Append the static response to `forces` (ndof, k), as far as the normal modes do not hold it already.

    Residual (static correction) vectors make the response to these loads exact in statics.
    """
    if forces.shape[1] == 0:
        return modes
    fe = body.fe
    # as large as the modes, whatever the load: a pressure of 1 Pa has the same shape as one of 1 MPa
    response, known = _unit_mass(fe, body.solve(forces))
    for _ in range(2):  # twice: what a mode takes from a response that it nearly holds leaves rounding along the mode
        response = response - modes.vectors @ (modes.vectors.T @ (fe.M @ response))
    rest, left = _unit_mass(fe, response)
    trial = np.hstack([modes.vectors, _independent(fe, rest[:, (known > 0.0) & (left > HELD)])])
    K, M = trial.T @ (fe.K @ trial), trial.T @ (fe.M @ trial)
    mu, turn = eigh(0.5 * (M + M.T), 0.5 * (K + K.T))
    order = np.flatnonzero(mu > 1e-14 * mu.max())[::-1]
    return NormalModes(trial @ (turn[:, order] / np.sqrt(mu[order])), 1.0 / mu[order])


def _independent(fe, vectors: np.ndarray) -> np.ndarray:
    """Return the vectors of unit mass (ndof, k), or fewer that span the same where some hold others."""
    if vectors.shape[1] < 2:
        return vectors
    size, turn = eigh(vectors.T @ (fe.M @ vectors))
    kept = size > ALIKE * size[-1]
    return vectors if kept.all() else vectors @ (turn[:, kept] / np.sqrt(size[kept]))


def orthonormal_basis(body: HeldBody, modes: NormalModes, frame: int | None, within: np.ndarray | None = None) -> Basis:
    """Return the shapes of the body frame, M-orthonormal, with diagonal stiffness.

    Parameters
    ----------
    body, modes
        Constraint modes and fixed-interface normal modes.
    frame : int or None
        None for the Buckens frame: the span of the rigid motions is removed as a null space, never by a list of the
        "first six" modes. Otherwise the number of the interface at which the frame is clamped.
    within : (nq + k, p) or None
        Displacements in coordinates of constraint modes and normal modes: the basis is what they and the rigid motions
        span. None: all of both.
    """
    K, M = _reduced_matrices(body, modes)
    nq, size = body.nq, len(K)
    rigid = np.zeros((size, body.rigid.shape[1]))
    rigid[:nq] = body.rigid_coordinates
    if within is not None:
        seen = rigid.T @ M if frame is None else np.eye(size)[body.slices[frame]]
        admissible = within - rigid @ np.linalg.solve(seen @ rigid, seen @ within)
    elif frame is None:
        scale = np.sqrt(np.where(np.diag(M) > 0.0, np.diag(M), 1.0))
        admissible = qr((M @ rigid) / scale[:, None])[0][:, rigid.shape[1] :] / scale[:, None]
    else:
        admissible = np.delete(np.eye(size), np.arange(size)[body.slices[frame]], axis=1)
    w2, content = _eigenvectors(body, admissible, K, M)
    shapes = body.constraint_modes @ content[:nq] + modes.vectors @ content[nq:]
    if frame is None:
        shapes = body.without_rigid(shapes)
    _check_energy(body, shapes, w2)
    flip = np.sign(np.take_along_axis(shapes, np.abs(shapes).argmax(axis=0)[None], axis=0)[0])
    return Basis(shapes * flip, w2, content * flip, M)


def _reduced_matrices(body: HeldBody, modes: NormalModes) -> tuple[np.ndarray, np.ndarray]:
    """K and M in (constraint modes, normal modes); the blocks of K between the two vanish by construction."""
    psi, phi, fe = body.constraint_modes, modes.vectors, body.fe
    mass_psi = fe.M @ psi
    coupling = mass_psi.T @ phi
    M = np.block([[psi.T @ mass_psi, coupling], [coupling.T, np.eye(phi.shape[1])]])
    K = np.zeros_like(M)
    K[: body.nq, : body.nq] = body.condensed
    np.fill_diagonal(K[body.nq :, body.nq :], modes.w2)
    return K, 0.5 * (M + M.T)


def _eigenvectors(
    body: HeldBody, admissible: np.ndarray, K: np.ndarray, M: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Solve M y = mu K y on the admissible subspace: the inverse problem keeps the digits of the low frequencies."""
    K_a, M_a = admissible.T @ K @ admissible, admissible.T @ M @ admissible
    if len(K_a) == 0:
        return np.zeros(0), np.zeros((len(K), 0))
    own = np.abs(np.diag(K_a))
    if not np.all(own > LEAST):
        raise _hinge(body, admissible, K_a)
    scale = 1.0 / np.sqrt(own)
    K_a, M_a = scale[:, None] * K_a * scale, scale[:, None] * M_a * scale
    try:
        mu, y = eigh(0.5 * (M_a + M_a.T), 0.5 * (K_a + K_a.T))
    except LinAlgError as error:
        raise _hinge(body, admissible * scale, K_a) from error
    if mu[0] <= 1e-15 * mu[-1]:
        if np.linalg.eigvalsh(K_a)[0] <= 1e-12:  # no energy rather than no mass (the diagonal of K_a is one)
            raise _hinge(body, admissible * scale, K_a)
        shape = body.constraint_modes @ (admissible @ (scale * y[:, 0]))[: body.nq]
        node, deck = body.fe.dofs[int(np.abs(shape).argmax()), 0], bool(body.fe.source)
        raise ReductionError(
            f"FE model '{body.fe.name}'",
            found=f"an interface motion without mass, largest at {body.fe.node_name(node)}",
            expected="mass behind every interface freedom",
            remedy="Give this region a density, a lumped mass or inertia (fem.with_mass), or take the interface away"
            + (
                "; lumped masses of a deck have no inertia: fem.read_deck(..., lumped=False), --consistent-mass, of a "
                "part in a model file lumped = false"
            )
            * deck,
        )
    order = np.argsort(mu)[::-1]
    return 1.0 / mu[order], admissible @ (scale[:, None] * y[:, order] / np.sqrt(mu[order]))


def _hinge(body: HeldBody, directions: np.ndarray, stiffness: np.ndarray) -> ReductionError:
    """Return the error for interfaces that move against each other without strain energy."""
    energy, y = eigh(0.5 * (stiffness + stiffness.T))
    shape = body.constraint_modes @ (directions @ y[:, 0])[: body.nq]
    return mechanism(
        body.fe,
        int(np.abs(shape).argmax()),
        f"the interfaces move against each other without strain energy{beside_largest(energy)}",
        held=False,
    )


def _check_energy(body: HeldBody, shapes: np.ndarray, w2: np.ndarray) -> None:
    """Raise if the strain energy of the softest shape cannot be told from rounding: a mechanism between interfaces."""
    if not len(w2):
        return
    soft = shapes[:, 0]
    handled = np.abs(soft) @ (abs(body.fe.K) @ np.abs(soft))
    if not w2[0] > 1e-14 * handled:
        raise mechanism(
            body.fe,
            int(np.abs(soft).argmax()),
            f"its strain energy is {w2[0] / handled:.0e} of the terms it is made of",
            held=False,
        )
