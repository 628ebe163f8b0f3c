"""The compiled method of order eight: it agrees with SciPy's methods on another formulation, and hands over to them."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.runs.patience import Patience
from flexmb.system import assemble


def linkage() -> fmb.Model:
    """A driven four-bar with a torsion spring and a pendulum on its coupler; hinges in space, so equations depend."""
    rods = {
        "crank": (0.3, (0, 0, 0), 1.2),
        "coupler": (0.8, (0.1087, 0.2796, 0), 0.35),
        "bob": (0.4, (0.1087, 0.2796, 0), -1.0),
    }
    bodies = [
        fmb.RigidBody.rod(name, length=length, mass=1.0, radius=0.01, at=at, rotation=(0, 0, angle))
        for name, (length, at, angle) in rods.items()
    ]
    rocker = fmb.RigidBody.rod("rocker", length=0.6, mass=1.0, radius=0.01, at=(0.7, 0, 0), rotation=(0, 0, 1.35))
    ends = {
        "A": ("ground.origin", "crank.start"),
        "B": ("crank.end", "coupler.start"),
        "C": ("coupler.end", "rocker.end"),
        "D": ("ground.D", "rocker.start"),
        "P": ("crank.end", "bob.start"),
    }
    joints = [fmb.Revolute(name, markers=markers) for name, markers in ends.items()]
    forces = [
        fmb.TorsionSpring("spring", joint="D", stiffness=20.0, damping=0.2),
        fmb.PointLoad("torque", marker="crank.center", moment=(0, 0, 15.0)),
    ]
    sensors = [fmb.Position("bob", marker="bob.end"), fmb.JointCoordinate("turn", joint="P"), fmb.Energy("energy")]
    return fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(markers={"D": (0.7, 0, 0)}), *bodies, rocker],
        joints=joints,
        forces=forces,
        sensors=sensors,
    )


def test_it_agrees_with_the_null_space_and_another_method():
    model = linkage()
    found = fmb.simulate(model, 0.6, samples=4, integrator=fmb.Explicit(rtol=1e-9, atol=1e-11))
    expected = fmb.simulate(
        model,
        0.6,
        samples=4,
        integrator=fmb.Explicit(method="RK45", rtol=1e-9, atol=1e-11, formulation=fmb.NullSpace()),
    )
    for name in ("bob", "turn", "energy"):
        np.testing.assert_allclose(found[name], expected[name], atol=1e-6)
    works = found.phases[0].works
    np.testing.assert_allclose(works, expected.phases[0].works, atol=1e-6)
    assert found.statistics["evaluations"] < expected.statistics["evaluations"] / 2


def test_the_error_follows_the_tolerance():
    """Errors at 1e-5, 1e-7 and 1e-9 against 1e-12."""
    model = linkage()
    ends = [
        fmb.simulate(model, 1.0, samples=2, integrator=fmb.Explicit(rtol=tol, atol=0.1 * tol))["bob"][-1]
        for tol in (1e-12, 1e-5, 1e-7, 1e-9)
    ]
    errors = np.max(np.abs(np.array(ends[1:]) - ends[0]), axis=1)
    assert errors[0] < 1e-4
    assert errors[1] < 1e-6
    assert errors[2] < 1e-8


@pytest.mark.parametrize("trusted", [True, False], ids=["compiled", "handed over"])
def test_where_the_factorisation_is_not_trusted_the_dense_solution_goes_on(trusted):
    """Both take the same way from 0.3 s on, and works and counts go on."""
    system, start = assemble(linkage())
    work, settings = system.workspace(), fmb.Explicit(rtol=1e-9, atol=1e-11)
    run = settings.start(system, start, work, 0.6)
    assert run.advance(0.3, Patience(np.inf)) == ""
    before = dict(run.counts)
    run.trusted = trusted
    assert run.advance(0.6, Patience(np.inf)) == ""
    assert run.counts["steps"] > before["steps"]
    t, q, _, _, _, works = run.sample()
    reference = fmb.simulate(linkage(), 0.6, samples=2, integrator=fmb.Explicit(rtol=1e-11, atol=1e-12))
    assert t == 0.6
    np.testing.assert_allclose(q[:-1], reference.final.q[:-1], atol=1e-7)
    np.testing.assert_allclose(works, reference.final.works, atol=1e-7)
