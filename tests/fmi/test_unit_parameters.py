"""Parameters of units: what a host sets before the start is what the model has."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb

HOST = """
import sys
import fmpy

values = {"k": 50.0, "m": 3.0} if sys.argv[2] == "set" else {}
seen = fmpy.simulate_fmu(sys.argv[1], stop_time=0.5, output_interval=0.5, start_values=values)
print(float(seen["place.x"][-1]).hex())
"""


def sled() -> fmb.Model:
    return fmb.Model(
        bodies=[fmb.Ground(markers={"wall": (-1, 0, 0)}), fmb.PointMass("mass", mass=2.0, at=(0.3, 0, 0))],
        forces=[fmb.SpringDamper("spring", markers=("ground.wall", "mass.center"), stiffness=8.0, length=1.0)],
        sensors=[fmb.Position("place", marker="mass.center")],
    )


TUNES = """
import sys
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave

told = read_model_description(sys.argv[1])
number = {v.name: v.valueReference for v in told.modelVariables}
unit = FMU3Slave(guid=told.guid, unzipDirectory=extract(sys.argv[1]), instanceName="one",
                 modelIdentifier=told.coSimulation.modelIdentifier)
unit.instantiate()
unit.enterInitializationMode(startTime=0.0)
unit.exitInitializationMode()

def steps(begin, end):
    for k in range(begin, end):
        unit.doStep(currentCommunicationPoint=0.05 * k, communicationStepSize=0.05)
    return unit.getFloat64([number["place.x"]])[0]

steps(0, 4)
kept = unit.getFMUState()
unit.setFloat64([number["k"]], [50.0])
changed = steps(4, 8)
unit.setFMUState(kept)
found = [changed, unit.getFloat64([number["k"]])[0], steps(4, 8)]
print(" ".join(float(x).hex() for x in found))
unit.terminate()
unit.freeInstance()
"""
PLACES = {"k": "spring.stiffness", "m": "mass.mass"}


@pytest.mark.parametrize("version", [3, slow(2)])
def test_a_host_sets_parameters(version, tmp_path):
    pytest.importorskip("fmpy")
    pytest.importorskip({3: "pythonfmu3", 2: "pythonfmu"}[version])
    from fmpy import read_model_description
    from fmpy.validation import validate_fmu

    settings = fmb.Simulation(t_end=0.5, integrator=fmb.Explicit())
    path = fmb.fmi.write_fmu(sled(), tmp_path / "sled.fmu", settings=settings, version=version, parameters=PLACES)
    assert validate_fmu(str(path)) == []
    told = {v.name: v for v in read_model_description(str(path)).modelVariables}
    assert (told["k"].causality, told["k"].variability, float(told["k"].start)) == ("parameter", "fixed", 8.0)
    for how, stiffness, mass in (("set", 50.0, 3.0), ("not", 8.0, 2.0)):
        run = subprocess.run([sys.executable, "-c", HOST, str(path), how], capture_output=True, text=True, timeout=300)
        assert run.returncode == 0, run.stderr
        model = sled().changed("spring", stiffness=stiffness).changed("mass", mass=mass)
        expected = fmb.simulate(model, 0.5, integrator=fmb.Explicit(), samples=2)["place"][-1, 0]
        assert float.fromhex(run.stdout.split()[-1]) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    ("places", "told"),
    [
        ({"k": "sprung.stiffness"}, r"'sprung\.stiffness'.*Did you mean 'spring'"),
        ({"k": "spring.stifness"}, "Did you mean 'stiffness'"),
        ({"k": "spring.markers"}, "a field that is a number"),
        ({"place.x": "spring.stiffness"}, "several variables of the name 'place.x'"),
        (["k"], "parameters"),
    ],
)
def test_wrong_places_are_said(places, told, tmp_path):
    with pytest.raises(fmb.ModelError, match=told):
        fmb.fmi.write_fmu(sled(), tmp_path / "sled.fmu", parameters=places)


def test_a_host_changes_a_parameter_between_steps(tmp_path):
    """The spring is stiffer from 0.2 s on: cosines one after the other; a state set back has the old spring again."""
    pytest.importorskip("fmpy")
    pytest.importorskip("pythonfmu3")
    from fmpy import read_model_description
    from fmpy.validation import validate_fmu

    settings = fmb.Simulation(t_end=0.5, integrator=fmb.Explicit(rtol=1e-10))
    path = fmb.fmi.write_fmu(sled(), tmp_path / "sled.fmu", settings=settings, tunable={"k": "spring.stiffness"})
    assert validate_fmu(str(path)) == []
    told = {v.name: v for v in read_model_description(str(path)).modelVariables}
    assert (told["k"].causality, told["k"].variability) == ("parameter", "tunable")
    run = subprocess.run([sys.executable, "-c", TUNES, str(path)], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    changed, k, unchanged = (float.fromhex(word) for word in run.stdout.split()[-3:])
    w, later = 2.0, 5.0
    x, v = 0.3 * np.cos(0.2 * w), -0.3 * w * np.sin(0.2 * w)
    assert changed == pytest.approx(x * np.cos(0.2 * later) + v / later * np.sin(0.2 * later), abs=1e-8)
    assert (k, unchanged) == (8.0, pytest.approx(0.3 * np.cos(0.4 * w), abs=1e-8))


def test_the_state_space_stands_beside_the_model(tmp_path):
    """A force on the sled: x'' = (u - k x) / m."""
    pytest.importorskip("pythonfmu3")
    from io import BytesIO
    from zipfile import ZipFile

    from scipy.io import loadmat

    pushed = fmb.PointLoad("push", marker="mass.center", force=(fmb.input("u"), 0, 0))
    model = replace(sled(), forces=[*sled().forces, pushed])
    plant = fmb.linearize(model, inputs=["u"], outputs=["place x"])
    path = fmb.fmi.write_fmu(model, tmp_path / "sled.fmu", plant=plant)
    with ZipFile(path) as unit:
        told = loadmat(BytesIO(unit.read("resources/plant.mat")))
    response = told["C"] @ np.linalg.solve(3j * np.eye(len(told["A"])) - told["A"], told["B"]) + told["D"]
    assert response[0, 0] == pytest.approx(1.0 / (8.0 - 2.0 * 3.0**2), rel=1e-6)
    assert str(told["inputs"][0, 0][0]) == "u"
