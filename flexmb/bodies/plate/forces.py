"""Membrane forces, moments and shear forces of plates, in the middles of the elements and between them."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.plate.element import BENDING, MEMBRANE, SHELL

__all__ = ["at_fractions", "least_areas", "thin_strains", "with_director_strains"]


def thin_strains(points, q) -> np.ndarray:
    """Return mean changes of strain 11, 22, 2 x 12 and of curvature 11, 22, 2 x 12 of thin elements, (ne, 8).

    `points` (ne, 625) as the kernels have them, `q` (ne, 12, 3). Curvature is positive where the side of the normal is
    stretched. The last two columns, the transverse shear, are zero.
    """
    flat = points[:, : 9 * MEMBRANE].reshape(len(points), 9, MEMBRANE)
    bent = points[:, 9 * MEMBRANE :].reshape(len(points), 4, BENDING)
    x = np.einsum("egkv,evi->egki", flat[:, :, 5:29].reshape(len(points), 9, 2, 12), q)
    E = np.stack([0.5 * _dot(x, x, 0, 0), 0.5 * _dot(x, x, 1, 1), _dot(x, x, 0, 1)], axis=-1) - flat[:, :, 2:5]
    area = flat[:, :, 1] / flat[:, :, 1].sum(axis=1, keepdims=True)
    y = np.einsum("egkv,evi->egki", bent[:, :, 4:].reshape(len(points), 4, 5, 12), q)
    n = np.cross(y[:, :, 0], y[:, :, 1])
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    kappa = np.einsum("egki,egi->egk", y[:, :, 2:], n) * (1.0, 1.0, 2.0) - bent[:, :, 1:4]
    return np.hstack([np.einsum("eg,egk->ek", area, E), -kappa.mean(axis=1), np.zeros((len(points), 2))])


def with_director_strains(points, q) -> np.ndarray:
    """Return the same of elements with director (ne, 8): `points` (ne, 234), `q` (ne, 8, 3), and the shear 1, 2."""
    own = points[:, : 4 * SHELL].reshape(len(points), 4, SHELL)
    x = np.einsum("egkv,evi->egki", own[:, :, 8:40].reshape(len(points), 4, 4, 8), q)
    s = (
        np.stack(
            [
                0.5 * _dot(x, x, 0, 0),
                0.5 * _dot(x, x, 1, 1),
                _dot(x, x, 0, 2),
                _dot(x, x, 1, 3),
                _dot(x, x, 0, 3) + _dot(x, x, 1, 2),
            ],
            axis=-1,
        )
        - own[:, :, 3:8]
    )
    s = s.mean(axis=1)
    middle = points[:, 4 * SHELL + 2 : 4 * SHELL + 18].reshape(len(points), 2, 8)
    r = np.einsum("ekv,evi->eki", middle, q)
    gamma = np.einsum("eki,ei->ek", r, q[:, 1::2].mean(axis=1))
    return np.hstack([s[:, :2], _dot(r, r, 0, 1)[:, None], s[:, 2:], gamma])


def least_areas(points, q) -> np.ndarray:
    """Return the least area r_1 x r_2 . n in each element (ne,) by that as drawn; n: its mean normal or director."""
    thin = q.shape[1] == 12
    count, stride, first = (9, MEMBRANE, 5) if thin else (4, SHELL, 8)
    own = points[:, : count * stride].reshape(len(points), count, stride)[:, :, first : first + 2 * q.shape[1]]
    x = np.einsum("egkv,evi->egki", own.reshape(len(points), count, 2, -1), q)
    areas = np.cross(x[:, :, 0], x[:, :, 1])
    n = areas.sum(axis=1) if thin else q[:, 1::2].sum(axis=1)
    size = np.linalg.norm(n, axis=1)
    return np.einsum("egi,ei->eg", areas, n / np.where(size > 0.0, size, 1.0)[:, None]).min(axis=1)


def _dot(x, y, a: int, b: int):
    return np.sum(x[..., a, :] * y[..., b, :], axis=-1)


def at_fractions(values, shape, fractions) -> np.ndarray:
    """Return values (ne, k) of the elements' middles at fractions (n, 2), bilinear between and beyond, (n, k)."""
    grid = np.reshape(values, (*shape, -1))
    for axis, n in enumerate(shape):
        if n == 1:
            grid = np.repeat(grid, 2, axis=axis)
    fractions = np.atleast_2d(np.asarray(fractions, float))
    out = np.zeros((len(fractions), grid.shape[2]))
    places, shares = [], []
    for axis, n in enumerate(shape):
        at = fractions[:, axis] * n - 0.5
        k = np.clip(np.floor(at).astype(int), 0, max(n - 2, 0))
        places.append(k)
        shares.append(at - k)
    for i in (0, 1):
        for j in (0, 1):
            weight = (shares[0] if i else 1.0 - shares[0]) * (shares[1] if j else 1.0 - shares[1])
            out += weight[:, None] * grid[places[0] + i, places[1] + j]
    return out
