"""FE12, NAFEMS LE10: thick elliptic plate under pressure; stress at the inner upper edge.

NAFEMS, The Standard NAFEMS Benchmarks (1990), test LE10: quarter of a plate 0.6 m thick between two ellipses,
1 MPa on the upper face; target sigma_yy = -5.38 MPa at D (2, 0, 0.3).
"""

import numpy as np
import pytest
from by_turns import slow
from fem.structured import structured

from flexmb import fem
from flexmb.model.material import Material


def elliptic(points):
    """Map the unit block (radial, angular, thickness) to the quarter plate; D is the image of (0, 0, 1)."""
    r, t, z = points.T
    angle = t * np.pi / 2
    x = (2.0 + 1.25 * r) * np.cos(angle)
    y = (1.0 + 1.75 * r) * np.sin(angle)
    return np.column_stack([x, y, 0.6 * (z - 0.5)])


@pytest.mark.parametrize(
    ("cell_type", "shape"),
    [("hexahedron20", (6, 8, 4)), ("hexahedron27", (6, 8, 4)), slow("tetra10", (10, 14, 6)), ("wedge15", (10, 14, 8))],
)
def test_le10(reference, cell_type, shape):
    mesh = structured(cell_type, shape, curve=elliptic)
    fe = fem.solid(mesh, Material(young=210e9, poisson=0.3, density=7800.0))
    middle = mesh.node_sets["x1"][np.abs(mesh.points[mesh.node_sets["x1"], 2]) < 1e-9]
    held = fem.fixed_freedoms(fe, {"y0": "y", "y1": "x", "x1": "xy"})
    held |= np.isin(fe.dofs[:, 0], middle) & (fe.dofs[:, 1] == 2)
    u = fem.static(fe, fem.pressure_load(fe, "z1", 1e6), held)
    stress = fe.blocks[0].nodal_stress(fe.field(u))[:, 1, 0]
    (d,) = np.flatnonzero(np.linalg.norm(mesh.points - [2.0, 0.0, 0.3], axis=1) < 1e-9)
    assert stress[d] / 1e6 == pytest.approx(reference("FE12")["reference"]["LE10_MPa"], rel=0.03)
