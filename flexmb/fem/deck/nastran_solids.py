"""Solids of a Nastran deck with their properties: PSOLID; others are refused by name."""

from __future__ import annotations

import numpy as np

from flexmb.fem.deck.cells import SolidCells, some
from flexmb.fem.deck.contents import Deck, Solids
from flexmb.fem.deck.nastran_materials import Materials
from flexmb.fem.deck.nastran_systems import Systems
from flexmb.fem.deck.nastran_text import Bulk, Card

__all__ = ["add_solids", "turned_solid"]

SOLIDS = {
    "CTETRA": ("tetra", "tetra10", 4, 10),
    "CPENTA": ("wedge", "wedge15", 6, 15),
    "CHEXA": ("hexahedron", "hexahedron20", 8, 20),
    "CPYRAM": ("pyramid", "pyramid13", 5, 13),
}
ORDER = {
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
}
"""Nastran numbers the vertical edges before the edges of the upper face, meshio after."""


REMEDIES = {
    "PCOMPS": "Write one layer of solids with a PSOLID per ply, or shells with a PCOMP",
    "PCOMPLS": "Write one layer of solids with a PSOLID per ply, or shells with a PCOMP",
    "PLSOLID": "Give these hyperelastic solids a PSOLID with the MAT1 of small strains",
    "PMIC": "Fluids are not read: remove them",
}


def add_solids(bulk: Bulk, deck: Deck, materials: Materials, systems: Systems) -> None:
    """Add tetrahedra, wedges, hexahedra and pyramids of both orders, with midside nodes left out or not."""
    properties = {card.integer(1): card for card in bulk.of("PSOLID", "PLSOLID", "PCOMPS", "PCOMPLS", "PMIC")}
    for name, (low, high, corners, count) in SOLIDS.items():
        table = bulk.tables.get(name)
        if table is None or not len(table):
            continue
        deck.inventory.read[name] += len(table)
        labels = table.integers(1)
        pids = np.where(table.blank(2), labels, table.integers(2))
        last = max((k for k in range(count) if not table.blank(3 + k).all()), default=0)
        used = count if last >= corners else corners  # a table of first order has no columns of midside nodes
        given = np.empty((len(table), used), np.int64)
        for k in range(used):
            given[:, k] = table.integers(3 + k)
        if (given[:, :corners] < 1).any():
            row = int(np.flatnonzero((given[:, :corners] < 1).any(axis=1))[0])
            raise table.card(row).refused(
                f"{int((given[row] > 0).sum())} nodes", f"{corners} corner nodes at least", "Complete the card"
            )
        empty = given < 1
        np.copyto(given, given[:, :1], where=empty)
        nodes = deck.numbers(given, f"{name} cards", out=given)
        nodes[empty] = -1
        del given, empty
        if high in ORDER and used == count:
            nodes = nodes[:, ORDER[high]]
        for pid in np.unique(pids):
            rows = np.flatnonzero(pids == pid)
            if int(pid) not in properties:
                raise table.card(int(rows[0])).refused(f"the property {pid}, which does not exist", "a PSOLID card")
            card = properties[int(pid)]
            if card.name != "PSOLID":
                remedy = REMEDIES.get(card.name, "Give these solids a linear property")
                raise card.refused(f"a property {card.name}", "PSOLID", remedy)
            if card.text(7).upper() in ("FFLUID", "PFLUID") or card.text(3).upper() == "FLUID":
                raise card.refused("a fluid (FCTN)", "structural solids", "Remove the fluid")
            material = materials.get(card.integer(2), card.where)
            if material.solid is None:
                raise card.refused(f"the material {material.name}", "MAT1 or MAT9 for solids")
            cells = SolidCells(low, high, corners, some(nodes, rows), labels[rows])
            for cell_type, connectivity, own in cells.parts(deck):
                for elasticity, chosen in _oriented(card, material.solid, connectivity, deck, systems):
                    deck.solids.append(
                        Solids(
                            cell_type=cell_type,
                            nodes=some(connectivity, chosen),
                            labels=own[chosen],
                            elasticity=elasticity,
                            density=material.density,
                            group=f"pid_{pid}",
                        )
                    )
    for card in properties.values():
        deck.inventory.read[card.name] += 1


def _oriented(card: Card, solid: np.ndarray, nodes: np.ndarray, deck: Deck, systems: Systems):
    """Yield (elasticity in basic axes, element numbers): one for all, or one per direction of a curved system."""
    everything = np.arange(len(nodes))
    isotropic = np.allclose(solid, turned_solid(solid, _any_rotation()), rtol=1e-9, atol=1e-9 * np.abs(solid).max())
    if isotropic:
        yield solid, everything
        return
    number = card.integer(3, 0)
    if number == -1:
        raise card.refused(
            "CORDM = -1 (axes of each element) with an anisotropic material",
            "a coordinate system",
            "Give CORDM the number of a system",
        )
    system = systems.system(number, card.where)
    axes = system.directions(deck.points[nodes].mean(axis=1))
    groups, which = np.unique(np.round(axes.reshape(len(axes), 9), 9), axis=0, return_inverse=True)
    for k in range(len(groups)):
        chosen = np.flatnonzero(which.ravel() == k)
        yield turned_solid(solid, axes[chosen[0]].T), chosen


def _any_rotation() -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()


def turned_solid(elasticity: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return an elasticity (6, 6), xx yy zz xy yz zx, in the axes in which the material axes are `columns` (3, 3)."""
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
    stress = np.array(
        [
            [columns[i, k] * columns[j, m] + (columns[i, m] * columns[j, k] if k != m else 0.0) for k, m in pairs]
            for i, j in pairs
        ]
    )
    return stress @ elasticity @ stress.T
