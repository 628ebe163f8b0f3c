"""RB11: a thin disc rolls in a circle, leaning inwards by 20 degrees: W^2 = 4 g tan(a) / (6 R + r sin(a)).

Reference: closed form; after one turn the disc is where it was (lean 1e-6 rad, radius 1e-5 m).
"""

import numpy as np
import pytest

import flexmb as fmb


def disc(case):
    m, r = case["model"], case["reference"]
    axis, spin = np.array(r["axis0"]), np.array(r["omega0"])
    y = np.array([0.0, 1.0, 0.0])
    lean = np.radians(m["lean_deg"])
    at = np.array([m["R_centre"], 0.0, m["r"] * np.cos(lean)])
    arm = -m["r"] * np.array([-axis[2], 0.0, axis[0]])
    return fmb.Model(
        gravity=(0, 0, -m["g"]),
        bodies=[
            fmb.Ground(),
            fmb.RigidBody(
                "disc",
                mass=m["m"],
                inertia=(m["I_diam"], m["I_diam"], m["I_axis"]),
                at=at,
                rotation=np.column_stack([np.cross(y, axis), y, axis]),
                velocity=-np.cross(spin, arm),
                angular_velocity=spin,
            ),
        ],
        joints=[fmb.Rolling("rolling", markers=("ground.origin", "disc.center"), radius=m["r"])],
        sensors=[
            fmb.Position("centre", marker="disc.center"),
            fmb.Energy("energy"),
            fmb.ConstraintError("error"),
            fmb.Orientation("turn", marker="disc.center"),
        ],
    )


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(rho_inf=0.95, step=4e-4), fmb.IDA(rtol=1e-9, atol=1e-11)], ids=["alpha", "IDA"]
)
def test_one_turn(reference, integrator):
    case = reference("RB11")
    end, period = case["reference"], case["reference"]["turn_period_s"]
    solution = fmb.simulate(disc(case), period, samples=41, integrator=integrator)
    path = solution["centre"]
    radius = np.linalg.norm(path[:, :2], axis=1)
    np.testing.assert_allclose(radius, case["model"]["R_centre"], atol=1e-5)
    np.testing.assert_allclose(path[-1], path[0], atol=1e-5)
    w, x, y, z = solution["turn"][-1]
    axis = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    assert np.arcsin(axis[2]) == pytest.approx(np.radians(case["model"]["lean_deg"]), abs=1e-6)
    angle = np.unwrap(np.arctan2(path[:, 1], path[:, 0]))
    assert abs(angle[-1] - angle[0]) / period == pytest.approx(end["precession_rad_s"], rel=1e-5)
    assert np.ptp(solution["energy"]) < 1e-4 * solution["energy"][0]
    assert solution["error"].max() < 1e-7


def test_second_order(reference):
    case = reference("RB11")
    period = case["reference"]["turn_period_s"]
    errors = []
    for steps in (1000, 2000, 4000):
        solution = fmb.simulate(
            disc(case), period, samples=2, integrator=fmb.GeneralizedAlpha(rho_inf=0.9, step=period / steps)
        )
        errors.append(np.linalg.norm(solution["centre"][-1] - solution["centre"][0]))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.1)
