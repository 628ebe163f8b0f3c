"""A deck, a model file and its run give the same bits whatever locale, encoding, seed of hashes and threads.

Another process calculates the same with all of these different at once, in a program that has set a locale in which
numbers have commas.
"""

import locale
import os
import shutil
import subprocess
import sys

import h5py

from flexmb.cli import main

DECK = """\
CEND
BEGIN BULK
MAT1,1,2.1+11,,.3,7850.
PBAR,1,1,4.0-4,1.333333-8,1.333333-8,2.25-8
GRID,1,,0.,0.,0.
GRID,2,,.25,0.,0.
GRID,3,,.5,.0125,0.
GRID,4,,.75,.05,0.
GRID,5,,1.,.1,0.
CBAR,1,1,1,2,0.,0.,1.
CBAR,2,1,2,3,0.,0.,1.
CBAR,3,1,3,4,0.,0.,1.
CBAR,4,1,4,5,0.,0.,1.
CONM2,9,5,,.75,.01,.02,.005
ENDDATA
"""
MODEL = """\
name = "Träger"
gravity = [0, 0, -9.81]

[parameters]
push = 12.5

[[body]]
kind = "Ground"

[[body]]
kind = "FloatingBody"
name = "beam"
damping = 0.02
[body.data]
deck = "beam.bdf"
units = "m, kg, s"
lumped = false
interfaces = { root = "node 1", tip = "node 5" }
modes = 4

[[body]]
kind = "RigidBody"
name = "bob"
mass = 0.3
inertia = [1e-3, 1e-3, 1e-3]
at = [1.0, 0.1, -0.2]
[body.markers]
pin = [0, 0, 0.2]

[[joint]]
kind = "Fixed"
name = "wall"
markers = ["ground.origin", "beam.root"]

[[joint]]
kind = "Spherical"
name = "pin"
markers = ["beam.tip", "bob.pin"]

[[force]]
kind = "PointLoad"
name = "push"
marker = "bob.center"
force = [0, "= push*sin(7.5*t)", 0]

[[sensor]]
kind = "Reaction"
name = "Auflager"
joint = "wall"

[[sensor]]
kind = "Position"
name = "bob"
marker = "bob.center"

[simulation]
t_end = 0.5
samples = 51
"""
PROGRAM = """\
import locale, sys
try:
    locale.setlocale(locale.LC_ALL, "")
except locale.Error:
    pass
print("point", locale.localeconv()["decimal_point"])
from flexmb.cli import main
sys.exit(main(["run", "model.toml", "--out", "out"]))
"""


def comma(folder) -> dict[str, str]:
    """Return variables of a locale with decimal commas: one that can be made, or is there; none otherwise."""
    make = shutil.which("localedef")
    if make is not None:
        name = folder / "de_DE.UTF-8"
        subprocess.run([make, "-i", "de_DE", "-f", "UTF-8", str(name)], capture_output=True, check=False)
        if name.is_dir():
            return {"LOCPATH": str(folder), "LC_ALL": "de_DE.UTF-8"}
    known = locale.setlocale(locale.LC_NUMERIC)
    for name in ("de_DE.UTF-8", "fr_FR.UTF-8", "tr_TR.UTF-8", "de-DE"):
        try:
            locale.setlocale(locale.LC_NUMERIC, name)
        except locale.Error:
            continue
        locale.setlocale(locale.LC_NUMERIC, known)
        return {"LC_ALL": name}
    return {}


def arrays(path) -> dict[str, bytes]:
    """Return all numbers of a solution by their names, without how long it took."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(
            lambda name, item: (
                found.update({name: item[()].tobytes()})
                if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" and name.startswith("phases")
                else None
            )
        )
    return found


def written(folder):
    """Write deck and model to a new folder; return what a run of them leaves there."""
    folder.mkdir()
    (folder / "beam.bdf").write_text(DECK)
    (folder / "model.toml").write_text(MODEL, encoding="utf-8")
    return folder / "out"


def test_runs_of_other_machines_have_the_same_bits(tmp_path, monkeypatch):
    own, other = written(tmp_path / "own"), written(tmp_path / "other")
    with monkeypatch.context() as here:
        here.chdir(own.parent)
        here.setenv("FLEXMB_BODIES", str(own.parent / "bodies"))
        assert main(["run", "model.toml", "--out", "out"]) == 0
    named = {"LC_ALL": "C", **comma(tmp_path)}
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "2")
    more = {"PYTHONHASHSEED": "4711", "PYTHONUTF8": "0", "FLEXMB_BODIES": str(other.parent / "bodies")}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        cwd=other.parent,
        env={**os.environ, **named, **threads, **more},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.split()[1] == (b"." if named["LC_ALL"] == "C" else b",")
    numbers = [arrays(folder / "solution.h5") for folder in (own, other)]
    assert len(numbers[0]) > 3
    assert numbers[0] == numbers[1]
    assert (own / "sensors.csv").read_bytes() == (other / "sensors.csv").read_bytes()
