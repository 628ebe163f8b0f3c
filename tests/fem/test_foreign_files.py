"""Matrices of other programs: read like scipy reads them, and refused by name where scipy's reader ends the process."""

import numpy as np
import pytest
from scipy import io as scipy_io
from scipy import sparse

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.fem.foreign_files import read_market


@pytest.mark.parametrize("form", ["sparse", "sparse symmetric", "dense", "dense symmetric"])
def test_market_as_scipy_writes_it(form, rng, tmp_path):
    full = rng.normal(size=(6, 6))
    full = full + full.T if "symmetric" in form else full
    full[np.abs(full) < 0.2] = 0.0
    matrix = sparse.coo_matrix(full) if "sparse" in form else full
    scipy_io.mmwrite(
        tmp_path / "x.mtx", matrix, symmetry="symmetric" if "symmetric" in form else "general", precision=17
    )
    np.testing.assert_array_equal(read_market(tmp_path / "x.mtx").toarray(), full)


HEAD = b"%%MatrixMarket matrix coordinate real symmetric\n% made by hand\n\n"


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (HEAD + b"2 2 3\n1 1 1.0\n2 1 \n2 2 1.0\n", "8 numbers. Expected: 9, as the sizes say"),
        (HEAD + b"2 2 3\n1 1 1.0\n2 1\0 4.0\n2 2 1.0\n", r"the characters b'\\x00' among the numbers"),
        (HEAD + b"3000000000 3000000000 3\n1 1 1.0\n2 1 4.0\n2 2 1.0\n", "3000000000 x 3000000000 with 3 entries"),
        (HEAD + b"2 2 900000000000\n1 1 1.0\n2 1 4.0\n2 2 1.0\n", "bytes of entries. Expected: 2700000000000 numbers"),
        (HEAD + b"2 2 3\n1 1 1.0\n3 1 4.0\n2 2 1.0\n", "the row 3. Expected: whole numbers from 1 to 2"),
        (HEAD + b"2 2 3\n1 1 1.0\n2 1.5 4.0\n2 2 1.0\n", "the column 1.5. Expected: whole numbers from 1 to 2"),
        (HEAD + b"2 2 3\n1 1 1.0\n2 1 4.0.0\n2 2 1.0\n", "the file cannot be read"),
        (HEAD + b"2 3 3\n1 1 1.0\n2 1 4.0\n2 2 1.0\n", "the sizes '2 3 3'"),
        (HEAD.replace(b"real", b"complex"), "the header .* Expected: %%MatrixMarket matrix, coordinate or array, real"),
    ],
)
def test_damaged_market(content, match, tmp_path):
    (tmp_path / "K.mtx").write_bytes(content)
    with pytest.raises(MeshError, match=match):
        fem.read_matrices(tmp_path / "K.mtx", np.zeros((1, 3)), mass=tmp_path / "K.mtx")


def test_indices_outside_of_a_stored_matrix(tmp_path):
    """scipy multiplies with indices that point outside of its arrays: the process ends."""
    K = sparse.csr_matrix(np.eye(3))
    arrays = {f"{s}_{n}": getattr(K, n) for s in "KM" for n in ("data", "indices", "indptr")}
    arrays |= {"nodes": np.zeros((1, 3)), "dofs": np.array([[0, 0], [0, 1], [0, 2]])}
    np.savez(tmp_path / "a.npz", **{**arrays, "K_indices": np.array([0, 1, 2_000_000_000])})
    with pytest.raises(
        MeshError, match=r"Matrix file '.*a\.npz': (the file cannot be read|2000000001 x|3 x 2000000001)"
    ):
        fem.read_matrices(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", **{**arrays, "dofs": np.zeros(3)})
    with pytest.raises(MeshError, match=r"dofs of the shape \(3,\)\. Expected: \(n, 3\) and \(3, 2\)"):
        fem.read_matrices(tmp_path / "b.npz")


def test_node_numbers_that_are_none(tmp_path):
    (tmp_path / "a_STIF1.mtx").write_text("nan,1,1,1,2.0\n")
    (tmp_path / "a_MASS1.mtx").write_text("1,1,1,1,2.0\n")
    with pytest.raises(MeshError, match=r"the node number nan\. Expected: whole numbers"):
        fem.read_matrices(tmp_path / "a_STIF1.mtx", np.zeros((1, 3)))


def test_coordinates_beyond_all_measure(tmp_path):
    path = tmp_path / "far.bdf"
    path.write_text("GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1e308\nCTETRA,1,1,1,2,3,4\n")
    with pytest.raises(MeshError, match=r"node 3 is at \[0.0, 0.0, 1e\+308\] m. Expected: coordinates up to 1e\+30 m"):
        fem.read_mesh(path)


def test_nodes_of_matrices_in_a_damaged_mesh(tmp_path):
    K = tmp_path / "a_STIF1.mtx"
    for name in ("a_STIF1.mtx", "a_MASS1.mtx"):
        (tmp_path / name).write_text("1,1,1,1,2.0\n")
    (tmp_path / "a.inp").write_text("*NODE\n1, 0.0, x, 0.0\n")
    with pytest.raises(MeshError, match=r"Mesh file '.*a\.inp': the file cannot be read \(could not convert"):
        fem.read_matrices(K, tmp_path / "a.inp")
