"""Heaps of many contacts, in which sweeps over the contacts pass loads on slowly."""

import warnings

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.nonsmooth import restitution, solve
from flexmb.integrate.nonsmooth.accelerated import accelerate
from flexmb.integrate.nonsmooth.hastened import hasten
from flexmb.integrate.nonsmooth.problem import residuals

RADIUS = 0.05


def pyramid(layers: int, friction: float) -> fmb.Model:
    """Return balls of 1 kg in square layers on a floor, each above a hollow of four, all neighbours touching."""
    at = [
        (RADIUS * (2 * i - m + 1), RADIUS * (2 * j - m + 1), RADIUS + RADIUS * 2**0.5 * k)
        for k, m in enumerate(range(layers, 0, -1))
        for i in range(m)
        for j in range(m)
    ]
    names = tuple(f"b{k}" for k in range(len(at)))
    inertia = (0.4 * RADIUS**2,) * 3
    law = fmb.Rigid(friction=friction)
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(),
            *(fmb.RigidBody(n, mass=1.0, inertia=inertia, at=p) for n, p in zip(names, at, strict=True)),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            *(fmb.Surface(n, marker=f"{n}.center", shape=fmb.Sphere(RADIUS)) for n in names),
        ],
        forces=[
            fmb.SurfaceContact("floor", surfaces=(names, "floor"), law=law),
            fmb.SurfaceContact("heap", surfaces=(names, names), law=law),
        ],
        sensors=[fmb.ForceOf("weight", force="floor")],
    )


def places(solution, state) -> np.ndarray:
    """Return the places of all balls (n, 3)."""
    return np.array([state.q[iq][:3] for iq, _ in solution.phases[0].system.body_slices.values() if iq.stop > iq.start])


def assert_stands(layers: int, t_end: float, step: float) -> fmb.Solution:
    """The floor carries the weight, and no ball moves further than the tolerance allows."""
    count = layers * (layers + 1) * (2 * layers + 1) // 6
    method = fmb.MoreauJean(step=step, tolerance=1e-6)
    solution = fmb.simulate(pyramid(layers, 1.0), t_end, integrator=method, samples=3)
    assert solution.status.kind == "finished"
    np.testing.assert_allclose(np.asarray(solution["weight"])[1:, 2], -9.81 * count, rtol=1e-5)
    moved = np.abs(places(solution, solution.final) - places(solution, solution.state(0.0))).max()
    assert moved < 10.0 * 1e-6 * 9.81 * step * t_end
    return solution


def test_a_pyramid_stands():
    """91 balls with 396 contacts: by sweeps and by Newton's method alone it took minutes, and did not always end."""
    solution = assert_stands(6, 0.02, 5e-3)
    assert solution.statistics["sweeps"] < 1500


@pytest.mark.slow
def test_a_pyramid_of_a_thousand_balls_stands_for_seconds():
    """1015 balls with 5292 contacts."""
    assert_stands(14, 10.0, 5e-3)


@pytest.mark.parametrize("way", [accelerate, hasten])
def test_drilling_and_rolling_are_known(way, monkeypatch):
    """Balls that rain, spinning, on each other, by gradients and by sweeps with momentum: all laws hold at their end,
    rolling among them."""
    rng, missed = np.random.default_rng(1), []

    def improved(p, parts, v, goal, most):
        out = np.zeros(len(p.points))
        steps = way(p, parts, v, goal, most)
        missed.append(residuals(p, v, out)[0] / goal)
        return steps

    monkeypatch.setattr(solve, "hasten", improved)
    monkeypatch.setattr(solve, "MANY", 60)
    names = tuple(f"b{k}" for k in range(40))
    bodies = [
        fmb.RigidBody(
            name,
            mass=1.0,
            inertia=(0.004,) * 3,
            at=(
                0.24 * (k % 4) + 0.01 * rng.normal(),
                0.24 * (k // 4 % 4) + 0.01 * rng.normal(),
                0.11 + 0.21 * (k // 16),
            ),
            velocity=tuple(0.5 * rng.normal(size=3)),
            angular_velocity=tuple(5.0 * rng.normal(size=3)),
        )
        for k, name in enumerate(names)
    ]
    surfaces = [fmb.Surface(name, marker=f"{name}.center", shape=fmb.Sphere(0.1)) for name in names]
    floor = fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane())
    law = fmb.Rigid(friction=0.5, rolling=5e-3, drilling=5e-3)
    heap = fmb.SurfaceContact("heap", surfaces=(("floor", *names), names), law=law)
    model = fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), *bodies], surfaces=[floor, *surfaces], forces=[heap])
    fmb.simulate(model, 0.15, samples=3, integrator=fmb.MoreauJean(step=2e-3))
    assert sum(left <= 1.0 for left in missed) >= 0.5 * len(missed) > 0.0


def settling(side: int) -> fmb.Model:
    """Return side^3 balls that fall a little into a box, slightly out of their grid."""
    spacing = 2.1 * RADIUS
    grid = spacing * (np.arange(side) - 0.5 * (side - 1))
    x, y, z = np.meshgrid(grid, grid, spacing * (0.5 + np.arange(side)) + 0.2 * RADIUS, indexing="ij")
    at = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    at += np.random.default_rng(1).uniform(-0.04 * RADIUS, 0.04 * RADIUS, at.shape)
    half = 0.5 * spacing * side + 0.2 * RADIUS
    walls = {
        f"wall {k}": fmb.Pose.axes(tuple(-half * np.array(n, float)), z=n, x=(n[1], n[0], 0))
        for k, n in enumerate([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
    }
    names = tuple(f"b{k}" for k in range(side**3))
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers=walls),
            *(
                fmb.RigidBody(n, mass=1.0, inertia=(0.4 * RADIUS**2,) * 3, at=tuple(p))
                for n, p in zip(names, at, strict=True)
            ),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            *(fmb.Surface(w, marker=f"ground.{w}", shape=fmb.Plane()) for w in walls),
            *(fmb.Surface(n, marker=f"{n}.center", shape=fmb.Sphere(RADIUS)) for n in names),
        ],
        forces=[fmb.SurfaceContact("heap", surfaces=(("floor", *walls, *names), names), law=fmb.Rigid(friction=0.3))],
    )


def test_sweeps_with_momentum_are_fewer(monkeypatch):
    """The same contacts to the same residual, from the same start: a third of the steps of gradients, at most."""
    taken, steps = [], []

    def compared(p, parts, v, goal, most):
        out, P, start = np.zeros(len(p.points)), p.P.copy(), v.copy()
        steps.append(accelerate(p, parts, v, goal, 3000))
        assert residuals(p, v, out)[0] <= goal
        p.P[:], v[:] = P, start
        taken.append(hasten(p, parts, v, goal, most))
        assert residuals(p, v, out)[0] <= goal
        return taken[-1]

    monkeypatch.setattr(solve, "hasten", compared)
    method = fmb.MoreauJean(step=2e-3, tolerance=1e-2)
    with warnings.catch_warnings():  # of the energy that so loose a tolerance adds
        warnings.simplefilter("ignore", fmb.ValidityWarning)
        solution = fmb.simulate(settling(6), 0.2, integrator=method, samples=3)
    assert solution.statistics["most contacts"] > 300
    assert len(taken) > 20
    assert sum(taken) < sum(steps) / 3.0


def test_joined_bodies_that_touch():
    """Twelve chains of ten balls, joined where neighbours touch, carry 99 balls.

    No impulse moves joined balls apart there: their mobility is rounding, by which nothing is to be divided.
    """
    weight, layer = {}, {}
    for j in range(12):
        for k in range(10):
            weight[f"c{j} {k}"] = 1.0, (2 * RADIUS * k, 2 * RADIUS * j, RADIUS)
            if j < 11 and k < 9:
                layer[f"t{j} {k}"] = 3.0, (RADIUS * (2 * k + 1), RADIUS * (2 * j + 1), RADIUS * (1 + 2**0.5))
    balls = weight | layer
    bodies = [
        fmb.RigidBody(
            n, mass=m, inertia=(1e-3 * m,) * 3, at=p, markers={"end": (RADIUS, 0, 0), "start": (-RADIUS, 0, 0)}
        )
        for n, (m, p) in balls.items()
    ]
    joints = [
        fmb.Spherical(f"j{j} {k}", markers=(f"c{j} {k}.end", f"c{j} {k + 1}.start"))
        for j in range(12)
        for k in range(9)
    ]
    surfaces = [fmb.Surface(n, marker=f"{n}.center", shape=fmb.Sphere(RADIUS)) for n in balls]
    floor = fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane())
    heap = fmb.SurfaceContact("heap", surfaces=(("floor", *balls), tuple(balls)), law=fmb.Rigid(friction=0.8))
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), *bodies],
        surfaces=[floor, *surfaces],
        joints=joints,
        forces=[heap],
    )
    solution = fmb.simulate(model, 0.02, samples=2, integrator=fmb.MoreauJean(step=2e-3, tolerance=1e-6))
    moved = np.abs(places(solution, solution.final) - places(solution, solution.state(0.0))).max()
    assert moved < 10.0 * 1e-6 * 9.81 * 2e-3 * 0.02


def test_the_best_impulses_are_told_where_none_will_do(monkeypatch):
    """Balls that cannot stand slip at many contacts at once: what is told to be left is the least that was found."""
    found, told = [], []
    looked, solved = solve.residuals, restitution.solve_contacts

    def look(p, v, out):
        residual, worst = looked(p, v, out)
        found.append(residual)
        return residual, worst

    def solution(p, parts, v, goal, most, **ways):
        found.clear()
        way = solved(p, parts, v, goal, most, **ways)
        left, worst = looked(p, v, np.zeros(len(p.points)))
        told.append((way.residual, min(found), left, way.worst == worst, goal))
        return way

    monkeypatch.setattr(solve, "residuals", look)
    monkeypatch.setattr(restitution, "solve_contacts", solution)
    method = fmb.MoreauJean(step=5e-3, tolerance=1e-6, sweeps=1500)
    with pytest.raises(fmb.IntegrationError, match=r"'heap': the laws of contact .* are missed by .* m/s after"):
        fmb.simulate(pyramid(5, 0.5), 0.02, samples=2, integrator=method)
    residual, least, left, same, goal = told[-1]
    assert residual == least > goal
    assert left == pytest.approx(residual, rel=1e-6)
    assert same
