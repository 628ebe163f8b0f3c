"""Matrices of Nastran's OUTPUT4 files, written by pyYeti."""

import numpy as np
import pytest

from flexmb import Material, fem
from flexmb.errors import MeshError

GRIDS = "".join(f"GRID,{10 * k},,{0.1 * (k - 1):.3f},0.,0.\n" for k in (1, 2, 3, 4))


def written(tmp_path, **matrices):
    with np.printoptions():  # pyYeti changes how all arrays are printed
        op4 = pytest.importorskip("pyyeti.nastran.op4")
    path = tmp_path / "part.op4"
    op4.write(str(path), matrices)
    (tmp_path / "part.bdf").write_text(f"BEGIN BULK\n{GRIDS}ENDDATA\n")
    return path


def chain():
    """Return K and M (24, 24) of a free Euler-Bernoulli beam of three elements with lumped masses."""
    section = fem.Section.rectangle(0.02, 0.03)
    points = np.array([[0.1 * k, 0.0, 0.0] for k in range(4)])
    fe = fem.frame(points=points, section=section, material=Material(young=210e9, poisson=0.3, density=7850.0))
    order = np.lexsort((fe.dofs[:, 1], fe.dofs[:, 0]))
    return (
        fe.K.toarray()[np.ix_(order, order)],
        fe.M.toarray()[np.ix_(order, order)],
        fem.eigenmodes(fe, n=9).frequencies,
    )


def test_stiffness_and_mass_of_all_grid_points(tmp_path):
    K, M, frequencies = chain()
    path = written(tmp_path, KGG=K, MGG=M)
    fe = fem.read_matrices(path, tmp_path / "part.bdf")
    np.testing.assert_allclose(fe.K.toarray(), K, rtol=1e-12, atol=1e-9 * abs(K).max())
    np.testing.assert_allclose(fem.eigenmodes(fe, n=9).frequencies[6:], frequencies[6:], rtol=1e-7)


def test_what_is_missing_or_cut_is_named(tmp_path):
    K, M, _ = chain()
    path = written(tmp_path, KGG=K)
    with pytest.raises(MeshError, match=r"matrices KGG.*MGG"):
        fem.read_matrices(path, tmp_path / "part.bdf")
    path = written(tmp_path, KGG=K[:18, :18], MGG=M[:18, :18])
    with pytest.raises(MeshError, match="18 rows and 4 nodes"):
        fem.read_matrices(path, tmp_path / "part.bdf")
    path = written(tmp_path, KGG=K, MGG=M)
    path.write_bytes(path.read_bytes()[:700])
    with pytest.raises(MeshError, match=r"part\.op4"):
        fem.read_matrices(path, tmp_path / "part.bdf")
