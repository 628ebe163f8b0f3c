"""An origin that falls along an orbit, and the attraction of elastic bodies.

References: scipy's integration about the centre in extended precision, sums over point masses, Hughes 1986 (libration).
"""

import warnings
from dataclasses import replace
from decimal import Decimal, getcontext

import numpy as np
import pytest
from contracts.random_models import derivative, moved, random_state
from contracts.test_tangents import assert_tangent
from scipy.integrate import solve_ivp

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import ModelError
from flexmb.forces.attraction import falling
from flexmb.math.rotations import euler_to_matrix
from flexmb.model.modal_arrays import GeometricStiffness
from flexmb.system import compile as compile_model
from flexmb.system.program import evaluate

MU, R0 = 3.986004418e14, 6.9e6


@pytest.mark.parametrize("speed", [0.85, 1.0, 1.25])
def test_orbit_is_an_ellipse(speed):
    """Pericentre, circle and apocentre at the start, over a turn and a half, by scipy."""
    place = np.array((4.0e6, -5.0e6, 2.6e6))
    far = np.linalg.norm(place)
    across = np.cross((0.3, 0.5, 1.0), place)
    velocity = speed * np.sqrt(MU / far) * (across / np.linalg.norm(across)) + (0.0 if speed == 1.0 else 1e-4) * place
    orbit = fmb.Orbit(place, velocity)
    t = np.linspace(0.0, 1.5 * orbit.period, 7)
    own = solve_ivp(
        lambda _, y: np.concatenate([y[3:], -MU * y[:3] / np.linalg.norm(y[:3]) ** 3]),
        (0, t[-1]),
        np.concatenate([place, velocity]),
        method="DOP853",
        t_eval=t,
        rtol=1e-13,
        atol=1e-9,
    ).y
    r, v = orbit.at(t)
    np.testing.assert_allclose(r, own[:3].T, atol=1e-3)
    np.testing.assert_allclose(v, own[3:].T, atol=1e-6)


def test_circle_by_its_angles():
    orbit = fmb.Orbit.circular(7e6, inclination=0.9, node=0.4, argument=0.3)
    normal = np.cross(orbit.place, orbit.velocity)
    assert np.arccos(normal[2] / np.linalg.norm(normal)) == pytest.approx(0.9)
    assert np.arctan2(normal[0], -normal[1]) == pytest.approx(0.4)
    assert orbit.place[2] == pytest.approx(7e6 * np.sin(0.9) * np.sin(0.3))
    assert orbit.period == pytest.approx(2 * np.pi * np.sqrt(7e6**3 / MU))


@pytest.mark.parametrize("size", [1e-3, 1.8, 4e3, 3e6])
def test_difference_of_attractions_has_all_digits(size):
    """Against the plain difference in numbers of 50 digits."""
    rho, d = np.array((4.0e6, -5.0e6, 2.6e6)), size * np.array((0.3, 0.8, -0.5))
    found = np.empty(3)
    falling(rho, d, MU, found)
    getcontext().prec = 50
    a, b = [Decimal(float(x)) for x in rho], [Decimal(float(x)) for x in d]
    r = [x + y for x, y in zip(a, b, strict=True)]
    far, near = (sum(x * x for x in p).sqrt() ** 3 for p in (r, a))
    expected = [float(Decimal(MU) * (x / near - y / far)) for x, y in zip(a, r, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=3e-15 * np.linalg.norm(expected))


def cluster():
    """Seven points with springs between all of them, reduced: the mass matrix is that of points."""
    rng = np.random.default_rng(7)
    nodes, masses = rng.normal(size=(7, 3)), rng.uniform(0.5, 2.0, size=7)
    K = np.zeros((21, 21))
    for i in range(7):
        for j in range(i):
            e = (nodes[i] - nodes[j]) / np.linalg.norm(nodes[i] - nodes[j])
            block = 50.0 * np.outer(e, e)
            for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                K[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += sign * block
    dofs = [(k, axis) for k in range(7) for axis in range(3)]
    fe = fem.from_matrices(K, np.diag(np.repeat(masses, 3)), nodes, dofs)
    return reduction.reduce(fe, interfaces={"a": [0, 1, 2]}, modes=3), masses


@pytest.fixture(scope="module")
def points():
    return cluster()


def elastic(data, origin=None, **fields) -> fmb.Model:
    values = {"at": (60.0, 80.0, -40.0), "rotation": (0.4, -0.7, 0.9), "geometric_stiffness": False}
    body = fmb.FloatingBody("b", data=data, **{**values, **fields})
    mu = 5e4 if origin is None else origin.mu
    return fmb.Model(bodies=[fmb.Ground(), body], forces=[fmb.CentralGravity("g", body="b", mu=mu)], origin=origin)


def test_attraction_of_an_elastic_body_is_the_sum_over_its_points(points):
    """Minus the derivatives of -sum mu m / r by all coordinates; what is left is of third order in size / distance."""
    data, masses = points
    errors = []
    for far in (1.0, 2.0):
        model = elastic(data)
        system, state = random_state(model, np.random.default_rng(3), strain=0.05)
        state.q[:3] = far * np.array((60.0, 80.0, -40.0))
        found = [-residual(x, state) for x in (system, compile_model(fmb.Model(bodies=model.bodies)))]

        def energy(h, d, system=system, state=state):
            q, R = moved(system, state, d, h).q, np.empty((3, 3))
            euler_to_matrix(q[3:7], R)
            places = q[:3] + (data.nodes + data.shapes @ q[7:]) @ R.T
            return -5e4 * np.sum(masses / np.linalg.norm(places, axis=1))

        own = np.array([-derivative(lambda h, d=d: energy(h, d), 1e-2) for d in np.eye(system.nu)])
        size = np.array([np.abs(own[span]).max() for span in (slice(3), slice(3, 6), slice(6, None))])
        errors.append(np.abs(found[0] - found[1] - own) / np.repeat(size, (3, 3, system.nu - 6)))
    # the field has second order: of the force a part (size / distance)^3 is left, of torque and modal forces the first
    assert errors[0][:3].max() < 2e-5
    assert errors[0][3:].max() < 0.1
    assert errors[1][:3].max() < 0.2 * errors[0][:3].max()
    assert errors[1][3:].max() < 0.6 * errors[0][3:].max()


def residual(system, state):
    work = system.workspace()
    work.weights[0].wanted = 0
    evaluate(system.program, state._replace(u=np.zeros(system.nu), a=np.zeros(system.nu)), work)
    return work.residual.copy()


@pytest.mark.parametrize("follows", [False, True])
def test_tangent_of_the_attraction_of_an_elastic_body(points, follows, rng):
    orbit = fmb.Orbit((8.0, 3.0, -5.0), (0.3, 1.0, 2.0), 60.0) if follows else None
    model = elastic(points[0], orbit, at=(3.0, 4.0, 1.0))
    system, state = random_state(model, rng)
    assert_tangent(system, state._replace(u=np.zeros(system.nu)), blocks=("M", "K"))


def test_what_does_not_fall_is_named(points):
    orbit = fmb.Orbit.circular(R0)
    body = fmb.PointMass("b", mass=1.0)
    pull = fmb.CentralGravity("g", body="b")
    assert fmb.Model(bodies=[body, fmb.Ground()], forces=[pull], origin=orbit).origin is orbit
    for given, match in (
        ({"bodies": [fmb.Ground(), body]}, r"Body 'b'.*no attraction.*CentralGravity\('pull on b', body='b'\)"),
        ({"bodies": [fmb.Ground(), body], "forces": [pull], "gravity": (0, 0, -9.81)}, "gravity .* and an origin"),
        (
            {"bodies": [fmb.Ground(), body], "forces": [fmb.CentralGravity("g", body="b", mu=1.0)]},
            r"mu = 1 N m2/kg, and origin falls",
        ),
        (
            {
                "bodies": [fmb.Ground(markers={"o": (1.0, 0, 0)}), body],
                "forces": [fmb.CentralGravity("g", body="b", source="ground.o")],
            },
            "a ground marker at the origin of W",
        ),
    ):
        with pytest.raises(ModelError, match=match):
            fmb.Model(origin=orbit, **given)
    with pytest.raises(ModelError, match="along one line"):
        fmb.Orbit((7e6, 0, 0), (1.0, 0, 0))
    with pytest.raises(ModelError, match="less than the speed of escape"):
        fmb.Orbit((7e6, 0, 0), (0, 2e4, 0))
    with pytest.raises(ModelError, match="mu = -1"):
        fmb.Orbit((7e6, 0, 0), (0, 2e3, 0), -1.0)
    steel, section = fmb.MATERIALS["steel"], fem.Section.solid_circle(0.1)
    cable = fmb.AncfCable("c", points=((0, 0, 0), (1, 0, 0)), elements=1, section=section, material=steel)
    with pytest.raises(ModelError, match=r"AncfCable.*RigidBody or a PointMass or a FloatingBody"):
        fmb.Model(bodies=[fmb.Ground(), cable], forces=[fmb.CentralGravity("g", body="c")])
    stiffened = fmb.FloatingBody("b", data=replace(points[0], geometric=no_stiffness(points[0].n_modes)))
    with pytest.raises(ModelError, match=r"inertia loads stiffen it.*geometric_stiffness="):
        fmb.Model(bodies=[fmb.Ground(), stiffened], forces=[fmb.CentralGravity("g", body="b")])
    falls = fmb.Model(bodies=[body, fmb.Ground()], forces=[pull], origin=orbit)
    with pytest.raises(ModelError, match="places relative to the orbit as they are"):
        falls.placed("p", at=(1, 0, 0))
    other = fmb.Model(bodies=[fmb.PointMass("c", mass=1.0), fmb.Ground()], forces=[fmb.CentralGravity("h", body="c")])
    with pytest.raises(ModelError, match="two origins"):
        falls + replace(other, origin=fmb.Orbit.circular(2 * R0))
    assert (falls + other).origin is orbit


def no_stiffness(m):
    none = {"inertia": np.zeros((12, m, m)), "interface": np.zeros((1, 6, m, m)), "loads": np.zeros((0, m, m))}
    return GeometricStiffness(**none, preload=np.zeros((m, m)))


def pair(orbit, at_earth: bool, **fields) -> fmb.Model:
    """Two points on a spring of 1.8 m."""
    place, velocity = (orbit.place, orbit.velocity) if at_earth else ((0, 0, 0), (0, 0, 0))
    bodies = [
        fmb.PointMass(k, mass=m, at=np.add(place, r), velocity=np.add(velocity, v))
        for k, m, r, v in (("a", 120.0, (0, 0, 0), (0, 0, 0)), ("b", 40.0, (1.2, 1.2, 0.6), (-0.02, 0.02, 0.0)))
    ]
    spring = fmb.SpringDamper("s", markers=("a.center", "b.center"), stiffness=5.0, length=1.7)
    return fmb.Model(
        bodies=[fmb.Ground(), *bodies],
        forces=[*(fmb.CentralGravity(f"g{k}", body=k) for k in "ab"), spring],
        sensors=[fmb.Position(k, marker=f"{k}.center") for k in "ab"],
        origin=None if at_earth else orbit,
        **fields,
    )


def test_default_in_orbit_keeps_relative_places():
    """A quarter of an orbit by scipy, each attraction as the difference to the origin in Encke's form by hand."""
    orbit = fmb.Orbit.circular(R0, inclination=0.5)
    run = fmb.simulate(pair(orbit, False), 1400.0, samples=3)
    assert run.statistics["integrator"].startswith("Explicit(method='DOP853', rtol=1e-11")
    masses = np.array((120.0, 40.0))

    def rate(t, y):
        r, v = y[:6].reshape(2, 3), y[6:].reshape(2, 3)
        rho = orbit.at(t)[0]
        far = np.linalg.norm(rho + r, axis=1)[:, None]
        q = np.sum(r * (r + 2 * rho), axis=1)[:, None] / (rho @ rho)
        pull = -MU / far**3 * (r - q * (3 + 3 * q + q * q) / (1 + (1 + q) ** 1.5) * rho)
        d = r[1] - r[0]
        tension = 5.0 * (np.linalg.norm(d) - 1.7) * d / np.linalg.norm(d)
        return np.concatenate([v.ravel(), (pull + np.outer(1 / masses * (1, -1), tension)).ravel()])

    y0 = np.array((0, 0, 0, 1.2, 1.2, 0.6, 0, 0, 0, -0.02, 0.02, 0.0))
    own = solve_ivp(rate, (0, 1400), y0, method="DOP853", t_eval=run.t, rtol=1e-12, atol=1e-13).y
    np.testing.assert_allclose(run["b"] - run["a"], (own[3:6] - own[:3]).T, atol=1e-8)


def test_coordinates_from_the_centre_are_told():
    """The pair in coordinates of the Earth: relative places have few digits, and the message says how to keep them."""
    orbit = fmb.Orbit.circular(R0)
    with pytest.warns(fmb.ValidityWarning, match=r"relative motion has few digits.*flexmb\.Orbit\(\(6900000\.0, 0"):
        fmb.simulate(pair(orbit, True), 1.0, samples=2)
    alone = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("a", mass=1.0, at=orbit.place, velocity=orbit.velocity)],
        forces=[fmb.CentralGravity("g", body="a")],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fmb.simulate(alone, 1.0, samples=2)


def test_elastic_and_other_models_keep_the_implicit_default(points):
    orbit = fmb.Orbit.circular(500.0, mu=0.05**2 * 500.0**3)
    for model in (elastic(points[0], orbit, at=(0, 0, 0)), fmb.Model(bodies=[fmb.PointMass("a", mass=1.0)])):
        run = fmb.simulate(model, 1e-3, samples=2)
        assert run.statistics["integrator"].startswith("GeneralizedAlpha")


def test_orbit_in_a_model_file():
    orbit = fmb.Orbit((6.9e6, 0.0, 1e5), (0.0, 7.6e3, 10.0))
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("b", mass=1.0)], forces=[fmb.CentralGravity("g", body="b")], origin=orbit
    )
    again = fmb.read_model_text(fmb.model_text(model))
    assert again.origin.fields() == orbit.fields()
    assert fmb.Model(bodies=[fmb.Ground()]).origin is None


def test_a_body_falls_to_one_centre_only():
    """The origin falls once, so a second attraction would be a load that it does not share."""
    pulls = [fmb.CentralGravity(name, body="stone") for name in ("one", "two")]
    stone = fmb.PointMass("stone", mass=1.0)
    with pytest.raises(ModelError, match=r"Force 'two'.*attracted by Force 'one' already"):
        fmb.Model(bodies=[fmb.Ground(), stone], forces=pulls, origin=fmb.Orbit.circular(7e6))
