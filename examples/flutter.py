"""Flutter of a typical section: plunge, pitch, and an airload that lags behind.

    U ->  ______o____x________        o elastic axis, a half chords behind the middle
         (______|_____________>       x centre of mass, e half chords behind the middle
                k_h, k_a

Lift (down is positive h) and moment about the elastic axis of a thin section of half chord b in an unsteady
incompressible stream (Theodorsen 1935, NACA report 496):

    L = pi rho b^2 (h'' + U a' - b a_e a'') + 2 pi rho U b w_e
    M = pi rho b^2 (b a_e h'' - U b (1/2 - a_e) a' - b^2 (1/8 + a_e^2) a'') + 2 pi rho U b^2 (1/2 + a_e) w_e

The downwash at three quarters of the chord, w = U a + h' + b (1/2 - a_e) a', acts with the lag of the wake. Jones's
approximation of Wagner's function, 1 - 0.165 exp(-0.0455 s) - 0.335 exp(-0.3 s) with s = U t / b (NACA report 681,
1940), makes it a sum of w and two lagged washes, the states of `Airload`. The mass of the air that moves along (the
terms of h'' and a'') is part of the body.

The speed at which `linearize` finds an undamped mode is compared with the root of Theodorsen's determinant, with his
function of Hankel functions: what is left is Jones's approximation.
"""

import numpy as np
from scipy.optimize import brentq, fsolve
from scipy.special import hankel2

import flexmb as fmb

RHO, B = 1.225, 0.5
AXIS, CENTRE, MASS_RATIO, GYRATION, RATIO, PITCH = -0.2, -0.1, 20.0, np.sqrt(0.24), 0.4, 50.0
"""a_e and e in half chords; m / (pi rho b^2), radius of gyration in half chords; w_h / w_a, and w_a in rad/s."""
WAKE = ((0.165, 0.0455), (0.335, 0.3))

AIR = np.pi * RHO * B**2
"""Mass of a cylinder of air around the section, kg/m."""
M = MASS_RATIO * AIR
INERTIA = np.array(
    [
        [M + AIR, M * (CENTRE - AXIS) * B - AIR * AXIS * B],
        [M * (CENTRE - AXIS) * B - AIR * AXIS * B, M * (GYRATION * B) ** 2 + AIR * B**2 * (0.125 + AXIS**2)],
    ]
)
STIFFNESS = np.array([M * (RATIO * PITCH) ** 2, M * (GYRATION * B * PITCH) ** 2])


def section(speed: float, pitch: float = 0.0) -> fmb.Model:
    """Return a metre of the wing in a stream, x downstream and y down, pitched by an angle (rad)."""
    behind = INERTIA[0, 1] / INERTIA[0, 0]
    own = INERTIA[1, 1] - INERTIA[0, 0] * behind**2
    down = fmb.Pose.axes((0, 0, 0), z=(0, 1, 0))
    turned = np.array([[np.cos(pitch), -np.sin(pitch)], [np.sin(pitch), np.cos(pitch)]]) @ [behind, 0.0]
    over = {"h": fmb.JointCoordinate("h", joint="plunge"), "a": fmb.JointCoordinate("a", joint="pitch")}
    springs = [fmb.formula("-k*x", over={"x": x}, k=k) for x, k in zip(over.values(), STIFFNESS)]
    air = fmb.Airload(
        "air", marker="wing.chord", chord=2 * B, span=1.0, place=0.5 * (1 + AXIS), density=RHO, wind=(speed, 0, 0)
    )
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"down": down}),
            fmb.RigidBody("mount", mass=1e-9 * M, inertia=(1e-9,) * 3, markers={"down": down, "axis": (0, 0, 0)}),
            fmb.RigidBody(
                "wing",
                mass=INERTIA[0, 0],
                inertia=(own, own, own),
                at=(*turned, 0.0),
                rotation=(0, 0, pitch),
                markers={"axis": (-behind, 0, 0), "chord": fmb.Pose.axes((-behind, 0, 0), x=(1, 0, 0), z=(0, -1, 0))},
            ),
        ],
        joints=[
            fmb.Prismatic("plunge", markers=("ground.down", "mount.down")),
            fmb.Revolute("pitch", markers=("mount.axis", "wing.axis")),
        ],
        forces=[
            fmb.Actuator("lift spring", joint="plunge", effort=springs[0]),
            fmb.Actuator("pitch spring", joint="pitch", effort=springs[1]),
            air,
        ],
        sensors=[*over.values()],
    )


def growth(speed: float) -> tuple[float, float]:
    """Return real part (1/s) and imaginary part (rad/s) of the oscillation that is damped least."""
    found = fmb.linearize(section(speed)).eigenvalues
    waves = found[found.imag > 1.0]
    least = waves[np.argmax(waves.real)]
    return float(least.real), float(least.imag)


def determinant(x: np.ndarray, function) -> tuple[float, float]:
    """Return Theodorsen's determinant at speed and frequency x (m/s, rad/s), for a function C(k), k = w b / U."""
    speed, w = x
    s, C = 1j * w, function(w * B / speed)
    wash = np.array([s, speed + s * B * (0.5 - AXIS)])  # of h and a
    air = np.array([[0.0, AIR * speed * s], [0.0, AIR * B * speed * (0.5 - AXIS) * s]])
    around = 2 * AIR / B * speed * C * np.outer([1.0, -B * (0.5 + AXIS)], wash)
    whole = INERTIA * s**2 + np.diag(STIFFNESS) + air + around
    value = np.linalg.det(whole) / np.prod(STIFFNESS)
    return value.real, value.imag


def theodorsen(k: float) -> complex:
    """Return Theodorsen's function C(k)."""
    return hankel2(1, k) / (hankel2(1, k) + 1j * hankel2(0, k))


def jones(k: float) -> complex:
    """Return the transfer function of Jones's approximation."""
    return 1.0 - sum(part * 1j * k / (1j * k + beta) for part, beta in WAKE)


def main() -> dict[str, float]:
    """Return flutter speeds, m/s, of the model, of the determinant with Jones's approximation, and of Theodorsen's."""
    speed = brentq(lambda U: growth(U)[0], 1.2 * B * PITCH, 3.0 * B * PITCH, xtol=1e-9)
    near = (speed, growth(speed)[1])
    by_jones, by_theodorsen = (fsolve(determinant, near, (f,), xtol=1e-11) for f in (jones, theodorsen))
    return {
        "speed": speed,
        "frequency": near[1],
        "Jones": float(by_jones[0]),
        "Jones frequency": float(by_jones[1]),
        "Theodorsen": float(by_theodorsen[0]),
    }


if __name__ == "__main__":
    answers = main()
    print("flutter at {speed:.4f} m/s, {frequency:.3f} rad/s; Theodorsen {Theodorsen:.4f} m/s".format(**answers))
