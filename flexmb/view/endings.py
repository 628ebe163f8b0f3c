"""Endings of files that a drawing can be written to."""

from __future__ import annotations

from pathlib import Path

from flexmb.errors import FlexmbError

__all__ = ["require_ending"]


def require_ending(figure, path: Path, what: str) -> None:
    """Raise FlexmbError, named after what is drawn, if matplotlib writes no file of this ending.

    The figure gets a canvas that draws without a screen.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    known = sorted(FigureCanvasAgg(figure).get_supported_filetypes())
    if path.suffix.lstrip(".") not in known:
        raise FlexmbError(
            f"{what} '{path}'",
            found=f"the ending '{path.suffix}'",
            expected=f"One of: {', '.join('.' + ending for ending in known)}",
            remedy="Use .png, .svg or .pdf",
        )
