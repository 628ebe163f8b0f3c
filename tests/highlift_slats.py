"""Slats of the high-lift example: their data, runs that several tests look at, and the equilibrium of a track by hand.

A track carries three unknown forces in its plane: those of its two pairs of rollers, which act through the centre of
the rack, and that of the teeth. The slat loads the rack at its ball, on the fixed track also with the moment of the
pendular strut. So three equations of equilibrium give all of them.
"""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from highlift_runs import DATA, FOLDER, run

import flexmb as fmb

SLATS = DATA["slats"]
PAIRS = [(pair, np.radians(angle)) for pair, angle in zip(("front", "rear"), SLATS["rollers"]["pair_angles_deg"])]
SIDES = ("left", "right")
CENTRE = np.array(SLATS["rack"]["centre"])
PATH = (SLATS["rack"]["roller_path_radius_outer"] + SLATS["rack"]["roller_path_radius_inner"]) / 2
BALL = PATH * np.array([np.sin(np.radians(-5.0)), np.cos(np.radians(-5.0))])  # from the centre, retracted


@cache
def held_slat(*settings):
    """Return slat 1 alone, retracted, its pinions held; settings of slat.toml."""
    model = fmb.load_model(FOLDER / "slat.toml", dict(settings))
    holds = [fmb.Drive(f"{track} hold", joint=f"{track}_pinion", angle=0.0) for track in ("t1", "t2")]
    return model.with_parts(joints=holds)


@cache
def at_rest(row):
    """Return the slats in equilibrium, retracted (row 0), or at rest after an extension of two seconds (row -1)."""
    if row == 0:
        return fmb.statics(fmb.load_model(FOLDER / "slats.toml"))
    return run("slats", ("duration", 2.0), t_end=2.2, samples=111)


def angle(solution, number):
    """Return the slat's angle (nt,), rad, nose down positive."""
    p = solution[f"s{number}_orientation"]
    return -2.0 * np.arctan2(p[:, 2], p[:, 0])


def pair_force(solution, track, pair, k):
    """Return the force of a pair of rollers on the rack, N, away from its centre."""
    names = (f"{track}_{pair} {ring} {side} force" for ring in ("outer", "inner") for side in SIDES)
    return sum(solution[name][k, 2] for name in names)


def moment(r, f):
    """Return the moment about the outboard axis of a force in the plane (x aft, z up)."""
    return r[1] * f[0] - r[0] * f[1]


def by_hand(number, deflection, k):
    """Return front pair, rear pair and pinion torque of the fixed and of a free track,
    from the k-th row of the airload.
    """
    chord, span = SLATS["chord"][number - 1], SLATS["span"][number - 1]
    cn, cc, xcp = (SLATS["airloads"][name][k] for name in ("CN", "CC", "XCP"))
    aft, up = (
        np.array([np.cos(deflection), np.sin(deflection)]),
        np.array([-np.sin(deflection), np.cos(deflection)]),
    )

    def turned(point):
        return point[0] * aft + point[1] * up

    area = DATA["airloads"]["dynamic_pressure"] * span * chord
    force = area * (cc * aft + cn * up)
    total = moment(turned(-CENTRE), force) - area * chord * cn * xcp  # about the centre of the racks
    half = force / 2  # the tracks stand symmetrically
    free = moment(turned(BALL), half)
    mesh = np.radians(7.5)
    matrix = np.zeros((3, 3))
    for column, (_, place) in enumerate(PAIRS):
        matrix[:2, column] = np.sin(place), np.cos(place)
    matrix[:, 2] = np.cos(mesh), -np.sin(mesh), SLATS["rack"]["pitch_radius"]
    found = []
    for turning in (total - free, free):
        front, rear, tooth = np.linalg.solve(matrix, -np.array([*half, turning]))
        found.append((front, rear, tooth * SLATS["pinion"]["pitch_radius"]))
    return SimpleNamespace(fixed=found[0], free=found[1])


def assert_forces_by_hand(solution, number, row):
    """Assert that the last forces of rollers and teeth of a slat are those of equilibrium, for the `row` of the
    airload."""
    expected = by_hand(number, np.radians(SLATS["max_angle_deg"]) * (0.0 if row == 0 else 1.0), row)
    largest = max(abs(expected.fixed[2]), abs(expected.free[2]))
    for track, (front, rear, torque) in ((f"s{number}_t1", expected.fixed), (f"s{number}_t2", expected.free)):
        scale = abs(front) + abs(rear)
        assert pair_force(solution, track, "front", -1) == pytest.approx(front, abs=0.01 * scale)
        assert pair_force(solution, track, "rear", -1) == pytest.approx(rear, abs=0.01 * scale)
        assert solution[f"{track}_tooth force"][-1, 5] == pytest.approx(torque, abs=0.01 * largest)


def assert_backlash(solution, numbers):
    """Assert that these slats follow their pinions, but for the backlash of their rollers."""
    full = np.radians(SLATS["max_angle_deg"])
    for number in numbers:
        progress = solution[f"s{number}_t1_pinion angle"] / np.radians(SLATS["pinion"]["pinion_range_deg"])
        off = angle(solution, number) - full * progress
        assert 1e-5 < np.abs(off).max() < 1.5e-3
    assert solution["loop closure"].max() < 1e-6


def assert_shared_rollers(solution, tracks):
    """Assert for {slat: number of its tracks} that the two contacts of a roller carry the same: nothing loads a slat
    sideways or across its tracks."""
    for number, last in tracks.items():
        for track in range(1, last + 1):
            name = f"s{number}_t{track}_front outer"
            left, right = (solution[f"{name} {side} force"][-1, 2] for side in SIDES)
            assert left < -1e3
            assert left == pytest.approx(right, rel=0.05)
