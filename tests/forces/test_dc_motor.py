"""A motor with winding and gear against closed forms: step response, stall, linear plant, a controller."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import ModelError

DATA = {"resistance": 2.0, "inductance": 0.05, "constant": 0.1, "ratio": 20.0}
INERTIA, VOLTS = 0.4, 12.0
R, L, EFFORT = DATA["resistance"], DATA["inductance"], DATA["ratio"] * DATA["constant"]


def rotor(*forces, voltage=VOLTS, ratio=DATA["ratio"], sensors=(), slides=False, **more) -> fmb.Model:
    """Return a disc (or a mass of the same number) that the motor drives."""
    kind = fmb.Prismatic if slides else fmb.Revolute
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("b", mass=INERTIA, inertia=(1, 1, INERTIA))],
        joints=[kind("axle", markers=("ground.origin", "b.center"))],
        forces=[fmb.DcMotor("motor", joint="axle", voltage=voltage, **(DATA | {"ratio": ratio})), *forces],
        sensors=[
            fmb.State("current", of="motor"),
            fmb.JointCoordinate("angle", joint="axle"),
            fmb.Energy("energy"),
            *sensors,
        ],
        **more,
    )


def poles(stiffness=0.0):
    """Return the eigenvalues of J x'' = n k i - s x, L i' = V - R i - n k x'."""
    A = [[0, 1, 0], [-stiffness / INERTIA, 0, EFFORT / INERTIA], [0, -EFFORT / L, -R / L]]
    return np.linalg.eigvals(np.array(A))


@pytest.mark.parametrize("slides", [False, True])
@pytest.mark.parametrize("ratio", [20.0, -20.0])
def test_step_response(ratio, slides):
    """The current after a step of the voltage is V / L (exp(a t) - exp(b t)) / (a - b), the speed its integral."""
    solution = fmb.simulate(rotor(ratio=ratio, slides=slides), 2.0, integrator=fmb.Implicit(rtol=1e-9), samples=41)
    a, b = (p for p in poles() if abs(p) > 1e-9)
    t = solution.t
    current = VOLTS / L * (np.exp(a * t) - np.exp(b * t)) / (a - b)
    assert solution["current"] == pytest.approx(current.real, abs=1e-7 * VOLTS / R)
    angle = (
        EFFORT
        / INERTIA
        * VOLTS
        / L
        / (a - b)
        * ((np.exp(a * t) - 1 - a * t) / a**2 - (np.exp(b * t) - 1 - b * t) / b**2)
    )
    assert solution["angle"] == pytest.approx(np.sign(ratio) * angle.real, abs=1e-6)
    balance = solution["energy"] - solution.phases[0].works @ (1.0, 1.0, -1.0)
    assert balance == pytest.approx(np.zeros(41), abs=1e-6)


def test_stalled_motor():
    """Held, the current rises as V / R (1 - exp(-R t / L)), and the statics find V / R and n k V / R."""
    hold = fmb.Drive("hold", joint="axle", angle=0.0)
    model = rotor().with_parts(joints=[hold], sensors=[fmb.Reaction("torque", joint="hold")])
    solution = fmb.simulate(model, 0.2, integrator=fmb.Implicit(rtol=1e-9), samples=21)
    current = VOLTS / R * (1 - np.exp(-R / L * solution.t))
    assert solution["current"] == pytest.approx(current, abs=1e-7)
    assert np.abs(solution["torque"][:, 5]) == pytest.approx(EFFORT * current, abs=1e-6)
    still = fmb.statics(model)
    assert still["current"][-1] == pytest.approx(VOLTS / R, rel=1e-9)
    assert abs(still["torque"][-1, 5]) == pytest.approx(EFFORT * VOLTS / R, rel=1e-9)


def test_poles():
    """The linear equations have the poles of the motor on its spring."""
    values = fmb.linearize(rotor(fmb.TorsionSpring("spring", joint="axle", stiffness=7.0), voltage=0.0)).eigenvalues
    exact = poles(7.0)
    both = np.concatenate([values, values[values.imag > 0.0].conj()])
    assert np.sort_complex(both) == pytest.approx(np.sort_complex(exact), rel=1e-9)


def test_poles_of_a_loop():
    """A voltage that follows the angle, V = -p x, moves the poles as s^2 (L s + R) J + (n k)^2 s + n k p = 0."""
    gain = 30.0
    feedback = fmb.formula("-p*x", over={"x": "angle"}, p=gain)
    values = fmb.linearize(rotor(voltage=feedback)).eigenvalues
    exact = np.roots([L * INERTIA, R * INERTIA, EFFORT**2, EFFORT * gain])
    both = np.concatenate([values, values[values.imag > 0.0].conj()])
    assert np.sort_complex(both) == pytest.approx(np.sort_complex(exact), rel=1e-9)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"inductance": 0.0}, "inductance = 0"),
        ({"resistance": -1.0}, "resistance = -1"),
        ({"constant": 0.0}, "constant = 0"),
        ({"ratio": 0.0}, "ratio = 0.0"),
        ({"current": float("nan")}, "current = nan"),
        ({"voltage": "much"}, "voltage = 'much'"),
    ],
)
def test_messages(change, words):
    with pytest.raises(ModelError) as raised:
        fmb.DcMotor("motor", joint="axle", **{"voltage": 1.0, **DATA, **change})
    assert words in str(raised.value)
