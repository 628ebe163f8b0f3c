"""Whatever a verb is asked to write with -o: what lies there already, of another kind or read by it, stays."""

import argparse

import pytest

from flexmb.cli import main
from flexmb.cli.command_line import VERBS
from flexmb.cli.written_files import WRITTEN, _is_used

READS = {
    "plot": ["runs/a"], "render": ["runs/a"], "report": ["runs/a"], "show": ["part.bdf"],
    "reduce": ["part.bdf", "--material", "steel"], "psd": ["crane.toml", "--density", "1e-6"],
    "locus": ["crane.toml", "--over", "k=1:2:3"], "campbell": ["crane.toml", "--over", "k=1:2:3"],
}  # fmt: skip
OTHERS = ("block.h5", "other.toml", "notes.txt", "mesh.msh")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with files of many kinds; what the verbs would read need not be right: they are not asked to compute."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs" / "a").mkdir(parents=True)
    names = [*OTHERS, "crane.toml", "part.bdf", "road.csv", "runs/a/solution.h5", "arrays.csv", "a.json", "a.png"]
    for name in names:
        (tmp_path / name).write_text(f"this is {name}")
    (tmp_path / "crane.toml").write_text('force = { table = "road.csv" }')
    (tmp_path / "arrays.csv").write_bytes(b"\x89HDF\r\n\x1a\n and arrays")
    return tmp_path


def refused(folder, words, capsys) -> str:
    """Return what a command is refused with; no file is another one then."""
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert main(words) == 2
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    return capsys.readouterr().err


PAIRS = [(verb, other) for verb in sorted(WRITTEN) for other in OTHERS if (verb, other) != ("reduce", "block.h5")]
"""A body that `reduce` would replace is another test's: it is of its own kind."""


@pytest.mark.parametrize(("verb", "other"), PAIRS)
def test_files_of_other_kinds_are_kept(verb, other, folder, capsys):
    told = refused(folder, [verb, *READS.get(verb, ["crane.toml"]), "-o", other], capsys)
    assert f"'{other}'" in told
    assert "the file exists already" in told
    assert "--overwrite" in told


@pytest.mark.parametrize("verb", sorted(WRITTEN))
def test_what_is_read_is_never_written_over(verb, folder, capsys):
    """Not even where overwriting is allowed."""
    read = READS.get(verb, ["crane.toml"])
    own = "runs/a/solution.h5" if read == ["runs/a"] else read[0]
    told = refused(folder, [verb, *read, "-o", own, "--overwrite"], capsys)
    assert f"flexmb {verb} reads it" in told


def test_tables_that_the_model_reads_are_kept(folder, capsys):
    """As the table asked for, and as the one beside a picture."""
    for words in (["statics", "crane.toml", "-o", "road.csv"], ["bode", "crane.toml", "-o", "road.png"]):
        assert "'road.csv'" in refused(folder, words, capsys)
    assert "reads it" in refused(folder, ["psd", "crane.toml", "--density", "road.csv", "-o", "road.png"], capsys)


def test_only_whole_names_in_the_model_are_its_tables(folder):
    """The end of another name is none; a name at the end of a path is one."""
    (folder / "crane.toml").write_text('force = { table = "tables/road.csv" }')
    given = argparse.Namespace(verb="statics", model="crane.toml")
    found = {name: _is_used(given, folder / name) for name in ("road.csv", "d.csv", "oad.csv", "road.cs")}
    assert found == {"road.csv": True, "d.csv": False, "oad.csv": False, "road.cs": False}


def test_runs_beside_are_never_written_over(folder, capsys):
    (folder / "runs" / "b").mkdir()
    (folder / "runs" / "b" / "solution.h5").write_text("another run")
    words = ["plot", "runs/a", "--with", "runs/b", "-o", "runs/b/solution.h5", "--overwrite"]
    assert "flexmb plot reads it" in refused(folder, words, capsys)


def test_arrays_under_another_name_and_reports_of_nothing(folder, capsys):
    assert "'arrays.csv'" in refused(folder, ["statics", "crane.toml", "-o", "arrays.csv"], capsys)
    told = refused(folder, ["reduce", "part.bdf", "--material", "steel", "-o", "a.h5"], capsys)
    assert "'a.json'" in told
    assert "'block.h5'" in refused(folder, ["statics", "crane.toml", "--vtk", "block.h5"], capsys)


def test_every_verb_that_writes_a_file_is_known():
    """A new verb with -o stands in the table."""
    for verb in VERBS:
        parser = argparse.ArgumentParser()
        verb.add_arguments(parser)
        assert ("-o" in parser._option_string_actions) == (verb.NAME in WRITTEN), verb.NAME
