"""The sheet of modes: as many pictures as modes, different ones, and messages where there is nothing to draw."""

from dataclasses import replace

import numpy as np
import pytest
from reduction.solids import block

from flexmb import reduction
from flexmb.errors import FlexmbError
from flexmb.view import graphics, mode_sheet


@pytest.fixture(scope="module")
def data():
    return reduction.reduce(block(divisions=(4, 1, 1)), {"a": "left"}, modes=4, compare=0)


@pytest.mark.render
def test_modes_side_by_side(data, tmp_path):
    """Four modes in two rows and two columns; each quarter of the sheet shows something else."""
    import pyvista

    path = mode_sheet(data, tmp_path / "out" / "modes.png", modes=4, size=(400, 300))
    image = pyvista.read(path).point_data.active_scalars.reshape(300, 400, -1)[..., :3].astype(float)
    quarters = [image[r : r + 150, c : c + 200] for r in (0, 150) for c in (0, 200)]
    for k, quarter in enumerate(quarters):
        assert len(np.unique(quarter.reshape(-1, 3), axis=0)) > 200
        assert all(np.abs(quarter - other).max() > 50 for other in quarters[:k])


def test_messages(data, tmp_path, monkeypatch):
    with pytest.raises(FlexmbError, match=r"the ending '\.gif'.*\.png, \.jpg.*Use \.png"):
        mode_sheet(data, tmp_path / "x.gif")
    with pytest.raises(
        FlexmbError, match=r"Modes of 'block': there is no mesh\. Expected: data reduced from an FE model"
    ):
        mode_sheet(replace(data, cells=()), tmp_path / "x.png")
    with pytest.raises(FlexmbError, match=r"Modes of 'block': there are no modes"):
        mode_sheet(data.selected(0), tmp_path / "x.png")
    monkeypatch.setattr(graphics, "_outcome", lambda: -11)
    with pytest.raises(FlexmbError, match=r"trial picture ended with code -11"):
        mode_sheet(data, tmp_path / "x.png")
