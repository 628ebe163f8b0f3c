"""`mode_sheet`: the first modes of a reduced body in one picture."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.files import replacing
from flexmb.io.cell_types import flat_cells
from flexmb.io.mode_series import mode_amplitude
from flexmb.view.graphics import require_graphics
from flexmb.view.stage import VIEW_ANGLE, camera_position

__all__ = ["mode_sheet", "oblique", "silent_plotter"]

STILL = (".png", ".jpg")
LABEL_ROOM = 0.16  # part of the height of each picture that its title takes


def mode_sheet(data, path: str | Path, *, modes: int = 6, camera=None, up=(0.0, 0.0, 1.0), size=(1800, 1000)) -> Path:
    """Draw the first modes side by side, coloured by displacement over the undeformed body, and return the path.

    Parameters
    ----------
    data : ModalNeutralData
        With a mesh.
    path : path
        ``.png`` or ``.jpg``.
    modes : int
        How many modes at most.
    camera : (3,), optional
        Direction to look from; chosen by the shape of the body unless given.
    up : (3,)
        Direction that is up in the picture.
    size : (int, int)
        Pixels of the whole sheet.

    Raises
    ------
    FlexmbError
        The data has no mesh or no modes, the ending is unknown, or nothing can be drawn on this machine.
    """
    path = Path(path)
    if path.suffix not in STILL:
        raise FlexmbError(
            f"Picture '{path}'",
            found=f"the ending '{path.suffix}'",
            expected=f"One of: {', '.join(STILL)}",
            remedy="Use .png for a picture",
        )
    count = min(modes, data.n_modes)
    if not data.cells or count < 1:
        raise FlexmbError(
            f"Modes of '{data.name}'",
            found="there is no mesh" if count else "there are no modes",
            expected="data reduced from an FE model with elements, and at least one mode",
            remedy="Reduce a model made by fem.solid, fem.shell or fem.frame",
        )
    require_graphics()
    columns = int(np.ceil(np.sqrt(count)))
    rows = -(-count // columns)
    direction = oblique(data.nodes) if camera is None else camera
    with silent_plotter(list(size), (rows, columns)) as plotter:
        for j in range(count):
            plotter.subplot(j // columns, j % columns)
            _draw(plotter, data, j)
            aspect = size[0] / columns / (size[1] / rows)
            plotter.camera.view_angle = VIEW_ANGLE
            plotter.camera_position = camera_position(_displaced(data, j), direction, up, aspect, LABEL_ROOM)
            plotter.renderer.reset_camera_clipping_range()
        with replacing(path, f"Picture '{path}'", folder=True) as file:
            plotter.screenshot(str(file))
    return path


@contextmanager
def silent_plotter(size, shape) -> Iterator[Any]:
    """Give an off-screen plotter, and close it; VTK tries X first and would say so on the terminal."""
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    plotter = pyvista.Plotter(off_screen=True, window_size=size, shape=shape, border=False, lighting="light kit")
    plotter.enable_anti_aliasing("ssaa")
    try:
        yield plotter
    finally:
        plotter.close()
        vtkLogger.SetStderrVerbosity(verbosity)


def oblique(nodes: np.ndarray) -> np.ndarray:
    """Return a direction in which no mode hides: across the longest side of the body, between the two others."""
    direction = np.empty(3)
    direction[np.argsort(np.ptp(nodes, axis=0))] = (0.8, 0.7, 0.35)
    return direction * (1.0, -1.0, 1.0)


def _displaced(data, j: int) -> np.ndarray:
    return data.nodes + mode_amplitude(data, j) * data.shapes[:, :, j]


def _draw(plotter, data, j: int) -> None:
    """Add one mode, and the edges of the body as it was."""
    displaced = _surface(data, _displaced(data, j))
    moved = np.linalg.norm(data.shapes[:, :, j], axis=1)
    displaced.point_data["size"] = (moved / (moved.max() or 1.0))[displaced.point_data["number"].astype(int)]
    thin = displaced.n_lines > 0
    plotter.set_background("#dfe6ee", top="white")
    plotter.add_mesh(
        displaced,
        scalars="size",
        cmap="viridis",
        clim=(0.0, 1.0),
        show_scalar_bar=False,
        smooth_shading=not thin,
        split_sharp_edges=False,
        render_lines_as_tubes=thin,
        line_width=6 if thin else 1,
        ambient=0.12,
    )
    rest = _surface(data, data.nodes)
    edges = rest if thin else rest.extract_feature_edges(feature_angle=40, boundary_edges=True, manifold_edges=False)
    if edges.n_points:
        plotter.add_mesh(edges, color="#26303a", line_width=1.2, opacity=0.45)
    plotter.add_text(
        f"{j + 1}: {data.frequencies[j]:.4g} Hz",
        font_size=11,
        color="#26303a",
        position="lower_left",
        font="arial",
    )


def _surface(data, points: np.ndarray):
    """Return the surface of the mesh with the numbers of its nodes."""
    import pyvista

    connectivity, ends, types = flat_cells(data.cells)
    starts = np.concatenate([[0], ends[:-1]])
    grid = pyvista.UnstructuredGrid(np.insert(connectivity, starts, ends - starts), types, points)
    grid.point_data["number"] = np.arange(len(points), dtype=float)
    surface = grid.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=1)
    surface.point_data["number"] = np.rint(surface.point_data["number"])
    return surface
