"""`read_matrices`: stiffness and mass from the files of other programs; one reader per format beside this
file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError
from flexmb.fem.announced import require_unpacked
from flexmb.fem.fe_model import FEModel
from flexmb.fem.foreign_files import read_market, require_file, understood, understood_matrix, whole_numbers
from flexmb.fem.matrices.abaqus import read_abaqus
from flexmb.fem.matrices.calculix import read_calculix
from flexmb.fem.matrices.from_matrices import from_matrices
from flexmb.fem.matrices.matrix_files import FileMatrices
from flexmb.fem.matrices.nastran import read_nastran
from flexmb.fem.matrices.op2 import read_op2
from flexmb.fem.matrices.op4 import read_op4
from flexmb.fem.node_table import NodeTable, node_table
from flexmb.files import replacing

__all__ = ["read_matrices", "write_matrices"]


def read_matrices(
    path: str | Path,
    nodes=None,
    *,
    mass: str | Path | None = None,
    length_unit: float = 1.0,
    mass_unit: float = 1.0,
    name: str | None = None,
) -> FEModel:
    """Return the FE model of matrices in a file, checked as by `from_matrices`.

    ================ ===================================== =========================================
    suffix           format                                mass, nodes when not given
    ================ ===================================== =========================================
    .npz             `write_matrices`, or scipy.sparse     in the same file, or `mass` and `nodes`
    .mtx             Matrix-Market                         must be given
    .mtx             Abaqus ``*MATRIX OUTPUT``, format     MASS for STIF in the name; `nodes` must
                     MATRIX INPUT, LABELS or COORDINATE    be given (COORDINATE: all nodes of the
                                                           matrix, rows by increasing number)
    .sti             CalculiX ``SOLVER=MATRIXSTORAGE``     .mas, .dof and .inp of the same name
    .pch .dmig       Nastran DMIG punch (KAAX, MAAX)       in the same file (GRID cards), or `nodes`
    .bdf .dat
    .op2 .op4        Nastran OUTPUT2, OUTPUT4 (KGG, MGG),  in the same file, or `mass`; `nodes` must be given
                     by pyYeti
    ================ ===================================== =========================================

    Parameters
    ----------
    path : file of the stiffness matrix, or of both
    nodes : path or (n, 3)
        Mesh file (.inp, .bdf) with the numbers of the nodes, or positions in the order of their numbers 1,
        2, ...
    mass : path
        File of the mass matrix.
    length_unit, mass_unit : float, m, kg
        See `from_matrices`.
    """
    path = Path(path)
    for kind, file in (("Matrix", path), ("Mass", mass)):
        if file is not None:
            require_file(f"{kind} file '{file}'", Path(file), "a file", "Check the folder")
    matrices = _read(path, None if mass is None else Path(mass))
    table = _table(path, nodes, matrices)
    with understood(f"Matrix file '{path}'", "nodes and freedoms that fit each other", "Export the matrices again"):
        positions, dofs, sets = _located(path, matrices, table)
    return from_matrices(
        matrices.K,
        matrices.M,
        positions,
        dofs,
        node_sets=sets,
        length_unit=length_unit,
        mass_unit=mass_unit,
        name=path.stem if name is None else name,
    )


def write_matrices(path: str | Path, fe: FEModel) -> None:
    """Write K, M, nodes, dofs and node sets of an FE model to an .npz file that `read_matrices` and numpy
    read."""
    path = Path(path)
    if path.suffix.lower() != ".npz" or not path.parent.is_dir():
        raise MeshError(
            f"Matrix file '{path}'",
            found=f"the suffix '{path.suffix}'" if path.parent.is_dir() else f"no folder '{path.parent}'",
            expected="a file .npz in an existing folder",
            remedy="Create the folder, or write another name",
        )
    arrays: dict[str, Any] = {"nodes": fe.nodes, "dofs": fe.dofs}
    for symbol, matrix in (("K", fe.K.tocsr()), ("M", fe.M.tocsr())):
        arrays |= {
            f"{symbol}_data": matrix.data,
            f"{symbol}_indices": matrix.indices,
            f"{symbol}_indptr": matrix.indptr,
        }
    arrays |= {f"set_{name}": numbers for name, numbers in fe.node_sets.items()}
    with replacing(path, f"Matrix file '{path}'") as part:
        np.savez_compressed(part, **arrays)


def _read(path: Path, mass: Path | None) -> FileMatrices:
    """Call the reader of the format; what it stumbles over is a MeshError with the file's name."""
    read = _reader(path)
    with understood_matrix(path):
        return read(path, mass)


def _reader(path: Path) -> Callable[[Path, Path | None], FileMatrices]:
    suffix = path.suffix.lower()
    if suffix == ".mtx":
        with path.open(encoding="utf-8", errors="replace") as file:
            return _read_market if file.readline().startswith("%%MatrixMarket") else read_abaqus
    readers = {
        ".npz": _read_npz,
        ".sti": read_calculix,
        ".pch": read_nastran,
        ".dmig": read_nastran,
        ".bdf": read_nastran,
        ".dat": read_nastran,
        ".op2": read_op2,
        ".op4": read_op4,
    }
    if suffix not in readers:
        raise MeshError(
            f"Matrix file '{path}'",
            found=f"the suffix '{suffix}'",
            expected="One of: .npz, .mtx, .sti, .pch, .dmig, .bdf, .dat, .op2, .op4",
            remedy="Read K and M with scipy and call fem.from_matrices",
        )
    return readers[suffix]


def _table(path: Path, nodes, matrices: FileMatrices) -> NodeTable:
    source = nodes if nodes is not None else matrices.nodes
    if source is None:
        raise MeshError(
            f"Matrix file '{path}'",
            found="no node positions",
            expected="the mesh of the matrices",
            remedy="Give nodes='mesh.inp', nodes='mesh.bdf' or an array (n, 3)",
        )
    return source if isinstance(source, NodeTable) else node_table(source)


def _located(path: Path, matrices: FileMatrices, table: NodeTable):
    """Return positions (n, 3) of the nodes that the matrices name, dofs (ndof, 2) or None, and the node
    sets."""
    labels = np.unique(matrices.labels) if matrices.labels is not None else table.labels
    unknown = np.setdiff1d(labels, table.labels)
    if len(unknown):
        raise MeshError(
            f"Matrix file '{path}'",
            found=f"node {unknown[0]} and {len(unknown) - 1} more have no position",
            expected="every node of the matrices in the mesh",
            remedy="Give the mesh file that the matrices were made from: nodes='...'",
        )
    positions = table.positions[np.searchsorted(table.labels, labels)]
    dofs = None
    if matrices.labels is not None:
        dofs = np.stack([np.searchsorted(labels, matrices.labels), np.asarray(matrices.directions)], axis=1)
    sets = {
        key: np.searchsorted(labels, found)
        for key, numbers in table.node_sets.items()
        if len(found := np.intersect1d(numbers, labels))
    }
    return positions, dofs, sets


def _read_market(path: Path, mass: Path | None) -> FileMatrices:
    if mass is None:
        raise MeshError(
            f"Matrix file '{path}'",
            found="one Matrix-Market file",
            expected="two: stiffness and mass",
            remedy="Give mass='M.mtx'",
        )
    with understood_matrix(mass):
        M = sparse.csr_matrix(read_market(mass))
    return FileMatrices(K=sparse.csr_matrix(read_market(path)), M=M)


def _read_npz(path: Path, mass: Path | None) -> FileMatrices:
    require_unpacked(path)
    if mass is not None:
        with understood_matrix(mass):
            require_unpacked(mass)
            M = _sound(mass, sparse.load_npz(mass))
        return FileMatrices(K=_sound(path, sparse.load_npz(path)), M=M)
    with np.load(path) as file:
        if "K_data" not in file or "nodes" not in file:
            raise MeshError(
                f"Matrix file '{path}'",
                found=f"the arrays {', '.join(file.files)}",
                expected="K_data, K_indices, K_indptr, the same of M, nodes, dofs (fem.write_matrices)",
                remedy="For two files of scipy.sparse.save_npz give mass='M.npz' and nodes",
            )
        K, M = (_sound(path, sparse.csr_matrix(tuple(file[f"{s}_{n}"] for n in _CSR))) for s in "KM")
        sets = {key.removeprefix("set_"): file[key] for key in file.files if key.startswith("set_")}
        nodes, dofs = file["nodes"], file["dofs"]
        if nodes.ndim != 2 or nodes.shape[1] != 3 or dofs.shape != (K.shape[0], 2):
            raise MeshError(
                f"Matrix file '{path}'",
                found=f"nodes of the shape {nodes.shape} and dofs of the shape {dofs.shape}",
                expected=f"(n, 3) and ({K.shape[0]}, 2), a row for each of K",
                remedy="Write the file again: fem.write_matrices",
            )
        table = NodeTable(labels=np.arange(len(nodes)), positions=np.asarray(nodes, float), node_sets=sets)
        return FileMatrices(K, M, labels=dofs[:, 0], directions=dofs[:, 1], nodes=table)


_CSR = ("data", "indices", "indptr")


def _sound(path: Path, matrix) -> sparse.csr_matrix:
    """Return a matrix of an .npz file as csr; scipy computes with its indices without looking at them."""
    if matrix.format in ("csr", "csc", "bsr"):
        matrix.check_format(full_check=True)
    if matrix.format == "dia":
        whole_numbers(f"Matrix file '{path}'", "diagonals", matrix.offsets, -(2**31), 2**31)
    if matrix.dtype.kind not in "fiu" or max(matrix.shape) > 10 * max(matrix.nnz, 1):
        raise MeshError(
            f"Matrix file '{path}'",
            found=f"{matrix.shape[0]} x {matrix.shape[1]} with {matrix.nnz} entries of the kind {matrix.dtype}",
            expected="real numbers, some in every row",
            remedy="Write the file again: fem.write_matrices, or scipy.sparse.save_npz",
        )
    return sparse.csr_matrix(matrix)
