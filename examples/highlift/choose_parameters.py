"""High lift: stiffnesses and travels with which the outcomes that the paper states hold with the widest margin.

The paper gives ratios of forces before and after the failure of a strut (Figs. 18 to 21), no data. Every ratio has an
accepted range; its margin is the distance to the nearer end, over the width of the range. The least margin of all, with
rigid and with elastic parts, is made as large as possible within what an aircraft could have (BOUNDS, as named in
`parameters.toml`).

Run it with: python examples/highlift/choose_parameters.py [number of designs]   (a minute of processor time for each)
"""

import json
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import flexmb as fmb

FOLDER = Path(__file__).parent
BOUNDS = {
    "inboard_flap_GJ": (0.7e6, 1.5e6),  # N m2
    "track_1_bracket_stiffness": (2.0e6, 2.0e7),  # N/m
    "drive_stiffness": (1.0e7, 4.0e7),  # N/m, tracks 1 and 2
    "stop_stiffness": (4.0e6, 1.0e7),  # N/m
    "free_travel": (0.028, 0.042),  # m, until the interconnection strut is pushed together
    "damping_ratio": (0.05, 0.10),  # of struts and drives
}
ACCEPTED = {
    "5.3 least strut 2 over strut 1": (3.0, 5.0),
    "5.3 greatest strut 2 over strut 1": (3.0, 5.0),
    "5.5 peak of strut 1": (4.5, 8.0),
    "5.6 strut 1 at rest": (1.6, 3.0),
    "5.7 way into the stop [mm]": (0.0, 4.0),
    "5.9 peak of the interconnection strut": (0.4, 1.5),
    "5.10 interconnection strut at rest": (0.35, 0.8),
}


def parameters(design: dict[str, float]) -> dict:
    """Return the parameters of the model files for a design."""
    return {
        "inboard_flap_GJ": design["inboard_flap_GJ"],
        "track_1_bracket_stiffness": design["track_1_bracket_stiffness"],
        "track_1_drive_drive_stiffness": design["drive_stiffness"],
        "track_2_drive_drive_stiffness": design["drive_stiffness"],
        "interconnection_strut_bistop_stiffness": design["stop_stiffness"],
        "interconnection_strut_free_travel": [-design["free_travel"], 0.012],
        "damping_ratio": design["damping_ratio"],
    }


def run(case: str, given: dict) -> fmb.Solution:
    """Return the motion of a case with parameters set."""
    path = FOLDER / f"{case}.toml"
    return fmb.simulate(fmb.load_model(path, given), **fmb.load_simulation(path, given).keywords())


def outcomes(design: dict[str, float], rigid: bool) -> dict[str, float]:
    """Return the ratios of `ACCEPTED` for a design."""
    given = {**parameters(design), "rigid": rigid}
    extension = run("operation", given)
    progress = extension["inboard_t2_lever angle"] / extension["inboard_t2_lever angle"][-1]
    eta = np.linspace(0.3, 0.9, 61)
    first, second = (np.interp(eta, progress, extension[f"inboard_t{k}_strut force"][:, 0]) for k in (1, 2))
    failure = run("strut_2_breaks", given)
    if failure.t[-1] < 1.7:
        raise fmb.ModelError(
            "strut_2_breaks",
            found=f"a run that ends at {failure.t[-1]:.4g} s",
            expected="1.8 s, until forces are at rest",
            remedy="Look at the warnings of the run",
        )
    t, one = failure.t, failure["inboard_t1_strut force"][:, 0]
    link, travel = failure["interconnection force"][:, 2], failure["interconnection travel"]
    before, after, settled = float(np.interp(0.645, t, one)), t > 0.65, t > 1.6
    found = (
        (-second / first).min(),
        (-second / first).max(),
        one[after].max() / before,
        one[settled].mean() / before,
        1e3 * (-design["free_travel"] - travel[settled].mean()),
        -link.min() / one[after].max(),
        -link[settled].mean() / one[settled].mean(),
    )
    return dict(zip(ACCEPTED, map(float, found), strict=True))


def margins(found: dict[str, float]) -> dict[str, float]:
    """Return the distance of each outcome to the nearer end of its range, over the width of the range."""
    return {name: min(found[name] - low, high - found[name]) / (high - low) for name, (low, high) in ACCEPTED.items()}


def least_margin(design: dict[str, float]) -> float:
    """Return the least margin of all outcomes, rigid and elastic; -1 for a design that cannot be run."""
    try:
        both = [outcomes(design, rigid) for rigid in (True, False)]
    except fmb.FlexmbError as error:
        print(json.dumps({"design": design, "error": str(error)[:200]}), flush=True)
        return -1.0
    least = min(min(margins(found).values()) for found in both)
    told = {"margin": least, "design": design, "rigid": both[0], "elastic": both[1]}
    print(json.dumps(told), flush=True)
    return least


def main(designs: int = 40) -> float:
    """Print all designs that were tried; return the least margin of the best."""
    start = {
        "inboard_flap_GJ": 1.05e6,
        "track_1_bracket_stiffness": 2.5e6,
        "drive_stiffness": 3.0e7,
        "stop_stiffness": 6.0e6,
        "free_travel": 0.038,
        "damping_ratio": 0.10,
    }
    outcomes(start, rigid=True)  # the data as they are can be run
    low, high = np.log(np.array(list(BOUNDS.values()))).T
    scaled = (np.log(list(start.values())) - low) / (high - low)

    def loss(x: np.ndarray) -> float:
        design = dict(zip(start, map(float, np.exp(low + x * (high - low))), strict=True))
        return -least_margin(design)

    step = np.where(scaled > 0.5, -0.25, 0.25)
    simplex = np.vstack([scaled, *(scaled + step * row for row in np.eye(len(scaled)))])
    options = {"initial_simplex": simplex, "maxfev": designs, "xatol": 0.01, "fatol": 1e-3, "adaptive": True}
    return -float(minimize(loss, scaled, method="Nelder-Mead", bounds=[(0.0, 1.0)] * 6, options=options).fun)


if __name__ == "__main__":
    print(main(*map(int, sys.argv[1:])))
