"""Corner and mid-edge functions of flat triangles and quadrilaterals.

All arrays are batched over the elements (ne) with c corners; local axes: z normal to the element.
Edge k joins the corners k and k + 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["CORNERS", "Functions", "edges", "functions", "integration_points", "mass_points"]

CORNERS = {3: ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), 4: ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))}
"""Corners of the reference triangle and square."""


@dataclass(frozen=True, eq=False)
class Functions:
    """Functions at one point of every element.

    Parameters
    ----------
    xi, eta : float
        The point of the reference element.
    value, edge_value : (c,), -
        Linear (bilinear) corner functions and quadratic mid-edge functions, 1 at their edge's middle.
    gradient, edge_gradient : (ne, 2, c), 1/m
    weight : (ne,), m2
        Area that belongs to the point.
    """

    xi: float
    eta: float
    value: np.ndarray
    gradient: np.ndarray
    edge_value: np.ndarray
    edge_gradient: np.ndarray
    weight: np.ndarray


def integration_points(count: int) -> list[tuple[float, float, float]]:
    """Return xi, eta, weight: the three mid-edges of a triangle (degree 2), 2 x 2 Gauss points of a square
    (degree 3)."""
    if count == 3:
        return [(0.5, 0.0, 1.0 / 6.0), (0.5, 0.5, 1.0 / 6.0), (0.0, 0.5, 1.0 / 6.0)]
    g = 1.0 / np.sqrt(3.0)
    return [(-g, -g, 1.0), (g, -g, 1.0), (g, g, 1.0), (-g, g, 1.0)]


def mass_points(count: int) -> list[tuple[float, float, float]]:
    """Return xi, eta, weight for products of quadratic functions: six points of a triangle (degree 4), 3 x
    3 of a square.

    Triangle: D. A. Dunavant, Int. J. Numer. Meth. Eng. 21 (1985) 1129-1148, table II, p = 4.
    """
    if count == 4:
        x, w = np.polynomial.legendre.leggauss(3)
        return [(float(a), float(b), float(v * u)) for a, v in zip(x, w) for b, u in zip(x, w)]
    out = []
    for a, weight in ((0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322)):
        out += [(xi, eta, 0.5 * weight) for xi, eta in ((a, a), (1.0 - 2.0 * a, a), (a, 1.0 - 2.0 * a))]
    return out


def functions(corners: np.ndarray, xi: float, eta: float, weight: float = 1.0) -> Functions:
    """Return the functions of elements with corners (ne, c, 2), m, at a point of the reference element."""
    value, slope, edge, edge_slope = (_triangle if corners.shape[1] == 3 else _quadrilateral)(xi, eta)
    jacobian = slope @ corners  # rows d(x, y)/dxi, d(x, y)/deta
    inverse = np.linalg.inv(jacobian)
    return Functions(xi, eta, value, inverse @ slope, edge, inverse @ edge_slope, weight * np.linalg.det(jacobian))


def edges(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return length (ne, c), m, and unit tangent (ne, c, 2) of the edges."""
    along = np.roll(corners, -1, axis=1) - corners
    length = np.linalg.norm(along, axis=2)
    return length, along / length[..., None]


def _triangle(xi: float, eta: float):
    value = np.array([1.0 - xi - eta, xi, eta])
    slope = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    pairs = ((0, 1), (1, 2), (2, 0))
    edge = np.array([4.0 * value[i] * value[j] for i, j in pairs])
    edge_slope = np.stack([4.0 * (slope[:, i] * value[j] + value[i] * slope[:, j]) for i, j in pairs], axis=1)
    return value, slope, edge, edge_slope


def _quadrilateral(xi: float, eta: float):
    x, y = np.array(CORNERS[4]).T
    value = 0.25 * (1.0 + x * xi) * (1.0 + y * eta)
    slope = 0.25 * np.stack([x * (1.0 + y * eta), y * (1.0 + x * xi)])
    below, right, above, left = 1.0 - eta, 1.0 + xi, 1.0 + eta, 1.0 - xi
    bow_x, bow_y = 1.0 - xi**2, 1.0 - eta**2
    edge = 0.5 * np.array([bow_x * below, right * bow_y, bow_x * above, left * bow_y])
    edge_slope = np.array(
        [
            [-xi * below, 0.5 * bow_y, -xi * above, -0.5 * bow_y],
            [-0.5 * bow_x, -eta * right, 0.5 * bow_x, -eta * left],
        ]
    )
    return value, slope, edge, edge_slope
