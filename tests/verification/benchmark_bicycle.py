"""The benchmark bicycle: geometry and masses of table 1, J. P. Meijaard, J. M. Papadopoulos, A. Ruina & A. L. Schwab,
Linearized dynamics equations for the balance and steer of a bicycle, Proc. R. Soc. A 463 (2007) 1955-1982.

The paper's z points down; here it points up, so that products of inertia with z change their sign.
"""

import numpy as np

import flexmb as fmb

TILT, WHEEL_BASE, TRAIL = np.pi / 10, 1.02, 0.08
REAR, FRONT = 0.3, 0.35

EIGENVALUES = {
    0.0: (-5.53094371765393, -3.13164324790656, 3.13164324790656, 5.53094371765393),
    3.0: (-10.35101467245920, -2.63366137253667, 1.70675605663975 + 2.31582447384325j),
    5.0: (-14.07838969279822, -0.32286642900409, -0.77534188219585 + 4.46486771378823j),
    8.0: (-20.27940894394569, 0.14327879765713, -2.69348683558097 + 8.46037971396931j),
}
"""Table 2: speed (m/s) to castering, capsize and weave (1/s), one of each conjugate pair."""


def bicycle(speed: float, length: float = 1.0, mass: float = 1.0, time: float = 1.0, offset=(0.0, 0.0, 0.0)):
    """Return the upright bicycle at a speed (m/s), in units of so many m, kg and s, the road at `offset`."""
    offset = np.asarray(offset, float)
    centre = {"rear": (0, 0, REAR), "frame": (0.3, 0, 0.9), "fork": (0.9, 0, 0.7), "front": (WHEEL_BASE, 0, FRONT)}
    centre = {name: np.array(at) / length for name, at in centre.items()}
    head = np.array([WHEEL_BASE + TRAIL, 0, 0]) / length

    def marker(body, at, x, z):
        return fmb.Pose.axes(tuple(at - centre[body]), x=x, z=z)

    def axle(body, wheel):
        return marker(body, centre[wheel], (1, 0, 0), (0, -1, 0))

    def steering(body):
        return marker(body, head, (0, 1, 0), (-np.sin(TILT), 0, np.cos(TILT)))

    def part(name, kilograms, inertia, markers, radius=None):
        return fmb.RigidBody(
            name,
            mass=kilograms / mass,
            inertia=np.array(inertia) / (mass * length**2),
            at=tuple(offset + centre[name]),
            velocity=(speed / length * time, 0, 0),
            angular_velocity=(0, speed / radius * time if radius else 0, 0),
            markers=markers,
        )

    frame = [[9.2, 0, -2.4], [0, 11, 0], [-2.4, 0, 2.8]]
    fork = [[0.05892, 0, 0.00756], [0, 0.06, 0], [0.00756, 0, 0.00708]]
    return fmb.Model(
        name="benchmark bicycle",
        gravity=(0, 0, -9.81 / length * time**2),
        bodies=[
            fmb.Ground(markers={"road": tuple(offset)}),
            part("rear", 2, (0.0603, 0.12, 0.0603), {"axle": axle("rear", "rear")}, REAR),
            part("frame", 85, frame, {"rear": axle("frame", "rear"), "head": steering("frame")}),
            part("fork", 4, fork, {"front": axle("fork", "front"), "head": steering("fork")}),
            part("front", 3, (0.1405, 0.28, 0.1405), {"axle": axle("front", "front")}, FRONT),
        ],
        joints=[
            fmb.Revolute("rear hub", markers=("frame.rear", "rear.axle")),
            fmb.Revolute("front hub", markers=("fork.front", "front.axle")),
            fmb.Revolute("head", markers=("frame.head", "fork.head")),
            fmb.Rolling("rear contact", markers=("ground.road", "rear.axle"), radius=REAR / length),
            fmb.Rolling("front contact", markers=("ground.road", "front.axle"), radius=FRONT / length),
        ],
    )
