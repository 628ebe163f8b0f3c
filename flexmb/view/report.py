"""`report`: one run, or several compared, as a web page that needs no other file."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import DataFileError, FlexmbError, did_you_mean, listed
from flexmb.io.scene import Scene
from flexmb.io.web_page import page
from flexmb.view import report_model, report_results, report_stress, report_trust
from flexmb.view.curves import COLORS
from flexmb.view.graphics import require_graphics
from flexmb.view.labels import Labels, known_labels, places, refuse_unknown
from flexmb.view.pictures import hidden_parts, largest_stress, require_hidden, upwards
from flexmb.view.report_results import Run, event_times
from flexmb.view.stage import Stage

__all__ = ["report"]

STYLE = """
h3 { font-size: 1em; margin: 1em 0 0.2em } summary { cursor: pointer; color: #66727e; margin-top: 0.6em }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(30em, 1fr)); gap: 0.6em 1.6em }
.stills { display: grid; grid-template-columns: repeat(3, 1fr); gap: 0.6em }
figure { margin: 0.4em 0; break-inside: avoid } figure svg { width: 100%; height: auto; display: block }
figcaption { font-weight: 600; font-size: 0.93em } figcaption .note { font-weight: 400 }
.event { border-left: 4px solid #1f5fa8; padding: 0.3em 0.8em; background: #eaf1f9; margin: 0.4em 0 }
.scroll { overflow-x: auto }
@media print { body { font-size: 11px; margin: 0; max-width: none } .figures { grid-template-columns: 1fr 1fr }
  h2 { break-after: avoid } tr { break-inside: avoid } details:not([open]) { display: none } .scroll { overflow: visible
  } }
"""
STILLS = 3
PIXELS = (960, 600)


def report(
    runs: Any,
    path: str | Path,
    *,
    checks: Mapping[str, Any] | None = None,
    verified: Mapping[str, Any] | None = None,
    pictures: bool = True,
    camera=None,
    labels: Labels | None = None,
    diagrams: Sequence[Any] = (),
    hide: Sequence[str] = (),
) -> Path:
    """Write a report and return its path: model, mobility, pictures, curves, loads, energy, modes, solver.

    Parameters
    ----------
    runs : Solution, or mapping of name to Solution
        Several runs are laid over one another, with the parameters in which they differ.
    path : path
        ``.html``.
    checks : mapping of name to Report, optional
        What `flexmb.check` found about the models of the runs.
    verified : mapping of name to Verification, optional
        What `flexmb.verify` found about the runs.
    pictures : bool
        Draw still pictures; a machine that cannot draw leaves them out and says so in the page.
    camera : (3,), or mapping of run to (3,), optional
        Direction to look from; runs that are not named have their own.
    labels : mapping of text to marker or body, or "bodies", optional
        Texts in the pictures, as in `render`, of the runs that have the marker or body.
    diagrams : sequence of Diagram or text
        Sensors over others, of all runs on one scale: "flap angle over lever angle". They come before the curves.
    hide : sequence of str
        What the pictures leave out, as in `render`: bodies that some run draws, "joints", "springs" or "supports".

    Raises
    ------
    FlexmbError
        There is no run, the ending is unknown, or the file cannot be written.
    """
    path, given = Path(path), runs if isinstance(runs, Mapping) else {"run": runs}
    if path.suffix != ".html":
        raise FlexmbError(
            f"Report '{path}'", found=f"the ending '{path.suffix}'", expected=".html", remedy="Name it report.html"
        )
    if not given:
        raise FlexmbError("Report", found="there is no run", expected="at least one", remedy="Give a solution")
    if isinstance(camera, Mapping):
        _require_runs(camera, list(map(str, given)))
    named = [Run(str(name), solution, COLORS[k % len(COLORS)]) for k, (name, solution) in enumerate(given.items())]
    text = _page(named, checks or {}, verified or {}, pictures, camera, labels or {}, diagrams, hide)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", errors="replace")
    except OSError as error:
        raise DataFileError(
            f"Report '{path}'",
            found=f"cannot write it ({error.strerror})",
            expected="a writable folder with free space",
            remedy="Choose another place",
        ) from error
    return path


def _require_runs(camera: Mapping[str, Any], runs: Sequence[str]) -> None:
    """FlexmbError for a direction of a run that is not in the report."""
    for name in camera:
        if str(name) not in runs:
            raise FlexmbError(
                "Report, camera",
                found=f"a direction for '{name}'",
                expected=f"names of runs: {listed(str(name), runs)}",
                remedy=did_you_mean(str(name), runs) or "Correct the name, or take the direction out",
            )


def _page(
    runs: list[Run],
    checks: Mapping[str, Any],
    verified: Mapping[str, Any],
    pictures: bool,
    camera,
    labels: Labels,
    diagrams=(),
    hide: Sequence[str] = (),
) -> str:
    described = runs[0].solution.model
    name = described.name if described is not None else runs[0].name
    several = len(runs) > 1
    parts = [f"<h1>{escape(name)}</h1>", _summary(runs), report_model.notices(runs, checks)]
    if several:
        parts.append(report_model.differences(runs))
    if pictures:
        parts.append(_stills(runs, camera, labels, (hide,) if isinstance(hide, str) else tuple(hide)))
    parts.append(report_results.diagrams(runs, diagrams))
    parts += [report_results.curves(runs), _wide(report_results.extremes(runs)), _wide(report_results.loads(runs))]
    parts += [_wide(report_stress.stresses(runs)), report_results.energy(runs), report_trust.trust(runs, verified)]
    if described is not None:
        parts += [report_model.mobility(runs, checks), report_model.model(described)]
        parts += ["" if several else report_model.parameters(described), report_model.modes(described)]
    parts.append(_wide(report_model.solver(runs)))
    return page(f"{name}: {', '.join(run.name for run in runs)}", [part for part in parts if part], STYLE)


def _wide(section: str) -> str:
    return f'<div class="scroll">{section}</div>' if section else ""


def _summary(runs: list[Run]) -> str:
    first = runs[0].solution
    if first.model is None:
        counts = "The model is not stored with the solution"
    else:
        m = first.model
        families = {"joint": m.joints, "force": m.forces, "sensor": m.sensors}
        counts = ", ".join(report_model.counted(len(parts), what) for what, parts in families.items())
        counts = f"{len(m.bodies)} bodies, {counts}"
    span = f"t = {first.t[0]:g} to {first.t[-1]:g} s, {len(first.t)} samples"
    if len(runs) == 1:
        return f"<p>{escape(runs[0].name)}: {counts}; {span}</p>"
    marked = ", ".join(f'<span style="color:{run.color}">&#9632;</span> {escape(run.name)}' for run in runs)
    return f"<p>{len(runs)} runs: {marked}</p><p class='note'>{counts}; {span} (first run)</p>"


def _stills(runs: list[Run], camera, labels: Labels, hide: tuple[str, ...]) -> str:
    """Pictures at the start, at events (or half way) and at the end; of several runs their ends."""
    scenes = [(run, Scene(run.solution)) for run in runs if run.solution.model is not None]
    require_hidden([scene for _, scene in scenes], hide)
    gone = [hidden_parts(scene, hide) for _, scene in scenes]
    refuse_unknown([scene for _, scene in scenes], labels, tuple(name for own in gone for name in own))
    try:
        require_graphics()
    except FlexmbError as error:
        return f'<h2>Pictures</h2><p class="note">None: {escape(str(error))}</p>'
    figures = []
    most = max(
        (largest_stress(scene, range(len(scene.times))) for _, scene in scenes), default=0.0
    )  # one scale for all
    for (run, scene), hidden in zip(scenes, gone, strict=True):
        frames = _chosen(scene, run.solution) if len(runs) == 1 else [len(scene.times) - 1]
        stage = Stage(scene, PIXELS, most, hide=hidden)
        try:
            stage.add_state(frames[0])
            toward = camera.get(run.name) if isinstance(camera, Mapping) else camera
            stage.look_from(toward, upwards(run.solution.model), list(range(len(scene.times))))
            own = known_labels(scene, labels, hidden)
            for frame in frames:
                stage.move_to(frame)
                stage.label(*places(scene, own, frame, hidden))
                title = f"t = {scene.times[frame]:.4g} s" + (f", {run.name}" if len(runs) > 1 else "")
                figures.append(report_results.figure(title, _image(stage.picture(), title)))
        finally:
            stage.close()
    return f'<h2>Pictures</h2><div class="stills">{"".join(figures)}</div>' if figures else ""


def _chosen(scene: Scene, solution) -> list[int]:
    first, last = scene.times[0], scene.times[-1]
    times = [first, *(event_times(solution)[: STILLS - 2] or [0.5 * (first + last)]), last]
    return list(dict.fromkeys(scene.nearest(t) for t in times))


def _image(pixels: np.ndarray, title: str) -> str:
    from matplotlib.image import imsave

    stream = io.BytesIO()
    imsave(stream, pixels, format="png")
    encoded = base64.b64encode(stream.getvalue()).decode("ascii")
    return f'<img alt="{escape(title)}" src="data:image/png;base64,{encoded}">'
