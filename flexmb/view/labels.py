"""Texts in still pictures: at a marker, at the middle of a body, or the name of every body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flexmb.errors import FlexmbError, did_you_mean, listed
from flexmb.io.drawn_parts import DrawnPart
from flexmb.io.scene import Scene

__all__ = ["BODIES", "Labels", "known_labels", "places", "refuse_unknown", "without_overlap"]

Labels = Mapping[str, str] | str
BODIES = "bodies"
"""In place of a marker: every body that is drawn, by its name."""
LAYERS = ("joints", "springs", "supports", "contact")
"""What is drawn and is no body."""
WIDTH, HEIGHT = 0.56, 1.3
"""Of a letter, and of a line, over the size of the font."""
LINE = 1.6
"""From one text to the next above it, with their frames, over the size of the font."""


def places(
    scene: Scene, labels: Labels | None, frame: int, hide: tuple[str, ...] = ()
) -> tuple[dict[str, np.ndarray], int]:
    """Return the places (3,), m, in W of the labels at a frame, and how many are given by themselves: they come first,
    then the names of bodies, large ones first."""
    bodies = _drawn_bodies(scene, hide)
    phase, row = scene.samples[frame]
    series = scene.solution.series(phase)
    found, every = {}, False
    for text, at in _pairs(labels):
        if at in bodies:
            found[text] = _middle(_points(scene, bodies[at], frame))
        elif at == BODIES:
            every = True
        else:
            _refuse(scene, text, at, hide)
            found[text] = series.marker(at).r[row]
    given = len(found)
    if every:
        named = {at for _, at in _pairs(labels)}
        drawn = [(name, _points(scene, part, frame)) for name, part in bodies.items() if name not in named]
        drawn.sort(key=lambda one: -float(np.linalg.norm(np.ptp(one[1], axis=0))))
        found |= {name: _middle(points) for name, points in drawn if name not in found}
    return found, given


def known_labels(scene: Scene, labels: Labels, hide: tuple[str, ...] = ()) -> dict[str, str]:
    """Return those of the labels that a scene has a place for: markers, and bodies that are drawn."""
    known = {*scene.solution.model.marker_names(), *_drawn_bodies(scene, hide), BODIES}
    return {text: at for text, at in _pairs(labels) if at in known}


def refuse_unknown(scenes: Sequence[Scene], labels: Labels | None, hide: tuple[str, ...] = ()) -> None:
    """FlexmbError for a label at what none of the scenes has."""
    known = [known_labels(scene, labels or {}, hide) for scene in scenes]
    for text, at in _pairs(labels):
        if scenes and not any(text in one for one in known):
            _refuse(scenes[0], text, at, hide)


def without_overlap(
    texts: Sequence[str], seen: np.ndarray, font: float, picture: tuple[int, int], given: int = 0
) -> dict[str, np.ndarray]:
    """Return where texts (2,), pixels, are written without covering one another, earlier ones first.

    Parameters
    ----------
    texts : sequence of str
    seen : (n, 2), pixels
        What they name in the picture: they begin there if there is room.
    font : float, pixels
        Size of the letters.
    picture : (int, int), pixels
        Width and height.
    given : int
        So many of the first ones are moved into the picture, and up or down to the nearest room; later ones without
        room are left out.
    """
    kept: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for number, (text, at) in enumerate(zip(texts, seen, strict=True)):
        size = font * np.array([WIDTH * len(text) + 1.0, HEIGHT])
        places = [np.asarray(at)]
        if number < given:
            inside = np.clip(at, 0.0, np.maximum(np.array(picture) - size, 0.0))
            moved = [inside + [0.0, lines * LINE * font] for lines in _from_zero(3 * len(texts))]
            places = sorted(moved, key=lambda place: not 0.0 <= place[1] <= picture[1] - size[1])  # inside first
        for place in places:
            if all(np.any((place >= other + extent) | (other >= place + size)) for other, extent in kept.values()):
                kept[text] = place, size
                break
    return {text: place for text, (place, _) in kept.items()}


def _from_zero(most: int) -> list[int]:
    """Return 0, 1, -1, 2, -2, ... most, -most."""
    return sorted(range(-most, most + 1), key=lambda number: (abs(number), -number))


def _pairs(labels: Labels | None) -> list[tuple[str, str]]:
    """Return (text, marker or body) of all labels."""
    if isinstance(labels, str):
        return [(labels, labels)]
    return list((labels or {}).items())


def _middle(points: np.ndarray) -> np.ndarray:
    """Return the middle (3,), m, of what is drawn of a body."""
    return 0.5 * (points.min(axis=0) + points.max(axis=0))


def _drawn_bodies(scene: Scene, hide: tuple[str, ...]) -> dict[str, DrawnPart]:
    """Return the bodies that are drawn, by name."""
    return {part.name: part for part in scene.parts if part.look not in LAYERS and part.name not in hide}


def _points(scene: Scene, part: DrawnPart, frame: int) -> np.ndarray:
    """Return where a part is, (n, 3), m."""
    return scene.points(part, frame, np.arange(len(part.points)))


def _refuse(scene: Scene, text: str, at: str, hide: tuple[str, ...]) -> None:
    """FlexmbError where a label names neither a marker nor one of the bodies that are drawn."""
    model, bodies = scene.solution.model, _drawn_bodies(scene, hide)
    if "." in at:
        model.marker(at, f"Picture, label '{text}'")
        return
    own = [name for name in model.marker_names() if name.partition(".")[0] == at]
    there = any(body.name == at for body in model.bodies)
    remedy = f"Write '{own[0]}', a marker of it" if own else "Take its label out"
    raise FlexmbError(
        f"Picture, label '{text}'",
        found=f"the body '{at}' is not drawn" if there else f"there is no body '{at}' that is drawn",
        expected=f"a marker (body.marker), bodies for all by their names, or one of: {listed(at, bodies)}",
        remedy=remedy if there else did_you_mean(at, [*bodies, BODIES]) or "Correct the name",
    )
