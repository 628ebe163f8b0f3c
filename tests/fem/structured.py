"""Small structured meshes of every solid cell type, straight or curved, for the tests."""

from itertools import permutations

import numpy as np

from flexmb.fem import Mesh
from flexmb.fem.solids.elements import HEX, SOLID_ELEMENTS, TET, WEDGE

CELL_TYPES = tuple(SOLID_ELEMENTS)
QUADRATIC = tuple(name for name, element in SOLID_ELEMENTS.items() if element.order == 2)


def unit_cells(family):
    """Corner positions (nc, 3) of the cells that fill the unit cube."""
    if family == "hexahedron":
        return [HEX]
    if family == "wedge":
        return [WEDGE, WEDGE @ np.diag([-1.0, -1.0, 1.0]) + [1.0, 1.0, 0.0]]
    cells = []
    for order in permutations(range(3)):  # Kuhn's six tetrahedra along the diagonal
        corners = np.zeros((4, 3))
        for k, axis in enumerate(order):
            corners[k + 1 :, axis] += 1.0
        if np.linalg.det(corners[1:] - corners[0]) < 0.0:
            corners = corners[[0, 2, 1, 3]]
        cells.append(corners)
    return cells


def structured(cell_type, shape=(2, 2, 2), size=(1.0, 1.0, 1.0), *, skew=0.0, curve=None, seed=1):
    """Return a mesh of a block. `skew` moves inner corners by that fraction of a cell, `curve` maps all nodes."""
    element = SOLID_ELEMENTS[cell_type]
    corners = {"tetra": TET, "hexahedron": HEX, "wedge": WEDGE}[element.family]
    # Nodes of the reference cell from its corners, by shape functions of the linear cell.
    linear = {"tetra": "tetra", "hexahedron": "hexahedron", "wedge": "wedge"}[element.family]
    from flexmb.fem.solids.elements import shape_functions

    weights = shape_functions(SOLID_ELEMENTS[linear], element.nodes)[0]
    assert np.allclose(weights @ corners, element.nodes)
    shape, size = np.array(shape), np.array(size, float)
    rng = np.random.default_rng(seed)
    moves = skew * rng.uniform(-1, 1, (*(shape + 1), 3))
    for axis in range(3):  # the surface stays a block
        moves[(slice(None),) * axis + ([0, -1],)] = 0.0
    numbers, points, cells = {}, [], []
    for index in np.ndindex(*shape):
        for cell in unit_cells(element.family):
            grid = np.rint(cell + index).astype(int)
            place = (grid + moves[tuple(grid.T)]) * size / shape
            positions = weights @ place
            keys = np.rint(4 * (weights @ grid)).astype(int)
            row = []
            for key, position in zip(map(tuple, keys), positions):
                if key not in numbers:
                    numbers[key] = len(points)
                    points.append(position)
                row.append(numbers[key])
            cells.append(row)
    points = np.array(points)
    sets = {}
    for axis, letter in enumerate("xyz"):
        sets[f"{letter}0"] = np.flatnonzero(np.abs(points[:, axis]) < 1e-9)
        sets[f"{letter}1"] = np.flatnonzero(np.abs(points[:, axis] - size[axis]) < 1e-9)
    if curve is not None:
        points = curve(points)
    return Mesh(points=points, cells=((cell_type, np.array(cells)),), node_sets=sets, name=cell_type)


def skin_nodes(mesh):
    return np.unique(np.concatenate([mesh.node_sets[name] for name in ("x0", "x1", "y0", "y1", "z0", "z1")]))
