"""Geometric stiffness of unit loads in modal coordinates (Banerjee 1993; docs, theory "geometric-stiffness")."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.model.modal_arrays import GeometricStiffness
from flexmb.reduction.markers import MarkerMotion
from flexmb.reduction.nodal_inertia import NodalInertia
from flexmb.reduction.statics import HeldBody

__all__ = ["by_loads", "coupling_stiffness", "geometric_matrices", "geometric_stiffness", "inertia_loads"]


ACCELERATIONS = range(12)
"""Load cases of the unit acceleration fields: they come first."""


def inertia_loads(fe: FEModel) -> np.ndarray:
    """Return the nodal forces of the unit acceleration fields, (ndof, 12): -M E_k, then -M [x_l e_k] at 3 + 3 k + l.

    Rotational freedoms accelerate with half the curl of the field, so that the antisymmetric fields are exactly the
    rigid angular accelerations and the loads balance the equations of the body. The symmetric fields, of spin, meet the
    rotary inertia of nodes with the moment w x J w.
    """
    if fe.condensed is not None:
        return np.asarray(fe.condensed.fields.T @ inertia_loads(fe.condensed.whole))
    field = np.zeros((len(fe.nodes), 6, 12))
    for k in range(3):
        field[:, k, k] = 1.0
        for l in range(3):
            field[:, k, 3 + 3 * k + l] = fe.nodes[:, l]
            field[:, 3:, 3 + 3 * k + l] = 0.5 * np.cross(np.eye(3)[l], np.eye(3)[k])
    loads = -(fe.M @ fe.vectors(field))
    nodal = NodalInertia.of(fe)
    if nodal is not None:
        for k in range(3):
            for l in range(3):
                unit = np.outer(np.eye(3)[k], np.eye(3)[l])
                loads[:, 3 + 3 * k + l] -= nodal.moments(0.5 * (unit + unit.T))
    return loads


def coupling_stiffness(body: HeldBody, static, direct, interfaces, shapes, own: int = len(ACCELERATIONS)) -> np.ndarray:
    """Return the geometric stiffness of the couplings for every load case, (loads, m, m).

    A coupling that turns by theta takes its nodes along ``theta x s + theta x (theta x s) / 2``; the second part works
    against the forces r = K u - f that hold the nodes in it: ``theta^T (sym(sum r s^T) - (sum r . s) I) theta / 2``.
    Without it a body frame that turns relative to a coupling (Buckens) meets a spurious stiffness, wherever the
    coupling prevents lateral contraction. A marker away from its nodes would carry its load without a lever. The marker
    of an averaging coupling at s from the mean of its nodes moves likewise under its own load f, which works on that
    motion: r = -f.

    Parameters
    ----------
    static : (ndof, loads), displacement u; direct : (ndof, loads), loads f that act on nodes, not through interfaces
    own : int
        Where the unit forces and moments of the interfaces begin among the loads, which may be some of all.
    """
    fe = body.fe
    out = np.zeros((static.shape[1], shapes.shape[1], shapes.shape[1]))
    for number, (coupling, marker) in enumerate(zip(body.couplings, interfaces, strict=True)):
        moments = np.zeros((3, 3, static.shape[1]))  # sum r s^T
        if coupling.averaging:
            for axis, load in enumerate(range(own + 6 * number, own + 6 * number + 3)):
                if 0 <= load < static.shape[1]:
                    moments[axis, :, load] = coupling.center - coupling.position
        else:
            rows = coupling.rows[fe.dofs[coupling.rows, 1] < 3]
            node, direction = fe.dofs[rows, 0], fe.dofs[rows, 1]
            held = fe.K[rows] @ static - direct[rows]
            arm = fe.nodes[node] - coupling.position
            np.add.at(moments, direction, arm[:, :, None] * held[:, None, :])
        out += _turning_stiffness(moments, marker.matrix[3:] @ shapes)
    return out


def _turning_stiffness(moments: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return the stiffness (loads, m, m) of sums r s^T (3, 3, loads) at a coupling that turns by (3, m)."""
    matrix = 0.5 * (moments + moments.transpose(1, 0, 2))
    matrix -= np.eye(3)[:, :, None] * np.trace(moments)
    return np.asarray(np.einsum("ia,ijl,jb->lab", turn, matrix, turn, optimize=True))


def _inner_stiffness(fe: FEModel, static: np.ndarray, inertia: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """Return the same of the couplings at which the parts of a condensed model are joined.

    static : (ndof of the whole, loads); inertia : (ndof of the whole, 12), the first loads; modes : (n, 6, m)
    """
    whole = fe.condensed.whole  # type: ignore[union-attr] # only such models have them
    out = np.zeros((static.shape[1], modes.shape[2], modes.shape[2]))
    for coupling, number in fe.condensed.couplings:  # type: ignore[union-attr]
        rows = coupling.rows[whole.dofs[coupling.rows, 1] < 3]
        node, direction = whole.dofs[rows, 0], whole.dofs[rows, 1]
        held = whole.K[rows] @ static
        held[:, : inertia.shape[1]] -= inertia[rows]
        moments = np.zeros((3, 3, static.shape[1]))
        np.add.at(moments, direction, (whole.nodes[node] - coupling.position)[:, :, None] * held[:, None, :])
        out += _turning_stiffness(moments, modes[number, 3:])
    return out


def geometric_matrices(
    body: HeldBody,
    shapes: np.ndarray,
    interfaces: Sequence[MarkerMotion],
    loads: np.ndarray,
    preload: np.ndarray,
    support: np.ndarray | None = None,
    preload_reaction: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Return ``Phi^T K_g(sigma) Phi`` for every load, (12 + 6 ni + nl + 1, m, m), in the order of `by_loads`.

    Parameters
    ----------
    body : HeldBody
    shapes : (ndof, m)
    interfaces : the motion of each interface; its transpose spreads the unit force or moment over the nodes
    loads, preload : (ndof, nl) and (ndof,), N
    preload_reaction : (ndof,), N
        What balances the preload, through an interface: a preload in equilibrium is the same in every frame.
    support : int indices of interface coordinates, or None
        Statically determinate support that balances the unit loads; the actual loads are in equilibrium, so its
        reactions cancel in the sum and any choice gives the same motion.
    """
    fe, inertia = body.fe, inertia_loads(body.fe)
    if not fe.blocks:
        raise ReductionError(
            f"FE model '{fe.name}'",
            found="geometric stiffness was requested, but there are no elements",
            expected="an FE model made from a mesh or a frame",
            remedy="Use geometric_stiffness=False for foreign matrices",
        )
    wrenches = [marker.matrix.T.toarray() for marker in interfaces]
    forces = np.hstack([inertia, *wrenches, loads, (preload + preload_reaction)[:, None]])
    static = body.solve_supported(forces, support)
    displacement, modes = fe.field(static), fe.field(shapes)
    matrices = np.sum([block.projected_geometric_stiffness(displacement, modes) for block in fe.blocks], axis=0)
    direct = np.hstack([inertia, *(np.zeros_like(w) for w in wrenches), loads, preload[:, None]])
    matrices += coupling_stiffness(body, static, direct, interfaces, shapes)
    if fe.condensed is not None:
        matrices += _inner_stiffness(fe, fe.condensed.fields @ static, inertia_loads(fe.condensed.whole), modes)
    return np.asarray(0.5 * (matrices + matrices.transpose(0, 2, 1)))


def by_loads(matrices: np.ndarray, interfaces: int) -> dict[str, np.ndarray]:
    """Return the fields of `GeometricStiffness` for matrices in the order of `geometric_matrices`."""
    own = len(ACCELERATIONS)
    inertia, interface, shape, constant = np.split(matrices, [own, own + 6 * interfaces, len(matrices) - 1])
    interface = interface.reshape(interfaces, 6, *matrices.shape[1:])
    return {"inertia": inertia, "interface": interface, "loads": shape, "preload": constant[0]}


def geometric_stiffness(body: HeldBody, shapes: np.ndarray, interfaces, *loads, **balance) -> GeometricStiffness:
    """Return the matrices of `geometric_matrices`, by the loads that they belong to."""
    return GeometricStiffness(
        **by_loads(geometric_matrices(body, shapes, interfaces, *loads, **balance), len(interfaces))
    )
