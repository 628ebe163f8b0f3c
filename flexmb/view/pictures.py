"""`render` and `overlay`: pictures and animations of a solution, drawn off-screen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from flexmb.errors import FlexmbError, did_you_mean, listed
from flexmb.files import complaints, replacing
from flexmb.io.drawn_parts import surface_part
from flexmb.io.scene import Scene
from flexmb.results import recover
from flexmb.view.graphics import require_graphics
from flexmb.view.labels import Labels, places, refuse_unknown
from flexmb.view.stage import Look, Stage

__all__ = ["hidden_parts", "largest_stress", "overlay", "render", "require_hidden", "upwards"]

STILL = (".png", ".jpg")
MOVING = (".gif", ".mp4")


def render(
    solution,
    path: str | Path,
    *,
    times=None,
    camera=None,
    size=(1600, 900),
    scale: float = 1.0,
    rate: float = 25.0,
    hide: Sequence[str] = (),
    labels: Labels | None = None,
) -> Path:
    """Draw a solution and return the path of the picture.

    Parameters
    ----------
    solution : Solution
        With its model.
    path : path
        ``.png`` or ``.jpg``: one state; ``.gif`` or ``.mp4``: an animation (with the package imageio).
    times : float or (k,), s, optional
        The state, or the states of the animation: the samples nearest to these times. By default the last sample, or
        all samples.
    camera : (3,) or pyvista camera position, optional
        Direction to look from; chosen by extent and motion of the mechanism unless given.
    size : (int, int)
        Pixels.
    scale : float
        Factor on elastic displacements.
    rate : float, 1/s
        Pictures per second of an animation.
    hide : sequence of str
        What is not drawn: names of bodies or surfaces, or "joints", "springs", "supports". A body in whose place its
        surfaces are drawn goes with them.
    labels : mapping of text to marker or body, or "bodies", optional
        Texts in still pictures, each at a marker, "body.marker", or the middle of a body; "bodies" (also as a place in
        the mapping) writes the names of all bodies, as far as they do not cover one another: the larger bodies first.

    Raises
    ------
    FlexmbError
        Nothing can be drawn on this machine, imageio is missing, or the ending is unknown.
    """
    picture = _checked(path, STILL + MOVING)
    scene, frames = _scene(solution, times, default_all=picture.suffix in MOVING)
    hidden = _hidden(scene, hide)
    refuse_unknown([scene], labels, hidden)
    stage = Stage(scene, size, largest_stress(scene, frames), scale, hide=hidden)
    try:
        stage.add_state(frames[0] if picture.suffix in MOVING else frames[-1])
        stage.look_from(camera, upwards(solution.model), frames if picture.suffix in MOVING else ())
        if picture.suffix in STILL:
            stage.label(*places(scene, labels, frames[-1], hidden))
        with replacing(picture, f"Picture '{picture}'") as file:
            if picture.suffix in STILL:
                stage.plotter.screenshot(str(file))
            else:
                _animate(stage, frames, file, rate)
    finally:
        stage.close()
    return picture


def overlay(
    solution,
    path: str | Path,
    *,
    times,
    camera=None,
    size=(1600, 900),
    scale: float = 1.0,
    hide: Sequence[str] = (),
    labels: Labels | None = None,
) -> Path:
    """Draw several states in one picture: the last one solid with its stress, those before it translucent.

    Parameters as in `render`; `times` lists the states in the order in which they fade in.
    """
    picture = _checked(path, STILL)
    scene, frames = _scene(solution, times, default_all=True)
    hidden = _hidden(scene, hide)
    refuse_unknown([scene], labels, hidden)
    stage = Stage(scene, size, largest_stress(scene, frames[-1:]), scale, hide=hidden)
    try:
        for number, frame in enumerate(frames[:-1]):
            stage.add_state(frame, Look(opacity=0.15 + 0.2 * (number + 1) / len(frames), color="#5b7fa6"))
        stage.add_state(frames[-1])
        stage.plotter.enable_depth_peeling(8)
        stage.look_from(camera, upwards(solution.model))
        stage.label(*places(scene, labels, frames[-1], hidden))
        with replacing(picture, f"Picture '{picture}'") as file:
            stage.plotter.screenshot(str(file))
    finally:
        stage.close()
    return picture


def _hidden(scene: Scene, hide: Sequence[str]) -> tuple[str, ...]:
    """Return the names of what is not drawn; FlexmbError for unknown ones, or if nothing would be left."""
    names = (hide,) if isinstance(hide, str) else tuple(hide)
    require_hidden([scene], names)
    return hidden_parts(scene, names)


def hidden_parts(scene: Scene, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the parts that are not drawn: for a body in whose place its surfaces are drawn, these."""
    instead = _drawn_instead(scene)
    return tuple(part for name in names for part in instead.get(name, [name]))


def _drawn_instead(scene: Scene) -> dict[str, list[str]]:
    """Return the drawn surfaces of every body that is not drawn itself."""
    drawn, instead = {part.name for part in scene.parts}, {}
    model = scene.solution.model
    taken = {body.name for body in model.bodies} if model is not None else set()
    for own in model.surfaces if model is not None else ():
        body = own.marker.partition(".")[0] if hasattr(own, "shape") else ""
        name = surface_part(own, taken)
        if body and body not in drawn and name in drawn:
            instead.setdefault(body, []).append(name)
    return instead


def require_hidden(scenes: Sequence[Scene], names: tuple[str, ...]) -> None:
    """FlexmbError for names that none of the scenes draws, or if one of them would be left empty."""
    each = [[part.name for part in scene.parts] for scene in scenes]
    instead = [name for scene in scenes for name in _drawn_instead(scene)]
    known = list(dict.fromkeys([*(name for own in each for name in own), *instead]))
    layers = ("joints", "springs", "supports")
    for name in names:
        if known and name not in known and name not in layers:
            raise FlexmbError(
                "Picture",
                found=f"hide names '{name}'",
                expected=f"a body or a surface that is drawn, or one of {', '.join(layers)}",
                remedy=did_you_mean(name, [*known, *layers]) or f"One of: {listed(name, known)}",
            )
    if any(set(own) <= set(hidden_parts(scene, names)) for own, scene in zip(each, scenes, strict=True)):
        raise FlexmbError("Picture", found="everything is hidden", expected="something to draw", remedy="Hide less")


def _checked(path: str | Path, endings: tuple[str, ...]) -> Path:
    """Return the path if its ending can be written and something can be drawn."""
    path = Path(path)
    if path.suffix not in endings:
        raise FlexmbError(
            f"Picture '{path}'",
            found=f"the ending '{path.suffix}'",
            expected=f"One of: {', '.join(endings)}",
            remedy="Use .png for a picture",
        )
    if path.suffix in MOVING:
        _imageio(path)
    require_graphics()
    with complaints(f"Picture '{path}'", "write"):
        path.parent.mkdir(parents=True, exist_ok=True)
    return path


def _imageio(path):
    try:
        import imageio.v2 as imageio

        if path.suffix == ".mp4":
            import imageio_ffmpeg  # noqa: F401
    except ImportError as error:
        raise FlexmbError(
            f"Animation '{path}'",
            found=f"the package {error.name} is not installed",
            expected="imageio for .gif, imageio with ffmpeg for .mp4",
            remedy="pip install 'imageio[ffmpeg]', or render single .png pictures",
        ) from error
    return imageio


def _scene(solution, times, default_all):
    """Return the scene and the numbers of the wanted frames."""
    scene = Scene(solution)
    if times is None:
        last = len(scene.times) - 1
        return scene, list(range(last + 1)) if default_all else [last]
    return scene, [scene.nearest(float(t)) for t in np.atleast_1d(times)]


def largest_stress(scene, frames) -> float:
    """Return the largest von Mises stress (Pa) of all bodies at the frames."""
    largest = 0.0
    for part in scene.parts:
        if part.data is None or not part.data.has_stress:
            continue
        for phase in {scene.samples[frame][0] for frame in frames}:
            rows = [scene.samples[frame][1] for frame in frames if scene.samples[frame][0] == phase]
            eta = scene.solution.series(phase).modal_coordinates(part.name)[rows]
            largest = max(largest, float(recover.largest_von_mises(part.data, eta).max()))
    return largest


def upwards(model):
    """Return the direction against gravity; z without gravity."""
    gravity = np.array(model.gravity)
    return -gravity if np.any(gravity) else np.array([0.0, 0.0, 1.0])


def _animate(stage, frames, path, rate):
    imageio = _imageio(path)
    more = {"loop": 0, "duration": 1000.0 / rate} if path.suffix == ".gif" else {"fps": rate, "macro_block_size": 2}
    with imageio.get_writer(path, **more) as writer:
        for frame in frames:
            stage.move_to(frame)
            writer.append_data(stage.picture())
