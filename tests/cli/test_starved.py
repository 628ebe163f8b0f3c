"""Full disks, limits and poor terminals on the command line: a message, never a traceback or a crash."""

import os
import subprocess
import sys

import pytest
from results.spinning import block_data

import flexmb as fmb
from flexmb.cli import main

LIMITED = """
import resource, sys
import flexmb as fmb
from flexmb.results import RunFile
data = fmb.ModalNeutralData.load(sys.argv[1])
for limit in range(0, int(sys.argv[3]), 997):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, -1))
    for write in (lambda: data.save(sys.argv[2]), lambda: RunFile(sys.argv[2], {"block": data}).close()):
        try:
            write()
            raise AssertionError("it has been written")
        except fmb.DataFileError as error:
            assert "File too large" in str(error), error
print("all said")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there are no such limits")
def test_no_room_for_bodies(tmp_path):
    """HDF5 ends the process when a file cannot be closed: it must not notice."""
    data = tmp_path / "block.h5"
    block_data().save(data)
    target = tmp_path / "other.h5"
    target.write_bytes(b"what was there before")
    command = [sys.executable, "-c", LIMITED, str(data), str(target), str(data.stat().st_size - 2000)]
    child = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (child.returncode, child.stdout) == (0, "all said\n"), child.stderr
    assert target.read_bytes() == b"what was there before"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["block.h5", "other.h5"]


def test_a_terminal_without_umlauts(fall):
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    command = [sys.executable, "-m", "flexmb", "check", str(fall)]
    child = subprocess.run(command, capture_output=True, env=environment, check=False)
    assert child.returncode == 0, child.stderr.decode()
    assert b"Grubler" in child.stdout


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no /dev/full")
def test_output_to_a_full_disk(fall):
    with open("/dev/full", "w") as full:
        child = subprocess.run(
            [sys.executable, "-m", "flexmb", "check", str(fall)], stdout=full, stderr=subprocess.PIPE, check=False
        )
    assert child.returncode == 2
    assert b"No space left" in child.stderr
    assert b"Traceback" not in child.stderr


def test_places_that_cannot_be_written(fall, capsys):
    """A file where a folder should be: every verb says so."""
    assert main(["run", str(fall), "--out", "run"]) == 0
    (fall.parent / "file").write_text("")
    for verb in (
        ["run", str(fall), "--out", "file/run"],
        ["run", str(fall), "--out", "file"],
        ["export", "run", "--csv", "--to", "file/x"],
        ["plot", "run", "-o", "file/x.png"],
        ["report", "run", "--no-pictures", "-o", "file/x.html"],
        ["sweep", str(fall), "--over", "g=1,2", "--out", "file/x"],
    ):
        assert main(verb) == 2
        assert "file" in capsys.readouterr().err


def test_a_locked_folder_is_refused_by_name(fall, capsys):
    """A run that goes on is not touched, with or without --overwrite; reading it says that it goes on."""
    assert main(["run", str(fall), "--out", "run"]) == 0
    before = (fall.parent / "run" / "solution.h5").read_bytes()
    holding = (
        "import sys\nfrom flexmb.lock import Lock\nlock = Lock('run', 'x'), Lock('run/solution.h5', 'y')\n"
        "print('held', flush=True)\nsys.stdin.read()"
    )
    child = subprocess.Popen([sys.executable, "-c", holding], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert child.stdout.readline() == b"held\n"
    capsys.readouterr()
    for verb in (
        ["run", str(fall), "--out", "run"],
        ["run", str(fall), "--out", "run", "--overwrite"],
        ["resume", "run", "--t-end", "2"],
    ):
        assert main(verb) == 2
        assert f"process {child.pid} on host" in capsys.readouterr().err
    with pytest.raises(fmb.DataFileError, match=f"process {child.pid} on host"):
        fmb.simulate(fmb.load_model(fall), 1.0, output="run/solution.h5")
    assert (fall.parent / "run" / "solution.h5").read_bytes() == before
    child.kill()  # it does not take back the lock: the operating system does
    child.wait()
    child.stdin.close()
    child.stdout.close()
    assert main(["run", str(fall), "--out", "run", "--overwrite"]) == 0
