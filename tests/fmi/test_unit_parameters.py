"""Parameters of units: what a host sets before the start is what the model has."""

import subprocess
import sys

import pytest

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


PLACES = {"k": "spring.stiffness", "m": "mass.mass"}


@pytest.mark.parametrize("version", [3, 2])
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
