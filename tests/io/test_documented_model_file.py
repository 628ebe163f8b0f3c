"""The model file of docs/howto/model-files.md is what the page says."""

import re
from pathlib import Path

import numpy as np
import pytest

import flexmb as fmb
from flexmb import io

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "model-files.md"


def test_the_pendulum_of_the_page(tmp_path):
    """A rod of length L released from the horizontal: the bearing carries 5/2 m g at the lowest point."""
    text = re.search(r"```toml\n(name.*?)```", PAGE.read_text("utf-8"), re.DOTALL)[1]
    path = tmp_path / "pendulum.toml"
    path.write_text(text)
    settings = io.load_simulation(path)
    assert settings.t_end == pytest.approx(4 * np.pi * np.sqrt(2 * 0.5 / (3 * 9.81)))
    solution = fmb.simulate(io.load_model(path), **settings.keywords())
    assert solution["bearing"][:, 2].max() == pytest.approx(2.5 * 9.81, rel=1e-3)


def test_the_expressions_of_the_page(tmp_path):
    """Signals and poses of the page can be read."""
    lines = re.findall(r"^(?:angle|force|moment) = .*$", PAGE.read_text("utf-8"), re.MULTILINE)
    assert len(lines) == 5
    (tmp_path / "load.csv").write_text("t [s],F [N]\n0,0\n1,2\n")
    for line in lines[1:]:
        path = tmp_path / "m.toml"
        path.write_text(
            '[parameters]\nlift = 1.0\n[[body]]\nkind = "PointMass"\nname = "p"\nmass = 1\n'
            '[[body]]\nkind = "Ground"\n'
            f'[[force]]\nkind = "PointLoad"\nname = "f"\nmarker = "p.center"\n{line}\n'
        )
        assert len(io.load_model(path).forces) == 1
