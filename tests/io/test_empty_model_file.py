"""A model file without content says that it is empty, not that its model lacks a body."""

import pytest

import flexmb as fmb
from flexmb.errors import ModelError


@pytest.mark.parametrize("text", ["", " \n\t\n", "\ufeff\n"])
def test_says_that_it_is_empty(text, tmp_path):
    path = tmp_path / "none.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ModelError, match="the file is empty"):
        fmb.load_model(path)


def test_a_file_of_parameters_is_a_model_without_bodies(tmp_path):
    path = tmp_path / "few.toml"
    path.write_text("[parameters]\na = 1.0\n", encoding="utf-8")
    assert not fmb.load_model(path).bodies
