"""VTK files are read back by VTK's own readers, in another process, and hold the values of the formula exactly.

The outside references are VTK's XML, VTKHDF and (legacy) XDMF readers; values are compared as float32, bit by bit.
"""

import subprocess
import sys
from dataclasses import replace
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest
import pyvista
from fem.structured import CELL_TYPES, structured
from results.every_cell import every_cell_data
from results.spinning import observe, spinning_model, spinning_phase, spinning_system, split
from tolerances import MACHINE

from flexmb.errors import DataFileError, MeshError, ModelError
from flexmb.io import solids
from flexmb.io.cell_types import flat_cells, skin_cells
from flexmb.io.scene import Scene
from flexmb.io.vtk_output import write_vtk
from flexmb.io.vtu import write_collection
from flexmb.model.model import Model
from flexmb.results import Solution, recover

READER = """
import sys
import numpy as np
import vtkmodules.vtkCommonDataModel
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
from vtkmodules.util.numpy_support import vtk_to_numpy

kind, path, time, out = sys.argv[1:]
if kind == "vtu":
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader as Reader
elif kind == "hdf":
    from vtkmodules.vtkIOHDF import vtkHDFReader as Reader
else:
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader as Reader
reader = Reader()
reader.SetFileName(path)
reader.UpdateInformation()
times = reader.GetOutputInformation(0).Get(Pipeline.TIME_STEPS())
reader.UpdateTimeStep(float(time))
output = reader.GetOutputDataObject(0)
several = hasattr(output, "GetNumberOfBlocks")
blocks = [output.GetBlock(k) for k in range(output.GetNumberOfBlocks())] if several else [output]
arrays = {}
for k, grid in enumerate(blocks):
    arrays[f"{k}/points"] = vtk_to_numpy(grid.GetPoints().GetData())
    arrays[f"{k}/connectivity"] = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    arrays[f"{k}/types"] = np.array([grid.GetCellType(c) for c in range(grid.GetNumberOfCells())])
    data = grid.GetPointData()
    for a in range(data.GetNumberOfArrays()):
        arrays[f"{k}/{data.GetArrayName(a)}"] = vtk_to_numpy(data.GetArray(a))
np.savez(out, times=np.array(times if times else []), **arrays)
"""


def read(kind, path, time, folder):
    """Read a file in another process by VTK's reader; its complaints go to stderr, which stays empty."""
    out = folder / "read.npz"
    child = subprocess.run(
        [sys.executable, "-c", READER, kind, str(path), repr(float(time)), str(out)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert child.returncode == 0, child.stderr
    assert "ERR" not in child.stderr
    with np.load(out) as arrays:
        return dict(arrays)


@pytest.fixture
def solution(monkeypatch):
    monkeypatch.setattr("flexmb.system.observe", observe, raising=False)
    model = spinning_model()
    bodies = [replace(body, data=every_cell_data()) if body.name == "block" else body for body in model.bodies]
    model = Model(bodies=bodies, joints=model.joints, sensors=())
    return Solution(phases=(spinning_phase(model, t=np.linspace(0, 1, 5)),))


def expected(solution, frame):
    """Points, displacement and von Mises stress of the block by the formulas of recovery."""
    body, phase = solution.model.body("block"), solution.phases[0]
    q = phase.q[[frame], 7:16]
    R = recover.rotation_matrices(q[:, 3:7])[0]
    points = recover.positions(body.data, q)[0]
    elastic = np.array([R @ (body.data.shapes[n] @ q[0, 7:]) for n in range(len(points))])
    mises = recover.von_mises(recover.stress(body.data, q[:, 7:]))[0]
    return points.astype(np.float32), elastic.astype(np.float32), mises.astype(np.float32)


def assert_block(arrays, number, solution, frame, line=3):
    points, elastic, mises = expected(solution, frame)
    connectivity, _, types = flat_cells(solution.model.body("block").data.cells)
    np.testing.assert_array_equal(arrays[f"{number}/connectivity"], connectivity)
    np.testing.assert_array_equal(arrays[f"{number}/types"], np.where(types == 3, line, types))
    # float32 of two summation orders: equal up to the last bit of the largest coordinate
    np.testing.assert_allclose(arrays[f"{number}/points"], points, rtol=0, atol=np.spacing(np.float32(8.0)))
    np.testing.assert_allclose(arrays[f"{number}/displacement"], elastic, rtol=2e-7, atol=1e-9)
    np.testing.assert_allclose(arrays[f"{number}/von_mises"], mises, rtol=2e-7)


@pytest.mark.parametrize("frame", [0, 3])
def test_pvd_and_vtu(solution, tmp_path, frame):
    path = write_vtk(solution, tmp_path / "out" / "spin.pvd")
    assert path == tmp_path / "out" / "spin.pvd"
    arrays = read("vtu", tmp_path / "out" / "spin" / f"block_{frame}.vtu", 0.0, tmp_path)
    assert_block(arrays, 0, solution, frame)


def test_pvd_by_pyvista(solution, tmp_path):
    reader = pyvista.get_reader(write_vtk(solution, tmp_path / "spin.pvd"))
    np.testing.assert_array_equal(reader.time_values, solution.t)
    scene = Scene(solution)
    for frame in (0, 4):
        reader.set_active_time_value(solution.t[frame])
        blocks = reader.read()
        assert len(blocks) == len(scene.parts)
        for block, part in zip(blocks, scene.parts):
            np.testing.assert_array_equal(block.points, scene.snapshot(part, frame).points.astype(np.float32))


def test_pvd_names_are_relative(solution, tmp_path):
    path = write_vtk(solution, tmp_path / "spin.pvd")
    path.parent.rename(tmp_path.parent / (tmp_path.name + "_moved"))
    moved = tmp_path.parent / (tmp_path.name + "_moved") / "spin.pvd"
    assert len(pyvista.get_reader(moved).read()) == 5


@pytest.mark.parametrize("frame", [0, 3])
def test_vtkhdf(solution, tmp_path, frame):
    write_vtk(solution, tmp_path / "spin.vtkhdf")
    arrays = read("hdf", tmp_path / "spin_block.vtkhdf", solution.t[frame], tmp_path)
    np.testing.assert_array_equal(arrays["times"], solution.t)
    assert_block(arrays, 0, solution, frame)


@pytest.mark.parametrize("frame", [0, 3])
def test_xdmf_sidecar(solution, tmp_path, frame):
    path = write_vtk(solution, tmp_path / "spin.vtkhdf")
    assert path.name == "spin.xdmf"
    arrays = read("xdmf", path, solution.t[frame], tmp_path)
    np.testing.assert_array_equal(arrays["times"], solution.t)
    scene = Scene(solution)
    number = [part.name for part in scene.parts].index("block")
    assert_block(arrays, number, solution, frame, line=4)  # XDMF has polylines only
    for k, part in enumerate(scene.parts):
        np.testing.assert_array_equal(arrays[f"{k}/points"], scene.snapshot(part, frame).points.astype(np.float32))


def test_the_mesh_is_stored_once(solution, tmp_path):
    write_vtk(solution, tmp_path / "spin.vtkhdf")
    with h5py.File(tmp_path / "spin_block.vtkhdf") as file:
        root = file["VTKHDF"]
        n = len(solution.model.body("block").data.nodes)
        assert len(root["Types"]) == 8
        assert root["Points"].shape == (5 * n, 3)
        assert root["Points"].dtype == np.float32
        assert root.attrs["Type"] == b"UnstructuredGrid"
        assert list(root.attrs["Version"]) == [2, 0]
        assert list(root["Steps/PointOffsets"]) == [k * n for k in range(5)]


def test_every_nth_sample_and_the_last(solution, tmp_path):
    reader = pyvista.get_reader(write_vtk(solution, tmp_path / "spin.pvd", every=3, stress=False))
    np.testing.assert_array_equal(reader.time_values, solution.t[[0, 3, 4]])
    assert "von_mises" not in reader.read()[1].array_names


def test_a_lost_joint_shrinks_to_nothing(monkeypatch):
    """After the event the glyph of the weld has no size; of the event's two samples the second is drawn."""
    monkeypatch.setattr("flexmb.system.observe", observe, raising=False)
    model = spinning_model()
    later = model.without("weld")
    solution = Solution(phases=split(spinning_phase(model), 5, model=later, system=spinning_system(later)))
    scene = Scene(solution)
    assert len(scene.times) == 11
    joints = scene.part("joints")
    weld = joints.carrier == [c[-1] for c in joints.carriers].index("weld")
    before, after = scene.snapshot(joints, 4).points[weld], scene.snapshot(joints, 5).points[weld]
    assert np.ptp(before, axis=0).min() > 0.01
    assert np.ptp(after, axis=0).max() == 0.0


def test_closed_surfaces():
    """Tubes, boxes and spheres are closed and outward: their volume by the divergence theorem is positive and right."""

    def volume(surface):
        triangles = [surface.triangles, surface.quads[:, [0, 1, 2]], surface.quads[:, [0, 2, 3]]]
        a, b, c = (surface.points[np.vstack(triangles)[:, k]] for k in range(3))
        return np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0

    n = 200  # regular polygon of n sides: area n/2 sin(2 pi/n) r^2
    area = 0.5 * n * np.sin(2 * np.pi / n)
    assert volume(solids.tube((1, 2, 3), (1, 5, 3), 2.0, sides=n)) == pytest.approx(area * 4 * 3, rel=1e-12)
    assert volume(solids.box((1.0, 2.0, 3.0))) == pytest.approx(6.0, rel=1e-12)
    assert volume(solids.sphere(1.5, sides=n)) == pytest.approx(4 / 3 * np.pi * 1.5**3, rel=1e-3)
    assert volume(solids.coil(1.0, 0.1)) > 0.0


def test_messages(solution, tmp_path):
    with pytest.raises(DataFileError, match=r"the ending '.vtk'.*\.pvd, \.vtkhdf.*Use \.pvd"):
        write_vtk(solution, tmp_path / "spin.vtk")
    with pytest.raises(ModelError, match=r"every = 0"):
        write_vtk(solution, tmp_path / "spin.pvd", every=0)
    (tmp_path / "file").write_text("")
    with pytest.raises(DataFileError, match=r"cannot write it.*another folder"):
        write_vtk(solution, tmp_path / "file" / "spin.pvd")
    with pytest.raises(ModelError, match=r"the solution has no model.*read_model"):
        Scene(Solution(phases=(replace(solution.phases[0], model=None),)))
    with pytest.raises(MeshError, match=r"cell type 'polygon'"):
        flat_cells([("polygon", np.zeros((1, 5), int))])


def test_names_are_escaped(tmp_path):
    """A part may be called 'left & "right"'."""
    write_collection(tmp_path / "x.pvd", [(0.0, 0, 'left & "right"', "left.vtu")])
    entry = ElementTree.parse(tmp_path / "x.pvd").getroot().find(".//DataSet")
    assert entry.get("name") == 'left & "right"'
    assert entry.get("timestep") == "0.0"


def test_the_skin_of_a_block(solution, tmp_path):
    """3 x 3 x 3 cells of every solid kind: the nodes on the outer faces, facets that enclose the volume,
    same values.
    """
    for cell_type in CELL_TYPES:
        mesh = structured(cell_type, (3, 3, 3), (1.0, 2.0, 3.0))
        nodes, cells = skin_cells(mesh.cells)
        points = mesh.points[nodes]
        assert np.all(np.isin(points, [0.0]).any(axis=1) | np.isclose(points, [1.0, 2.0, 3.0]).any(axis=1))
        outer = np.isclose(mesh.points, 0.0).any(axis=1) | np.isclose(mesh.points, [1.0, 2.0, 3.0]).any(axis=1)
        assert len(nodes) == outer.sum()
        grid = pyvista.PolyData(
            points,
            faces=np.concatenate(
                [
                    np.column_stack([np.full(len(rows), n), rows[:, :n]]).ravel()
                    for name, rows in cells
                    for n in [3 if name.startswith("tri") else 4]
                ]
            ),
        )
        assert grid.n_open_edges == 0
        assert grid.triangulate().volume == pytest.approx(6.0, rel=1e-6)


def test_surface_only(solution, tmp_path):
    """The same places and stress as in the whole mesh, node by node."""
    whole, skin = (Scene(solution, surface=surface) for surface in (False, True))
    flexible = [part for part in skin.parts if part.look == "flexible"]
    assert flexible
    for part in flexible:
        full = whole.part(part.name)
        chosen = np.arange(len(full.points)) if part.nodes is None else part.nodes
        one, two = skin.snapshot(part, 1), whole.snapshot(full, 1)
        assert np.allclose(one.points, two.points[chosen], rtol=0, atol=MACHINE)
        assert np.allclose(one.displacement, two.displacement[chosen], rtol=0, atol=MACHINE)
        if one.von_mises is not None:
            assert np.allclose(one.von_mises, two.von_mises[chosen], rtol=MACHINE)
        ids = np.array([0, len(part.points) - 1])
        assert np.allclose(skin.points(part, 1, ids, 2.0), whole.points(full, 1, chosen[ids], 2.0), atol=MACHINE)
    target = write_vtk(solution, tmp_path / "skin.pvd", surface=True)
    assert target.is_file()


def test_frames_of_an_earlier_export_are_removed(solution, tmp_path):
    write_vtk(solution, tmp_path / "a.pvd")
    many = len(list((tmp_path / "a").glob("*.vtu")))
    write_vtk(solution, tmp_path / "a.pvd", every=10_000)
    assert len(list((tmp_path / "a").glob("*.vtu"))) < many


def test_joints_are_small_beside_the_parts_of_a_long_model():
    """Thirty links of 1 m: a joint is drawn within 0.2 m, not at a hundredth of 30 m times its glyph."""
    import flexmb as fmb

    rods = [fmb.RigidBody.rod(f"b{k}", length=1.0, mass=1.0, radius=0.05, at=(k, 0, 0)) for k in range(30)]
    ends = ["ground.origin", *(f"b{k}.end" for k in range(29))]
    joints = [fmb.Revolute(f"j{k}", markers=(end, f"b{k}.start")) for k, end in enumerate(ends)]
    model = fmb.Model(bodies=[fmb.Ground(), *rods], joints=joints)
    scene = Scene(fmb.simulate(model, 1e-3, samples=2))
    assert 0.02 < np.abs(scene.part("joints").points).max() < 0.2
