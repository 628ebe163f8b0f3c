"""Hand-made FE models for the tests: a planar cubic beam with two freedoms per node (Hermite, consistent mass)."""

import numpy as np
from scipy import sparse

from flexmb.fem.fe_model import FEModel


def planar_beam(n_el=20, length=2.0, EI=None, rhoA=None, E=210e9, rho=7850.0, b=0.04, h=0.02) -> FEModel:
    """Bending in x-y: freedoms uy and rz; the textbook 4x4 matrices of the Hermite beam."""
    EI = E * b * h**3 / 12 if EI is None else EI
    rhoA = rho * b * h if rhoA is None else rhoA
    l = length / n_el
    k = (
        EI
        / l**3
        * np.array(
            [
                [12, 6 * l, -12, 6 * l],
                [6 * l, 4 * l * l, -6 * l, 2 * l * l],
                [-12, -6 * l, 12, -6 * l],
                [6 * l, 2 * l * l, -6 * l, 4 * l * l],
            ]
        )
    )
    m = (
        rhoA
        * l
        / 420
        * np.array(
            [
                [156, 22 * l, 54, -13 * l],
                [22 * l, 4 * l * l, 13 * l, -3 * l * l],
                [54, 13 * l, 156, -22 * l],
                [-13 * l, -3 * l * l, -22 * l, 4 * l * l],
            ]
        )
    )
    n = n_el + 1
    K, M = sparse.lil_matrix((2 * n, 2 * n)), sparse.lil_matrix((2 * n, 2 * n))
    for e in range(n_el):
        rows = slice(2 * e, 2 * e + 4)
        K[rows, rows] += k
        M[rows, rows] += m
    nodes = np.column_stack([np.linspace(0, length, n), np.zeros(n), np.zeros(n)])
    dofs = np.column_stack([np.repeat(np.arange(n), 2), np.tile([1, 5], n)])
    return FEModel(
        nodes=nodes,
        dofs=dofs,
        K=K.tocsr(),
        M=M.tocsr(),
        node_sets={"left": np.array([0]), "right": np.array([n_el])},
        name="planar beam",
    )
