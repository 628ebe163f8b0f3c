"""Distances to profiles: closed forms, and the least distance to very many points of the curve."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.profiles.feet import FOOT, MOST_FEET, find_feet, rising_roots
from flexmb.profiles.supports import MOST_SUPPORTS, SUPPORT, find_supports

ANGLES = np.arange(12) * np.pi / 6.0
STAR = fmb.SmoothOutline(
    through=[(r * np.cos(a), r * np.sin(a)) for a, r in zip(ANGLES, np.where(np.arange(12) % 2, 0.5, 1.0))]
)
EGG = fmb.SmoothOutline(through=[(1.2 * np.cos(a) + 0.1 * np.sin(a), np.sin(a)) for a in ANGLES[::2]])
SLOT = fmb.Outline(
    start=(0, 0.1),
    pieces=[
        fmb.Line(to=(1, 0.1)),
        fmb.Arc(center=(1, 0), sweep=-np.pi),
        fmb.Line(to=(0, -0.1)),
        fmb.Arc(center=(0, 0), sweep=-np.pi),
    ],
)
TOOTH = fmb.Outline(
    start=(0.9, -0.2),
    pieces=[
        fmb.Line(to=(1.0, -0.2)),
        fmb.Involute(base_radius=0.98, radius=1.2, side=1),
        fmb.Line(to=(1.1, 0.2)),
        fmb.Line(to=(0.9, 0.2)),
    ],
)


@pytest.mark.parametrize("profile", [STAR, EGG, SLOT, TOOTH], ids=["star", "egg", "slot", "tooth"])
def test_no_nearer_place_is_missed(profile, rng):
    """2 000 000 points of the curve are nowhere nearer, and the nearest of them is hardly farther."""
    curve = np.vstack([[profile._at(i, h)[0] for h in np.arange(4000) / 4000] for i in range(int(profile.table[0]))])
    for point in rng.uniform(-1.5, 1.5, (60, 2)):
        least = np.linalg.norm(curve - point, axis=1).min()
        assert least - 1e-5 < abs(profile.distance(point)[0]) < least + 1e-12


def test_closed_forms():
    disc = fmb.Disc(radius=2.0, center=(1.0, 0.0))
    distance, normal, curvature = disc.distance((1.0, 5.0))
    np.testing.assert_allclose([distance, *normal, curvature], [3.0, 0.0, 1.0, 0.5], atol=1e-15)
    assert fmb.Disc(radius=2.0, hollow=True).distance((0.5, 0.0))[0] == pytest.approx(1.5, abs=1e-15)
    assert SLOT.distance((0.5, 0.03))[0] == pytest.approx(0.07, abs=1e-15)
    np.testing.assert_allclose(SLOT.distance((1.05, 0.0))[1], (-1.0, 0.0), atol=1e-15)
    assert SLOT.area == pytest.approx(-(0.2 + np.pi * 0.01), rel=1e-5)
    # the string of an involute is its normal, and as long as the arc that it has left
    t = 0.7
    base = np.array([np.cos(t), np.sin(t)])
    flank = fmb.Outline(start=(1, 0), pieces=[fmb.Involute(base_radius=1.0, radius=2.0, side=1)], ends=True)
    point = base + (t + 0.25) * np.array([np.sin(t), -np.cos(t)])
    distance, normal, curvature = flank.distance(point)
    np.testing.assert_allclose([distance, *normal], [0.25, np.sin(t), -np.cos(t)], rtol=1e-13)
    assert curvature == pytest.approx(1.0 / t, rel=1e-12)


def test_a_groove_is_touched_at_both_flanks():
    groove = fmb.Outline(start=(1, 1), pieces=[fmb.Line(to=(0, 0)), fmb.Line(to=(-1, 1))], ends=True)
    feet = np.empty((MOST_FEET, FOOT))
    assert find_feet(groove.table, 0.0, 0.5, 0.4, feet) == 2
    np.testing.assert_allclose(feet[:2, 4], 0.5 / 2**0.5, rtol=1e-14)


def test_a_slot_has_the_same_width_everywhere():
    path = [(0.2 * k, 0.1 * np.sin(k)) for k in range(7)]
    slot = fmb.Slot(through=path, width=0.05)
    middle = fmb.SmoothOutline(through=path, ends=True).points(1e-2)
    distances = [slot.distance(point)[0] for point in middle]
    np.testing.assert_allclose(distances, 0.025, atol=1e-7)
    assert slot.area < 0.0


def test_normals_are_the_gradient_of_the_distance(rng):
    h = 1e-6
    for point in rng.uniform(-1.4, 1.4, (40, 2)):
        differences = [(EGG.distance(point + e)[0] - EGG.distance(point - e)[0]) / (2 * h) for e in h * np.eye(2)]
        np.testing.assert_allclose(EGG.distance(point)[1], differences, atol=1e-7)


def test_roots_of_polynomials(rng):
    """Against the eigenvalues of the companion matrix."""
    roots = np.empty(6)
    for _ in range(300):
        power = rng.normal(size=6)
        count = rising_roots(power, 5, roots)
        found = np.roots(power[::-1])
        real = np.sort(found[(abs(found.imag) < 1e-9) & (found.real > 0) & (found.real < 1)].real)
        slopes = np.polyval(np.polyder(power[::-1]), real)
        np.testing.assert_allclose(np.sort(roots[:count]), real[slopes > 0], atol=1e-9)


@pytest.mark.parametrize("profile", [STAR, EGG], ids=["star", "egg"])
def test_supports_are_the_farthest_points(profile, rng):
    curve = profile.points(1e-4)
    found = np.empty((MOST_SUPPORTS, SUPPORT))
    for angle in rng.uniform(0, 2 * np.pi, 40):
        n = np.cos(angle), np.sin(angle)
        assert find_supports(profile.table, *n, found) >= 1
        assert found[0, 3] == pytest.approx(np.max(curve @ n), abs=1e-8)


def test_sharp_corners_of_long_and_short_sides():
    """Around the tip of a tooth sharper than 90 degrees the point is outside, in all of the cone of its normals."""
    tip, low, far = np.array([0.0, 1.0]), np.array([0.1, 0.0]), np.array([-3.0, 0.5])
    tooth = fmb.Outline(start=low, pieces=[fmb.Line(to=tip), fmb.Line(to=far)])
    found = np.empty((MOST_SUPPORTS, SUPPORT))
    ends = [np.arctan2(-d[0], d[1]) for d in (tip - low, far - tip)]
    first, last = np.unwrap(ends)
    assert last - first > np.pi / 2.0
    for angle in np.linspace(first, last, 33)[1:-1]:
        n = np.array([np.cos(angle), np.sin(angle)])
        assert tooth.distance(tip + 0.01 * n)[0] == pytest.approx(0.01, rel=1e-12)
        assert find_supports(tooth.table, *n, found) >= 1
        np.testing.assert_allclose(found[0, :3], (*tip, 0.0), atol=1e-15)


def test_signs_against_winding_numbers(rng):
    """Random polygons with corners of every angle: inside where the angles to the corners wind around."""
    for _ in range(6):
        angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, 9))
        corners = rng.uniform(0.2, 1.0, 9)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        polygon = _square(*map(tuple, corners))
        for point in rng.uniform(-1.0, 1.0, (100, 2)):
            rays = np.vstack([corners, corners[:1]]) - point
            turned = np.arctan2(rays[:, 1], rays[:, 0])
            winding = np.sum((np.diff(turned) + np.pi) % (2.0 * np.pi) - np.pi)
            assert (polygon.distance(point)[0] < 0.0) == (winding > np.pi)


def test_smooth_joints_lose_nothing():
    """Directions and points exactly across the joints of a circle's halves, and within rounding of them."""
    disc = fmb.Disc(radius=0.03, center=(0.0, -0.005))
    found, feet = np.empty((MOST_SUPPORTS, SUPPORT)), np.empty((MOST_FEET, FOOT))
    for angle in np.pi * np.array([[-1.0, 0.0, 1.0, 2.0]]) + np.linspace(-1e-15, 1e-15, 21)[:, None]:
        for a in angle:
            n = np.array([np.cos(a), np.sin(a)])
            assert find_supports(disc.table, *n, found) == 1
            np.testing.assert_allclose(found[0, 2:4], (0.03, 0.03 - 0.005 * n[1]), rtol=1e-9)
            assert find_feet(disc.table, *(np.array([0, -0.005]) + 0.05 * n), 0.1, feet) == 1
            np.testing.assert_allclose(feet[0, 4:7], (0.02, 1 / 0.05, 1 / 0.03), rtol=1e-9)


def _square(*corners):
    return fmb.Outline(start=corners[0], pieces=[fmb.Line(to=c) for c in corners[1:]])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: _square((0, 0), (1, 1), (1, 0), (0, 1)), "crosses itself near"),
        (lambda: _square((0, 0), (1, 0), (1, 0), (0, 1)), "has no length"),
        (lambda: fmb.SmoothOutline(through=[(0, 0), (1, 0), (1, 0), (0, 1)]), "points 2 and 3 both"),
        (lambda: fmb.Outline(start=(0, 0), pieces=[]), "no pieces"),
        (lambda: fmb.Outline(start=(0, 0, 0), pieces=[fmb.Line(to=(1, 0))]), "two numbers"),
        (lambda: fmb.Arc(center=(0, 0), sweep=0.0), "not zero"),
        (lambda: fmb.Disc(radius=-1.0), "radius = -1.0"),
        (lambda: fmb.Slot(through=[(0, 0), (0.1, 0.1), (0.2, 0)], width=0.5), "more than half the width"),
        (lambda: fmb.Slot(through=[(0, 0)], width=0.5), "two points"),
        (
            lambda: fmb.Outline(start=(0.5, 0), pieces=[fmb.Involute(base_radius=1.0, radius=2.0, side=1)]),
            "base circle",
        ),
        (
            lambda: fmb.Outline(start=(1, 0), pieces=[fmb.Involute(base_radius=1.0, radius=2e9, side=1)], ends=True),
            "winds 3.*e.08 times around its base circle",
        ),
    ],
)
def test_bad_curves_are_refused_by_name(make, words):
    with pytest.raises(ModelError, match=words):
        make()


def test_an_involute_of_many_turns_is_drawn_as_finely_as_one_of_few():
    """The tangent turns as the string rolls: ten turns of it have at least that many chords."""
    radius = float(np.hypot(1.0, 20.0 * np.pi))
    scroll = fmb.Outline(start=(1, 0), pieces=[fmb.Involute(base_radius=1.0, radius=radius, side=1)], ends=True)
    assert len(scroll.points(0.1)) >= 20.0 * np.pi / 0.1
