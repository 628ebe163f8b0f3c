"""Forces from Python, and pressure on load shapes."""

from pathlib import Path

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

MESH = Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh"


def model(force, **fields):
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(0.1, 0.2, 0.3), **fields)],
        forces=[force],
        sensors=[fmb.Position("r", marker="b.center"), fmb.Orientation("o", marker="b.center")],
    )


def spring(t, d, v, R, w):
    return -40.0 * d - 2.0 * v, -0.4 * w


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(step=2e-3), fmb.IDA(rtol=1e-8)], ids=["alpha", "IDA"])
def test_equals_the_bushing_it_describes(integrator):
    ends = ("ground.origin", "b.center")
    bushing = fmb.Bushing(
        "f", markers=ends, stiffness=(40.0, 40.0, 40.0, 0, 0, 0), damping=(2.0, 2.0, 2.0, 0.4, 0.4, 0.4)
    )
    fields = {"at": (0.1, 0.2, 0.0), "angular_velocity": (1.0, 2.0, 3.0)}
    runs = [
        fmb.simulate(model(force, **fields), 1.0, samples=11, integrator=integrator)
        for force in (bushing, fmb.UserForce("f", markers=ends, function=spring))
    ]
    np.testing.assert_allclose(runs[1]["r"], runs[0]["r"], atol=1e-7)
    np.testing.assert_allclose(runs[1]["o"], runs[0]["o"], atol=1e-7)


@pytest.mark.parametrize(
    ("law", "found"),
    [
        (lambda t, d, v, R, w: ((np.nan if t > 0.3 else 0.0, 0, 0), (0, 0, 0)), "Force 'mine': it returned"),
        (lambda t, d, v, R, w: ((1.0 / (0.0 if t > 0.3 else 1.0), 0, 0), (0, 0, 0)), "ZeroDivisionError"),
        (lambda t, d, v, R, w: ((0, 0), (0, 0, 0)) if t > 0.3 else ((0, 0, 0), (0, 0, 0)), "ValueError"),
    ],
)
def test_what_goes_wrong_in_the_function_is_told(law, found):
    force = fmb.UserForce("mine", markers=("ground.origin", "b.center"), function=law)
    with pytest.raises(fmb.IntegrationError, match=found) as error:
        fmb.simulate(model(force), 1.0, samples=101, integrator=fmb.GeneralizedAlpha(step=1e-2))
    assert 0.2 < error.value.solution.t[-1] < 0.35


@pytest.mark.parametrize(("function", "found"), [(3.0, "function = 3.0"), ("spring", "function = 'spring'")])
def test_messages(function, found):
    with pytest.raises(fmb.ModelError, match=found):
        fmb.UserForce("f", markers=("ground.origin", "b.center"), function=function)


def test_a_function_by_name():
    force = fmb.UserForce("f", markers=("ground.origin", "b.center"), function="no_such_module:law")
    with pytest.raises(fmb.ModelError, match="no_such_module"):
        fmb.accelerations(model(force))


@pytest.fixture(scope="module")
def bracket():
    fe = fem.solid(fem.read_mesh(MESH), fmb.MATERIALS["steel"])
    return reduction.reduce(fe, interfaces={"foot": "foot", "load": "load"}, modes=2, loads={"push": "load"}, compare=0)


def test_pressure_is_carried_by_the_support(bracket):
    """The reaction of the clamp is the resultant of the load shape times its amount."""
    body = fmb.FloatingBody("bracket", data=bracket)
    clamped = fmb.Model(
        bodies=[fmb.Ground(markers={"foot": body.marker_poses()["foot"]}), body],
        joints=[fmb.Fixed("clamp", markers=("ground.foot", "bracket.foot"))],
        forces=[fmb.Pressure("push", load="bracket.push", amount=2e3)],
        sensors=[fmb.Reaction("r", joint="clamp")],
    )
    solution = fmb.statics(clamped)
    np.testing.assert_allclose(solution["r"][-1, :3], -2e3 * bracket.load_shapes[0, :3], rtol=1e-6, atol=1e-3)


def test_messages_of_pressure(bracket):
    bodies = [fmb.Ground(), fmb.FloatingBody("bracket", data=bracket)]
    for load, found in (
        ("bracket.pull", "has no load 'pull'"),
        ("ground.push", "has no load"),
        ("body.push", "does not exist"),
    ):
        with pytest.raises(fmb.ModelError, match=found):
            fmb.Model(bodies=bodies, forces=[fmb.Pressure("p", load=load, amount=1.0)])
    with pytest.raises(fmb.ModelError, match="load = 'push'"):
        fmb.Pressure("p", load="push", amount=1.0)


def zero_division(t, d, v, R, w):
    return 1.0 / 0.0


@pytest.mark.parametrize(
    ("force", "found"),
    [
        (
            fmb.UserForce("mine", markers=("ground.origin", "b.center"), function=zero_division),
            "ZeroDivisionError.* at t = 0 s",
        ),
        (
            fmb.UserForce("mine", markers=("ground.origin", "b.center"), function=lambda t: 0.0),
            "takes 1 positional argument",
        ),
        (
            fmb.PointLoad("mine", marker="b.center", force=(fmb.expression("log(t - 1)"), 0, 0)),
            "its force and moment are .nan",
        ),
    ],
    ids=["raises", "arguments", "signal"],
)
def test_what_is_no_number_at_the_start_is_named(force, found):
    with pytest.raises(fmb.CompileError, match=f"Force 'mine': .*{found}"):
        fmb.simulate(model(force), 1.0)
