"""Curves of the slats: rollers and pinions of slat 1 in operation, and after the loss of a roller, rigid beside
elastic.

Run it with: python examples/highlift/slat_figures.py [picture]   (a minute for four runs)
"""

import sys

import numpy as np
from figures import BLUE, ORANGE, dress, run

SIDES = ("left", "right")


def contact(solution, name: str) -> np.ndarray:
    """Return the force of a roller, both of its contacts, on the rack, kN, away from the centre of the rack."""
    return sum(np.nan_to_num(solution[f"s1_{name} {side} force"][:, 2]) for side in SIDES) / 1e3


def draw(axes, rigid: bool, style: str, label: str) -> None:
    """Draw the figures of one variant."""
    sound, broken = run("slats", rigid), run("slat_roller_lost", rigid)
    for track, colour in (("t1", BLUE), ("t2", ORANGE)):
        what = "fixed" if track == "t1" else "free"
        for pair in ("front", "rear"):
            force = contact(sound, f"{track}_{pair} outer") + contact(sound, f"{track}_{pair} inner")
            axes[0].plot(sound.t, force, style, color=colour, label=f"{what}{label}" if pair == "front" else None)
        axes[1].plot(sound.t, sound[f"s1_{track}_tooth force"][:, 5], style, color=colour, label=f"{what}{label}")
        axes[2].plot(
            broken.t, contact(broken, f"{track}_front outer"), style, color=colour, label=f"{what}, roller{label}"
        )
    edge = broken["s1_t2_front outer edge force"][:, 2] / 1e3
    axes[2].plot(broken.t, edge, style, color="tab:red", label=f"free, edge of the opening{label}")


def main(picture: str = "slats.png") -> None:
    """Write the picture."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(13.0, 4.2), layout="constrained")
    for rigid, style, label in ((True, "-", ""), (False, ":", ", elastic")):
        draw(axes, rigid, style, label)
    dress(axes, ("pairs of rollers, fixed and free track [kN]", "pinions [N m]", "front roller lost at 0.65 s [kN]"))
    axes[2].set_xlim(0.6, 1.0)
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    main(*sys.argv[1:])
