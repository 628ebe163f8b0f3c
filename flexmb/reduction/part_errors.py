"""What the bases of reduced parts cost the response of the whole that is made of them.

Parts touch each other at their interfaces alone. With the forces ``G_p`` there by unit loads on the whole, a change
``E_p`` of the response of a part changes that of the whole by ``G_p^T E_p G_p``, to first order: K and M are symmetric.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["PartError", "error_of_part", "errors_of_parts"]


@dataclass(frozen=True, eq=False)
class PartError:
    """The error of the response of a part, and the part in freedoms of the whole.

    Parameters
    ----------
    frequencies : (n,), Hz
    matrix : (n, k, k) complex, m/N
        Error of the motion of its interfaces by forces on them; turns times, moments over the size of the part.
    dofs : (m, 2)
        Node and direction, in the whole, of its freedoms: the motions of its interfaces come first.
    K, M : (m, m)
    scale : (k,)
        What makes forces on the interfaces of those on its first freedoms.
    """

    frequencies: np.ndarray
    matrix: np.ndarray
    dofs: np.ndarray
    K: np.ndarray
    M: np.ndarray
    scale: np.ndarray

    def places(self, dofs: np.ndarray) -> np.ndarray | None:
        """Return which of the freedoms (n, 2) of the whole are its own; None where it lacks some."""
        known = {(node, direction): k for k, (node, direction) in enumerate(dofs.tolist())}
        found = [known.get((node, direction), -1) for node, direction in self.dofs.tolist()]
        return None if -1 in found else np.array(found)

    def at(self, hertz: float) -> np.ndarray:
        """Return the error (k, k) at a frequency, Hz."""
        known = self.frequencies
        after = int(np.clip(np.searchsorted(known, hertz), 1, len(known) - 1))
        share = np.clip((hertz - known[after - 1]) / (known[after] - known[after - 1]), 0.0, 1.0)
        return np.asarray((1.0 - share) * self.matrix[after - 1] + share * self.matrix[after])


def error_of_part(quality: Mapping[str, Any], dofs: np.ndarray, K: np.ndarray, M: np.ndarray) -> PartError | None:
    """Return the error of a part from the report of its reduction; None where it has none with phases."""
    told = quality.get("transfer", {})
    if "matrix" not in told or any(len(row["freedoms"]) != 6 for row in quality["interfaces"]):
        return None
    real, imaginary = np.moveaxis(np.array(told["matrix"], float), 1, 0)
    scale = np.tile(np.repeat([1.0, 1.0 / told["length"]], 3), len(quality["interfaces"]))
    return PartError(np.array(told["frequencies"], float), real + 1j * imaginary, dofs, K, M, scale)


def errors_of_parts(
    parts: Sequence[tuple[PartError, np.ndarray | None]], motion: np.ndarray, hertz: float, loss: complex
) -> np.ndarray:
    """Return the error (n, n), m/N, of the response of the whole to n loads, by the bases of its parts.

    Parameters
    ----------
    parts : sequence of (PartError, (m,) of int or None)
        Each with the places of its freedoms in the whole, see `PartError.places`.
    motion : (ndof, n), m
        Of the freedoms of the whole, by the loads, which act on interfaces of parts.
    loss : complex
        ``1 + 2 i zeta``.
    """
    error, w2 = np.zeros((motion.shape[1], motion.shape[1]), complex), (2.0 * np.pi * hertz) ** 2
    for part, places in parts:
        if places is not None:
            count = len(part.scale)
            forces = part.scale[:, None] * ((loss * part.K - w2 * part.M)[:count] @ motion[places])
            error += forces.T @ part.at(hertz) @ forces
    return error
