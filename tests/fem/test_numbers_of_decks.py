"""Numbers, sets and warnings of a deck go with the model through reduction, files, sensors, reports and ParaView."""

from importlib import import_module

import h5py
import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, io, reduction
from flexmb.errors import MeshError, ModelError, ReductionError
from flexmb.model.numbering import Numbering

PLATE = """BEGIN BULK
{grids}
{cells}
GRID,9001,,0.,.5,.1
RBE2,31,9001,123456,{left}
GRID,9002,,1.,.5,.1
RBE3,32,,9002,123456,1.,123456,{right}
CONM2,77,9001,,2.
CROD,88,5,2063,9003
CROD,89,5,{top},9003
CROD,90,5,{far},9003
GRID,9003,,0.,.5,.4
CONM2,78,9003,,.001
PROD,5,1,1.-4,1.-9
PSHELL,4,1,.01,1,,1
MAT1,1,7.+10,,.3,2700.
PCOMPLEX,4
SET1,12,2063,2064
CGAP,99,1,2063,2064
ENDDATA
"""
N = 4


def plate(tmp_path, name="plate.bdf"):
    """A plate of 4 x 4 shells whose nodes are numbered 2063, 2066, ... and its elements 501, 511, ..."""
    label = lambda i, j: 2063 + 3 * (i + (N + 1) * j) if (i, j) != (1, 0) else 2064  # noqa: E731
    grids = [f"GRID,{label(i, j)},,{i / N},{j / N},0." for j in range(N + 1) for i in range(N + 1)]
    corners = [(label(i, j), label(i + 1, j), label(i + 1, j + 1), label(i, j + 1)) for j in range(N) for i in range(N)]
    cells = [f"CQUAD4,{501 + 10 * k},4,{','.join(map(str, c))}" for k, c in enumerate(corners)]
    sides = [",".join(str(label(i, j)) for j in range(N + 1)) for i in (0, N)]
    right = sides[1].replace(",", ",+\n+,", 2)  # one number in the first line, one in the second, three in the third
    text = PLATE.format(
        grids="\n".join(grids), cells="\n".join(cells), left=sides[0], right=right, top=label(0, N), far=label(N, 2)
    )
    path = tmp_path / name
    path.write_text(text)
    return path, label


@pytest.fixture(scope="module")
def reduced(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plate")
    path, label = plate(folder)
    with pytest.warns(fem.MeshWarning, match="left out: CGAP"):
        fe = fem.read_deck(path, show=False, lumped=False)
    data = reduction.reduce(fe, "all", 4)
    return fe, fmb.ModalNeutralData.load(data.save(folder / "plate.h5")), label


def test_numbers_survive_the_file(reduced):
    fe, data, label = reduced
    at = int(np.argmin(np.linalg.norm(data.nodes - (0.75, 0.5, 0.0), axis=1)))
    assert data.node_name(at) == f"node {label(3, 2)} of the deck"
    assert fe.node_name(at) == data.node_name(at)
    np.testing.assert_array_equal(data.nodes_named(f"node {label(3, 2)}", "x"), [at])
    np.testing.assert_array_equal(data.nodes_named(f"node {label(3, 2)} of the deck", "x"), [at])
    of_element = data.nodes[data.nodes_named("element 511", "x")]  # the second element: x from 1/4 to 1/2
    np.testing.assert_allclose([of_element.min(axis=0), of_element.max(axis=0)], [[0.25, 0, 0], [0.5, 0.25, 0]])
    assert [len(cells) for _, cells in data.cells] == [len(labels) for labels in data.numbering.cells]


def test_sets_of_the_deck_are_places_of_stress(reduced):
    _, data, label = reduced
    np.testing.assert_array_equal(np.sort(data.numbering.nodes[data.node_sets["set_12"]]), [label(0, 0), label(1, 0)])
    assert len(data.node_sets["pid_4"]) == (N + 1) ** 2
    body = fmb.FloatingBody("plate", data=data)
    model = fmb.Model(bodies=[fmb.Ground(), body], gravity=(0, 0, -9.81))
    solution = fmb.simulate(model, t_end=0.01, samples=3)
    eta = solution.series(0).modal_coordinates("plate")
    at = data.nodes_named("element 511", "x")
    sigma = np.einsum("ncm,tm->tnc", data.stress_modes[at], eta)
    for node in ("element 511", ["element 511"], at.tolist()):
        found = solution[fmb.Stress("s", body="plate", node=node, component="xx")]
        np.testing.assert_allclose(found, sigma[:, :, 0].max(axis=1), rtol=1e-9, atol=1e-9)
    one = solution[fmb.Stress("s", body="plate", node=f"node {label(3, 2)}", component="tensor")]
    assert one.shape == (3, 6)


@pytest.mark.parametrize(
    ("node", "words"),
    [
        ("set_13", r"'set_13', which is no set of 'plate'.*Did you mean 'set_12'"),
        ("node 7", r"'node 7', which the deck does not have.*2063 to 9003"),
        ("element 502", r"the deck does not have.*numbers of elements"),
        ("node 9003", r"node 9003 of the deck, at which no element gives stress.*nodes of solids or shells"),
        ("element 89", r"'element 89', a beam, rod or spring, which has no stress modes"),
        (["element 511", "element 89"], r"'element 89', a beam, rod or spring"),
        (4711, r"node = 4711.*the name of a set"),
    ],
)
def test_places_that_are_not_there(reduced, node, words):
    _, data, _ = reduced
    model = fmb.Model(bodies=[fmb.Ground(), fmb.FloatingBody("plate", data=data)])
    with pytest.raises(ModelError, match=words):
        fmb.Stress("s", body="plate", node=node).check(model)


def test_interfaces_by_numbers_of_the_deck(reduced):
    fe, data, label = reduced
    data = reduction.reduce(fe, {"tip": f"node {label(4, 4)}"}, 2, stations={"mid": "element 511"})
    np.testing.assert_allclose(data.marker_positions, [[1, 1, 0], [0.375, 0.125, 0]], atol=1e-12)
    assert data.quality["interfaces"][0]["node"] == f"node {label(4, 4)} of the deck"
    with pytest.raises(ReductionError, match="'node 5', which the deck does not have"):
        reduction.reduce(fe, {"tip": "node 5"}, 2)


def test_an_interface_of_several_names(reduced):
    """A list of names was refused, though Stress and stations took one; the rigid line moves about its centre."""
    fe, _, label = reduced
    names = [f"node {label(i, 2)}" for i in (1, 2, 3)]
    data = reduction.reduce(fe, {"line": names, "tip": ["node " + str(label(4, 4))]}, 2)
    np.testing.assert_allclose(data.marker_positions, [[0.5, 0.5, 0], [1, 1, 0]], atol=1e-12)
    with pytest.raises(ReductionError, match="'node 5', which the deck does not have"):
        reduction.reduce(fe, {"line": [*names, "node 5"]}, 2)


def test_warnings_and_inventory_reach_the_reports(reduced, tmp_path):
    _, data, _ = reduced
    told = [text for text in data.quality["warnings"] if "CGAP" in text]
    assert len(told) == 1
    assert data.quality["source"]["read"]["CQUAD4"] == N * N
    assert data.quality["source"]["program"] == "Nastran"
    assert "Nastran deck 'plate.bdf'" in data.report()
    assert "node 9001 of the deck" in data.report()
    page, numbers = io.write_report(data, tmp_path / "plate.html")
    assert "CGAP" in page.read_text()
    assert "CGAP" in numbers.read_text()
    model = fmb.Model(bodies=[fmb.Ground(), fmb.FloatingBody("plate", data=data)], gravity=(0, 0, -9.81))
    solution = fmb.simulate(model, t_end=0.01, samples=3)
    text = fmb.view.report({"run": solution}, tmp_path / "run.html", pictures=False).read_text()
    assert "CGAP" in text
    assert " of the deck" in text  # the place of the largest stress


def test_warnings_of_meshes_go_on_with_them(tmp_path):
    """Each time, whatever the filters of the module `warnings` have shown before."""
    mesh = fem.Mesh(points=np.array([[0, 0, 0], [900.0, 0, 0]]), cells=(("line", np.array([[0, 1]])),))
    steel, tube = fmb.MATERIALS["steel"], fem.Section.tube(50.0, 5.0)
    for _ in range(2):
        with pytest.warns(fem.MeshWarning, match="must be metres"):
            fe = fem.frame(mesh=mesh, section=tube, material=steel)
        assert "must be metres" in fe.warnings[0]
        assert "must be metres" in reduction.reduce(fe, {"a": [0], "b": [1]}, 0).quality["warnings"][0]


def test_old_files_have_no_sets(reduced, tmp_path):
    _, data, _ = reduced
    path = data.save(tmp_path / "old.h5")
    with h5py.File(path, "r+") as file:
        del file["node_sets"], file["numbering"]
    old = fmb.ModalNeutralData.load(path)
    assert old.numbering is None
    assert old.node_name(3) == "node 3"
    with pytest.raises(ModelError, match="reduce the part again"):
        old.nodes_named("set_12", "x")


def test_numbers_in_paraview_files(reduced, tmp_path):
    import pyvista

    _, data, _ = reduced
    model = fmb.Model(bodies=[fmb.Ground(), fmb.FloatingBody("plate", data=data)], gravity=(0, 0, -9.81))
    solution = fmb.simulate(model, t_end=0.01, samples=3)
    fmb.write_vtk(solution, tmp_path / "run.pvd")
    grid = pyvista.read(tmp_path / "run" / "plate_1.vtu")
    np.testing.assert_array_equal(grid.point_data["node"], data.numbering.nodes)
    np.testing.assert_array_equal(grid.cell_data["element"], np.concatenate(data.numbering.cells))
    fmb.write_vtk(solution, tmp_path / "run.vtkhdf")
    for kind, path in (("vtkIOHDF.vtkHDFReader", "run_plate.vtkhdf"), ("vtkIOXdmf2.vtkXdmfReader", "run.xdmf")):
        module, _, name = kind.partition(".")
        reader = getattr(import_module(f"vtkmodules.{module}"), name)()
        reader.SetFileName(str(tmp_path / path))
        reader.UpdateInformation()
        reader.UpdateTimeStep(0.01)
        found = pyvista.wrap(reader.GetOutputDataObject(0))
        grid = found[0] if path.endswith("xdmf") else found
        np.testing.assert_array_equal(grid.point_data["node"], data.numbering.nodes)
        np.testing.assert_array_equal(grid.cell_data["element"], np.concatenate(data.numbering.cells))
    reader = pyvista.get_reader(io.write_modes(data, tmp_path / "modes.pvd"))
    np.testing.assert_array_equal(reader.read()[0].point_data["node"], data.numbering.nodes)


def test_instances_number_their_nodes_by_themselves(tmp_path):
    text = """*PART, NAME=Bar
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
*ELEMENT, TYPE=B31, ELSET=all
7, 1, 2
*BEAM SECTION, ELSET=all, MATERIAL=Alloy, SECTION=RECT
.1, .1
0., 1., 0.
*END PART
*ASSEMBLY, NAME=a
*INSTANCE, NAME=Left, PART=Bar
*END INSTANCE
*INSTANCE, NAME=Right, PART=Bar
1., 0., 0.
*END INSTANCE
*END ASSEMBLY
*MATERIAL, NAME=Alloy
*ELASTIC
7.e10, .3
*DENSITY
2700.
"""
    path = tmp_path / "two.inp"
    path.write_text(text)
    fe = fem.read_deck(path, show=False)
    assert [fe.node_name(k) for k in range(4)] == [
        f"node {name}.{k} of the deck" for name in ("Left", "Right") for k in (1, 2)
    ]
    cells = tuple(block.connectivity for block in fe.blocks if len(block.connectivity))
    np.testing.assert_array_equal(fe.numbering.nodes_of("element right.7", cells, "x"), [2, 3])
    with pytest.raises(MeshError, match=r"2 instances use.*Left, Right"):
        fe.numbering.nodes_of("node 2", cells, "x", MeshError)
    np.testing.assert_array_equal(fe.node_sets["Right"], [2, 3])
    np.testing.assert_array_equal(fe.node_sets["Alloy"], [0, 1, 2, 3])


def test_numbers_of_parts_and_of_joined_models(tmp_path):
    path, label = plate(tmp_path)
    mesh = fem.read_mesh(path.with_name("plate.bdf"))
    skin = fem.shell(mesh, fmb.MATERIALS["aluminium"], 0.01)
    assert skin.node_name(0) == f"node {label(0, 0)} of the deck"
    halves = fem.split(skin, at=(0.5,))
    assert {halves[1].node_name(k) for k in range(len(halves[1].nodes))} == {
        f"node {label(i, j)} of the deck" for i in range(2, 5) for j in range(5)
    }
    other = fem.frame([(1, 0, 0), (2, 0, 0)], section=fem.Section.tube(0.05, 0.002), material=fmb.MATERIALS["steel"])
    both = fem.joined(skin, other)
    names = [both.node_name(k) for k in range(len(both.nodes))]
    assert f"node {label(4, 0)} of the deck" in names
    assert sum("deck" not in name for name in names) == 1  # the far end of the beam
    assert Numbering(nodes=np.array([0, 5])).node_name(0) == "node 0"
