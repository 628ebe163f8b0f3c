"""`paraview_script`: a Python script that opens exported files in ParaView ready-made: colours, camera, time."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb.errors import DataFileError
from flexmb.files import write_text
from flexmb.io.scene import Scene
from flexmb.io.vtk_output import part_file
from flexmb.view.pictures import largest_stress, upwards
from flexmb.view.stage import VIEW_ANGLE, camera_position, framed_points, part_color
from flexmb.view.viewpoint import viewpoint

__all__ = ["paraview_script"]

UNREAD = {
    ".pvd": "this file should be beside this script",
    ".vtkhdf": "ParaView 5.12 and newer read .vtkhdf. In this one open the .xdmf with 'XDMF Reader', or export --vtk",
}
"""What to do where ParaView does not open a file."""

SCRIPT = """# Opens {title} in ParaView with colours, camera and time: paraview --script={name}
# In ParaView that is open already: Tools > Python Shell > Run Script.

from pathlib import Path

from paraview.simple import *

try:
    FOLDER = Path(__file__).resolve().parent
except NameError:  # ParaView's shell runs scripts without a name
    FOLDER = Path({folder})

STRESS = "von_mises"  # Pa
LARGEST = {largest!r}  # Pa, of all flexible bodies over the whole motion

# name, file, colour (red, green, blue), whether it carries the stress
PARTS = [
{parts}
]


def opened(file):
    try:
        return OpenDataFile(str(FOLDER / file))
    except RuntimeError as error:  # ParaView before 5.12 and .vtkhdf
        raise RuntimeError(f"{{error}}: {unread}") from error


view = GetActiveViewOrCreate("RenderView")
stress = GetColorTransferFunction(STRESS)
stress.ApplyPreset("Turbo", True)
stress.RescaleTransferFunction(0.0, LARGEST or 1.0)

for name, file, colour, elastic in PARTS:
    part = opened(file)
    RenameSource(name, part)
    shown = Show(part, view)
    shown.Representation = "Surface"
    if elastic and LARGEST > 0.0:
        ColorBy(shown, ("POINTS", STRESS))
        stress.RescaleTransferFunction(0.0, LARGEST)
        shown.SetScalarBarVisibility(view, True)
        stress.NanColor = colour  # nodes of beams alone have no stress
    else:
        shown.ColorArrayName = [None, ""]
        shown.AmbientColor = shown.DiffuseColor = colour

if LARGEST > 0.0:
    bar = GetScalarBar(stress, view)
    bar.Title, bar.ComponentTitle = "von Mises stress [Pa]", ""

GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
GetAnimationScene().GoToFirst()
Render()  # the first time, this places the camera by itself
view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = {camera}
view.CameraViewAngle = {angle!r}
Render()
"""


def paraview_script(solution, path: str | Path, *, camera=None) -> Path:
    """Write the script beside the files of `flexmb.write_vtk` and return its path, ``<name>_paraview.py``.

    Parameters
    ----------
    solution : Solution
        With its model.
    path : path
        The ``.pvd`` or ``.vtkhdf`` that was written; the script goes with the folder wherever it is moved.
    camera : (3,), optional
        Direction to look from; chosen by extent and motion of the mechanism unless given.

    Raises
    ------
    DataFileError
        The files are not there.
    """
    path = Path(path)
    scene = Scene(solution)
    frames = list(range(len(scene.times)))
    files = {part.name: part_file(path, part.name) for part in scene.parts}
    missing = [file for file in files.values() if not file.is_file()]
    if missing:
        raise DataFileError(
            f"ParaView script for '{path}'",
            found=f"there is no '{missing[0]}'",
            expected="the files that flexmb.write_vtk makes",
            remedy="Call flexmb.write_vtk first",
        )
    rows = []
    for part in scene.parts:
        elastic = part.data is not None and part.data.has_stress
        place = files[part.name].relative_to(path.parent).as_posix()
        rows.append(f"    ({part.name!a}, {place!a}, {_rgb(part_color(scene, part))}, {elastic}),")
    up = upwards(solution.model)
    direction = viewpoint(scene, up) if camera is None else camera
    place = camera_position(framed_points(scene, frames), direction, up, 16 / 9, 0.1)
    script = path.with_name(f"{path.stem}_paraview.py")
    text = SCRIPT.format(
        # names may hold anything, also what would be code: they are quoted, and stay on their line
        title=ascii(solution.model.name),
        name=ascii(script.name),
        folder=ascii(str(path.parent.resolve())),
        largest=largest_stress(scene, frames),
        parts="\n".join(rows),
        camera=", ".join(str([float(f"{x:.6g}") for x in np.array(vector)]) for vector in place),
        angle=VIEW_ANGLE,
        unread=UNREAD.get(path.suffix, UNREAD[".vtkhdf"]),
    )
    return write_text(script, text)


def _rgb(color: str) -> tuple[float, ...]:
    return tuple(round(int(color[k : k + 2], 16) / 255.0, 3) for k in (1, 3, 5))
