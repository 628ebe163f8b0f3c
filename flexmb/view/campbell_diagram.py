"""`campbell_diagram`: the frequencies of a rotating structure over its speed, as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from flexmb.files import replacing
from flexmb.view.curves import COLORS, INK
from flexmb.view.endings import require_ending

__all__ = ["campbell_diagram"]


def campbell_diagram(diagram, path: str | Path, *, orders: Sequence[float] = (1.0,)) -> Path:
    """Draw frequencies over the speed, with a ray for each order and a mark where one meets it; return the path.

    Modes that grow have circles at those speeds. The upper scale is in revolutions per minute.

    Parameters
    ----------
    diagram : Campbell
        The result of ``campbell(model, speeds)``.
    path : path
        The ending chooses the format: .png, .svg, .pdf.
    orders : sequence of float
        Of excitations: a frequency of so many times the speed.

    Raises
    ------
    FlexmbError
        The ending is unknown.
    """
    import matplotlib
    from matplotlib.figure import Figure

    path = Path(path)
    speeds, turns = diagram.speeds, 2.0 * np.pi
    with matplotlib.rc_context({"text.parse_math": False}):
        figure = Figure(figsize=(7.5, 6.0), layout="constrained", dpi=130)
        require_ending(figure, path, "Campbell diagram")
        ax = figure.subplots()
        for k, (curve, grows) in enumerate(zip(diagram.frequencies.T, diagram.grows.T, strict=True)):
            color = COLORS[k % len(COLORS)]
            ax.plot(speeds, curve, "-", lw=1.4, color=color, label=f"mode {k + 1}")
            ax.plot(np.where(grows, speeds, np.nan), curve, "o", ms=4, mfc="none", color=color)
        top = 1.08 * (float(diagram.frequencies.max()) or 1.0)
        for order in orders:
            ax.plot(speeds, order * speeds / turns, "--", lw=0.9, color=INK)
            end = min(float(speeds[-1]), top * turns / order) if order > 0.0 else float(speeds[-1])
            ax.annotate(f"{order:g} x speed", (end, min(order * end / turns, top)), ha="right", va="top", fontsize=8)
            for _, speed in diagram.critical(order):
                ax.plot(speed, order * speed / turns, "D", ms=5, color=INK)
        ax.set(xlim=(float(speeds[0]), float(speeds[-1])), ylim=(0.0, top))
        ax.set_xlabel("speed [rad/s]", color=INK)
        ax.set_ylabel(f"frequency [Hz], observed from {diagram.observer}", color=INK)
        per_minute = partial(np.multiply, 30.0 / np.pi), partial(np.multiply, np.pi / 30.0)
        upper = ax.secondary_xaxis("top", functions=per_minute)
        upper.set_xlabel("speed [rpm]", color=INK)
        ax.legend(loc="best", frameon=False, fontsize=9)
        with replacing(path, f"Campbell diagram '{path}'", folder=True) as file:
            figure.savefig(file)
    return path
