"""Several impacts at once, beside every combination of contacts that press, tried one after another."""

from itertools import combinations, pairwise

import numpy as np
import pytest

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
    """Return the velocities after the impact of touching balls by the law of Newton, or of Poisson.

    Contacts that touch without nearing each other have no impulse of their own to give back, eq. (poisson-law).
    """
    v, e, n = np.array(speeds), np.array(es), len(es)
    W = np.zeros((n, n + 1))
    W[range(n), range(n)], W[range(n), range(1, n + 1)] = -1.0, 1.0
    inverse = np.diag(1.0 / np.array(masses))
    D, q, none = W @ inverse @ W.T, W @ v, np.zeros(n)
    if rule == "Newton":
        P = pressed(D, q + e * np.minimum(q, 0.0), none)
    else:
        compression = pressed(D, q, none)
        P = compression + pressed(D, q + D @ compression, np.where(q < 0.0, e, 0.0) * compression)
    return v + inverse @ W.T @ P


@pytest.mark.parametrize("rule", ["Newton", "Poisson"])
@pytest.mark.parametrize("speeds", SPEEDS)
@pytest.mark.parametrize("masses", MASSES)
def test_touching_balls_with_unequal_restitution(masses, speeds, rule):
    """Each contact has its own e: 0.9, 0.1, 0.6 and 0.3."""
    found = after(row(masses, speeds, UNEQUAL, rule), 0.004)
    assert found == pytest.approx(expected(masses, speeds, UNEQUAL, rule), abs=1e-7)


@pytest.mark.parametrize("rule", ["Newton", "Poisson"])
def test_plastic_impacts_join_all_balls(rule):
    """e = 0 everywhere: all move on together, whatever the rule and the masses."""
    masses = MASSES[1]
    together = masses[0] / sum(masses)
    assert after(row(masses, SPEEDS[0], (0.0,) * 4, rule), 0.004) == pytest.approx([together] * 5, abs=1e-7)


@pytest.mark.parametrize("e", [1.0, 0.8])
@pytest.mark.parametrize("masses", MASSES)
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
