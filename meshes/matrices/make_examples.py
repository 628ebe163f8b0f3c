"""Make the example matrices of this folder: one part per file format that `fem.read_matrices` reads.

    python meshes/matrices/make_examples.py

`block` is a steel block of 0.2 x 0.1 x 0.05 m, two hexahedra (.inp, .mtx); `beam` a steel tube of 0.6 m, three beams
(.npz, .pch). The CalculiX files are not stored: run ``ccx block`` in a copy of this folder.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.io import mmwrite

from flexmb import fem
from flexmb.model.material import Material

FOLDER = Path(__file__).parent
STEEL = Material(young=210e9, poisson=0.3, density=7850.0)

BLOCK = """** Block of two hexahedra, m, N, kg, s. ccx block writes block.sti, block.mas and block.dof.
*NODE, NSET=all
{nodes}
*ELEMENT, TYPE=C3D8, ELSET=block
1, 1, 2, 5, 4, 7, 8, 11, 10
2, 2, 3, 6, 5, 8, 9, 12, 11
*NSET, NSET=left
1, 4, 7, 10
*NSET, NSET=right
3, 6, 9, 12
*MATERIAL, NAME=steel
*ELASTIC
210e9, 0.3
*DENSITY
7850.
*SOLID SECTION, ELSET=block, MATERIAL=steel
*STEP
*FREQUENCY, SOLVER=MATRIXSTORAGE
1
*END STEP
"""


def block_positions() -> np.ndarray:
    """Return the positions (12, 3), m, of the nodes 1..12 of the block."""
    z, y, x = np.meshgrid((0.0, 0.05), (0.0, 0.1), (0.0, 0.1, 0.2), indexing="ij")
    return np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)


def beam() -> fem.FEModel:
    """Return the tube: four nodes along x, six freedoms each."""
    points = np.linspace((0.0, 0.0, 0.0), (0.6, 0.0, 0.0), 4)
    return fem.frame(points, section=fem.Section.tube(0.04, 0.003), material=STEEL, name="beam")


def write_block(folder: Path) -> None:
    """Write block.inp and its matrices: Abaqus block_STIF1.mtx and block_MASS1.mtx, Matrix-Market block_[KM].mtx."""
    positions = block_positions()
    lines = [f"{number}, {x:.2f}, {y:.2f}, {z:.2f}" for number, (x, y, z) in enumerate(positions, start=1)]
    (folder / "block.inp").write_text(BLOCK.format(nodes="\n".join(lines)))
    mesh = fem.read_mesh(folder / "block.inp")
    model = fem.solid(mesh, STEEL)
    for kind, symbol, matrix in (("STIF", "K", model.K), ("MASS", "M", model.M)):
        mmwrite(folder / f"block_{symbol}.mtx", sparse.tril(matrix), symmetry="symmetric", precision=17)
        lower = sparse.tril(matrix).tocoo()
        rows = []
        for i, j, value in zip(lower.row, lower.col, lower.data):
            (node, direction), (other, along) = model.dofs[i] + 1, model.dofs[j] + 1
            rows.append(f"{node},{direction}, {other},{along}, {value:.17e}\n")
        (folder / f"block_{kind}1.mtx").write_text("".join(rows))


def write_beam(folder: Path) -> None:
    """Write beam.npz and beam.pch (Nastran DMIG, symmetric, with GRID cards; the nodes are numbered 101, 102, ...)."""
    model = beam()
    fem.write_matrices(folder / "beam.npz", model)
    lines = ["$ Steel tube of 0.6 m, K and M as DMIG, with its grid points"]
    lines += [
        f"{'GRID*':8s}{101 + k:16d}{'':16s}{x:16.9f}{y:16.9f}\n{'*':8s}{z:16.9f}"
        for k, (x, y, z) in enumerate(model.nodes)
    ]
    for name, matrix in (("KAAX", model.K), ("MAAX", model.M)):
        lines.append(f"{'DMIG':8s}{name:8s}{0:8d}{6:8d}{2:8d}{0:8d}{'':8s}{'':8s}{model.ndof:8d}")
        lower = sparse.tril(matrix).tocsc()
        for column in range(model.ndof):
            node, direction = model.dofs[column]
            lines.append(f"{'DMIG*':8s}{name:16s}{101 + node:16d}{direction + 1:16d}")
            for k in range(lower.indptr[column], lower.indptr[column + 1]):
                row_node, row_direction = model.dofs[lower.indices[k]]
                value = f"{lower.data[k]:.9E}".replace("E", "D")
                lines.append(f"{'*':8s}{101 + row_node:16d}{row_direction + 1:16d}{value:>16s}")
    (folder / "beam.pch").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    write_block(FOLDER)
    write_beam(FOLDER)
