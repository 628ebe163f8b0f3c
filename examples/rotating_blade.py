"""Campbell diagram of a tapered rotor blade.

Problem: a blade on a hub turns with the speed W. Its thickness falls linearly to half at the tip; so does its mass per
length, and its flap stiffness falls to an eighth (Hodges & Rutkowski, AIAA J. 19, 1981). How do its frequencies grow?

           W
          (|)   EI0, m0                    EI0/8, m0/2
           |=========================---------------      -> x
          hub                                       L

Formula: w = f(n) sqrt(EI0 / m0 L^4) with n = W sqrt(m0 L^4 / EI0); at rest f = 3.8238, 18.3173, 47.2648.
Expected: at n = 12 the first flap frequency is f = 13.4711 (rigid flapping of a limp blade would be n itself).
"""

import numpy as np

import flexmb as fmb
from flexmb import fem, reduction

LENGTH, WIDTH, HEIGHT = 6.0, 0.30, 0.06  # m; chord in the plane of rotation, thickness along the axis
ALUMINIUM = fmb.MATERIALS["aluminium"]


def blade():
    """Return the reduced blade: 40 beam elements, ten modes, stiffness of the centrifugal load included."""
    x = np.linspace(0.0, LENGTH, 41)
    taper = 1.0 - 0.5 * x / LENGTH
    sections = [fem.Section.rectangle(WIDTH, HEIGHT * s) for s in taper]
    fe = fem.frame(np.outer(x, [1, 0, 0]), section=sections, material=ALUMINIUM, shear=False, rotary_inertia=False)
    return reduction.reduce(fe, {"root": "start"}, modes=10, geometric_stiffness=True, stress=False)


def frequencies(data, speed):
    """Return the frequencies, Hz, and the flap share of each mode about the rotation with `speed`, rad/s."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("blade", data=data)],
        joints=[
            fmb.Revolute("hub", markers=("ground.origin", "blade.root")),
            fmb.Drive("spin", joint="hub", angle=fmb.expression("speed * t", speed=float(speed))),
        ],
    )
    modes = fmb.linearize(model, fmb.statics(model))
    tip = data.shapes[-1] @ modes.modes[6:]
    return modes.frequencies, np.abs(tip[2]) / np.linalg.norm(tip, axis=0)


def main():
    """Print the Campbell diagram and return f of the first flap mode at n = 12."""
    data = blade()
    unit = np.sqrt(ALUMINIUM.young * HEIGHT**2 / (12.0 * ALUMINIUM.density * LENGTH**4))  # sqrt(EI0 / m0 L^4), rad/s
    for n in np.linspace(0.0, 12.0, 7):
        hertz, flap = frequencies(data, n * unit)
        first = hertz[flap > 0.9][:3]
        print(f"{n * unit * 30 / np.pi:7.1f} rpm   flap " + "  ".join(f"{f:8.3f}" for f in first) + " Hz")
    return 2.0 * np.pi * first[0] / unit


if __name__ == "__main__":
    print(f"first flap frequency at n = 12: {main():.4f} (Hodges & Rutkowski: 13.4711)")
