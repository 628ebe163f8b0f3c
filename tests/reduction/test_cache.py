"""Reduced bodies are kept by content: the same content is read, any other is reduced."""

from dataclasses import replace

import numpy as np
import pytest
from fem.beams import STEEL, plate
from reduction.solids import block

from flexmb import fem, reduction
from flexmb.errors import DataFileError
from flexmb.reduction.cache import fingerprint

ENDS = {"a": "left", "b": "right"}


@pytest.fixture(scope="module")
def fe():
    return block(divisions=(4, 2, 1))


def stages(fe, folder, **options):
    said = []
    data = reduction.reduce(fe, ENDS, cache=folder, progress=lambda stage, fraction: said.append(stage), **options)
    return data, said


def test_second_reduction_is_read_from_disk(fe, tmp_path):
    first, work = stages(fe, tmp_path / "kept", modes=3)
    again, rest = stages(block(divisions=(4, 2, 1)), tmp_path / "kept", modes=3)
    assert work[-1] == "done"
    assert rest == []
    np.testing.assert_array_equal(again.shapes, first.shapes)
    assert again.quality == first.quality
    assert len(list((tmp_path / "kept").iterdir())) == 1


@pytest.mark.parametrize(
    "options",
    [
        {"modes": 4},
        {"modes": 3, "frame": "a"},
        {"modes": 3, "damping": 0.01},
        {"modes": 3, "loads": {"air": reduction.Pressure("top", (0, 0, 1))}},
    ],
)
def test_other_settings_are_other_data(fe, tmp_path, options):
    stages(fe, tmp_path, modes=3)
    assert stages(fe, tmp_path, **options)[1] != []


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


def test_damaged_file_is_made_again(fe, tmp_path):
    stages(fe, tmp_path, modes=3)
    path = next(tmp_path.iterdir())
    path.write_bytes(path.read_bytes()[:1000])
    assert stages(fe, tmp_path, modes=3)[1] != []
    assert stages(fe, tmp_path, modes=3)[1] == []


def test_side_of_the_stress_is_content():
    """The stiffness of a shell does not know at which side its stress is taken."""
    sheet = plate(2, 1, 1.0, 0.5, "quad")
    prints = {fingerprint(fem.shell(sheet, STEEL, 0.01, stress_side=side), ()) for side in (-1.0, 0.0, 1.0)}
    assert len(prints) == 3
    assert fingerprint(fem.shell(sheet, STEEL, 0.01), ()) in prints


def test_place_that_is_no_folder(fe, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(DataFileError, match=r"no folder can be made there.*may be written to"):
        reduction.reduce(fe, ENDS, modes=3, cache=tmp_path / "file")
