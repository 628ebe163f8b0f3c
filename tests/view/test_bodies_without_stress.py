"""Beams have forces and no stress at nodes: they are not shown as if it were 0 MPa, alone or beside a plate.

Reference: the numbers of nodes of each kind of element; the plate's own stress is tested in tests/results.
"""

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

import flexmb as fmb
from flexmb import io, parts, view
from flexmb.io.quality_page import report_numbers

BAR = fmb.fem.Section.rectangle(0.02, 0.02)


def described(name, with_plate):
    mast = parts.Line(
        points=[(0, 0, 0), (0, 0, 1.0)], elements=4, section=BAR, material="steel", nodes={"top": 1.0}, name="mast"
    )
    plate = parts.Plate(
        corners=[(0, 0, 1.0), (0.4, 0, 1.0), (0.4, 0.2, 1.0), (0, 0.2, 1.0)],
        thickness=0.01,
        size=0.1,
        material="steel",
        stress_side=1,
    )
    ends = {"foot": "mast.start", "end": "plate.edge_2" if with_plate else "mast.end"}
    return parts.Part(name=name, pieces=[mast, plate] if with_plate else [mast], interfaces=ends, modes=3, compare=0)


@pytest.fixture(scope="module")
def run():
    bodies = [
        fmb.FloatingBody("mast", data=described("mast", False).reduced()),
        fmb.FloatingBody("sign", data=described("sign", True).reduced(), at=(1.0, 0, 0)),
    ]
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"a": (0, 0, 0), "b": (1.0, 0, 0)}), *bodies],
        joints=[
            fmb.Fixed("a", markers=("ground.a", "mast.foot")),
            fmb.Fixed("b", markers=("ground.b", "sign.foot")),
        ],
        forces=[fmb.PointLoad("wind", marker="mast.end", force=(10.0, 0, 0))],
    )
    return fmb.statics(model)


def test_which_nodes_have_stress(run):
    mast, sign = (run.model.body(name).data for name in ("mast", "sign"))
    assert not mast.has_stress
    assert sign.has_stress
    on_plate = np.unique(np.concatenate([cells.ravel() for kind, cells in sign.cells if kind != "line"]))
    assert set(np.flatnonzero(sign.stressed)) == set(on_plate)
    assert len(on_plate) < len(sign.nodes)


def test_what_is_said(run):
    mast, sign = (run.model.body(name).data for name in ("mast", "sign"))
    assert "its elements are beams, rods or springs, which give no stress at nodes" in mast.report()
    assert "with stress modes" not in mast.report()
    assert "with stress modes" in sign.report()
    assert [report_numbers(data)["stress_modes"] for data in (mast, sign)] == [False, True]


def values(file):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(file))
    reader.Update()
    array = reader.GetOutput().GetPointData().GetArray("von_mises")
    return None if array is None else vtk_to_numpy(array)


def test_files_for_paraview(run, tmp_path):
    fmb.write_vtk(run.last(), tmp_path / "x.pvd")
    files = sorted((tmp_path / "x").glob("mast_*.vtu")), sorted((tmp_path / "x").glob("sign_*.vtu"))
    assert values(files[0][-1]) is None
    found = values(files[1][-1])
    assert np.array_equal(np.isnan(found), ~run.model.body("sign").data.stressed)
    assert np.nanmax(found) > 0.0
    text = view.paraview_script(run.last(), tmp_path / "x.pvd").read_text()
    lines = {
        name: next(line for line in text.splitlines() if line.startswith(f"    ('{name}'")) for name in ("mast", "sign")
    }
    assert lines["mast"].endswith("False),")
    assert lines["sign"].endswith("True),")


def test_modes_for_paraview(run, tmp_path):
    for name, there in (("mast", False), ("sign", True)):
        data = run.model.body(name).data
        io.write_modes(data, tmp_path / f"{name}.pvd")
        found = values(tmp_path / name / "mode_1.vtu")
        assert (found is not None) == there
        if there:
            assert np.array_equal(np.isnan(found), ~data.stressed)


def test_the_report_names_no_stress_of_beams(run, tmp_path):
    page = view.report({"run": run.last()}, tmp_path / "r.html", pictures=False).read_text()
    table = page[page.index("<h2>Largest stress</h2>") :]
    table = table[: table.index("</table>")]
    assert "sign" in table
    assert "mast" not in table


@pytest.mark.render
def test_pictures(run, tmp_path, monkeypatch):
    """The mast has the colour of flexible parts; what has no stress beside the plate too."""
    from flexmb.view.stage import ELASTIC_LABEL, Stage

    surfaces, close = {}, Stage.close
    monkeypatch.setattr(
        Stage, "close", lambda self: surfaces.update({part.name: one for part, one, *_ in self._drawn}) or close(self)
    )
    view.render(run.last(), tmp_path / "x.png", size=(400, 300))
    assert ELASTIC_LABEL not in surfaces["mast"].point_data
    shown = surfaces["sign"].point_data[ELASTIC_LABEL]
    assert np.isnan(shown).any()
    assert np.nanmax(shown) > 0.0
