"""Cams: the follower that rolls or slides on the profile moves by the law; laws against closed forms."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.profiles.supports import MOST_SUPPORTS, SUPPORT, find_supports

TURN = 2.0 * np.pi
MOTION = [(2.0, 0.01, "cycloidal"), (3.0, 0.01, "cycloidal"), (5.0, 0.0, "polynomial"), (TURN, 0.0, "harmonic")]
PLACES = np.array([0.1, 0.6, 1.3, 2.4, 3.3, 4.1, 4.9, 5.7])


def turned(point, angle):
    """Return a point of the ground in the axes of the cam."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * point[0] + s * point[1], -s * point[0] + c * point[1]])


def test_laws():
    """Norton, ch. 3: peak speeds 2 (cycloidal), 1.875 (3-4-5), pi/2 (harmonic); peak accelerations 2 pi, 5.7735,
    pi^2/2, each for a unit rise over a unit angle.
    """
    for law, speed, acceleration in (
        ("cycloidal", 2.0, TURN),
        ("polynomial", 1.875, 10.0 / 3**0.5),
        ("harmonic", np.pi / 2, np.pi**2 / 2),
    ):
        cam = fmb.Cam(base_radius=20.0, motion=[(1.0, 1.0, law), (TURN, 0.0, "cycloidal")])
        s, d, dd = cam.lift(np.linspace(0.0, 1.0, 20001))
        assert [s[0], s[-1]] == pytest.approx([0.0, 1.0], abs=1e-12)
        assert np.max(d) == pytest.approx(speed, rel=1e-6)
        assert np.max(np.abs(dd)) == pytest.approx(acceleration, rel=1e-6)


@pytest.mark.parametrize("offset", [0.0, 0.005])
def test_a_translating_roller(offset):
    cam = fmb.Cam(base_radius=0.04, motion=MOTION, roller=0.01, offset=offset)
    for angle in PLACES:
        high = (0.05**2 - offset**2) ** 0.5 + float(cam.lift([angle])[0][0])
        assert cam.distance(turned((offset, high), angle))[0] == pytest.approx(0.01, abs=1e-9)


@pytest.mark.parametrize("pivot", [(-0.1, 0.02), (0.1, 0.02)])
def test_an_oscillating_roller(pivot):
    motion = [(angle, 20.0 * lift, law) for angle, lift, law in MOTION]  # up to 0.2 rad
    cam = fmb.Cam(base_radius=0.04, motion=motion, roller=0.01, pivot=pivot, arm=0.09)
    sense = 1.0 if pivot[0] < 0.0 else -1.0
    reach = np.hypot(*pivot)
    first = np.arctan2(-pivot[1], -pivot[0]) + sense * np.arccos((reach**2 + 0.09**2 - 0.05**2) / (2 * reach * 0.09))
    for angle in PLACES:
        a = first + sense * float(cam.lift([angle])[0][0])
        center = np.array(pivot) + 0.09 * np.array([np.cos(a), np.sin(a)])
        assert cam.distance(turned(center, angle))[0] == pytest.approx(0.01, abs=1e-8)


def test_a_translating_face():
    cam = fmb.Cam(base_radius=0.04, motion=MOTION)
    found = np.empty((MOST_SUPPORTS, SUPPORT))
    for angle in PLACES:
        find_supports(cam.table, *turned((0.0, 1.0), angle), found)
        s, _, second = (float(x[0]) for x in cam.lift([angle]))
        assert found[0, 3] == pytest.approx(0.04 + s, abs=1e-9)
        assert found[0, 2] == pytest.approx(0.04 + s + second, rel=2e-3)  # the radius of curvature


@pytest.mark.parametrize("pivot", [(-0.1, 0.01), (0.1, 0.01)])
def test_an_oscillating_face(pivot):
    motion = [(angle, 10.0 * lift, law) for angle, lift, law in MOTION]
    cam = fmb.Cam(base_radius=0.04, motion=motion, pivot=pivot, arm=0.005)
    found = np.empty((MOST_SUPPORTS, SUPPORT))
    sense = 1.0 if pivot[0] < 0.0 else -1.0
    first = np.arctan2(pivot[1], pivot[0]) - sense * np.arccos((0.04 - 0.005) / np.hypot(*pivot))
    for angle in PLACES:
        n = first + sense * float(cam.lift([angle])[0][0])
        normal = np.array([np.cos(n), np.sin(n)])
        assert normal[1] > 0.0  # the face lies above the cam
        find_supports(cam.table, *turned(normal, angle), found)
        assert found[0, 3] == pytest.approx(normal @ pivot + 0.005, abs=1e-8)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"roller": 0.2, "motion": [(0.5, 0.03, "harmonic"), (TURN, 0.0, "harmonic")]}, "undercut"),
        ({"motion": [(0.3, 0.03, "harmonic"), (TURN, 0.0, "harmonic")]}, "radius of curvature"),
        ({"motion": [(2.0, 0.01, "cycloidal")]}, "a full turn"),
        ({"motion": [(2.0, 0.01, "cyclodal"), (TURN, 0.0, "harmonic")]}, "cycloidal"),
        ({"motion": 3}, "growing angles"),
        ({"offset": 0.2, "roller": 0.01}, "offset"),
        ({"pivot": (-0.5, 0.0), "arm": 0.1, "roller": 0.01}, "reaches"),
        ({"count": 3.5}, "whole number"),
    ],
)
def test_bad_cams_are_refused_by_name(fields, words):
    with pytest.raises(ModelError, match=words):
        fmb.Cam(**{"base_radius": 0.04, "motion": MOTION, **fields})
