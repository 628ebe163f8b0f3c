"""Modal neutral data with one cell of every type that bodies are made of."""

from dataclasses import replace

import numpy as np
from results.spinning import block_data


def unit_cells():
    """One cell of every solid type that bodies are made of, far enough apart, with VTK's node order."""
    edges = {
        "tetra10": (4, [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]),
        "hexahedron20": (
            8,
            [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
        ),
        "wedge15": (6, [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]),
    }
    corners = {
        4: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
        6: [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (0, 1))],
        8: [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))],
    }
    nodes, cells = [], []
    for k, (name, (n, pairs)) in enumerate(edges.items()):
        own = np.array(corners[n], float)
        own = np.vstack([own, [(own[i] + own[j]) / 2 for i, j in pairs]]) + (2.0 * k, 0, 0)
        start = sum(len(x) for x in nodes)
        cells.append((name, start + np.arange(len(own))[None]))
        nodes.append(own)
    start = sum(len(x) for x in nodes)
    nodes.append(np.array([[0, 0, 3.0], [1, 0, 3], [2, 0, 3]]))
    cells += [("line", np.array([[start, start + 1]])), ("line3", np.array([[start, start + 2, start + 1]]))]
    cells += [
        ("tetra", np.array([[0, 1, 2, 3]])),
        ("hexahedron", np.arange(10, 18)[None]),
        ("wedge", np.arange(30, 36)[None]),
    ]
    return np.vstack(nodes), tuple(cells)


def every_cell_data():
    nodes, cells = unit_cells()
    n = len(nodes)
    rng = np.random.default_rng(2)
    return replace(
        block_data(),
        nodes=nodes,
        cells=cells,
        shapes=rng.normal(size=(n, 3, 2)),
        stress_modes=rng.normal(size=(n, 6, 2)) * 1e9,
    )
