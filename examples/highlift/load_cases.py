"""Load cases of the trailing edge with elastic flaps and tracks: a table of the largest forces, case by case.

Operation, gust, jam, a lever that stays behind, a wing that is warmer than its flaps (with links that are free in
spanwise direction, and with a ball in their place), and the share of the drive struts over the stiffness of the flap.

Run it with: python examples/highlift/load_cases.py [rigid]   (fourteen runs, two minutes; rigid: half a minute)
"""

import sys
from pathlib import Path

import numpy as np

import flexmb as fmb

FOLDER = Path(__file__).parent
CASES = {
    "operation": {},
    "gust, 1.5 times at 0.75 s": {"load_set": 2, "gust_start": 0.6},
    "jam, twice the load": {"load_set": 3},
    "lever 2 behind by 2 %": {"asymmetry": 0.02},
    "lever 2 ahead by 2 %": {"asymmetry": -0.02},
    "wing longer by 1e-3": {"thermal_strain": 1e-3},
    "the same, track 3 fixed as well": {"thermal_strain": 1e-3, "t3_spanwise_free": False},
}
STIFFNESS = (
    ("inboard_flap_GJ", (1.05e5, 5.25e5, 1.05e6, 2.1e6, 4.2e6)),
    ("inboard_flap_EI_flapwise", (1.7e6, 6.8e6)),
)
ETA = 0.8
"""Progress at which the share of the struts is taken."""


def extension(**given) -> fmb.Solution:
    """Return an extension in one second with parameters set."""
    path = FOLDER / "operation.toml"
    settings = fmb.load_simulation(path, given, samples=501)
    return fmb.simulate(fmb.load_model(path, given), **settings.keywords())


def forces(solution: fmb.Solution) -> dict[str, float]:
    """Return the largest forces of an extension, kN, and its largest torque, kN m, by name."""
    largest = lambda name, column: float(np.abs(solution[name][:, column]).max()) / 1e3  # noqa: E731
    return {
        "strut 1 [kN]": largest("inboard_t1_strut force", 0),
        "strut 2 [kN]": largest("inboard_t2_strut force", 0),
        "pendulum 2 [kN]": largest("inboard_t2_pendulum force", 0),
        "strut 4 [kN]": largest("outboard_t4_strut force", 0),
        "torque 2 [kN m]": largest("drive 2 torque", 5),
        "interconnection [kN]": largest("interconnection force", 2),
        "spanwise 3 [kN]": largest("outboard_t3_flap force", 1),
    }


def share(solution: fmb.Solution) -> float:
    """Return the force of strut 1 over that of both drive struts at `ETA`."""
    eta = solution["inboard_t2_lever angle"] / solution["inboard_t2_lever angle"][-1]
    one, two = (np.interp(ETA, eta, solution[f"inboard_t{k}_strut force"][:, 0]) for k in (1, 2))
    return float(one / (one - two))


def main(rigid: bool = False) -> dict[str, dict[str, float]]:
    """Print the tables and return that of the cases."""
    table = {}
    for name, given in CASES.items():
        table[name] = forces(extension(rigid=rigid, **given))
        if len(table) == 1:
            print("| case | " + " | ".join(table[name]) + " |\n|---|" + "---|" * len(table[name]))
        print(f"| {name} | " + " | ".join(f"{value:.1f}" for value in table[name].values()) + " |", flush=True)
    for parameter, values in () if rigid else STIFFNESS:
        print(f"\n| {parameter} [N m2] | share of strut 1 at progress {ETA} |\n|---|---|")
        for value in values:
            print(f"| {value:.3g} | {share(extension(rigid=False, **{parameter: value})):.3f} |", flush=True)
    return table


if __name__ == "__main__":
    main("rigid" in sys.argv[1:])
