"""A unit whose states, inputs, outputs and parameters are arrays: in the system, and beside the model."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb

pytest.importorskip("fmpy")
from fmi.array_unit import A, B, C, D, build_arrays
from fmi.exchange_units import HAS_COMPILER

pytestmark = pytest.mark.skipif(not HAS_COMPILER, reason="units are compiled with cc")
GAIN = np.array([[1.0, 0.25], [0.0, 1.0]])
PLACE, SPEED = fmb.Position("place", marker="mass.center"), fmb.Velocity("speed", marker="mass.center")
INPUTS = {"u[1]": fmb.measured(PLACE), "u[2]": fmb.measured(SPEED)}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return build_arrays(tmp_path_factory.mktemp("arrays"))


def pushed(force, *sensors) -> fmb.Model:
    """Return a mass on a spring that is pushed along x."""
    return fmb.Model(
        bodies=[fmb.Ground(markers={"wall": (-1, 0, 0)}), fmb.PointMass("mass", mass=2.0, at=(0.3, 0, 0))],
        forces=[
            fmb.PointLoad("push", marker="mass.center", force=(force, 0, 0)),
            fmb.SpringDamper("spring", markers=("ground.wall", "mass.center"), stiffness=8.0, damping=0.5, length=1.0),
        ],
        sensors=[PLACE, SPEED, *sensors],
    )


def matrix() -> np.ndarray:
    """Return the matrix of place, speed and both states."""
    a, b, c, d = (np.array(x) for x in (A, B, C, D))
    out = np.zeros((4, 4))
    out[0, 1] = 1.0
    out[1] = np.r_[-8.0, -0.5, 0.0, 0.0] / 2.0
    force = np.r_[d[0] - d[1], c[0] - c[1]]  # y[1] - y[2]
    out[1] += force / 2.0
    out[2:] = GAIN @ np.hstack([b, a])
    return out


def test_in_the_system(path):
    """States "x[1]", "x[2]" beside the equations of both by scipy; poles are those of their matrix."""
    parameters = {f"gain[{i + 1},{j + 1}]": GAIN[i, j] for i in range(2) for j in range(2)}
    unit = fmb.fmi.ModelExchange(path, inputs=INPUTS, parameters=parameters)
    assert unit.outputs == ("y[1]", "y[2]")
    states = [fmb.State(f"x{k}", of="arrays", state=f"x[{k}]") for k in (1, 2)]
    model = pushed(unit["y[1]"] - unit["y[2]"], *states)
    run = fmb.simulate(model, t_end=1.0, integrator=fmb.Explicit(), samples=6)
    S, start = matrix(), (0.3, 0.0, 0.4, -0.2)
    exact = solve_ivp(lambda t, z: S @ z, (0, 1), start, "DOP853", run.t, rtol=1e-12, atol=1e-12).y
    for name, row in (("x1", 2), ("x2", 3)):
        np.testing.assert_allclose(run[name], exact[row], atol=1e-7)
    np.testing.assert_allclose(run["place"][:, 0], exact[0], atol=1e-7)
    found = fmb.linearize(model, about=fmb.statics(model)).eigenvalues
    for pole in np.linalg.eigvals(S):
        assert np.abs(found - complex(pole.real, abs(pole.imag))).min() < 1e-7


def test_beside_the_model(path):
    """Inputs are held over a communication step: the error is that of the step, and halves with it."""
    S, errors = matrix(), []
    for step in (0.02, 0.01):
        unit = fmb.fmi.Fmu(
            path,
            inputs={"u[1]": "place x", "u[2]": "speed vx"},
            outputs={"one": "y[1]", "two": "y[2]"},
            parameters={"gain[1,2]": GAIN[0, 1]},
            kind="model exchange",
        )
        run = fmb.fmi.cosimulate(pushed(fmb.input("one") - fmb.input("two")), unit, 1.0, step=step)
        exact = solve_ivp(lambda t, z: S @ z, (0, 1), (0.3, 0.0, 0.4, -0.2), rtol=1e-10, atol=1e-12).y[:, -1]
        errors.append(abs(run["place"][-1, 0] - exact[0]))
    assert errors[0] < 5e-3
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.2)
