"""`spectra`: power spectral densities over the frequency."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.files import replacing
from flexmb.view.curves import COLORS, INK, PALE
from flexmb.view.endings import require_ending

__all__ = ["spectra"]


def spectra(plant, frequencies, densities, path: str | Path) -> Path:
    """Draw the density of every output over the frequency, outputs of one unit in one plot, and return the path.

    Parameters
    ----------
    plant : Plant
    frequencies : (nf,), Hz
        Positive; both axes are logarithmic.
    densities : (nf, p)
        One-sided, in (unit of the output)^2/Hz: the diagonals of `flexmb.spectral_response`.
    path : path
        The ending chooses the format: .png, .svg, .pdf.

    Raises
    ------
    FlexmbError
        No output moves, there are more than a picture can show, or the ending is unknown.
    """
    import matplotlib
    from matplotlib.figure import Figure

    path, G = Path(path), np.asarray(densities, float)
    moving = [k for k in range(G.shape[1]) if G[:, k].max() > 0.0]
    units = list(dict.fromkeys(plant.units[k] for k in moving))
    of_units = [[k for k in moving if plant.units[k] == unit] for unit in units]
    if not moving or max(map(len, of_units)) > len(COLORS):
        raise FlexmbError(
            f"Spectra '{path}'",
            found=f"{len(moving)} outputs that move",
            expected=f"1 to {len(COLORS)} of each unit",
            remedy="Name the outputs to draw, such as 'tip z'",
        )
    with matplotlib.rc_context({"text.parse_math": False}):  # a dollar sign in a name is a dollar sign
        figure = Figure(figsize=(8.0, 1.2 + 3.2 * len(units)), layout="constrained", dpi=130)
        require_ending(figure, path, "Spectra")
        axes = figure.subplots(len(units), 1, sharex=True, squeeze=False)[:, 0]
        for ax, unit, own in zip(axes, units, of_units, strict=True):
            for color, k in zip(COLORS, own):
                ax.plot(
                    frequencies, np.where(G[:, k] > 0.0, G[:, k], np.nan), color=color, lw=1.5, label=plant.outputs[k]
                )
            ax.set_xscale("log")
            ax.set_yscale("log")
            ax.set_ylabel(f"density [({unit})²/Hz]" if unit else "density [1/Hz]", color=INK)
            ax.xaxis.set_major_formatter("{x:g}")
            ax.yaxis.set_major_formatter("{x:.0e}")
            ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, frameon=False, fontsize=8)
            ax.grid(True, which="major", color=PALE, lw=0.8)
            ax.tick_params(colors=INK)
            for side in ("top", "right"):
                ax.spines[side].set_visible(False)
        axes[-1].set_xlabel("frequency [Hz]", color=INK)
        with replacing(path, f"Spectra '{path}'", folder=True) as file:
            figure.savefig(file)
    return path
