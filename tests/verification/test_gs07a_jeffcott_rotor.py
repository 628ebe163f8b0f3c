"""GS07a: unbalance response of a Jeffcott rotor on isotropic springs, with and without damping.

Reference: closed form r/e = w^2 / sqrt((wc^2 - w^2)^2 + (c w / m)^2); 1e-3.
"""

import numpy as np
import pytest

import flexmb as fmb


def rotor(m, omega, c):
    """The rotor starts in its steady whirl."""
    mass, k, e = m["m"], m["k"], m["e"]
    response = mass * e * omega**2 / (k - mass * omega**2 + 1j * c * omega)
    at, v = np.array([response.real, response.imag, 0.0]), np.array([-response.imag, response.real, 0.0]) * omega
    return fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody(
                "disc",
                mass=mass,
                inertia=(1, 1, 2),
                center_of_mass=(e, 0, 0),
                at=at,
                velocity=v,
                angular_velocity=(0, 0, omega),
                markers={"shaft": (0, 0, 0)},
            ),
        ],
        joints=[
            fmb.Planar("plane", markers=("ground.origin", "disc.shaft")),
            fmb.Drive("motor", joint="plane", angle=fmb.ramp(rate=omega)),
        ],
        forces=[
            fmb.Bushing(
                "shaft",
                markers=("ground.origin", "disc.shaft"),
                stiffness=(k, k, 0, 0, 0, 0),
                damping=(c, c, 0, 0, 0, 0),
            )
        ],
        sensors=[fmb.Position("whirl", marker="disc.shaft")],
    )


@pytest.mark.parametrize("damped", [False, True])
def test_amplitude(reference, damped):
    case = reference("GS07a")
    m = case["model"]
    for ratio, expected in case["reference"]["damped" if damped else "undamped"].items():
        omega = float(ratio) * case["reference"]["wc"]
        turn = 2.0 * np.pi / omega
        solution = fmb.simulate(
            rotor(m, omega, m["c"] if damped else 0.0),
            4.0 * turn,
            samples=81,
            integrator=fmb.GeneralizedAlpha(rho_inf=0.95, step=turn / 2000),
        )
        amplitude = np.linalg.norm(solution["whirl"][:, :2], axis=1)
        np.testing.assert_allclose(amplitude, expected, rtol=1e-3)


def test_critical_speed(reference):
    case = reference("GS07a")
    model = rotor(case["model"], 1.0, 0.0)
    model = model.changed("motor", angle=0.0).changed("disc", velocity=(0, 0, 0), angular_velocity=(0, 0, 0))
    still = fmb.linearize(model)
    np.testing.assert_allclose(2.0 * np.pi * still.frequencies, case["reference"]["wc"], rtol=1e-3)
