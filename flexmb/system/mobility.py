"""Mobility: the Grübler-Kutzbach count beside the true rank, and the dependent equations by name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from flexmb.math.block_pattern import blocks
from flexmb.math.weights import weigh_mass
from flexmb.system.dependence import combinations, dependent_rows
from flexmb.system.needles import without_needles
from flexmb.system.program import evaluate
from flexmb.system.system import System

__all__ = [
    "DEPENDENT",
    "DRIFTS",
    "Mobility",
    "constraint_matrix",
    "dependent_equations",
    "equation_scale",
    "indeterminate_equations",
    "mass_diagonal",
    "mass_metric",
    "mobility",
    "shared_reactions",
    "still_dependent",
]

DEPENDENT = 1e-6
"""An equation whose gradient has a smaller part than this (relative) outside the span of the others is dependent: axes
that are parallel but for the digits of a mesh file count as parallel."""
DRIFTS = 10.0
"""Growth of that part, from position to position, up to which an equation remains dependent."""
RANK = 1e-10
"""Singular values below this, relative to the largest, are zero but for rounding."""
FEATHER = 1e-6
"""Least mass of a body in the metric of that, relative to the heaviest."""
LEFT = 1e-5
"""Of the pivots of bodies that hardly resist: below this, softness would be rounding."""
SHARE = 1e-5
"""Equations with a smaller share in a state of self-stress take no part in it."""
MIXTURES = 8
"""Of the dependent equations, if there are more, so many are looked at for states of self-stress."""
DENSE = 150
"""Equations up to which a singular value decomposition is as quick as the sparse search."""
ROUNDING = 1e-13
"""Gradients smaller than this, relative to the largest, are zero but for the last digit."""


def constraint_matrix(system: System, work) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """Return the mass part (nu, nu) and G (ng, nu) of the matrix evaluated last, with unit mass weight."""
    tables, nu = system.tables, system.nu
    mass, gradient = (
        sparse.csr_matrix(  # with indices of its own: scipy sorts them in place
            (work.S[tables[f"{name}_at"]], tables[f"{name}_columns"].copy(), tables[f"{name}_starts"].copy()),
            shape=(rows, nu),
        )
        for name, rows in (("mass", nu), ("gradient", system.ng))
    )
    return mass, gradient


def mass_diagonal(system: System, work) -> np.ndarray:
    """Return the diagonal (nu,) of the mass part of the matrix evaluated last, with unit mass weight."""
    diagonal = np.zeros(system.nu)
    diagonal[system.tables["diagonal_rows"]] = work.S[system.tables["diagonal_at"]]
    return diagonal


def mass_metric(M: sparse.csr_matrix) -> np.ndarray:
    """Return the diagonal of M, with the geometric mean of the others where bodies have no inertia, (nu,)."""
    diagonal = np.abs(M.diagonal())
    some = diagonal > 0.0
    return np.where(some, diagonal, np.exp(np.mean(np.log(diagonal[some]))) if np.any(some) else 1.0)


def equation_scale(M: sparse.csr_matrix, G: sparse.csr_matrix, least: np.ndarray) -> np.ndarray:
    """Return the diagonal of G diag(M)^-1 G^T, (ng,): the size of the pivots of the multipliers.

    Inertias are at least `least` (nu,): a body that hardly resists says nothing of the others that an equation holds
    but for the digits that its pivots leave them. An equation that nothing can move (the twist of a cable's end) has no
    size of its own and gets the largest.
    """
    metric = mass_metric(M)
    rows, entries = _beyond_rounding(G)

    def sizes(inertia: np.ndarray) -> np.ndarray:
        return np.bincount(rows, weights=entries * entries / inertia[G.indices], minlength=G.shape[0])

    scale = np.maximum(sizes(np.maximum(metric, least)), LEFT * sizes(metric))
    return np.where(scale > 0.0, scale, np.max(scale, initial=0.0) or 1.0)


def _beyond_rounding(G: sparse.csr_matrix) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of the entries of G, and the entries with zeros in rows of rounding only: the turn of a cable
    about its tangent, which moves no coordinate.
    """
    rows = np.repeat(np.arange(G.shape[0]), np.diff(G.indptr))
    largest = np.zeros(G.shape[0])
    np.maximum.at(largest, rows, np.abs(G.data))
    return rows, np.where((largest > ROUNDING * np.max(largest, initial=0.0))[rows], G.data, 0.0)


def dependent_equations(system: System, M: sparse.csr_matrix, G: sparse.csr_matrix) -> np.ndarray:
    """Return the numbers of equations whose gradients depend on earlier equations.

    Rows are scaled to the metric of the mass matrix, so lengths and angles are comparable.
    """
    block = blocks(system.program.pattern)
    A = _unit_gradients(system, M, G)
    return dependent_rows(A, block[G.shape[1] :], block[: G.shape[1]], DEPENDENT)


def still_dependent(system: System, M: sparse.csr_matrix, G: sparse.csr_matrix) -> np.ndarray:
    """Return which of the redundant equations of an assembled system depend on the others at this place, (k,) of int.

    Those of a dead centre do not, once it is left. Deviations of a mesh file change a little with the position.
    """
    found, block = system.redundant, blocks(system.program.pattern)
    gradients = _unit_gradients(system, M, G)
    others = np.setdiff1d(np.arange(gradients.shape[0]), found)
    if gradients.shape[0] > DENSE:
        order = np.concatenate([others, np.asarray(found, int)])
        joints = block[G.shape[1] :][order]
        joints[len(others) :] += 1 + int(joints.max())  # fronts of their own, after all others
        latest = order[dependent_rows(gradients[order], joints, block[: G.shape[1]], DRIFTS * DEPENDENT)]
        if not len(np.intersect1d(latest, others)):  # else others have become dependent here: their rank decides
            return latest
    A = gradients.toarray()
    others = A[others]
    s, Vt = np.linalg.svd(others, full_matrices=False)[1:] if len(others) else (np.zeros(0), np.zeros((0, A.shape[1])))
    span = list(Vt[s > RANK * np.max(s, initial=0.0)])
    dependent = []
    for k in found:
        basis = np.array(span).reshape(len(span), A.shape[1])
        apart = A[k] - basis.T @ (basis @ A[k])
        apart -= basis.T @ (basis @ apart)
        distance = float(np.linalg.norm(apart))
        if distance <= DRIFTS * DEPENDENT:
            dependent.append(k)
        else:
            span.append(apart / distance)
    return np.array(dependent, int)


def _unit_gradients(system: System, M: sparse.csr_matrix, G: sparse.csr_matrix) -> sparse.csr_matrix:
    """Return the gradients (ng, nu) in the metric of the masses, each of length one."""
    rows, entries = _beyond_rounding(G)
    framed = [k for k, body in enumerate(system.model.bodies) if body.has_frame]
    metric = without_needles(mass_metric(M), system.program.frames[:, 1], system.lengths.bodies[framed])
    return _of_length_one(G, rows, entries, _without_feathers(metric, blocks(system.program.pattern)[: G.shape[1]]))


def _of_length_one(G: sparse.csr_matrix, rows, entries, metric: np.ndarray) -> sparse.csr_matrix:
    """Return the matrix with other `entries` in the `rows` of G, in a metric (nu,), each row of length one."""
    entries = entries * (1.0 / np.sqrt(metric))[G.indices]
    norms = np.sqrt(np.bincount(rows, weights=entries * entries, minlength=G.shape[0]))
    entries = (1.0 / np.where(norms > 0.0, norms, 1.0))[rows] * entries
    some = entries != 0.0  # zeros would fill factors
    starts = np.searchsorted(rows[some], np.arange(G.shape[0] + 1))
    return sparse.csr_matrix((entries[some], G.indices[some], starts), shape=G.shape)


def _without_feathers(metric: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Return the metric (nu,) with bodies that weigh next to nothing made heavier, all their inertia alike.

    Dependence is geometry. In the metric of the masses a point of 1e-12 kg is all that moves, and every joint that
    shares it looks like every other.
    """
    _, first, number = np.unique(body, return_index=True, return_inverse=True)
    mass = metric[first]
    return metric * np.maximum(1.0, FEATHER * np.max(mass, initial=0.0) / mass)[number]


def indeterminate_equations(M: sparse.csr_matrix, G: sparse.csr_matrix, dependent) -> np.ndarray:
    """Return the numbers of equations whose multipliers are not unique: those that take part in a state of self-stress.

    A dependent gradient is a combination of independent ones, g_d = sum y_i g_i; multipliers (1, -y) do no work. Of
    many dependent gradients a few random mixtures stand for all: they leave out no equation that takes part in one of
    them.
    """
    dependent = np.asarray(dependent, int)
    if not len(dependent):
        return dependent
    A = _of_length_one(G, np.repeat(np.arange(G.shape[0]), np.diff(G.indptr)), G.data, mass_metric(M))
    others = np.setdiff1d(np.arange(A.shape[0]), dependent)
    shares = np.zeros(len(others))
    if len(others):
        n = len(dependent)
        mixture = np.eye(n) if n <= MIXTURES else np.random.default_rng(0).normal(size=(n, MIXTURES))
        _, y = combinations(A[others])(A[others] @ (A[dependent].T @ mixture))
        shares = np.max(np.abs(y), axis=1, initial=0.0)
    return np.sort(np.concatenate([dependent, others[shares > SHARE]]))


@dataclass(frozen=True)
class Mobility:
    """What `check` finds about the freedoms of a model.

    Parameters
    ----------
    velocities : int
        Velocities of all bodies.
    equations : int
        Constraint equations of all joints and drives.
    rank : int
        Independent ones among them.
    redundant : tuple of str
        Names of the dependent equations.
    indeterminate : tuple of str
        Names of the equations whose multipliers are not unique: the dependent ones and those that they depend on.
    """

    velocities: int
    equations: int
    rank: int
    redundant: tuple[str, ...]
    indeterminate: tuple[str, ...] = ()

    @property
    def mobility(self) -> int:
        """True number of degrees of freedom."""
        return self.velocities - self.rank

    @property
    def gruebler(self) -> int:
        """Count of Grübler and Kutzbach: velocities minus equations."""
        return self.velocities - self.equations


def mobility(system: System, state, work) -> Mobility:
    """Return the counts of an assembled system at a state."""
    names = system.equation_names
    redundant, shared = tuple(names[k] for k in system.redundant), ()
    if system.redundant:
        weigh_mass(work.weights)
        program = system.program
        bare = program._replace(regularisation=np.zeros(system.ng), floor=np.zeros(len(program.floor)))
        evaluate(bare, state, work)
        shared = tuple(names[k] for k in indeterminate_equations(*constraint_matrix(system, work), system.redundant))
    return Mobility(system.nu - int(np.sum(system.is_state)), system.ng, system.ng - len(redundant), redundant, shared)


def shared_reactions(system: System, state=None) -> list[str]:
    """Return the joints whose reactions are not unique at a state, or as assembled, each with its equations:
    "B: InPlane x".
    """
    if not system.redundant:
        return []
    names = [system.equation_names[k] for k in system.indeterminate]
    if state is not None:
        names = list(mobility(system, state, system.workspace()).indeterminate)
    found: dict[str, list[str]] = {}
    for name in names:
        joint, _, kind = name.rpartition(": ")
        found.setdefault(joint, []).append(kind)
    return [f"{joint}: {', '.join(kinds)}" for joint, kinds in found.items()]
