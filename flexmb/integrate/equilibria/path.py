"""Path following: equilibria that depend on a load factor t, from point to point by arc length.

With x = (q, lam, t) the equilibria R(q, lam, t) = 0, g(q, t) = 0 form a curve. From a point with the unit tangent T the
next one is sought in the plane across T at the distance s (Riks 1979; Wempner 1971). The matrix of Newton's method,
bordered by T, stays regular where the load has an extremum (Keller 1977). Length counts displacements relative to the
largest so far, and loads relative to the load to be reached: eq. (arc-length).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from flexmb.integrate.extent import extents
from flexmb.integrate.matrices import stiffness_at
from flexmb.math.weights import no_matrix
from flexmb.system.program import advance, evaluate, increment, keep_branches

__all__ = ["EquilibriumPath", "Point"]

SOFTEST = 1e-6
"""Stiffness of a freedom, relative to the largest, below which it does not count."""
ITERATIONS = 10
"""Most corrections of a point; beyond, a shorter arc is cheaper."""


class Point(NamedTuple):
    """A point of the path: q (nq,), lam (ng,), load t, unit tangent (nu + ng + 1,), the sign of the bordered
    determinant (it changes at a bifurcation) and the number of corrections that it took."""

    q: np.ndarray
    lam: np.ndarray
    t: float
    tangent: np.ndarray
    sign: float
    iterations: int = 0


class EquilibriumPath:
    """The equations of equilibrium of a system and their solution at a given distance from a known point.

    Parameters
    ----------
    system : System
    start : State
        A configuration, for the lengths that make increments comparable.
    span : float
        Load that counts as length one.
    tolerance : float
        Largest unbalanced force relative to the largest reaction or load.
    """

    def __init__(self, system, start, span: float, tolerance: float):
        self.system, self.work, self.span, self.tolerance = system, system.workspace(), span, tolerance
        self.size = system.lengths.whole
        self.extent, _ = extents(system, start, self.work)
        self.first = start.q
        self.largest = 0.0
        self._weigh(self.size)

    def _weigh(self, reach: float) -> None:
        """Let a root mean square displacement of `reach` (m) count as much as the whole load."""
        self.reach = reach
        nu, ng = self.system.nu, self.system.ng
        self.metric = np.concatenate([(self.extent / reach) ** 2 / nu, np.zeros(ng), [1.0]])

    def begin(self, q, lam, t: float, direction: float) -> Point | None:
        """Return the equilibrium near q at the load t, with the tangent along which the load goes in `direction`."""
        up = np.zeros(len(self.metric))
        up[-1] = direction
        point = self.solve(Point(q, lam, t, up, 0.0), 0.0)
        if point is None:
            return None
        self.first = point.q
        # at first, the displacement that the whole load would make if it went on as it begins
        linear = self.reach * (1.0 / max(point.tangent[-1] ** 2, 1e-12) - 1.0) ** 0.5
        return self._reweighed(point, min(max(linear, 1e-6 * self.size), self.size))

    def reached(self, point: Point) -> Point:
        """Return a point with the tangent of unit length, where displacements count relative to the largest so far."""
        d = np.zeros(self.system.nu)
        increment(self.system.program, self.first, point.q, d)
        return self._reweighed(point, max(self.reach, float(np.sqrt(np.mean((d * self.extent) ** 2)))))

    def _reweighed(self, point: Point, reach: float) -> Point:
        self._weigh(reach)
        return point._replace(tangent=point.tangent / self.length(point.tangent))

    def solve(self, base: Point, s: float) -> Point | None:
        """Return the point in the plane at the distance s from a point, or None if the corrections do not converge."""
        nu, ng = self.system.nu, self.system.ng
        q, lam, t = self._moved(base.q, base.lam, base.t, s * base.tangent)
        for iteration in range(ITERATIONS):
            matrix, rest, here = self._linearised(q, lam, t, base.tangent)
            if not np.all(np.isfinite(rest)):
                return None
            try:
                factor = splu(matrix)
            except RuntimeError:  # exactly singular
                return None
            force = np.max(np.abs(rest[:nu] / self.extent))
            gap = np.max(np.abs(rest[nu : nu + ng]), initial=0.0)
            step = factor.solve(-rest)
            stride = np.max(np.abs(step[:nu] * self.extent)) / self.size
            # of this place and the points found: reactions of corrections that led nowhere would balance any force
            largest = max(self.largest, here)
            balanced = force <= self.tolerance * max(largest, 1e-30) and gap <= 1e-9 * self.size
            # stiff parts: what is left of their forces is what rounding the positions makes
            if balanced or (stride <= 1e-13 and force <= 1e2 * self.tolerance * largest):
                self.largest = largest
                keep_branches(self.system.program, self.work, q)
                tangent = factor.solve(np.append(np.zeros(nu + ng), 1.0))
                return Point(q, lam, t, tangent / self.length(tangent), _sign(factor), iteration)
            if not stride <= 1.0:
                return None
            q, lam, t = self._moved(q, lam, t, step)
        return None

    def locate(self, base: Point, end: Point, value: Callable[[Point], float], close: float) -> Point | None:
        """Return the point between two at which a value that changes sign is as close to zero (Illinois method)."""
        low, high, f_low, f_high = 0.0, self.along(base, end), value(base), value(end)
        found = None
        for _ in range(40):
            s = (low * f_high - high * f_low) / (f_high - f_low)
            point = self.solve(base, s)
            if point is None:
                return found
            found, f = point, value(point)
            if abs(f) <= close or abs(high - low) <= 1e-14 * abs(high):
                break
            if f * f_high < 0.0:
                low, f_low = high, f_high
            else:
                f_low *= 0.5
            high, f_high = s, f
        return found

    def bisect(self, base: Point, end: Point, halvings: int = 12) -> Point:
        """Return a point just after the bifurcation between two points."""
        low, high = 0.0, self.along(base, end)
        for _ in range(halvings):
            point = self.solve(base, 0.5 * (low + high))
            if point is None:
                break
            if point.sign == base.sign:
                low = 0.5 * (low + high)
            else:
                high, end = 0.5 * (low + high), point
        return end

    def along(self, base: Point, end: Point) -> float:
        """Return the distance of a point's plane from the base."""
        d = np.zeros(self.system.nu)
        increment(self.system.program, base.q, end.q, d)
        d = np.concatenate([d, np.zeros(self.system.ng), [(end.t - base.t) / self.span]])
        return float(np.dot(self.metric * base.tangent, d)) / self.length(base.tangent) ** 2

    def length(self, x: np.ndarray) -> float:
        """Return the length of an increment."""
        return float(np.sqrt(np.dot(self.metric, x * x)))

    def cosine(self, a: Point, b: Point) -> float:
        """Return the cosine between the tangents at two points."""
        return float(np.dot(self.metric * a.tangent, b.tangent)) / (self.length(a.tangent) * self.length(b.tangent))

    def foremost(self, point: Point) -> str:
        """Return the title of the body that moves most along the path."""
        k = int(np.argmax(np.abs(point.tangent[: self.system.nu] * self.extent)))
        return self.system.owner(k).partition(",")[0]

    def loose(self, state) -> str:
        """Say which body has a freedom that nothing holds, if one has no stiffness at all and no joint."""
        K, _, G = stiffness_at(self.system, state, self.work)
        held = np.asarray(abs(K).sum(axis=1)).ravel() + np.asarray(abs(G).sum(axis=0)).ravel()
        return f": nothing holds {self.system.owner(int(np.argmin(held)))}" if np.min(held) == 0.0 else ""

    def _moved(self, q, lam, t, x):
        nu, ng = self.system.nu, self.system.ng
        new = np.zeros(self.system.nq)
        advance(self.system.program, q, np.ascontiguousarray(x[:nu]), 1.0, new)
        return new, lam + x[nu : nu + ng], t + self.span * x[-1]

    def _residual(self, q, lam, t) -> np.ndarray:
        no_matrix(self.work.weights)
        evaluate(self.system.program, self.system.state(t, q, u=np.zeros(self.system.nu), lam=lam), self.work)
        return np.concatenate([self.work.residual, self.work.equations["g"]])

    def _linearised(self, q, lam, t, tangent):
        """Return the bordered matrix, the residual with a zero for the plane, and the largest reaction or load."""
        h = 1e-4 * self.span
        later = self._residual(q, lam, t + h)
        K, L, G = stiffness_at(self.system, self.system.state(t, q, u=np.zeros(self.system.nu), lam=lam), self.work)
        rest = np.concatenate([self.work.residual, self.work.equations["g"]])
        slope = (later - rest) * (self.span / h)
        nu = self.system.nu
        reactions = abs(L) @ np.abs(lam)
        forces = np.maximum(reactions, np.abs(slope[:nu])) / self.extent
        soft = 1e-12 * (abs(G).power(2) @ (1.0 / self._stiffness(K)))
        soft = np.maximum(soft, 1e-6 * np.max(soft, initial=0.0))
        border = sparse.csr_matrix(self.metric * tangent)
        n = nu + self.system.ng
        matrix = sparse.bmat(
            [
                [K, -L, slope[:nu, None]],
                [G, -sparse.diags(soft), slope[nu:, None]],
                [border[:, :nu], border[:, nu:n], border[:, n:]],
            ],
            format="csc",
        )
        return matrix, np.append(rest, 0.0), float(np.max(forces, initial=0.0))

    def _stiffness(self, K) -> np.ndarray:
        """Return the size of the diagonal of K (nu,), with a floor: rounding in it is no softness, and an equation
        between freedoms without stiffness must not yield.
        """
        size = abs(K.diagonal()) / self.extent**2
        stiffest = float(np.max(size, initial=0.0))
        return np.maximum(size, SOFTEST * stiffest if stiffest > 0.0 else 1.0) * self.extent**2


def _sign(factor) -> float:
    """Return the sign of the determinant of a factorised matrix."""
    negative = int(np.sum(factor.U.diagonal() < 0.0)) + _odd(factor.perm_r) + _odd(factor.perm_c)
    return -1.0 if negative % 2 else 1.0


def _odd(permutation) -> int:
    """Return 1 for an odd permutation: by its number of even cycles."""
    seen = np.zeros(len(permutation), bool)
    even = 0
    for k in range(len(permutation)):
        length = 0
        while not seen[k]:
            seen[k] = True
            k = int(permutation[k])
            length += 1
        even += length > 0 and length % 2 == 0
    return even % 2
