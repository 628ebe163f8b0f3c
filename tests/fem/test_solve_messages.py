"""Statics, eigenmodes, buckling and given matrices: what does not fit is refused before any computing."""

from dataclasses import replace

import numpy as np
import pytest
from fem.beams import STEEL, plate, straight
from reduction.solids import block
from scipy import sparse

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.fem.matrices.read_matrices import read_matrices

TUBE = fem.Section.tube(0.05, 0.002)


@pytest.fixture(scope="module")
def beam():
    return fem.frame(straight(3), section=TUBE, material=STEEL)


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (
            lambda fe: fem.static(fe, np.zeros(4), "start"),
            r"a load of the shape \(4,\).*Expected: finite numbers, \(24,\)",
        ),
        (lambda fe: fem.static(fe, np.full(24, np.nan), "start"), r"a load that is not finite"),
        (lambda fe: fem.buckling(fe, np.zeros(24), "start"), r"a load that is zero at all free freedoms"),
        (
            lambda fe: fem.buckling(fe, np.eye(24)[0], "start"),
            r"zero at all free freedoms.*Load nodes that are not held",
        ),
        (lambda fe: fem.buckling(fe, np.ones((24, 2)), "start"), r"a load of several columns"),
        (lambda fe: fem.buckling(fe, np.ones(24), "start", 18), r"18 buckling modes asked for\. Expected: 1 to 17"),
        (lambda fe: fem.eigenmodes(fe, "start", 19), r"19 eigenmodes asked for\. Expected: 1 to 18"),
        (lambda fe: fem.eigenmodes(fe, "start", 0), r"0 eigenmodes asked for"),
    ],
)
def test_loads_and_counts(beam, act, message):
    with pytest.raises(MeshError, match=message):
        act(beam)


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (
            lambda: fem.frame([(0, 0, 0), (np.nan, 0, 0)], section=TUBE, material=STEEL),
            r"point 1 is at \[nan, 0\.0, 0\.0\]",
        ),
        (lambda: fem.shell(plate(1, 1, 1.0, 1.0, "quad"), "steel", 0.01), r"material: the text 'steel'"),
        (lambda: fem.shell(plate(1, 1, 1.0, 1.0, "quad"), STEEL, "thin"), r"the thickness 'thin'.*a number, m"),
        (lambda: fem.shell(plate(1, 1, 1.0, 1.0, "quad"), STEEL, {"skin": None}), r"the thickness None"),
    ],
)
def test_models_that_cannot_be(act, message):
    with pytest.raises(MeshError, match=message):
        act()


def test_traction_of_another_shape():
    with pytest.raises(MeshError, match=r"the traction \(1, 0\).*three numbers, Pa"):
        fem.traction_load(block(divisions=(1, 1, 1)), "top", (1, 0))


@pytest.mark.parametrize("name", ["K.mat", "none/K.npz"])
def test_matrices_are_written_as_npz(beam, tmp_path, name):
    with pytest.raises(MeshError, match=r"a file \.npz in an existing folder"):
        fem.write_matrices(tmp_path / name, beam)


def test_all_modes_of_a_small_model(beam):
    assert len(fem.eigenmodes(beam, "start", 18).frequencies) == 18


@pytest.mark.parametrize(
    ("K", "M", "nodes", "message"),
    [
        (np.eye(6), np.eye(3), np.eye(2, 3), r"K has the shape \(6, 6\), M \(3, 3\).*same freedoms"),
        (np.eye(6), np.eye(6), np.full((2, 3), np.nan), r"node 0 is at \[nan, nan, nan\].*finite coordinates"),
        (np.eye(6), np.eye(6), np.zeros((2, 2)), r"nodes have the shape \(2, 2\)"),
        ((1.0 + 1.0j) * np.eye(6), np.eye(6), np.eye(2, 3), r"K is complex.*structural damping"),
        (np.eye(6), sparse.csr_matrix(np.eye(6) * 1j), np.eye(2, 3), r"M is complex"),
    ],
)
def test_given_matrices(K, M, nodes, message):
    with pytest.raises(MeshError, match=message):
        fem.from_matrices(K, M, nodes)


def test_matrix_files_that_are_cut_or_missing(beam, tmp_path):
    from scipy.io import mmwrite

    for symbol in "KM":
        mmwrite(tmp_path / f"{symbol}.mtx", getattr(beam, symbol), symmetry="symmetric")
    with pytest.raises(MeshError, match=r"Mass file .*none\.mtx'.*no such file"):
        read_matrices(tmp_path / "K.mtx", mass=tmp_path / "none.mtx", nodes=beam.nodes)
    text = (tmp_path / "K.mtx").read_text()
    (tmp_path / "K.mtx").write_text(text[: len(text) // 2])
    with pytest.raises(MeshError, match=r"K\.mtx'.* numbers\. Expected: .* as the sizes say.*export it again"):
        read_matrices(tmp_path / "K.mtx", mass=tmp_path / "M.mtx", nodes=beam.nodes)
    (tmp_path / "part.npz").write_bytes(b"PK\x03\x04 nothing")
    with pytest.raises(MeshError, match=r"part\.npz'.*cannot be read"):
        read_matrices(tmp_path / "part.npz")


def test_supports_in_one_notation(beam):
    """Text and numbers mean the same to fixed= and to with_supports; nonsense is refused by both."""
    held = [fem.eigenmodes(beam, fixed={"start": how}, n=9).frequencies for how in ("xyzrxryrz", range(6))]
    held += [
        fem.eigenmodes(fem.with_supports(beam, "start", how), n=9).frequencies for how in ("x y z rx ry rz", range(6))
    ]
    for frequencies in held[1:]:
        np.testing.assert_allclose(frequencies, held[0], rtol=1e-6)
    for wrong, words in (
        ("xq", "letters out of x y z"),
        ((0, 6), r"numbers 0\.\.5"),
        ("", "letters"),
        ((), r"numbers 0\.\.5"),
        (3.5, r"numbers 0\.\.5"),
    ):
        for call in (fem.with_supports, lambda fe, name, how: fem.eigenmodes(fe, fixed={name: how}, n=1)):
            with pytest.raises(MeshError, match=words):
                call(beam, "start", wrong)


@pytest.mark.parametrize("kind", ["lil", "dok", "coo", "csc", "dense"])
def test_matrices_of_any_format(beam, kind):
    """Kept as csr: the same frequencies, and the same message about an entry that is no number."""
    K = beam.K.toarray() if kind == "dense" else beam.K.asformat(kind)
    frequencies = fem.eigenmodes(replace(beam, K=K, blocks=()), n=9).frequencies
    np.testing.assert_allclose(frequencies[6:], fem.eigenmodes(beam, n=9).frequencies[6:], rtol=1e-9)
    K = beam.K.tolil()
    K[3, 3] = np.nan
    with pytest.raises(MeshError, match="a stiffness of nan at node 0"):
        replace(beam, K=K.toarray() if kind == "dense" else K.asformat(kind), blocks=())
