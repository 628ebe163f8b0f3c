"""Reduced bodies are kept by content: the same content is read, any other is reduced."""

from dataclasses import replace

import numpy as np
import pytest
from fem.beams import STEEL, plate
from reduction.solids import block

from flexmb import fem, parts, reduction
from flexmb.errors import ReductionError
from flexmb.parts.fingerprint import fingerprint

ENDS = {"a": "left", "b": "right"}


@pytest.fixture(scope="module")
def fe():
    return block(divisions=(4, 2, 1))


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    """Keep what is reduced here, and nothing else."""
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "kept"))
    return tmp_path / "kept"


def stages(fe, **options):
    said = []
    data = parts.reduced(fe, ENDS, progress=lambda stage, fraction: said.append(stage), **options)
    return data, said


def test_second_reduction_is_read_from_disk(fe, folder):
    first, work = stages(fe, modes=3)
    again, rest = stages(block(divisions=(4, 2, 1)), modes=3)
    assert work[-1] == "done"
    assert rest == []
    np.testing.assert_array_equal(again.shapes, first.shapes)
    assert again.quality == first.quality
    assert [entry.name for entry in parts.kept_bodies()] == [fe.name]
    assert len(list(folder.glob("*.h5"))) == 1
    same = reduction.reduce(fe, ENDS, modes=3)
    np.testing.assert_allclose(same.frequencies, again.frequencies, rtol=1e-12)


@pytest.mark.parametrize(
    "options",
    [
        {"modes": 4},
        {"modes": 3, "frame": "a"},
        {"modes": 3, "damping": 0.01},
        {"modes": 3, "loads": {"air": reduction.Pressure("top", (0, 0, 1))}},
    ],
)
def test_other_settings_are_other_data(fe, options):
    stages(fe, modes=3)
    assert stages(fe, **options)[1] != []


def test_other_model_is_other_content(fe):
    prints = {
        fingerprint(model, ())
        for model in (
            fe,
            replace(fe, K=fe.K * 1.0000001),
            replace(fe, nodes=fe.nodes + 1e-9),
            replace(fe, name="other"),
            replace(fe, node_sets={**fe.node_sets, "left": fe.node_sets["left"][1:]}),
        )
    }
    assert len(prints) == 5
    assert fingerprint(fe, ()) == fingerprint(block(divisions=(4, 2, 1)), ())


def test_damaged_file_is_made_again(fe, folder):
    stages(fe, modes=3)
    (path,) = folder.glob("*.h5")
    path.write_bytes(path.read_bytes()[:1000])
    assert stages(fe, modes=3)[1] != []
    assert stages(fe, modes=3)[1] == []


def test_side_of_the_stress_is_content():
    """The stiffness of a shell does not know at which side its stress is taken."""
    sheet = plate(2, 1, 1.0, 0.5, "quad")
    prints = {fingerprint(fem.shell(sheet, STEEL, 0.01, stress_side=side), ()) for side in (-1.0, 0.0, 1.0)}
    assert len(prints) == 3
    assert fingerprint(fem.shell(sheet, STEEL, 0.01), ()) in prints


def test_place_that_is_no_folder(fe, folder, tmp_path, monkeypatch):
    """The data are made and used; that they are not kept is told as for parts."""
    (tmp_path / "file").touch()
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "file"))
    troubles = []

    class Ear(parts.Watcher):
        def trouble(self, name, words):
            troubles.append((name, words))

    with parts.watching(Ear()):
        assert stages(fe, modes=3)[0].n_modes > 0
    assert [name for name, _ in troubles] == [fe.name]
    assert "cannot be kept" in troubles[0][1]


def test_what_is_no_model_is_refused():
    with pytest.raises(ReductionError, match="FEModel"):
        parts.reduced("beam", ENDS)
