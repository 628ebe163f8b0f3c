"""`flexmb report`: one run folder, several compared, messages."""

from pathlib import Path

import pytest

from flexmb.cli import main


@pytest.fixture
def runs(fall):
    for name, g in (("one", "9.81"), ("two", "1.62")):
        assert main(["run", "fall.toml", "--out", f"runs/{name}", "--set", f"g={g}"]) == 0


def test_report(runs, capsys):
    assert main(["report", "runs/one", "--no-pictures"]) == 0
    assert "Report: runs/one/report.html" in capsys.readouterr().out
    text = Path("runs/one/report.html").read_text(encoding="utf-8")
    assert "<title>fall: one</title>" in text
    assert "Mobility" in text
    assert main(["report", "runs/one", "runs/two", "--no-pictures"]) == 0
    assert "Report: comparison.html" in capsys.readouterr().out
    assert "<title>fall: one, two</title>" in Path("comparison.html").read_text(encoding="utf-8")


def test_runs_of_the_same_name_are_told_apart(runs, capsys):
    main(["run", "fall.toml", "--out", "others/one"])
    assert main(["report", "runs/one", "others/one", "--no-pictures", "-o", "c.html"]) == 0
    assert "fall: runs/one, others/one" in Path("c.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["runs/three"], "Run folder 'runs/three': it does not exist"),
        (["runs/one", "runs/one"], "Report: a run folder is given twice"),
        (["runs/one", "-o", "x.txt"], "Report 'x.txt': the ending '.txt'"),
        (["runs/one", "--camera", "up"], "--camera up: 'up'. Expected: 3 numbers"),
    ],
)
def test_messages(runs, capsys, arguments, message):
    assert main(["report", *arguments]) == 2
    assert message in capsys.readouterr().err
