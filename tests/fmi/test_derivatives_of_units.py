"""What a host gets of the derivatives of an exported unit: the linear plant and differences of steps, nothing more."""

import subprocess
import sys
import zipfile

import numpy as np
import pytest
from by_turns import slow
from scipy.io import loadmat
from scipy.linalg import expm

import flexmb as fmb

STEP, MOMENT, WEIGHT, ARM = 0.1, 1e-3, 2.0 * 9.81, 0.5

HOST = """
import sys
import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

path, folder, version, step, moment = sys.argv[1], sys.argv[2], *(float(x) for x in sys.argv[3:])
about = fmpy.read_model_description(path)
number = {v.name: v.valueReference for v in about.modelVariables}
unit = (FMU3Slave if version == 3 else FMU2Slave)(
    guid=about.guid, unzipDirectory=fmpy.extract(path, folder), modelIdentifier=about.coSimulation.modelIdentifier,
    instanceName="one")
unit.instantiate()
if version == 3:
    unit.enterInitializationMode(startTime=0.0)
    get, give = unit.getFloat64, unit.setFloat64
else:
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    get, give = unit.getReal, unit.setReal
unit.exitInitializationMode()
try:
    print("derivative", unit.getDirectionalDerivative([number["angle"]], [number["torque"]], [1.0]))
except Exception as error:
    print("refused", getattr(error, "status", ""))
state, ends = unit.getFMUState(), []
for value in (moment, -moment):
    unit.setFMUState(state)
    give([number["torque"]], [value])
    unit.doStep(0.0, step)
    ends.append(get([number["angle"]])[0])
print(float.hex((ends[0] - ends[1]) / (2.0 * moment)), flush=True)
"""


def pendulum() -> fmb.Model:
    """Return a rod that hangs at rest, with a torque from outside."""
    across = fmb.Pose.axes(z=(0, 1, 0))
    rod = fmb.RigidBody(
        "rod",
        mass=2.0,
        inertia=(0.2, 0.2, 0.01),
        at=(0, 0, -ARM),
        markers={"top": fmb.Pose.axes((0, 0, ARM), z=(0, 1, 0))},
    )
    return fmb.Model(
        bodies=[fmb.Ground(markers={"y": across}), rod],
        joints=[fmb.Revolute("hinge", markers=("ground.y", "rod.top"))],
        forces=[fmb.Actuator("motor", joint="hinge", effort=fmb.input("torque"))],
        sensors=[fmb.JointCoordinate("angle", joint="hinge")],
        gravity=(0, 0, -9.81),
    )


@pytest.mark.parametrize("version", [3, slow(2)])
def test_binary_refuses_and_differences_of_steps_are_the_plant(version, tmp_path):
    """d angle(h) / d torque of a step is (1 - cos w h) / (m g a), of the unit, and of the plant that it holds."""
    pytest.importorskip("fmpy")
    pytest.importorskip({3: "pythonfmu3", 2: "pythonfmu"}[version])
    plant = fmb.linearize(pendulum(), inputs="motor.effort", outputs="angle")
    settings = fmb.Simulation(t_end=1.0, integrator=fmb.Explicit(rtol=1e-10, atol=1e-12))
    path = fmb.fmi.write_fmu(pendulum(), tmp_path / "rod.fmu", settings=settings, version=version, plant=plant)
    given = [str(path), str(tmp_path / "unit"), str(version), str(STEP), str(MOMENT)]
    run = subprocess.run([sys.executable, "-c", HOST, *given], capture_output=True, text=True, timeout=300)
    lines = run.stdout.split("\n")
    assert any(line.startswith("refused") for line in lines), run.stdout + run.stderr
    assert not any(line.startswith("derivative") for line in lines)
    if version == 3:  # the compiled part answers by itself: pythonfmu3, fmi_functions.cpp
        assert "FMI function not supported: fmi3GetDirectionalDerivative" in run.stdout + run.stderr
    of_unit = next(float.fromhex(line) for line in lines if "0x" in line)

    frequency = np.sqrt(WEIGHT * ARM / (0.2 + 2.0 * ARM**2))
    exact = (1.0 - np.cos(frequency * STEP)) / (WEIGHT * ARM)
    assert of_unit == pytest.approx(exact, rel=1e-5)
    with zipfile.ZipFile(path) as unit:
        (tmp_path / "plant.mat").write_bytes(unit.read("resources/plant.mat"))
        about = unit.read("modelDescription.xml").decode()
    kept = loadmat(tmp_path / "plant.mat")
    A, B, C = (kept[name] for name in "ABC")
    whole = expm(STEP * np.block([[A, B], [np.zeros((B.shape[1], A.shape[0] + B.shape[1]))]]))
    assert (C @ whole[: len(A), len(A) :]).item() == pytest.approx(exact, rel=1e-9)
    assert "No directional derivatives" in about
    assert 'providesDirectionalDerivative="true"' not in about
    assert 'providesDirectionalDerivatives="true"' not in about
