"""Cells of a mirror image are not inside out: every cell type, against its own template."""

import numpy as np
import pytest
from tolerances import MACHINE

from flexmb.io.cell_types import VTK_TYPES
from flexmb.model.mirrored_cells import ORDERS, mirrored_cells

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
RING3, RING4 = [(0, 1), (1, 2), (2, 0)], [(0, 1), (1, 2), (2, 3), (3, 0)]
TRIANGLE, QUAD = [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(*xy, 0) for xy in SQUARE]
TETRA, PYRAMID = [*TRIANGLE, (0, 0, 1)], [*QUAD, (0.5, 0.5, 1)]
WEDGE = [*TRIANGLE, (0, 0, 1), (1, 0, 1), (0, 1, 1)]
CUBE = [*QUAD, *[(*xy, 1) for xy in SQUARE]]
CUBE_EDGES = [*RING4, *[(a + 4, b + 4) for a, b in RING4], *[(k, k + 4) for k in range(4)]]
CUBE_FACES = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (2, 3, 7, 6), (0, 1, 2, 3), (4, 5, 6, 7), range(8)]
PYRAMID_EDGES = [*RING4, *[(k, 4) for k in range(4)]]
TEMPLATES = {  # corners, then the corners whose mean each further node is, in VTK's order
    "triangle": (TRIANGLE, []),
    "triangle6": (TRIANGLE, RING3),
    "quad": (QUAD, []),
    "quad8": (QUAD, RING4),
    "quad9": (QUAD, [*RING4, range(4)]),
    "tetra": (TETRA, []),
    "tetra10": (TETRA, [*RING3, (0, 3), (1, 3), (2, 3)]),
    "hexahedron": (CUBE, []),
    "hexahedron20": (CUBE, CUBE_EDGES),
    "hexahedron27": (CUBE, [*CUBE_EDGES, *CUBE_FACES]),
    "wedge": (WEDGE, []),
    "wedge15": (WEDGE, [*RING3, *[(a + 3, b + 3) for a, b in RING3], *[(k, k + 3) for k in range(3)]]),
    "pyramid": (PYRAMID, []),
    "pyramid13": (PYRAMID, PYRAMID_EDGES),
}


@pytest.mark.parametrize("kind", TEMPLATES)
def test_image_is_an_affine_map_that_keeps_the_inside(kind):
    corners, means = TEMPLATES[kind]
    corners = np.array(corners, float)
    nodes = np.array([*corners, *(corners[list(mean)].mean(axis=0) for mean in means)])
    mirrored = nodes * (1.0, -1.0, 1.0)
    ((_, order),) = mirrored_cells(((kind, np.arange(len(nodes))[None]),))
    before, after = nodes - nodes[0], mirrored[order[0]] - mirrored[order[0, 0]]
    matrix, _, rank, _ = np.linalg.lstsq(before, after, rcond=None)
    np.testing.assert_allclose(before @ matrix, after, atol=MACHINE)
    if rank == 3:
        assert np.linalg.det(matrix) > 0.0
    else:  # the face keeps its side: its normal z lies in the mirror
        assert np.cross(after[1], after[2])[2] > 0.0


def test_points_and_lines_have_no_inside():
    cells = (("vertex", np.array([[3]])), ("line", np.array([[0, 1]])), ("line3", np.array([[0, 1, 2]])))
    for (_, before), (_, after) in zip(cells, mirrored_cells(cells), strict=True):
        np.testing.assert_array_equal(before, after)
    assert set(VTK_TYPES) - set(ORDERS) == {"vertex", "line", "line3"}
