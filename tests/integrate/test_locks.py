"""Joints that jam and come free again: every kind is held where it is, sensors and forces of it go on."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem
from flexmb.errors import ModelError

PINS = ("ground.origin", "body.pin")
J = (0.1, 0.2, 0.25)


def body(**fields) -> fmb.RigidBody:
    return fmb.RigidBody("body", mass=1.0, inertia=J, markers={"pin": (0, 0, 0), "corner": (0.3, 0.2, 0.1)}, **fields)


def free(joint, moving, *parts, forces=(), sensors=(), then=None, at=0.2):
    events = [fmb.Event("jam", at=at, then=fmb.Lock("joint") if then is None else then)]
    return fmb.Model(
        gravity=(1.0, -2.0, -9.81),
        bodies=[fmb.Ground(), moving],
        joints=[joint, *parts],
        forces=forces,
        sensors=[fmb.Position("corner", marker="body.corner"), *sensors],
        events=events,
    )


KINDS = [
    (fmb.Revolute("joint", markers=PINS), {"angular_velocity": (0, 0, 2.0)}),
    (fmb.Prismatic("joint", markers=PINS), {}),
    (fmb.Cylindrical("joint", markers=PINS), {"angular_velocity": (0, 0, 3.0)}),
    (fmb.Planar("joint", markers=PINS), {"angular_velocity": (0, 0, 2.0), "velocity": (1.0, 0, 0)}),
    (fmb.Universal("joint", markers=PINS), {"rotation": (np.pi / 2, 0, 0), "angular_velocity": (0, 1.0, 2.0)}),
    (fmb.Screw("joint", markers=PINS, pitch=0.1), {}),
    (fmb.Spherical("joint", markers=PINS), {"angular_velocity": (1.0, 2.0, 3.0)}),
    (fmb.ConstantVelocity("joint", markers=PINS), {"angular_velocity": (1.0, 0, 0)}),
    (fmb.InLine("joint", markers=PINS), {"angular_velocity": (1.0, 0, 2.0)}),
    (fmb.Rod("joint", markers=PINS), {"at": (1.0, 0, 0)}),
    (fmb.PointOnCurve("joint", markers=PINS, curve=[(0, 0, 0), (1, 0, -0.5), (2, 0, 0)]), {}),
    (fmb.Rolling("joint", markers=PINS, radius=0.5, disc=False), {"at": (0, 0, 0.5)}),
]


@pytest.mark.parametrize(("joint", "start"), KINDS, ids=[type(joint).__name__ for joint, _ in KINDS])
def test_a_locked_joint_stays_where_it_is(joint, start):
    solution = fmb.simulate(free(joint, body(**start)), 0.4, samples=9)
    then = solution["corner"][solution.t >= 0.2 - 1e-12]
    assert np.max(np.abs(then[0] - solution["corner"][0])) > 1e-3
    np.testing.assert_allclose(then, np.tile(then[0], (len(then), 1)), atol=1e-9)


def test_what_acts_on_a_locked_joint_goes_on():
    """A screw with friction and a wound spring on a universal joint keep their coordinates;
    the spring's moment is k theta.
    """
    screw = free(
        KINDS[5][0],
        body(),
        forces=[fmb.JointFriction("rub", joint="joint", moving=0.1, radius=0.01)],
        sensors=[fmb.JointCoordinate("turn", joint="joint", freedom="turn")],
    )
    turn = fmb.simulate(screw, 0.4, samples=9)["turn"]
    np.testing.assert_allclose(turn[5:], turn[5], atol=1e-12)
    spring = fmb.TorsionSpring("spring", joint="joint", stiffness=3.0, freedom="turn_b")
    crossed = free(
        KINDS[4][0],
        body(**KINDS[4][1]),
        forces=[spring],
        sensors=[fmb.JointCoordinate("turn", joint="joint", freedom="turn_b"), fmb.ForceOf("moment", force="spring")],
    )
    solution = fmb.simulate(crossed, 0.4, samples=9)
    np.testing.assert_allclose(
        np.linalg.norm(solution["moment"][:, 3:], axis=1), 3.0 * np.abs(solution["turn"]), rtol=1e-9
    )


@pytest.mark.parametrize(
    "integrator", [fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Explicit()], ids=lambda x: type(x).__name__
)
def test_turns_are_kept_and_events_meet_samples(integrator):
    """A wheel on a torsion spring, wound 15 rad, held from 0.5 to 0.7 s: a sine before, a cosine after. The sample at
    0.7 s is that of the event but for the last digit."""
    wheel = body(angular_velocity=(0, 0, 30.0))
    model = fmb.Model(
        bodies=[fmb.Ground(), wheel],
        joints=[fmb.Revolute("joint", markers=PINS)],
        forces=[fmb.TorsionSpring("spring", joint="joint", stiffness=0.025)],
        sensors=[fmb.JointCoordinate("turn", joint="joint"), fmb.ForceOf("moment", force="spring")],
        events=[
            fmb.Event("latch", at=0.5, then=fmb.Lock("joint")),
            fmb.Event("open", at=0.7, then=fmb.Unlock("joint")),
        ],
    )
    solution = fmb.simulate(model, 1.0, samples=11, integrator=integrator)
    w = np.sqrt(0.025 / J[2])
    held = 30.0 / w * np.sin(0.5 * w)
    assert solution["turn"][-1] == pytest.approx(held * np.cos(0.3 * w), abs=2e-3)
    np.testing.assert_allclose(solution["moment"][:, 5], -0.025 * solution["turn"], atol=1e-12)
    assert np.linspace(0.0, 1.0, 11)[7] > 0.7
    assert np.all(np.isclose(solution.t, 0.7) <= (solution.t == 0.7))


def test_a_latch_holds_a_while():
    """A wheel under a torque of 0.5 N m, J = 0.25 kg m2: locked from 0.5 to 1 s,
    it starts again from rest at 2 rad/s2.
    """
    wheel = fmb.RigidBody("body", mass=1.0, inertia=J, markers={"pin": (0, 0, 0), "corner": (1, 0, 0)})
    joint = fmb.Revolute("joint", markers=PINS)
    model = fmb.Model(
        bodies=[fmb.Ground(), wheel],
        joints=[joint],
        forces=[fmb.Actuator("motor", joint="joint", effort=0.5)],
        sensors=[fmb.JointCoordinate("turn", joint="joint"), fmb.Reaction("held", joint="joint")],
        events=[
            fmb.Event("latch", at=0.5, then=fmb.Lock("joint")),
            fmb.Event("open", at=1.0, then=fmb.Unlock("joint")),
        ],
    )
    solution = fmb.simulate(model, 2.0, samples=21)
    t = solution.t
    expected = np.where(t <= 0.5, t**2, np.where(t <= 1.0, 0.25, 0.25 + (t - 1.0) ** 2))
    np.testing.assert_allclose(solution["turn"], expected, atol=1e-6)
    assert [phase.ended for phase in solution.phases] == ["latch", "open", "finished"]
    assert [len(phase.model.joints) for phase in solution.phases] == [1, 2, 1]


def test_the_reading_of_a_drive_goes_with_it():
    """Locked at 2 rad/s 0.2 s = 0.4 rad, whatever the drive says later."""
    drive = fmb.Drive("motor", joint="joint", angle=fmb.ramp(rate=2.0))
    model = free(
        KINDS[0][0],
        body(),
        drive,
        sensors=[fmb.Reaction("torque", joint="motor"), fmb.JointCoordinate("turn", joint="joint")],
    )
    solution = fmb.simulate(model, 0.4, samples=9)
    assert solution["turn"][-1] == pytest.approx(0.4, abs=1e-9)
    assert [joint.name for joint in solution.phases[-1].model.joints] == ["joint", "joint locked turn"]


@pytest.mark.parametrize(
    ("make", "found"),
    [
        (
            lambda: free(KINDS[0][0], body(), fmb.Drive("motor", joint="joint", angle=0.0), then=fmb.Lock("motor")),
            "Lock of 'motor', which is a Drive",
        ),
        (
            lambda: free(KINDS[8][0], body(), sensors=[fmb.JointCoordinate("slid", joint="joint")]),
            "Lock makes 'joint' (InLine) a fixed joint, but Sensor 'slid' needs a freedom of it",
        ),
        (lambda: free(KINDS[6][0], body(), then=fmb.Unlock("joint")), "Unlock of 'joint', which is a Spherical"),
        (lambda: free(KINDS[6][0], body(), then=fmb.Unlock("jiont")), "joint 'jiont' does not exist"),
    ],
)
def test_messages(make, found):
    with pytest.raises(ModelError) as caught:
        make()
    assert found in str(caught.value)
    assert caught.value.remedy


def test_a_joint_of_two_cables_is_refused_before_the_run():
    """Their markers are fractions of the length: none can be added where the joint happens to be."""
    steel = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
    ropes = [
        fmb.AncfCable(
            name,
            points=((x, 0, 0), (x + 1.0, 0, 0)),
            elements=2,
            section=fem.Section.solid_circle(0.01),
            material=steel,
            markers={"mid": 0.5},
        )
        for name, x in (("a", 0.0), ("b", 1.0))
    ]
    with pytest.raises(ModelError, match=r"joint 'joint' \(Spherical\) joins two flexible bodies"):
        fmb.Model(
            bodies=[fmb.Ground(), *ropes],
            joints=[fmb.Spherical("joint", markers=("a.end", "b.start"))],
            events=[fmb.Event("jam", at=0.1, then=fmb.Lock("joint"))],
        )
