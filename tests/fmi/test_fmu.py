"""Models as functional mock-up units, in FMPy as the host."""

import subprocess
import sys
import zipfile

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb
from flexmb.fmi.inside import variable_name
from flexmb.fmi.units import base_units

VERSIONS = pytest.mark.parametrize("version", [3, 2])
SETTINGS = fmb.Simulation(t_end=1.0, integrator=fmb.Explicit())


def four_bar() -> fmb.Model:
    """A crank with a motor, a coupler and a rocker with a spring."""
    places = {"A": (0, 0, 0), "B": (0, 0.1, 0), "C": (0.3, 0.2, 0), "D": (0.3, 0, 0)}
    bodies = [fmb.Ground(markers={"A": places["A"], "D": places["D"]})]
    for name, start, end in (("crank", "A", "B"), ("coupler", "B", "C"), ("rocker", "C", "D")):
        way = tuple(np.subtract(places[end], places[start]))
        bodies.append(
            fmb.RigidBody(
                name,
                mass=1.0,
                inertia=(0.01, 0.01, 0.01),
                at=places[start],
                markers={start: (0, 0, 0), end: way},
            )
        )
    pins = [("ground", "crank", "A"), ("crank", "coupler", "B"), ("coupler", "rocker", "C"), ("rocker", "ground", "D")]
    return fmb.Model(
        bodies=bodies,
        joints=[fmb.Revolute(at, markers=(f"{a}.{at}", f"{b}.{at}")) for a, b, at in pins],
        forces=[
            fmb.Actuator("motor", joint="A", effort=fmb.input("torque", 0.2)),
            fmb.TorsionSpring("return", joint="D", stiffness=2.0, damping=0.05),
        ],
        sensors=[fmb.JointCoordinate("crank angle", joint="A"), fmb.Reaction("pin", joint="D")],
        gravity=(0, -9.81, 0),
    )


HOST = """
import atexit
import sys
import numpy as np
import fmpy
import flexmb.fmi.library as library

given_back = []
release = library.release
library.release = lambda one: (release(one), given_back.append(one))
atexit.register(lambda: print("libraries given back:", len(given_back)))  # the unit's comes before
torque = np.array([(0.0, 0.5), (0.3, 0.5), (0.3, -0.2), (2.0, -0.2)], dtype=[("time", float), ("torque", float)])
given = torque if sys.argv[2] == "set" else None
seen = fmpy.simulate_fmu(sys.argv[1], stop_time=1.0, output_interval=0.05, input=given)
print(*seen.dtype.names)
for row in seen:
    print(*(float(x).hex() for x in row))
"""


def hosted(path, how: str) -> dict[str, np.ndarray]:
    """Return the outputs over time of a unit that runs in FMPy, in a process of its own as hosts are."""
    run = subprocess.run([sys.executable, "-c", HOST, str(path), how], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    names, *rows, last = run.stdout.splitlines()
    assert last == "libraries given back: 1"  # else the library writes into freed memory as the process ends
    values = np.array([[float.fromhex(x) for x in row.split()] for row in rows])
    return dict(zip(names.split(), values.T, strict=True))


@pytest.mark.parametrize("version", [slow(3), 2])
def test_fmpy_runs_the_unit_as_we_run_the_model(version, tmp_path):
    pytest.importorskip("fmpy")
    pytest.importorskip({3: "pythonfmu3", 2: "pythonfmu"}[version])
    from fmpy.validation import validate_fmu

    path = fmb.fmi.write_fmu(four_bar(), tmp_path / "four_bar.fmu", settings=SETTINGS, version=version)
    assert validate_fmu(str(path)) == []
    seen = hosted(path, "set")
    assert list(seen)[:3] == ["time", "crank.angle", "pin.fx"]
    with fmb.stepper(four_bar(), integrator=fmb.Explicit(), t_end=1.0) as run:
        run.set("torque", 0.5)
        run.advance(to=0.3)
        run.set("torque", -0.2)
        run.advance(to=1.0)
        assert seen["crank.angle"][-1] == pytest.approx(run["crank angle"], abs=1e-8)
        assert seen["pin.fx"][-1] == pytest.approx(run["pin"][0], abs=1e-6)
    unset = hosted(path, "not set")
    reference = fmb.simulate(four_bar(), 1.0, integrator=fmb.Explicit(), samples=21)
    np.testing.assert_allclose(unset["crank.angle"], reference["crank angle"], atol=1e-8)


def test_a_host_takes_steps_back(tmp_path):
    fmpy = pytest.importorskip("fmpy")
    pytest.importorskip("pythonfmu3")
    from fmpy.fmi3 import FMU3Slave

    path = fmb.fmi.write_fmu(four_bar(), tmp_path / "four_bar.fmu", settings=SETTINGS)
    about = fmpy.read_model_description(str(path))
    assert about.coSimulation.canGetAndSetFMUstate
    number = {v.name: v.valueReference for v in about.modelVariables}
    unit = FMU3Slave(
        guid=about.guid,
        unzipDirectory=fmpy.extract(str(path), tmp_path / "unit"),
        modelIdentifier=about.coSimulation.modelIdentifier,
        instanceName="one",
    )
    unit.instantiate()
    unit.enterInitializationMode(startTime=0.0)
    unit.exitInitializationMode()
    unit.doStep(0.0, 0.1)
    state, angle = unit.getFMUState(), unit.getFloat64([number["crank.angle"]])
    ends = []
    for torque in (1.0, -1.0, 1.0):
        unit.setFMUState(state)
        assert unit.getFloat64([number["crank.angle"]]) == angle
        unit.setFloat64([number["torque"]], [torque])
        unit.doStep(0.1, 0.1)
        ends.append(unit.getFloat64([number["crank.angle"]])[0])
    assert ends[0] == ends[2] != ends[1]
    unit.freeFMUState(state)
    unit.terminate()
    unit.freeInstance()


def test_what_a_unit_holds(tmp_path):
    pytest.importorskip("pythonfmu3")
    path = fmb.fmi.write_fmu(four_bar(), tmp_path / "four_bar.fmu", settings=SETTINGS)
    with zipfile.ZipFile(path) as unit:
        names = unit.namelist()
        description = unit.read("modelDescription.xml").decode()
    assert "resources/model.toml" in names
    assert 'unit="rad"' in description
    assert "Python interpreter in which flexmb is installed" in description
    assert str(tmp_path) not in description


def test_what_cannot_be_a_unit_is_said(tmp_path):
    model = four_bar()
    for name in ("four-bar.fmu", "four_bar.zip", "4bar.fmu"):
        with pytest.raises(fmb.ModelError, match="identifier"):
            fmb.fmi.write_fmu(model, tmp_path / name)
    with pytest.raises(fmb.ModelError, match="version = 1"):
        fmb.fmi.write_fmu(model, tmp_path / "a.fmu", version=1)
    twice = fmb.Model(
        bodies=model.bodies,
        joints=model.joints,
        forces=[fmb.Actuator("motor", joint="A", effort=fmb.input("crank.angle"))],
        sensors=model.sensors,
    )
    with pytest.raises(fmb.ModelError, match=r"several variables.*crank\.angle"):
        fmb.fmi.write_fmu(twice, tmp_path / "a.fmu")


def test_names_and_units_follow_the_conventions():
    assert variable_name("crank angle") == "crank.angle"
    assert variable_name("3rd pin") == "'3rd pin'"
    assert variable_name("it's") == r"'it\'s'"
    assert base_units("N m") == {"kg": 1, "m": 2, "s": -2}
    assert base_units("m/s2") == {"m": 1, "s": -2}
    assert base_units("furlong") is None


def test_the_command_writes_a_unit(tmp_path, monkeypatch, capsys):
    pytest.importorskip("pythonfmu3")
    from flexmb.cli import main

    monkeypatch.chdir(tmp_path)
    fmb.save_model(four_bar(), "four_bar.toml", SETTINGS)
    assert main(["fmu", "four_bar.toml"]) == 0
    told = capsys.readouterr().out
    assert "Inputs: torque" in told
    assert "crank.angle, pin.fx" in told
    with zipfile.ZipFile("four_bar.fmu") as unit:
        assert "modelDescription.xml" in unit.namelist()


TWICE = """
import sys
import flexmb as fmb

model = fmb.Model(bodies=[fmb.PointMass("stone", mass=1.0)])
for _ in range(2):
    try:
        fmb.fmi.cosimulate(model, fmb.fmi.Fmu(sys.argv[1]), 0.02, step=0.01)
        print("went", flush=True)
    except fmb.ModelError as error:
        print(error, flush=True)
"""


def test_a_unit_that_would_end_the_process_is_refused(tmp_path):
    """The library of PythonFMU 0.7 crashes (signal 11) where a unit of FMI 2 is loaded for the second time."""
    pytest.importorskip("fmpy")
    pytest.importorskip("pythonfmu")
    path = fmb.fmi.write_fmu(four_bar(), tmp_path / "four_bar.fmu", settings=SETTINGS, version=2)
    run = subprocess.run([sys.executable, "-c", TWICE, str(path)], capture_output=True, text=True, timeout=300)
    # PythonFMU 0.7 gives up objects of Python once too often: the process may end with signal 11 when Python exits
    assert run.stdout.startswith("went"), run.stderr
    assert "was loaded in this process before" in run.stdout
