"""`Bushing`: an elastic joint with six stiffnesses."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.forces.relative import act_relative, add_relative_tangent, relative_motion
from flexmb.math.definiteness import semidefinite, symmetric
from flexmb.math.kernel import inner_kernel
from flexmb.math.rotations import log_euler, matrix_to_euler
from flexmb.math.switches import IDLE, TURN, switch_kernel
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import cross, dot
from flexmb.model.described import finite_array
from flexmb.model.kinds import Force
from flexmb.model.table import Table

__all__ = ["Bushing"]

ROW = np.dtype(
    [
        ("a", np.int64),
        ("b", np.int64),
        ("pair", np.int64),
        ("stiffness", float, (6, 6)),
        ("damping", float, (6, 6)),
    ],
    align=True,
)


@inner_kernel
def _inverse_tangent(phi, A, B, m):
    """Write T^-T = I + 1/2 phi~ + c phi~^2 to `A` and the derivative of T^-T m with respect to phi to `B`.

    c(x) = (1 - x/2 cot x/2) / x^2, x = |phi|.
    """
    x2 = dot(phi, phi)
    if x2 < 1e-2:
        c = 1.0 / 12.0 + x2 / 720.0 + x2 * x2 / 30240.0 + x2**3 / 1209600.0
        dc = 1.0 / 360.0 + x2 / 7560.0 + x2 * x2 / 201600.0
    else:
        x = x2**0.5
        h = 0.5 * x
        g = 1.0 - h / np.tan(h)
        c = g / x2
        dc = (0.5 * (h / np.sin(h) ** 2 - 1.0 / np.tan(h)) / x2 - 2.0 * g / (x2 * x)) / x
    t = np.empty(3)
    s = np.empty(3)
    cross(phi, m, t)
    cross(phi, t, s)
    pm = dot(phi, m)
    for i in range(3):
        for j in range(3):
            A[i, j] = c * phi[i] * phi[j]
            # c (dphi x (phi x m) + phi x (dphi x m)) = c (phi m.dphi + dphi.phi (-2 m) + dphi (phi.m)), and dc
            B[i, j] = c * (phi[i] * m[j] - 2.0 * m[i] * phi[j]) + dc * s[i] * phi[j]
        A[i, i] += 1.0 - c * x2
        B[i, i] += c * pm
        j, k = (i + 1) % 3, (i + 2) % 3
        A[i, j] -= 0.5 * phi[k]
        A[i, k] += 0.5 * phi[j]
        B[i, j] += 0.5 * m[k]
        B[i, k] -= 0.5 * m[j]


@row_kernel
def apply(raw, data, state, work):
    """f = -K (d, phi) - C (d', w) in the axes of a; the moment of the rotation vector is T^-T of its force."""
    rows = raw.view(ROW)
    motion = np.empty(9)
    Q = np.empty((3, 3))
    p = np.empty(4)
    y = np.empty(6)
    h = np.empty(6)
    f = np.empty(6)
    A = np.empty((3, 3))
    B = np.empty((3, 3))
    left = np.empty((6, 6))
    for n in range(rows.shape[0]):
        row = rows[n]
        a, b = work.markers[row.a], work.markers[row.b]
        relative_motion(a, b, motion, Q)
        matrix_to_euler(Q, p)
        y[0:3] = motion[0:3]
        log_euler(p, y[3:6])
        for i in range(6):
            h[i] = 0.0
            f[i] = 0.0
            for j in range(6):
                h[i] += row.stiffness[i, j] * y[j]
                f[i] -= row.damping[i, j] * motion[3 + j]
            work.energy[0].potential += 0.5 * y[i] * h[i]
            work.energy[0].dissipation -= f[i] * motion[3 + i]
        _inverse_tangent(y[3:6], A, B, h[3:6])
        for i in range(3):
            f[i] -= h[i]
            f[3 + i] -= A[i, 0] * h[3] + A[i, 1] * h[4] + A[i, 2] * h[5]
        act_relative(a, b, f)
        if work.weights[0].wanted == 1:
            # df = -P K P^T d(d, psi) - B T^-1 dpsi with P = diag(I, T^-T)
            for i in range(6):
                for j in range(6):
                    left[i, j] = row.stiffness[i, j]
            for j in range(6):
                for i in range(3):
                    h[i] = A[i, 0] * left[3, j] + A[i, 1] * left[4, j] + A[i, 2] * left[5, j]
                    if j >= 3:
                        h[i] += B[i, j - 3]
                for i in range(3):
                    left[3 + i, j] = h[i]
            for i in range(6):
                for j in range(3):
                    h[j] = A[j, 0] * left[i, 3] + A[j, 1] * left[i, 4] + A[j, 2] * left[i, 5]
                for j in range(3):
                    left[i, 3 + j] = h[j]
            add_relative_tangent(work.pairs[row.pair], a, b, f, left, row.damping)


@switch_kernel
def switch(raw, data, state, work, out):
    """The rotation vector, if it has a stiffness: it jumps from one side to the other at half a turn."""
    rows = raw.view(ROW)
    motion = np.empty(9)
    Q = np.empty((3, 3))
    p = np.empty(4)
    for n in range(rows.shape[0]):
        row, turn = rows[n], out[n]
        turn[:] = 0.0
        turn[0] = IDLE
        if np.any(row.stiffness[3:6, 3:6] != 0.0):
            relative_motion(work.markers[row.a], work.markers[row.b], motion, Q)
            matrix_to_euler(Q, p)
            turn[0] = TURN
            log_euler(p, turn[1:4])


@dataclass(frozen=True, eq=False)
class Bushing(Force):
    """Hold two markers together elastically in all six directions, eq. (bushing).

    The force is linear in the displacement d of marker b from marker a and in the rotation vector phi of its axes, both
    in the axes of a. The moment follows from the elastic energy 1/2 (d, phi) K (d, phi), at any rotation below half a
    turn. If a bushing with rotational stiffness turns further, the run ends there.

    Parameters
    ----------
    name : str
    markers : (str, str)
    stiffness : (6,) or (6, 6), N/m and N m/rad
        Along x, y, z and about x, y, z of marker a.
    damping : (6,) or (6, 6), N s/m and N m s/rad
        Of the same motions.
    """

    name: str
    _: KW_ONLY
    markers: tuple[str, str]
    stiffness: Any
    damping: Any = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    holds_turns: ClassVar[bool] = True
    table: ClassVar[Table] = Table("Bushing", ROW, {"apply": apply, "switch": switch}, switches=1)

    def __post_init__(self):
        super().__post_init__()
        self.require_marker_pair()
        for field in ("stiffness", "damping"):
            object.__setattr__(self, field, self._matrix(field))

    def _matrix(self, field: str):
        value = finite_array(getattr(self, field))
        full = np.diag(value) if value.shape == (6,) else value
        good = full.shape == (6, 6) and symmetric(full)
        if not good or not semidefinite(full):
            raise ModelError(
                self.title,
                found=f"{field} = {getattr(self, field)!r}",
                expected="six numbers >= 0, or a symmetric matrix (6, 6) without negative eigenvalues",
                remedy=f"Write {field}=(kx, ky, kz, krx, kry, krz)",
            )
        return tuple(tuple(row) for row in value.tolist()) if value.ndim == 2 else tuple(value.tolist())

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist."""
        for marker in self.markers:
            model.marker(marker, self.title)

    def record(self, compiler):
        """Return the row."""
        a, b = (compiler.marker(name) for name in self.markers)
        K, C = (np.array(x) if np.ndim(x) == 2 else np.diag(x) for x in (self.stiffness, self.damping))
        return {"a": a, "b": b, "pair": compiler.pair(a, b), "stiffness": K, "damping": C}
