"""Units whose library is none, lacks functions, or is another than the description says: refused by name."""

import os
import subprocess
import zipfile

import pytest

import flexmb as fmb

pytest.importorskip("fmpy")
from fmi.exchange_units import HAS_COMPILER, description, write_without_library

MODEL = fmb.Model(
    bodies=[fmb.Ground(), fmb.PointMass("mass", mass=2.0)],
    forces=[fmb.PointLoad("push", marker="mass.center", force=(fmb.input("force"), 0, 0))],
)


def in_the_system(path):
    fmb.fmi.ModelExchange(path)


def beside_the_model(path, kind="model exchange"):
    fmb.fmi.cosimulate(MODEL, fmb.fmi.Fmu(path, outputs={"force": "y"}, kind=kind), 0.1, step=0.05)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("use", [in_the_system, beside_the_model])
def test_a_library_that_is_no_program(version, use, tmp_path):
    """The working folder stays where it was, so that names of files mean the same afterwards."""
    path, here = write_without_library(tmp_path / "junk.fmu", "oscillator", version), os.getcwd()
    with pytest.raises(fmb.DataFileError, match=r"Fmu '.*junk\.fmu': its library cannot be loaded"):
        use(path)
    assert os.getcwd() == here


@pytest.mark.parametrize("version", [2, 3])
def test_beside_the_model_with_its_own_solver(version, tmp_path):
    path, here = write_without_library(tmp_path / "junk.fmu", "oscillator", version), os.getcwd()
    other = tmp_path / "solver.fmu"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(other, "w") as new:
        for file in old.namelist():
            text = old.read(file).replace(b"ModelExchange", b"CoSimulation")
            new.writestr(file, text.replace(b' providesDirectionalDerivative="true"', b""))
    with pytest.raises(fmb.DataFileError, match="its library cannot be loaded"):
        beside_the_model(other, "co-simulation")
    assert os.getcwd() == here


@pytest.mark.skipif(not HAS_COMPILER, reason="the library is compiled with cc")
@pytest.mark.parametrize("version", [2, 3])
def test_a_library_without_the_functions(version, tmp_path):
    (tmp_path / "empty.c").write_text("int nothing;\n")
    made = tmp_path / "empty.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-o", str(made), str(tmp_path / "empty.c")], check=True)
    path = write_without_library(tmp_path / "empty.fmu", "oscillator", version, made.read_bytes())
    with pytest.raises(fmb.DataFileError, match=f"functions of FMI {version}"):
        in_the_system(path)


def test_the_description_names_another_library(tmp_path):
    path = write_without_library(tmp_path / "other.fmu", "oscillator", 3)
    other = tmp_path / "moved.fmu"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(other, "w") as new:
        for file in old.namelist():
            new.writestr(file.replace("oscillator.", "pendulum."), old.read(file))
    with pytest.raises(fmb.DataFileError, match="a library 'oscillator'"):
        in_the_system(other)


def test_derivatives_without_a_state(tmp_path):
    sound, path = write_without_library(tmp_path / "sound.fmu", "oscillator", 3), tmp_path / "stray.fmu"
    text = description("oscillator", 3, True).replace(' derivative="1"', "")
    with zipfile.ZipFile(sound) as old, zipfile.ZipFile(path, "w") as new:
        for file in old.namelist():
            new.writestr(file, text if file == "modelDescription.xml" else old.read(file))
    with pytest.raises(fmb.DataFileError, match=r"'der\(x0\)' is listed as a derivative"):
        in_the_system(path)
