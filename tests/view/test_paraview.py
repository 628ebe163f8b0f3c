"""The script that opens a run in ParaView: run here with stand-ins for ParaView's functions, its files read by VTK."""

import ast
import runpy
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from results.spinning import observe, spinning_model, spinning_phase

import flexmb as fmb
from flexmb.errors import DataFileError
from flexmb.io.scene import Scene
from flexmb.results import Solution
from flexmb.view import paraview_script
from flexmb.view.pictures import largest_stress


class Stand(SimpleNamespace):
    """Takes every call and every attribute of one of ParaView's objects."""

    def __getattr__(self, name):
        return lambda *arguments: None


@pytest.fixture
def paraview(monkeypatch):
    """The functions of paraview.simple that the script calls; returns what it opened and how it shows it."""
    seen = SimpleNamespace(view=Stand(), table=Stand(ranges=[]), opened=[], shown={})
    seen.table.RescaleTransferFunction = lambda low, high: seen.table.ranges.append((low, high))

    def open_file(file):
        seen.opened.append(file)
        return Stand(file=file)

    def show(source, view):
        seen.shown[source.file] = Stand(colored=None)
        return seen.shown[source.file]

    simple = ModuleType("paraview.simple")
    simple.__all__ = [
        "ColorBy",
        "GetActiveViewOrCreate",
        "GetAnimationScene",
        "GetColorTransferFunction",
        "GetScalarBar",
        "OpenDataFile",
        "RenameSource",
        "Render",
        "Show",
    ]
    simple.OpenDataFile, simple.Show = open_file, show
    simple.RenameSource = lambda name, source: None
    simple.ColorBy = lambda shown, array: setattr(shown, "colored", array)
    simple.GetActiveViewOrCreate = lambda kind: seen.view
    simple.GetColorTransferFunction = lambda name: seen.table
    simple.GetAnimationScene = simple.GetScalarBar = lambda *arguments: Stand()
    simple.Render = lambda: None
    monkeypatch.setitem(sys.modules, "paraview", ModuleType("paraview"))
    monkeypatch.setitem(sys.modules, "paraview.simple", simple)
    return seen


@pytest.mark.parametrize("ending", [".pvd", ".vtkhdf"])
def test_the_script_opens_what_is_there(solution, paraview, tmp_path, ending):
    """Every file exists, is readable at every time, and has the array by which it is coloured."""
    import pyvista

    path = tmp_path / "out" / f"spin{ending}"
    fmb.write_vtk(solution, path)
    script = paraview_script(solution, path)
    assert script == tmp_path / "out" / "spin_paraview.py"
    moved = tmp_path / "elsewhere"
    script.parent.rename(moved)
    runpy.run_path(str(moved / script.name))
    assert len(paraview.opened) == len(Scene(solution).parts)
    colored = 0
    for file in paraview.opened:
        assert file.startswith(str(moved))
        array = paraview.shown[file].colored
        colored += array is not None
        if ending == ".pvd":
            reader = pyvista.get_reader(file)
            np.testing.assert_allclose(reader.time_values, Scene(solution).times)
            mesh = reader.read()[0]
            assert array is None or array[1] in mesh.point_data
        else:
            assert array is None or array[1] in pyvista.read(file).point_data
    assert colored == 1
    scene = Scene(solution)
    assert paraview.table.ranges[-1] == (0.0, largest_stress(scene, range(len(scene.times))))
    assert len(paraview.view.CameraPosition) == len(paraview.view.CameraViewUp) == 3


def test_without_the_files(solution, tmp_path):
    message = (
        r"ParaView script for '.*x\.pvd': there is no '.*\.pvd'\. Expected: the files .*Call flexmb\.write_vtk first"
    )
    with pytest.raises(DataFileError, match=message):
        paraview_script(solution, tmp_path / "x.pvd")


def test_rigid_models_have_no_stress(monkeypatch, paraview, tmp_path):
    monkeypatch.setattr("flexmb.system.observe", observe, raising=False)
    phase = spinning_phase(spinning_model(stress=False), t=np.linspace(0, 0.08, 3))
    path = tmp_path / "spin.pvd"
    solution = Solution(phases=(phase,))
    fmb.write_vtk(solution, path)
    runpy.run_path(str(paraview_script(solution, path)))
    assert paraview.shown
    assert all(shown.colored is None for shown in paraview.shown.values())
    assert all(len(shown.DiffuseColor) == 3 for shown in paraview.shown.values())


HOSTILE = ['"""\nraise SystemExit(7)\n"""', "\\", "a'b\"c", "{title}", "x\nraise SystemExit(7)"]


def test_names_are_no_code(tmp_path):
    """Whatever a model, its bodies and the file are called, the statements of the script are the same."""

    def statements(name):
        rod = fmb.RigidBody.rod("rod", length=1.0, mass=1.0, radius=0.1)
        solution = fmb.simulate(fmb.Model(name=name, bodies=[fmb.Ground(), rod]), 0.1, samples=2)
        file = fmb.write_vtk(solution, tmp_path / f"{name}.pvd")
        return [type(node).__name__ for node in ast.walk(ast.parse(paraview_script(solution, file).read_text()))]

    plain = statements("plain")
    for name in HOSTILE:
        assert statements(name) == plain
