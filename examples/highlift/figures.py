"""Curves of the high-lift system laid out like Figs. 16-21 of Zierath, Woernle & Heyden, rigid beside elastic.

Run it with: python examples/highlift/figures.py [picture]   (a minute for four runs)
"""

import sys
import tomllib
from pathlib import Path

import numpy as np

import flexmb as fmb

FOLDER = Path(__file__).parent
BLUE, ORANGE, GREY = "tab:blue", "tab:orange", "0.6"
STOPS = tomllib.loads((FOLDER / "parameters.toml").read_text())["trailing_edge"]["interconnection_strut"]["free_travel"]
FAILURE = 1.8  # s, until the stationary values after the failure show


def run(case: str, rigid: bool, t_end: float = 1.0, **others) -> fmb.Solution:
    """Return the solution of a case with parameters set, a thousand samples a second."""
    given = {"rigid": rigid, **others}
    settings = fmb.load_simulation(FOLDER / f"{case}.toml", given, t_end=t_end, samples=round(1000 * t_end) + 1)
    return fmb.simulate(fmb.load_model(FOLDER / f"{case}.toml", given), **settings.keywords())


def draw(axes, operation: fmb.Solution, failure: fmb.Solution, style: str, label: str) -> None:
    """Draw the six figures of one variant."""
    t = operation.t
    forces = {k: f"inboard_t{k}_strut force" for k in (1, 2)}
    before = float(np.interp(0.645, failure.t, failure[forces[1]][:, 0]))
    for name, colour in (("inboard_t2", BLUE), ("outboard_t3", ORANGE)):
        lever, angle = (np.degrees(operation[f"{name}_{what} angle"]) for what in ("lever", "flap"))
        axes[0].plot(t, angle, style, color=colour, label=f"{name.split('_')[0]} flap{label}")
        if not label:  # prescribed: the same in both variants
            axes[0].plot(t, lever, "-.", color=colour, linewidth=0.9, label=f"{name.split('_')[0]} actuator")
    axes[1].plot(t, 1e3 * operation["interconnection travel"], style, color=BLUE, label=f"operation{label}")
    for k, colour in ((1, BLUE), (2, ORANGE)):
        axes[2].plot(t, operation[forces[k]][:, 0] / before, style, color=colour, label=f"track {k}{label}")
        axes[3].plot(failure.t, failure[forces[k]][:, 0] / before, style, color=colour, label=f"track {k}{label}")
    axes[4].plot(t, 1e3 * operation["interconnection travel"], style, color=BLUE, label=f"operation{label}")
    axes[4].plot(failure.t, 1e3 * failure["interconnection travel"], style, color=ORANGE, label=f"failure{label}")
    axes[5].plot(failure.t, failure["interconnection force"][:, 2] / before, style, color=BLUE, label=f"strut{label}")


def dress(axes, titles) -> None:
    """Give the diagrams their titles, legends and grids."""
    for ax, title in zip(axes, titles):
        ax.set_title(title, fontsize=10)
        ax.legend(fontsize=8, framealpha=0.7)
        ax.tick_params(labelsize=8)
        ax.grid(color="0.9")


def main(picture: str = "high_lift.png") -> None:
    """Write the picture."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 3, figsize=(13.0, 7.4), layout="constrained")
    axes = axes.ravel()
    strut = "interconnection strut"
    titles = (
        "flaps and actuators [deg]",
        f"{strut} [mm]",
        "drive struts / track 1 at 0.645 s",
        "the same, failure",
        f"{strut} [mm]",
        f"{strut} / track 1 before",
    )
    for rigid, style, label in ((True, "-", ""), (False, ":", ", elastic")):
        draw(axes, run("operation", rigid), run("strut_2_breaks", rigid, FAILURE), style, label)
    dress(axes, [f"{title}, cf. Fig. {number}" for number, title in enumerate(titles, 16)])
    for ax in (axes[1], axes[4]):
        for stop in STOPS:
            ax.axhline(1e3 * stop, color=GREY, linewidth=0.8)
    low, high = (f(ax.get_ylim()[k] for ax in axes[2:4]) for k, f in enumerate((min, max)))
    for ax in axes[2:4]:  # operation and failure on one scale
        ax.set_ylim(low, high)
    for ax in axes[3:]:
        ax.set_xlim(0.5, FAILURE)
    for ax in axes:
        ax.set_xlabel("t [s]", fontsize=8)
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    main(*sys.argv[1:])
