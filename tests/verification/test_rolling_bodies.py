"""Discs, tops and balls on a floor, and impacts in a row: rigid contact against motions known in closed form.

Sources: Moffatt 2000, Nature 404 (spinning disc); Jellett 1872 (integral of tops on a point with friction).
"""

import numpy as np
import pytest

import flexmb as fmb

G = 9.81
FLOOR = fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane())


def on_floor(body, shape, mu, marker="center"):
    return fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(), body],
        surfaces=[FLOOR, fmb.Surface("skin", marker=f"body.{marker}", shape=shape)],
        forces=[fmb.SurfaceContact("touch", surfaces=("floor", "skin"), law=fmb.Rigid(friction=mu))],
        sensors=[
            fmb.Position("p", marker="body.center"),
            fmb.Position("c", marker=f"body.{marker}"),
            fmb.Velocity("v", marker="body.center"),
            fmb.AngularVelocity("w", marker="body.center"),
        ],
    )


def run(model, t_end, step, samples):
    return fmb.simulate(model, t_end, integrator=fmb.MoreauJean(step=step), samples=samples)


def roller(rotation, velocity):
    """A solid cylinder of 1 kg, radius and half length 0.1 m."""
    across = (3 * 0.1**2 + 0.2**2) / 12.0
    return fmb.RigidBody(
        "body", mass=1.0, inertia=(across, across, 0.005), at=(0, 0, 0.1), rotation=rotation, velocity=velocity
    )


def test_a_cylinder_stands():
    found = run(on_floor(roller(np.eye(3), (0, 0, 0)), fmb.Cylinder(radius=0.1, length=0.2), 0.3), 1.0, 5e-3, 3)
    assert np.abs(found["p"] - found["p"][0]).max() < 1e-10


def test_a_cylinder_slides_and_rolls():
    """v = 2/3 v0 when it rolls, from t = v0 / (3 mu g) on."""
    lying = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    found = run(on_floor(roller(lying, (1, 0, 0)), fmb.Cylinder(radius=0.1, length=0.2), 0.3), 1.0, 5e-3, 41)
    sliding = found.t < 1.0 / (3.0 * 0.3 * G) - 0.01
    assert found["v"][sliding, 0] == pytest.approx(1.0 - 0.3 * G * found.t[sliding], abs=1e-9)
    assert found["v"][-1] == pytest.approx((2.0 / 3.0, 0, 0), abs=1e-9)


@pytest.mark.slow
def test_a_disc_spins_on_its_edge():
    """Its centre rests, and the contact goes round with W^2 = 4 g / (a sin(alpha)): a steady motion without losses.

    The method is of first order there: height and turns are off by half as much with half the step.
    """
    a, thick, lean = 0.1, 2e-4, np.deg2rad(20.0)
    turns = np.sqrt(4.0 * G / (a * np.sin(lean)))
    up, normal = np.array([np.cos(lean), 0, np.sin(lean)]), np.array([-np.sin(lean), 0, np.cos(lean)])
    body = fmb.RigidBody(
        "body",
        mass=1.0,
        inertia=(0.25 * a**2, 0.25 * a**2, 0.5 * a**2),
        at=(0, 0, a * np.sin(lean) + 0.5 * thick * np.cos(lean)),
        rotation=np.column_stack([up, np.cross(normal, up), normal]),
        angular_velocity=tuple(turns * np.sin(lean) * up),
    )
    model = on_floor(body, fmb.Cylinder(radius=a, length=thick), 0.8)
    off = []
    for step in (4e-4, 2e-4):
        found = run(model, 0.5, step, 101)
        w = found["w"]
        angle = np.unwrap(np.arctan2(w[:, 1], w[:, 0]))[-1]
        off.append((1.0 - found["p"][-1, 2] / found["p"][0, 2], angle / (turns * 0.5) - 1.0))
        assert np.abs(found["p"][:, :2]).max() < 2.5 * step
    assert off[1][0] == pytest.approx(0.5 * off[0][0], rel=0.1)
    assert abs(off[1][0]) < 0.03
    assert abs(off[1][1]) < 0.01


def test_a_tippe_top_keeps_jelletts_integral():
    """Whatever friction does, L . r stays: angular momentum, and the way from the contact to the centre of mass."""
    radius, off, inertia = 0.03, 0.004, np.array([3.6e-6, 3.6e-6, 3.0e-6])
    c, s = np.cos(0.2), np.sin(0.2)
    tilted = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    body = fmb.RigidBody(
        "body",
        mass=0.01,
        inertia=tuple(inertia),
        at=tuple(np.array([0, 0, radius]) - off * tilted[:, 2]),
        rotation=tilted,
        angular_velocity=(0, 0, 150.0),
        markers={"ball": (0, 0, off)},
    )
    found = run(on_floor(body, fmb.Sphere(radius), 0.3, "ball"), 0.6, 2e-4, 61)
    axis, w = (found["c"] - found["p"]) / off, found["w"]
    momentum = inertia[0] * w + (inertia[2] - inertia[0]) * np.sum(w * axis, axis=1)[:, None] * axis
    lever = found["p"] - found["c"] * (1.0, 1.0, 0.0)
    jellett = np.sum(momentum * lever, axis=1)
    assert np.ptp(jellett) < 3e-4 * abs(jellett[0])
    assert axis[-1, 2] < axis[0, 2] - 0.2  # it has begun to turn over


def test_a_cradle_of_different_masses():
    """Five balls apart by 1 mm: impacts two by two in the order of time, momentum and energy by hand."""
    masses, gap, t_end = np.array([1.0, 0.5, 2.0, 1.0, 4.0]), 1e-3, 0.05
    x, v, t = np.arange(5) * (0.1 + gap), np.array([1.0, 0, 0, 0, 0]), 0.0
    start = x.copy()
    while True:
        nearing, apart = v[:-1] - v[1:], np.maximum(x[1:] - x[:-1] - 0.1, 0.0)
        # two that have just met part, whatever rounding leaves between them
        times = np.where(nearing > 1e-9, apart / np.maximum(nearing, 1e-9), np.inf)
        k = int(np.argmin(times))
        if t + times[k] > t_end:
            break
        x, t = x + v * times[k], t + times[k]
        mean = masses[k : k + 2] @ v[k : k + 2] / masses[k : k + 2].sum()
        v[k : k + 2] = 2.0 * mean - v[k : k + 2]
    names = tuple(f"ball {k}" for k in range(5))
    bodies = [
        fmb.RigidBody(n, mass=m, inertia=(1e-3,) * 3, at=(p, 0, 0), velocity=(1.0 if n == "ball 0" else 0.0, 0, 0))
        for n, m, p in zip(names, masses, start, strict=True)
    ]
    model = fmb.Model(
        bodies=bodies,
        surfaces=[fmb.Surface(n, marker=f"{n}.center", shape=fmb.Sphere(0.05)) for n in names],
        forces=[fmb.SurfaceContact("touch", surfaces=(names, names), law=fmb.Rigid(restitution=1.0))],
        sensors=[fmb.Velocity(n, marker=f"{n}.center") for n in names],
    )
    found = run(model, t_end, 5e-5, 3)
    assert [found[n][-1, 0] for n in names] == pytest.approx(v, abs=1e-7)
    assert found.statistics["largest residual of contacts [m/s]"] < 1e-7


def test_a_box_on_a_belt_that_is_free():
    """It takes mu g from the belt of five times its mass, and both end with the momentum that the belt had."""
    along = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 0, 1))
    belt = fmb.RigidBody("belt", mass=5.0, inertia=(1, 1, 1), velocity=(1.0, 0, 0), markers={"x": along})
    box = fmb.RigidBody("box", mass=1.0, inertia=(1 / 150,) * 3, at=(0, 0, 0.1))
    model = fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(markers={"x": along}), belt, box],
        joints=[fmb.Prismatic("slide", markers=("ground.x", "belt.x"))],
        surfaces=[
            fmb.Surface("belt", marker="belt.center", shape=fmb.Plane()),
            fmb.Surface("box", marker="box.center", shape=fmb.Cuboid(size=(0.2,) * 3)),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=("belt", "box"), law=fmb.Rigid(friction=0.2))],
        sensors=[fmb.Velocity(n, marker=f"{n}.center") for n in ("belt", "box")],
    )
    found = run(model, 1.0, 2e-3, 11)
    assert found["box"][3, 0] == pytest.approx(0.2 * G * 0.3, rel=1e-9)
    assert found["box"][-1, 0] == pytest.approx(5.0 / 6.0, rel=1e-9)
    assert found["belt"][-1, 0] == pytest.approx(5.0 / 6.0, rel=1e-9)
