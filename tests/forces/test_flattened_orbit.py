"""An origin that falls about a flattened centre, and bodies of some size in the fields of J2 and of third bodies.

References: scipy's integration of the accelerations by components (Vallado 2013, section 8.6), in extended precision
where differences count; the turning of the node in closed form; sums over point masses; numbers of 50 digits.
"""

from decimal import Decimal, getcontext

import numpy as np
import pytest
from contracts.random_models import derivative, moved, random_state
from contracts.test_tangents import assert_tangent
from forces.test_orbit_origin import cluster, residual
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.math.harmonic_field import falling_oblate
from flexmb.math.rotations import euler_to_matrix
from flexmb.system import compile as compile_model

MU, RADIUS, J2 = 3.986004418e14, 6378137.0, 1.0826267e-3
TILT = Rotation.from_rotvec((0.3, -0.2, 0.5))


@pytest.fixture(scope="module")
def points():
    return cluster()


def attraction(r, number=float):
    """Attraction of the Earth with J2 by components, m/s2."""
    r = np.asarray(r, number)
    mu, radius, j2 = number(MU), number(RADIUS), number(J2)
    far = np.sqrt((r * r).sum())
    share = 5 * r[2] * r[2] / far**2
    flat = -number(1.5) * j2 * mu * radius**2 / far**5 * r * (np.array((1, 1, 3), number) - share)
    return -mu * r / far**3 + flat


@pytest.mark.parametrize("speed", [0.97, 1.2])
def test_orbit_about_a_flattened_centre(speed):
    """Three turns by scipy, nearly a circle and an ellipse of e = 0.44; the axis is that of z."""
    place = np.array((4.0e6, -5.0e6, 2.6e6))
    far = np.linalg.norm(place)
    across = np.cross((0.3, 0.5, 1.0), place)
    velocity = speed * np.sqrt(MU / far) * across / np.linalg.norm(across)
    orbit = fmb.Orbit(place, velocity, j2=J2, turns=3.0)
    t = np.linspace(0.0, orbit.span, 23)
    own = solve_ivp(
        lambda _, y: np.concatenate([y[3:], attraction(y[:3])]),
        (0, t[-1]),
        np.concatenate([place, velocity]),
        method="DOP853",
        t_eval=t,
        rtol=1e-13,
        atol=1e-9,
    ).y
    r, v = orbit.at(t)
    np.testing.assert_allclose(r, own[:3].T, atol=1e-4)
    np.testing.assert_allclose(v, own[3:].T, atol=1e-7)


def test_axis_of_the_centre_is_free():
    """The same orbit with everything turned."""
    orbit = fmb.Orbit.circular(7e6, inclination=0.9, node=0.4, j2=J2, turns=1.0)
    turned = fmb.Orbit(
        TILT.apply(orbit.place), TILT.apply(orbit.velocity), j2=J2, turns=1.0, axis=TILT.apply((0, 0, 2))
    )
    np.testing.assert_allclose(turned.at(3000.0)[0], TILT.apply(orbit.at(3000.0)[0]), atol=1e-6)


def test_node_of_the_orbit_turns():
    """dO/dt = -3/2 n J2 (R / a)^2 cos i, first order in J2, over ten turns from node to node."""
    a, i = 7.2e6, 0.9
    orbit = fmb.Orbit.circular(a, inclination=i, node=0.3, j2=J2)
    t = orbit.period * np.arange(11)
    h = np.cross(*orbit.at(t))
    node = np.unwrap(np.arctan2(h[:, 0], -h[:, 1]))
    rate = -1.5 * 2 * np.pi / orbit.period * J2 * (RADIUS / a) ** 2 * np.cos(i)
    np.testing.assert_allclose(node - 0.3, rate * t, atol=5e-3 * abs(rate * t[-1]))


@pytest.mark.parametrize("size", [1e-3, 1.8, 4e3, 3e6])
def test_difference_of_flattenings_has_all_digits(size):
    """Against the plain difference in numbers of 50 digits."""
    rho, d = np.array((4.0e6, -5.0e6, 2.6e6)), size * np.array((0.3, 0.8, -0.5))
    k = np.array((0.6, 0.0, 0.8))
    found = np.empty(3)
    falling_oblate(rho, d, k, 3.0, found)
    getcontext().prec = 50
    a, b, axis = ([Decimal(float(x)) for x in v] for v in (rho, d, k))

    def pull(r):
        far, z = sum(x * x for x in r).sqrt(), sum(x * y for x, y in zip(r, axis, strict=True))
        return [-3 * ((6 * z * n + 3 * x) / far**5 - 15 * z * z * x / far**7) for x, n in zip(r, axis, strict=True)]

    both = pull([x + y for x, y in zip(a, b, strict=True)]), pull(a)
    expected = [float(x - y) for x, y in zip(*both, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14 * np.linalg.norm(expected))


def craft(orbit, **fields) -> fmb.Model:
    """Two points on a spring of 1.8 m, with J2."""
    starts = (("a", 120.0, (0, 0, 0), (0, 0, 0)), ("b", 40.0, (1.2, 1.2, 0.6), (-0.02, 0.02, 0.0)))
    bodies = [fmb.PointMass(k, mass=m, at=r, velocity=v) for k, m, r, v in starts]
    spring = fmb.SpringDamper("s", markers=("a.center", "b.center"), stiffness=5.0, length=1.7)
    flat = [fmb.OblateGravity(f"j{k}", body=k) for k in "ab"]
    return fmb.Model(
        bodies=[fmb.Ground(), *bodies],
        forces=[*(fmb.CentralGravity(f"g{k}", body=k) for k in "ab"), *flat, spring],
        sensors=[
            *(fmb.Position(k, marker=f"{k}.center") for k in "ab"),
            fmb.OrbitalPosition("far", marker="a.center"),
            fmb.Energy("energy"),
            fmb.Energy("work", kind="work_of_loads"),
        ],
        **{"origin": orbit, **fields},
    )


def test_relative_places_keep_their_digits():
    """Part of a turn by scipy, origin and both points together; differences of attractions in extended precision."""
    orbit = fmb.Orbit.circular(6.9e6, inclination=0.5, j2=J2, turns=1.5)
    run = fmb.simulate(craft(orbit), 200.0, samples=5)
    masses = np.array((120.0, 40.0))

    def rate(t, y):
        rho, r = np.asarray(y[:3], np.longdouble), y[6:12].reshape(2, 3)
        at = attraction(rho, np.longdouble)
        pull = np.array([np.asarray(attraction(rho + x, np.longdouble) - at, float) for x in r])
        d = r[1] - r[0]
        tension = 5.0 * (np.linalg.norm(d) - 1.7) * d / np.linalg.norm(d)
        pull += np.outer(1 / masses * (1, -1), tension)
        return np.concatenate([y[3:6], np.asarray(at, float), y[12:], pull.ravel()])

    y0 = np.concatenate([orbit.place, orbit.velocity, (0, 0, 0, 1.2, 1.2, 0.6, 0, 0, 0, -0.02, 0.02, 0.0)])
    scale = np.repeat((1e-7, 1e-10, 1e-12), (3, 3, 12))
    own = solve_ivp(rate, (0, 200), y0, method="DOP853", t_eval=run.t, rtol=1e-12, atol=scale).y
    np.testing.assert_allclose(run["b"] - run["a"], (own[9:12] - own[6:9]).T, atol=1e-9)
    np.testing.assert_allclose(run["a"], own[6:9].T, atol=1e-8)
    np.testing.assert_allclose(run["far"], (own[:3] + own[6:9]).T, atol=1e-3)
    balance = run["energy"] - run["energy"][0] - run["work"]
    np.testing.assert_allclose(balance, 0.0, atol=1e-9)


def test_what_falls_otherwise_is_named():
    orbit = fmb.Orbit.circular(7e6, j2=J2, turns=2.0)
    model = craft(orbit)
    for change, match in (
        ({"forces": [f for f in model.forces if f.name != "jb"]}, r"Body 'b'.*no flattening.*OblateGravity\('J2 on b'"),
        ({"forces": [*model.forces, fmb.OblateGravity("more", body="b")]}, r"'more'.*attracted by Force 'jb' already"),
        (
            {"forces": [f.replaced(j2=2e-3) if f.name == "jb" else f for f in model.forces]},
            r"'jb'.*0\.002.*one flattened centre",
        ),
        ({"origin": fmb.Orbit.circular(7e6, j2=J2, axis=(0, 1, 0))}, r"one flattened centre for all"),
    ):
        fields = {name: getattr(model, name) for name in ("bodies", "forces", "sensors", "origin")}
        with pytest.raises(ModelError, match=match):
            fmb.Model(**{**fields, **change})
    with pytest.raises(ModelError, match=r"computed until 11657.*turns=3\.4"):
        fmb.simulate(model, 2e4)
    with pytest.raises(ModelError, match="computed until"):
        orbit.at(2e4)
    with fmb.stepper(model) as run, pytest.raises(ModelError, match="computed until"):
        run.advance(to=2e4)
    with pytest.raises(ModelError, match=r"t = -5 s.*from t = 0 on"):
        orbit.at((-5.0, 5.0))
    with pytest.raises(ModelError, match=r"t = -5 s.*from t = 0 on"):
        fmb.simulate(model, 1.0, t_start=-5.0)
    for fields, match in (
        ({"j2": -1.0}, "j2 = -1"),
        ({"turns": 0.0}, "turns = 0"),
        ({"j2": J2, "turns": 1e7}, r"a table of 2\.4e\+09 rows.*a turn of this orbit takes 240.*turns=8250"),
        ({"axis": (0, 0, 0)}, "an axis"),
    ):
        with pytest.raises(ModelError, match=match):
            fmb.Orbit.circular(7e6, **fields)


FIELDS = {
    "oblate": fmb.OblateGravity("g", body="b", mu=40.0, radius=30.0, j2=0.3, source="ground.o"),
    "third": fmb.ThirdBody("g", body="b", mu=5e4, at=(-70.0, 20.0, 50.0)),
}


def field(name, x):
    """Potential of a unit mass at x (n, 3), by hand."""
    if name == "third":
        s = np.array((-70.0, 20.0, 50.0))
        return -5e4 / np.linalg.norm(x - s, axis=-1) + 5e4 * x @ s / np.linalg.norm(s) ** 3
    r = x - np.array((2.0, -3.0, 1.0))
    far, z = np.linalg.norm(r, axis=-1), r @ TILT.apply((0, 0, 1))
    return 0.5 * 40.0 * 0.3 * 900.0 * (3.0 * z * z - far**2) / far**5


def floating(name, data) -> fmb.Model:
    body = fmb.FloatingBody(
        "b", data=data, at=(60.0, 80.0, -40.0), rotation=(0.4, -0.7, 0.9), geometric_stiffness=False
    )
    ground = fmb.Ground(markers={"o": fmb.Pose((2.0, -3.0, 1.0), TILT)})
    return fmb.Model(bodies=[ground, body], forces=[FIELDS[name]])


@pytest.mark.parametrize("name", FIELDS)
def test_field_over_an_elastic_body_is_the_sum_over_its_points(points, name):
    """Minus the derivatives of the potential of seven points by all coordinates; what is left is of third order."""
    data, masses = points
    errors = []
    for far in (2.0, 4.0):
        model = floating(name, data)
        system, state = random_state(model, np.random.default_rng(3), strain=0.05)
        state.q[:3] = far * np.array((60.0, 80.0, -40.0))
        bare = compile_model(fmb.Model(bodies=model.bodies))
        found = -residual(system, state) + residual(bare, state)

        def energy(h, d, system=system, state=state):
            q, R = moved(system, state, d, h).q, np.empty((3, 3))
            euler_to_matrix(q[3:7], R)
            return np.sum(masses * field(name, q[:3] + (data.nodes + data.shapes @ q[7:]) @ R.T))

        own = np.array([-derivative(lambda h, d=d: energy(h, d), 3e-2) for d in np.eye(system.nu)])
        size = np.array([np.abs(own[span]).max() for span in (slice(3), slice(3, 6), slice(6, None))])
        errors.append(np.abs(found - own) / np.repeat(size, (3, 3, system.nu - 6)))
    assert errors[0][:3].max() < 1e-4
    assert errors[0].max() < 0.1
    assert np.linalg.norm(errors[1]) < 0.7 * np.linalg.norm(errors[0])


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize("follows", [False, True])
def test_tangent_over_an_elastic_body(points, name, follows, rng):
    body = fmb.FloatingBody("b", data=points[0], at=(3.0, 4.0, 1.0), geometric_stiffness=False)
    ground = fmb.Ground(markers={"o": fmb.Pose((0, 0, 0), TILT)})
    forces, orbit = [FIELDS[name].replaced(**({"radius": 0.9} if name == "oblate" else {}))], None
    if follows:
        flat = {"j2": 0.3, "radius": 0.9, "axis": TILT.apply((0, 0, 1))} if name == "oblate" else {}
        orbit = fmb.Orbit((8.0, 3.0, -5.0), (0.3, 1.0, 1.0), 40.0, **flat)
        forces.append(fmb.CentralGravity("c", body="b", mu=40.0))
    model = fmb.Model(bodies=[ground, body], forces=forces, origin=orbit)
    system, state = random_state(model, rng)
    assert_tangent(system, state._replace(u=np.zeros(system.nu)), blocks=("M", "K"))


def test_flattening_turns_what_has_a_size():
    """Force and torque on six points, 60 of their distances away."""
    arms = np.array([(0.9, 0, 0), (-0.9, 0, 0), (0, 0.5, 0), (0, -0.5, 0), (0, 0, 0.3), (0, 0, -0.3)])
    m, R, at = 0.4, Rotation.from_rotvec((0.4, -0.7, 0.9)), np.array((30.0, 40.0, -20.0))
    J = m * np.sum([a @ a * np.eye(3) - np.outer(a, a) for a in arms], axis=0)
    body = fmb.RigidBody("b", mass=6 * m, inertia=J, at=at, rotation=R)
    ground = fmb.Ground(markers={"o": fmb.Pose((2.0, -3.0, 1.0), TILT)})
    sensor = fmb.ForceOf("f", force="g")
    model = fmb.Model(bodies=[ground, body], forces=[FIELDS["oblate"]], sensors=[sensor])
    found = fmb.simulate(model, 1e-6, samples=2)["f"][0]
    places = at + R.apply(arms)
    pulls = -m * np.array(
        [[derivative(lambda h, x=x, e=e: field("oblate", x + h * e), 0.05) for e in np.eye(3)] for x in places]
    )
    force, torque = pulls.sum(axis=0), np.cross(places - at, pulls).sum(axis=0)
    np.testing.assert_allclose(found[:3], force, atol=1e-5 * np.linalg.norm(force))
    np.testing.assert_allclose(found[3:], torque, atol=5e-3 * np.linalg.norm(torque))
