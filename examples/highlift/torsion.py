"""High lift: how the torsional stiffness of the inboard flap shares the load between its drive struts, and why.

    track 1, yields c1      shaft, GJ over length         track 2, yields c2      c: rad per N m of pitching moment on
        |=====================================================|                    the end of the flap, levers held
       M1 + T                                                M2 - T

Without torsional stiffness each end pitches by itself: the twist d0 = c2 M2 - c1 M1. The flap resists with the torque
T = d0/(c1 + c2 + length/GJ), which it takes from track 2 and gives to track 1, and with it strut forces in proportion.
So the effect of GJ ends where c1 + c2 exceeds length/GJ, and it has the size and the sign of d0: ends that yield alike
leave nothing to share. d0, c1 + c2 and the forces per torque follow from two equilibria with the stiffness as it is,
the second with a pair of couples on the ends; the estimate then gives the forces with any other stiffness.

Run it with: python examples/highlift/torsion.py   (two minutes)
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

import flexmb as fmb

FOLDER = Path(__file__).parent
ETA = 0.8
"""Progress at which the flap is held."""
COUPLE = 200.0
"""N m on either end."""
GJ, LENGTH = 1.05e6, 3.55
"""As shipped, N m2; between tracks 1 and 2, m."""
OTHERS = (1.05e5, 5.25e5, 2.1e6, 4.2e6)
SYSTEMS = {
    "parts, rigid tracks": {"rigid": True},
    "parts, elastic tracks": {"rigid": True, "flexible": 1},
    "elastic flap, rigid tracks": {"rigid": False, "flexible": 0},
    "elastic flap and tracks": {"rigid": False},
    "the same, brackets 5 kN/mm": {"rigid": False, "track_1_bracket_stiffness": 5e6},
    "the same, brackets 20 kN/mm": {"rigid": False, "track_1_bracket_stiffness": 2e7},
    "the same, rigid brackets": {"rigid": False, "track_1_bracket_stiffness": 1e10},
    "the same, drives 12 kN/mm": {"rigid": False, **{f"track_{k}_drive_drive_stiffness": 1.2e7 for k in (1, 2)}},
    "the same, rigid drives": {"rigid": False, **{f"track_{k}_drive_drive_stiffness": 1e10 for k in (1, 2)}},
}
"""Parameters of the systems that are compared."""
S = "min(t/0.6, 1)"


def held(given: dict, eta: float, couple: float = 0.0) -> fmb.Model:
    """Return the operation with levers that stop at progress `eta` after 0.6 s, and couples on the ends of the flap."""
    model = fmb.load_model(FOLDER / "operation.toml", given)
    drives = [model.joint(f"drive {k}") for k in range(1, 6)]
    ranges = [float(drive.angle.terms[0].sample(0.0)[0]) for drive in drives]
    stops = [
        replace(drive, angle=fmb.expression(f"{eta * full!r}*(10*{S}**3 - 15*{S}**4 + 6*{S}**5)"))
        for drive, full in zip(drives, ranges)
    ]
    torques = [sensor for sensor in model.sensors if sensor.name.startswith("drive")]
    model = model.without(*(part.name for part in (*drives, *torques)))
    return model.with_parts(
        joints=stops,
        forces=[
            fmb.PointLoad("couple 1", marker="inboard_flap_root.S", moment=(0, -couple, 0)),
            fmb.PointLoad("couple 2", marker="inboard_flap_tip.R", moment=(0, couple, 0)),
        ],
        sensors=[
            *torques,
            fmb.Orientation("end 1", marker="inboard_flap_root.S"),
            fmb.Orientation("end 2", marker="inboard_flap_tip.R"),
        ],
    )


@cache
def moved(rigid: bool, flexible: int, eta: float) -> fmb.Solution:
    """Return the motion from which the equilibria begin: data as shipped."""
    return fmb.simulate(held({"rigid": rigid, "flexible": flexible}, eta), t_end=0.62, samples=5)


def at_rest(given: dict, eta: float, couple: float = 0.0) -> np.ndarray:
    """Return forces of struts 1 and 2 (N, tension) and twist of the flap (rad, end 2 against end 1) in equilibrium."""
    rigid = given["rigid"]
    start = moved(rigid, given.get("flexible", 0 if rigid else 1), eta)
    solution = fmb.statics(held(given, eta, couple), t=1.0, state=start)
    (p, _, q, _), (r, _, s, _) = (solution[f"end {k}"][-1] for k in (1, 2))
    one, two = (solution[f"inboard_t{k}_strut force"][-1, 0] for k in (1, 2))
    return np.array([one, two, 2.0 * (np.arctan2(s, r) - np.arctan2(q, p))])


def estimated(given: dict, eta: float = ETA) -> dict[str, float]:
    """Return free twist `d0` (rad), yield `c` (rad/(N m)) and what tells the forces: from two equilibria."""
    k = given.get("inboard_flap_GJ", GJ) / LENGTH
    plain, coupled = at_rest(given, eta), at_rest(given, eta, COUPLE)
    net = COUPLE - k * (coupled - plain)[2]  # of the pair of couples, what reaches the supports
    c = (coupled - plain)[2] / net
    return {"c": c, "d0": plain[2] * (1.0 + c * k), "forces": plain[:2], "per torque": (coupled - plain)[:2] / net}


def with_stiffness(estimate: dict, stiffness: float) -> np.ndarray:
    """Return the forces of struts 1 and 2 for another torsional stiffness, N m2, by the estimate."""
    torque, shipped = (estimate["d0"] / (estimate["c"] + LENGTH / value) for value in (stiffness, GJ))
    return estimate["forces"] + estimate["per torque"] * (shipped - torque)


def share(forces: np.ndarray) -> float:
    """Return the force of strut 1 over that of both."""
    return float(forces[0] / (forces[0] - forces[1]))


def main(systems: dict = SYSTEMS) -> dict[str, dict]:
    """Print and return free twist, yield, and shares over GJ, computed and estimated."""
    found = {}
    print(
        "| system | free twist [mrad] | yield [µrad/(N m)] | " + " | ".join(f"{value:.3g}" for value in OTHERS) + " |"
    )
    print("|" + "---|" * (3 + len(OTHERS)))
    for name, given in systems.items():
        estimate = estimated(given)
        computed = {value: share(at_rest({**given, "inboard_flap_GJ": value}, ETA)[:2]) for value in OTHERS}
        guessed = {value: share(with_stiffness(estimate, value)) for value in OTHERS}
        found[name] = {"computed": computed, "estimated": guessed, **estimate}
        cells = [f"{computed[value]:.4f} ({guessed[value]:.4f})" for value in OTHERS]
        print(
            f"| {name} | {1e3 * estimate['d0']:.2f} | {1e6 * estimate['c']:.2f} | " + " | ".join(cells) + " |",
            flush=True,
        )
    return found


if __name__ == "__main__":
    main()
