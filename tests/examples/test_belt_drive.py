"""The belt drive against the equations of a steady belt: creep, tensions, torque, and where the power goes."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

EXAMPLE = Path(__file__).parents[2] / "examples" / "belt_drive.py"


def steady_belt(*, axial, line_mass, strain, radius, half, distance, stiffness, friction, transition, speed, torque):
    """Return speed of the driven pulley, tension of tight and slack side: eq. (belt-creep) over both pulleys.

    Leamy & Wasfy, Journal of Applied Mechanics 69 (2002) 763-771, with friction mu v / sqrt(v^2 + v0^2) and a surface
    that gives way by N / (r k). Unknown are the speed of the unstretched belt, that of the driven pulley and both
    tensions; known that the belt is closed, how long it is, and the torque.
    """
    outside = radius + half
    drawn = 2.0 * distance + 2.0 * np.pi * outside

    def stretch(tension):
        return 1.0 - strain + tension / axial

    def around(tension, w, v):
        """Tension behind the pulley, length of belt on it (as drawn), torque on the belt."""

        def rate(_, y):
            N = y[0] - line_mass * v**2 * stretch(y[0])
            r = outside - N / (outside * stiffness)
            slip = v * stretch(y[0]) - w * r
            dN = friction * slip / np.hypot(slip, transition) * N
            return dN / (1.0 - line_mass * v**2 / axial), r / stretch(y[0]), r * dN

        return solve_ivp(rate, (0.0, np.pi), (tension, 0.0, 0.0), rtol=1e-9, atol=1e-9).y[:, -1]

    unit = np.array([speed * outside, speed, strain * axial, strain * axial])

    def misfit(x):
        v, w, tight, slack = x * unit
        on_driver, on_driven = around(tight, speed, v), around(slack, w, v)
        free = distance / stretch(tight) + distance / stretch(slack)
        return [
            (on_driver[0] - slack) / torque,
            (on_driven[0] - tight) / torque,
            on_driven[2] / torque - 1.0,
            100.0 * ((on_driver[1] + on_driven[1] + free) / drawn - 1.0),
        ]

    found = root(misfit, [1.0, 0.99, 1.2, 0.8], tol=1e-12)
    assert np.abs(found.fun).max() < 1e-9
    return (found.x * unit)[1:]


def assert_steady_belt(elements, tolerance, t_end):
    """Compare a run with the steady belt; the tolerance is relative to the creep.
    Return lost power over torque times creep.
    """
    belt = runpy.run_path(str(EXAMPLE))
    solution = belt["run"](elements, t_end)
    names = {
        "axial": "EA",
        "line_mass": "LINE_MASS",
        "strain": "STRAIN",
        "radius": "RADIUS",
        "half": "HALF",
        "distance": "DISTANCE",
        "stiffness": "STIFFNESS",
        "friction": "FRICTION",
        "transition": "TRANSITION",
        "speed": "SPEED",
        "torque": "TORQUE",
    }
    w, *expected = steady_belt(**{name: belt[constant] for name, constant in names.items()})
    turned = {name: solution[name][-1] - solution[name][-11] for name in ("driver", "driven")}
    creep = 1.0 - turned["driven"] / turned["driver"]
    assert creep == pytest.approx(1.0 - w / belt["SPEED"], rel=tolerance)
    np.testing.assert_allclose(belt["tensions"](solution), expected, rtol=0.01)
    torques = [solution[f"belt on {name}"][-11:, 5].mean() for name in ("driver", "driven")]
    np.testing.assert_allclose(torques, (-belt["TORQUE"], belt["TORQUE"]), rtol=0.02)
    lost = (solution["lost"][-1] - solution["lost"][-11]) / 0.1
    return lost / (belt["TORQUE"] * belt["SPEED"] * creep)


@pytest.mark.slow
def test_creep_of_a_coarse_belt():
    assert_steady_belt(60, 0.03, 0.5)


@pytest.mark.slow
def test_creep():
    assert assert_steady_belt(120, 0.005, 0.7) == pytest.approx(1.0, rel=0.05)
