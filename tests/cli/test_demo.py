"""`flexmb demo`: the flap station from mesh to ParaView.

Reference: high-lift data set "widebody_highlift" 1.0, outcomes 5.1 and 5.3: the flap angle is zero retracted and at
0.52 of the drive's travel, dips to -2.5 deg between and ends at 38 deg (rigid linkage); the strut is in compression,
-51 kN at most, the pendulum carries 68 kN (quasi-static).
"""

import csv
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli import main
from flexmb.cli.demo import _compile_ahead
from flexmb.cli.run_folder import open_run
from flexmb.integrate.runs import ahead_of_run
from flexmb.math.jets import run_program
from flexmb.system.program import row_kernels


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
    # it begins at rest in equilibrium: nothing rings; below a progress of 0.15 the small force changes its sign
    assert np.abs(np.diff(strut[:4])).max() < 500.0
    assert strut.max() == pytest.approx(strut[0], abs=1.0)
    assert solution["lever stress"][0] > 1e6
    assert fmb.statics(solution.model)["strut force"][-1, 0] == pytest.approx(strut[0], rel=1e-3)
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


@pytest.mark.slow
def test_mesh_and_mechanism_follow_one_parameter(demo, capsys):
    """A lever of 0.7 m: the bores of the mesh are 0.7 m apart, the strut hangs on the longer lever, nothing is open."""
    station = str(demo / "flap_station.toml")
    assert main(["check", station, "--set", "lever_length=0.7"]) == 0
    out = capsys.readouterr().out
    assert "mobility 18" in out
    assert "Warning" not in out
    assert "assembly moved" not in out
    model = fmb.load_model(station, {"lever_length": 0.7})
    data = model.body("lever").data
    root, tip = data.marker_positions
    assert np.linalg.norm(tip - root) == pytest.approx(0.7, abs=1e-7)
    assert np.ptp(data.nodes[:, 0]) - np.ptp(fmb.load_model(station).body("lever").data.nodes[:, 0]) == pytest.approx(
        0.1
    )
    rigid = fmb.load_model(station, {"lever_length": 0.7, "lever_is_rigid": True})
    assert fmb.kinematics(rigid, 1.0, samples=21).status.ok


def test_the_station_can_be_varied(demo):
    rigid = fmb.load_model(demo / "flap_station.toml", {"lever_is_rigid": True})
    assert fmb.check(rigid).mobility == 0


def test_pyvista_reads_the_motion(demo):
    """Frames at 0, 0.5 and 1 s: the lever's nodes and stress are there, and the flap is where its sensor says."""
    import pyvista

    reader = pyvista.get_reader(demo / "flap_station.pvd")
    solution = open_run(demo / "run")
    assert len(reader.time_values) == 51
    for t in (0.0, 0.5, 1.0):
        reader.set_active_time_value(t)
        blocks = {block.n_points: block for block in reader.read()}
        lever = blocks[5042]
        assert lever.n_cells == 2522
        k = int(np.argmin(np.abs(solution.t - t)))
        assert lever["von_mises"].max() == pytest.approx(solution["lever stress"][k], rel=1e-5)
        nose = solution[fmb.Position("nose", marker="flap.nose")][k]
        edge = nose + 2.35 * np.array([np.cos(a := solution["flap angle"][k]), 0.0, -np.sin(a)])
        reached = min(np.abs(block.points[:, [0, 2]] - edge[[0, 2]]).max(axis=1).min() for block in blocks.values())
        assert reached < 1e-5


READ = """
import sys
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.vtkIOHDF import vtkHDFReader
xml = vtkXMLUnstructuredGridReader()
xml.SetFileName(sys.argv[1])
xml.Update()
hdf = vtkHDFReader()
hdf.SetFileName(sys.argv[2])
hdf.UpdateInformation()
hdf.SetStep(hdf.GetNumberOfSteps() - 1)
hdf.Update()
for grid in (xml.GetOutput(), hdf.GetOutputDataObject(0)):
    stress = grid.GetPointData().GetArray("von_mises")
    print(grid.GetNumberOfPoints(), grid.GetNumberOfCells(), stress.GetRange()[1])
print(hdf.GetNumberOfSteps())
"""


def test_a_vtk_process_reads_both_formats(demo):
    """The last frame of the lever, by VTK's own readers in a process of their own: VTU and VTKHDF say the same."""
    files = [str(demo / "flap_station" / "lever_50.vtu"), str(demo / "flap_station_lever.vtkhdf")]
    child = subprocess.run([sys.executable, "-c", READ, *files], capture_output=True, text=True, check=True)
    vtu, hdf, steps = (line.split() for line in child.stdout.splitlines())
    assert vtu == hdf
    assert vtu[:2] == ["5042", "2522"]
    assert steps == ["51"]
    assert float(vtu[2]) == pytest.approx(open_run(demo / "run")["lever stress"][-1], rel=1e-5)


def test_size_on_disk(demo):
    """The motion for ParaView is smaller than the reduced body that it shows."""
    size = {name: sum(f.stat().st_size for f in (demo / name).rglob("*")) for name in ("flap_station", "run")}
    assert size["flap_station"] < (demo / "lever.h5").stat().st_size
    assert size["run"] < 3 * (demo / "lever.h5").stat().st_size


@pytest.mark.render
def test_picture(demo):
    """Retracted, middle and extended: nothing is cut off at the sides, the lever shows the colours of its stress."""
    from matplotlib.image import imread

    picture = imread(demo / "flap_station.png")[:, :, :3]
    assert picture.shape == (900, 1600, 3)
    border = np.concatenate([picture[:, :8], picture[:, -8:]], axis=1)
    assert np.ptp(border, axis=1).max() < 0.02  # the mechanism does not touch the sides
    saturation = picture.max(axis=2) - picture.min(axis=2)
    assert (saturation[:700] > 0.5).sum() > 2000  # above the scale: on the lever


def test_table_and_timings(tmp_path, capsys, monkeypatch, demo):
    """What is printed: progress, angle, strut force, torque and stress; the file to open; cold or warm, by stage."""
    from flexmb.cli.demo import _Clock, _table

    lines = _table(open_run(demo / "run"))
    head = " ".join(lines[0].split())
    assert head.startswith("t [s] progress [-] lever [deg] flap [deg] strut [kN]")
    assert head.endswith("torque [kN m] lever stress [MPa]")
    assert len(lines) == 12
    assert lines[-1].split()[1] == "1.000"
    clock = _Clock()
    clock.stop("reduction")
    assert "warm: kernels from the cache" in str(clock)
    clock.compiling = lambda: 7.0
    assert "cold: 7.0 s of it compiling" in str(clock)


def test_what_is_compiled_ahead_is_what_the_model_holds(demo, monkeypatch):
    """The kernels are named before the model is there; a kind too few would be compiled by one process alone."""
    named = []
    monkeypatch.setattr(ahead_of_run, "compile_ahead", lambda *given: named.extend(given[1]))
    _compile_ahead()
    model = open_run(demo / "run").model
    equations = (equation for joint in model.joints for equation in joint.equations_in(model))
    assert set(row_kernels(part.table for part in (*model.bodies, *equations, *model.forces))) < set(named)
    assert run_program in named


def test_a_changed_model_is_not_overwritten(tmp_path, capsys):
    changed = tmp_path / "flap_station.toml"
    changed.write_text("# mine\n")
    assert main(["demo", "--out", str(tmp_path)]) != 0
    assert "flap_station.toml in it was changed" in capsys.readouterr().err
    assert changed.read_text() == "# mine\n"
