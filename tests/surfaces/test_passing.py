"""No step passes a contact unseen: first touches against closed forms and another library, a bullet and a plate."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from surfaces.bodies_of_triangles import ball

import flexmb as fmb
from flexmb.surfaces.advancement import FINEST, first_touch
from flexmb.surfaces.detection import find_closest, nearest_sample
from flexmb.surfaces.records import CONTACT


def touch(first, second, start, way, rotation=None, turn=(0, 0, 0), floor=1e-9):
    """Return when b, moving straight by `way` and turning by `turn` (rotation vector), first touches a."""
    a, b = (fmb.Surface("s", marker="b.m", **given).packed for given in (first, second))
    data = np.concatenate([a, b])
    sampled = "spacing" in first or "spacing" in second
    Q0 = Rotation.from_rotvec((0, 0, 0) if rotation is None else rotation)
    rows, contacts = [], np.zeros(2, CONTACT)
    for s in (0.0, 1.0):
        Q = (Rotation.from_rotvec(s * np.array(turn, float)) * Q0).as_matrix()
        d = np.asarray(start, float) + s * np.asarray(way, float)
        find = nearest_sample if sampled else find_closest
        find(data, 0, len(a), np.inf, d, Q, contacts)
        row = np.zeros(28)
        row[1], row[10:13], row[13:16], row[19:28] = contacts[0]["gap"], d, way, Q.ravel()
        rows.append(row)
    assert rows[0][1] > 0.0
    assert rows[1][1] > 0.0
    return first_touch(data, sampled, 0, len(a), *rows, 1.0, floor, contacts)


@pytest.mark.parametrize("thickness", [1e-3, 1e-5])
def test_a_ball_through_a_plate(thickness):
    """Gap over way, for a plate thinner than a hundredth of the ball too."""
    plate = {"shape": fmb.Cuboid(size=(thickness, 1.0, 1.0))}
    found = touch(plate, {"shape": fmb.Sphere(5e-4)}, (-0.4, 0.1, 0.2), (0.9, 0.01, 0.0))
    expected = (0.4 - 5e-4 - 0.5 * thickness) / 0.9
    assert expected - 1e-12 <= found <= expected + FINEST * 5e-4 / 0.9 * 2


def test_a_ball_past_a_ball(rng):
    """Two balls on straight ways: the quadratic equation of the distance of their centres; grazing and missing."""
    for miss in (0.0, 0.5, 0.999, 1.001, 1.5):
        e = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        start, way = -2.0 * e[0] + miss * 0.5 * e[1], 4.0 * e[0]
        found = touch({"shape": fmb.Sphere(0.3)}, {"shape": fmb.Sphere(0.2)}, start, way)
        if miss > 1.0:
            assert found == 2.0
        else:
            expected = (2.0 - 0.5 * np.sqrt(1.0 - miss**2)) / 4.0
            assert expected <= found <= expected + 2e-4


def test_a_turning_bar():
    """A bar that turns by 170 degrees above a floor dips below it when its half length exceeds the height."""
    bar = {"shape": fmb.Cuboid(size=(2.0, 0.1, 0.1)), "spacing": 0.05}
    floor = {"shape": fmb.Plane()}
    found = touch(floor, bar, (0, 0, 0.8), (0, 0, 0), turn=(0, np.radians(170), 0))
    lowest = lambda angle: 0.8 - 0.975 * np.sin(angle) - 0.05 * np.cos(angle)  # noqa: E731
    assert found < 0.5
    assert abs(lowest(np.radians(170) * found)) < 0.03
    assert touch(floor, bar, (0, 0, 1.2), (0, 0, 0), turn=(0, np.radians(170), 0)) == 2.0


def test_times_of_another_library(rng):
    """Samples of a box on straight ways against the triangles of a bumpy ball: the first time of impact of ipctk."""
    of_points = pytest.importorskip("ipctk").TightInclusionCCD()
    vertices, triangles = ball(1, bumps=0.3)
    box = fmb.Cuboid(size=(0.3, 0.2, 0.1))
    own = fmb.Surface("s", marker="b.m", shape=box, spacing=0.1)
    hits = 0
    for _ in range(12):
        e = rng.normal(size=3)
        start = -2.5 * e / np.linalg.norm(e) + rng.normal(size=3) * 0.4
        way, turned = -2.0 * start + rng.normal(size=3) * 0.3, rng.normal(size=3)
        found = touch(
            {"shape": fmb.TriangleMesh(vertices, triangles)},
            {"shape": box, "spacing": 0.1},
            start,
            way,
            rotation=turned,
        )
        places = Rotation.from_rotvec(turned).apply(own.points[0]) + start
        times = [2.0]
        for z in places:
            for t in vertices[triangles]:
                hit, time = of_points.point_triangle_ccd(z, *t, z + way, *t)
                if hit:
                    times.append(time)
        expected = min(times)
        hits += expected < 1.0
        assert found == pytest.approx(expected, abs=2e-3)
    assert hits > 4


INTEGRATORS = (
    fmb.GeneralizedAlpha(),
    fmb.GeneralizedAlpha(step=1e-7),
    fmb.IDA(),
    fmb.Explicit(),
    fmb.Implicit(),
    fmb.MoreauJean(step=3e-4),
)


def shot(law, speed=1000.0, **ball):
    """Return a bullet of 1 mm, 1 m before a plate of 1 mm."""
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"o": (0, 0, 0)}),
            fmb.RigidBody.sphere("b", density=7800.0, radius=5e-4, at=(-1.0337, 0.01, 0.013), velocity=(speed, 0, 0)),
        ],
        surfaces=[
            fmb.Surface("plate", marker="ground.o", shape=fmb.Cuboid(size=(1e-3, 0.2, 0.2))),
            fmb.Surface("ball", marker="b.center", shape=fmb.Sphere(5e-4), **ball),
        ],
        forces=[fmb.SurfaceContact("hit", surfaces=("plate", "ball"), law=law)],
        sensors=[fmb.Position("x", marker="b.center"), fmb.Velocity("v", marker="b.center")],
    )


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: f"{type(i).__name__}-{getattr(i, 'step', None)}")
def test_a_bullet_meets_a_plate(integrator):
    """It comes back with its speed: none of the steps, some of them 0.1 m long, passes the plate."""
    solution = fmb.simulate(shot(fmb.Hertz(stiffness=1e9)), t_end=1.5e-3, samples=4, integrator=integrator)
    assert solution["v"][-1, 0] == pytest.approx(-1000.0, rel=2e-2)
    assert solution["x"][-1, 0] < 0.0


@pytest.mark.parametrize("step", [0.3, 7e-4])
@pytest.mark.parametrize("speed", [1.0, 30.0, 1000.0])
def test_bullets_by_steps_with_impulses(speed, step):
    """`MoreauJean` divides its steps at compliant contacts: elastic, and with the damping of Hunt and Crossley.

    m v v'(p) = -K p^e (1 + c v), integrated over the penetration p from v to -r v and back to p = 0, gives with w = c v
    w (1 + r) = ln((1 + w) / (1 - w r)), whatever K and the exponent.
    """
    integrator = fmb.MoreauJean(step=step / speed)
    for c in (0.0, 0.5 / speed):
        law = fmb.Hertz(stiffness=1e9, damping=c)
        solution = fmb.simulate(shot(law, speed), t_end=1.5 / speed, samples=2, integrator=integrator)
        w = c * speed
        r = brentq(lambda r, w=w: w * (1.0 + r) - np.log((1.0 + w) / (1.0 - w * r)), 1e-6, 1.0) if c else 1.0
        assert solution["v"][-1, 0] == pytest.approx(-r * speed, rel=5e-3)
        assert solution.statistics["cut at contacts"] > 0
        assert "warnings" not in solution.statistics


def test_a_bullet_by_long_steps():
    """Steps of a given size meet the plate as well; what they make of the impact is told."""
    with pytest.warns(fmb.ValidityWarning, match="were divided"):
        solution = fmb.simulate(
            shot(fmb.Hertz(stiffness=1e9)), t_end=1.5e-3, samples=4, integrator=fmb.GeneralizedAlpha(step=3e-4)
        )
    assert abs(solution["v"][-1, 0] - 1000.0) > 1.0


def test_a_sampled_bullet():
    law = fmb.ElasticFoundation(modulus=1e13, thickness=1e-3)
    solution = fmb.simulate(shot(law, spacing=1e-4), t_end=1.5e-3, samples=4)
    assert solution["v"][-1, 0] == pytest.approx(-1000.0, rel=2e-2)


@pytest.mark.parametrize("order", [("plate", "cube"), ("cube", "plate")])
@pytest.mark.parametrize("step", [1e-4, 2e-5])
def test_a_fast_cube_strikes_with_an_edge(order, step):
    """Newton's law for the edge that meets the plate first: impulse (1 + e) v_n / (1/m + l^2/J) with the lever l.

    It flies 0.5 mm, half the plate's thickness, in 0.5 us: points of both sides of the plate must not be held at once.
    """
    m, J, half, v, w, e = 1e-3, 1e-9, 5e-4, 1000.0, 1500.0, 0.5
    cube = fmb.RigidBody(
        "cube", mass=m, inertia=(J, J, J), at=(-0.5003, 0, 0), velocity=(v, 0, 0), angular_velocity=(0, 0, w)
    )
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"o": (0, 0, 0)}), cube],
        surfaces=[
            fmb.Surface("plate", marker="ground.o", shape=fmb.Cuboid(size=(1e-3, 0.2, 0.2))),
            fmb.Surface("cube", marker="cube.center", shape=fmb.Cuboid(size=(1e-3, 1e-3, 1e-3))),
        ],
        forces=[fmb.SurfaceContact("hit", surfaces=order, law=fmb.Rigid(restitution=e))],
        sensors=[fmb.Velocity("v", marker="cube.center"), fmb.AngularVelocity("w", marker="cube.center")],
    )
    solution = fmb.simulate(model, 1e-3, samples=2, integrator=fmb.MoreauJean(step=step))
    t = brentq(lambda t: 0.5003 - half - v * t - half * (np.cos(w * t) + np.sin(w * t)), 0.0, 1e-3)
    y = half * (np.sin(w * t) - np.cos(w * t))  # m, the edge beside the centre
    impulse = (1.0 + e) * (v - w * y) / (1.0 / m + y * y / J)
    assert solution["v"][-1] == pytest.approx([v - impulse / m, 0.0, 0.0], rel=1e-4, abs=1e-6)
    # the edge is met up to a quarter of the thickness deep: 0.25 us, 4e-4 rad
    assert solution["w"][-1, 2] == pytest.approx(w + y * impulse / J, rel=1.5e-2)
    assert solution["w"][-1, :2] == pytest.approx(0.0, abs=1.0)
