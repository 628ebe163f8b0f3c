"""`Slot`: the walls of a curved track of constant width."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import finite_array
from flexmb.profiles.pieces import Segments, cubics
from flexmb.profiles.profile import Profile
from flexmb.profiles.segments import ARC

__all__ = ["Slot"]

DENSE = 16
"""Points of a wall between two points of the path."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Slot(Profile):
    """A track of constant width around the cubic spline through points, with round ends; the material lies around it.

    Parameters
    ----------
    through : (n, 2), m
        The path of the middle of the track.
    width : float, m
        From wall to wall: the diameter of the roller and its play.

    Raises
    ------
    ModelError
        The path bends more sharply than half the width.
    """

    through: Any
    width: float

    def __post_init__(self):
        through = finite_array(self.through)
        if through.ndim != 2 or through.shape[1:] != (2,) or len(through) < 2:
            raise ModelError(
                self.title,
                found=f"through = {self.through!r:.60}",
                expected="two points (n, 2) or more, m",
                remedy="Write through=[(0, 0), (0.1, 0.02), (0.2, 0)]",
            )
        object.__setattr__(self, "through", tuple(map(tuple, through.tolist())))
        self.require_positive("width")
        super().__post_init__()

    def segments(self) -> tuple[Segments, bool]:
        """Return both walls and the arcs at the ends, walked clockwise."""
        points = np.array(self.through)
        h = np.linspace(0.0, 1.0, DENSE, endpoint=False)[:, None]
        places, firsts, seconds = [], [], []
        for _, numbers in cubics(points, "not-a-knot" if len(points) > 3 else "natural", self.title):
            x = numbers.reshape(2, 4)
            at = np.append(h, [[1.0]], axis=0) if not len(places) + 1 < len(points) - 1 else h
            places.append(x[:, 0] + at * (x[:, 1] + at * (x[:, 2] + at * x[:, 3])))
            firsts.append(x[:, 1] + at * (2.0 * x[:, 2] + 3.0 * at * x[:, 3]))
            seconds.append(2.0 * x[:, 2] + 6.0 * at * x[:, 3])
        c, d, dd = (np.concatenate(entries) for entries in (places, firsts, seconds))
        speed = np.linalg.norm(d, axis=1)
        bend = np.abs(d[:, 0] * dd[:, 1] - d[:, 1] * dd[:, 0]) / speed**3
        if bend.max() * self.width >= 2.0:
            k = int(np.argmax(bend))
            raise ModelError(
                self.title,
                found=f"a radius of {1.0 / bend[k]:.6g} m at ({c[k, 0]:.6g}, {c[k, 1]:.6g}) m",
                expected=f"more than half the width, {0.5 * self.width:.6g} m",
                remedy="Bend the path less, or make the track narrower",
            )
        t = d / speed[:, None]
        across = 0.5 * self.width * np.column_stack([-t[:, 1], t[:, 0]])
        left = cubics(c + across, ((1, t[0]), (1, t[-1])), self.title)
        right = cubics((c - across)[::-1], ((1, -t[-1]), (1, -t[0])), self.title)
        ends = [
            (ARC, np.array([*c[k], 0.5 * self.width, np.arctan2(sense * across[k, 1], sense * across[k, 0]), -np.pi]))
            for k, sense in ((-1, 1.0), (0, -1.0))
        ]
        return [*left, ends[0], *right, ends[1]], True
