"""Matrices of Nastran's OUTPUT2 files."""

from pathlib import Path

import numpy as np
import pytest
from fem.output2_file import matrix, output2, table
from fem.test_matrices_op4 import GRIDS, chain

from flexmb import fem
from flexmb.errors import MeshError

with np.printoptions():  # pyYeti changes how all arrays are printed
    op2 = pytest.importorskip("pyyeti.nastran.op2")


def written(tmp_path, *blocks):
    path = tmp_path / "part.op2"
    path.write_bytes(output2(*blocks))
    (tmp_path / "part.bdf").write_text(f"BEGIN BULK\n{GRIDS}ENDDATA\n")
    return path


def test_the_writer_of_these_tests_writes_what_nastran_writes():
    """The generalized stiffness in a file of NX Nastran 9.1, written again byte for byte."""
    path = Path(op2.__file__).parents[1] / "tests/nas2cam_csuper/assemble.op2"
    if not path.is_file():
        pytest.skip("this release of pyYeti comes without its files of Nastran")
    with op2.OP2(str(path)) as file:
        block = next(block for block in file.dblist if block.name == "KHH")
        values = file.rdop2mats(["KHH"])["KHH"]
    own = matrix("KHH", values, block.trailer, b"K1SHH   " + 2 * (170).to_bytes(4, "little"))
    assert own == path.read_bytes()[block.start : block.stop]
    with pytest.raises(MeshError, match=r"matrices KHH.*KAAX"):
        fem.read_matrices(path)


def test_stiffness_and_mass_of_all_grid_points(tmp_path):
    K, M, frequencies = chain()
    fe = fem.read_matrices(
        written(tmp_path, table("GEOM1S"), matrix("KGG", K), matrix("PG", K[:, :1]), matrix("MGG", M)),
        tmp_path / "part.bdf",
    )
    np.testing.assert_allclose(fe.K.toarray(), K, rtol=1e-12, atol=1e-9 * abs(K).max())
    np.testing.assert_allclose(fem.eigenmodes(fe, n=9).frequencies[6:], frequencies[6:], rtol=1e-7)


def test_mass_in_a_file_of_its_own(tmp_path):
    K, M, _ = chain()
    path = written(tmp_path, matrix("KGG", K))
    (tmp_path / "mass.op2").write_bytes(output2(matrix("MGG", M)))
    fe = fem.read_matrices(path, tmp_path / "part.bdf", mass=tmp_path / "mass.op2")
    np.testing.assert_allclose(fe.M.toarray(), M, rtol=1e-12, atol=1e-12 * abs(M).max())


def test_files_without_matrices_and_with_several_of_a_name(tmp_path):
    K, M, _ = chain()
    with pytest.raises(MeshError, match=r"no matrices, only tables: GEOM1S, OUGV1.*OUTPUT2 KGG,MGG"):
        fem.read_matrices(written(tmp_path, table("GEOM1S"), table("OUGV1")), tmp_path / "part.bdf")
    with pytest.raises(MeshError, match="2 matrices named KAAX"):
        fem.read_matrices(
            written(tmp_path, matrix("KAAX", K), matrix("KAAX", 2 * K), matrix("MAAX", M)), tmp_path / "part.bdf"
        )
    large = (101, 40_000, 40_000, 6, 2, 2, 0)
    with pytest.raises(MeshError, match=r"KGG with 40000 rows.*OUTPUT4"):
        fem.read_matrices(written(tmp_path, matrix("KGG", K, large), matrix("MGG", M)), tmp_path / "part.bdf")


def test_damaged_files_are_named(tmp_path):
    K, M, _ = chain()
    path = written(tmp_path, matrix("KGG", K), matrix("MGG", M))
    whole = path.read_bytes()
    for length in (0, 3, 50, 700, len(whole) // 2, len(whole) - 200):
        path.write_bytes(whole[:length])
        with pytest.raises(MeshError, match=r"part\.op2"):
            fem.read_matrices(path, tmp_path / "part.bdf")


def test_lengths_that_do_not_fit_are_found_before_the_reading(tmp_path):
    """A record that claims another length leads a reader astray, without end in some cases."""
    K, M, _ = chain()
    path = written(tmp_path, matrix("KGG", K), matrix("MGG", M))
    whole = bytearray(path.read_bytes())
    whole[92:96] = (-64).to_bytes(4, "little", signed=True)
    path.write_bytes(whole)
    with pytest.raises(MeshError, match="a record at byte 92 of"):
        fem.read_matrices(path, tmp_path / "part.bdf")
