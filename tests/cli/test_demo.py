"""`flexmb demo`: the flap station from mesh to ParaView.

Reference: high-lift data set "widebody_highlift" 1.0, outcomes 5.1 and 5.3: the flap angle is zero retracted and at
0.52 of the drive's travel, dips to -2.5 deg between and ends at 38 deg (rigid linkage); the strut is in compression,
-51 kN at most, the pendulum carries 68 kN (quasi-static).
"""

import csv
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli import main
from flexmb.cli.run_folder import open_run


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """Run the demo once."""
    folder = tmp_path_factory.mktemp("demo")
    assert main(["demo", "--out", str(folder)]) == 0
    return folder


def test_motion(demo):
    solution = open_run(demo / "run")
    assert solution.status.ok
    angle = np.degrees(solution["flap angle"])
    lever = np.degrees(solution["lever angle"])
    assert angle[0] == pytest.approx(0.0, abs=0.01)
    assert angle.min() == pytest.approx(-2.5, abs=0.1)
    assert angle[-1] == pytest.approx(38.0, abs=0.25)
    assert np.sum(np.diff(np.sign(angle[5:])) != 0) == 1
    half = np.interp(0.0, angle[angle.argmin() :], lever[angle.argmin() :])
    assert (half + 40.0) / 117.128438 == pytest.approx(0.52, abs=0.01)
    assert solution["loop closure"].max() < 1e-9


def test_forces(demo):
    solution = open_run(demo / "run")
    strut = solution["strut force"][:, 0]
    assert strut.min() == pytest.approx(-51e3, rel=0.06)
    assert np.all(strut[solution.t > 0.3] < 0.0)
    assert solution["pendulum force"][:, 0].min() == pytest.approx(-68e3, rel=0.03)


def test_energy_balance(demo):
    """Work of drive and loads = change of kinetic, potential and strain energy + dissipation."""
    s = open_run(demo / "run")
    total = s["total energy"] - s["total energy"][0]
    works = s["work of the drive"] + s["work of the airload"] - s["dissipated energy"]
    assert np.abs(total - works).max() < 1e-4 * np.abs(s["work of the airload"]).max()


def test_files(demo):
    names = {p.name for p in demo.iterdir()}
    assert {"flap_station.toml", "lever.h5", "flap_station.pvd", "run"} <= names
    frames = ElementTree.parse(demo / "flap_station.pvd").getroot().iter("DataSet")
    assert all((demo / frame.get("file")).is_file() for frame in frames)
    with (demo / "run" / "sensors.csv").open(newline="") as file:
        assert "flap angle [rad]" in next(csv.reader(file))
    assert fmb.load_model(demo / "run" / "model.toml").name == "flap_station"


def test_the_station_can_be_varied(demo):
    rigid = fmb.load_model(demo / "flap_station.toml", {"lever_is_rigid": True})
    assert fmb.check(rigid).mobility == 0
