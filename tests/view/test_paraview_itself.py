"""ParaView itself opens what is exported: `apt-get install paraview python3-paraview xvfb`, then `pytest -m peer`."""

import json
import os
import shutil
import subprocess

import numpy as np
import pytest

import flexmb as fmb
from flexmb.io.scene import Scene
from flexmb.view import paraview_script

PARAVIEW = [shutil.which("xvfb-run"), "-a", shutil.which("pvbatch")]

pytestmark = [
    pytest.mark.peer,
    pytest.mark.skipif(None in PARAVIEW, reason="needs ParaView's pvbatch, and xvfb-run"),
]

LOOK = """
import json, runpy, sys
from paraview.simple import *

what, file, answer = sys.argv[1:]
found = {}

def seen(source, time):
    source.UpdatePipeline(time)
    information = source.GetDataInformation()
    arrays = information.GetPointDataInformation()
    of = {
        arrays.GetArrayInformation(k).GetName(): arrays.GetArrayInformation(k).GetComponentRange(0)
        for k in range(arrays.GetNumberOfArrays())
    }
    return {"points": information.GetNumberOfPoints(), "bounds": information.GetBounds(), "arrays": of}

if what == "script":
    runpy.run_path(file)
    found = {name: dict(seen(source, source.TimestepValues[-1]), times=list(source.TimestepValues))
             for (name, _), source in GetSources().items()}
    SaveScreenshot(answer + ".png", GetActiveView(), ImageResolution=[400, 300])
else:
    source = XDMFReader(FileNames=[file])
    found = {"all": seen(source, source.TimestepValues[-1])}
with open(answer, "w") as stream:
    json.dump(found, stream)
"""


def in_paraview(what, file, folder):
    """Let ParaView open a file, and return what it sees there; with what it printed."""
    look, answer = folder / "look.py", folder / "answer.json"
    look.write_text(LOOK)
    own = {key: os.environ[key] for key in ("HOME", "LANG", "TMPDIR") if key in os.environ}
    for _ in range(3):  # a virtual screen is not always ready at once
        done = subprocess.run(
            [*PARAVIEW, str(look), what, str(file), str(answer)],
            env={**own, "PATH": "/usr/bin:/bin"},
            capture_output=True,
            text=True,
            timeout=120,
        )
        if "bad X server connection" not in done.stderr:
            break
    return json.loads(answer.read_text()) if answer.exists() else None, done.stdout + done.stderr


def test_the_script(solution, tmp_path):
    """Parts by name, at every time, at their places, with the stress by which they are coloured; and a picture."""
    import pyvista

    path = fmb.write_vtk(solution, tmp_path / "out" / "spin.pvd")
    found, said = in_paraview("script", paraview_script(solution, path), tmp_path)
    assert found, said
    scene = Scene(solution)
    assert set(found) == {part.name for part in scene.parts}
    for part in scene.parts:
        np.testing.assert_allclose(found[part.name]["times"], scene.times)
        points = scene.snapshot(part, len(scene.times) - 1).points
        box = np.column_stack([points.min(axis=0), points.max(axis=0)]).ravel()
        np.testing.assert_allclose(found[part.name]["bounds"], box, rtol=1e-6, atol=1e-9)
    stressed = [name for name, part in found.items() if "von_mises" in part["arrays"]]
    assert len(stressed) == 1
    assert found[stressed[0]]["arrays"]["von_mises"][1] > 0.0
    picture = pyvista.read(tmp_path / "answer.json.png")
    assert len(np.unique(picture.active_scalars, axis=0)) > 20  # neither black nor one colour


def test_xdmf(solution, tmp_path):
    """ParaView's "XDMF Reader" shows in the sidecar of .vtkhdf files what the .pvd shows."""
    path = fmb.write_vtk(solution, tmp_path / "out" / "spin.vtkhdf")
    assert path.suffix == ".xdmf"
    found, said = in_paraview("xdmf", path, tmp_path)
    assert found, said
    scene = Scene(solution)
    last = [scene.snapshot(part, len(scene.times) - 1).points for part in scene.parts]
    assert found["all"]["points"] == sum(len(points) for points in last)
    every = np.vstack(last)
    box = np.column_stack([every.min(axis=0), every.max(axis=0)]).ravel()
    np.testing.assert_allclose(found["all"]["bounds"], box, rtol=1e-6, atol=1e-9)
    assert {"von_mises", "displacement"} <= set(found["all"]["arrays"])


def test_vtkhdf_where_paraview_is_too_old(solution, tmp_path):
    """ParaView 5.12 and newer open the files; older ones say what to do."""
    path = fmb.write_vtk(solution, tmp_path / "out" / "spin.vtkhdf")
    found, said = in_paraview("script", paraview_script(solution, path.with_suffix(".vtkhdf")), tmp_path)
    if found is None:
        assert "ParaView 5.12 and newer read .vtkhdf. In this one open the .xdmf with 'XDMF Reader'" in said
    else:
        assert set(found) == {part.name for part in Scene(solution).parts}
