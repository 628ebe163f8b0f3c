"""Several impacts at once, beside every combination of contacts that press, tried one after another."""

from itertools import combinations, pairwise

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb

RADIUS, STEP = 0.05, 1e-4
AHEAD = 9.5e-4
"""s, until what moves strikes: in the middle of a step."""
MASSES = ((1.0, 1.0, 1.0, 1.0, 1.0), (3.0, 1.0, 0.5, 2.0, 0.7), (0.2, 1.0, 1.0, 4.0, 1.0))
SPEEDS = ((1.0, 0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0, -2.0))
UNEQUAL = (0.9, 0.1, 0.6, 0.3)


def row(masses, speeds, es, rule, gap=0.0):
    """Return balls in a row, a law of its own for each pair of neighbours; the outer ones strike."""
    names = [f"ball {k}" for k in range(len(masses))]
    ahead = [-AHEAD if v > 0.0 else AHEAD if v < 0.0 else 0.0 for v in speeds]
    bodies = [
        fmb.RigidBody(
            name,
            mass=m,
            inertia=(1e-3,) * 3,
            at=(k * (2.0 * RADIUS + gap) + a * abs(v), 0, 0),  # both strike at the same time
            velocity=(v, 0, 0),
        )
        for k, (name, m, v, a) in enumerate(zip(names, masses, speeds, ahead, strict=True))
    ]
    return fmb.Model(
        bodies=bodies,
        surfaces=[fmb.Surface(name, marker=f"{name}.center", shape=fmb.Sphere(RADIUS)) for name in names],
        forces=[
            fmb.SurfaceContact(f"touch {k}", surfaces=pair, law=fmb.Rigid(restitution=e, rule=rule))
            for k, (pair, e) in enumerate(zip(pairwise(names), es, strict=True))
        ],
        sensors=[fmb.Velocity(name, marker=f"{name}.center") for name in names],
    )


def after(model, t_end):
    """Return the velocities of all balls along the row."""
    solution = fmb.simulate(model, t_end, integrator=fmb.MoreauJean(step=STEP, tolerance=1e-10), samples=3)
    return [float(solution[body.name][-1, 0]) for body in model.bodies if body.name != "ground"]


def pressed(D, q, least):
    """Return the impulses P >= least with D P + q >= 0, and one of both zero: the only such combination."""
    n = len(q)
    for size in range(n + 1):
        for on in map(list, combinations(range(n), size)):
            P = least.copy()
            if on:
                off = q + D @ P
                P[on] -= np.linalg.solve(D[np.ix_(on, on)], off[on])
            if np.all(P >= least - 1e-12) and np.all(D @ P + q >= -1e-12):
                return P
    raise AssertionError


def expected(masses, speeds, es, rule):
    """Return the velocities after the impact of touching balls by the law of Newton or Poisson, eq. (poisson-law)."""
    v, n = np.array(speeds), len(es)
    W = np.zeros((n, n + 1))
    W[range(n), range(n)], W[range(n), range(1, n + 1)] = -1.0, 1.0
    inverse = np.diag(1.0 / np.array(masses))
    return v + inverse @ W.T @ impulses(W @ inverse @ W.T, W @ v, np.array(es), rule)


def impulses(D, q, e, rule):
    """Return the impulses of closed contacts with the mobility D and the velocities q before."""
    none = np.zeros(len(q))
    if rule == "Newton":
        return pressed(D, q + e * np.minimum(q, 0.0), none)
    compression = pressed(D, q, none)
    return compression + pressed(D, q + D @ compression, e * compression)


@pytest.mark.parametrize("rule", ["Newton", "Poisson"])
@pytest.mark.parametrize("speeds", SPEEDS)
@pytest.mark.parametrize("masses", MASSES)
def test_touching_balls_with_unequal_restitution(masses, speeds, rule):
    """Each contact has its own e: 0.9, 0.1, 0.6 and 0.3."""
    found = after(row(masses, speeds, UNEQUAL, rule), 0.004)
    assert found == pytest.approx(expected(masses, speeds, UNEQUAL, rule), abs=1e-7)


@pytest.mark.parametrize(("first", "second"), [(0.5, 1.0), (0.3, 0.9), (0.0, 0.0)])
def test_what_rests_gives_back_what_is_pressed_into_it(first, second):
    """Three equal balls, the first of which strikes at 1 m/s, by hand.

    All three move with 1/3 after the compression, with the impulses 2/3 and 1/3. Each contact gives back e times its
    own, as long as the balls part, e1 <= e2 <= 4 e1 (Glocker & Pfeiffer 1995).
    """
    model = row((1.0,) * 3, (1.0, 0.0, 0.0), (first, second), "Poisson")
    by_hand = (1.0 - 2.0 * first) / 3.0, (1.0 + 2.0 * first - second) / 3.0, (1.0 + second) / 3.0
    assert after(model, 0.004) == pytest.approx(by_hand, abs=1e-7)


def test_energy_never_grows(rng):
    """Poisson's law without friction takes energy, or none, whatever the restitutions of the contacts are."""
    lost = []
    for _ in range(8):
        masses, es = tuple(10.0 ** rng.uniform(-1, 1, 5)), tuple(rng.uniform(0, 1, 4))
        speeds = (rng.uniform(0.5, 2), 0.0, 0.0, 0.0, -rng.uniform(0.5, 2))
        found = after(row(masses, speeds, es, "Poisson"), 0.004)
        assert found == pytest.approx(expected(masses, speeds, es, "Poisson"), abs=1e-7)
        before = np.dot(masses, np.square(speeds))
        lost.append(1.0 - np.dot(masses, np.square(found)) / before)
    assert min(lost) >= 0.0
    es = (1.0,) * 4
    found = after(row(MASSES[1], SPEEDS[1], es, "Poisson"), 0.004)
    assert np.dot(MASSES[1], np.square(found)) == pytest.approx(np.dot(MASSES[1], np.square(SPEEDS[1])), rel=1e-7)


@pytest.mark.parametrize(("e", "ends"), [((1.0, 0.0), (0.5, 0.0)), ((0.5, 0.5), (0.0, 0.5)), ((0.0, 0.8), (0.0, 0.8))])
def test_a_rod_that_rests_on_one_end(e, ends):
    """A slender rod turns about one end, which rests, and strikes with the other at 1 m/s: velocities of its ends.

    m D = (4, -2; -2, 4), so the compression is m/6 and m/3: the floor presses below the end that rests, too.
    """
    half, names = 0.5, ("left", "right")
    rod = fmb.RigidBody(
        "rod",
        mass=1.0,
        inertia=(1e-3, 1.0 / 12.0, 1.0 / 12.0),
        at=(0, 0, 0),
        velocity=(0, 0, -0.5),
        angular_velocity=(0, 1.0, 0),
        markers={"left": (-half, 0, 0), "right": (half, 0, 0)},
    )
    tiny = 1e-6 * np.array([(0, 0, 0), (1, 0, 2), (0, 1, 2), (-1, -1, 2.0)])
    model = fmb.Model(
        bodies=[fmb.Ground(), rod],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            *(fmb.Surface(name, marker=f"rod.{name}", shape=fmb.Hull(points=tiny)) for name in names),
        ],
        forces=[
            fmb.SurfaceContact(name, surfaces=("floor", name), law=fmb.Rigid(restitution=x, rule="Poisson"))
            for name, x in zip(names, e, strict=True)
        ],
        sensors=[fmb.Velocity(name, marker=f"rod.{name}") for name in names],
    )
    solution = fmb.simulate(model, 2e-6, integrator=fmb.MoreauJean(step=1e-6, tolerance=1e-10), samples=3)
    D = np.array([[4.0, -2.0], [-2.0, 4.0]])
    q = np.array([0.0, -1.0])
    assert q + D @ impulses(D, q, np.array(e), "Poisson") == pytest.approx(ends, abs=1e-12)
    assert [solution[name][-1, 2] for name in names] == pytest.approx(ends, abs=1e-5)


def test_weight_is_not_given_back():
    """A ball rests on a floor that gives back everything, while two others strike each other: it stays where it is."""
    at = {"rests": (0, 0, RADIUS), "strikes": (1.0, 0, 1.0), "is struck": (1.0 + 2.0 * RADIUS + AHEAD, 0, 1.0)}
    speeds = {"strikes": (1.0, 0, 0)}
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(),
            *(
                fmb.RigidBody(name, mass=1.0, inertia=(1e-3,) * 3, at=place, velocity=speeds.get(name, (0, 0, 0)))
                for name, place in at.items()
            ),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            *(fmb.Surface(name, marker=f"{name}.center", shape=fmb.Sphere(RADIUS)) for name in at),
        ],
        forces=[
            fmb.SurfaceContact(name, surfaces=pair, law=fmb.Rigid(restitution=1.0, rule="Poisson"))
            for name, pair in (("hold", ("floor", "rests")), ("hit", ("strikes", "is struck")))
        ],
        sensors=[fmb.Velocity(name, marker=f"{name}.center") for name in at],
    )
    solution = fmb.simulate(model, 0.004, integrator=fmb.MoreauJean(step=STEP), samples=41)
    assert solution["is struck"][-1, 0] == pytest.approx(1.0, abs=1e-9)
    assert np.abs(solution["rests"]).max() < 1e-12


@pytest.mark.parametrize("rule", ["Newton", "Poisson"])
def test_plastic_impacts_join_all_balls(rule):
    """e = 0 everywhere: all move on together, whatever the rule and the masses."""
    masses = MASSES[1]
    together = masses[0] / sum(masses)
    assert after(row(masses, SPEEDS[0], (0.0,) * 4, rule), 0.004) == pytest.approx([together] * 5, abs=1e-7)


@pytest.mark.parametrize(("masses", "e"), every_second(MASSES, [1.0, 0.8]))
def test_a_cradle_apart_is_struck_by_another_mass(masses, e):
    """Balls 1 mm apart strike one pair after another: the closed form of two bodies, impact for impact."""
    gap = 1e-3
    model = row(masses, SPEEDS[0], (e,) * 4, "Newton", gap)
    t_end = 0.04
    x = np.array([k * gap for k in range(5)]) - [AHEAD, 0, 0, 0, 0]  # without the diameters
    v, t = np.array(SPEEDS[0]), 0.0
    while True:
        nearing = v[:-1] - v[1:]
        times = np.where(nearing > 1e-12, (x[1:] - x[:-1]) / np.where(nearing > 1e-12, nearing, 1.0), np.inf)
        k = int(np.argmin(times))
        if t + times[k] > t_end:
            break
        t, x = t + times[k], x + v * times[k]
        P = (1.0 + e) * nearing[k] / (1.0 / masses[k] + 1.0 / masses[k + 1])
        v[k], v[k + 1] = v[k] - P / masses[k], v[k + 1] + P / masses[k + 1]
    assert after(model, t_end) == pytest.approx(v, abs=1e-6)
