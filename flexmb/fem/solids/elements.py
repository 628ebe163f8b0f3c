"""The solid elements: reference nodes, shape functions, integration rules, faces.

scikit-fem gives the shape functions and the one-dimensional, triangle and tetrahedron rules; this file puts
its nodes into meshio's order by their reference positions, so that no table of permutations exists.
Reference cells: unit tetrahedron, unit cube, unit wedge (triangle in x, y times 0 <= z <= 1).

The rules integrate the stiffness of undistorted elements exactly (hexahedra: Gauss 2x2x2 and 3x3x3) and
the mass of undistorted elements exactly. Stresses are sampled at the points where the stresses of a distorted
element are best (Barlow 1976) and continued to the nodes by the polynomial through these points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

__all__ = ["HEX8_COMPATIBLE", "HEX20_REDUCED", "SOLID_ELEMENTS", "WEDGE6_COMPATIBLE", "ElementTables", "SolidElement"]

TET = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
HEX = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
WEDGE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)

TET_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
HEX_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
WEDGE_EDGES = ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))

TET_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
HEX_FACES = ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (2, 3, 7, 6), (0, 3, 2, 1), (4, 5, 6, 7))
WEDGE_FACES = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))


@dataclass(frozen=True, kw_only=True, eq=False)
class ElementTables:
    """Shape functions at the integration points, in meshio's node order; what the kernels read.

    stiffness_gradient (nq, nn, 3), stiffness_weight (nq,), mass_value (nq, nn), mass_gradient (nq, nn, 3),
    mass_weight (nq,), stress_gradient (ns, nn, 3), extrapolation (nn, ns); inner_* (nq or ns, ni, 3) gradients of
    the incompatible modes at the same points, centre_gradient (nn, 3).
    """

    stiffness_gradient: np.ndarray
    stiffness_weight: np.ndarray
    stiffness_inner: np.ndarray
    mass_value: np.ndarray
    mass_gradient: np.ndarray
    mass_weight: np.ndarray
    stress_gradient: np.ndarray
    stress_inner: np.ndarray
    extrapolation: np.ndarray
    centre_gradient: np.ndarray


@dataclass(frozen=True, kw_only=True)
class SolidElement:
    """One kind of solid element.

    Parameters
    ----------
    cell_type : str
        Name in meshio's spelling.
    family : str
        "tetra", "hexahedron" or "wedge".
    order : int
        1 linear, 2 quadratic.
    basis : str
        Name of the scikit-fem element with these shape functions; "" for the 15-node wedge, which it lacks.
    stiffness_order, mass_order, stress_order : int
        Polynomial order of the integration rules (per direction for hexahedra).
    incompatible : bool
        Adds the incompatible displacement modes of Wilson in the form of Taylor, Beresford & Wilson 1976; in a wedge
        the second-degree terms of the triangle and of the height, without products.
    """

    cell_type: str
    family: str
    order: int
    basis: str
    stiffness_order: int
    mass_order: int
    stress_order: int
    incompatible: bool = False

    @property
    def corners(self) -> np.ndarray:
        """Reference positions of the corner nodes, (nc, 3)."""
        return {"tetra": TET, "hexahedron": HEX, "wedge": WEDGE}[self.family]

    @property
    def nodes(self) -> np.ndarray:
        """Reference positions of all nodes, (nn, 3), in meshio's order."""
        corners = self.corners
        if self.order == 1:
            return corners
        edges = {"tetra": TET_EDGES, "hexahedron": HEX_EDGES, "wedge": WEDGE_EDGES}[self.family]
        middles = [corners[list(edge)].mean(axis=0) for edge in edges]
        if self.cell_type == "hexahedron27":
            middles += [corners[list(face)].mean(axis=0) for face in HEX_FACES] + [corners.mean(axis=0)]
        return np.vstack([corners, middles])

    @property
    def faces(self) -> tuple[tuple[int, ...], ...]:
        """Local node numbers of each face: corners (outward by the right-hand rule), mid-sides, centre."""
        corner_faces = {"tetra": TET_FACES, "hexahedron": HEX_FACES, "wedge": WEDGE_FACES}[self.family]
        if self.order == 1:
            return corner_faces
        nodes, faces = self.nodes, []
        for face in corner_faces:
            ring = nodes[list(face)]
            middles = list((ring + np.roll(ring, -1, axis=0)) / 2.0)
            if self.cell_type == "hexahedron27":
                middles.append(ring.mean(axis=0))
            faces.append(face + tuple(int(k) for k in locate(np.array(middles), nodes)))
        return tuple(faces)

    @property
    def mirror(self) -> np.ndarray:
        """Node order of the mirrored element: repairs cells written with the opposite orientation."""
        mirrored = self.nodes.copy()
        if self.family == "tetra":
            mirrored[:, :2] = mirrored[:, 1::-1]
        else:
            mirrored[:, 2] = 1.0 - mirrored[:, 2]
        return locate(mirrored, self.nodes)

    @property
    def tables(self) -> ElementTables:
        """Shape functions at the integration points (computed once)."""
        return _tables(self)

    def compatible(self) -> SolidElement:
        """Return the element without incompatible modes."""
        return replace(self, incompatible=False)


def locate(positions: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Return the number of the node at each position."""
    distance = np.linalg.norm(positions[:, None] - nodes[None], axis=2)
    found = distance.argmin(axis=1)
    assert distance[np.arange(len(found)), found].max() < 1e-12, "reference nodes do not match"
    return found


def rule(family: str, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Return integration points (nq, 3) and weights (nq,) on the reference cell.

    scikit-fem's own wedge rule takes the triangle's second coordinate for the extrusion and squares its weights;
    the product of its triangle and line rules is used instead.
    """
    from skfem.quadrature import get_quadrature
    from skfem.refdom import RefHex, RefLine, RefTet, RefTri

    if family == "wedge":
        triangle, triangle_weight = get_quadrature(RefTri, order)
        line, line_weight = get_quadrature(RefLine, order + 1)
        points = np.array([[x, y, z] for z in line[0] for x, y in triangle.T])
        return points, np.outer(line_weight, triangle_weight).ravel()
    points, weights = get_quadrature({"tetra": RefTet, "hexahedron": RefHex}[family], order)
    return np.ascontiguousarray(points.T), np.ascontiguousarray(weights)


def shape_functions(element: SolidElement, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return values (np, nn) and reference gradients (np, nn, 3) at reference points (np, 3)."""
    if not element.basis:
        return _wedge15(element.nodes, points)
    import skfem

    basis = getattr(skfem, element.basis)()
    order = locate(element.nodes, basis.doflocs)
    value, gradient = np.empty((len(points), len(order))), np.empty((len(points), len(order), 3))
    for a, i in enumerate(order):
        phi, dphi = basis.lbasis(points.T.copy(), int(i))
        value[:, a] = phi
        for k in range(3):
            gradient[:, a, k] = dphi[k]
    return value, gradient


def _wedge15(nodes: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Serendipity wedge: quadratic triangle times (1, z), plus z^2 times (1, x, y)."""
    powers = [(i, j, k) for k in (0, 1) for i in range(3) for j in range(3 - i)] + [(0, 0, 2), (1, 0, 2), (0, 1, 2)]

    def monomials(at: np.ndarray, derivative: int = -1) -> np.ndarray:
        columns = []
        for exponents in powers:
            e, factor = list(exponents), 1.0
            if derivative >= 0:
                factor, e[derivative] = float(e[derivative]), max(e[derivative] - 1, 0)
            columns.append(factor * at[:, 0] ** e[0] * at[:, 1] ** e[1] * at[:, 2] ** e[2])
        return np.column_stack(columns)

    coefficients = np.linalg.inv(monomials(nodes))
    gradient = np.stack([monomials(points, k) @ coefficients for k in range(3)], axis=2)
    return monomials(points) @ coefficients, gradient


def _inner(element: SolidElement, points: np.ndarray) -> np.ndarray:
    """Reference gradients (np, ni, 3) of the incompatible modes, whose mean over the reference cell is zero.

    Hexahedra: 1 - (2 x_i - 1)^2. Wedges: x^2, x y, y^2 from the middle of the triangle, and 1 - (2 z - 1)^2.
    """
    if not element.incompatible:
        return np.zeros((len(points), 0, 3))
    if element.family == "wedge":
        out = np.zeros((len(points), 4, 3))
        x, y, z = points[:, 0] - 1.0 / 3.0, points[:, 1] - 1.0 / 3.0, points[:, 2]
        out[:, 0, 0], out[:, 2, 1], out[:, 3, 2] = 2.0 * x, 2.0 * y, -4.0 * (2.0 * z - 1.0)
        out[:, 1, 0], out[:, 1, 1] = y, x
        return out
    return np.stack([np.diag(-4.0 * (2.0 * x - 1.0)) for x in points])


def _continued(family: str, at: np.ndarray) -> np.ndarray:
    """Polynomials carried by the stress points: 1; linear (tetra); bilinear in the triangle and z; trilinear."""
    x, y, z = at.T
    one = np.ones(len(at))
    return {
        "tetra": np.column_stack([one, x, y, z]),
        "wedge": np.column_stack([one, x, y, z, x * z, y * z]),
        "hexahedron": np.column_stack([one, x, y, z, x * y, y * z, z * x, x * y * z]),
    }[family]


@cache
def _tables(element: SolidElement) -> ElementTables:
    points, weight = rule(element.family, element.stiffness_order)
    mass_points, mass_weight = rule(element.family, element.mass_order)
    stress_points, _ = rule(element.family, element.stress_order)
    mass_value, mass_gradient = shape_functions(element, mass_points)
    if len(stress_points) == 1:
        extrapolation = np.ones((len(element.nodes), 1))
    else:
        extrapolation = _continued(element.family, element.nodes) @ np.linalg.pinv(
            _continued(element.family, stress_points)
        )
    centre = element.corners.mean(axis=0, keepdims=True)
    return ElementTables(
        stiffness_gradient=shape_functions(element, points)[1],
        stiffness_weight=weight,
        stiffness_inner=_inner(element, points),
        mass_value=mass_value,
        mass_gradient=mass_gradient,
        mass_weight=mass_weight,
        stress_gradient=shape_functions(element, stress_points)[1],
        stress_inner=_inner(element, stress_points),
        extrapolation=np.ascontiguousarray(extrapolation),
        centre_gradient=shape_functions(element, centre)[1][0],
    )


SOLID_ELEMENTS = {
    element.cell_type: element
    for element in (
        SolidElement(
            cell_type="tetra",
            family="tetra",
            order=1,
            basis="ElementTetP1",
            stiffness_order=1,
            mass_order=2,
            stress_order=1,
        ),
        SolidElement(
            cell_type="tetra10",
            family="tetra",
            order=2,
            basis="ElementTetP2",
            stiffness_order=2,
            mass_order=4,
            stress_order=2,
        ),
        SolidElement(
            cell_type="hexahedron",
            family="hexahedron",
            order=1,
            basis="ElementHex1",
            stiffness_order=3,
            mass_order=3,
            stress_order=3,
            incompatible=True,
        ),
        SolidElement(
            cell_type="hexahedron20",
            family="hexahedron",
            order=2,
            basis="ElementHexS2",
            stiffness_order=5,
            mass_order=5,
            stress_order=3,
        ),
        SolidElement(
            cell_type="hexahedron27",
            family="hexahedron",
            order=2,
            basis="ElementHex2",
            stiffness_order=5,
            mass_order=5,
            stress_order=3,
        ),
        SolidElement(
            cell_type="wedge",
            family="wedge",
            order=1,
            basis="ElementWedge1",
            stiffness_order=2,
            mass_order=2,
            stress_order=2,
            incompatible=True,
        ),
        SolidElement(
            cell_type="wedge15", family="wedge", order=2, basis="", stiffness_order=4, mass_order=4, stress_order=2
        ),
    )
}
"""The solid elements by cell type."""

HEX8_COMPATIBLE = SOLID_ELEMENTS["hexahedron"].compatible()
"""The plain 8-node hexahedron: locks in bending, see docs/decisions/0002-hex8.md."""

WEDGE6_COMPATIBLE = SOLID_ELEMENTS["wedge"].compatible()
"""The plain 6-node wedge: locks in bending, see docs/decisions/0002-hex8.md."""

HEX20_REDUCED = replace(SOLID_ELEMENTS["hexahedron20"], stiffness_order=3)
"""The 20-node hexahedron whose stiffness is integrated at 2x2x2 points: softer, and alone with six motions that strain
nothing (I. Fried 1974); among neighbours in two directions it has none."""
