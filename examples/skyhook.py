"""A quarter car whose suspension damps the body as if it hung on a damper in the sky (Karnopp 1974).

    [body 300 kg]        measured velocity v -> force -c v between body and wheel
     spring | actuator
    [wheel 40 kg]
     tyre   |  road r(t)

With the spring k, the tyre K and the masses m, n of body and wheel

    m x'' = -k (x - y) - c x',    n y'' = k (x - y) + c x' + K (r - y)

the transmissibility x / r is K k / ((m s^2 + c s + k)(n s^2 + k + K) - k (c s + k)). A passive damper of the same c
between body and wheel lets more of fast bumps through.
"""

import numpy as np

import flexmb as fmb

BODY, WHEEL, SPRING, TYRE, DAMPING = 300.0, 40.0, 2.0e4, 1.8e5, 3.0e3
FREQUENCIES = np.array([0.3, 0.8, 1.3, 2.0, 5.0, 11.0, 30.0])


def car(road=None, sky: bool = True) -> fmb.Model:
    """Return the quarter car on a road (a signal, m), by default an input, damped from the sky or not."""
    up = fmb.Pose.axes((0, 0, 0), z=(0, 0, 1))
    wheel, stroke = fmb.JointCoordinate("wheel", joint="axle"), fmb.JointCoordinate("stroke", joint="strut")
    speed = fmb.Velocity("speed", marker="body.up")
    law = "-k*s - c*v[2]" if sky else "-k*s - c*rate(s)"
    over = {"s": stroke, "v": speed} if sky else {"s": stroke}
    tyre = fmb.formula("K*(r - y)", over={"y": wheel, "r": fmb.input("road") if road is None else road}, K=TYRE)
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"up": up}),
            fmb.RigidBody("wheel", mass=WHEEL, inertia=(1, 1, 1), markers={"up": up}),
            fmb.RigidBody("body", mass=BODY, inertia=(1, 1, 1), markers={"up": up}),
        ],
        joints=[
            fmb.Prismatic("axle", markers=("ground.up", "wheel.up")),
            fmb.Prismatic("strut", markers=("wheel.up", "body.up")),
        ],
        forces=[
            fmb.Actuator("tyre", joint="axle", effort=tyre),
            fmb.Actuator("suspension", joint="strut", effort=fmb.formula(law, over=over, k=SPRING, c=DAMPING)),
        ],
        sensors=[fmb.Position("place", marker="body.up"), wheel, stroke, speed],
    )


def transmissibility(frequencies: np.ndarray, sky: bool = True) -> np.ndarray:
    """Return x / r by the closed form, complex."""
    s = 2j * np.pi * frequencies
    m, n, k, K, c = BODY, WHEEL, SPRING, TYRE, DAMPING
    if sky:
        return K * k / ((m * s**2 + c * s + k) * (n * s**2 + k + K) - k * (c * s + k))
    return K * (c * s + k) / ((m * s**2 + c * s + k) * (n * s**2 + c * s + k + K) - (c * s + k) ** 2)


def measured(sky: bool = True) -> np.ndarray:
    """Return the same from the linear model."""
    plant = fmb.linearize(car(sky=sky), inputs="road", outputs="place")
    return plant.frequency_response(FREQUENCIES)[:, 2, 0]


def main() -> dict[str, float]:
    """Return how far both are from the closed form (relative), and the amplitude over a road of 1.3 Hz in the run."""
    found = {
        name: float(np.abs(measured(sky) / transmissibility(FREQUENCIES, sky) - 1.0).max())
        for name, sky in (("sky", True), ("passive", False))
    }
    bumps = fmb.harmonic(amplitude=0.01, frequency=1.3)
    run = fmb.simulate(car(bumps), t_end=12.0, samples=1201, integrator=fmb.Implicit(rtol=1e-8))
    last = slice(-301, None)
    wave = np.exp(-2j * np.pi * 1.3 * run.t[last])
    both = np.column_stack([wave.real, wave.imag, np.ones(301)])
    amplitude = np.linalg.norm(np.linalg.lstsq(both, run["place"][last, 2], rcond=None)[0][:2])
    return {**found, "run": float(amplitude / 0.01 / np.abs(transmissibility(np.array([1.3])))[0] - 1.0)}


if __name__ == "__main__":
    print(
        "apart from the closed form by {sky:.1e} (sky), {passive:.1e} (passive), in the run {run:.1e}".format(**main())
    )
