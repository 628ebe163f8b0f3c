"""`flexmb verify`: the table, the file it leaves, the section of the report."""

import os
from pathlib import Path

import pytest

import flexmb as fmb
from flexmb.cli import main, resume
from flexmb.errors import DataFileError


def test_a_run_is_verified_and_reported(fall, capsys):
    assert main(["run", "fall.toml", "--out", "runs/one"]) == 0
    assert main(["report", "runs/one", "--no-pictures"]) == 0
    assert "How far this can be trusted" not in Path("runs/one/report.html").read_text(encoding="utf-8")
    capsys.readouterr()
    assert main(["verify", "runs/one", "--window", "0.2:0.6"]) == 0
    printed = capsys.readouterr().out
    assert "How far model 'fall' can be trusted: all 1 answers hold within 1 %" in printed
    assert "by IDA, t = 0.2 to 0.6 s" in printed
    assert fmb.Verification.load("runs/one/verification.json").ok
    assert main(["report", "runs/one", "--no-pictures"]) == 0
    page = Path("runs/one/report.html").read_text(encoding="utf-8")
    assert "How far this can be trusted" in page
    assert "equations of motion" in page
    assert "by integrator" in page
    # another run in the same folder is not the one that was verified
    assert main(["run", "fall.toml", "--out", "runs/one", "--overwrite"]) == 0
    assert not Path("runs/one/verification.json").exists()


def test_what_does_not_hold_is_the_exit_code(fall, capsys):
    assert main(["run", "fall.toml", "--out", "runs/one"]) == 0
    assert main(["verify", "runs/one", "--within", "1e-15"]) == 1
    assert "do not" in capsys.readouterr().out


def test_messages(fall, capsys):
    assert main(["verify", "runs/none"]) == 2
    assert "Run folder 'runs/none': it does not exist" in capsys.readouterr().err
    assert main(["run", "fall.toml", "--out", "runs/one"]) == 0
    assert main(["verify", "runs/one", "--window", "now"]) == 2
    assert "--window: 'now'. Expected: two times in s, FROM:TO" in capsys.readouterr().err


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes")
def test_a_pipe_among_the_files_of_a_run_is_refused_before_the_work(fall, capsys, monkeypatch):
    """Opening it would wait for a reader, after a verification that takes ten times as long as the run."""
    monkeypatch.setattr(fmb, "verify", lambda *_, **__: pytest.fail("verified"))
    monkeypatch.setattr(resume, "_continued", lambda *_: pytest.fail("continued"))
    assert main(["run", "fall.toml", "--out", "runs/one"]) == 0
    os.mkfifo("runs/one/verification.json")
    assert main(["verify", "runs/one"]) == 2
    assert "'runs/one': verification.json is a pipe or a device. Expected: a regular" in capsys.readouterr().err
    for name in ("log.txt", "sensors.csv"):
        Path("runs/one", name).unlink()
        os.mkfifo(f"runs/one/{name}")
        assert main(["resume", "runs/one"]) == 2
        assert f"{name} is a pipe or a device" in capsys.readouterr().err
        os.unlink(f"runs/one/{name}")
        Path("runs/one", name).touch()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes")
def test_a_verification_is_not_saved_into_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "verification.json")
    with pytest.raises(DataFileError, match=r"verification.json is a pipe or a device"):
        fmb.Verification.save(object(), tmp_path / "verification.json")
