"""`model_picture`: an FE model before its reduction: property groups, interfaces by name, free edges, loose nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.files import replacing
from flexmb.io.cell_types import flat_cells
from flexmb.view.graphics import require_graphics
from flexmb.view.mode_sheet import STILL, oblique, silent_plotter
from flexmb.view.stage import VIEW_ANGLE, camera_position

__all__ = ["model_picture"]

FILL = ("#9fb8cf", "#c7b38f", "#a5c0ab", "#c3a9b8", "#b3b3cc", "#c9c9b0", "#93b7bd", "#cbb0a0")
LOOKS = {
    "interfaces": "#b3263d",
    "free edges": "#d9822b",
    "unmerged nodes": "#c020c0",
    "loose parts": "#2040d0",
}
NAMED = 30
"""Interfaces up to which every one is named in the picture."""


def model_picture(model, path: str | Path, *, checks=None, camera=None, up=(0.0, 0.0, 1.0), size=(1800, 1100)) -> Path:
    """Draw an FE model with its interfaces marked and return the path.

    Elements are coloured by block (property and kind), free edges of shells, unmerged nodes and loose parts by what
    `flexmb.fem.deck_checks` found.

    Parameters
    ----------
    model : FEModel
    path : path
        ``.png`` or ``.jpg``.
    checks : DeckChecks, optional
    camera : (3,), optional
        Direction to look from; by default across the longest side.
    up, size : (3,), (int, int)
        What is up in the picture; pixels.

    Raises
    ------
    FlexmbError
        The model has no elements, the ending is unknown, or nothing can be drawn on this machine.
    """
    path = Path(path)
    if path.suffix not in STILL:
        raise FlexmbError(
            f"Picture '{path}'",
            found=f"the ending '{path.suffix}'",
            expected=f"One of: {', '.join(STILL)}",
            remedy="Use .png for a picture",
        )
    cells = [(b.cell_type, np.asarray(b.connectivity)) for b in model.blocks if len(b.connectivity)]
    if not cells:
        raise FlexmbError(
            f"FE model '{model.name}'",
            found="no elements to draw",
            expected="solids, shells, beams or rods",
            remedy="Matrices, masses and springs alone have no shape",
        )
    require_graphics()
    drawn = np.unique(np.concatenate([rows.ravel() for _, rows in cells]))
    direction = oblique(model.nodes[drawn]) if camera is None else camera
    with silent_plotter(list(size), (1, 1)) as plotter:
        plotter.set_background("#dfe6ee", top="white")
        for number, block in enumerate(cells):
            _add_cells(plotter, model.nodes, block, FILL[number % len(FILL)])
        shown = _mark(plotter, model, checks, float(np.linalg.norm(np.ptp(model.nodes[drawn], axis=0))) or 1.0)
        if shown:
            _add_legend(plotter, shown)
        plotter.add_text(_title(model, cells), font_size=10, color="#26303a", position="upper_left", font="arial")
        plotter.camera.view_angle = VIEW_ANGLE
        plotter.camera_position = camera_position(model.nodes[drawn], direction, up, size[0] / size[1], 0.08)
        plotter.renderer.reset_camera_clipping_range()
        with replacing(path, f"Picture '{path}'", folder=True) as file:
            plotter.screenshot(str(file))
    return path


def _add_legend(plotter, shown: list[tuple[str, str]]) -> None:
    """Add the legend at the upper right, as wide as its longest line: the renderer's own place cuts wide ones off."""
    legend = plotter.add_legend(
        [[text, LOOKS[kind]] for kind, text in shown], bcolor="white", face="rectangle", loc=None, font_family="arial"
    )
    width, height = 0.03 + 0.011 * max(len(text) for _, text in shown), 0.034 * len(shown)
    legend.SetPosition(0.99 - width, 0.985 - height)
    legend.SetPosition2(width, height)


def _title(model, cells) -> str:
    counts: dict[str, int] = {}
    for kind, rows in cells:
        counts[kind] = counts.get(kind, 0) + len(rows)
    return f"{model.name}: {len(model.nodes)} nodes, " + ", ".join(f"{n} {kind}" for kind, n in counts.items())


def _add_cells(plotter, nodes: np.ndarray, block: tuple[str, np.ndarray], color: str) -> None:
    import pyvista

    connectivity, ends, types = flat_cells([block])
    starts = np.concatenate([[0], ends[:-1]])
    grid: Any = pyvista.UnstructuredGrid(np.insert(connectivity, starts, ends - starts), types, nodes)
    if block[0].startswith("line"):
        plotter.add_mesh(grid, color="#3d5a75", line_width=4, render_lines_as_tubes=True)
        return
    surface = grid.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=0)
    few = len(block[1]) < 20000
    plotter.add_mesh(surface, color=color, show_edges=few, edge_color="#8796a5", line_width=0.4, ambient=0.2)


def _mark(plotter, model, checks, size: float) -> list[tuple[str, str]]:
    """Add what is to be looked at, and return (kind, words) for the legend."""
    shown = []
    places = {name: model.nodes[at.node] for name, at in model.reference_points.items()}
    if places:
        points = np.array(list(places.values()))
        plotter.add_points(points, color=LOOKS["interfaces"], point_size=16, render_points_as_spheres=True)
        if len(places) <= NAMED:
            lifted = points + 0.004 * size * np.array([0.0, 0.0, 1.0])
            plotter.add_point_labels(
                lifted,
                list(places),
                font_size=17,
                text_color="#26303a",
                shape_color="white",
                shape_opacity=0.65,
                show_points=False,
                always_visible=True,
                font_family="arial",
                margin=2,
            )
        shown.append(("interfaces", f"{len(places)} interfaces"))
    if checks is None:
        return shown
    if len(checks.free_edges):
        _add_lines(plotter, model.nodes, checks.free_edges, LOOKS["free edges"])
        shown.append(("free edges", f"{len(checks.free_edges)} free edges"))
    for kind, nodes in (
        ("unmerged nodes", np.unique(checks.unmerged)),
        ("loose parts", np.concatenate([np.zeros(0, int), *checks.parts[1:]])),
    ):
        if len(nodes):
            at = model.nodes[nodes]
            plotter.add_points(at, color=LOOKS[kind], point_size=11, render_points_as_spheres=True)
            count = len(checks.parts) - 1 if kind == "loose parts" else len(nodes)
            shown.append((kind, f"{count} {kind}"))
    return shown


def _add_lines(plotter, nodes: np.ndarray, edges: np.ndarray, color: str) -> None:
    import pyvista

    lines = np.column_stack([np.full(len(edges), 2), edges]).ravel()
    plotter.add_mesh(pyvista.PolyData(nodes, lines=lines), color=color, line_width=3, render_lines_as_tubes=True)
