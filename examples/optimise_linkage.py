"""Flap station: which lever, strut and place of the actuator carry the flap with the least strut force?

      A     . rail (14 deg) . ===E===>  s     lever A-D of length l, drive strut D-E of length b, airload on the flap
      |\\   .                .                 E travels 1.156 m; the law of cosines in the triangle A-D-E gives the
    l | D ---------- b                        angles of the lever at both ends of the travel

Airload and weight set the force R(s) that the carriage needs along the rail. A strut at the angle a to it carries R /
cos a: it should lie along the rail at landing, where R is greatest. Free are l and the height h by which A is moved, up
to 0.15 m; b gives lever and strut the data set's angle at landing. The drive torque R ds/dphi must not exceed 25 kN m.
Expected number: 49.15 kN of the data set fall to 47.72 kN.
"""

from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import flexmb as fmb

STATION = Path(fmb.__file__).parent / "cli" / "demo_data"
ALONG, ACROSS = np.array([(0.970296, -0.241922), (0.241922, 0.970296)])  # the rail, in x and z
A, E, TRAVEL = np.array([-0.475284, -0.540170]), np.array([0.30, -0.28]) - 0.05 * ALONG - 0.10 * ACROSS, 1.15625


def linkage(l: float, h: float, stroke: float) -> tuple[float, float]:
    """Return the length of the strut, m, and the angle of the lever from the rail's normal, rad."""
    ends = [E + s * ALONG - A - h * ACROSS for s in (stroke, TRAVEL)]
    r, last = np.hypot(*ends[0]), np.hypot(*ends[1])
    b = -0.8268 * l + np.sqrt(last**2 - (1.0 - 0.8268**2) * l**2)  # 145.8 deg between lever and strut at landing
    corner = np.arccos((l**2 + r**2 - b**2) / (2.0 * l * r))
    return b, np.arctan2(ends[0] @ ACROSS, ends[0] @ ALONG) - corner + 0.5 * np.pi


def peaks(design) -> np.ndarray:
    """Return the greatest strut force, kN, and drive torque, kN m, while the flap extends in real time."""
    (b, first), (_, last), (x, z) = linkage(*design, 0.0), linkage(*design, TRAVEL), A + design[1] * ACROSS
    changed = {"lever_length": design[0], "strut_length": b, "lever_start": first, "lever_range": last - first}
    changed |= {"a_x": x, "a_z": z, "lever_modes": 0, "lever_is_rigid": True, "duration": 32.54}
    solution = fmb.kinematics(fmb.load_model(STATION / "flap_station.toml", changed), 32.54, samples=61)
    return 1e-3 * np.abs([solution["strut force"][:, 0], solution["actuator torque"][:, 5]]).max(axis=1)


def main() -> float:
    """Return the least peak strut force, kN."""
    before, torque = peaks((0.60, 0.0)), {"type": "ineq", "fun": lambda x: 25.0 - peaks(x)[1]}
    settings = {"bounds": [(0.62, 0.80), (-0.15, 0.15)], "options": {"eps": 1e-4, "ftol": 1e-4}}
    best = minimize(lambda x: peaks(x)[0], (0.64, 0.0), method="SLSQP", constraints=[torque], **settings)
    print(f"data set {before.round(2)}, l, h = {best.x.round(3)} m: {peaks(best.x).round(2)} kN, kN m")
    return float(best.fun)


if __name__ == "__main__":
    main()
