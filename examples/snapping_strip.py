"""Latch of a deployable panel: an arched strip of spring steel between two hinges snaps to its other side.

Problem: a strip, free of stress as a sine arch of the rise h, keeps the panel in one of two positions. Which push P at
its crown makes it snap over, and does it stay there?

              | P
           .-----.
        .-'       '-.        h
      .'             '.
     o        L        o                 z up, x to the right

Formula: shallow arch with hinged ends (Fung & Kaplan, NACA TN 2840, 1952). With the thrust H the sine amplitudes are
a_n = (EI k_n^4 h_n - 2 P s_n / L) / (EI k_n^4 - H k_n^2), k_n = n pi / L, s_n = sin(n pi / 2), and
H = EA / 4 sum k_n^2 (h_n^2 - a_n^2). It sways over at the thrust H = EI k_2^2: two loads P, between which it snaps.
Expected: P = 1.555 N pushes it over; P = -0.787 N pulls it back, so without load it stays on either side.
"""

import numpy as np

import flexmb as fmb
from flexmb import fem

LENGTH, RISE, WIDTH, THICKNESS = 0.4, 0.012, 0.02, 0.5e-3  # m
PUSH, RATE = 3.0, 4.0  # N; N/s of the simulation
HINGE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # z of the joint along y


def model(load):
    """Return the strip, a little askew, under a load on its crown, an expression of time."""
    x = np.linspace(0.0, LENGTH, 25)
    z = np.sin(np.pi * x / LENGTH) + 1e-4 * np.sin(2.0 * np.pi * x / LENGTH)
    arch = np.stack([x, 0.0 * x, RISE * z], axis=1)
    strip = fmb.AncfBeam(
        "strip",
        points=arch,
        elements=10,
        section=fem.Section.rectangle(WIDTH, THICKNESS),
        material=fmb.MATERIALS["steel"],
        damping=2e-4,
        markers={"left": (0.0, HINGE), "right": (1.0, HINGE), "crown": 0.5},
    )
    ground = fmb.Ground(markers={"left": fmb.Pose((0, 0, 0), HINGE), "right": fmb.Pose((LENGTH, 0, 0), HINGE)})
    return fmb.Model(
        bodies=[ground, strip],
        gravity=(0, 0, 0),
        joints=[fmb.Revolute(side, markers=(f"ground.{side}", f"strip.{side}")) for side in ("left", "right")],
        forces=[fmb.PointLoad("P", marker="strip.crown", force=(0, 0, fmb.expression(load)))],
        sensors=[fmb.Position("crown", marker="strip.crown")],
    )


def path():
    """Return the equilibria under a push that grows and falls as the strip needs it."""
    return fmb.statics(model(f"-{PUSH}*t"), t=1.0, path=fmb.ArcLength())


def snap():
    """Return the motion under a push that grows steadily."""
    return fmb.simulate(model(f"-{RATE}*t"), t_end=0.6, samples=121, integrator=fmb.GeneralizedAlpha(rtol=1e-4))


def main():
    """Print the limit points and the time of the snap; return the push at which the strip snaps, N."""
    equilibria, motion = path(), snap()
    for point in equilibria.limit_points:
        height = 1e3 * equilibria["crown"][point.sample, 2]
        print(f"{point.kind} of the push: {PUSH * point.load:.3f} N, crown at {height:.2f} mm")
    when = motion.t[np.argmax(motion["crown"][:, 2] < 0.0)]
    print(f"pushed with {RATE} N/s it passes the hinges at t = {when:.3f} s, P = {RATE * when:.2f} N")
    return PUSH * equilibria.limit_points[0].load


if __name__ == "__main__":
    print(f"the strip snaps at {main():.3f} N (shallow arch: 1.555 N)")
