"""A changed, cut or hostile data file is refused: by its seal, by a child process, or by what its arrays hold."""

import h5py
import numpy as np
import pytest
from model.test_modal_neutral_file import arbitrary_data

from flexmb import hdf5, hdf5_seal
from flexmb.errors import DataFileError, ModelError
from flexmb.model.modal_neutral_data import ModalNeutralData


@pytest.fixture
def path(tmp_path):
    return arbitrary_data().save(tmp_path / "rod.h5")


def reopened(path):
    """Open a file to change it: HDF5 cuts the seal away, as of an older file."""
    return h5py.File(path, "r+")


def test_every_file_is_sealed(path, monkeypatch):
    assert hdf5_seal.state_of(path) == hdf5_seal.WHOLE
    monkeypatch.setattr(hdf5, "probe", lambda path: pytest.fail("an undamaged file is read directly"))
    assert ModalNeutralData.load(path).name == "rod"


def same(one, other):
    """Is everything in two bodies equal?"""
    return all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("shapes", "nodes", "stiffness", "stress_modes")
    ) and (one.marker_names == other.marker_names and one.quality == other.quality)


@pytest.mark.filterwarnings("ignore:.*restored from its parity")
def test_any_changed_byte_is_noticed_and_restored(path):
    """Of every kind of place in the file, 60 places in all; in the seal and the parity it changes nothing."""
    content, data = path.read_bytes(), ModalNeutralData.load(path)
    length = content.index(b"FLEXSEAL")
    for place in np.linspace(0, len(content) - 1, 60).astype(int):
        path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
        assert hdf5_seal.state_of(path) != hdf5_seal.WHOLE or place >= length
        assert same(ModalNeutralData.load(path), data), place
    path.write_bytes(content.replace(b"fine", b"file"))
    with pytest.warns(UserWarning, match=r"among bytes .*all of it was restored from its parity"):
        assert ModalNeutralData.load(path).quality == data.quality


def test_a_stretch_that_the_parity_covers(path):
    """A sector of zeros anywhere, also over the beginning, is restored; of more, the arrays are named."""
    content, data = path.read_bytes(), ModalNeutralData.load(path)
    length = content.index(b"FLEXSEAL")
    for place in range(0, length, 1000):
        path.write_bytes((content[:place] + bytes(4096) + content[place + 4096 :])[:length] + content[length:])
        with pytest.warns(UserWarning, match="all of it was restored"):
            assert same(ModalNeutralData.load(path), data), place
    path.write_bytes(content[:512] + bytes(length - 1024) + content[length - 512 :])
    with pytest.raises(DataFileError, match=r"the file is damaged: lost are .*stress_modes rows 0 to 4"):
        ModalNeutralData.load(path)


def test_a_file_that_may_not_be_read(path, monkeypatch):
    """It is not called damaged; permissions mean nothing to root, so that opening fails is made here."""

    def refuse(self, *how, **more):
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr("pathlib.Path.open", refuse)
    with pytest.raises(DataFileError, match=r"it may not be read \(Permission denied\)"):
        ModalNeutralData.load(path)


def test_without_its_parity_a_changed_byte_is_refused(path):
    """As in files of former times: nobody can say what was there."""
    content = path.read_bytes()
    path.write_bytes(content[: content.index(b"FLEXPRTY")].replace(b"fine", b"file"))
    with pytest.raises(DataFileError, match="its checksum does not match its content"):
        ModalNeutralData.load(path)


def test_records_behind_the_seal_belong_to_others(path):
    end = hdf5.end_of(path)
    path.write_bytes(path.read_bytes() + b"records")
    assert hdf5.end_of(path) == end == path.stat().st_size - 7
    assert hdf5_seal.state_of(path) == hdf5_seal.WHOLE


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda f: f["shapes"].__setitem__((0, 0, 0), np.nan), r"shapes\[0, 0, 0\] is nan. Expected: finite numbers"),
        (lambda f: f["shapes"].__setitem__((0, 0, 0), 1e200), "shapes holds 1e\\+200. Expected: numbers up to 1e\\+60"),
        (lambda f: f["cells/0"].__setitem__((0, 0), 77), "tetra cells name the node 77. Expected: nodes 0 to 4"),
        (lambda f: f["cells/0"].__setitem__((0, 0), -1), "tetra cells name the node -1"),
        (lambda f: f["invariants/nn"].__setitem__((0, 0), 0.0), "mode 1 has the modal mass 0 kg"),
        (lambda f: f["invariants/vv"].__setitem__(slice(None), 0.0), "a mass of 0 kg"),
        (lambda f: f.attrs.__setitem__("marker_names", '["a", "a"]'), r"two of the name 'a' \(marker\)"),
        (lambda f: f.attrs.__setitem__("marker_names", "[1, 2]"), "names or numbers of another type"),
        (lambda f: f.attrs.__setitem__("n_interfaces", "7"), "7 interfaces. Expected: 0 to 2"),
        (lambda f: f.attrs.__setitem__("quality", '{"a": '), "truncated or damaged"),
        (lambda f: f.attrs.__setitem__("schema_version", "two"), "truncated or damaged"),
    ],
)
def test_content_that_is_no_body(path, change, match):
    with reopened(path) as file:
        change(file)
    with pytest.raises((DataFileError, ModelError), match=match):
        ModalNeutralData.load(path)


def test_shapes_that_do_not_fit(path):
    with reopened(path) as file:
        del file["invariants/ww2"]
        file["invariants/ww2"] = np.zeros((3, 3, 3, 2))
    with pytest.raises(ModelError, match=r"invariants\.ww2 has the shape \(3, 3, 3, 2\)\. Expected: \(3, 3, 3, 3\)"):
        ModalNeutralData.load(path)


def test_a_small_file_that_asks_for_much_memory(path):
    with reopened(path) as file:
        file.create_dataset("more", shape=(3_000_000_000,), dtype=float, chunks=(1000,))
    with pytest.raises(DataFileError, match=r"the datasets up to 'more' \(3000000000,\) have 2\.4e\+10 bytes"):
        ModalNeutralData.load(path)


def test_links_to_other_files(path, tmp_path):
    with reopened(path) as file:
        del file["nodes"]
        file["nodes"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "/nodes")
    with pytest.raises(DataFileError, match="'nodes' is a link to another place"):
        ModalNeutralData.load(path)


def test_what_the_library_does_not_survive(path, monkeypatch, tmp_path):
    """The child may crash or not end: the message says so, and this process goes on."""
    with reopened(path) as file:
        del file.attrs["quality"]
    script = tmp_path / "hdf5_probe.py"
    monkeypatch.setattr(hdf5_seal, "__file__", str(tmp_path / "hdf5_seal.py"))
    script.write_text("import os\nos.abort()")
    with pytest.raises(DataFileError, match="the HDF5 library cannot read it without crashing"):
        ModalNeutralData.load(path)
    script.write_text("while True: pass")
    monkeypatch.setattr(hdf5_seal, "PATIENCE", 0.3)
    with pytest.raises(DataFileError, match="does not come to its end within 0 s"):
        ModalNeutralData.load(path)


def test_a_report_that_cannot_be_told(path):
    data = ModalNeutralData.load(path)
    with pytest.raises(DataFileError, match="a quality report that cannot be printed"):
        data.report()
    with pytest.raises(ModelError, match=r"a quality report of other modes\. Expected: a row for each of the 3 modes"):
        data.selected(3)
