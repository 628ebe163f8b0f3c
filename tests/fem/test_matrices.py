"""Matrices of other programs: the shipped examples, round trips, checks and messages."""

import re
import shutil
import subprocess
import warnings
from pathlib import Path

import numpy as np
import pytest
from fem.beams import STEEL, straight
from scipy import sparse

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.fem import Section
from flexmb.fem.matrices.checks import wave_speed
from flexmb.fem.matrices.nastran import nastran_float
from flexmb.fem.meshes import mesh

EXAMPLES = Path(__file__).parents[2] / "meshes" / "matrices"


@pytest.fixture
def beam():
    return fem.frame(straight(3), section=Section.tube(0.04, 0.003), material=STEEL, name="beam")


@pytest.fixture
def block():
    """The block of the examples from its mesh, elements without internal modes as other programs have
    them."""
    return fem.solid(fem.read_mesh(EXAMPLES / "block.inp"), STEEL, elements={"hexahedron": fem.HEX8_COMPATIBLE})


def assert_close(found, expected, tolerance):
    assert abs(found - expected).max() <= tolerance * abs(expected).max()


def test_matrix_market_and_abaqus_are_the_same_block():
    market = fem.read_matrices(EXAMPLES / "block_K.mtx", EXAMPLES / "block.inp", mass=EXAMPLES / "block_M.mtx")
    abaqus = fem.read_matrices(EXAMPLES / "block_STIF1.mtx", EXAMPLES / "block.inp")
    expected = fem.solid(fem.read_mesh(EXAMPLES / "block.inp"), STEEL)
    for found in (market, abaqus):
        assert_close(found.K, expected.K, 1e-15)
        assert_close(found.M, expected.M, 1e-15)
        np.testing.assert_array_equal(found.nodes, expected.nodes)
        np.testing.assert_array_equal(found.node_sets["right"], [2, 5, 8, 11])


def test_nastran_punch_is_the_beam():
    """The file has ten digits and node numbers 101..104."""
    found = fem.read_matrices(EXAMPLES / "beam.pch")
    expected = fem.read_matrices(EXAMPLES / "beam.npz")
    assert_close(found.K, expected.K, 1e-9)
    assert_close(found.M, expected.M, 1e-9)
    np.testing.assert_allclose(found.nodes, expected.nodes, atol=1e-9)
    np.testing.assert_array_equal(expected.node_sets["end"], [3])


def test_nastran_small_fields_commas_and_both_triangles(tmp_path):
    """Two masses on a spring along x: k = 1e3, m = 2 and 3; the same terms in three spellings."""

    def card(*words):
        return "".join([f"{words[0]:8s}", *(f"{word!s:>8s}" for word in words[1:])]) + "\n"

    grids = "GRID,1,,0.,0.,0.\n" + card("GRID", 2, "", "1.", "0.", "0.")
    small = card("DMIG", "K2GG", 0, 6, 1, 0) + card("DMIG", "K2GG", 1, 1, "", 1, 1, "1.0+3")
    small += card("DMIG", "K2GG", 2, 1, "", 1, 1, "-1.0D+3") + card("+", 2, 1, "1000.0")
    comma = "DMIG,M2GG,0,6,1,0\nDMIG,M2GG,1,1,,1,1,2.0\nDMIG,M2GG,2,1,,2,1,3.0\n"
    (tmp_path / "pair.bdf").write_text("$ two masses\n" + grids + small + comma)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", mesh.MeshWarning)  # one direction only, slow by design
        fe = fem.read_matrices(tmp_path / "pair.bdf")
    np.testing.assert_allclose(fe.K.toarray(), [[1e3, -1e3], [-1e3, 1e3]])
    np.testing.assert_allclose(fe.M.toarray(), np.diag([2.0, 3.0]))
    np.testing.assert_array_equal(fe.dofs, [[0, 0], [1, 0]])


@pytest.mark.parametrize(
    ("word", "value"),
    [("1.0+3", 1e3), ("-1.5-2", -0.015), ("1.0D+3", 1e3), ("2.", 2.0), ("", 0.0), ("1E5", 1e5)],
)
def test_nastran_numbers(word, value):
    assert nastran_float(word) == value


def test_npz_round_trip(tmp_path, beam):
    fem.write_matrices(tmp_path / "beam.npz", beam)
    found = fem.read_matrices(tmp_path / "beam.npz")
    assert (found.K != beam.K).nnz == 0
    assert (found.M != beam.M).nnz == 0
    np.testing.assert_array_equal(found.dofs, beam.dofs)
    sparse.save_npz(tmp_path / "K.npz", beam.K)
    sparse.save_npz(tmp_path / "M.npz", beam.M)
    found = fem.read_matrices(tmp_path / "K.npz", beam.nodes, mass=tmp_path / "M.npz")
    assert (found.K != beam.K).nnz == 0


def test_calculix_matrices(ccx, tmp_path, block):
    """ccx writes K and M of the shipped block; its C3D8 with full integration is our compatible
    hexahedron."""
    shutil.copy(EXAMPLES / "block.inp", tmp_path)
    subprocess.run([ccx, "block"], cwd=tmp_path, check=True, capture_output=True, timeout=60)
    found = fem.read_matrices(tmp_path / "block.sti")
    assert_close(found.M, block.M, 1e-10)
    assert_close(found.K, block.K, 1e-10)
    np.testing.assert_array_equal(found.node_sets["left"], [0, 3, 6, 9])
    frequencies = fem.eigenmodes(found, None, 9).frequencies
    np.testing.assert_allclose(frequencies[6:], fem.eigenmodes(block, None, 9).frequencies[6:], rtol=1e-6)


def test_units_are_converted(beam):
    """The beam in N, mm, tonne, s: lengths 1e3 larger, masses 1e-3."""
    rotation = sparse.diags(np.where(beam.dofs[:, 1] >= 3, 1e3, 1.0))
    stiffness, mass = (1e-3 * rotation @ matrix @ rotation for matrix in (beam.K, beam.M))
    fe = fem.from_matrices(stiffness, mass, 1e3 * beam.nodes, beam.dofs, length_unit=1e-3, mass_unit=1e3)
    assert_close(fe.K, beam.K, 1e-14)
    assert_close(fe.M, beam.M, 1e-14)
    with pytest.warns(mesh.MeshWarning, match="mass_unit=1e3"):
        fem.from_matrices(stiffness, mass, 1e3 * beam.nodes, beam.dofs)


def test_wave_speed_is_that_of_the_material(beam):
    """sqrt(E / rho) = 5172 m/s of a bar; a solid within 25 %."""
    assert wave_speed(beam) == pytest.approx(np.sqrt(210e9 / 7850), rel=1e-6)
    assert wave_speed(fem.solid(fem.read_mesh(EXAMPLES / "block.inp"), STEEL)) == pytest.approx(5172, rel=0.25)


def test_supported_matrices_warn(beam):
    held = fem.with_spring(beam, 0, [1e9] * 6)
    with pytest.warns(mesh.MeshWarning, match="rigid motion x, y, z, about x, about y, about z costs energy"):
        taken = fem.from_matrices(held.K, held.M, held.nodes, held.dofs)
    assert abs(taken.K - held.K).max() <= 1e-12 * abs(held.K).max()  # told, not repaired


def test_only_the_held_directions_are_named(beam):
    """A spring along the beam at a node on its axis holds x and nothing else; a free beam has nothing to tell."""
    held = fem.with_spring(beam, 0, [1e9, 0, 0, 0, 0, 0])
    with pytest.warns(mesh.MeshWarning, match="rigid motion x costs energy"):
        fem.from_matrices(held.K, held.M, held.nodes, held.dofs)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fem.from_matrices(beam.K, beam.M, beam.nodes, beam.dofs)


def test_missing_freedoms_warn(beam):
    kept = np.flatnonzero((beam.dofs[:, 0] != 2) | (beam.dofs[:, 1] != 1))
    with pytest.warns(mesh.MeshWarning) as found:
        fem.from_matrices(beam.K[kept][:, kept], beam.M[kept][:, kept], beam.nodes, beam.dofs[kept])
    assert "mass along x, y, z" in str(found[-1].message)


def changed(matrix, i, j, factor):
    matrix = matrix.tolil()
    matrix[i, j] *= factor
    return matrix.tocsr()


@pytest.mark.parametrize(
    ("make", "found", "remedy"),
    [
        (lambda b: (b.K[:, :5], b.M, b.nodes), "K has the shape (24, 5)", "file"),
        (lambda b: (b.K, sparse.tril(b.M), b.nodes), "M differs from its transpose", "add the transpose"),
        (
            lambda b: (changed(b.K, 0, 6, 1.1), b.M, b.nodes),
            "K differs from its transpose",
            "follower forces",
        ),
        (lambda b: (changed(b.K, 0, 0, np.nan), b.M, b.nodes), "not finite", "again"),
        (lambda b: (changed(b.K, 4, 4, -1.0), b.M, b.nodes), "node 0, direction 4", "sign error"),
        (lambda b: (changed(b.K, 7, 7, 0.3), b.M, b.nodes), "K has negative eigenvalues", "sign error"),
        (lambda b: (b.K, changed(b.M, 7, 7, 0.01), b.nodes), "M has negative eigenvalues", "exchanged"),
        (lambda b: (b.K, 0 * b.M, b.nodes), "M is zero", "names"),
        (lambda b: (b.K, b.M, b.nodes[:3]), "24 rows and 3 nodes", "Give dofs"),
        (lambda b: (b.K, b.M, b.nodes, b.dofs[:3]), "dofs of shape (3, 2)", "direction 0..5"),
        (lambda b: (b.K, b.M, b.nodes, b.dofs + 1), "node 4, direction 6", "start at 0"),
        (lambda b: (b.K, b.M, b.nodes, b.dofs * [1, 0]), "appears in 6 rows", "order of the rows"),
    ],
)
def test_messages_of_matrices(beam, make, found, remedy):
    with pytest.raises(MeshError, match=re.escape(found)) as caught:
        fem.from_matrices(*make(beam))
    assert remedy in caught.value.remedy


@pytest.mark.parametrize(
    ("name", "text", "found", "remedy"),
    [
        ("part.xyz", "", "suffix '.xyz'", "fem.from_matrices"),
        ("part.mtx", "%%MatrixMarket matrix\n", "one Matrix-Market file", "mass="),
        ("part_STIF1.mtx", "1,1,1,1,2.0\n", "no mass matrix beside it", "mass="),
        ("part.sti", "1 1 2.0\n", "no file 'part.mas'", "MATRIXSTORAGE"),
        ("part.pch", "DMIG    KAAX           0       6       1       0\n", "the matrices KAAX", "EXTSEOUT"),
        (
            "part.pch",
            "DMIG,KAAX,0,6,3,0\nDMIG,KAAX,1,1,,1,1,2.0\nDMIG,MAAX,0,6,1,0\n",
            "IFO 6, TIN 3",
            "real",
        ),
        (
            "part.pch",
            "DMIG,KAAX,0,6,1,0\nDMIG,KAAX,1,0,,1,0,2.0\nDMIG,MAAX,0,6,1,0\n",
            "scalar points",
            "physical",
        ),
    ],
)
def test_messages_of_files(tmp_path, name, text, found, remedy):
    (tmp_path / name).write_text(text)
    with pytest.raises(MeshError, match=re.escape(found)) as caught:
        fem.read_matrices(tmp_path / name)
    assert remedy in caught.value.remedy


def write(folder, stiffness, mass="1,1,1,1,2.0\n"):
    (folder / "a_STIF1.mtx").write_text(stiffness)
    (folder / "a_MASS1.mtx").write_text(mass)
    return folder / "a_STIF1.mtx"


@pytest.mark.parametrize(
    ("stiffness", "nodes", "found", "remedy"),
    [
        ("1 1 2.0\n", None, "3 words in line 1", "FORMAT=MATRIX INPUT"),
        ("-5,1,-5,1,2.0\n", None, "node number -5", "contact"),
        ("1,7,1,7,2.0\n", None, "freedom 7 of node 1", "pressure"),
        ("1,1,1,2,2.0\n1,2,1,1,3.0\n", None, "more than once", "one triangle"),
        ("1,1,1,1,2.0\n", None, "no node positions", "nodes="),
        ("9,1,9,1,2.0\n", [[0, 0, 0]], "node 9 and 0 more have no position", "mesh file"),
        ("1,1,1,1,2.0\n", [[0, 0]], "shape (1, 2)", "positions"),
    ],
)
def test_messages_of_entries(tmp_path, stiffness, nodes, found, remedy):
    text = f"{found} {remedy}"
    with pytest.raises(MeshError) as caught:
        fem.read_matrices(write(tmp_path, stiffness), nodes)
    assert found in str(caught.value), text
    assert remedy in str(caught.value), text


def test_messages_of_missing_files(tmp_path):
    with pytest.raises(MeshError, match="no such file"):
        fem.read_matrices(tmp_path / "none.sti")
    with pytest.raises(MeshError, match="no such file"):
        fem.read_matrices(write(tmp_path, "1,1,1,1,2.0\n"), tmp_path / "none.inp")
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(MeshError, match="the arrays a"):
        fem.read_matrices(tmp_path / "other.npz")
    (tmp_path / "b.bdf").write_text("GRID,1,5,0.,0.,0.\n")
    with pytest.raises(MeshError, match="coordinate system 5"):
        fem.read_matrices(write(tmp_path, "1,1,1,1,2.0\n"), tmp_path / "b.bdf")
    (tmp_path / "c.bdf").write_text("$ nothing\n")
    with pytest.raises(MeshError, match="no nodes"):
        fem.read_matrices(write(tmp_path, "1,1,1,1,2.0\n"), tmp_path / "c.bdf")
    for suffix, text in (("sti", "3 3 1.0\n"), ("mas", "1 1 1.0\n"), ("dof", "1.1\n")):
        (tmp_path / f"job.{suffix}").write_text(text)
    with pytest.raises(MeshError, match="rows up to 3"):
        fem.read_matrices(tmp_path / "job.sti")


@pytest.mark.parametrize("half", [True, False])
def test_abaqus_coordinate_format(tmp_path, half):
    """Rows and columns only: the freedoms of the nodes by increasing number; one triangle or both."""
    expected = fem.read_matrices(EXAMPLES / "block_STIF1.mtx", EXAMPLES / "block.inp")
    for word, matrix in (("STIF", expected.K), ("MASS", expected.M)):
        entries = (sparse.tril(matrix) if half else matrix).tocoo()
        lines = [f"{i + 1} {j + 1} {value:.17E}" for i, j, value in zip(entries.row, entries.col, entries.data)]
        (tmp_path / f"block_{word}1.mtx").write_text("\n".join(lines) + "\n")
    found = fem.read_matrices(tmp_path / "block_STIF1.mtx", EXAMPLES / "block.inp")
    assert_close(found.K, expected.K, 1e-15)
    assert_close(found.M, expected.M, 1e-15)
    np.testing.assert_array_equal(found.nodes, expected.nodes)


def test_a_damaged_mass_file_is_blamed_itself(tmp_path, block):
    """By every reader of two files: the stiffness is whole."""
    text = "%%MatrixMarket matrix coordinate real symmetric\n3 3 3\n1 1 1.0\n2 2 1.0\n3 3 1.0\n"
    (tmp_path / "K.mtx").write_text(text)
    (tmp_path / "M.mtx").write_text(text.replace("2 2 1.0", "2 2 1.0.0"))
    sparse.save_npz(tmp_path / "K.npz", sparse.identity(3, format="csr"))
    (tmp_path / "M.npz").write_bytes((tmp_path / "K.npz").read_bytes()[:100])
    write(tmp_path, "1,1,1,1,2.0\n", "1,1,1,1,2.0x\n")
    for suffix, entries in (("sti", "1 1 1.0\n"), ("mas", "1 1 one\n"), ("dof", "1.1\n"), ("inp", "")):
        (tmp_path / f"job.{suffix}").write_text(entries)
    for stiffness, mass in (
        ("K.mtx", "M.mtx"),
        ("K.npz", "M.npz"),
        ("a_STIF1.mtx", "a_MASS1.mtx"),
        ("job.sti", "job.mas"),
    ):
        with pytest.raises(MeshError) as caught:
            fem.read_matrices(tmp_path / stiffness, [[0, 0, 0]], mass=tmp_path / mass)
        assert f"{mass}'" in caught.value.part
        assert stiffness not in str(caught.value)
