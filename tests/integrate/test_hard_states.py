"""Hard states: dead centres, vanishing steps, events at the start and at one time, mechanisms that an event makes
impossible.

Whatever cannot be followed says who, what, what was expected and what to do, and the samples before it are kept.
"""

from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import CompileError, FlexmbError, IntegrationError, ModelError

INTEGRATORS = [fmb.GeneralizedAlpha(), fmb.GeneralizedAlpha(step=1e-3), fmb.IDA(), fmb.Explicit()]
NAMES = ["alpha adaptive", "alpha", "IDA", "explicit"]


def four_parts(error: FlexmbError) -> str:
    """Check that a message has its four parts and return it."""
    assert all((error.part, error.found, error.expected, error.remedy)), error
    return str(error)


def crank_slider(angle: float, drive: str = "") -> fmb.Model:
    """Crank 1 m, rod 1.5 m, slider along x; at angle 0 they are stretched: a dead centre for a driven slider."""
    along = fmb.Pose.axes((0, 0, 0), x=(0, 1, 0), z=(1, 0, 0))
    knee = np.array([np.cos(angle), np.sin(angle), 0.0])
    tilt = -np.arcsin(np.sin(angle) / 1.5)
    crank = fmb.RigidBody.rod("crank", length=1.0, mass=1.0, radius=0.05, rotation=(0, 0, angle))
    rod = fmb.RigidBody.rod("rod", length=1.5, mass=1.0, radius=0.05, at=knee, rotation=(0, 0, tilt))
    x = knee[0] + 1.5 * np.cos(tilt)
    slider = fmb.RigidBody(
        "slider", mass=1.0, inertia=(1, 1, 1), at=(x, 0, 0), markers={"rail": along, "pin": (0, 0, 0)}
    )
    joints = [
        fmb.Revolute("pivot", markers=("ground.origin", "crank.start")),
        fmb.Spherical("knee", markers=("crank.end", "rod.start")),
        fmb.Spherical("wrist", markers=("rod.end", "slider.pin")),
        fmb.Prismatic("rail", markers=("ground.rail", "slider.rail")),
    ]
    if drive:
        joints.append(fmb.Drive("push", joint="rail", displacement=fmb.expression(f"{x:.16g} {drive}")))
    return fmb.Model(
        name="crank drive",
        bodies=[fmb.Ground(markers={"rail": along}), crank, rod, slider],
        joints=joints,
        sensors=[fmb.JointCoordinate("angle", joint="pivot"), fmb.JointCoordinate("stroke", joint="rail")],
    )


def test_a_driven_start_at_a_dead_centre():
    with pytest.raises(CompileError) as caught:
        fmb.simulate(crank_slider(0.0, "- t**2"), 0.5)
    text = four_parts(caught.value)
    assert "singular configuration: push" in text
    assert "dead centre" in text


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=NAMES)
def test_the_same_start_is_none_for_a_driven_crank(integrator):
    """Closed form of the stroke: cos a + sqrt(1.5^2 - sin^2 a)."""
    model = crank_slider(0.0)
    drive = fmb.Drive("push", joint="pivot", angle=fmb.expression("t**2"))
    model = fmb.Model(bodies=model.bodies, joints=[*model.joints, drive], sensors=model.sensors)
    solution = fmb.simulate(model, 1.0, samples=11, integrator=integrator)
    a = solution.t**2
    np.testing.assert_allclose(solution["stroke"], np.cos(a) + np.sqrt(2.25 - np.sin(a) ** 2), atol=1e-5)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=NAMES)
def test_a_dead_centre_that_a_driven_slider_reaches(integrator):
    """Stretched at x = 2.5 m, t = 0.5 s: the crank's speed grows beyond all bounds there."""
    angle = 0.8
    x = np.cos(angle) + np.sqrt(2.25 - np.sin(angle) ** 2)
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(crank_slider(angle, f"+ {4.2 * (2.5 - x)}*t**2"), 1.0, samples=41, integrator=integrator)
    assert "Model 'crank drive'" in four_parts(caught.value)
    kept = caught.value.solution
    assert kept.status.kind == "failed"
    assert 0.4 < kept.t[-1] < 0.5
    np.testing.assert_allclose(kept["stroke"], x + 4.2 * (2.5 - x) * kept.t**2, atol=1e-5)


def hinged(*drives) -> fmb.Model:
    """A body that turns freely about z at 2 rad/s, and drives of its hinge."""
    body = fmb.RigidBody(
        "arm", mass=1.0, inertia=(0.1, 0.1, 0.1), angular_velocity=(0, 0, 2.0), markers={"pin": (0, 0, 0)}
    )
    joints = [fmb.Revolute("pivot", markers=("ground.origin", "arm.pin")), *drives]
    return fmb.Model(
        bodies=[fmb.Ground(), body],
        joints=joints,
        sensors=[fmb.JointCoordinate("angle", joint="pivot"), fmb.ConstraintError("gap")],
    )


@pytest.mark.parametrize(
    "other",
    [fmb.Drive("two", joint="pivot", angle=fmb.ramp(rate=2.5)), fmb.Fixed("two", markers=("ground.origin", "arm.pin"))],
    ids=["drive", "fixed"],
)
def test_speeds_that_contradict_each_other_at_the_start(other):
    with pytest.raises(CompileError) as caught:
        fmb.simulate(hinged(fmb.Drive("one", joint="pivot", angle=fmb.ramp(rate=2.0)), other), 1.0)
    text = four_parts(caught.value)
    assert "'one: Angle': its first derivative misses zero by" in text
    assert "two drives contradict each other" in text


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=NAMES)
def test_drives_that_part_on_the_way(integrator):
    """From t = 0.5 s on the second drive runs ahead: by 10 s^3 - 15 s^4 + 6 s^5 with s = 2 t - 1."""
    model = hinged(
        fmb.Drive("one", joint="pivot", angle=fmb.ramp(rate=2.0)),
        fmb.Drive("two", joint="pivot", angle=fmb.expression("2*t + smooth(2*t - 1)")),
    )
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(model, 1.0, samples=101, integrator=integrator)
    text = four_parts(caught.value)
    assert "dependent equations stay open" in text
    assert "one: Angle" in text
    assert "two: Angle" in text
    kept = caught.value.solution
    assert 0.49 < kept.t[-1] < 0.53
    np.testing.assert_allclose(kept["angle"], 2.0 * kept.t, atol=1e-4)
    assert kept["gap"].max() < 1e-4


def spring(stiffness: float, length: float = 1.001) -> fmb.Model:
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.PointMass("mass", mass=1.0, at=(0, 0, -length))],
        forces=[fmb.SpringDamper("spring", markers=("ground.origin", "mass.center"), stiffness=stiffness, length=1.0)],
        sensors=[fmb.Position("p", marker="mass.center")],
    )


def test_a_stiffness_at_which_explicit_steps_vanish():
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(spring(1e14), 1.0, samples=11, integrator=fmb.Explicit(most_steps=200))
    text = four_parts(caught.value)
    assert "200 steps between two samples" in text
    assert "stiff" in text
    assert len(caught.value.solution.t) == 1


def test_a_stiffness_that_implicit_steps_damp_away():
    """What the steps cannot resolve is damped: the mass stays where the spring holds it."""
    solution = fmb.simulate(spring(1e14, 1.0), 1.0, samples=11, integrator=fmb.GeneralizedAlpha(step=1e-3))
    assert solution["p"][-1, 2] == pytest.approx(-1.0, abs=1e-9)


def test_a_stiffness_that_is_no_number():
    with pytest.raises(ModelError) as caught:
        spring(float("nan"))
    assert "stiffness = nan" in four_parts(caught.value)


def dropped(events) -> fmb.Model:
    """A mass on a rod, at rest beside it."""
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.PointMass("mass", mass=1.0, at=(1.0, 0, 0))],
        joints=[fmb.Rod("rod", markers=("ground.origin", "mass.center"))],
        sensors=[fmb.Position("p", marker="mass.center"), fmb.Velocity("v", marker="mass.center")],
        events=events,
    )


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=NAMES)
@pytest.mark.parametrize(
    "event",
    [
        fmb.Event("cut", at=0.0, then=fmb.Release("rod")),
        fmb.Event("cut", sensor="p", column=0, above=0.5, then=fmb.Release("rod")),
    ],
    ids=["time", "sensor"],
)
def test_events_at_the_start(event, integrator):
    """The rod breaks before anything moves: free fall."""
    solution = fmb.simulate(dropped([event]), 0.5, samples=6, integrator=integrator)
    assert [phase.ended for phase in solution.phases] == ["cut", "finished"]
    assert solution.phases[0].t.tolist() == [0.0]
    np.testing.assert_allclose(solution["p"][-1], [1.0, 0, -0.5 * 9.81 * 0.25], atol=1e-8)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=NAMES)
def test_two_events_at_one_time_happen_in_their_order(integrator):
    """At 0.2 s the rod breaks and the mass becomes heavy, which changes nothing in free fall;
    at 0.2 s again it stops.
    """
    events = [
        fmb.Event("cut", at=0.2, then=fmb.Release("rod")),
        fmb.Event("heavy", at=0.2, then=fmb.Change("mass", mass=5.0)),
        fmb.Event("end", at=0.2, then=fmb.Stop()),
    ]
    solution = fmb.simulate(dropped(events), 0.5, samples=6, integrator=integrator)
    assert [phase.ended for phase in solution.phases] == ["cut", "heavy", "end"]
    assert solution.status.kind == "stopped"
    assert solution.t[-1] == pytest.approx(0.2)
    assert solution.phases[-1].model.body("mass").mass == 5.0


def test_an_event_happens_once():
    """The mass passes the threshold twice, up and down; without `repeats` it counts once."""
    mass = fmb.PointMass("mass", mass=1.0, velocity=(0, 0, 5.0))
    load = fmb.Change("load", force=(0, 0, -9.81))
    model = fmb.Model(
        bodies=[fmb.Ground(), mass],
        forces=[fmb.PointLoad("load", marker="mass.center", force=(0, 0, -9.81))],
        sensors=[fmb.Position("p", marker="mass.center")],
        events=[fmb.Event("high", sensor="p", column=2, above=0.5, then=load)],
    )
    solution = fmb.simulate(model, 1.2, samples=13)
    assert [phase.ended for phase in solution.phases] == ["high", "finished"]


def test_what_an_event_makes_impossible_keeps_the_motion_before():
    """A drive changed to a displacement beyond reach: the next phase cannot be assembled."""
    model = crank_slider(0.8, "- 0.1*t")
    event = fmb.Event("jump", at=0.25, then=fmb.Change("push", displacement=9.0))
    model = fmb.Model(name="jump", bodies=model.bodies, joints=model.joints, sensors=model.sensors, events=[event])
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(model, 1.0, samples=41)
    text = four_parts(caught.value)
    assert "t = 0.25 s" in text
    assert "cannot be assembled" in text
    assert caught.value.solution.t[-1] == pytest.approx(0.25)
    assert caught.value.solution.status.kind == "failed"


def test_a_drive_that_an_event_lets_begin_elsewhere():
    """2 rad/s for 0.5 s is 1 rad; a ramp with 3 rad/s from t = 0 would be at 1.5 rad. One from 1 rad on is right."""
    drive = fmb.Drive("motor", joint="pivot", angle=fmb.ramp(rate=2.0))
    faster = [fmb.ramp(rate=3.0), fmb.expression("1 + 3*(t - 0.5)")]
    models = [
        replace(hinged(drive), events=(fmb.Event("faster", at=0.5, then=fmb.Change("motor", angle=angle)),))
        for angle in faster
    ]
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(models[0], 1.0, samples=11)
    text = four_parts(caught.value)
    assert "Event 'faster' at t = 0.5 s: what it changes moves Body 'arm' by 0 m and 0.5" in text
    assert caught.value.solution["angle"][-1] == pytest.approx(1.0)
    assert fmb.simulate(models[1], 1.0, samples=11)["angle"][-1] == pytest.approx(2.5, abs=1e-6)


def test_an_event_that_releases_what_another_has_released():
    """The second release names a joint that is gone by then: the samples before are kept."""
    events = [fmb.Event("cut", at=0.1, then=fmb.Release("rod")), fmb.Event("again", at=0.2, then=fmb.Release("rod"))]
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(dropped(events), 0.5, samples=6)
    assert "there is no joint or force 'rod' to release" in four_parts(caught.value)
    assert caught.value.solution.t[-1] >= 0.1


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=NAMES)
def test_numbers_that_are_none_from_a_load(integrator):
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("mass", mass=1.0)],
        sensors=[fmb.Position("p", marker="mass.center")],
        forces=[fmb.PointLoad("load", marker="mass.center", force=(fmb.expression("sqrt(0.1 - t)"), 0, 0))],
    )
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(model, 0.5, samples=51, integrator=integrator)
    four_parts(caught.value)
    assert 0.05 < caught.value.solution.t[-1] < 0.1 + 1e-9


def test_dependent_equations_of_joints_in_one_point():
    """A shaft in two bearings with all markers in one point: the model has no size, and tolerances are those of 1 m."""
    shaft = fmb.RigidBody("shaft", mass=1.0, inertia=(0.1, 0.1, 0.1))
    bearings = [fmb.Revolute(name, markers=("ground.origin", "shaft.center")) for name in ("A", "B")]
    motor = fmb.Drive("motor", joint="A", angle=fmb.expression("20*t"))
    model = fmb.Model(
        bodies=[fmb.Ground(), shaft],
        joints=[*bearings, motor],
        gravity=(1.0, 2.0, 3.0),
        sensors=[fmb.JointCoordinate("turn", joint="B")],
    )
    solution = fmb.simulate(model, 1.0, samples=3, integrator=fmb.Explicit())
    np.testing.assert_allclose(np.ravel(solution["turn"]), [0.0, 10.0, 20.0], atol=1e-8)
