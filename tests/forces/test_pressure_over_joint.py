"""`Pressure` over the coordinate of a joint: an airload that follows an angle.

Reference: a rod on a hinge with a spring, the load a couple M(theta) about it: equilibrium k theta = M(theta), and
small vibrations with the stiffness k - M'(theta) in closed form; and `PointLoad` with the same tables.
"""

import numpy as np
import pytest
from contracts.test_tangents import assert_tangent
from scipy.optimize import brentq
from tolerances import SOLVER

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import ModelError
from flexmb.system import assemble

LENGTH, STIFFNESS = 1.0, 400.0
AIR = fmb.table([-0.5, 0.0, 0.5, 1.0], [-20.0, 10.0, 60.0, 90.0], of="hinge", kind="cubic")  # N at the tip


@pytest.fixture(scope="module")
def rod():
    """A stiff beam along x; load shape "air" is a unit force on its end across it."""
    points = np.column_stack([np.linspace(0.0, LENGTH, 5), np.zeros(5), np.zeros(5)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.05, 0.05), material=fmb.MATERIALS["steel"])
    loads = {"air": reduction.NodalForces({4: (0.0, 1.0, 0.0)})}
    return reduction.reduce(fe, interfaces={"root": [0], "tip": [4]}, modes=2, loads=loads)


def model(rod, *loads) -> fmb.Model:
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("rod", data=rod, damping=0.01)],
        joints=[fmb.Revolute("hinge", markers=("ground.origin", "rod.root"))],
        forces=[fmb.TorsionSpring("spring", joint="hinge", stiffness=STIFFNESS, damping=0.2), *loads],
        sensors=[fmb.JointCoordinate("angle", joint="hinge")],
    )


def test_equilibrium_and_frequency(rod):
    """k theta = M(theta); omega^2 = (k - M')/J, where a load that grows with the angle softens the hinge."""
    loaded = model(rod, fmb.Pressure("air", load="rod.air", amount=1.3 * AIR))
    moment = np.polynomial.Polynomial.fit(AIR.x, AIR.y, 3)
    theta = brentq(lambda x: STIFFNESS * x - 1.3 * LENGTH * moment(x), 0.0, 0.5)
    rest = fmb.statics(loaded)
    assert rest["angle"][-1] == pytest.approx(theta, rel=1e-3)  # the rod bends a little
    J = rod.inertia[2, 2] + rod.mass * (LENGTH / 2) ** 2
    omega = np.sqrt((STIFFNESS - 1.3 * LENGTH * moment.deriv()(theta)) / J)
    lowest = fmb.linearize(loaded, about=rest.final).frequencies[0]
    assert 2.0 * np.pi * lowest == pytest.approx(omega, rel=2e-3)
    assert lowest < 0.9 * fmb.linearize(model(rod)).frequencies[0]


def test_tangent(rod):
    """The iteration matrix has the change of the load with the joint: compared with differences, in a bent state."""
    system, state = assemble(model(rod, fmb.Pressure("air", load="rod.air", amount=AIR)))
    q = state.q.copy()
    q[7 : 7 + rod.n_modes] = 1e-4 * np.cos(np.arange(rod.n_modes))
    assert_tangent(system, system.state(0.0, q), blocks=("K",))


def test_same_motion_as_a_point_load(rod):
    """A load shape that is one nodal force is a follower load on this node."""
    runs = [
        fmb.simulate(model(rod, load), t_end=0.3, samples=31, integrator=fmb.GeneralizedAlpha(rtol=1e-8))
        for load in (
            fmb.Pressure("air", load="rod.air", amount=AIR * fmb.step(value=1.0, rise=0.05)),
            fmb.PointLoad(
                "air", marker="rod.tip", axes="rod.root", force=(0.0, AIR * fmb.step(value=1.0, rise=0.05), 0.0)
            ),
        )
    ]
    assert np.ptp(runs[0]["angle"]) > 0.02
    np.testing.assert_allclose(runs[0]["angle"], runs[1]["angle"], atol=SOLVER)


@pytest.mark.parametrize(
    ("amount", "message"),
    [
        (AIR * AIR, "tables over several joints, or a product of two such tables. Expected: tables over one joint."),
        (fmb.table([0.0, 1.0], [0.0, 1.0], of="hinje"), "joint 'hinje' does not exist"),
    ],
)
def test_messages(rod, amount, message):
    with pytest.raises(ModelError) as caught:
        model(rod, fmb.Pressure("air", load="rod.air", amount=amount))
    assert message in str(caught.value)


def test_an_amount_that_follows_a_measurement(rod):
    """60 N/rad of the measured angle softens the hinge as the same table over the joint does; its rate damps it."""
    angle = fmb.measured("angle")
    straight = fmb.table([-1.0, 1.0], [-60.0, 60.0], of="hinge", kind="linear")
    found = [
        fmb.linearize(model(rod, fmb.Pressure("air", load="rod.air", amount=amount))).eigenvalues
        for amount in (60.0 * angle, straight)
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    damped = model(rod, fmb.Pressure("air", load="rod.air", amount=-0.5 * fmb.measured("angle", rate=True)))
    torsion = fmb.Actuator("d", joint="hinge", effort=-0.5 * LENGTH * fmb.measured("angle", rate=True))
    lowest = [fmb.linearize(m).eigenvalues[0] for m in (damped, model(rod, torsion))]
    assert lowest[0].real == pytest.approx(lowest[1].real, rel=2e-3)  # the rod bends a little
    system, state = assemble(model(rod, fmb.Pressure("air", load="rod.air", amount=60.0 * angle * angle)))
    q = state.q.copy()
    q[7 : 7 + rod.n_modes] = 1e-4 * np.cos(np.arange(rod.n_modes))
    assert_tangent(system, system.state(0.0, q), blocks=("K", "D"))
