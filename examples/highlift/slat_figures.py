"""Curves of the slats: rollers and pinions of slat 1 in operation, and after the loss of a roller. Rigid slats whose
rollers are springs along fixed radii, the same with rollers as cylinders in circles of the racks, and elastic slats.

Run it with: python examples/highlift/slat_figures.py [picture]   (two minutes for six runs)
"""

import sys

import numpy as np
from figures import BLUE, ORANGE, dress, run

SIDES = ("left", "right")
VARIANTS = (
    ({"rigid": True}, "-", ""),
    ({"rigid": True, "profiles": True}, "--", ", profiles"),
    ({"rigid": False}, ":", ", elastic"),
)
"""Parameters, line style and label of the variants that are drawn."""


def contact(solution, name: str, sign: float = 1.0) -> np.ndarray:
    """Return the force of a roller, both of its contacts, on the rack, kN, away from the centre of the rack."""
    return sign * sum(np.nan_to_num(solution[f"s1_{name} {side} force"][:, 2]) for side in SIDES) / 1e3


def draw(axes, given: dict, style: str, label: str) -> None:
    """Draw the figures of one variant."""
    sound, broken = run("slats", **given), run("slat_roller_lost", **given)
    sign = -1.0 if given.get("profiles") else 1.0  # profiles tell the force on the roller
    for track, colour in (("t1", BLUE), ("t2", ORANGE)):
        what = "fixed" if track == "t1" else "free"
        for pair in ("front", "rear"):
            force = contact(sound, f"{track}_{pair} outer", sign) + contact(sound, f"{track}_{pair} inner", sign)
            axes[0].plot(sound.t, force, style, color=colour, label=f"{what}{label}" if pair == "front" else None)
        axes[1].plot(sound.t, sound[f"s1_{track}_tooth force"][:, 5], style, color=colour, label=f"{what}{label}")
        lost = contact(broken, f"{track}_front outer", sign)
        axes[2].plot(broken.t, lost, style, color=colour, label=f"{what}, roller{label}")
    edge = broken["s1_t2_front outer edge force"][:, 2] / 1e3
    axes[2].plot(broken.t, edge, style, color="tab:red", label=f"free, edge of the opening{label}")


def main(picture: str = "slats.png") -> None:
    """Write the picture."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(13.0, 4.2), layout="constrained")
    for given, style, label in VARIANTS:
        draw(axes, given, style, label)
    dress(axes, ("pairs of rollers, fixed and free track [kN]", "pinions [N m]", "front roller lost at 0.65 s [kN]"))
    axes[2].set_xlim(0.6, 1.0)
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    main(*sys.argv[1:])
