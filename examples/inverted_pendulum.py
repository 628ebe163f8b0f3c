"""An inverted pendulum on a cart, held upright by a linear-quadratic regulator that measures place, angle and rates.

    g |        o  rod, length 0.6 m, mass 0.2 kg
      v       /
        [cart]o-->  force F, mass 0.5 kg, on a rail along x

With the angle a of the rod from upright, counter-clockwise, the linear equations are

    (M + m) x'' - m l/2 a'' = F,      - m l/2 x'' + m l^2/3 a'' - m g l/2 a = 0

The regulator F = -K (x, a, x', a') minimises the integral of 10 x^2 + a^2 + 0.1 F^2 (scipy's Riccati solver). The
poles of the linearised model with its controller must be the eigenvalues of A - B K, and the fall from 0.3 rad must be
caught.
"""

import numpy as np
from scipy.linalg import solve_continuous_are

import flexmb as fmb

CART, ROD, LENGTH, GRAVITY = 0.5, 0.2, 0.6, 9.81


def regulator() -> tuple[np.ndarray, np.ndarray]:
    """Return the gains K (4,) and the poles of the closed loop (4,), 1/s, of the linear equations."""
    M = np.array([[CART + ROD, -ROD * LENGTH / 2], [-ROD * LENGTH / 2, ROD * LENGTH**2 / 3]])
    falling = np.linalg.solve(M, [[0.0, 0.0], [0.0, ROD * GRAVITY * LENGTH / 2]])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [falling, np.zeros((2, 2))]])
    B = np.concatenate([np.zeros(2), np.linalg.solve(M, [1.0, 0.0])])[:, None]
    K = B.T @ solve_continuous_are(A, B, np.diag([10.0, 1.0, 0.0, 0.0]), [[0.1]]) / 0.1
    return K[0], np.linalg.eigvals(A - B @ K)


def pendulum(gains: np.ndarray, lean: float = 0.0) -> fmb.Model:
    """Return the cart with the rod at an angle `lean` (rad) from upright, and its controller."""
    along_x = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))
    place = fmb.JointCoordinate("x", joint="rail")
    angle = fmb.JointCoordinate("a", joint="hinge")
    k = dict(zip(("kx", "ka", "kv", "kw"), gains, strict=True))
    force = fmb.formula("-(kx*x + ka*(a - pi/2) + kv*rate(x) + kw*rate(a))", over={"x": place, "a": angle}, **k)
    return fmb.Model(
        gravity=(0, -GRAVITY, 0),
        bodies=[
            fmb.Ground(markers={"rail": along_x}),
            fmb.RigidBody("cart", mass=CART, inertia=(1e-3, 1e-3, 1e-3), markers={"rail": along_x, "pin": (0, 0, 0)}),
            fmb.RigidBody.rod("rod", length=LENGTH, mass=ROD, rotation=(0, 0, np.pi / 2 + lean)),
        ],
        joints=[
            fmb.Prismatic("rail", markers=("ground.rail", "cart.rail")),
            fmb.Revolute("hinge", markers=("cart.pin", "rod.start")),
        ],
        forces=[fmb.Actuator("motor", joint="rail", effort=force)],
        sensors=[place, angle, fmb.SignalValue("force", of=force)],
    )


def main() -> tuple[float, float]:
    """Return how far the poles are from those of the regulator (relative), and the largest angle after 5 s, rad."""
    gains, poles = regulator()
    found = fmb.linearize(pendulum(gains)).eigenvalues
    both = np.concatenate([found, found[found.imag > 0.0].conj()])
    apart = np.abs(np.sort_complex(both) - np.sort_complex(poles)).max() / np.abs(poles).max()
    fall = fmb.simulate(pendulum(gains, lean=0.3), t_end=6.0, samples=301)
    last = fall["a"][-50:]  # the last second
    return float(apart), float(np.abs(last - np.pi / 2).max())


if __name__ == "__main__":
    print("poles apart by {:.1e}; {:.1e} rad left after 5 s".format(*main()))
