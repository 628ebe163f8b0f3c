"""`joined`: FE models of different kinds as one part: a skin of shells with stringers of beams, beams on solids."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError
from flexmb.fem.fe_model import ElementBlock, FEModel
from flexmb.fem.meshes.groups import stacked
from flexmb.fem.nodal_assembly import freedom_rows
from flexmb.fem.split import DivisibleBlock
from flexmb.fem.told import keeping_warnings
from flexmb.model.numbering import Numbering

__all__ = ["PlacedBlock", "joined"]

COINCIDENT = 1e-6
"""Nodes of different models nearer than this fraction of the size of the whole become one node."""


@keeping_warnings
def joined(*models: FEModel, name: str | None = None) -> FEModel:
    """Return one model of several: nodes at the same place become one, stiffness and mass add up.

    A node has every freedom that one of the models gives it. A node of solids has no rotations: a beam or a shell that
    ends on it is hinged there. Hold it by a rigid link over a face instead (`with_rigid_link`); then the models need no
    common node.

    Parameters
    ----------
    models : FEModel
        Without links, which come after joining. Nodes within one model are kept apart, whatever their distance.
    name : str
        Default: the name of the first model.

    Returns
    -------
    FEModel
        Sets of the same name are united.

    Raises
    ------
    MeshError
        Fewer than two models, a model with links, a node that meets two nodes of another model.

    Examples
    --------
    >>> from flexmb.fem import Section, frame
    >>> from flexmb.model.material import Material
    >>> steel, tube = Material(young=210e9, poisson=0.3, density=7850.0), Section.tube(0.05, 0.002)
    >>> mast = frame([(0, 0, 0), (0, 0, 2)], section=tube, material=steel)
    >>> yard = frame([(-1, 0, 2), (0, 0, 2), (1, 0, 2)], section=tube, material=steel)
    >>> joined(mast, yard).nodes.shape                           # the top of the mast is the middle of the yard
    (4, 3)
    """
    _check(models)
    name = models[0].name if name is None else name
    every = np.vstack([fe.nodes for fe in models])
    nodes, numbers = models[0].nodes, [np.arange(len(models[0].nodes))]
    tolerance = COINCIDENT * float(np.linalg.norm(np.ptp(every, axis=0)))
    for fe in models[1:]:
        number = _placed(fe, nodes, tolerance)
        nodes = np.vstack([nodes, fe.nodes[number >= len(nodes)]])
        numbers.append(number)
    pairs = [np.column_stack([number[fe.dofs[:, 0]], fe.dofs[:, 1]]) for fe, number in zip(models, numbers)]
    dofs = np.unique(np.vstack(pairs), axis=0)
    row = freedom_rows(dofs, len(nodes))
    K, M = sparse.csr_matrix((len(dofs),) * 2), sparse.csr_matrix((len(dofs),) * 2)
    for fe, pair in zip(models, pairs, strict=True):
        into = sparse.csr_matrix(
            (np.ones(fe.ndof), (row[pair[:, 0], pair[:, 1]], np.arange(fe.ndof))), shape=(len(dofs), fe.ndof)
        )
        K, M = K + into @ fe.K @ into.T, M + into @ fe.M @ into.T
    return FEModel(
        nodes=nodes,
        dofs=dofs,
        K=K.tocsr(),
        M=M.tocsr(),
        name=name,
        node_sets=_node_sets(models, numbers),
        facet_sets=_facet_sets(models, numbers),
        blocks=tuple(
            PlacedBlock(block=block, number=number, number_of_nodes=len(nodes))
            for fe, number in zip(models, numbers)
            for block in fe.blocks
        ),
        numbering=_numbering(models, numbers, len(nodes)),
    )


def _numbering(models, numbers, count: int) -> Numbering | None:
    """Return the numbers that nodes and cells have in their files; models of several files are told by their names."""
    known = [fe for fe in models if fe.numbering is not None]
    if not known:
        return None
    nodes, owner, cells = np.zeros(count, np.int64), np.full(count, -1), []
    instances: list[str] = []
    for fe, number in zip(models, numbers, strict=True):
        own = fe.numbering or Numbering(nodes=np.zeros(0, np.int64))
        own = own.padded(len(fe.nodes), [len(block.connectivity) for block in fe.blocks])
        cells += own.cells
        new = (nodes[number] == 0) & (own.nodes > 0)  # a common node keeps the number of the first model
        nodes[number[new]] = own.nodes[new]
        inside = np.full(len(number), -1) if own.instance_of is None else own.instance_of
        prefix = f"{fe.name}." if len(known) > 1 else ""
        names = [*(f"{prefix}{name}" for name in own.instances), fe.name]
        place = np.where(inside >= 0, inside, len(names) - 1 if len(known) > 1 else -1 - len(instances))
        owner[number[new]] = len(instances) + place[new]
        instances += names
    several = (owner >= 0).any()
    return Numbering(
        nodes=nodes,
        cells=tuple(cells),
        instances=tuple(instances) if several else (),
        instance_of=owner if several else None,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class PlacedBlock:
    """Elements of a model that became part of a larger one: an `ElementBlock` around another one.

    Parameters
    ----------
    block : ElementBlock
    number : (own nodes,), int
        Node numbers in the larger model; each occurs once.
    number_of_nodes : int
        Of the larger model.
    """

    block: ElementBlock
    number: np.ndarray
    number_of_nodes: int

    @property
    def cell_type(self) -> str:
        """Cell name in meshio's spelling."""
        return self.block.cell_type

    @cached_property
    def connectivity(self) -> np.ndarray:
        """(ne, nodes per cell), int, node numbers of the larger model."""
        return self.number[self.block.connectivity]

    @property
    def modulus(self) -> float:
        """Largest elastic stiffness of the material, Pa."""
        return self.block.modulus

    def part(self, chosen: np.ndarray, nodes: np.ndarray, number: np.ndarray) -> PlacedBlock:
        """Return the chosen elements (mask) on the given nodes (old numbers); `number` (n,) are the new ones."""
        kept = np.flatnonzero(number[self.number] >= 0)
        own = np.full(len(self.number), -1)
        own[kept] = np.arange(len(kept))
        divided: DivisibleBlock = self.block  # type: ignore[assignment]
        return PlacedBlock(
            block=divided.part(chosen, kept, own), number=number[self.number[kept]], number_of_nodes=len(nodes)
        )

    def matrices(self, dofs: np.ndarray, lumped: bool) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """Return K and M (ndof, ndof) of these elements, in the freedoms `dofs`."""
        here, own = self._freedoms(dofs)
        divided: DivisibleBlock = self.block  # type: ignore[assignment]
        K, M = (_spread(matrix, here, len(dofs)) for matrix in divided.matrices(own, lumped))
        return K, M

    def geometric_stiffness(self, displacement: np.ndarray, dofs: np.ndarray) -> sparse.csr_matrix:
        """Initial-stress stiffness (ndof, ndof), N/m, of the stress that `displacement` (n, 6), m, causes."""
        here, own = self._freedoms(dofs)
        return _spread(self.block.geometric_stiffness(displacement[self.number], own), here, len(dofs))

    def projected_geometric_stiffness(self, displacements: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """``modes^T K_g modes`` for each load case: (l, m, m), N/m."""
        return self.block.projected_geometric_stiffness(displacements[self.number], modes[self.number])

    def nodal_stress(self, displacements: np.ndarray) -> np.ndarray:
        """Stress xx, yy, zz, xy, yz, zx at nodes, (n, 6, k), Pa; NaN at nodes of other blocks."""
        stress = np.full(displacements.shape, np.nan)
        stress[self.number] = self.block.nodal_stress(displacements[self.number])
        return stress

    def element_stress(self, displacements: np.ndarray, cells: np.ndarray | None = None) -> np.ndarray:
        """Stress (ne, nodes of a cell, 6, k), Pa, at the nodes of chosen cells, each cell by itself."""
        return self.block.element_stress(displacements[self.number], cells)  # type: ignore[attr-defined]

    def _freedoms(self, dofs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the rows of `dofs` at nodes of these elements, and the same freedoms by own node numbers."""
        own = np.full(self.number_of_nodes, -1)
        own[self.number] = np.arange(len(self.number))
        here = np.flatnonzero(own[dofs[:, 0]] >= 0)
        return here, np.column_stack([own[dofs[here, 0]], dofs[here, 1]])


def _spread(matrix: sparse.csr_matrix, rows: np.ndarray, size: int) -> sparse.csr_matrix:
    entries = matrix.tocoo()
    return sparse.csr_matrix((entries.data, (rows[entries.row], rows[entries.col])), shape=(size, size))


def _check(models: tuple[FEModel, ...]) -> None:
    if len(models) < 2:
        raise MeshError(
            "Joined FE models",
            found=f"{len(models)} models",
            expected="two or more",
            remedy="Call fem.joined(first, second, ...)",
        )
    for fe in models:
        if fe.expansion is not None:
            raise MeshError(
                f"FE model '{fe.name}'",
                found="a model with links",
                expected="models without links",
                remedy="Join first, then call fem.with_rigid_link or fem.with_averaging_link",
            )


def _placed(fe: FEModel, nodes: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the number of each node of a model among the nodes so far (n, 3), new ones behind them."""
    from scipy.spatial import cKDTree

    distance, nearest = cKDTree(nodes).query(fe.nodes, k=min(2, len(nodes)))
    distance, nearest = distance.reshape(len(fe.nodes), -1), nearest.reshape(len(fe.nodes), -1)
    meets = distance[:, 0] <= tolerance
    taken = np.sort(nearest[meets, 0])
    twice = np.flatnonzero(meets & (distance[:, -1] <= tolerance)) if distance.shape[1] > 1 else np.zeros(0, int)
    same = np.flatnonzero(meets & np.isin(nearest[:, 0], taken[:-1][np.diff(taken) == 0]))
    if len(twice) or len(same):
        at = fe.nodes[(twice if len(twice) else same)[0]]
        raise MeshError(
            f"FE model '{fe.name}'",
            found=f"several nodes at ({at[0]:.6g}, {at[1]:.6g}, {at[2]:.6g}) m "
            "within one model, where models are to be joined",
            expected="one node per model at a place",
            remedy="Merge duplicate nodes in the mesh, or join away from the cut",
        )
    number = np.where(meets, nearest[:, 0], -1)
    number[~meets] = len(nodes) + np.arange((~meets).sum())
    return number


def _node_sets(models, numbers) -> dict[str, np.ndarray]:
    sets: dict[str, np.ndarray] = {}
    for fe, number in zip(models, numbers, strict=True):
        for key, members in fe.node_sets.items():
            sets[key] = np.union1d(sets.get(key, np.zeros(0, int)), number[members])
    return sets


def _facet_sets(models, numbers) -> dict[str, np.ndarray]:
    sets: dict[str, np.ndarray] = {}
    for fe, number in zip(models, numbers, strict=True):
        renumber = np.append(number, -1)  # the filler -1 of mixed facet rows stays -1
        for key, facets in fe.facet_sets.items():
            mine = renumber[np.asarray(facets, int)]
            sets[key] = stacked([sets[key], mine]) if key in sets else mine
    return sets
