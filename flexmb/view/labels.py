"""Texts in still pictures: at a marker, at the middle of a body, or the name of every body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flexmb.errors import FlexmbError, did_you_mean
from flexmb.io.scene import Scene

__all__ = ["BODIES", "Labels", "known_labels", "places", "refuse_unknown", "without_overlap"]

Labels = Mapping[str, str] | str
BODIES = "bodies"
"""In place of a marker: every body that is drawn, by its name."""
LAYERS = ("joints", "springs", "supports")
WIDTH, HEIGHT = 0.56, 1.3
"""Of a letter, and of a line, over the size of the font."""


def places(
    scene: Scene, labels: Labels | None, frame: int, hide: tuple[str, ...] = ()
) -> tuple[dict[str, np.ndarray], int]:
    """Return the places (3,), m, in W of the labels at a frame, and how many are given by themselves: they come first,
    then the names of bodies, large ones first."""
    bodies = {part.name: part for part in scene.parts if part.look not in LAYERS and part.name not in hide}
    phase, row = scene.samples[frame]
    series = scene.solution.series(phase)
    found, every = {}, False
    for text, at in _pairs(labels):
        if at in bodies:
            found[text] = _middle(scene.snapshot(bodies[at], frame).points)
        elif at == BODIES:
            every = True
        else:
            _refuse(series.model, text, at, list(bodies))
            found[text] = series.marker(at).r[row]
    given = len(found)
    if every:
        named = {at for _, at in _pairs(labels)}
        drawn = [(name, scene.snapshot(part, frame).points) for name, part in bodies.items() if name not in named]
        drawn.sort(key=lambda one: -float(np.linalg.norm(np.ptp(one[1], axis=0))))
        found |= {name: _middle(points) for name, points in drawn if name not in found}
    return found, given


def known_labels(model, labels: Labels) -> dict[str, str]:
    """Return those of the labels that a model has a place for."""
    known = {*model.marker_names(), *(body.name for body in model.bodies), BODIES}
    return {text: at for text, at in _pairs(labels) if at in known}


def refuse_unknown(models: Sequence, labels: Labels) -> None:
    """FlexmbError for a label at what none of the models has."""
    for text, at in _pairs(labels):
        if models and not any(text in known_labels(model, labels) for model in models):
            _refuse(models[0], text, at, [body.name for body in models[0].bodies])


def without_overlap(texts: Sequence[str], seen: np.ndarray, font: float, given: int = 0) -> list[str]:
    """Return the texts that can be written without covering one another, earlier ones first.

    Parameters
    ----------
    texts : sequence of str
    seen : (n, 2), pixels
        Where they begin in the picture.
    font : float, pixels
        Size of the letters.
    given : int
        So many of the first ones are kept in any case.
    """
    kept: list[tuple[str, np.ndarray, np.ndarray]] = []
    for number, (text, at) in enumerate(zip(texts, seen, strict=True)):
        size = font * np.array([WIDTH * len(text) + 1.0, HEIGHT])
        if number < given or all(np.any((at >= other + extent) | (other >= at + size)) for _, other, extent in kept):
            kept.append((text, at, size))
    return [text for text, _, _ in kept]


def _pairs(labels: Labels | None) -> list[tuple[str, str]]:
    """Return (text, marker or body) of all labels."""
    if isinstance(labels, str):
        return [(labels, labels)]
    return list((labels or {}).items())


def _middle(points: np.ndarray) -> np.ndarray:
    """Return the middle (3,), m, of what is drawn of a body."""
    return 0.5 * (points.min(axis=0) + points.max(axis=0))


def _refuse(model, text: str, at: str, bodies: Sequence[str]) -> None:
    """FlexmbError where a label names neither a marker nor one of the bodies."""
    if "." in at:
        model.marker(at, f"Picture, label '{text}'")
        return
    raise FlexmbError(
        f"Picture, label '{text}'",
        found=f"there is no body '{at}' that is drawn",
        expected="a body, a marker (body.marker), or bodies: all by their names",
        remedy=did_you_mean(at, [*bodies, BODIES]) or f"One of: {', '.join(bodies)[:200]}",
    )
