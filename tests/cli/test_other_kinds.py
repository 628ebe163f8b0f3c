"""A path where something of another kind lies: what is there is said, never that nothing is."""

import os

import pytest
from results.spinning import block_data

from flexmb.cli import main
from flexmb.found import no_file_because

MODEL_VERBS = ("check", "run", "statics", "modes", "linearize", "bode", "locus", "campbell", "fmu", "sweep")
RUN_VERBS = ("resume", "verify", "export", "plot", "render", "view", "report")
OPTIONS = {
    "psd": ("--density", "1"),
    "locus": ("--over", "g=1:2:2"),
    "campbell": ("--over", "g=1:2:2"),
    "sweep": ("--over", "g=1,2"),
}
ABSENT = ("does not exist", "no such file", "No such file")


@pytest.fixture
def places(fall):
    """Make a run folder, the folder of a sweep, a folder with a run, and files of many kinds."""
    folder = fall.parent
    for name in ("run", "runs/fall", "study/runs/0001"):
        (folder / name).mkdir(parents=True)
        (folder / name / "solution.h5").write_bytes(b"\x89HDF\r\n\x1a\n")
        (folder / name / "model.toml").write_text(fall.read_text())
    (folder / "study/study.json").write_text("{}")
    (folder / "study/results.csv").write_text("number\n")
    for name in ("none.toml", "none.h5", "none.bdf", "none.msh"):
        (folder / name).write_text("")
    (folder / "empty").mkdir()
    (folder / "part.msh").write_text("$MeshFormat")
    block_data().save(folder / "block.h5")
    return folder


def told(verb, path, capsys):
    """Return what a verb says about a path that it refuses."""
    assert main([verb, path, *OPTIONS.get(verb, ())]) == 2
    return capsys.readouterr().err


@pytest.mark.parametrize("verb", MODEL_VERBS)
def test_no_model_file(places, verb, capsys):
    for path, found, remedy in (
        ("run", "a run folder", "run/model.toml"),
        ("study", "the folder of a sweep", "study/results.csv"),
        ("empty", "an empty folder", ".toml"),
    ):
        text = told(verb, path, capsys)
        assert found in text
        assert remedy in text
        assert not any(word in text for word in ABSENT), text
    assert "Did you mean 'fall.toml'?" in told(verb, "FALL.toml", capsys)
    assert "Did you mean 'fall.toml'?" in told(verb, "fall", capsys)
    assert "an empty name" in told(verb, "", capsys)
    assert "it is not text" in (text := told(verb, "block.h5", capsys))
    assert "data =" in text


@pytest.mark.parametrize("verb", RUN_VERBS)
def test_no_run_folder(places, verb, capsys):
    for path, found, remedy in (
        ("fall.toml", "it is a model file", "Name its run folder: runs/fall"),
        ("run/solution.h5", "it is a file in a run folder", "Name the folder: run"),
        ("block.h5", "it is a file", "flexmb show block.h5"),
        ("study", "it is the folder of a sweep", "study/runs/0001"),
        ("runs", "there is no solution.h5", "runs/fall"),
        ("empty", "it is an empty folder", "run the model first"),
        ("fall.toml/x", "'fall.toml' on the way to it is a file", "Correct the path"),
    ):
        text = told(verb, path, capsys)
        assert found in text
        assert remedy in text
        assert not any(word in text for word in ABSENT), text
    assert "it does not exist" in told(verb, "nothing", capsys)


@pytest.mark.parametrize(
    ("verb", "path", "found", "remedy"),
    [
        ("show", "run", "it is no file", "flexmb report run"),
        ("show", "none.h5", "the file is empty", "copy it again"),
        ("show", "part.msh", "the file cannot be read", "write it again"),
        ("show", "fall.toml", "it describes a model", "flexmb run fall.toml"),
        ("reduce", "run", "it is a run folder", "flexmb report run"),
        ("reduce", "fall.toml", "it is a model file", "flexmb check fall.toml"),
        ("reduce", "block.h5", "it is a data file", "flexmb show block.h5"),
        ("reduce", "none.msh", "the file is empty", "copy it again"),
        ("reduce", "none.bdf", "the file is empty", "copy it again"),
    ],
)
def test_no_mesh_and_no_body(places, verb, path, found, remedy, capsys):
    text = told(verb, path, capsys)
    assert found in text
    assert remedy in text
    assert not any(word in text for word in ABSENT), text


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_pipes_are_not_waited_for(places, capsys):
    os.mkfifo("pipe.csv")
    assert main(["sweep", "fall.toml", "--list", "pipe.csv"]) == 2
    assert "a device or pipe" in capsys.readouterr().err
    assert "a device or pipe" in told("show", "pipe.csv", capsys)


def test_links_and_permissions(tmp_path, monkeypatch):
    link, private = tmp_path / "link.toml", tmp_path / "private.toml"
    link.symlink_to("gone.toml")
    assert "a link to 'gone.toml', which does not exist" in no_file_because(link).what
    private.write_text("x")
    assert no_file_because(private) is None
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # who tests as root may read everything
    assert "may not be read" in no_file_because(private).what
