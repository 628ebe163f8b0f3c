"""Statics, eigenmodes and linear buckling of an FE model: the full-model answers that a reduction is judged by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError, ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.held import HeldMotion, held_motion, held_places
from flexmb.math.factor import factor
from flexmb.math.lanczos import lowest_modes
from flexmb.model.described import whole

__all__ = ["Modes", "buckling", "eigenmodes", "fixed_freedoms", "static"]

SINGULAR = 1e-4
"""Relative residual above which a stiffness matrix counts as singular."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Modes:
    """Eigenmodes: frequencies (n,), Hz, ascending, and shapes (ndof, n) with shapes^T M shapes = I."""

    frequencies: np.ndarray
    shapes: np.ndarray


def fixed_freedoms(fe: FEModel, fixed) -> np.ndarray:
    """Return a mask (ndof,) of the freedoms held at zero.

    Parameters
    ----------
    fixed : None, str, node numbers, coordinates, mapping, or mask (ndof,)
        A node set or several, node numbers, or coordinates (x, y, z) of a node, m: all freedoms of these nodes. The
        name of supports of a deck ("spc_1"): their freedoms. A mapping of such nodes to directions,
        ``{"symmetry": "x", 17: "xyz", (0.0, 0.0, 0.1): "xyzrxrz"}``. A mask is returned as it is. `with_supports`
        has the same notation.

    A mask knows freedoms of nodes only. Directions across the axes that supports of a deck hold, and nodes that
    follow others by links, are held where `static`, `eigenmodes` and `buckling` get the name itself.

    Raises
    ------
    MeshError
        Supports that hold directions across the axes.
    """
    if isinstance(fixed, str) and fixed in fe.slanted:
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"supports '{fixed}' with {fe.slanted[fixed].shape[0]} directions across the axes",
            expected="supports along the axes, for a mask of freedoms",
            remedy=f"Give the name: fem.static(fe, load, '{fixed}'), fem.eigenmodes(fe, '{fixed}')",
        )
    return _mask(fe, fixed)


def _mask(fe: FEModel, fixed) -> np.ndarray:
    """Return which freedoms (ndof,) of nodes stand still."""
    return np.isin(6 * fe.dofs[:, 0] + fe.dofs[:, 1], held_places(fe, fixed))


def static(fe: FEModel, load: np.ndarray, fixed) -> np.ndarray:
    """Return the displacements (ndof,) or (ndof, k), m and rad, under loads of the same shape, N and N m.

    ``K u = f`` with the freedoms `fixed` (see `fixed_freedoms`) held at zero.
    """
    load = _load(fe, load)
    held = _held(fe, fixed)
    u = _solver(fe, held.reduced(fe.K), held.free).solve(held.forces(load.reshape(fe.ndof, -1)))
    return held.spread(u, fe.ndof).reshape(load.shape)


def eigenmodes(fe: FEModel, fixed=None, n: int = 10) -> Modes:
    """Return the n lowest eigenmodes, rigid ones of an unsupported model included (near 0 Hz).

    ``K phi = (2 pi f)^2 M phi`` by block Lanczos; a small negative shift makes the matrix to
    factorise positive definite for unsupported models too.
    """
    held = _held(fe, fixed)
    n = _checked_count(fe, n, len(held.free), "eigenmodes")
    k, m = held.reduced(fe.K), held.reduced(fe.M)
    if not m.diagonal().sum() > 0.0:
        raise MeshError(
            f"FE model '{fe.name}'",
            found="no mass at the free freedoms",
            expected="materials with a density, or masses",
            remedy="Give the materials a density: a deck for statics may have none",
        )
    # Between zero and the first elastic eigenvalue whatever the units: far below the mean of K over M.
    shift = 1e-8 * k.diagonal().sum() / m.diagonal().sum()
    solver = _solver(fe, (k + shift * m).tocsr(), held.free)
    values, vectors = lowest_modes(solver.solve, lambda x: m @ x, k.shape[0], n)
    shapes = held.spread(vectors, fe.ndof)
    return Modes(frequencies=np.sqrt(np.maximum(values - shift, 0.0)) / (2.0 * np.pi), shapes=shapes)


def buckling(fe: FEModel, load: np.ndarray, fixed, n: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return the n smallest load factors (n,), ascending by magnitude, and shapes (ndof, n), largest entry 1.

    Linear buckling: ``(K + factor K_g(sigma)) phi = 0`` with the stress sigma that `load` (ndof,), N, causes. A
    negative factor belongs to the reversed load.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    if not fe.blocks:
        raise MeshError(
            f"FE model '{fe.name}'",
            found="no element blocks",
            expected="elements with geometric stiffness",
            remedy="Make the model from a mesh; K and M alone do not know the stress",
        )
    load, held = _load(fe, load), _held(fe, fixed)
    n = _checked_count(fe, n, len(held.free) - 1, "buckling modes")
    if load.ndim != 1 or not np.any(held.forces(load)):
        raise MeshError(
            f"FE model '{fe.name}'",
            found="a load of several columns" if load.ndim != 1 else "a load that is zero at all free freedoms",
            expected="one load (ndof,) that deforms the model",
            remedy="Load nodes that are not held; sum load cases to one",
        )
    k = held.reduced(fe.K)
    solver = _solver(fe, k, held.free)
    field = fe.field(held.spread(solver.solve(held.forces(load[:, None])), fe.ndof))[:, :, 0]
    kg = held.reduced(sum(block.geometric_stiffness(field, fe.dofs) for block in fe.blocks))
    # K_g phi = mu K phi with mu = -1 / factor: the largest |mu|, and K is positive definite while K_g is not.
    inverse = LinearOperator(k.shape, matvec=lambda b: solver.solve(b.reshape(-1, 1)).ravel(), dtype=float)
    start = np.random.default_rng(0).standard_normal(k.shape[0])
    mu, vectors = eigsh(kg, n, M=k, Minv=inverse, which="LM", v0=start)
    order = np.argsort(-np.abs(mu))
    shapes = held.spread(vectors[:, order], fe.ndof)
    shapes /= shapes[np.abs(shapes).argmax(axis=0), np.arange(n)]
    return -1.0 / mu[order], shapes


def _load(fe: FEModel, load) -> np.ndarray:
    load = np.asarray(load, float)
    if load.ndim not in (1, 2) or len(load) != fe.ndof or not np.isfinite(load).all():
        found = f"a load of the shape {load.shape}" if load.shape[:1] != (fe.ndof,) else "a load that is not finite"
        raise MeshError(
            f"FE model '{fe.name}'",
            found=found,
            expected=f"finite numbers, ({fe.ndof},) or ({fe.ndof}, k)",
            remedy="Use fem.pressure_load, fem.traction_load, or fe.forces of nodal forces (n, 6, k)",
        )
    return load


def _checked_count(fe: FEModel, given, most: int, what: str) -> int:
    """Return a number of modes, 8 for 8.0."""
    n = whole(given)
    if isinstance(n, bool) or not isinstance(n, int | np.integer):
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"n = {given!r:.40} {what}",
            expected=f"a whole number, 1 to {most}",
            remedy="Write n=10",
        )
    if not 0 < n <= most:
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"{n} {what} asked for",
            expected=f"1 to {most}, the free freedoms",
            remedy="Ask for fewer, or refine the mesh",
        )
    return int(n)


def _held(fe: FEModel, fixed) -> HeldMotion:
    return held_motion(fe, fixed, _mask(fe, fixed))


def _solver(fe: FEModel, matrix: sparse.csr_matrix, free: np.ndarray):
    """Return a factorisation of a positive definite matrix; MeshError if it is singular."""
    singular = MeshError(
        f"FE model '{fe.name}'",
        found=f"a singular stiffness matrix of {len(free)} free freedoms",
        expected="supports that take away all rigid motions",
        remedy="Fix more nodes; check whether the mesh falls apart or a hinge is left free",
    )
    try:
        solver = factor(matrix, fe.nodes[fe.dofs[free, 0]])
        trial = np.random.default_rng(0).standard_normal((matrix.shape[0], 1))
        answer = solver.solve(trial)
    except ReductionError:
        raise singular from None
    # Rounding makes the zero pivots of a mechanism small, not zero: the answer is huge and wrong by its own size.
    if not np.linalg.norm(matrix @ answer - trial) <= SINGULAR * np.linalg.norm(trial):
        raise singular
    return solver
