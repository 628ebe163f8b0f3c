"""The data file: nothing is lost on the way, and a wrong file says what is wrong with it."""

import dataclasses
import warnings

import h5py
import numpy as np
import pytest

from flexmb import hdf5
from flexmb.errors import DataFileError, ValidityWarning
from flexmb.model.modal_arrays import GeometricStiffness, InertiaInvariants
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.modal_neutral_file import SCHEMA, VERSION


def arbitrary_data(rotations: bool = True) -> ModalNeutralData:
    rng = np.random.default_rng(7)
    n, m, k = 5, 3, 2
    invariants = InertiaInvariants(
        vv=np.eye(3),
        vw0=rng.random((3, 3)),
        vw1=rng.random((m, 3, 3)),
        vn=rng.random((3, m)),
        ww0=rng.random((3, 3)),
        ww1=rng.random((m, 3, 3)),
        ww2=rng.random((m, m, 3, 3)),
        wn0=rng.random((3, m)),
        wn1=rng.random((m, 3, m)),
        nn=np.eye(m),
    )
    geometric = GeometricStiffness(
        inertia=rng.random((12, m, m)),
        interface=rng.random((1, 6, m, m)),
        loads=rng.random((1, m, m)),
        preload=rng.random((m, m)),
    )
    return ModalNeutralData(
        name="rod",
        nodes=rng.random((n, 3)),
        cells=(("tetra", np.array([[0, 1, 2, 3]])), ("line", np.array([[3, 4]]))),
        shapes=rng.random((n, 3, m)),
        rotation_shapes=rng.random((n, 3, m)) if rotations else None,
        marker_names=("a", "tip"),
        n_interfaces=1,
        marker_positions=rng.random((k, 3)),
        marker_translations=rng.random((k, 3, m)),
        marker_rotations=rng.random((k, 3, m)),
        stiffness=np.eye(m),
        damping_ratios=np.full(m, 0.01),
        frequencies=np.arange(1.0, 4.0),
        invariants=invariants,
        geometric=geometric if rotations else None,
        load_names=("air",),
        load_shapes=rng.random((1, 6 + m)),
        load_turning=rng.random((1, 6 + m, m)) if rotations else None,
        preload_turning=rng.random((6 + m, m)) if rotations else None,
        stress_modes=rng.random((n, 6, m)) if rotations else None,
        frame="a",
        quality={"modes": [1, 2], "text": "fine", "number": np.float64(0.5)},
    )


def assert_same(a, b):
    if dataclasses.is_dataclass(a):
        for field in dataclasses.fields(a):
            assert_same(getattr(a, field.name), getattr(b, field.name))
    elif isinstance(a, tuple):
        assert len(a) == len(b)
        for x, y in zip(a, b, strict=True):
            assert_same(x, y)
    elif isinstance(a, np.ndarray):
        assert a.shape == b.shape
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    else:
        assert a == b


@pytest.mark.parametrize("full", [True, False])
def test_every_field_survives_the_file(tmp_path, full):
    data = arbitrary_data(full)
    assert data.save(tmp_path / "rod.h5") == tmp_path / "rod.h5"
    assert_same(data, ModalNeutralData.load(tmp_path / "rod.h5"))


def test_missing_file_names_the_neighbours(tmp_path):
    arbitrary_data().save(tmp_path / "conrod.h5")
    with pytest.raises(DataFileError, match=r"does not exist.*kind 'flexmb.modal_neutral_data'.*conrod\.h5"):
        ModalNeutralData.load(tmp_path / "conrood.h5")


def test_missing_folder(tmp_path):
    with pytest.raises(DataFileError, match=r"folder '.*runs' does not exist"):
        arbitrary_data().save(tmp_path / "runs" / "x.h5")
    with pytest.raises(DataFileError, match=r"does not exist"):
        ModalNeutralData.load(tmp_path / "runs" / "x.h5")


def test_not_hdf5(tmp_path):
    path = tmp_path / "x.h5"
    path.write_text("$MeshFormat")
    with pytest.raises(DataFileError, match=r"not an HDF5 file.*MeshFo"):
        ModalNeutralData.load(path)


def test_truncated(tmp_path):
    path = arbitrary_data().save(tmp_path / "x.h5")
    content = path.read_bytes()
    path.write_bytes(content[: content.index(b"FLEXSEAL") // 2])
    with pytest.raises(DataFileError, match=r"truncated or damaged.*Write or copy it again"):
        ModalNeutralData.load(path)


def test_missing_dataset_counts_as_damage(tmp_path):
    path = arbitrary_data().save(tmp_path / "x.h5")
    with h5py.File(path, "a") as file:
        del file["shapes"]
    with pytest.raises(DataFileError, match=r"damaged.*shapes"):
        ModalNeutralData.load(path)


def test_foreign_schema(tmp_path):
    with hdf5.writing(tmp_path / "x.h5", schema="flexmb.solution", version=1):
        pass
    with pytest.raises(DataFileError, match=r"schema 'flexmb.solution'.*schema 'flexmb.modal_neutral_data'"):
        ModalNeutralData.load(tmp_path / "x.h5")
    with hdf5.writing(tmp_path / "y.h5"):
        pass
    with pytest.raises(DataFileError, match="no schema attribute"):
        ModalNeutralData.load(tmp_path / "y.h5")


@pytest.mark.parametrize(("version", "remedy"), [(VERSION + 1, "Update flexmb"), (VERSION - 1, "Make the file again")])
def test_other_version(tmp_path, version, remedy):
    with hdf5.writing(tmp_path / "x.h5", schema=SCHEMA, version=version):
        pass
    with pytest.raises(DataFileError, match=rf"schema version {version} .*version {VERSION}.*{remedy}"):
        ModalNeutralData.load(tmp_path / "x.h5")


def write_half_a_file(path):
    with hdf5.writing(path, schema=SCHEMA, version=VERSION) as file:
        file["nodes"] = np.zeros(3)
        raise KeyboardInterrupt


def test_interrupted_writing_keeps_the_old_file(tmp_path):
    path = arbitrary_data().save(tmp_path / "x.h5")
    before = path.read_bytes()
    with pytest.raises(KeyboardInterrupt):
        write_half_a_file(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["x.h5"]


def test_loads_that_an_old_file_cannot_turn_are_told(tmp_path):
    """By name, with what to do; a body with all terms, or without loads, says nothing."""
    full = arbitrary_data()
    for change, named in (
        ({"load_turning": None}, repr(full.load_names[0])),
        ({"preload_turning": None}, "its preload"),
    ):
        path = dataclasses.replace(full, **change).save(tmp_path / "old.h5")
        with pytest.warns(ValidityWarning, match=rf"Reduced body .*old.h5.*{named}.*[Rr]educe it again"):
            ModalNeutralData.load(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error", ValidityWarning)
        ModalNeutralData.load(full.save(tmp_path / "new.h5"))


@pytest.mark.parametrize("loads", [1, 0])
def test_a_body_of_the_former_sign_of_pressure_is_told(tmp_path, loads):
    """Its load shapes pulled outwards: the file cannot say which, so nothing is turned, and nothing is silent."""
    data = arbitrary_data()
    if not loads:
        bare = dataclasses.replace(data.geometric, loads=data.geometric.loads[:0])
        cut = {"load_shapes": data.load_shapes[:0], "load_turning": data.load_turning[:0]}
        data = dataclasses.replace(data, load_names=(), geometric=bare, **cut)
    path, plain = data.save(tmp_path / "new.h5"), tmp_path / "old.h5"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ModalNeutralData.load(path)
    with h5py.File(path) as file, h5py.File(plain, "w") as old:
        for name in file:
            file.copy(name, old)
        old.attrs.update({key: value for key, value in file.attrs.items() if key != "pressure"})
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        again = ModalNeutralData.load(plain)
    assert ["a unit pressure on a surface pulled outwards" in str(w.message) for w in told] == [True] * loads
    np.testing.assert_array_equal(again.load_shapes, data.load_shapes)
