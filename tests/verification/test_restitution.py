"""Restitution by Poisson's law, and what has no rebound by Newton's: held bodies, against closed forms."""

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb

LEFT = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 1, 0))


def between_walls(law, play, speed=1.0):
    """Return a ball of 1 kg that flies along x from the right wall to the left one, and sideways."""
    ball = fmb.RigidBody("b", mass=1.0, inertia=(4e-3,) * 3, at=(0.1, 0, 0), velocity=(-speed, 0, 0.3))
    right = fmb.Pose.axes((0.2 + play, 0, 0), z=(-1, 0, 0), x=(0, 1, 0))
    return fmb.Model(
        bodies=[fmb.Ground(markers={"l": LEFT, "r": right}), ball],
        surfaces=[
            fmb.Surface("l", marker="ground.l", shape=fmb.Plane()),
            fmb.Surface("r", marker="ground.r", shape=fmb.Plane()),
            fmb.Surface("b", marker="b.center", shape=fmb.Sphere(radius=0.1)),
        ],
        forces=[fmb.SurfaceContact("c", surfaces=(("l", "r"), "b"), law=law)],
        sensors=[fmb.Velocity("v", marker="b.center"), fmb.Position("p", marker="b.center")],
    )


@pytest.mark.parametrize("rule", ["Newton", "Poisson"])
@pytest.mark.parametrize("play", [0.0, 1e-9])
def test_ball_without_play_stops(rule, play):
    """It cannot rebound, because the other wall holds it: what is left is the motion along the walls."""
    law = fmb.Rigid(restitution=0.5, rule=rule)
    solution = fmb.simulate(between_walls(law, play), 0.02, integrator=fmb.MoreauJean(step=1e-3), samples=3)
    np.testing.assert_allclose(solution["v"][-1], (0, 0, 0.3), atol=1e-7)
    told = solution.statistics["impacts without a rebound by Newton's law"]
    assert (told > 0) == (rule == "Newton")
    series = solution.series(0)
    assert series.energy[-1].sum() == pytest.approx(0.5 * 0.3**2, rel=1e-6)
    assert series.energy[-1].sum() + series.works[-1, 2] == pytest.approx(0.5 * 1.09, rel=1e-6)


@pytest.mark.parametrize("rule", ["Newton", "Poisson"])
def test_ball_on_the_floor(rule):
    """One impact without friction: both laws give back e times the speed."""
    law = fmb.Rigid(restitution=0.5, rule=rule)
    model = between_walls(law, 10.0)
    solution = fmb.simulate(model, 0.02, integrator=fmb.MoreauJean(step=1e-3), samples=3)
    np.testing.assert_allclose(solution["v"][-1], (0.5, 0, 0.3), atol=1e-9)


@pytest.mark.parametrize(
    ("rule", "e", "h", "m"),
    [
        ("Newton", 0.9, 1.0, 1.0),
        slow("Poisson", 0.9, 1.0, 1.0),
        slow("Newton", 0.6, 0.05, 40.0),
        ("Poisson", 0.6, 0.05, 40.0),
    ],
)
def test_the_last_bounces_end(rule, e, h, m):
    """At rest after sqrt(2 h / g) (1 + e) / (1 - e): what holds the weight in a step is not given back."""
    g, radius = 9.81, 0.1
    end = np.sqrt(2.0 * h / g) * (1.0 + e) / (1.0 - e)
    model = fmb.Model(
        gravity=(0, 0, -g),
        bodies=[fmb.Ground(), fmb.RigidBody("b", mass=m, inertia=(0.004 * m,) * 3, at=(0, 0, radius + h))],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            fmb.Surface("b", marker="b.center", shape=fmb.Sphere(radius=radius)),
        ],
        forces=[fmb.SurfaceContact("c", surfaces=("floor", "b"), law=fmb.Rigid(restitution=e, rule=rule))],
        sensors=[fmb.Velocity("v", marker="b.center")],
    )
    solution = fmb.simulate(model, 1.1 * end, integrator=fmb.MoreauJean(step=end / 2000), samples=441)
    moving = solution.t[np.abs(np.asarray(solution["v"])[:, 2]) > 1e-9]
    assert 0.96 * end < moving[-1] < 1.001 * end


def slipping_rod(law, *, speed=1.0, sideways=0.0):
    """Return a rod of 1 kg and 1 m at 45 degrees whose lower end strikes a floor."""
    half, c = 0.5, np.cos(np.pi / 4)
    J = 1.0 / 12.0
    rod = fmb.RigidBody(
        "rod",
        mass=1.0,
        inertia=(J, J, 1e-3),
        at=(0, 0, half * c),
        velocity=(sideways, 0, -speed),
        markers={"tip": (-half * c, 0, -half * c)},
    )
    return fmb.Model(
        bodies=[fmb.Ground(markers={"floor": (0, 0, 0)}), rod],
        surfaces=[
            fmb.Surface("floor", marker="ground.floor", shape=fmb.Plane()),
            fmb.Surface("tip", marker="rod.tip", shape=fmb.Hull(points=TINY)),
        ],
        forces=[fmb.SurfaceContact("c", surfaces=("floor", "tip"), law=law)],
        sensors=[fmb.Velocity("v", marker="rod.center"), fmb.Velocity("tip", marker="rod.tip")],
    )


TINY = 1e-9 * np.array([(0, 0, 0), (1, 0, 2), (0, 1, 2), (-1, -1, 2.0)])


@pytest.mark.parametrize(("rule", "e", "mu"), [("Newton", 0.5, 0.1), ("Poisson", 0.5, 0.1), ("Poisson", 0.8, 0.05)])
def test_oblique_impact_with_friction(rule, e, mu):
    """A rod strikes askew and slips all along: impulses by hand from the mobility of its tip.

    With the lever r = (-c, 0, -c)/2 from the centre, D_NN = 1 + x^2/J, D_NT = -x z/J (x = z = -c/2).
    It slips one way through both phases, so P_T = -mu P_N there, P_C = v / (D_NN - mu D_NT s) and P = (1 + e) P_C in
    both laws alike.
    """
    x = z = -0.5 * np.cos(np.pi / 4)
    J = 1.0 / 12.0
    DNN, DNT = 1.0 + x * x / J, -x * z / J
    s = np.sign(DNT)  # the normal impulse pushes the tip this way, and friction acts against it
    P = (1.0 + e) / (DNN - mu * s * DNT)
    solution = fmb.simulate(
        slipping_rod(fmb.Rigid(restitution=e, friction=mu, rule=rule)),
        2e-4,
        integrator=fmb.MoreauJean(step=1e-5),
        samples=3,
    )
    assert abs(DNT) - mu * (1.0 + z * z / J) > 0.0  # slips
    np.testing.assert_allclose(solution["v"][-1], (-s * mu * P, 0, P - 1.0), atol=2e-3)


def test_the_laws_differ_where_slip_ends():
    """A tip that is pushed sideways sticks in both phases: against the impulses by hand.

    Compression stops the tip, D P_C = -xi; in the expansion the normal impulse is e times P_C and friction keeps the
    tip from slipping, D_TT P_T + D_TN e P_CN = 0. Newton's law: the tip leaves with e times its normal speed, and
    without slip.
    """
    x = z = -0.5 * np.cos(np.pi / 4)
    J, e = 1.0 / 12.0, 0.6
    D = np.array([[1.0 + x * x / J, -x * z / J], [-x * z / J, 1.0 + z * z / J]])
    before = np.array([-1.0, 0.4])
    compression = np.linalg.solve(D, -before)
    again = e * compression[0]
    poisson = compression + (again, -D[1, 0] / D[1, 1] * again)
    newton = np.linalg.solve(D, (e, 0.0) - before)
    assert all(abs(P[1]) < 0.9 * P[0] for P in (compression, poisson - compression, newton))
    for rule, P in (("Newton", newton), ("Poisson", poisson)):
        model = slipping_rod(fmb.Rigid(restitution=e, friction=0.9, rule=rule), sideways=0.4)
        solution = fmb.simulate(model, 2e-4, integrator=fmb.MoreauJean(step=1e-5), samples=3)
        np.testing.assert_allclose(solution["v"][-1], (0.4 + P[1], 0, P[0] - 1.0), atol=2e-3)
    assert abs(newton[0] - poisson[0]) > 0.05


def test_rule_is_checked():
    with pytest.raises(fmb.ModelError, match="Poisson"):
        fmb.Rigid(restitution=0.5, rule="Poison")


@pytest.mark.parametrize("e", [0.5, 1.0])
@pytest.mark.parametrize("lift", [0.0, 300.0, 900.0, -300.0])
def test_a_force_at_the_impact_changes_nothing_of_the_rebound(lift, e):
    """One impact without friction: both laws send the ball back with e times its speed, whatever pulls or presses."""
    for rule in ("Newton", "Poisson"):
        ball = fmb.RigidBody("b", mass=1.0, inertia=(4e-3,) * 3, at=(0.1, 0, 0), velocity=(-1.0, 0, 0))
        model = fmb.Model(
            bodies=[fmb.Ground(markers={"l": LEFT}), ball],
            surfaces=[
                fmb.Surface("l", marker="ground.l", shape=fmb.Plane()),
                fmb.Surface("b", marker="b.center", shape=fmb.Sphere(radius=0.1)),
            ],
            forces=[
                fmb.SurfaceContact("c", surfaces=("l", "b"), law=fmb.Rigid(restitution=e, rule=rule)),
                fmb.PointLoad("lift", marker="b.center", force=(lift, 0.0, 0.0)),
            ],
            sensors=[fmb.Velocity("v", marker="b.center")],
        )
        solution = fmb.simulate(model, 1e-3, integrator=fmb.MoreauJean(step=1e-3), samples=2)
        assert solution["v"][-1, 0] == pytest.approx(e, abs=1e-9)
        assert "warnings" not in solution.statistics
