"""`Capsule`: a round bar with round ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmb.surfaces.bar import Bar
from flexmb.surfaces.edges import LINE, Edges
from flexmb.surfaces.revolved import frustum, patches
from flexmb.surfaces.shape import Points
from flexmb.surfaces.sphere import on_unit_sphere

__all__ = ["Capsule"]


@dataclass(frozen=True, eq=False)
class Capsule(Bar):
    """All points within `radius`, m, of a line of `length`, m, along the z-axis, whose middle is the marker."""

    code: ClassVar[int] = 3
    edged: ClassVar[bool] = True

    @property
    def reach(self) -> float:
        """Distance of its poles, m."""
        return self.radius + 0.5 * self.length

    def corners(self) -> tuple[np.ndarray, float]:
        """Return the ends of the line, and the radius."""
        return np.array([(0, 0, -0.5 * self.length), (0, 0, 0.5 * self.length)]), self.radius

    @property
    def edges(self) -> Edges:
        """The line between its ends, which is rounded by the radius."""
        line = np.zeros((1, LINE))
        line[0, [2, 5]] = -0.5 * self.length, 0.5 * self.length
        return Edges(line, line[0, :6].reshape(2, 3), np.zeros((2, 3)), [], self.radius)

    def samples(self, spacing: float) -> Points:
        """Return points of the side and of the two half-spheres."""
        r, h = self.radius, 0.5 * self.length
        side = frustum((r, -h), (r, h), spacing)
        area = 4.0 * np.pi * r * r
        n = on_unit_sphere(2 * max(2, round(0.5 * area / spacing / spacing)))
        ends = r * n + np.where(n[:, 2:] > 0.0, h, -h) * (0, 0, 1)
        return (
            np.concatenate([side[0], ends]),
            np.concatenate([side[1], n]),
            np.concatenate([side[2], np.full(len(n), area / len(n))]),
        )

    def drawing(self) -> tuple[np.ndarray, np.ndarray]:
        """Return side and ends."""
        angle = np.linspace(0.0, 0.5 * np.pi, 9)
        rho, z = self.radius * np.cos(angle), self.radius * np.sin(angle) + 0.5 * self.length
        return patches(np.concatenate([rho[::-1], rho]), np.concatenate([-z[::-1], z]))
