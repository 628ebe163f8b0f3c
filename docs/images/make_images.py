"""Draw the diagrams of the documentation from computed results: ``python docs/images/make_images.py [name ...]``.

Needs the source tree: reference solutions come from tests/verification.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot as plt

FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parents[1] / "tests"))


def rod_modes(path: Path) -> None:
    """Error of a slider-crank and a four-bar against the full FE model of the rod, over the number of modes."""
    from verification.full_model_cases import errors, full, reduced

    counts = (0, 2, 4, 8, 16, 32, 42)
    figure, axes = plt.subplots(1, 2, figsize=(8, 3.4), sharey=True, layout="constrained")
    for axis, case in zip(axes, ("slider-crank", "four-bar")):
        expected = full(case)
        table = np.array([errors(reduced(case, modes), expected) for modes in counts])
        for row, label, mark in zip(table.T, ("deflection", "force at A", "force at B", "stress"), "osd^"):
            axis.semilogy(counts, row, f"{mark}-", label=label, markersize=4)
        axis.set(title=case, xlabel="fixed-interface modes")
        axis.grid(True, alpha=0.3)
    axes[0].set(ylabel="error relative to the largest value")
    axes[1].legend()
    figure.savefig(path, dpi=120)


DIAGRAMS = {"rod_modes": rod_modes}


def main() -> None:
    """Draw all diagrams, or those named on the command line."""
    for name in sys.argv[1:] or DIAGRAMS:
        DIAGRAMS[name](FOLDER / f"{name}.png")


if __name__ == "__main__":
    main()
