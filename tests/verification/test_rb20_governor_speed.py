"""RB20: steady speed of a conical pendulum and of a Porter governor with sleeve, arms without mass.

Reference: closed forms w^2 = g tan(b) / (a + l sin b) and (m + M) g tan(b) / (m (a + l sin b)); 1e-6.
"""

import numpy as np
import pytest

import flexmb as fmb


def governor(m, omega, sleeve):
    b = np.radians(m["angle_from_vertical_deg"])
    a, length = m["hinge_offset"], m["l"]
    radius, drop = a + length * np.sin(b), length * np.cos(b)
    bodies = [
        fmb.Ground(),
        fmb.RigidBody(
            "hub",
            mass=1.0,
            inertia=(1, 1, 1),
            angular_velocity=(0, 0, omega),
            markers={"right": (a, 0, 0), "left": (-a, 0, 0)},
        ),
    ]
    joints = [
        fmb.Revolute("bearing", markers=("ground.origin", "hub.center")),
        fmb.Drive("motor", joint="bearing", angle=fmb.ramp(rate=omega)),
    ]
    if sleeve:
        bodies.append(
            fmb.RigidBody(
                "sleeve",
                mass=sleeve,
                inertia=(1, 1, 1),
                at=(0, 0, -2 * drop),
                angular_velocity=(0, 0, omega),
                markers={"right": (a, 0, 0), "left": (-a, 0, 0)},
            )
        )
        joints.append(fmb.Prismatic("guide", markers=("hub.center", "sleeve.center")))
    for name, side in (("right", 1.0), ("left", -1.0)):
        bodies.append(
            fmb.PointMass(
                name, mass=m["ball_mass"], at=(side * radius, 0, -drop), velocity=(0, side * radius * omega, 0)
            )
        )
        joints.append(fmb.Rod(f"arm {name}", markers=(f"hub.{name}", f"{name}.center")))
        if sleeve:
            joints.append(fmb.Rod(f"link {name}", markers=(f"sleeve.{name}", f"{name}.center")))
    return fmb.Model(
        gravity=(0, 0, -m["g"]), bodies=bodies, joints=joints, sensors=[fmb.Position("ball", marker="right.center")]
    )


@pytest.mark.parametrize(("sleeve", "key"), [(0.0, "omega"), (4.0, "omega_sleeve_M_4m")])
def test_angle_stays(reference, sleeve, key):
    case = reference("RB20")
    m = case["model"]
    model = governor(m, case["reference"][key], sleeve * m["ball_mass"])
    first = fmb.accelerations(model)["right"][:3]
    b = np.radians(m["angle_from_vertical_deg"])
    radius = m["hinge_offset"] + m["l"] * np.sin(b)
    np.testing.assert_allclose(first, [-(case["reference"][key] ** 2) * radius, 0, 0], atol=1e-9 * abs(first[0]))
    solution = fmb.simulate(model, 2.0, samples=41, integrator=fmb.GeneralizedAlpha(rtol=1e-9))
    np.testing.assert_allclose(solution["ball"][:, 2], -m["l"] * np.cos(b), atol=1e-6)
