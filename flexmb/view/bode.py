"""`bode`: gain and phase of a plant over the frequency."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.files import replacing
from flexmb.view.curves import COLORS, INK, PALE
from flexmb.view.endings import require_ending

__all__ = ["bode"]

MOST = 4
"""Inputs beside each other."""
NOTHING = 1e-12
"""Of the largest response in the same unit: what is less is rounding, and is not drawn."""


def bode(plant, frequencies, path: str | Path) -> Path:
    """Draw gain and phase of every output over the frequency, a column for each input, and return the path.

    Responses that are zero are left out.

    Parameters
    ----------
    plant : Plant
        The result of ``linearize(model, inputs=..., outputs=...)``.
    frequencies : (nf,), Hz
        Positive; the axis is logarithmic.
    path : path
        The ending chooses the format: .png, .svg, .pdf.

    Raises
    ------
    FlexmbError
        More curves than a picture can show, none at all, or a frequency that is not positive.
    """
    import matplotlib

    path, f = Path(path), np.atleast_1d(np.asarray(frequencies, float))
    if not np.all(f > 0.0) or len(f) < 2:
        raise FlexmbError(
            f"Bode plot '{path}'",
            found="fewer than two frequencies, or one that is not positive",
            expected="positive frequencies, Hz: their axis is logarithmic",
            remedy="Begin above zero",
        )
    H = plant.frequency_response(f)
    drawn = _drawn(plant, H)
    if not drawn.any():
        raise FlexmbError(
            f"Bode plot '{path}'",
            found="no output answers any input",
            expected="an output that the inputs move",
            remedy="Name other inputs or outputs",
        )
    columns = np.flatnonzero(drawn.any(axis=0))
    if len(columns) > MOST or drawn.sum(axis=0).max() > len(COLORS):
        raise FlexmbError(
            f"Bode plot '{path}'",
            found=f"{int(drawn.sum())} curves of {len(columns)} inputs",
            expected=f"at most {MOST} inputs and {len(COLORS)} outputs",
            remedy="Name the inputs and outputs to draw, such as 'tip z'",
        )
    with matplotlib.rc_context({"text.parse_math": False}):  # a dollar sign in a name is a dollar sign
        return _written(plant, f, H, drawn, columns, path)


def _drawn(plant, H: np.ndarray) -> np.ndarray:
    """Return which responses (p, m) are more than rounding."""
    size = np.abs(H).max(axis=0)
    largest = np.array([size[[unit == own for unit in plant.units]].max(axis=0) for own in plant.units])
    return (size > NOTHING * largest) & (size > 0.0)


def _written(plant, f, H, drawn, columns, path: Path) -> Path:
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    figure = Figure(figsize=(2.0 + 6.0 * len(columns), 6.0), layout="constrained", dpi=130)
    require_ending(figure, path, "Bode plot")
    axes = figure.subplots(2, len(columns), sharex=True, squeeze=False, height_ratios=(3, 2))
    for (gain, phase), column in zip(axes.T, columns, strict=True):
        for color, row in zip(COLORS, np.flatnonzero(drawn[:, column])):
            label = f"{plant.outputs[row]} [{plant.units[row]}]" if plant.units[row] else plant.outputs[row]
            gain.plot(f, np.abs(H[:, row, column]), color=color, lw=1.5, label=label)
            phase.plot(f, _phase(H[:, row, column]), color=color, lw=1.5)
        gain.set_yscale("log")
        gain.set_xscale("log")
        gain.set_xlim(f.min(), f.max())
        for axis in (gain.yaxis, phase.xaxis):  # plain numbers: powers of ten would be formulas
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
        gain.set_title(f"per unit of {plant.inputs[column]}", loc="left", fontsize=10, color=INK, pad=26)
        gain.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, frameon=False, fontsize=8, borderaxespad=0.2)
        _quarters(phase)
        phase.set_xlabel("frequency [Hz]", color=INK)
        for ax in (gain, phase):
            ax.grid(True, which="major", color=PALE, lw=0.8)
            ax.tick_params(colors=INK)
            for side in ("top", "right"):
                ax.spines[side].set_visible(False)
    axes[0, 0].set_ylabel("gain", color=INK)
    axes[1, 0].set_ylabel("phase [deg]", color=INK)
    with replacing(path, f"Bode plot '{path}'", folder=True) as file:
        figure.savefig(file)
    return path


def _phase(H: np.ndarray) -> np.ndarray:
    """Return the phase in degrees without jumps of a full turn."""
    return np.degrees(np.unwrap(np.angle(H)))


def _quarters(ax) -> None:
    """Set the ticks of a phase to whole eighths, quarters or halves of a turn, at most eight."""
    from matplotlib.ticker import MultipleLocator

    low, high = ax.get_ylim()
    step = next((step for step in (45.0, 90.0, 180.0, 360.0) if high - low <= 8.0 * step), 720.0)
    ax.yaxis.set_major_locator(MultipleLocator(step))
