"""RC01: a door on two or three coaxial hinges, a horizontal axis: redundant equations, reactions of least norm.

Reference: closed form; accelerations 1e-10, motion 1e-6.
"""

import numpy as np
import pytest

import flexmb as fmb


def door(case, places):
    m = case["model"]
    a, h, mass = m["width"], m["height"], m["m"]
    axis = {f"h{k}": fmb.Pose.axes((0, y, 0), z=(0, 1, 0)) for k, y in enumerate(places)}
    inertia = (mass * h * h / 12.0, mass * a * a / 12.0, mass * (a * a + h * h) / 12.0)
    return fmb.Model(
        gravity=(0, 0, -m["g"]),
        bodies=[fmb.Ground(markers=axis), fmb.RigidBody("door", mass=mass, inertia=inertia, center_of_mass=(a / 2, 0, 0),
                                                        markers=axis)],
        joints=[fmb.Revolute(f"hinge {k}", markers=(f"ground.h{k}", f"door.h{k}")) for k in range(len(places))],
        sensors=[fmb.JointCoordinate("angle", joint="hinge 0"), fmb.ConstraintError("error")])


@pytest.mark.parametrize("places", [(-0.5, 0.5), (-0.5, 0.0, 0.5)], ids=["two", "three"])
@pytest.mark.parametrize("formulation", [fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri()])
def test_start(reference, places, formulation):
    case = reference("RC01")
    model, r = door(case, places), case["reference"]
    report = fmb.check(model)
    assert report.equations - len(report.redundant) == 5
    assert {name.partition(":")[0] for name in report.redundant} == {f"hinge {k}" for k in range(1, len(places))}
    result = fmb.accelerations(model, formulation=formulation)
    assert abs(result["door"][4]) == pytest.approx(abs(r["alpha0"]), rel=1e-10)
    total = sum(result.reactions[joint.name] for joint in model.joints)
    assert total[2] == pytest.approx(r["total_vertical_force0"], rel=1e-10)
    for joint in model.joints:  # least norm: equal shares
        np.testing.assert_allclose(result.reactions[joint.name][2], total[2] / len(places), rtol=1e-6)


@pytest.mark.parametrize("places", [(-0.5, 0.5), (-0.5, 0.0, 0.5)], ids=["two", "three"])
def test_motion(reference, places):
    case = reference("RC01")
    expected = case["reference"]["angle_from_horizontal_at_t"]
    times = [0.0, *map(float, expected)]
    solution = fmb.simulate(door(case, places), 2.0, samples=times, integrator=fmb.GeneralizedAlpha(
        rho_inf=0.95, step=2.5e-4))
    angle = solution["angle"]
    np.testing.assert_allclose(np.abs(angle[1:]), np.abs(list(expected.values())), atol=3e-6)
    assert solution["error"].max() < 1e-9
