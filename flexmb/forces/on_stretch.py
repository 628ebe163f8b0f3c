"""What forces on a stretch of a cable or beam share: its name checked, its points as bulk data."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmb.errors import ModelError, did_you_mean

__all__ = ["check_stretch", "require_stretch_name", "stretch_points"]


def require_stretch_name(force) -> None:
    """Raise ModelError unless the field `stretch` is "body.stretch"."""
    if not isinstance(force.stretch, str) or "." not in force.stretch:
        raise ModelError(
            force.title,
            found=f"stretch = {force.stretch!r}",
            expected="'body.stretch'",
            remedy="Write stretch='belt.all' and stretches={'all': (0.0, 1.0)} in the body",
        )


def check_stretch(force, model) -> None:
    """Raise ModelError if the body of the field `stretch` has no stretch of this name."""
    name, _, stretch = force.stretch.partition(".")
    known = tuple(getattr(model.body(name, force.title), "loaded_stretches", ()))
    if stretch not in known:
        raise ModelError(
            force.title,
            found=f"body '{name}' has no stretch '{stretch}'",
            expected=f"One of: {', '.join(known)}" if known else "an AncfCable or AncfBeam with stretches",
            remedy=did_you_mean(stretch, known) or f"Write stretches={{'{stretch}': (0.0, 1.0)}}",
        )


def stretch_points(force, compiler, pair: Callable[[int], int]) -> tuple[int, int]:
    """Return where the points of the stretch begin in the bulk data (marker, pair, length of each), and their number.

    `pair` gives the number of the pair of a marker's number, or -1.
    """
    name, _, stretch = force.stretch.partition(".")
    there = compiler.model.body(name).loaded_stretches[stretch]
    markers = [compiler.marker(f"{name}.{marker}") for marker in there.markers]
    return compiler.bulk(np.stack([markers, [pair(b) for b in markers], there.weights], axis=1)), len(markers)
