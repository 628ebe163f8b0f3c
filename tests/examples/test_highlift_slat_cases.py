"""High-lift system, slats: driven by their line of shafts, and after the loss of a roller."""

from itertools import pairwise

import numpy as np
import pytest
from highlift_runs import DATA, FOLDER, run
from highlift_slats import (
    BALL,
    PAIRS,
    SIDES,
    SLATS,
    assert_backlash,
    assert_forces_by_hand,
    assert_shared_rollers,
    by_hand,
    pair_force,
)

import flexmb as fmb

STATIONS = [(s, t) for s in range(1, 7) for t in range(1, SLATS["tracks"][s - 1] + 1)]
FAILURE = 0.65


def driven(variant, t_end=2.0, samples=41):
    """Return the beginning of the extension at the speed of the real drive: 600 rpm from 0.9 s on."""
    return run("slats_driven", ("transmission", variant), t_end=t_end, samples=samples)


@pytest.mark.slow
def test_rigid_shafts_move_all_pinions_alike():
    """60 turns of the line for one of the pinions; the motor holds back what the airload drives,
    sum of all pinions / 60.
    """
    solution = driven(1)
    first = solution["line_s1t1_gear angle"]
    speed = np.gradient(first, solution.t)[-5]
    assert speed * 60 / (2 * np.pi) == pytest.approx(600.0, rel=0.01)
    for s, t in STATIONS:
        np.testing.assert_allclose(solution[f"line_s{s}t{t}_gear angle"], first, atol=1e-9)
        np.testing.assert_allclose(solution[f"s{s}_t{t}_pinion angle"], first / 60, atol=1e-9)
    torque = sum(solution[f"s{s}_t{t}_tooth force"][-1, 5] for s, t in STATIONS) / 60
    assert solution["line_motor torque"][-1, 5] == pytest.approx(-torque, rel=0.03)


@pytest.mark.slow
def test_elastic_shafts_lag_by_their_wind_up():
    """Every section winds up by the torque of all stations outboard of it over G J / length."""
    solution = driven(2)
    gear = {station: solution["line_s{}t{}_gear angle".format(*station)][-1] for station in STATIONS}
    torque = {(s, t): solution[f"s{s}_t{t}_tooth force"][-1, 5] / 60 for s, t in STATIONS}
    place = {
        (s, t): SLATS["start_Y"][s - 1] + SLATS["track_span_fraction"][s - 1][t - 1] * SLATS["span"][s - 1]
        for s, t in STATIONS
    }
    wind_up = 0.0
    for inner, outer in pairwise(STATIONS):
        outboard = sum(torque[k] for k in STATIONS[STATIONS.index(outer) :])
        wind_up += outboard * (place[outer] - place[inner]) / DATA["transmission"]["shaft"]["GJ"]
    found = gear[STATIONS[-1]] - gear[STATIONS[0]]
    assert found == pytest.approx(wind_up, rel=0.05)


def displaced_ball(front, rear):
    """Return how far the ball of a rack has moved in the landing setting, (2,) m, by the radial displacements of its
    pairs.

    The centre follows from both; the mesh turns the rack by the displacement of the centre along the teeth over R (the
    line of centres turns by that over R - r, and the rack by (R - r)/R of it).
    """
    rows = np.array([[np.sin(place), np.cos(place)] for _, place in PAIRS])
    centre = np.linalg.solve(rows, [front, rear])
    mesh = np.radians(7.5)
    turn = -(centre @ [np.cos(mesh), -np.sin(mesh)]) / SLATS["rack"]["pitch_radius"]
    full = np.radians(SLATS["max_angle_deg"])
    ball = np.array([np.cos(full) * BALL[0] - np.sin(full) * BALL[1], np.sin(full) * BALL[0] + np.cos(full) * BALL[1]])
    return centre + turn * np.array([ball[1], -ball[0]])


def overlap(force, contacts):
    """Return the overlap of a roller (two contacts) or an edge (one), m."""
    return (abs(force) / contacts / SLATS["rollers"]["c_N"]) ** (2 / 3)


@pytest.fixture(scope="module")
def lost():
    """The front outer roller of the free track of slat 1 is lost; at a tolerance of 1e-4 in a quarter of the time."""
    path = FOLDER / "slat_roller_lost.toml"
    settings = {**fmb.load_simulation(path).keywords(), "integrator": fmb.GeneralizedAlpha(rtol=1e-4)}
    return fmb.simulate(fmb.load_model(path), **settings)


@pytest.mark.slow
def test_before_the_loss_the_edges_carry_nothing(lost):
    assert not np.any(lost["s1_t2_front outer edge force"][lost.t < FAILURE - 0.01])


@pytest.mark.slow
def test_what_is_not_lost_moves_as_in_operation(lost):
    """Before the loss the rollers carry what they carry in operation, after it the other slats do."""
    sound = run("slats")
    for track in ("s1_t1", "s1_t2"):
        one = np.interp(0.6, sound.t, sound[f"{track}_front outer left force"][:, 2])
        assert np.interp(0.6, lost.t, lost[f"{track}_front outer left force"][:, 2]) == pytest.approx(one, rel=0.01)
    other = "s2_t2_tooth force"
    assert lost[other][-1, 5] == pytest.approx(sound[other][-1, 5], rel=0.02)


@pytest.mark.slow
def test_the_edge_takes_over_the_force_of_the_roller(lost):
    """Both act through the centre of the rack at the same angle, so equilibrium asks for the same force (the rack has
    moved by 12 mm: 3 %); the fixed track, the other slats and the other pairs carry what they did. The lost roller
    carries nothing."""
    expected = by_hand(1, np.radians(SLATS["max_angle_deg"]), -1)
    after = lost.t > FAILURE
    for side in SIDES:
        assert not np.any(lost[f"s1_t2_front outer {side} force"][after])
    edge = lost["s1_t2_front outer edge force"][:, 2]
    front, rear, torque = expected.free
    assert edge[-1] == pytest.approx(front, rel=0.03)
    assert edge[after].min() < 2.0 * front  # the rack strikes the edge
    assert pair_force(lost, "s1_t2", "rear", -1) == pytest.approx(rear, rel=0.04)
    assert lost["s1_t2_tooth force"][-1, 5] == pytest.approx(torque, rel=0.08)
    assert pair_force(lost, "s1_t1", "front", -1) == pytest.approx(expected.fixed[0], rel=0.01)
    assert pair_force(lost, "s1_t1", "rear", -1) == pytest.approx(expected.fixed[1], rel=0.01)
    other = by_hand(2, np.radians(SLATS["max_angle_deg"]), -1)
    assert lost["s2_t2_tooth force"][-1, 5] == pytest.approx(other.free[2], rel=0.02)


@pytest.mark.slow
def test_the_other_slats_extend_as_ever(lost):
    """In the landing setting, at rest: what test_highlift_slats.py says of all of them in operation."""
    assert_backlash(lost, range(2, 7))
    assert_shared_rollers(lost, {2: 2, 6: 3})
    for number in (3, 5):
        assert_forces_by_hand(lost, number, -1)


@pytest.mark.slow
def test_the_slat_stands_askew(lost):
    """By kinematics: the displacements of both racks at their pairs of rollers, from gap,
    backlash and overlap by hand.
    """
    expected = by_hand(1, np.radians(SLATS["max_angle_deg"]), -1)
    slack = SLATS["rollers"]["backlash_main"] / 2
    balls = []
    for (front, rear, _), gap, contacts in ((expected.fixed, slack, 2), (expected.free, 3e-3, 1)):
        balls.append(displaced_ball(gap + overlap(front, contacts), -slack - overlap(rear, 2)))
    distance = np.diff(SLATS["track_span_fraction"][0])[0] * SLATS["span"][0]
    skew = (balls[1] - balls[0]) / distance * 0.75 * SLATS["span"][0]  # between the nose points
    found = (lost["s1_nose outboard"] - lost["s1_nose inboard"])[-1, [0, 2]]
    assert found[1] == pytest.approx(skew[1], rel=0.05)
    assert 0.010 < skew[1] < 0.014
    before = (lost["s1_nose outboard"] - lost["s1_nose inboard"])[lost.t < FAILURE, 2]
    assert np.abs(before).max() < 5e-4


@pytest.mark.slow
def test_an_elastic_slat_swings_to_the_same_forces():
    """The edge carries the same in the mean, the slat bends and rings on."""
    path, given = FOLDER / "slat_roller_lost.toml", {"rigid": False}
    solution = fmb.simulate(fmb.load_model(path, given), **fmb.load_simulation(path, given).keywords())
    front = by_hand(1, np.radians(SLATS["max_angle_deg"]), -1).free[0]
    settled = solution.t > 1.1
    assert solution["s1_t2_front outer edge force"][settled, 2].mean() == pytest.approx(front, rel=0.05)
