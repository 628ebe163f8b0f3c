"""RB05: flyball governor with a stiff spring and damper (IFToMM benchmark A05), free shaft.

Reference: minimal-coordinate equations integrated to 1e-12; slider 1e-5 m, speed 1e-5 rad/s by IDA;
5e-5 by the second-order method at a step of 0.2 ms.
"""

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb

HINGE, BETA, SPEED = 0.05, np.radians(30.0), 2.0 * np.pi * 0.16


def rod(name, side):
    """A rod of 0.3 kg with a point mass of 5 kg at its end, hanging outwards and 30 degrees down."""
    m, tip, J = 0.3, 5.0, 0.3 * (1.0 + 1e-4) / 12.0
    c = (0.5 * m + tip) / (m + tip)
    across = J + m * (c - 0.5) ** 2 + tip * (1.0 - c) ** 2
    x, z = np.array([side * np.cos(BETA), 0, -np.sin(BETA)]), np.array([side * np.sin(BETA), 0, np.cos(BETA)])
    R = np.column_stack([x, np.cross(z, x), z])
    return fmb.RigidBody(
        name,
        mass=m + tip,
        inertia=(0.3 * 2e-4 / 12.0, across, across),
        center_of_mass=(c, 0, 0),
        at=(side * HINGE, 0, 1),
        rotation=R,
        velocity=(0, side * HINGE * SPEED, 0),
        angular_velocity=(0, 0, SPEED),
        markers={"hinge": fmb.Pose.axes(z=(0, 1, 0)), "mid": (0.5, 0, 0)},
    )


def governor(case):
    m = case["model"]
    turn = {"angular_velocity": (0, 0, SPEED)}
    spring = {"stiffness": m["k"], "damping": m["c"], "length": m["l0"]}
    axis = fmb.Pose.axes
    joints = [
        fmb.Revolute("bearing", markers=("ground.origin", "shaft.foot")),
        fmb.Prismatic("guide", markers=("shaft.foot", "slider.center")),
    ]
    forces = []
    for name in ("right", "left"):
        joints.append(fmb.Revolute(name, markers=(f"shaft.{name}", f"{name}.hinge")))
        forces.append(fmb.SpringDamper(name, markers=(f"slider.{name}", f"{name}.mid"), **spring))
    return fmb.Model(
        gravity=m["gravity"],
        joints=joints,
        forces=forces,
        bodies=[
            fmb.Ground(),
            rod("right", 1.0),
            rod("left", -1.0),
            fmb.RigidBody.box(
                "shaft",
                size=(0.01, 0.01, 1.0),
                density=3000.0,
                at=(0, 0, 0.5),
                **turn,
                markers={
                    "foot": (0, 0, -0.5),
                    "right": axis((HINGE, 0, 0.5), z=(0, 1, 0)),
                    "left": axis((-HINGE, 0, 0.5), z=(0, 1, 0)),
                },
            ),
            fmb.RigidBody.box(
                "slider",
                size=(0.1, 0.1, 0.1),
                density=3000.0,
                at=(0, 0, 0.5),
                **turn,
                markers={"right": (HINGE, 0, 0), "left": (-HINGE, 0, 0)},
            ),
        ],
        sensors=[
            fmb.Position("slider", marker="slider.center"),
            fmb.JointCoordinate("angle", joint="bearing"),
            fmb.Velocity("speed", marker="slider.right"),
            fmb.Energy("energy"),
        ],
    )


@pytest.mark.parametrize(
    ("integrator", "tolerance"),
    [slow(fmb.GeneralizedAlpha(rho_inf=0.9, step=2e-4), 5e-5), (fmb.IDA(rtol=1e-9, atol=1e-11), 1e-5)],
    ids=["alpha", "IDA"],
)
def test_slider_and_shaft(reference, integrator, tolerance):
    case = reference("RB05")
    solution = fmb.simulate(governor(case), 10.0, samples=101, integrator=integrator)
    for t, expected in case["reference"].items():
        k = round(10 * float(t))
        speed = np.linalg.norm(solution["speed"][k, :2]) / HINGE
        assert solution["slider"][k, 2] == pytest.approx(expected["slider_z"], abs=tolerance), t
        assert speed == pytest.approx(expected["shaft_speed"], abs=tolerance), t
        assert solution["angle"][k] == pytest.approx(expected["shaft_angle"], abs=1e-4), t
