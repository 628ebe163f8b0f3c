"""Curves of the leading edge laid out like Figs. 22 and 23 of Zierath, Woernle & Heyden: droop nose, rigid and elastic,
slat.

Run it with: python examples/highlift/leading_edge_figures.py [picture]   (half a minute for four
runs)
"""

import sys

import numpy as np
from figures import BLUE, GREY, ORANGE, dress, run

FULL, SLAT = 25.0, 27.0  # degrees


def draw(axes, rigid: bool, style: str, label: str) -> None:
    """Draw both figures of one variant."""
    sound, broken = run("droop_operation", rigid), run("droop_strut_breaks", rigid, 1.8)
    progress = sound["s2_lever angle"] / sound["s2_lever angle"][-1]
    angle = np.degrees(sound["s2_nose angle"])
    axes[0].plot(progress, angle / FULL, style, color=BLUE, label=f"droop nose{label}")
    axes[1].plot(progress, angle - FULL * progress, style, color=BLUE, label=f"track 2{label}")
    before = float(np.interp(0.7, sound.t, sound["s2_drive strut force"][:, 0]))
    for k, colour in ((2, BLUE), (4, ORANGE)):
        name = f"s{k}_drive strut force"
        axes[2].plot(sound.t, sound[name][:, 0] / before, style, color=GREY)
        axes[2].plot(broken.t, broken[name][:, 0] / before, style, color=colour, label=f"track {k}{label}")


def draw_slat(axes) -> None:
    """Draw the angle of slat 1, on rollers."""
    sound = run("slats", True)
    progress = sound["s1_t1_pinion angle"] / sound["s1_t1_pinion angle"][-1]
    angle = np.degrees(2.0 * np.arcsin(-sound["s1_orientation"][:, 2]))
    axes[0].plot(progress, angle / SLAT, "--", color=ORANGE, label="slat")
    axes[1].plot(progress, angle - SLAT * progress, "--", color=ORANGE, label="slat")


def main(picture: str = "leading_edge.png") -> None:
    """Write the picture."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(13.0, 4.2), layout="constrained")
    for rigid, style, label in ((True, "-", ""), (False, ":", ", elastic")):
        draw(axes, rigid, style, label)
    draw_slat(axes)
    titles = (
        "angle / full angle over progress, cf. Fig. 22",
        "departure from proportion [deg]",
        "drive struts / track 2 before, cf. Fig. 23",
    )
    dress(axes, titles)
    axes[2].set_xlim(0.5, 1.8)
    axes[2].legend(fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 0.12))
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    main(*sys.argv[1:])
