"""Nodal stress where cells of several kinds and materials meet, against uniform strain in closed form."""

import numpy as np
import pytest
from fem.structured import structured
from tolerances import MACHINE

from flexmb import fem
from flexmb.fem.meshes.mesh import Mesh
from flexmb.model.material import Material
from flexmb.reduction.stress import stress_modes

STEEL = Material(young=210e9, poisson=0.0, density=7850.0)
ALUMINIUM = Material(young=70e9, poisson=0.0, density=2700.0)


def stretched(nodes, strain=1e-4):
    field = np.zeros((len(nodes), 6, 1))
    field[:, 0, 0] = strain * nodes[:, 0]
    return field


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_node_between_materials_shows_the_stiffer_one(order):
    """Two materials side by side under one strain: sigma = E eps in each, at the joint that of steel."""
    mesh = structured("hexahedron20", (2, 2, 1))
    lower = mesh.points[mesh.cells[0][1]].mean(axis=1)[:, 1] < np.median(mesh.points[:, 1])
    sets = {"steel": (np.flatnonzero(lower),), "aluminium": (np.flatnonzero(~lower),)}
    given = [("steel", STEEL), ("aluminium", ALUMINIUM)]
    fe = fem.solid(Mesh(points=mesh.points, cells=mesh.cells, cell_sets=sets), dict(given[k] for k in order))
    sigma = stress_modes(fe, stretched(fe.nodes))[:, 0, 0]
    at_steel = np.isin(np.arange(len(fe.nodes)), mesh.cells[0][1][lower])
    assert sigma[at_steel] == pytest.approx(1e-4 * STEEL.young, rel=1e3 * MACHINE)
    assert sigma[~at_steel] == pytest.approx(1e-4 * ALUMINIUM.young, rel=1e3 * MACHINE)


def test_cells_of_two_kinds_average_as_cells(rng):
    """A cube of two wedges beside a cube of one hexahedron: each cell counts once, not each kind."""
    hexa, wedge = structured("hexahedron", (1, 1, 1)), structured("wedge", (1, 1, 1))
    shift = [np.ptp(hexa.points[:, 0]), 0.0, 0.0]
    fe = fem.joined(fem.solid(hexa, STEEL), fem.solid(Mesh(points=wedge.points + shift, cells=wedge.cells), STEEL))
    field = 1e-4 * rng.standard_normal((len(fe.nodes), 6, 2))
    got = stress_modes(fe, field)
    parts = [
        (block.nodal_stress(field), np.bincount(block.connectivity.ravel(), minlength=len(fe.nodes)))
        for block in fe.blocks
    ]
    for node in range(len(fe.nodes)):
        cells = [(stress[node], count[node]) for stress, count in parts if count[node]]
        mean = sum(stress * count for stress, count in cells) / sum(count for _, count in cells)
        assert np.allclose(got[node], mean, rtol=1e-12, atol=1e-12 * np.abs(got).max())
    assert max(sum(count[node] > 0 for _, count in parts) for node in range(len(fe.nodes))) == 2
