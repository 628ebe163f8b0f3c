"""Plates for drawing: both faces and the rim of the deformed sheet, with strains and stress resultants as fields."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.plate.forces import at_fractions
from flexmb.bodies.plate.places import at_point

__all__ = ["PlateSurface"]

PIECES = 2
"""Pieces of an element along each side."""
STRAINS = ("E11", "E22", "2E12", "K11", "K22", "2K12")
RESULTANTS = ("N11", "N22", "N12", "M11", "M22", "M12", "Q1", "Q2")


class PlateSurface:
    """The surface of an `AncfPlate` with its thickness.

    Parameters
    ----------
    body : AncfPlate

    Attributes
    ----------
    cells : tuple of (cell type, connectivity)
    fields : tuple of str
        Names of the scalars at the points: strains E (-), curvatures K (1/m), forces N, Q (N/m), moments M (N).
    """

    fields = STRAINS + RESULTANTS

    def __init__(self, body):
        self.body = body
        ns, nt = (PIECES * n for n in body.elements)
        s, t = np.meshgrid(np.linspace(0.0, 1.0, ns + 1), np.linspace(0.0, 1.0, nt + 1), indexing="ij")
        self.fractions = np.stack([s.ravel(), t.ravel()], axis=1)
        places = [at_point(body, *z) for z in self.fractions]
        self.nodes, self.weights = np.array([p[0] for p in places]), np.array([p[1] for p in places])
        self.half = 0.5 * body.thickness_at(*self.fractions.T)
        number = np.arange((ns + 1) * (nt + 1)).reshape(ns + 1, nt + 1)
        quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
        rim = np.concatenate([number[:, 0], number[-1, 1:], number[-2::-1, -1], number[0, -2:0:-1]])
        n, m = number.size, len(rim)
        # the rim has points of its own, so that edges stay sharp: top, bottom, upper and lower rim
        self.of = np.concatenate([np.arange(n), np.arange(n), rim, rim])
        self.side = np.repeat([1.0, -1.0, 1.0, -1.0], [n, n, m, m])
        i = np.arange(m)
        j = (i + 1) % m
        band = 2 * n + np.stack([i, m + i, m + j, j], axis=1)
        self.cells = (("quad", np.vstack([quads, n + quads[:, ::-1], band])),)

    def points(self, q: np.ndarray) -> np.ndarray:
        """Return the points (n, 3), m, in W for the body's coordinates q (nq,)."""
        r, normal = self.body.surface_points(q, self.nodes, self.weights)
        return r[self.of] + (self.side * self.half[self.of])[:, None] * normal[self.of]

    def values(self, q: np.ndarray) -> dict[str, np.ndarray]:
        """Return strains and stress resultants at the points by name, (n,)."""
        strains = at_fractions(self.body.strains(q)[:, :6], self.body.elements, self.fractions)
        both = np.hstack([strains, self.body.resultants(q, self.fractions)])[self.of]
        return {name: both[:, k] for k, name in enumerate(self.fields)}
