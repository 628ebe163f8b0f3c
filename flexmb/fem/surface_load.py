"""Consistent nodal forces of pressure and traction on named facets."""

from __future__ import annotations

import numpy as np

from flexmb.errors import MeshError, did_you_mean
from flexmb.fem.fe_model import FEModel

__all__ = [
    "facet_areas",
    "node_areas",
    "pressure_change",
    "pressure_field",
    "pressure_load",
    "traction_field",
    "traction_load",
]

CORNERS = {"tri": np.array([[0, 0], [1, 0], [0, 1]], float), "quad": np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)}
FACETS = {
    3: ("tri", "ElementTriP1", 4),
    6: ("tri", "ElementTriP2", 4),
    4: ("quad", "ElementQuad1", 3),
    8: ("quad", "ElementQuadS2", 5),
    9: ("quad", "ElementQuad2", 5),
}
"""Shape, scikit-fem element and order of the integration rule by the number of nodes."""


def pressure_load(fe: FEModel, facets: str | np.ndarray, pressure: float = 1.0) -> np.ndarray:
    """Return nodal forces (ndof,), N, of a pressure, Pa, that acts against the outward normal, eq. (fe-pressure)."""
    return fe.forces(pressure_field(fe, facets, pressure))[:, 0]


def pressure_field(fe: FEModel, facets: str | np.ndarray, pressure: float = 1.0) -> np.ndarray:
    """Return the nodal forces (n, 6, 1), N, of a pressure, Pa, that acts against the outward normal."""
    return _nodal(fe, facets, lambda normal: -pressure * normal)


def traction_load(
    fe: FEModel, facets: str | np.ndarray, traction: tuple[float, float, float] | np.ndarray
) -> np.ndarray:
    """Return nodal forces (ndof,), N, of a traction vector (3,), Pa, in body axes, eq. (fe-traction)."""
    return fe.forces(traction_field(fe, facets, traction))[:, 0]


def traction_field(
    fe: FEModel, facets: str | np.ndarray, traction: tuple[float, float, float] | np.ndarray
) -> np.ndarray:
    """Return the nodal forces (n, 6, 1), N, of a traction vector (3,), Pa, in body axes."""
    t = np.asarray(traction, float)
    if t.shape != (3,) or not np.isfinite(t).all():
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"the traction {traction!r}",
            expected="three numbers, Pa",
            remedy="Give (tx, ty, tz) in body axes",
        )
    return _nodal(fe, facets, lambda normal: np.linalg.norm(normal, axis=-1, keepdims=True) * t)


def pressure_change(fe: FEModel, facets: np.ndarray, pressure: float, field: np.ndarray) -> np.ndarray:
    """Return how the nodal forces of a pressure, Pa, change with displacements (n, 6, k) of the surface: (n, 6, k), N.

    The forces follow the deformed surface: ``int N (du_,1 x x_,2 + x_,1 x du_,2)`` in place of ``int N x_,1 x x_,2``.
    """
    out = np.zeros(field.shape)
    width = (facets >= 0).sum(axis=1)
    for nn in np.unique(width):
        chosen = facets[width == nn][:, :nn]
        value, gradient, weight = _facet_tables(int(nn))
        shape = weight[:, None] * value
        tangents = np.einsum("fak,qad->fqdk", fe.nodes[chosen], gradient)
        for j in range(field.shape[2]):
            moved = np.einsum("fak,qad->fqdk", field[chosen, :3, j], gradient)
            normal = np.cross(moved[:, :, 0], tangents[:, :, 1]) + np.cross(tangents[:, :, 0], moved[:, :, 1])
            np.add.at(out[:, :3, j], chosen, -pressure * np.einsum("qa,fqk->fak", shape, normal))
    return out


def node_areas(fe: FEModel, facets: str | np.ndarray) -> np.ndarray:
    """Return the share of every node in the area of facets, int N dA, (n,), m2."""
    return facet_areas(fe.nodes, _rows(fe, facets))


def facet_areas(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return the share of every point (n, 3) in the area of facets (nf, nn), -1 behind short ones: int N dA, (n,)."""
    out = np.zeros(len(points))
    width = (facets >= 0).sum(axis=1)
    for nn in np.unique(width):
        chosen = facets[width == nn][:, :nn]
        value, gradient, weight = _facet_tables(int(nn))
        tangents = np.einsum("fak,qad->fqdk", points[chosen], gradient)
        size = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2)
        np.add.at(out, chosen, np.einsum("q,qa,fq->fa", weight, value, size))
    return out


def _rows(fe: FEModel, facets: str | np.ndarray) -> np.ndarray:
    """Return the facets of a name."""
    if isinstance(facets, str):
        if facets not in fe.facet_sets:
            known = ", ".join(sorted(fe.facet_sets)) or "none"
            raise MeshError(
                f"FE model '{fe.name}'",
                found=f"the facet set '{facets}' does not exist",
                expected=f"One of: {known}",
                remedy=did_you_mean(facets, fe.facet_sets),
            )
        return fe.facet_sets[facets]
    return facets


def _nodal(fe: FEModel, facets: str | np.ndarray, force) -> np.ndarray:
    """Return the nodal forces (n, 6, 1) of a force per reference area, given the facets' normals."""
    facets = _rows(fe, facets)
    nodal = np.zeros((len(fe.nodes), 6, 1))
    width = (facets >= 0).sum(axis=1)
    for nn in np.unique(width):
        chosen = facets[width == nn][:, :nn]
        value, gradient, weight = _facet_tables(int(nn))
        x = fe.nodes[chosen]
        tangents = np.einsum("fak,qad->fqdk", x, gradient)
        normal = np.cross(tangents[:, :, 0], tangents[:, :, 1])  # its length is the area per unit of X
        forces = np.einsum("q,qa,fqk->fak", weight, value, force(normal))
        np.add.at(nodal[:, :3, 0], chosen, forces)
    return nodal


def _facet_tables(nn: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return values (nq, nn), gradients (nq, nn, 2) and weights (nq,) in meshio's node order."""
    import skfem
    from skfem.quadrature import get_quadrature

    from flexmb.fem.solids.elements import locate

    shape, name, order = FACETS[nn]
    corners = CORNERS[shape]
    nodes = np.vstack([corners, (corners + np.roll(corners, -1, axis=0)) / 2, [[0.5, 0.5]]])[:nn]
    basis = getattr(skfem, name)()
    points, weight = get_quadrature(basis, order)
    found = [basis.lbasis(points.copy(), int(i)) for i in locate(nodes, basis.doflocs)]
    value = np.column_stack([np.broadcast_to(phi, weight.shape) for phi, _ in found])
    gradient = np.stack(
        [np.stack([np.broadcast_to(d, weight.shape) for d in dphi], axis=-1) for _, dphi in found], axis=1
    )
    return value, gradient, weight
