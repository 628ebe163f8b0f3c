"""Every message of the forces."""

import pytest

import flexmb as fmb

ENDS = ("ground.origin", "b.center")
STOP = {"travel": (-0.1, 0.1), "stiffness": 1e3}
CASES = [
    (lambda: fmb.BiStop("f", **STOP), "neither markers nor joint"),
    (lambda: fmb.BiStop("f", markers=ENDS, joint="j", **STOP), "both markers and joint"),
    (lambda: fmb.BiStop("f", markers=ENDS, along="w", **STOP), "along = 'w'"),
    (lambda: fmb.BiStop("f", markers=ENDS, travel=(0.1, -0.1), stiffness=1e3), "travel"),
    (lambda: fmb.BiStop("f", markers=ENDS, exponent=0.5, **STOP), "exponent = 0.5"),
    (lambda: fmb.BiStop("f", markers=ENDS, depth=0.0, **STOP), "depth = 0"),
    (lambda: fmb.BiStop("f", joint="ball", **STOP), "permits no turn or slide"),
    (lambda: fmb.OneSidedSpring("f", markers=ENDS, stiffness=1.0, exponent=0.0), "exponent = 0.0"),
    (lambda: fmb.OneSidedSpring("f", markers=ENDS, stiffness=1.0, length=float("nan")), "length = nan"),
    (lambda: fmb.OneSidedSpring("f", markers=ENDS, stiffness=1.0, backlash=-1.0), "backlash = -1.0"),
    (lambda: fmb.TorsionSpring("f", joint="j", stiffness=-1.0), "stiffness = -1.0"),
    (lambda: fmb.TorsionSpring("f", joint="j", stiffness=1.0, free_angle=float("inf")), "free_angle = inf"),
    (lambda: fmb.TorsionSpring("f", joint="j", stiffness=1.0), "permits no turn"),
    (lambda: fmb.TorsionSpring("f", joint="jj", stiffness=1.0), "joint 'jj' does not exist"),
    (lambda: fmb.Actuator("f", joint="j", effort="much"), "effort = 'much'"),
    (lambda: fmb.Actuator("f", joint="j", effort=fmb.table([0, 1], [0, 1], of="hinge")), "of 'hinge'"),
    (lambda: fmb.Motor("f", joint="j", target="far", stiffness=1.0), "target = 'far'"),
    (lambda: fmb.Motor("f", joint="j", target=1.0, stiffness=1.0, limits=(2.0, 1.0)), "limits"),
    (lambda: fmb.Motor("f", joint="j", target=1.0, stiffness=-1.0), "stiffness"),
    (lambda: fmb.Actuator("f", joint="j", effort=1.0, limits=(2.0, 1.0)), "limits"),
    (lambda: fmb.Actuator("f", joint="j", effort=1.0, freedom="slide_x"), "permits no slide_x"),
    (lambda: fmb.Bushing("f", markers=ENDS, stiffness=(1.0, 2.0)), "stiffness"),
    (lambda: fmb.Bushing("f", markers=ENDS, stiffness=(1, 1, 1, 1, 1, -1.0)), "stiffness"),
    (
        lambda: fmb.Bushing("f", markers=("ground.origin", "b.x"), stiffness=(1,) * 6),
        "marker 'b.x' does not exist",
    ),
    (lambda: fmb.JointFriction("f", joint="j", moving=0.3, standing=0.2), "standing = 0.2 below"),
    (lambda: fmb.JointFriction("f", joint="hinge", moving=0.3), "no radius"),
    (lambda: fmb.JointFriction("f", joint="j", moving=-0.3), "moving = -0.3"),
    (lambda: fmb.Contact("f", markers=ENDS, radius=0.1, stiffness=1.0, against="cone"), "against = 'cone'"),
    (
        lambda: fmb.Contact("f", markers=ENDS, radius=0.1, stiffness=1.0, against="sphere"),
        "other_radius = None",
    ),
    (
        lambda: fmb.Contact("f", markers=ENDS, radius=0.1, stiffness=1.0, other_radius=0.2),
        "other_radius = 0.2",
    ),
    (lambda: fmb.Contact("f", markers=ENDS, radius=0.1, stiffness=1.0, exponent=0.9), "exponent = 0.9"),
    (
        lambda: fmb.PointLoad(
            "f",
            marker="b.center",
            force=(fmb.table([0, 1], [0, 1], of="j"), fmb.table([0, 1], [0, 1], of="hinge"), 0),
        ),
        "tables over several joints",
    ),
    (
        lambda: fmb.PointLoad("f", marker="b.center", force=(fmb.table([0, 1], [0, 1], of="ball"), 0, 0)),
        "permits no",
    ),
]


@pytest.mark.parametrize(("make", "found"), CASES, ids=[found for _, found in CASES])
def test_messages(make, found):
    with pytest.raises(fmb.ModelError, match=found) as error:
        fmb.Model(
            bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1))],
            joints=[
                fmb.Prismatic("j", markers=ENDS),
                fmb.Revolute("hinge", markers=ENDS),
                fmb.Spherical("ball", markers=ENDS),
            ],
            forces=[make()],
        )
    assert all((error.value.part, error.value.found, error.value.expected, error.value.remedy))


def test_a_table_over_a_joint_is_no_function_of_time():
    with pytest.raises(fmb.ModelError, match="over the coordinate of joint 'hinge'"):
        fmb.accelerations(
            fmb.Model(
                bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(1, 1, 1))],
                forces=[
                    fmb.SpringDamper(
                        "s",
                        markers=ENDS,
                        stiffness=1.0,
                        length=1.0,
                        preload=fmb.table([0, 1], [0, 1], of="hinge"),
                    )
                ],
            )
        )
