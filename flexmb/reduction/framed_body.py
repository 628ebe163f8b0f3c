"""An elastic body as its frame sees it: its static response, its modes and its response at a frequency.

In the Buckens frame the body is free, loads are balanced by rigid inertia and no rigid motion is left in a response;
a frame that is clamped at an interface holds the body there. Everything comes from the factorisation of `HeldBody`.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.errors import ReductionError
from flexmb.math.lanczos import lowest_modes
from flexmb.reduction.basis import NormalModes
from flexmb.reduction.geometric import inertia_loads
from flexmb.reduction.markers import MarkerMotion
from flexmb.reduction.statics import HeldBody

__all__ = ["FramedBody"]

_CLEAR = 2.0  # the modes that are known reach this many times beyond the frequency of a response
_ROUNDS = 16  # of Chebyshev's iteration: spectrum in [3/4, 1], so each gains more than a digit
MOST_KNOWN = 1000
"""Modes up to a frequency from which it is called out of reach: they cost more time and memory than the part itself."""
_NEAR = 1e-6  # relative distance of a squared frequency from a mode's below which the mode itself is the response


class FramedBody:
    """A body with its frame, and where it is loaded.

    Parameters
    ----------
    body : HeldBody
    frame : int or None
        Interface at which the frame is clamped; None for the Buckens frame.
    markers : list of MarkerMotion
        Interfaces, then stations.
    loads, joining : (ndof, k), N
        Load shapes of the body, and those whose response joins the basis (all unless given).

    Attributes
    ----------
    inputs : (ndof, nb)
        Loads of one newton: on each interface freedom (moments of 1 N times the size of the body; not on the one that
        holds the frame), and of each load shape.
    excitation : (ndof, k)
        The inputs of interfaces and of joining loads, and the inertia forces of the frame where it is clamped: what a
        mechanism loads the body with.
    outputs : (ndof, no)
        Unit loads at the stations: what reads them.
    """

    def __init__(
        self,
        body: HeldBody,
        frame: int | None,
        markers: list[MarkerMotion],
        loads: np.ndarray,
        joining: np.ndarray | None = None,
    ):
        self.body, self.frame, self._markers = body, frame, markers
        self._loads, self._joining = loads, loads if joining is None else joining
        self._modes = NormalModes(np.zeros((body.fe.ndof, 0)), np.zeros(0))
        self._all_found = False
        self._found: dict[Hashable, Any] = {}

    def freed(self) -> FramedBody:
        """Return the body in the Buckens frame: what is said of errors does not depend on the frame."""
        if self.frame is None:
            return self
        return FramedBody(self.body, None, self._markers, self._loads, self._joining)

    def without_joining(self) -> FramedBody:
        """Return the body without loads that join the basis; modes that are known stay known."""
        alone = FramedBody(self.body, self.frame, self._markers, self._loads, self._loads[:, :0])
        alone._modes, alone._all_found, alone._found = self._modes, self._all_found, self._found
        return alone

    @cached_property
    def _at_interfaces(self) -> np.ndarray:
        """Loads of one newton on interface freedoms, (ndof, k)."""
        body, columns = self.body, [np.zeros((self.body.fe.ndof, 0))]
        scale = body.coordinate_scale()
        for number, (coupling, marker, where) in enumerate(zip(body.couplings, self._markers, body.slices)):
            if number != self.frame:
                columns.append(marker.matrix[coupling.freedoms].T.toarray() * scale[where])
        return np.hstack(columns)

    @property
    def at_interfaces(self) -> int:
        """How many of the inputs act on interfaces; they come first."""
        return self._at_interfaces.shape[1]

    @cached_property
    def inputs(self) -> np.ndarray:
        """Loads of one newton on interface freedoms, and of each load shape, (ndof, nb)."""
        return np.hstack([self._at_interfaces, _one_newton(self._loads)])

    @property
    def load_sizes(self) -> np.ndarray:
        """Sum of the nodal forces of each load shape, (nl,), N: what makes one of its unit of an input."""
        return np.abs(self._loads).sum(axis=0)

    @cached_property
    def spin(self) -> np.ndarray:
        """Inertia forces of the symmetric acceleration fields: xx, yy, zz, xy, yz, zx, (ndof, 6), N s2.

        Whatever angular velocity the body has, its centrifugal load is made of them.
        """
        gradients = inertia_loads(self.body.fe)[:, 3:].reshape(-1, 3, 3)
        same = [gradients[:, k, k] for k in range(3)]
        return np.column_stack([*same, *(gradients[:, k, l] + gradients[:, l, k] for k, l in ((0, 1), (1, 2), (2, 0)))])

    @cached_property
    def excitation(self) -> np.ndarray:
        """What a mechanism loads the body with, (ndof, k)."""
        fe, none = self.body.fe, np.zeros((self.body.fe.ndof, 0))
        inertia = none if self.frame is None else _one_newton(fe.M @ self.body.rigid)
        return np.hstack([self._at_interfaces, _one_newton(self._joining), inertia])

    @cached_property
    def outputs(self) -> np.ndarray:
        """Unit loads at the stations, (ndof, no)."""
        stations = [marker.matrix.T.toarray() for marker in self._markers[len(self.body.couplings) :]]
        whole = np.hstack([np.zeros((self.body.fe.ndof, 0)), *stations])
        return whole[:, np.any(whole != 0.0, axis=0)]

    def elastic(self, vectors: np.ndarray) -> np.ndarray:
        """Return displacements (ndof, k) as the frame sees them: less the rigid motion of the frame."""
        if self.frame is None:
            return self.body.without_rigid(vectors)
        where = self.body.slices[self.frame]
        motion = self.body.coordinates(vectors)[where]
        return vectors - self.body.rigid @ np.linalg.solve(self.body.rigid_coordinates[where], motion)

    def solve(self, forces: np.ndarray) -> np.ndarray:
        """Return the static elastic response (ndof, k) to forces (ndof, k)."""
        if self.frame is None:
            return self.body.solve_free(forces)
        where = self.body.slices[self.frame]
        return self.body.solve_supported(forces, np.arange(where.start, where.stop))

    def once(self, key: Hashable, find: Callable[[], Any]) -> Any:
        """Return what `find` returned when this key was asked for first. It must not depend on loads."""
        if key not in self._found:
            self._found[key] = find()
        return self._found[key]

    def modes(self, count: int) -> NormalModes:
        """Return the lowest elastic modes in this frame: `count`, or as many as there are."""
        if count > len(self._modes.w2) and not self._all_found:
            fe, most = self.body.fe, self.body.fe.ndof - self.body.rigid.shape[1]
            w2, vectors = lowest_modes(
                self.solve, lambda x: fe.M @ x, fe.ndof, min(count, most), start=self._modes.vectors
            )
            self._modes, self._all_found = NormalModes(vectors, w2), len(w2) < count
        return NormalModes(self._modes.vectors[:, :count], self._modes.w2[:count])

    def modes_beyond(self, w2: float) -> NormalModes:
        """Return the modes up to the first one above w2, 1/s2, with this one; all where none is."""
        count = max(8, len(self._modes.w2))
        while True:
            modes = self.modes(min(count, MOST_KNOWN))
            if len(modes.w2) == MOST_KNOWN < count and modes.w2[-1] <= w2:
                raise ReductionError(
                    f"FE model '{self.body.fe.name}'",
                    found=f"more than {MOST_KNOWN} elastic modes below {np.sqrt(w2) / (2.0 * np.pi):.4g} Hz, and "
                    f"{int(np.sum(modes.w2 <= 0.01 * w2))} below a tenth of it",
                    expected="fewer modes up to twice the frequency that is asked for",
                    remedy="Ask for a lower frequency; frequencies are in Hz",
                )
            beyond = np.flatnonzero(modes.w2 > w2)
            if len(beyond):
                return self.modes(int(beyond[0]) + 1)
            if len(modes.w2) < count:
                return modes
            count *= 2

    def modes_in_band(self, limit: float) -> np.ndarray:
        """Return the squared frequencies (k,), 1/s2, of the modes up to `limit`, Hz; of the first where none is."""
        square = (2.0 * np.pi * limit) ** 2
        w2 = self.modes_beyond(square).w2
        return w2[: max(1, int(np.sum(w2 <= square)))]

    def response(self, forces: np.ndarray, w2: float) -> np.ndarray:
        """Return the elastic response ``(K - w2 M)^-1 f`` (ndof, k), m, to harmonic forces without damping.

        The modes up to twice the frequency answer by themselves, what is left by Chebyshev's iteration on
        ``(1 - w2 K^-1 M) x = K^-1 f``, whose spectrum there lies between 3/4 and 1. At a resonance, where the
        response has no bound, it is the mode itself.
        """
        static = self.solve(forces)
        if w2 == 0.0:
            return static
        known, fe = self.modes_beyond(_CLEAR**2 * w2), self.body.fe
        share = known.vectors.T @ forces
        gap = known.w2 - w2
        gap = np.where(np.abs(gap) < _NEAR * w2, _NEAR * w2, gap)
        out = known.vectors @ (share / gap[:, None])

        def rest(x):
            return x - known.vectors @ (known.vectors.T @ (fe.M @ x))

        low = 1.0 - 1.0 / _CLEAR**2
        middle, half = 0.5 * (1.0 + low), 0.5 * (1.0 - low)
        residual = rest(static)
        step, ratio = residual / middle, half / middle
        x = step
        for _ in range(_ROUNDS):  # Saad, Iterative methods for sparse linear systems, 2003, algorithm 12.1
            residual = residual - step + w2 * rest(self.solve(fe.M @ step))
            following = 1.0 / (2.0 * middle / half - ratio)
            step = following * ratio * step + (2.0 * following / half) * residual
            ratio, x = following, x + step
        return out + x


def _one_newton(loads: np.ndarray) -> np.ndarray:
    """Return loads (ndof, k) scaled so that their nodal forces sum up to one newton."""
    size = np.abs(loads).sum(axis=0)
    return loads / np.where(size > 0.0, size, 1.0)
