"""A flexible arm of one link, with a controller that measures its hub, and one that measures its tip.

      torque |  hub 0.02 kg m2                      tip
             O=======================================>   steel strip 20 x 2 mm, 0.6 m

    hub:  torque = -k (a + T a')        tip:  torque = -k (y + T y') / L

A controller at the motor takes energy out of every mode. One that measures the tip meets modes whose tip moves against
the hub, and drives them: only the damping of the strip holds against it, up to a gain. Theory: the strip is a
Bernoulli beam with E I (1 + b s), w'''' = -c^4 w with c^4 = rho A s^2 / (E I (1 + b s)), and

    w(0) = 0,   J s^2 w'(0) = torque + E I (1 + b s) w''(0),   w''(L) = w'''(L) = 0.

With the controller it has a root s = i w at the gain at which the arm becomes unstable.
"""

import numpy as np
from scipy.optimize import fsolve

import flexmb as fmb
from flexmb import fem

LENGTH, WIDTH, HEIGHT, HUB, LEAD, DAMPING = 0.6, 0.02, 0.002, 0.02, 0.2, 2e-4
"""m, kg m2, and s: T of the controllers, b of the strip."""
YOUNG, DENSITY = 2.1e11, 7850.0
AREA, BENDING = WIDTH * HEIGHT, YOUNG * WIDTH * HEIGHT**3 / 12.0


def arm(gain: float, tip: bool = True, elements: int = 4) -> fmb.Model:
    """Return the arm with a controller of a gain, N m/rad, that measures its tip or its hub."""
    second = WIDTH * HEIGHT**3 / 12.0
    strip = fmb.AncfCable(
        "strip",
        points=((0, 0, 0), (LENGTH, 0, 0)),
        elements=elements,
        section=fem.Section.values(AREA, second, second, 2.0 * second),
        material=fmb.Material(young=YOUNG, poisson=0.3, density=DENSITY),
        bending_damping=DAMPING * BENDING,
        axial_damping=DAMPING * YOUNG * AREA,
    )
    if tip:
        over, text = {"p": fmb.Position("tip", marker="strip.end")}, "-k*(p[1] + T*rate(p[1]))/L"
    else:
        over, text = {"a": fmb.JointCoordinate("a", joint="motor")}, "-k*(a + T*rate(a))"
    law = fmb.formula(text, over=over, k=gain, T=LEAD, L=LENGTH)
    return fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("hub", mass=0.5, inertia=(HUB, HUB, HUB), markers={"clamp": (0, 0, 0)}),
            strip,
        ],
        joints=[
            fmb.Revolute("motor", markers=("ground.origin", "hub.center")),
            fmb.Fixed("clamp", markers=("hub.clamp", "strip.start")),
        ],
        forces=[fmb.Actuator("torque", joint="motor", effort=law)],
        sensors=[*over.values()],
    )


def characteristic(s: complex, gain: float, tip: bool) -> complex:
    """Return the determinant of the four conditions of the strip at its ends, by parts of its motion."""
    bending = BENDING * (1.0 + DAMPING * s)
    c = (-DENSITY * AREA * s * s / bending) ** 0.25 + 0j
    z = c * LENGTH
    # cos, sin, cosh, sinh of c x: values and derivatives at both ends
    start = np.array([1, 0, 1, 0]), np.array([0, c, 0, c]), np.array([-(c**2), 0, c**2, 0])
    end = np.array([np.cos(z), np.sin(z), np.cosh(z), np.sinh(z)])
    second = c**2 * np.array([-np.cos(z), -np.sin(z), np.cosh(z), np.sinh(z)])
    third = c**3 * np.array([np.sin(z), -np.cos(z), np.sinh(z), np.cosh(z)])
    measured = end / LENGTH if tip else start[1]
    hub = HUB * s * s * start[1] + gain * (1.0 + LEAD * s) * measured - bending * start[2]
    return np.linalg.det(np.array([start[0], hub / bending, second / c**2, third / c**3]))


def theory(near: tuple[float, float]) -> tuple[float, float]:
    """Return gain (N m/rad) and frequency (rad/s) at which the controller of the tip has an undamped root."""

    def parts(x):
        value = characteristic(1j * x[1], x[0], tip=True)
        return value.real, value.imag

    gain, frequency = fsolve(parts, near, xtol=1e-12)
    return float(gain), float(frequency)


def main() -> dict[str, float]:
    """Return the gain of instability of the model and of theory, and the largest growth with the hub measured, 1/s."""
    locus = fmb.root_locus(arm, np.geomspace(0.01, 1.0, 5))
    gain = locus.limits()[0]
    poles = fmb.linearize(arm(gain)).eigenvalues
    frequency = float(poles[np.argmax(poles.real)].imag)
    by_theory, known = theory((gain, frequency))
    hub = fmb.root_locus(lambda k: arm(k, tip=False), np.geomspace(0.01, 30.0, 4))
    return {
        "gain": gain,
        "frequency": frequency,
        "theory": by_theory,
        "theory frequency": known,
        "hub": float(hub.growth.max()),
    }


if __name__ == "__main__":
    print("unstable from {gain:.5f} N m/rad on, at {frequency:.3f} rad/s; theory {theory:.5f} N m/rad".format(**main()))
