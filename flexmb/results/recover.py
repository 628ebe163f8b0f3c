"""Recovery: from flexible coordinates to displacement, position and stress of nodes.

Displacement in body axes ``U = Phi eta``, position in W ``x = r + R (X + U)``, stress ``sigma = S eta`` by the stress
modes of the reduction, von Mises stress from the nodal stress. Nothing is stored per time and node unless asked for:
every function takes the coordinates of the wanted times and, where it makes sense, the wanted nodes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.kernel import kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.model.described import finite_array

__all__ = [
    "Envelope",
    "displacement",
    "element_stress",
    "largest_von_mises",
    "line_forces",
    "line_strains",
    "modal_data",
    "positions",
    "principal",
    "rotation_matrices",
    "section_forces",
    "strain_energy",
    "stress",
    "velocities",
    "von_mises",
    "von_mises_envelope",
]

CHUNK = 16_000_000
"""Numbers of nodal stress held at once (128 MB); longer series go through in pieces."""


class Envelope(NamedTuple):
    """Largest value of each node over time: value (n,), time (n,), s, at which it occurred first."""

    value: np.ndarray
    time: np.ndarray


def modal_data(body):
    """Return the ModalNeutralData that a floating body moves with (its selected modes); ModelError for other bodies."""
    data = getattr(body, "reduced", None)
    if data is None:
        raise ModelError(
            body.title,
            found=f"a {type(body).__name__} has no modes",
            expected="a FloatingBody",
            remedy="Displacement and stress fields exist for bodies with modal neutral data",
        )
    return data


def displacement(data, eta, nodes=None) -> np.ndarray:
    """Return the elastic displacement U = Phi eta in body axes.

    Parameters
    ----------
    data : ModalNeutralData
    eta : (nt, m), m
    nodes : (k,) int, optional
        All nodes by default.

    Returns
    -------
    (nt, k, 3), m
    """
    shapes = data.shapes if nodes is None else data.shapes[_checked(data, nodes)]
    return _superposed(shapes, eta)


def rotation_matrices(p) -> np.ndarray:
    """Return the rotation matrices (nt, 3, 3) of Euler parameters (nt, 4)."""
    p = np.ascontiguousarray(p, float)
    R = np.empty((len(p), 3, 3))
    _fill_matrices(p, R)
    return R


@kernel
def _fill_matrices(p, R):
    for k in range(p.shape[0]):
        euler_to_matrix(p[k], R[k])


def positions(data, q, nodes=None) -> np.ndarray:
    """Return positions of nodes in W, ``x = r + R (X + Phi eta)``: (nt, k, 3), m, from q (nt, 7 + m)."""
    q = np.atleast_2d(np.asarray(q, float))
    X = data.nodes if nodes is None else data.nodes[_checked(data, nodes)]
    local = X + displacement(data, q[:, 7:], nodes)
    return q[:, None, :3] + local @ rotation_matrices(q[:, 3:7]).transpose(0, 2, 1)


def velocities(data, q, u, nodes=None) -> np.ndarray:
    """Return velocities of nodes in W, ``R (v + w x (X + Phi eta) + Phi eta')``: (nt, k, 3), m/s.

    Parameters
    ----------
    data : ModalNeutralData
    q : (nt, 7 + m)
    u : (nt, 6 + m)
    nodes : (k,) int, optional
        All nodes by default.
    """
    q, u = (np.atleast_2d(np.asarray(x, float)) for x in (q, u))
    X = data.nodes if nodes is None else data.nodes[_checked(data, nodes)]
    local = X + displacement(data, q[:, 7:], nodes)
    rate = u[:, None, :3] + np.cross(u[:, None, 3:6], local) + displacement(data, u[:, 6:], nodes)
    return rate @ rotation_matrices(q[:, 3:7]).transpose(0, 2, 1)


def strain_energy(data, eta) -> np.ndarray:
    """Return the strain energy of the body ``1/2 eta . K eta``, (nt,), J."""
    eta = np.atleast_2d(np.asarray(eta, float))
    return 0.5 * np.einsum("ti,ij,tj->t", eta, data.stiffness, eta)


def stress(data, eta, nodes=None) -> np.ndarray:
    """Return the nodal stress xx, yy, zz, xy, yz, zx in body axes: (nt, k, 6), Pa."""
    return _superposed(_stress_modes(data, nodes), eta)


def _superposed(modes, eta):
    """Return the sum of modes (k, c, m) times eta (nt, m): (nt, k, c)."""
    eta = np.atleast_2d(np.asarray(eta, float))
    flat = modes.reshape(modes.shape[0] * modes.shape[1], modes.shape[2])  # also for a body without modes
    if len(eta) == 1:  # the product with one vector reads the modes in their order, several times faster
        return (flat @ eta[0]).reshape(1, *modes.shape[:2])
    return (eta @ flat.T).reshape(len(eta), *modes.shape[:2])


@kernel
def _von_mises(sigma, out):
    """``s_v^2 = ((xx-yy)^2 + (yy-zz)^2 + (zz-xx)^2)/2 + 3 (xy^2 + yz^2 + zx^2)``."""
    for k in range(sigma.shape[0]):
        xx, yy, zz, xy, yz, zx = sigma[k, 0], sigma[k, 1], sigma[k, 2], sigma[k, 3], sigma[k, 4], sigma[k, 5]
        normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        out[k] = (0.5 * normal + 3.0 * (xy * xy + yz * yz + zx * zx)) ** 0.5


def von_mises(sigma) -> np.ndarray:
    """Return the von Mises stress (...,), Pa, of stresses (..., 6) ordered xx, yy, zz, xy, yz, zx."""
    sigma = np.ascontiguousarray(sigma, float)
    out = np.empty(sigma.shape[:-1])
    _von_mises(sigma.reshape(-1, 6), out.reshape(-1))
    return out


def principal(sigma) -> np.ndarray:
    """Return the principal stresses (..., 3), Pa, the greatest first, of stresses (..., 6) ordered xx, yy,
    zz, xy, yz, zx.
    """
    sigma = np.asarray(sigma, float)
    return np.linalg.eigvalsh(sigma[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]])[..., ::-1]


def largest_von_mises(data, eta, nodes=None) -> np.ndarray:
    """Return the largest von Mises stress among nodes (all by default) at each time: (nt,), Pa."""
    return np.concatenate([np.nanmax(values, axis=1) for _, values in _von_mises_pieces(data, eta, nodes)])


def von_mises_envelope(data, t, eta, nodes=None) -> Envelope:
    """Return the largest von Mises stress of each node over time, Pa, and the time at which it occurred, s."""
    t = np.atleast_1d(np.asarray(t, float))
    n = len(data.nodes) if nodes is None else len(np.atleast_1d(nodes))
    value, time = np.full(n, -1.0), np.full(n, t[0])
    for start, values in _von_mises_pieces(data, eta, nodes):
        k = np.argmax(values, axis=0)
        highest = np.take_along_axis(values, k[None], 0)[0]
        time = np.where(highest > value, t[start + k], time)
        value = np.maximum(value, highest)
    return Envelope(value, time)


def _von_mises_pieces(data, eta, nodes):
    """Yield (first time index, von Mises stress (times of the piece, k))."""
    S = _stress_modes(data, nodes)
    eta = np.atleast_2d(np.asarray(eta, float))
    step = max(1, CHUNK // (6 * len(S)))
    for start in range(0, len(eta), step):
        yield start, von_mises(_superposed(S, eta[start : start + step]))


def element_stress(data, eta, block, cells=None) -> np.ndarray:
    """Return the stress xx, yy, zz, xy, yz, zx at the nodes of single elements: (nt, ne, nodes of a cell, 6), Pa, body
    axes.

    Nodal stress is a mean over the cells at a node; how far these differ there tells the error of the mesh.

    Parameters
    ----------
    data : ModalNeutralData
        Reduced from an FE model of solids or shells.
    eta : (nt, m)
    block : SolidBlock or ShellBlock
        The elements of that FE model, ``fe.blocks[0]``.
    cells : (ne,) int, optional
        Rows of ``block.connectivity``; all by default.
    """
    shapes = data.shapes
    at_elements = getattr(block, "element_stress", None)
    if at_elements is None or block.connectivity.max() >= len(shapes):
        raise ModelError(
            f"Modal neutral data '{data.name}'",
            found=f"a {type(block).__name__} that cannot give it stress",
            expected="the solids or shells of the FE model that was reduced",
            remedy="Give fe.blocks[0] of that model; beams have recover.section_forces",
        )
    turned = np.zeros_like(shapes) if data.rotation_shapes is None else data.rotation_shapes
    cells = None if cells is None else np.atleast_1d(np.asarray(cells, int))
    modes = at_elements(np.concatenate([shapes, turned], axis=1), cells)  # (ne, c, 6, m)
    return np.einsum("tm,encm->tenc", np.atleast_2d(np.asarray(eta, float)), modes, optimize=True).reshape(
        -1, *modes.shape[:3]
    )


def section_forces(data, eta, block) -> np.ndarray:
    """Return N, V_y, V_z (N), M_x, M_y, M_z (N m) at both ends of every beam: (nt, ne, 2, 6), in the beam's axes.

    Parameters
    ----------
    data : ModalNeutralData
        Reduced from an FE model of frames.
    eta : (nt, m)
    block : FrameBlock
        The beams of that FE model, ``fe.blocks[0]``.
    """
    if data.rotation_shapes is None or not hasattr(block, "section_forces"):
        raise ModelError(
            f"Modal neutral data '{data.name}'",
            found=f"{type(block).__name__} has no section forces",
            expected="beams with rotations at their nodes",
            remedy="Give the block of the FE model that fem.frame made and that was reduced",
        )
    modes = block.section_forces(np.concatenate([data.shapes, data.rotation_shapes], axis=1))  # (ne, 2, 6, m)
    return np.einsum("tm,ecfm->tecf", np.atleast_2d(np.asarray(eta, float)), modes)


def line_forces(body, q, fractions) -> np.ndarray:
    """Return the section forces of a cable or beam at fractions (n,) of its length: (nt, n, 3 or 6), as SectionForces.

    Parameters
    ----------
    body : AncfCable or AncfBeam
    q : (nt, nq)
        Its coordinates at the wanted times: ``solution.series().coordinates(body.name)[0]``.
    fractions : (n,)
    """
    return _along(body, "section_forces", q, fractions)


def line_strains(body, q, fractions) -> np.ndarray:
    """Return the strains of a cable or beam at fractions (n,) of its length: (nt, n, 2 or 6), as SectionStrains."""
    return _along(body, "section_strains", q, fractions)


def _along(body, quantity: str, q, fractions) -> np.ndarray:
    if body.drawn != "line":
        raise ModelError(
            body.title,
            found=f"a {type(body).__name__} is not a line",
            expected="an AncfCable or AncfBeam",
            remedy="Section forces of reduced frames are given by recover.section_forces",
        )
    given, fractions = fractions, np.atleast_1d(finite_array(fractions))
    if not fractions.size or fractions.ndim > 1 or fractions.min() < 0.0 or fractions.max() > 1.0:
        raise ModelError(
            body.title,
            found=f"fractions = {given!r}",
            expected="fractions of the length, 0 to 1",
            remedy="Write numpy.linspace(0, 1, 21)",
        )
    q, size = np.atleast_2d(np.asarray(q, float)), len(body.initial_state()[0])
    if q.ndim != 2 or q.shape[1] != size:
        raise ModelError(
            body.title,
            found=f"coordinates of shape {q.shape}",
            expected=f"(nt, {size})",
            remedy="Take the coordinates of the body: solution.series().coordinates(body.name)[0]",
        )
    return np.array([getattr(body, quantity)(row, fractions) for row in q])


def _stress_modes(data, nodes):
    if data.stress_modes is None:
        raise ModelError(
            f"Modal neutral data '{data.name}'",
            found="there are no stress modes",
            expected="data reduced from an FE model with elements",
            remedy="Reduce a model made by fem.solid or fem.shell; matrices alone carry no stress",
        )
    return data.stress_modes if nodes is None else data.stress_modes[_checked(data, nodes)]


def _checked(data, nodes):
    nodes = np.atleast_1d(np.asarray(nodes, int))
    if len(nodes) and (nodes.min() < 0 or nodes.max() >= len(data.nodes)):
        wrong = nodes[(nodes < 0) | (nodes >= len(data.nodes))][0]
        raise ModelError(
            f"Modal neutral data '{data.name}'",
            found=f"node {wrong}",
            expected=f"node numbers 0 to {len(data.nodes) - 1}",
            remedy="Choose nodes of data.nodes",
        )
    return nodes
