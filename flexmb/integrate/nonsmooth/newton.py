"""Newton's method on all contacts at once, for piles and jams in which sweeps are slow.

Unknown are all impulses P, xi = D P + q with the mobilities D = W S^-1 W^T between contacts. The laws are the
projections ``P = proj(P - xi / d)`` of Alart & Curnier onto the half-line of normal impulses and onto the discs of
friction, whose radius follows the normal impulse. They are piecewise smooth, and Newton's method ends in a few steps
near the solution. Three ways are tried: steps that are shortened until what is left becomes smaller; whole steps with a
softness, which pass over hills (four legs of a table of which only three can press); contacts that become harder.
In directions in which contacts share a load the impulses are not unique; the smallest step is taken.

Source: Alart & Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991) 353-375.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from flexmb.integrate.nonsmooth.problem import add_impulse
from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["mobility", "newton"]

MOST_BLOCKS = 30_000
"""Pairs of contacts that share a part, above which the matrix costs more than sweeps."""
DENSE = 150
"""Rows up to which the matrix is solved as a full one."""
SOFT = 1e-9
"""Softness of the steps of large problems, relative to the mobility of a contact."""
SOFTER = (1e-6, 1e-4, 1e-8)
"""Softness of steps that are taken whole, where steps downhill get nowhere."""
SOFTEST = (1e-1, 1e-3, 1e-5, 1e-7, 1e-9, 0.0)
"""Softness of contacts on the way to rigid ones."""
STEPS, HALVINGS = 40, 12


@kernel
def _shared(p, parts, blocks, write):
    """Write which contacts (i, j) share a part, and the part, to `blocks` (n, 3) if asked to; return how many."""
    n_parts = len(parts.start) - 1
    count = np.zeros(n_parts + 1, np.int64)
    for i in range(len(p.points)):
        for side in range(2):
            if p.active[i] > 0 and p.spans[i, 2 * side] >= 0:
                count[p.spans[i, 2 * side] + 1] += 1
    for k in range(n_parts):
        count[k + 1] += count[k]
    members = np.empty(count[n_parts], np.int64)
    filled = count[:n_parts].copy()
    for i in range(len(p.points)):
        for side in range(2):
            part = p.spans[i, 2 * side]
            if p.active[i] > 0 and part >= 0:
                members[filled[part]] = i
                filled[part] += 1
    total = 0
    for part in range(n_parts):
        for x in range(count[part], count[part + 1]):
            for y in range(count[part], count[part + 1]):
                if write:
                    blocks[total, 0], blocks[total, 1], blocks[total, 2] = members[x], members[y], part
                total += 1
    return total


@inner_kernel
def _block(p, parts, i, j, part, out):
    """Write the velocity of contact i per impulse of j, through one part, to `out` (rows of i, rows of j)."""
    side = 0 if p.spans[j, 0] == part else 1
    at = p.spans[j, 2 * side + 1]
    size = parts.start[part + 1] - parts.start[part]
    mi, mj = p.rows[i], p.rows[j]
    for leg in range(2):
        iu, nu, w = p.legs[i, 3 * leg], p.legs[i, 3 * leg + 1], p.legs[i, 3 * leg + 2]
        if nu == 0 or parts.of[iu] != part:
            continue
        for n in range(nu):
            place = parts.place[iu + n]
            for r in range(mi):
                x = p.W[w + r * nu + n]
                if x != 0.0:
                    for k in range(mj):
                        out[r, k] += x * p.X[at + k * size + place]


@kernel
def _fill(p, parts, blocks, first, rows, columns, values):
    """Write the entries of D as triplets."""
    out, at = np.empty((6, 6)), 0
    for n in range(len(blocks)):
        i, j = blocks[n, 0], blocks[n, 1]
        out[:] = 0.0
        _block(p, parts, i, j, blocks[n, 2], out)
        for r in range(p.rows[i]):
            for k in range(p.rows[j]):
                rows[at], columns[at], values[at] = first[i] + r, first[j] + k, out[r, k]
                at += 1
    return at


def mobility(p, parts):
    """Return D (csr), the first row of every contact (n + 1,), inactive ones without rows; None if it is too large."""
    total = _shared(p, parts, np.zeros((0, 3), np.int64), False)
    if total > MOST_BLOCKS:
        return None
    blocks = np.zeros((total, 3), np.int64)
    _shared(p, parts, blocks, True)
    first = np.concatenate([[0], np.cumsum(np.where(p.active > 0, p.rows, 0))])
    entries = int(np.sum(p.rows[blocks[:, 0]] * p.rows[blocks[:, 1]]))
    rows, columns, values = np.zeros(entries, np.int64), np.zeros(entries, np.int64), np.zeros(entries)
    _fill(p, parts, blocks, first, rows, columns, values)
    return sparse.csr_matrix((values, (rows, columns)), shape=(first[-1], first[-1])), first


@inner_kernel
def _disc(x, y, z, radius, slope, J, F, P, k, normal):
    """Write the projection of (y, z) onto a disc, and its derivatives, into rows k and k + 1 of F and J."""
    size = (y * y + z * z) ** 0.5
    J[k : k + 2] = 0.0
    if radius <= 0.0:
        F[k], F[k + 1] = P[k], P[k + 1]
        return
    if size <= radius:
        J[k, k] = J[k + 1, k + 1] = 1.0
        F[k], F[k + 1] = P[k] - y, P[k + 1] - z
        return
    c, s = y / size, z / size
    J[k, k], J[k, k + 1] = radius / size * s * s, -radius / size * c * s
    J[k + 1, k], J[k + 1, k + 1] = -radius / size * c * s, radius / size * c * c
    J[k, normal], J[k + 1, normal] = slope * c, slope * s
    F[k], F[k + 1] = P[k] - radius * c, P[k + 1] - radius * s


@kernel
def _laws(p, first, xi, P, scale, F, J):
    """Write F = P - proj(z), z = P - scale xi, and the derivative of proj by z, (6, 6) of every contact."""
    z, own, one = np.zeros(6), np.zeros((6, 6)), np.zeros(6)
    largest, total = 0.0, 0.0
    for i in range(len(p.points)):
        if p.active[i] == 0:
            continue
        at, m, point = first[i], p.rows[i], p.points[i]
        for k in range(m):
            z[k] = P[at + k] - scale[at + k] * xi[at + k]
        own[:] = 0.0
        pressed = z[0] > p.least[i]
        own[0, 0] = 1.0 if pressed else 0.0
        normal = max(z[0], p.least[i])
        F[at] = P[at] - normal
        if m >= 3:
            mu = point.friction
            slope = mu if pressed else 0.0
            _disc(z[0], z[1], z[2], mu * normal, slope, own, one, P[at : at + m], 1, 0)
            F[at + 1], F[at + 2] = one[1], one[2]
        if m == 6:
            reach = point.drilling * normal
            own[3] = 0.0
            if abs(z[3]) <= reach:
                own[3, 3], F[at + 3] = 1.0, P[at + 3] - z[3]
            else:
                sign = 1.0 if z[3] > 0.0 else -1.0
                own[3, 0] = sign * point.drilling if pressed else 0.0
                F[at + 3] = P[at + 3] - sign * reach
            slope = point.rolling if pressed else 0.0
            _disc(z[0], z[4], z[5], point.rolling * normal, slope, own, one, P[at : at + m], 4, 0)
            F[at + 4], F[at + 5] = one[4], one[5]
        for r in range(m):
            missed = abs(F[at + r]) / (scale[at + r] * scale[at]) ** 0.5
            largest = max(largest, missed)
            total += missed * missed
            for k in range(m):
                J[i, r, k] = own[r, k]
    return largest, total**0.5


def _scaled_jacobian(p, first, J):
    """Return the derivatives of the projections as a block diagonal matrix (csr)."""
    rows, columns, values = [], [], []
    for m in (1, 3, 6):
        of = np.flatnonzero((p.rows == m) & (p.active > 0))
        if len(of):
            r, c = np.meshgrid(np.arange(m), np.arange(m), indexing="ij")
            rows.append((first[of][:, None, None] + r).ravel())
            columns.append((first[of][:, None, None] + c).ravel())
            values.append(J[of][:, :m, :m].ravel())
    n = int(first[-1])
    if not rows:
        return sparse.csr_matrix((n, n))
    triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.csr_matrix(triplets, shape=(n, n))


def _direction(projected, scale, D, F, softness: float) -> np.ndarray:
    """Return the step of Newton's method; without softness, contacts that share their load take the smallest one."""
    n = len(F)
    if n > DENSE:
        softness = max(softness, SOFT)
    soft = D + sparse.diags(softness / scale) if softness > 0.0 else D
    A = sparse.identity(n, format="csr") - projected + projected @ sparse.diags(scale) @ soft
    try:
        if n > DENSE:
            change = splu(A.tocsc()).solve(-F)
        elif softness > 0.0:
            change = np.linalg.solve(A.toarray(), -F)
        else:
            change = np.linalg.lstsq(A.toarray(), -F, rcond=1e-11)[0]
    except (np.linalg.LinAlgError, RuntimeError):
        return np.zeros(n)
    return change if np.all(np.isfinite(change)) else np.zeros(n)


def _downhill(p, first, scale, D, q, P, goal: float) -> tuple[np.ndarray, float, int]:
    """Return the impulses, by how much they miss their laws, and the steps it took from `P`, each for the better."""
    F, J = np.zeros(len(P)), np.zeros((len(p.points), 6, 6))
    left, total = _laws(p, first, D @ P + q, P, scale, F, J)
    for steps in range(STEPS):
        if left <= goal:
            return P, left, steps
        change = _direction(_scaled_jacobian(p, first, J), scale, D, F, 0.0)
        part, before = 1.0, left
        for _ in range(HALVINGS):
            trial = P + part * change
            left, better = _laws(p, first, D @ trial + q, trial, scale, F, J)
            if better < (1.0 - 1e-4 * part) * total:
                break
            part *= 0.5
        else:
            return P, before, steps
        P, total = trial, better
    return P, left, STEPS


def _whole(p, first, scale, D, q, P, goal: float, softness: float) -> tuple[np.ndarray, float, int]:
    """Return the best impulses on the way of whole steps, by how much they miss their laws, and the steps."""
    F, J = np.zeros(len(P)), np.zeros((len(p.points), 6, 6))
    best, least, steps = P, np.inf, 0
    while steps < STEPS:
        left, _ = _laws(p, first, D @ P + q, P, scale, F, J)
        if left < least:
            best, least = P, left
        if least <= goal:
            break
        P = P + _direction(_scaled_jacobian(p, first, J), scale, D, F, softness)
        steps += 1
    return best, least, steps


def newton(p, parts, v: np.ndarray, xi_of, goal: float) -> tuple[float, int]:
    """Improve the impulses until their laws are missed by less than `goal` (m/s); return by how much, and the steps.

    ``xi_of(v)`` gives the velocities of all rows with their shifts.
    """
    made = mobility(p, parts)
    if made is None or not len(p.points):
        return np.inf, 0
    D, first = made
    n = int(first[-1])
    diagonal = np.maximum(D.diagonal(), 0.0)
    scale = np.zeros(n)
    groups = ((0, 1), (1, 3), (3, 4), (4, 6))
    for i in np.flatnonzero(p.active > 0):  # one number for the directions that are projected together
        for low, high in groups:
            if low < p.rows[i]:
                d = diagonal[first[i] + low : first[i] + high].max()
                scale[first[i] + low : first[i] + high] = 1.0 / d if d > 0.0 else 1.0 / max(diagonal[first[i]], 1e-300)
    P = np.concatenate([p.P[i, : p.rows[i]] for i in np.flatnonzero(p.active > 0)])
    q = xi_of(v) - D @ P
    P, left, steps = _downhill(p, first, scale, D, q, P, goal)
    for softness in SOFTER:
        if left <= goal:
            break
        trial, better, taken = _whole(p, first, scale, D, q, P, goal, softness)
        steps += taken
        if better < left:
            P, left = trial, better
    if left > goal and n <= DENSE:
        trial = P
        for softness in SOFTEST:  # the solution of soft contacts is unique, and leads to the rigid one
            soft = (D + sparse.diags(softness / scale)).tocsr() if softness > 0.0 else D
            trial, better, taken = _whole(p, first, scale, soft, q, trial, goal, 0.0)
            steps += taken
        if better < left:
            P, left = trial, better
    at = 0
    for i in np.flatnonzero(p.active > 0):
        m = int(p.rows[i])
        own = np.zeros(6)
        own[:m] = P[at : at + m]
        add_impulse(p, parts, i, own - p.P[i], v)
        p.P[i], at = own, at + m
    return left, steps
