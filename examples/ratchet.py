r"""A ratchet: a wheel turns forwards under its pawl by clicks, and the pawl holds it when the torque turns round.

       face | o------------+ pivot of the pawl     wheel: 12 teeth from 42 to 50 mm, radial faces, straight backs
        /|  |/ _ back                              pawl: a roller of 1 mm, which a spring presses into the notches
       / |_/|/   \                                 torque: 0.2 N m forwards for 0.25 s, then 0.5 N m backwards
             wheel

Held, the roller lies in a notch, at r from the face of a tooth and from the back of the next one. So the wheel stands
where it began but for whole pitches of 30 degrees, and a press of 0.5 N m into the contact.
Expected: three whole pitches, less the press of 0.5 N m / (43 mm)^2 / 2e6 N/m = 1.4e-4 rad.
"""

import numpy as np

import flexmb as fmb

TEETH, TIP, ROOT, ROLLER = 12, 0.050, 0.042, 0.001  # m
PITCH = 2.0 * np.pi / TEETH
STIFFNESS = 2e6  # N/m


def wheel() -> fmb.Outline:
    """Return the profile: from each tip along the back to the root of the next face, then up that face."""
    angles = PITCH * np.arange(TEETH)[:, None] + [0.0, PITCH]
    corners = (np.array([TIP, ROOT]) * [np.cos(angles), np.sin(angles)]).reshape(2, -1).T
    return fmb.Outline(start=corners[0], pieces=[fmb.Line(to=corner) for corner in corners[1:]])


def model() -> fmb.Model:
    """Return wheel and pawl, the roller in the notch at the face that points straight up."""
    back = np.array([0.0, ROOT]) - TIP * np.array([np.sin(PITCH), np.cos(PITCH)])  # along the back, to the root
    along = back / np.linalg.norm(back)
    tip = np.array([ROLLER, ROOT + ROLLER * (1.0 - along[1]) / -along[0]])
    pivot = tip + (0.045, 0.006)
    centre = 0.5 * (tip + pivot)
    return fmb.Model(
        gravity=(0, 0, 0),
        bodies=[
            fmb.Ground(markers={"axis": (0, 0, 0), "pivot": (*pivot, 0)}),
            fmb.RigidBody(
                "wheel",
                mass=0.5,
                inertia=(3e-4, 3e-4, 6e-4),
                shape=[fmb.Extrusion(outline=wheel().points()[:-1], depth=(-0.004, 0.004))],
            ),
            fmb.RigidBody(
                "pawl",
                mass=0.02,
                inertia=(1e-6, 4e-6, 4e-6),
                at=(*centre, 0),
                markers={"pivot": (*(pivot - centre), 0), "tip": (*(tip - centre), 0)},
            ),
        ],
        joints=[
            fmb.Revolute("axis", markers=("ground.axis", "wheel.center")),
            fmb.Revolute("pivot", markers=("ground.pivot", "pawl.pivot")),
        ],
        forces=[
            fmb.CamFollower(
                "teeth",
                markers=("wheel.center", "pawl.tip"),
                profile=wheel(),
                roller=ROLLER,
                stiffness=STIFFNESS,
                damping=2.0,
            ),
            fmb.TorsionSpring("spring", joint="pivot", stiffness=0.5, damping=2e-4, free_angle=0.3),
            fmb.TorsionSpring("drag", joint="axis", stiffness=0.0, damping=0.02),
            fmb.Actuator("torque", joint="axis", effort=0.2 - fmb.step(value=0.7, at=0.25)),
        ],
        sensors=[fmb.JointCoordinate("angle", joint="axis"), fmb.JointCoordinate("pawl", joint="pivot")],
    )


def main() -> float:
    """Return by how many pitches the wheel stands ahead at the end."""
    solution = fmb.simulate(model(), t_end=0.6, samples=301)
    return float(solution["angle"][-1] / PITCH)


if __name__ == "__main__":
    print(f"{main():.5f} pitches")
