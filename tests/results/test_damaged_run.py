"""A finished solution file of which bytes are changed: restored, or read up to the damage, which is named."""

import h5py
import numpy as np
import pytest

import flexmb as fmb
from flexmb import hdf5, hdf5_parity
from flexmb.errors import DataFileError

LINE = {"samples": 2001, "integrator": fmb.GeneralizedAlpha(step=1e-3)}


def model():
    return fmb.Model(
        name="drop",
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.PointMass("stone", mass=2.0)],
        sensors=[fmb.Position("place", marker="stone.center")],
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A run of 2001 samples, as bytes."""
    path = tmp_path_factory.mktemp("run") / "solution.h5"
    fmb.simulate(model(), 2.0, **LINE, output=path, write_model=fmb.model_text)
    return path.read_bytes()


def load(path):
    return fmb.Solution.load(path, read_model=fmb.read_model_text)


@pytest.fixture
def place_of_q(whole, tmp_path):
    """First byte and number of bytes of the coordinates in the file, and bytes of one sample."""
    (tmp_path / "look.h5").write_bytes(whole)
    with h5py.File(tmp_path / "look.h5", "r") as file:
        q = file["phases/0/q"]
        return q.id.get_offset(), q.nbytes, q.nbytes // len(q)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.filterwarnings("ignore:.*restored from its parity")
def test_one_changed_byte_costs_nothing(whole, tmp_path, seed):
    """Anywhere in the file: the superblock, the model's text, the samples, the seal, the parity."""
    (tmp_path / "good.h5").write_bytes(whole)
    good, rng = load(tmp_path / "good.h5"), np.random.default_rng(seed)
    places = [
        seed,
        8 + seed,
        *rng.integers(0, len(whole), 12),
        whole.index(b"FLEXSEAL") + 9,
        whole.index(b"FLEXPRTY") + 9,
    ]
    for place in places:
        path = tmp_path / "changed.h5"
        path.write_bytes(whole[:place] + bytes([whole[place] ^ (1 << rng.integers(8))]) + whole[place + 1 :])
        found = load(path)
        assert found.status.kind == "finished", place
        for name in ("t", "q", "u", "a", "works"):
            np.testing.assert_array_equal(getattr(found.phases[0], name), getattr(good.phases[0], name))
        assert found.statistics == good.statistics
        assert found.model.name == "drop"


def test_a_lost_sector_is_restored_and_told(whole, tmp_path, place_of_q):
    path = tmp_path / "changed.h5"
    path.write_bytes(whole[: place_of_q[0]] + bytes(4096) + whole[place_of_q[0] + 4096 :])
    with pytest.warns(
        UserWarning, match=r"changed after it was written, among bytes \d+ to \d+; all of it was restored"
    ):
        found = load(path)
    assert found["place"][-1, 2] == pytest.approx(-9.81 / 2 * 4.0, rel=1e-9)
    found.save(path, fmb.model_text)  # as the warning says
    assert not hdf5.is_damaged(path)


def test_what_cannot_be_restored_costs_its_rows_only(whole, tmp_path, place_of_q):
    """Half of the coordinates are lost: the samples before are read, and `resume` computes the others again."""
    offset, size, row = place_of_q
    first = offset + size // 2
    path = tmp_path / "changed.h5"
    path.write_bytes(whole[:first] + bytes(size // 2) + whole[first + size // 2 :])
    with pytest.warns(UserWarning, match="lost are phases/0/q rows") as told:
        found = load(path)
    texts = " ".join(str(one.message) for one in told)
    assert "all else was restored" in texts
    lost = (size // 2 + 512) // row  # a block more at each end
    assert 2001 - lost - 30 <= len(found.t) <= 1001
    assert found.status.kind == "interrupted"
    assert f"{2001 - len(found.t)} samples that follow there are left out" in texts
    np.testing.assert_allclose(found["place"][:, 2], -9.81 / 2 * found.t**2, atol=1e-9)
    with pytest.warns(UserWarning, match="lost are"):
        again = fmb.resume(path, 2.0, **LINE, read_model=fmb.read_model_text, write_model=fmb.model_text)
    assert again.status.kind == "finished"
    assert len(load(path).t) == 2001  # without a warning: it is a sound file again
    assert not hdf5.is_damaged(path)
    np.testing.assert_allclose(load(path)["place"][:, 2], -9.81 / 2 * again.t**2, atol=1e-8)


def test_zeros_at_the_end_are_no_numbers(whole, tmp_path):
    """A copy that broke off and was filled up to its size: behind the seal nothing is missing, before it numbers may
    be, and nothing tells which.
    """
    seal = whole.index(b"FLEXSEAL")
    for kept in (seal, seal - 1, seal - 2000, len(whole) // 2):
        (tmp_path / "copy.h5").write_bytes(whole[:kept] + bytes(len(whole) - kept))
        with pytest.raises(DataFileError, match="its checksum does not match its content"):
            load(tmp_path / "copy.h5")
    (tmp_path / "copy.h5").write_bytes(whole[: seal + 24] + bytes(len(whole) - seal - 24))
    assert len(load(tmp_path / "copy.h5").t) == LINE["samples"]


def test_a_file_without_its_notes_is_refused(whole, tmp_path):
    """Most of it is lost, and what tells rows from structure too."""
    seal, notes = whole.index(b"FLEXSEAL"), whole.index(b"phases/0/q", whole.index(b"FLEXPRTY"))
    path = tmp_path / "changed.h5"
    path.write_bytes(whole[:600] + bytes(seal - 600) + whole[seal:notes] + b"x" + whole[notes + 1 :])
    with pytest.raises(DataFileError, match=r"the file is damaged.*\(\d+ bytes in all\), more than can be restored"):
        load(path)


def test_all_samples_lost(whole, tmp_path):
    """The structure is there twice: the message is that of a run without samples, not of a file that is no run."""
    seal, path = whole.index(b"FLEXSEAL"), tmp_path / "changed.h5"
    path.write_bytes(bytes(seal) + whole[seal:])
    with (
        pytest.warns(UserWarning, match="lost are phases/0"),
        pytest.raises(
            DataFileError, match=r"there are no samples \(part of the file is missing or damaged at its start"
        ),
    ):
        load(path)


def test_what_is_lost_is_not_held_in_memory(whole, tmp_path, place_of_q):
    """It may be most of a large file; only blocks that differ from the file are kept."""
    offset, size, _ = place_of_q
    path = tmp_path / "changed.h5"
    path.write_bytes(whole[:offset] + bytes(size) + whole[offset + size :])
    mended = hdf5_parity.mend(path)
    lost = sum(last - first for first, last in mended.lost)
    assert lost > 0.9 * size
    assert sum(map(len, mended.blocks.values())) < 0.1 * size
