"""What makes increments comparable: every velocity as a displacement in metres, every body with its size."""

from __future__ import annotations

import numpy as np

from flexmb.system.mobility import constraint_matrix
from flexmb.system.program import evaluate

__all__ = ["extents", "model_size"]


def model_size(system) -> float:
    """Return the diagonal of the box around all markers as described, m (1 m for a point)."""
    r = system.tables["markers"]["r"]
    size = float(np.linalg.norm(r.max(axis=0) - r.min(axis=0))) if len(r) else 0.0
    return size if size > 0.0 else 1.0


def extents(system, state, work, size: float, smallest: float) -> tuple[np.ndarray, np.ndarray]:
    """Return for every velocity the length that makes its increment a displacement, and the displacement of reference.

    Parameters
    ----------
    size : float, m
        Reference of frames and points.
    smallest : float, m
        Least reference of flexible coordinates; it grows with the deflections that occur.

    Returns
    -------
    extent, reach : (nu,), (nu,)
        Translations have the extent 1, rotations the radius of gyration, flexible coordinates sqrt(M_jj / m): the root
        mean square displacement of the body's material per unit.
    """
    work.coefficients[:] = (1.0, 0.0, 0.0, 1.0, 0.0)
    evaluate(system.program, state, work)
    diagonal = np.abs(constraint_matrix(system, work)[0].diagonal())
    extent, reach = np.ones(system.nu), np.full(system.nu, size)
    for body in system.model.bodies:
        span = system.body_slices[body.name][1]
        if span.stop == span.start:
            continue
        mass = diagonal[span.start]
        extent[span] = np.sqrt(diagonal[span] / mass) if mass > 0.0 else 1.0
        start = span.start
        if body.has_frame:
            # a rotation error of a body moves its markers, not only its mass: at least 1e-3 of the model counts
            extent[start : start + 3] = 1.0
            extent[start + 3 : start + 6] = np.maximum(extent[start + 3 : start + 6], 1e-3 * size)
            start += 6
            reach[start : span.stop] = smallest
        elif body.block_size < body.n_vector:
            # nodes: their positions count as they are, their gradients with the material around the node
            blocks = diagonal[span].reshape(-1, body.block_size)
            extent[span] = np.sqrt(blocks / np.maximum(blocks[:, :1], 1e-300)).ravel()
    return extent, reach
