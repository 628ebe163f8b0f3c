"""A motion in closed form to be drawn."""

from dataclasses import replace

import numpy as np
import pytest
from results.every_cell import every_cell_data
from results.spinning import observe, spinning_model, spinning_phase

from flexmb.model.model import Model
from flexmb.results import Solution


@pytest.fixture
def solution(monkeypatch):
    """Half a turn in five samples; the flexible body has one cell of every type."""
    monkeypatch.setattr("flexmb.system.observe", observe, raising=False)
    model = spinning_model()
    bodies = [replace(body, data=every_cell_data()) if body.name == "block" else body for body in model.bodies]
    return Solution(phases=(spinning_phase(Model(bodies=bodies, joints=model.joints), t=np.linspace(0, 0.08, 5)),))
