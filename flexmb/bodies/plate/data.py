"""What the kernels of plates need of every element: shape functions in local axes, mass, strains without stress."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.plate.surface import EDGES, Surface

__all__ = ["bilinear", "hermite_plate", "shell_elements", "thin_elements"]

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
POWERS = np.array([[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2], [3, 0], [2, 1], [1, 2], [0, 3], [3, 1], [1, 3]])
DERIVATIVES = ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1))
"""N, N_x, N_y, N_xx, N_yy, N_xy."""


def _monomials(at, dx, dy) -> np.ndarray:
    """Return the derivatives of the 12 monomials at one point, (12,)."""
    out = np.ones(12)
    for axis, d in ((0, dx), (1, dy)):
        n = POWERS[:, axis]
        factor = np.ones(12)
        for k in range(d):
            factor = factor * (n - k)
        out *= factor * np.where(n >= d, at[axis] ** np.maximum(n - d, 0).astype(float), 0.0)
    return out


COEFFICIENTS = np.linalg.inv(np.array([_monomials(c, *d) for c in CORNERS for d in ((0, 0), (1, 0), (0, 1))]))


def hermite_plate(x: float, y: float, lengths) -> np.ndarray:
    """Return N and its derivatives by x, y in -1..1 for r, r_s, r_t of four nodes, (ne, 6, 12): eq. (plate-shapes).

    The polynomials of Adini & Clough (1961); gradients are per length along the edges `lengths` (ne, 4).
    """
    scale = np.ones((len(lengths), 12))
    for node, (s, t) in enumerate(((0, 2), (0, 3), (1, 3), (1, 2))):
        scale[:, 3 * node + 1], scale[:, 3 * node + 2] = 0.5 * lengths[:, s], 0.5 * lengths[:, t]
    return np.array([_monomials((x, y), *d) @ COEFFICIENTS for d in DERIVATIVES]) * scale[:, None]


def bilinear(x: float, y: float) -> np.ndarray:
    """Return N, N_x, N_y of four nodes at x, y in -1..1, (3, 4)."""
    a, b = 1.0 + x * CORNERS[:, 0], 1.0 + y * CORNERS[:, 1]
    return 0.25 * np.array([a * b, CORNERS[:, 0] * b, CORNERS[:, 1] * a])


def _axes(gradients, first):
    """Return J (ne, 2, 2), areas and normals of gradients by x, y (ne, 2, 3).

    J maps derivatives by the local axes 1, 2 on those by x, y; axis 1 is the direction `first` (ne, 3) in the surface.
    """
    n = np.cross(gradients[:, 0], gradients[:, 1])
    area = np.linalg.norm(n, axis=1)
    n = n / area[:, None]
    e = first - n * np.sum(n * first, axis=1)[:, None]
    e /= np.linalg.norm(e, axis=1)[:, None]
    return np.einsum("exi,eai->exa", gradients, np.stack([e, np.cross(n, e)], axis=1)), area, n


def _gauss(n: int):
    """Return points and weights (n2,) of the square -1..1."""
    x, w = np.polynomial.legendre.leggauss(n)
    return [(a, b, p * q) for a, p in zip(x, w, strict=True) for b, q in zip(x, w, strict=True)]


def _local(N, J) -> np.ndarray:
    """Return derivatives 1, 2, 11, 22, 12 in local axes (ne, 5, V) of N, N_x, ... (ne, 6, V).

    Of the second derivatives only the part along the normal is meant, to which the change of the axes adds nothing.
    """
    inverse = np.linalg.inv(J)
    second = np.stack([N[:, [3, 5]], N[:, [5, 4]]], axis=1)
    second = np.einsum("eax,exyv,eby->eabv", inverse, second, inverse)
    return np.concatenate([inverse @ N[:, 1:3], second[:, [0, 1, 0], [0, 1, 1]]], axis=1)


def _rows(*columns) -> np.ndarray:
    """Return arrays (ne, ...) side by side as (ne, k)."""
    return np.hstack([np.reshape(c, (len(c), -1)) for c in columns])


def thin_elements(surface: Surface, vectors, plate) -> tuple[np.ndarray, np.ndarray]:
    """Return masses, moments and areas (ne, 12 (12 + 2)), and points (ne, 625), of elements with nodal vectors.

    `vectors` (n, 3, 3) are r, r_s, r_t of the nodes; `plate` has material, thickness, initial strain.
    """
    q = vectors[surface.cells].reshape(-1, 12, 3)
    E, nu, density = plate.material.young, plate.material.poisson, plate.material.density
    first = np.einsum("ev,evi->ei", hermite_plate(0.0, 0.0, surface.lengths)[:, 1], q)
    mass, moment, shape = np.zeros((len(q), 12, 12)), np.zeros((len(q), 12)), np.zeros((len(q), 12))
    rest = np.tile([1.0, 1.0, 0.0], (len(q), 1)) * 0.5 * (1.0 - plate.initial_strain) ** 2
    membrane, bending = [], []
    for order in (4, 3, 2):
        for x, y, weight in _gauss(order):
            N = hermite_plate(x, y, surface.lengths)
            J, area, n = _axes(N[:, 1:3] @ q, first)
            w, h = weight * area, plate.thickness_in(x, y)
            if order == 4:
                mass += np.einsum("e,es,et->est", density * h * w, N[:, 0], N[:, 0])
                moment += (density * h * w)[:, None] * N[:, 0]
                shape += w[:, None] * N[:, 0]
                continue
            D = _local(N, J)
            if order == 3:
                membrane.append(_rows(w * E * h / (1.0 - nu**2), w, rest, D[:, :2], N[:, 0]))
            else:
                bent = np.einsum("eki,ei->ek", D[:, 2:] @ q, n) * (1.0, 1.0, 2.0) * (not plate.flat)
                bending.append(_rows(w * E * h**3 / 12.0 / (1.0 - nu**2), bent, D))
    return _rows(mass, moment, shape), np.hstack(membrane + bending)


def _spread(N, director: bool) -> np.ndarray:
    """Return coefficients on r and d of four nodes (ne, k, 8) of those on r (ne, k, 4), or on d."""
    out = np.zeros((*N.shape[:-1], 8))
    out[..., int(director) :: 2] = N
    return out


def shell_elements(surface: Surface, vectors, plate) -> tuple[np.ndarray, np.ndarray]:
    """Return masses, moments and areas (ne, 8 (8 + 2)), and points (ne, 234), of elements with directors.

    `vectors` (n, 2, 3) are r, d of the nodes.
    """
    q, d = np.moveaxis(vectors[surface.cells], 2, 0)
    n, middle = len(q), np.tile(bilinear(0.0, 0.0), (len(q), 1, 1))
    E, nu, density, G = plate.material.young, plate.material.poisson, plate.material.density, plate.material.shear
    first = middle[:, 1:] @ q
    mass, moment, shape = np.zeros((n, 8, 8)), np.zeros((n, 8)), np.zeros((n, 8))
    S, walls, in_plane = np.zeros((n, 4, 4)), np.zeros((n, 4)), np.zeros(n)
    rest = np.ones((n, 2)) * 0.5 * (1.0 - plate.initial_strain) ** 2
    points = []
    for x, y, weight in _gauss(2):
        N = np.tile(bilinear(x, y), (n, 1, 1))
        J, area, _ = _axes(N[:, 1:] @ q, first[:, 0])
        w, h = weight * area, plate.thickness_in(x, y)
        D = np.linalg.solve(J, N[:, 1:])
        kappa = np.einsum("eai,ebi->eab", D @ q, D @ d) * (not plate.flat)
        bent = np.stack([kappa[:, 0, 0], kappa[:, 1, 1], kappa[:, 0, 1] + kappa[:, 1, 0]], axis=1)
        on_r = _spread(N[:, 0], False)
        points.append(
            _rows(
                w * E * h / (1.0 - nu**2),
                w * E * h**3 / 12.0 / (1.0 - nu**2),
                w,
                rest,
                bent,
                _spread(D, False),
                _spread(D, True),
                on_r,
            )
        )
        both = np.einsum("es,et->est", N[:, 0], N[:, 0])
        mass[:, 0::2, 0::2] += (density * h * w)[:, None, None] * both
        mass[:, 1::2, 1::2] += (density * h**3 / 12.0 * w)[:, None, None] * both
        moment += (density * h * w)[:, None] * on_r
        shape += w[:, None] * on_r
        c = np.linalg.solve(J, np.tile(0.5 * np.array([[1 - y, 1 + y, 0, 0], [0, 0, 1 - x, 1 + x]]), (n, 1, 1)))
        S += np.einsum("e,eai,eaj->eij", w * plate.shear_factor * G * h, c, c)
        walls += (w * E * h)[:, None] * N[:, 0]
        in_plane += w * G * h
    D = np.linalg.solve(_axes(first, first[:, 0])[0], middle[:, 1:])
    edges = [0.25 * np.sum((q[:, b] - q[:, a]) * (d[:, a] + d[:, b]), axis=1) * (not plate.flat) for a, b in EDGES]
    points += [in_plane[:, None], np.zeros((n, 1)), _rows(_spread(D, False), S), np.stack(edges, axis=1), walls]
    return _rows(mass, moment, shape), np.hstack(points)
