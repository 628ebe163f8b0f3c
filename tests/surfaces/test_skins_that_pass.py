"""No step passes a contact of two skins unseen: impacts against closed forms, first touches against another library."""

import numpy as np
import pytest
from by_turns import slow
from reduction.solids import block

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.forces.skin_rows import ROW
from flexmb.forces.skin_sweep import sweep_skins
from flexmb.math.switches import COLUMNS
from flexmb.surfaces.skin_faces import packed_faces

L, B, HIGH = 0.4, 0.04, 0.01
LAW = fmb.ElasticFoundation(modulus=1e12, thickness=0.01)
CASES = (
    (10.0, fmb.GeneralizedAlpha(rho_inf=1.0)),
    (10.0, fmb.IDA()),
    (10.0, fmb.Explicit()),
    slow(10.0, fmb.Implicit(rtol=1e-8)),  # with 1e-6 3 % off, and told so
    slow(300.0, fmb.Explicit()),
    (300.0, fmb.MoreauJean(step=1e-4)),
)


@pytest.fixture(scope="module")
def bar():
    """A bar that does not deform: a body with the skin of its solid and no mode."""
    fe = block((L, B, HIGH), (20, 2, 1))
    return reduction.reduce(fe, interfaces={"root": np.flatnonzero(fe.nodes[:, 0] < 1e-9)}, modes=0)


def at_each_other(bar, speed, *, shift=0.0, away=0.05, **skin):
    """Return two bars of one mass, the upper one across the middle of the lower one, that near each other."""
    x = bar.nodes
    near = np.flatnonzero((x[:, 2] < 1e-9) & (np.abs(x[:, 0] - 0.2) < 0.0301))
    lower = fmb.FloatingBody("a", data=bar, skins={"all": fmb.Skin(spacing=0.1, faces=True, **skin)})
    upper = fmb.FloatingBody(
        "b",
        data=bar,
        at=(0.2 + 0.5 * B + shift, 0.5 * B - 0.2, HIGH + away),
        rotation=(0, 0, np.pi / 2),
        velocity=(0, 0, -speed),
        skins={"low": fmb.Skin(spacing=0.01, nodes=near)},
    )
    return fmb.Model(
        gravity=(0, 0, 0),
        bodies=[fmb.Ground(), lower, upper],
        surfaces=[fmb.SkinSurface("low", skin="b.low"), fmb.SkinSurface("all", skin="a.all")],
        forces=[fmb.SkinContact("touch", surfaces=("low", "all"), law=LAW)],
        sensors=[fmb.Velocity("v a", marker="a.root"), fmb.Velocity("v b", marker="b.root")],
    )


@pytest.mark.parametrize(("speed", "integrator"), CASES, ids=lambda i: str(i).partition("(")[0])
def test_bars_of_one_mass_change_their_speeds(bar, speed, integrator):
    """An elastic impact of their centres: the one stops, the other goes on. They are 10 mm thick, 50 mm apart."""
    found = fmb.simulate(at_each_other(bar, speed), 0.08 / speed, samples=2, integrator=integrator)
    assert found["v a"][-1, 2] == pytest.approx(-speed, rel=2e-2)
    assert found["v b"][-1, 2] == pytest.approx(0.0, abs=2e-2 * speed)


@pytest.mark.parametrize("speed", [1.0, 1000.0])
def test_a_bar_beside_another_flies_on(bar, speed):
    """30 mm beyond its end nothing is met, and no step is shortened."""
    found = fmb.simulate(at_each_other(bar, speed, shift=0.25), 0.08 / speed, samples=2, integrator=fmb.Explicit())
    assert found["v b"][-1, 2] == pytest.approx(-speed, rel=1e-12)
    assert found.statistics["steps"] < 10


def test_steps_of_a_given_size_are_divided(bar):
    """One step would end 30 mm below the other bar."""
    model = at_each_other(bar, 10.0)
    with pytest.warns(fmb.ValidityWarning, match="were divided"):
        found = fmb.simulate(model, 8e-3, samples=2, integrator=fmb.GeneralizedAlpha(step=8e-3))
    assert found["v a"][-1, 2] < -1.0


def test_tubes_of_cables_meet():
    """A cable of 4 mm that strikes another one, across it, at 50 m/s: momentum stays, and it does not pass."""
    section, r = fem.Section.solid_circle(4e-3), 2e-3
    soft = fmb.Material(young=1e7, poisson=0.3, density=1000.0)

    def cable(name, start, end, velocity=(0, 0, 0), **skin):
        tube = fmb.Skin(spacing=1e-3, radius=r, between=(0.45, 0.55), **skin)
        return fmb.AncfCable(
            name,
            points=(start, end),
            elements=2,
            section=section,
            material=soft,
            velocity=velocity,
            markers={"mid": 0.5},
            skins={"tube": tube},
        )

    model = fmb.Model(
        gravity=(0, 0, 0),
        bodies=[
            fmb.Ground(),
            cable("a", (-0.1, 0, 0), (0.1, 0, 0), faces=True),
            cable("b", (0, -0.1, 0.1), (0, 0.1, 0.1), velocity=(0, 0, -50.0)),
        ],
        surfaces=[fmb.SkinSurface("b", skin="b.tube"), fmb.SkinSurface("a", skin="a.tube")],
        forces=[fmb.SkinContact("touch", surfaces=("b", "a"), law=fmb.ElasticFoundation(modulus=1e9, thickness=1e-3))],
        sensors=[
            fmb.Momentum("P"),
            fmb.Position("a mid", marker="a.mid"),
            fmb.Position("b mid", marker="b.mid"),
        ],
    )
    found = fmb.simulate(model, 2.5e-3, samples=26)
    above = found["b mid"][:, 2] - found["a mid"][:, 2]
    assert above.min() > 0.9 * r
    assert found["a mid"][-1, 2] < -5e-3
    np.testing.assert_allclose(found["P"][:, 2], found["P"][0, 2], rtol=1e-9)


def moved(rng):
    """Return places (2, 3) of a point and (2, 3, 3) of a triangle at both ends of a step; half of them meet."""
    triangle = np.stack([rng.normal(size=(3, 3))] * 2)
    triangle[1] += 0.1 * rng.normal(size=(3, 3)) + rng.normal(size=3)
    share, s = rng.dirichlet((1.0, 1.0, 1.0)), rng.uniform(0.05, 0.95)
    met = share @ ((1.0 - s) * triangle[0] + s * triangle[1])
    way = 2.0 * rng.normal(size=3)
    point = np.array([met - s * way, met + (1.0 - s) * way])
    if rng.random() < 0.5:
        point += 0.7 * rng.normal(size=3)
    return point, triangle


def swept(row, data, point, triangle, normal):
    """Return the part of a step of 1 s at which a point that looks along `normal` first meets a triangle, else 2.0."""
    rows = np.zeros((2, 2, COLUMNS))
    for k in range(2):
        rows[k, 0, 10:19] = *point[k], *(point[1] - point[0]), *normal
        for c in range(3):
            rows[k, 1, 10 + 6 * c : 16 + 6 * c] = *triangle[k, c], *(triangle[1, c] - triangle[0, c])
    part = np.array([2.0])
    sweep_skins(row[0], data, rows[0], rows[1], 1.0, 0.0, True, part)
    return part[0]


def first_root(point, triangle):
    """Return when a point first meets a triangle by the cubic of their common plane, else 2.0, and from which side."""

    def places(s):
        return (1.0 - s) * point[0] + s * point[1], (1.0 - s) * triangle[0] + s * triangle[1]

    def volume(s):
        z, X = places(s)
        return np.linalg.det(np.array([z - X[0], X[1] - X[0], X[2] - X[0]]))

    thirds = np.linspace(0.0, 1.0, 4)
    roots = np.roots(np.polyfit(thirds, [volume(s) for s in thirds], 3))
    for s in sorted(r.real for r in roots if abs(r.imag) < 1e-9 and 0.0 <= r.real <= 1.0):
        z, X = places(s)
        share = np.linalg.lstsq((X[1:] - X[0]).T, z - X[0], rcond=None)[0]
        if share.min() >= 0.0 and share.sum() <= 1.0:
            return s, volume(s - 1e-6)
    return 2.0, 0.0


@pytest.mark.parametrize("count", [150, pytest.param(10_000, marks=pytest.mark.slow)])
def test_times_of_another_library(rng, count):
    """Points and triangles that move straight, and deform: hits of ipctk, which is early, and the roots of a cubic.

    It is never late; where a point nearly slides along the face it may be early.
    """
    of_points = pytest.importorskip("ipctk").TightInclusionCCD()
    faces, nodes, _ = packed_faces(np.eye(3), np.array([[0, 1, 2]]))
    faces[:, 3:] = 0.0
    data = np.concatenate([faces.ravel(), nodes.ravel()])
    row = np.zeros(1, ROW)
    for name, value in {"count": 1, "n_corners": 3, "nodes": faces.size, "n_nodes": 1, "depth": 1e-6}.items():
        row[name] = value
    late, hits = [], 0
    for _ in range(count):
        point, triangle = moved(rng)
        out = np.cross(triangle[0, 1] - triangle[0, 0], triangle[0, 2] - triangle[0, 0])
        if (point[0] - triangle[0, 0]) @ out < 0.0:
            triangle = triangle[:, [0, 2, 1]]  # it begins outside
        hit, time = of_points.point_triangle_ccd(point[0], *triangle[0], point[1], *triangle[1])
        root, side = first_root(point, triangle)
        assert hit == (root < 2.0)
        if hit and side < 0.0:
            continue  # from behind, after a way around the face
        there = (1.0 - min(root, 1.0)) * triangle[0] + min(root, 1.0) * triangle[1]
        found = swept(row, data, point, triangle, -np.cross(there[1] - there[0], there[2] - there[0]))
        assert (found < 2.0) == hit
        if hit:
            late.append(found - root)
            assert found == pytest.approx(time, abs=0.05)
            hits += 1
    assert hits > 0.3 * count
    assert max(late) < 1e-8
    assert min(late) > -0.05
    assert np.median(np.abs(late)) < 1e-8
