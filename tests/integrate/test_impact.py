"""Impacts inside mechanisms: momentum of the whole, energy, order of events, and what is said about wrong ones."""

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb


def struck(restitution, **fields):
    """A rod hinged at its end at rest, and a ball that flies at it, 0.7 m from the hinge; both in the plane x-y."""
    rod = fmb.RigidBody.rod(
        "rod", length=1.0, mass=3.0, markers={"face": fmb.Pose.axes((0.7, 0, 0), x=(1, 0, 0), z=(0, 0, 1))}
    )
    ball = fmb.PointMass("ball", mass=0.5, at=(0.7, -0.2, 0), velocity=(0.3, 2.0, 0))
    impact = fmb.Impact(("rod.face", "ball.center"), restitution=restitution, along="y")
    # the ball is on the side -y: seen along -y of the face
    turned = fmb.Pose.axes((0.7, 0, 0), x=(-1, 0, 0), z=(0, 0, 1))
    rod = rod.replaced(markers={**rod.markers, "face": turned})
    return fmb.Model(
        bodies=[fmb.Ground(), rod, ball],
        joints=[fmb.Revolute("hinge", markers=("ground.origin", "rod.start"))],
        sensors=[
            fmb.Distance("gap", markers=("rod.face", "ball.center"), along="y"),
            fmb.Velocity("v", marker="ball.center"),
            fmb.JointCoordinate("angle", joint="hinge"),
            fmb.Velocity("tip", marker="rod.end"),
            fmb.Energy("kinetic", kind="kinetic"),
        ],
        events=[fmb.Event("hit", sensor="gap", below=0.0, repeats=True, then=impact)],
        **fields,
    )


@pytest.mark.parametrize(
    ("e", "integrator"), every_second([0.0, 0.6, 1.0], [fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Explicit()])
)
def test_a_ball_strikes_a_hinged_rod(e, integrator):
    """Angular momentum about the hinge is kept: w = (1 + e) m v s / (J + m s^2); the hinge takes the rest."""
    m, v, s, J = 0.5, 2.0, 0.7 + 0.3 * 0.1, 3.0 / 3.0
    solution = fmb.simulate(struck(e), 0.1 + 1e-3, samples=2, integrator=integrator)
    assert solution.phases[0].t[-1] == pytest.approx(0.1, abs=1e-11)
    w = (1 + e) * m * v * s / (J + m * s * s)
    k = len(solution.phases[0].t)
    assert solution["tip"][k, 1] == pytest.approx(w, rel=1e-9)
    assert solution["v"][k, 1] == pytest.approx(w * s - e * v, rel=1e-9)
    assert solution["v"][k, 0] == pytest.approx(0.3, rel=1e-12)
    if e == 1.0:
        assert solution["kinetic"][k] == pytest.approx(solution["kinetic"][k - 1], rel=1e-9)


@pytest.mark.parametrize("e", [0.0, 0.6])
def test_impulses_of_the_contact_and_of_the_hinge(e, tmp_path):
    """P = (1 + e) v / (1/m + s^2 / J) on the ball; the hinge has what the rod's momentum lacks: M w L / 2 - P."""
    m, v, s, J, M = 0.5, 2.0, 0.7 + 0.3 * 0.1, 3.0 / 3.0, 3.0
    P = (1 + e) * v / (1 / m + s * s / J)
    solution = fmb.simulate(struck(e), 0.1 + 1e-3, samples=2, output=tmp_path / "s.h5")
    for known in (solution, fmb.Solution.load(tmp_path / "s.h5", model=struck(e))):
        (found,) = fmb.impulses(known)
        assert (found.event, found.markers) == ("hit", ("rod.face", "ball.center"))
        assert found.t == pytest.approx(0.1, abs=1e-11)
        assert found.impulse == pytest.approx(P, rel=1e-9)
        np.testing.assert_allclose(found.joints["hinge"][:3], [0.0, M * P * s / J * 0.5 - P, 0.0], atol=1e-9)


def test_events_in_one_interval_happen_in_their_order():
    """Both thresholds are passed between the same two looks; the list names the later one first."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("mass", mass=1.0, velocity=(1.0, 0, 0))],
        sensors=[fmb.Position("p", marker="mass.center")],
        events=[
            fmb.Event(name, sensor="p", column=0, above=x, then=fmb.Change("mass", mass=mass))
            for name, x, mass in (("late", 0.50037, 3.0), ("early", 0.50023, 2.0))
        ],
    )
    solution = fmb.simulate(model, 1.0, samples=3)
    assert [phase.ended for phase in solution.phases] == ["early", "late", "finished"]
    np.testing.assert_allclose([phase.t[-1] for phase in solution.phases[:2]], [0.50023, 0.50037], atol=1e-11)


def test_what_is_lifted_over_the_threshold_again_happens_again():
    """A repeating event of a harmonic motion: once per period, at the times of the closed form."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("mass", mass=1.0, at=(1.0, 0, 0))],
        forces=[fmb.SpringDamper("spring", markers=("ground.origin", "mass.center"), stiffness=400.0, length=0.9)],
        sensors=[fmb.Distance("d", markers=("ground.origin", "mass.center"))],
        events=[fmb.Event("short", sensor="d", below=0.85, repeats=True, then=fmb.Change("mass", at=(0, 0, 0)))],
    )
    solution = fmb.simulate(model, 1.0, samples=11, integrator=fmb.GeneralizedAlpha(rtol=1e-9))
    # x = 0.9 + 0.1 cos(20 t): first at cos = -0.5, then every pi / 10
    expected = np.arccos(-0.5) / 20 + np.pi / 10 * np.arange(3)
    np.testing.assert_allclose([phase.t[-1] for phase in solution.phases[:-1]], expected, atol=1e-5)


def test_a_contact_that_lasts_ends_the_run_and_keeps_it():
    model = struck(0.0, gravity=(0, 9.81, 0))
    model = model.changed("ball", velocity=(0, 2.0, 0))
    joint = fmb.Fixed("held", markers=("ground.origin", "rod.start"))
    model = fmb.Model(
        gravity=model.gravity,
        bodies=model.bodies,
        joints=[joint],
        events=model.events,
        sensors=[s for s in model.sensors if s.name != "angle"],
    )
    with pytest.raises(
        fmb.IntegrationError, match=r"Event 'hit' happens again and again at t = 0\.0.*Contact"
    ) as caught:
        fmb.simulate(model, 1.0)
    assert all((caught.value.part, caught.value.found, caught.value.expected, caught.value.remedy))
    assert caught.value.solution.t[-1] > 0.05


def test_an_impulse_that_moves_nothing():
    model = struck(1.0)
    wall = fmb.Fixed("wall", markers=("ground.origin", "rod.start"))
    pin = fmb.RigidBody("pin", mass=0.1, inertia=(1, 1, 1), at=(0.5, 0.5, 0))
    sensor = fmb.Distance("gap", markers=("rod.start", "pin.center"), along="y")
    event = fmb.Event(
        "hit", sensor="gap", above=0.4, then=fmb.Impact(("rod.start", "pin.center"), restitution=0.5, along="y")
    )
    held = fmb.Fixed("held", markers=("ground.there", "pin.center"))
    ground = fmb.Ground(markers={"there": (0.5, 0.5, 0)})
    model = fmb.Model(bodies=[ground, model.bodies[1], pin], joints=[wall, held], sensors=[sensor], events=[event])
    with pytest.raises(fmb.IntegrationError, match=r"Event 'hit'.*rod.start and pin.center moves nothing"):
        fmb.simulate(model, 1.0)


@pytest.mark.parametrize(
    ("fields", "found"),
    [
        ({"restitution": 1.2}, "restitution = 1.2"),
        ({"restitution": 0.5, "along": "n"}, "along = 'n'"),
        ({"restitution": 0.5, "markers": ("rod.face", "ball.middle")}, "ball.middle"),
        ({"restitution": 0.5, "markers": ("rod.face",)}, "markers = ('rod.face',)"),
    ],
)
def test_wrong_impacts(fields, found):
    impact = fmb.Impact(fields.pop("markers", ("rod.face", "ball.center")), **fields)
    model, event = struck(1.0), fmb.Event("hit", sensor="gap", below=0.0, then=impact)
    with pytest.raises(fmb.ModelError) as caught:
        fmb.Model(bodies=model.bodies, joints=model.joints, sensors=model.sensors, events=[event])
    assert found in str(caught.value)
    assert all((caught.value.part, caught.value.expected, caught.value.remedy))


def test_a_time_does_not_repeat():
    with pytest.raises(fmb.ModelError, match=r"repeats = True with at = 1.0 s"):
        fmb.Event("once", at=1.0, repeats=True, then=fmb.Stop())


@pytest.mark.parametrize(("fields", "found"), [({"markers": "ab"}, "markers = 'ab'"), ({"along": "w"}, "along = 'w'")])
def test_wrong_distances(fields, found):
    with pytest.raises(fmb.ModelError) as caught:
        fmb.Distance("d", **{"markers": ("a.b", "c.d"), **fields})
    assert found in str(caught.value)
    assert all((caught.value.part, caught.value.expected, caught.value.remedy))
