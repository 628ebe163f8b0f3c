"""`write_vtk`: a solution for ParaView, as PVD with VTU files or as VTKHDF with an XDMF file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb import hdf5
from flexmb.errors import DataFileError
from flexmb.io.cell_types import flat_cells, mixed_topology
from flexmb.io.contact_tiles import FIELDS
from flexmb.io.scene import Scene
from flexmb.io.vtkhdf import VtkHdfSeries
from flexmb.io.vtu import VtuSeries, write_collection
from flexmb.io.xdmf import write_xdmf
from flexmb.model.described import check_kind
from flexmb.results import Solution

__all__ = ["part_file", "write_vtk"]


def write_vtk(solution, path: str | Path, *, every: int = 1, stress: bool = True, surface: bool = False) -> Path:
    """Write the motion of all parts for ParaView and return the file to open.

    Points are displaced; flexible bodies carry ``displacement`` (elastic, in W, m) and, if elements give stress,
    ``von_mises`` (Pa), which is NaN at nodes of beams, rods and links alone. Bodies of a deck carry the numbers of
    their nodes, ``node``, and elements, ``element`` (0 for what is not in it; ``instance`` counts part instances from
    0). Cables and beams have their sections and carry the section forces (N, N m); rigid bodies, joints, springs and
    supports are drawn as simple solids. Contacts with areas are small squares at the points that touch at some sample,
    with ``pressure`` (Pa), ``slip`` (m/s) and ``pressure_times_way`` (N/m). Numbers are float32.

    Parameters
    ----------
    solution : Solution
        With its model.
    path : path
        ``out/name.pvd`` writes the collection and ``out/name/<part>_<frame>.vtu``: any ParaView reads it. One part
        alone is opened by ``out/name/<part>.pvd``.
        ``out/name.vtkhdf`` writes ``out/name_<part>.vtkhdf``, cells once and all frames in one file per part, read by
        ParaView 5.12 and later, and ``out/name.xdmf``, which shows the same data in earlier ones by their "XDMF
        Reader"; their "Xdmf3" readers cannot, and in 5.11 they end ParaView: take the .pvd there.
    every : int
        Write every n-th sample.
    stress : bool
        Write the von Mises stress.
    surface : bool
        Write the skin of solid bodies only: half the size or less, but nothing inside to cut through.

    Returns
    -------
    Path
        The .pvd or .xdmf file.
    """
    check_kind(
        solution,
        Solution,
        f"VTK output '{path}'",
        "Give what flexmb.simulate returns, or flexmb.Solution.load(...)",
        DataFileError,
    )
    path = Path(path)
    writers = {".pvd": _write_pvd, ".vtkhdf": _write_vtkhdf}
    if path.suffix not in writers:
        raise DataFileError(
            f"VTK output '{path}'",
            found=f"the ending '{path.suffix}'",
            expected=f"One of: {', '.join(writers)}",
            remedy="Use .pvd if in doubt",
        )
    scene = Scene(solution, every=every, stress=stress, surface=surface)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return writers[path.suffix](scene, path)
    except OSError as error:
        raise DataFileError(
            f"VTK output '{path}'",
            found=f"cannot write it ({error})",
            expected="a writable folder with free space",
            remedy="Free space, or choose another folder",
        ) from error


def _fields(scene, part) -> dict[str, int]:
    """Return the fields of a part with their numbers of components."""
    if part.tiles is not None:
        return dict.fromkeys(FIELDS, 1)
    if part.line is not None:
        return dict.fromkeys(part.line.fields, 1)
    if part.data is None:
        return {}
    mises = scene.stress and part.data.has_stress
    return {**({"von_mises": 1} if mises else {}), "displacement": 3}


def _numbers(part) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return the numbers that the points and cells of a part have in the deck."""
    own = None if part.data is None else part.data.numbering
    if own is None:
        return {}, {}
    if part.nodes is not None:  # the skin of solids: its facets are no elements
        own = own.of(part.nodes, ())
    points = {"node": own.nodes} | ({} if own.instance_of is None else {"instance": own.instance_of})
    return points, {"element": np.concatenate(own.cells)} if own.cells else {}


def _frame(scene, part, frame):
    """Return points and fields of a part as float32."""
    snapshot = scene.snapshot(part, frame)
    values = snapshot.line or {name: getattr(snapshot, name) for name in _fields(scene, part)}
    fields = {name: value.astype(np.float32) for name, value in values.items()}
    return snapshot.points.astype(np.float32), fields


def _write_pvd(scene, path):
    folder = path.with_suffix("")
    folder.mkdir(exist_ok=True)
    digits = len(str(len(scene.times) - 1))
    entries = []
    for number, part in enumerate(scene.parts):
        for old in folder.glob(f"{_file_name(part.name)}_[0-9]*.vtu"):  # of an earlier export with more frames
            old.unlink()
        series, own = VtuSeries(part.cells, *_numbers(part)), []
        for frame, t in enumerate(scene.times):
            file = folder / f"{_file_name(part.name)}_{frame:0{digits}d}.vtu"
            series.write(file, float(t), *_frame(scene, part, frame))
            entries.append((float(t), number, part.name, f"{folder.name}/{file.name}"))
            own.append((float(t), 0, part.name, file.name))
        write_collection(part_file(path, part.name), own)
    write_collection(path, sorted(entries, key=lambda entry: (entry[0], entry[1])))
    return path


def _write_vtkhdf(scene, path):
    parts = []
    for part in scene.parts:
        fields, numbers = _fields(scene, part), _numbers(part)
        file = part_file(path, part.name)
        with hdf5.writing(file) as stream:
            series = VtkHdfSeries(stream, part.cells, len(part.points), fields, *numbers)
            for frame, t in enumerate(scene.times):
                series.append(t, *_frame(scene, part, frame))
            series.finish()
        n_cells, length = len(flat_cells(part.cells)[2]), len(mixed_topology(part.cells))
        parts.append((part.name, file.name, len(part.points), n_cells, length, fields, tuple(map(tuple, numbers))))
    sidecar = path.with_suffix(".xdmf")
    write_xdmf(sidecar, [float(t) for t in scene.times], parts)
    return sidecar


def part_file(path: str | Path, name: str) -> Path:
    """Return the file that holds one part over all frames, beside ``name.pvd`` or ``name.vtkhdf``."""
    path = Path(path)
    if path.suffix == ".pvd":
        return path.with_suffix("") / f"{_file_name(name)}.pvd"
    return path.with_name(f"{path.stem}_{_file_name(name)}.vtkhdf")


def _file_name(name: str) -> str:
    """Return a part's name as a file name."""
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in name)
