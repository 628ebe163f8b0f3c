"""`Stage`: the parts of a scene as pyvista meshes with colours, light and camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from flexmb.io.cell_types import flat_cells
from flexmb.io.drawn_parts import DrawnPart
from flexmb.io.scene import Scene
from flexmb.view.arm_lines import arm_lines
from flexmb.view.labels import without_overlap
from flexmb.view.viewpoint import viewpoint

__all__ = ["VIEW_ANGLE", "Look", "Stage", "bar", "camera_position", "framed_points", "part_color"]

VIEW_ANGLE = 20.0  # degrees; a long lens keeps parallel links nearly parallel

FEW = 12  # texts up to which letters are large

FRAMING, DIRECTIONS = 60, 400  # frames and points by which the camera is placed

BROAD, HIGH, FEWER = 1600, 900, 0.6
"""Size, pixels, of a picture whose letters are full, and the part of it below which a colour bar has fewer numbers."""
MEGA = 1e-6
COLORS = {"flexible": "#6f9fc8", "joints": "#33404d", "springs": "#c98a2b", "supports": "#8b949d", "contact": "#26303a"}
RIGID = ("#9fb1c2", "#c98f5a", "#7fa593", "#e9e6dd", "#9d93b4", "#c7b979")
"""Rigid bodies take these colours one after the other, so that neighbours differ."""
ELASTIC_LABEL = "von Mises stress [MPa]"
CONTACT_LABEL = "contact pressure [MPa]"


class Look(NamedTuple):
    """How a state is drawn: opacity, and the colour of bodies that show no stress (None: their family's)."""

    opacity: float = 1.0
    color: str | None = None


class Stage:
    """A window, never shown unless asked for, with one state of the scene on it.

    Parameters
    ----------
    scene : Scene
    size : (int, int)
        Width and height of the picture in pixels.
    largest_stress : float, Pa
        End of the colour scale; 0 draws no scale.
    scale : float
        Factor on elastic displacements.
    shown : bool
        Open a window on the screen.
    hide : sequence of str
        Names of bodies, or "joints", "springs", "supports": what is not drawn.
    """

    def __init__(
        self,
        scene: Scene,
        size,
        largest_stress: float,
        scale: float = 1.0,
        shown: bool = False,
        hide: Sequence[str] = (),
    ):
        import pyvista
        from vtkmodules.vtkCommonCore import vtkLogger

        self.scene, self.scale, self.largest_stress = scene, scale, largest_stress
        # VTK tries X first and says so on the terminal before it turns to EGL
        self._verbosity = vtkLogger.GetCurrentVerbosityCutoff()
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
        plotter: Any = pyvista.Plotter(off_screen=not shown, window_size=list(size), lighting="light kit")
        plotter.set_background("#dfe6ee", top="white")
        plotter.enable_anti_aliasing("ssaa")
        self.plotter = plotter
        self._drawn: list[tuple[DrawnPart, Any, np.ndarray, list]] = []
        self._hidden = frozenset(hide)

    def add_state(self, frame: int, look: Look | None = None) -> None:
        """Add all parts as they are at a frame."""
        look = look or Look()
        for part in self.scene.parts:
            if part.name in self._hidden:
                continue
            if look.color is None or part.look != "supports":  # what stands still would be drawn twice
                self._add(part, frame, look)

    def move_to(self, frame: int) -> None:
        """Move what has been added to another frame."""
        for part, surface, ids, edges in self._drawn:
            points, mises = self._state(part, frame)
            surface.points = points[ids]
            if surface.n_cells > surface.n_lines + surface.n_verts:  # lines alone have no normals
                surface.compute_normals(inplace=True, split_vertices=False)
            if mises is not None:
                surface.point_data[ELASTIC_LABEL] = mises[ids]
            if part.tiles is not None:
                surface.point_data[CONTACT_LABEL] = self._pressure(part, frame)[ids]
            for line, line_ids in edges:
                line.points = points[line_ids]

    def look_from(self, camera, up, frames: Sequence[int] = ()) -> None:
        """Place the camera so that all that has been added is seen, at the frames too through which it will move.

        `camera` is a direction to look from, a pyvista camera position, or None: then it is chosen by the extent and
        the motion of the scene.
        """
        if camera is not None and np.shape(camera) != (3,):
            self.plotter.camera_position = camera
            return
        seen = [surface.points for _, surface, _, _ in self._drawn]
        if frames:
            seen.append(framed_points(self.scene, frames, self.scale))
        direction = viewpoint(self.scene, up) if camera is None else camera
        width, height = self.plotter.window_size
        room = 0.22 if self.largest_stress > 0.0 else 0.0
        self.plotter.camera.view_angle = VIEW_ANGLE
        self.plotter.camera_position = camera_position(np.vstack(seen), direction, up, width / height, room)
        self.plotter.renderer.reset_camera_clipping_range()

    def label(self, places: Mapping[str, np.ndarray], given: int = 0) -> None:
        """Write texts at places (3,), m, in W, in front of everything, instead of those written before.

        The first `given` ones are moved where they would cover another, with a line to their place; of the others those
        without room are left out, and the picture says how many.
        """
        if not places:
            return
        font = max(10, self.plotter.window_size[1] // (36 if len(places) <= FEW else 64))
        seen = dict(zip(places, self._seen(np.array(list(places.values()), float)), strict=True))
        kept = without_overlap(list(places), np.array(list(seen.values())), font, self.plotter.window_size, given)
        named = np.array([places[text] for text in kept], float)
        written = self._behind(np.array([kept[text] - seen[text] for text in kept]), named)
        actor = self.plotter.add_point_labels(
            written,
            list(kept),
            font_size=font,
            shape_color="white",
            shape_opacity=0.75,
            text_color=COLORS["contact"],
            show_points=False,
            always_visible=True,
            name="labels",
        )
        actor.GetMapper().SetPlaceAllLabels(True)  # else VTK leaves out what it finds too close
        self.plotter.add_points(named, color=COLORS["contact"], point_size=9, name="places of labels")
        moved = np.flatnonzero(np.any(written != named, axis=1))
        self.plotter.remove_actor("lines of labels")
        if len(moved):
            ends = np.stack([named[moved], written[moved]], axis=1).reshape(-1, 3)
            self.plotter.add_lines(ends, color=COLORS["contact"], width=1, name="lines of labels")
        left_out = len(places) - len(kept)
        note = f"names without room: {left_out}" if left_out else ""
        self.plotter.add_text(note, position="lower_left", font_size=8, color=COLORS["contact"], name="left out")

    def _seen(self, points: np.ndarray) -> np.ndarray:
        """Return where points (n, 3), m, in W are in the picture (n, 2), pixels."""
        clipped = np.column_stack([points, np.ones(len(points))]) @ self._projection().T
        return 0.5 * (clipped[:, :2] / clipped[:, 3:] + 1.0) * np.array(self.plotter.window_size, float)

    def _behind(self, moves: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return the points (n, 3), m, in W of the same depth that are seen `moves` (n, 2), pixels, away."""
        matrix = self._projection()
        clipped = np.column_stack([points, np.ones(len(points))]) @ matrix.T
        clipped[:, :2] += 2.0 * moves / np.array(self.plotter.window_size, float) * clipped[:, 3:]
        found = clipped @ np.linalg.inv(matrix).T
        return np.where(np.any(moves != 0.0, axis=1)[:, None], found[:, :3] / found[:, 3:], points)

    def _projection(self) -> np.ndarray:
        """Return the matrix (4, 4) from W to the picture, which goes from -1 to 1."""
        width, height = self.plotter.window_size
        matrix = self.plotter.camera.GetCompositeProjectionTransformMatrix(width / height, -1, 1)
        return np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])

    def picture(self) -> np.ndarray:
        """Return the picture, (height, width, 3) uint8."""
        self.plotter.render()
        return self.plotter.screenshot(None, return_img=True)

    def close(self) -> None:
        """Free the window."""
        from vtkmodules.vtkCommonCore import vtkLogger

        self.plotter.close()
        vtkLogger.SetStderrVerbosity(self._verbosity)

    def _state(self, part, frame):
        snapshot = self.scene.snapshot(part, frame)
        points = snapshot.points
        if snapshot.displacement is not None and self.scale != 1.0:
            points = points + (self.scale - 1.0) * snapshot.displacement
        return points, None if snapshot.von_mises is None else MEGA * snapshot.von_mises

    def _pressure(self, part, frame) -> np.ndarray:
        """Return the pressure of a contact at its points, MPa."""
        return MEGA * part.tiles.values(*self.scene.samples[frame])["pressure"]

    def _add(self, part, frame, look):
        import pyvista

        points, mises = self._state(part, frame)
        connectivity, ends, types = flat_cells((*part.cells, *arm_lines(part)))
        starts = np.concatenate([[0], ends[:-1]])
        cells = np.insert(connectivity, starts, ends - starts)
        grid = pyvista.UnstructuredGrid(cells, types, points)
        # VTK's own record of the original points is wrong for quadratic cells: carry the numbers as a field
        grid.point_data["number"] = np.arange(len(points), dtype=float)
        surface = grid.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=1)
        ids = np.rint(surface.point_data.pop("number")).astype(int)
        shading: dict[str, Any] = {"color": look.color or part_color(self.scene, part)}
        if part.tiles is not None:
            surface.point_data[CONTACT_LABEL] = self._pressure(part, frame)[ids]
            largest = max(tiles.largest() for tiles in (other.tiles for other in self.scene.parts) if tiles)
            shading = {
                "scalars": CONTACT_LABEL,
                "cmap": "inferno",
                "clim": (0.0, MEGA * largest),
                "scalar_bar_args": {**bar(CONTACT_LABEL, MEGA * largest, self.plotter.window_size), "position_x": 0.03},
                "lighting": False,
            }
        elif mises is not None and look.color is None and self.largest_stress > 0.0:
            surface.point_data[ELASTIC_LABEL] = mises[ids]
            shading = {
                "scalars": ELASTIC_LABEL,
                "cmap": _colors(),
                "clim": (0.0, MEGA * self.largest_stress),
                "scalar_bar_args": bar(ELASTIC_LABEL, MEGA * self.largest_stress, self.plotter.window_size),
                "interpolate_before_map": True,
                "nan_color": part_color(self.scene, part),  # beams beside shells: they have no stress
            }
        thin = surface.n_lines > 0
        actor = self.plotter.add_mesh(
            surface,
            smooth_shading=not thin,
            split_sharp_edges=False,
            opacity=look.opacity,
            specular=0.35,
            specular_power=20,
            ambient=0.12,
            render_lines_as_tubes=thin,
            line_width=6 if thin else 1,
            **shading,
        )
        if part.tiles is not None:  # they lie in the surfaces, and are to be seen
            actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
            actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-2.0, -150.0)
        elif look.opacity < 1.0:  # a face that coincides with another state's is behind it, not half of it
            actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
            actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.5, 1.0)
        edges = []
        if part.look == "flexible" and not thin:
            line = surface.extract_feature_edges(feature_angle=40, boundary_edges=False, manifold_edges=False)
            if line.n_points:
                line_ids = ids[_nearest(surface.points, line.points)]
                self.plotter.add_mesh(line, color="#26303a", line_width=1.2, opacity=0.6 * look.opacity)
                edges.append((line, line_ids))
        self._drawn.append((part, surface, ids, edges))


def part_color(scene: Scene, part: DrawnPart) -> str:
    """Return the colour of a part without stress: its family's, or its own among the rigid bodies."""
    rigid = [other.name for other in scene.parts if other.look == "rigid"]
    return COLORS[part.look] if part.look in COLORS else RIGID[rigid.index(part.name) % len(RIGID)]


def framed_points(scene: Scene, frames: Sequence[int], scale: float = 1.0) -> np.ndarray:
    """Return the outer points of all parts over a motion, (n, 3), m: what a camera that stands still must see."""
    outer = [(part, _outer(part)) for part in scene.parts]
    return np.vstack([scene.points(part, frame, ids, scale) for frame in _spread(frames) for part, ids in outer])


def _spread(frames: Sequence[int]) -> list[int]:
    """Return frames that stand for all of them: a mechanism goes no detours between one sixtieth and the next."""
    return (
        [frames[k] for k in np.unique(np.linspace(0, len(frames) - 1, FRAMING).round().astype(int))] if frames else []
    )


def _outer(part: DrawnPart) -> np.ndarray:
    """Return the numbers of the points that lie farthest out, in directions all around: a few hundred of many."""
    if len(part.points) <= DIRECTIONS or len(part.carriers) > 1:
        return np.arange(len(part.points))
    k = np.arange(DIRECTIONS) + 0.5  # spiral of equal areas on the sphere
    z, turn = 1.0 - 2.0 * k / DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * k
    directions = np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z])
    return np.unique(np.argmax(part.points @ directions, axis=0))


def _nearest(points, wanted):
    """Return the numbers of the points that are equal to the wanted ones."""
    from scipy.spatial import cKDTree

    return cKDTree(points).query(wanted)[1]


def _colors():
    """Return turbo without its black ends, which would hide the shading."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps["turbo"](np.linspace(0.07, 0.97, 256)))


def bar(title: str, largest: float, size: Sequence[int]) -> dict[str, Any]:
    """Return how a colour bar from 0 to `largest` looks: its numbers have three digits, or all before the point.

    In a picture of a small `size` (width and height, pixels) letters keep a size to be read, and numbers are fewer.
    """
    shrunk = min(1.0, size[0] / BROAD, size[1] / HIGH)
    small = shrunk < FEWER
    return {
        "title": title + "\n",
        "vertical": False,
        "position_x": 0.34,
        "position_y": 0.02,
        "width": 0.32,
        "height": min(0.2, 0.08 / shrunk**0.75),
        "title_font_size": max(12, round(22 * shrunk)),
        "label_font_size": max(11, round(18 * shrunk)),
        "color": "#26303a",
        "n_labels": 3 if small else 5,
        "fmt": "%.0f" if 1e3 <= largest < 1e6 else "%.3g",
        "font_family": "arial",
        "unconstrained_font_size": True,
    }


def camera_position(points, camera, up, aspect: float, room: float):
    """Return (eye, focus, up) for pyvista, as near as all points allow.

    Parameters
    ----------
    points : (n, 3), m
        Points to show.
    camera : (3,)
        Direction to look from.
    up : (3,)
        Direction that is up in the picture.
    aspect : float
        Width of the picture by its height.
    room : float
        Part of the height at the bottom that stays free, for the colour scale.
    """
    up = np.asarray(up, float) / np.linalg.norm(up)
    direction = np.asarray(camera, float)
    direction = direction / np.linalg.norm(direction)
    if abs(direction @ up) > 0.999:
        up = np.eye(3)[int(np.argmin(np.abs(direction)))]
    right = np.cross(up, direction)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(direction, right), direction])
    seen = points @ axes.T
    middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
    x, y = np.abs(seen - middle)[:, :2].T
    depth = (seen - middle)[:, 2]
    slope = np.tan(np.radians(VIEW_ANGLE / 2.0))
    distance = max(np.max(x / (0.92 * aspect * slope) + depth), np.max(y / (0.92 * (1.0 - room) * slope) + depth))
    middle[1] -= room * slope * distance
    focus = middle @ axes
    return [tuple(focus + distance * direction), tuple(focus), tuple(up)]
