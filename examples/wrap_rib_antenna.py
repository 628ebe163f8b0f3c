"""A wrap-rib antenna on a flexible boom unwinds in orbit: a tree with one flexible link, in joint coordinates.

Problem: how do the ribs swing out, and what does the boom make of it?

                      rib of rigid segments, universal joints
                     /  with nonlinear springs
        hub   (=====o-----o-----o        at the start the ribs lie
               |    \\                    along the hub, as wound up
               |     o-----o-----o
               |
               |  L-shaped boom, reduced with geometric stiffness
        +---+  |
        |bus|--+                         nothing else holds it
        +---+

Data: in the manner of the antenna of Banerjee, J. Guidance 16 (1993): an L-shaped flexible boom, a hub, and ribs of 16
to 160 segments in all; the numbers are ours.

Formula: the boom's modes are eliminated before its joint, link by link (theory: recursive, eq. bend-out), so that an
evaluation costs the sum of the links; rigid ones cost what they cost in a rigid tree.
Expected: both momenta are kept, and energy but for the damping of the springs; the ribs are stretched after 1.6 s, the
tips 0.6 m + 4 x 0.5 m from the middle of the hub, and swing on; the same motion in the coordinates of all bodies
(tests/examples/test_wrap_rib_antenna.py).
"""

from functools import cache

import numpy as np

import flexmb as fmb
from flexmb import fem, reduction

ARMS, RADIUS, SEGMENT = (3.0, 4.0), 0.6, 0.5  # m: arms of the boom, hub, a segment
OFFSET, BEND = 0.05, 0.7  # m, springs beside the joints; rad, from segment to segment when wound up
TIP = (ARMS[0], 0.0, ARMS[1])


@cache
def boom() -> fmb.ModalNeutralData:
    """Return the reduced boom, along x and then up."""
    points = [(x, 0, 0) for x in np.linspace(0, ARMS[0], 7)] + [(ARMS[0], 0, z) for z in np.linspace(0, ARMS[1], 9)[1:]]
    tube = fem.Section.tube(0.1, 0.003)
    fe = fem.frame(points=points, section=tube, material=fmb.MATERIALS["aluminium"])
    return reduction.reduce(fe, interfaces={"root": [0], "tip": [len(points) - 1]}, modes=0, geometric_stiffness=True)


def rib(k: int, angle: float, segments: int):
    """Return segments, joints and springs of a rib that leaves the hub at an angle about z."""
    bodies, joints, forces = [], [], []
    out = fmb.Pose.axes((0, 0, 0), z=(0, 1, 0), x=(1, 0, 0))
    at, turned = np.array(TIP) + RADIUS * np.array([np.cos(angle), np.sin(angle), 0.0]), angle
    before, beside = f"hub.rib {k}", f"hub.spring {k}"
    for n in range(segments):
        name, turned = f"rib {k}.{n}".replace(".", "-"), turned + BEND
        ends = {"root": out, "tip": fmb.Pose((SEGMENT, 0, 0)), "in": (OFFSET, OFFSET, 0)}
        ends["out"] = (SEGMENT - OFFSET, OFFSET, 0)
        rod = fmb.RigidBody(
            name, mass=0.4, inertia=(1e-4, 0.0084, 0.0084), center_of_mass=(0.5 * SEGMENT, 0, 0), at=at,
            rotation=(0, 0, turned), markers=ends,
        )  # fmt: skip
        bodies.append(rod)
        joints.append(fmb.Universal(f"{name} joint", markers=(before, f"{name}.root")))
        spring = {"stiffness": 400.0, "cubic": 2e5, "damping": 2.0, "length": 2.0 * OFFSET}
        forces.append(fmb.SpringDamper(f"{name} spring", markers=(beside, f"{name}.in"), **spring))
        at = at + SEGMENT * np.array([np.cos(turned), np.sin(turned), 0.0])
        before, beside = f"{name}.tip", f"{name}.out"
    return bodies, joints, forces


def antenna(ribs: int = 4, segments: int = 4, rigid: bool = False) -> fmb.Model:
    """Return the antenna, wound up; its boom rigid for comparison."""
    angles = 2 * np.pi * np.arange(ribs) / ribs
    ends = {"boom": (0, 0, 0)}
    for k, a in enumerate(angles):
        c, s = np.cos(a), np.sin(a)
        ends[f"rib {k}"] = fmb.Pose((RADIUS * c, RADIUS * s, 0), (0, 0, a))
        r, t = RADIUS - OFFSET, OFFSET
        ends[f"spring {k}"] = (r * c - t * s, r * s + t * c, 0)
    bodies = [
        fmb.Ground(),
        fmb.RigidBody("bus", mass=2000.0, inertia=(900.0, 900.0, 900.0), markers={"boom": (0, 0, 0)}),
        fmb.FloatingBody("boom", data=boom(), rigid=rigid),
        fmb.RigidBody("hub", mass=40.0, inertia=(5.0, 5.0, 8.0), at=TIP, markers=ends),
    ]
    joints = [fmb.Fixed("mast", markers=("bus.boom", "boom.root")), fmb.Fixed("top", markers=("boom.tip", "hub.boom"))]
    forces = []
    for k, a in enumerate(angles):
        parts = rib(k, a, segments)
        bodies, joints, forces = bodies + parts[0], joints + parts[1], forces + parts[2]
    sensors = [fmb.Energy("energy"), fmb.Momentum("momentum"), fmb.Position("hub", marker="hub.center")]
    sensors.append(fmb.Position("tip", marker=f"rib 0-{segments - 1}.tip"))
    return fmb.Model(name="antenna", bodies=bodies, joints=joints, forces=forces, sensors=sensors)


def run(duration: float = 2.0, integrator=None, **fields):
    """Return the motion; explicit, in joint coordinates. By default until the ribs have been stretched, and on."""
    how = integrator or fmb.Explicit(formulation=fmb.Recursive())
    return fmb.simulate(antenna(**fields), duration, samples=51, integrator=how)


def main() -> float:
    """Print how the first rib swings out; return how far the hub has moved from its place, m."""
    motion = run()
    reach = np.linalg.norm(motion["tip"] - motion["hub"], axis=1)
    away = np.linalg.norm(motion["hub"] - motion["hub"][0], axis=1)
    for t, x, y in zip(motion.t[::5], reach[::5], away[::5], strict=True):
        print(f"{t:.1f} s  tip of the first rib {x:.3f} m from the hub, hub {1e3 * y:.1f} mm from its place")
    print(motion.statistics)
    return float(away.max())


if __name__ == "__main__":
    main()
