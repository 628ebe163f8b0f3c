"""`root_loci`: the poles of a mechanism over a parameter, as a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb.files import replacing
from flexmb.view.curves import COLORS, INK, PALE
from flexmb.view.endings import require_ending

__all__ = ["root_loci"]

RAYS = (0.05, 0.1, 0.2, 0.4, 0.7)
"""Damping ratios along whose rays grey lines are drawn."""


def root_loci(locus, path: str | Path, *, name: str = "parameter", limits: bool = True) -> Path:
    """Draw poles in the complex plane, from circles at the first value to crosses at the last, and return the path.

    Values at which a motion begins to grow are in the legend, with its frequency; the unstable half is grey. Of
    conjugate pairs both are drawn.

    Parameters
    ----------
    locus : RootLocus
        The result of ``root_locus(model, values)``.
    path : path
        The ending chooses the format: .png, .svg, .pdf.
    name : str
        Of the parameter.
    limits : bool
        Seek the values at which stability ends, by new models between the values.

    Raises
    ------
    FlexmbError
        The ending is unknown.
    """
    import matplotlib
    from matplotlib.figure import Figure

    path = Path(path)
    with matplotlib.rc_context({"text.parse_math": False}):
        figure = Figure(figsize=(7.5, 6.0), layout="constrained", dpi=130)
        require_ending(figure, path, "Root loci")
        ax = figure.subplots()
        moving = _spread(locus.poles)
        _frame(ax, locus.poles[:, moving])
        for k, column in enumerate(np.flatnonzero(moving)):
            poles, color = locus.poles[:, column], COLORS[k % len(COLORS)]
            ax.plot(poles.real, poles.imag, "-", marker=".", ms=3, lw=1.2, color=color)
            ax.plot(poles.real[0], poles.imag[0], "o", ms=6, mfc="none", color=color)
            ax.plot(poles.real[-1], poles.imag[-1], "x", ms=6, color=color)
        first, last = locus.values[0], locus.values[-1]
        ax.set_title(f"o  {name} = {first:.6g}     x  {name} = {last:.6g}", loc="left", fontsize=10, color=INK)
        for value, pole in locus.crossings() if limits else ():
            ax.plot([0.0, 0.0], [pole.imag, -pole.imag], "D", ms=6, color=INK, label=_told(name, value, pole))
        if ax.get_legend_handles_labels()[0]:
            ax.legend(loc="best", frameon=False, fontsize=9)
        with replacing(path, f"Root loci '{path}'", folder=True) as file:
            figure.savefig(file)
    return path


def _told(name: str, value: float, pole: complex) -> str:
    frequency = abs(pole.imag) / (2.0 * np.pi)
    return f"limit at {name} = {value:.6g}" + (f", {frequency:.4g} Hz" if frequency > 0.0 else "")


def _spread(poles: np.ndarray) -> np.ndarray:
    """Return which poles are drawn: those that move, or are not far beyond all that move, (n,) bool."""
    moved = np.abs(poles - poles[0]).max(axis=0)
    size = np.abs(poles).max(axis=0)
    moving = moved > 1e-6 * np.maximum(size, 1e-300)
    if not moving.any():
        return np.ones(len(size), bool)
    return moving | (size <= size[moving].max())


def _frame(ax, poles: np.ndarray) -> None:
    """Draw the axes, the unstable half and the rays of damping ratios."""
    low, high = float(poles.real.min()), float(poles.real.max())
    reach, tall = max(high - low, 1e-12), max(float(np.abs(poles.imag).max()), 1e-12)
    left, right = min(low, 0.0) - 0.08 * reach, max(high, 0.0) + 0.08 * reach
    ax.axvspan(0.0, right, color=PALE, alpha=0.5, lw=0)
    for ratio in RAYS:
        far = min(-left / ratio, 1.1 * tall / np.sqrt(1.0 - ratio * ratio))
        for half in (1.0, -1.0):
            ax.plot([0.0, -ratio * far], [0.0, half * far * np.sqrt(1.0 - ratio * ratio)], color=PALE, lw=0.8)
        ax.annotate(f"{100 * ratio:g} %", (-ratio * far, far * np.sqrt(1.0 - ratio * ratio)), fontsize=7, color=INK)
    ax.axvline(0.0, color=INK, lw=0.8)
    ax.axhline(0.0, color=INK, lw=0.8)
    ax.set(xlim=(left, right), ylim=(-1.12 * tall, 1.12 * tall))
    ax.set_xlabel("real part [1/s]", color=INK)
    ax.set_ylabel("imaginary part [rad/s]", color=INK)
    ax.tick_params(colors=INK)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
