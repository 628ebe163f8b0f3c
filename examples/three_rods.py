"""Three rods in a spin: the stiffness that the motion gives them (Banerjee 1993, eqs. 1-7).

Problem: how stiff are two rods that hang on springs at the end of a turning one?

          W
         (|)     r         L, tip mass m      L, tip mass m
          |------------o~~~~~~~~~~~~~~~o~~~~~~~~~~~~~~~o   -> x
                       k               k

Formula: in the angles of the joints, K = [[k + 3 m W^2 r L, m W^2 r L], [m W^2 r L, k + m W^2 L (r + L)]]; without the
geometric part the spin would soften the rods and let them diverge.
Expected: the torques of the recursion, differentiated by the angles, at every speed; `JointTree.bias` in linear time.
"""

import numpy as np

import flexmb as fmb

STIFFNESS, MASS, RADIUS, LENGTH = 100.0, 1.0, 0.5, 1.0  # N m/rad, kg, m, m


def rods() -> fmb.JointTree:
    """Return the tree of the three rods."""
    small = {"inertia": (1e-9, 1e-9, 1e-9), "markers": {"end": (0, 0, 0), "start": (-LENGTH, 0, 0)}}
    bodies = [
        fmb.Ground(),
        fmb.RigidBody("arm", mass=1.0, inertia=(1, 1, 1), markers={"hub": (0, 0, 0), "rim": (RADIUS, 0, 0)}),
        fmb.RigidBody("one", mass=MASS, at=(RADIUS + LENGTH, 0, 0), **small),
        fmb.RigidBody("two", mass=MASS, at=(RADIUS + 2 * LENGTH, 0, 0), **small),
    ]
    joints = [
        fmb.Revolute("axis", markers=("ground.origin", "arm.hub")),
        fmb.Revolute("first", markers=("arm.rim", "one.start")),
        fmb.Revolute("second", markers=("one.end", "two.start")),
    ]
    springs = [fmb.TorsionSpring(f"on {name}", joint=name, stiffness=STIFFNESS) for name in ("first", "second")]
    return fmb.JointTree(fmb.Model(name="three rods", bodies=bodies, joints=joints, forces=springs))


def stiffness(speed: float) -> np.ndarray:
    """Return the stiffness (2, 2), N m/rad, of the joints in a spin, by central differences of the forces."""
    tree, step = rods(), 1e-4
    places = [tree.index(f"{name}.turn") for name in ("first", "second")]
    v = np.zeros(len(tree.rate_names))
    v[tree.index("axis.turn")] = speed
    K = np.empty((2, 2))
    for column, place in enumerate(places):
        q = np.zeros(len(tree.names))
        q[place] = step
        K[:, column] = (tree.bias(q, v) - tree.bias(-q, v))[places] / (2.0 * step)
    return K


def closed_form(speed: float) -> np.ndarray:
    """Return the same by the formula."""
    c = MASS * speed**2 * LENGTH
    coupling = c * RADIUS
    return np.array([[STIFFNESS + 3 * coupling, coupling], [coupling, STIFFNESS + c * (RADIUS + LENGTH)]])


def main() -> float:
    """Print the stiffness over the speed; return its largest relative difference from the formula."""
    worst = 0.0
    for speed in (0.0, 1.0, 3.0, 10.0):
        K, expected = stiffness(speed), closed_form(speed)
        worst = max(worst, float(np.abs(K - expected).max() / expected.max()))
        print(f"{speed:4.0f} rad/s  K = {K.round(4).tolist()} N m/rad")
    return worst


if __name__ == "__main__":
    main()
