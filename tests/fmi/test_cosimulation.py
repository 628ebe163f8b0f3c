"""Models beside units of other programs: here a controller that is built with PythonFMU3."""

import os
import subprocess
import sys

import numpy as np
import pytest

import flexmb as fmb

pytest.importorskip("fmpy")
pythonfmu3 = pytest.importorskip("pythonfmu3")

CONTROLLER = """
from pythonfmu3 import Fmi3Slave, Float64, Fmi3Causality, Fmi3Variability


class {name}(Fmi3Slave):
    def __init__(self, **given):
        super().__init__(**given)
        self.measured, self.u, self.gain = 0.0, 0.0, 1.0
        kind = Fmi3Variability.continuous
        self.register_variable(Float64("measured", causality=Fmi3Causality.input, variability=kind))
        self.register_variable(
            Float64("gain", causality=Fmi3Causality.parameter, variability=Fmi3Variability.fixed)
        )
        self.register_variable(Float64("u", causality=Fmi3Causality.output, variability=kind))

    def do_step(self, current_time, step_size):
        self.u = {law}
        from pythonfmu3.fmi3slave import Fmi3StepResult

        return Fmi3StepResult()
"""


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    """Return a function that builds a controller of a law."""
    from pythonfmu3.builder import FmuBuilder

    def build(name: str, law: str):
        folder = tmp_path_factory.mktemp(name)
        script = folder / f"{name.lower()}.py"
        script.write_text(CONTROLLER.format(name=name, law=law), encoding="utf-8")
        return FmuBuilder.build_FMU(script, dest=folder / "built")

    return build


def slider() -> fmb.Model:
    """A mass that is pushed along x."""
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("mass", mass=2.0, at=(0.3, 0, 0))],
        forces=[fmb.PointLoad("push", marker="mass.center", force=(fmb.input("force"), 0, 0))],
        sensors=[fmb.Position("place", marker="mass.center")],
        gravity=(0, 0, 0),
    )


@pytest.mark.parametrize("name", ["place x", "place x [m]", "place.x"])
def test_a_controller_in_a_unit_is_the_controller_in_python(unit, name):
    controller = fmb.fmi.Fmu(
        unit("Proportional", "-self.gain * self.measured"),
        inputs={"measured": name},
        outputs={"force": "u"},
        parameters={"gain": 8.0},
    )
    solution = fmb.fmi.cosimulate(slider(), controller, 2.0, step=0.05, integrator=fmb.Explicit())
    with fmb.stepper(slider(), integrator=fmb.Explicit(), t_end=2.0) as run:
        force, places = 0.0, [run["place"][0]]
        for t in solution.t[1:]:
            run.set("force", force)
            force = -8.0 * run["place"][0]
            run.advance(to=t)
            places.append(run["place"][0])
    np.testing.assert_allclose(solution["place"][:, 0], places, atol=1e-14)
    # the force is late by one step and held for another: x(k+1) = x(k) + h v(k) + h^2/2m f(k-1), exactly
    x, v, f, h, seen = 0.3, 0.0, 0.0, 0.05, [0.3]
    for _ in range(40):
        x, v, f = x + h * v + h * h * f / 4.0, v + h * f / 2.0, -8.0 * x
        seen.append(x)
    np.testing.assert_allclose(places, seen, atol=1e-12)


def test_an_end_that_is_no_multiple_of_the_step_is_met(unit):
    solution = fmb.fmi.cosimulate(slider(), fmb.fmi.Fmu(unit("Nothing", "0.0")), 0.5, step=0.2)
    np.testing.assert_allclose(solution.t, [0.0, 0.2, 0.4, 0.5])


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"inputs": {"measurd": "place x"}}, "no input 'measurd'.*Did you mean 'measured'"),
        ({"inputs": {"measured": "place w"}}, "no sensor 'place w'.*place x, place y, place z"),
        ({"inputs": {"measured": "place"}}, "sensor 'place' has 3 columns.*place x, place y, place z"),
        ({"inputs": {"measured": "place x [mm]"}}, r"'place x \[mm\]'.*\[m\].*not converted"),
        ({"outputs": {"forse": "u"}}, "input 'forse' does not exist.*force"),
        ({"outputs": {"force": "v"}}, "no output 'v'.*one of: u"),
        ({"parameters": {"gian": 1.0}}, "no input 'gian'.*gain"),
    ],
)
def test_names_that_do_not_exist_are_said_before_the_run(unit, given, said):
    with pytest.raises(fmb.ModelError, match=said):
        fmb.fmi.cosimulate(slider(), fmb.fmi.Fmu(unit("Named", "0.0"), **given), 0.1, step=0.05)


def test_units_that_fail_are_named_and_results_kept(unit):
    late = "1.0 / 0.0 if current_time > 0.12 else 0.0"
    for name, law, said in (("Failing", late, "Failing"), ("Nan", "float('nan')", r"u = nan at t = 0\.05 s")):
        controller = fmb.fmi.Fmu(unit(name, law), outputs={"force": "u"})
        with pytest.raises(fmb.IntegrationError, match=said) as raised:
            fmb.fmi.cosimulate(slider(), controller, 0.5, step=0.05)
        assert len(raised.value.solution.t) >= 2


FAILING = """
import sys
import flexmb as fmb

model = fmb.Model(
    bodies=[fmb.PointMass("mass", mass=2.0)],
    forces=[fmb.PointLoad("push", marker="mass.center", force=(fmb.input("force"), 0, 0))],
)
for _ in range(3):
    try:
        fmb.fmi.cosimulate(model, fmb.fmi.Fmu(sys.argv[1], outputs={"force": "u"}), 0.5, step=0.1)
    except fmb.IntegrationError as error:
        print("status 4" in str(error), flush=True)
"""


def test_a_unit_that_failed_for_good_is_left_alone(unit):
    """FMI 3.0.1, 2.2.2: after "fatal" nothing may be called. PythonFMU3 would use the object that it has released."""
    path = unit("Fatal", "1.0 / 0.0 if current_time > 0.12 else 0.0")
    overwritten = os.environ | {"PYTHONMALLOC": "malloc", "GLIBC_TUNABLES": "glibc.malloc.perturb=165"}
    run = subprocess.run(
        [sys.executable, "-c", FAILING, str(path)], capture_output=True, text=True, timeout=300, env=overwritten
    )
    assert run.stdout.count("True") == 3, run.stderr
    assert run.returncode == 0, run.stderr


def test_files_that_are_no_units(tmp_path):
    with pytest.raises(fmb.DataFileError, match="no such file"):
        fmb.fmi.cosimulate(slider(), fmb.fmi.Fmu(tmp_path / "none.fmu"), 0.1, step=0.05)
    (tmp_path / "junk.fmu").write_bytes(b"PK junk")
    with pytest.raises(fmb.DataFileError, match="cannot be read"):
        fmb.fmi.cosimulate(slider(), fmb.fmi.Fmu(tmp_path / "junk.fmu"), 0.1, step=0.05)
    with pytest.raises(fmb.ModelError, match="positive step"):
        fmb.fmi.cosimulate(slider(), [], 0.1, step=0.5)
