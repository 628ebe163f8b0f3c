"""High-lift system, slats: outcomes 5.11 and 5.19 of the data set, and forces of rollers and teeth by hand.

Reference: the statements of the data set (README 5), and equilibrium of a track (tests/highlift_slats.py).
"""

import numpy as np
import pytest
from highlift_runs import FOLDER, run
from highlift_slats import (
    PAIRS,
    SIDES,
    SLATS,
    angle,
    assert_backlash,
    assert_forces_by_hand,
    assert_shared_rollers,
    at_rest,
    by_hand,
    held_slat,
    pair_force,
)
from tolerances import SOLVER

import flexmb as fmb

STRIKES = [f"{pair} {ring} {side}" for pair, _ in PAIRS for ring in ("outer", "inner") for side in SIDES]


def test_outcome_5_11():
    """On hinges instead of rollers the slats turn exactly in proportion to their pinions: 27 deg for 486 deg."""
    solution = run("slats", ("ideal", True), samples=101)
    full = np.radians(SLATS["max_angle_deg"])
    for number in (1, 6):
        progress = solution[f"s{number}_t1_pinion angle"] / np.radians(SLATS["pinion"]["pinion_range_deg"])
        assert np.abs(angle(solution, number) / full - progress).max() < 1e-6


@pytest.mark.slow
def test_rollers_add_backlash_to_it():
    """A pair of rollers 15 deg behind the other: gap and overlap of 0.2 mm together let the centre of the rack move by
    0.2 mm/sin 15 deg along the path, 1 mrad; the line stays straight within that."""
    assert_backlash(at_rest(-1), range(1, 7))


@pytest.mark.parametrize("number", [1, 3, 5])
@pytest.mark.parametrize("row", [0, pytest.param(-1, marks=pytest.mark.slow)])
def test_roller_forces_and_pinion_torques_by_hand(number, row):
    """Retracted and in the landing setting, at rest."""
    assert_forces_by_hand(at_rest(row), number, row)


@pytest.mark.slow
def test_both_substitutes_share_a_roller():
    assert_shared_rollers(at_rest(-1), {1: 2, 6: 3})


def test_no_force_inside_the_backlash():
    """5.19: without load the retracted rack floats between its rollers, and no contact acts, exactly."""
    still = fmb.simulate(held_slat(("load_factor", 0.0)), 0.05, samples=6)
    for track in ("t1", "t2"):
        for name in STRIKES:
            assert not np.any(still[f"{track}_{name} force"])


def lift(*settings):
    """Return how far the airload moves the rack of the free track away from the centre of its path, m,
    at the front pair.
    """
    rack = fmb.statics(held_slat(*settings))[fmb.Position("left", marker="t2_rack.left")]
    assert np.abs(rack[-1] - rack[0]).max() < 2e-3
    return (rack[-1] - rack[0])[2]


@pytest.mark.slow
def test_the_roller_law_tends_to_an_ideal_contact():
    """5.19: the overlap of the front pair of the free track is (F/2 / c_N)^(2/3) beyond half the backlash, eq.
    (one-sided): it falls with c_N; twice the backlash moves the zero point by half of it."""
    force = -by_hand(1, 0.0, 0).free[0] / 2  # of each of two contacts
    gap = SLATS["rollers"]["backlash_main"] / 2
    overlaps = []
    for factor in (1.0, 10.0, 100.0):
        stiffness = factor * SLATS["rollers"]["c_N"]
        overlaps.append(lift(("rollers_c_N", stiffness)) - gap)
        assert overlaps[-1] == pytest.approx((force / stiffness) ** (2 / 3), rel=0.01, abs=1e-8)
    assert overlaps[2] < 0.05 * overlaps[0]
    wider = lift(("rollers_backlash_main", 2 * SLATS["rollers"]["backlash_main"]))
    assert wider - lift() == pytest.approx(gap, rel=1e-3)


def test_every_track_is_determinate():
    """Six slats on thirteen tracks: no dependent equation; only the rollers hold the racks (63 freedoms)."""
    report = fmb.check(fmb.load_model(FOLDER / "slats.toml"))
    assert not report.redundant
    assert report.mobility == report.gruebler == 63
    assert report.assembly_error < SOLVER


def euler_bernoulli(number):
    """Return the first frequency of free bending of a slat, Hz: 22.37/(2 pi) sqrt(EI/(m l^4))."""
    span, mass = SLATS["span"][number - 1], SLATS["mass"][number - 1]
    return 22.3733 / (2 * np.pi) * np.sqrt(SLATS["EI_flapwise"] * span / mass / span**4)


def test_an_elastic_slat():
    """Its mass, and its first free frequency within 3 % (the area centre lies behind the shear centre); on two tracks,
    which is determinate, it loads rollers and pinions as the rigid one does, but for its bending under them."""
    data = fmb.load_model(FOLDER / "slat.toml", {"rigid": False}).body("beam").data
    assert data.mass == pytest.approx(SLATS["mass"][0], rel=1e-9)
    assert data.frequencies[0] == pytest.approx(euler_bernoulli(1), rel=0.03)
    expected = by_hand(1, 0.0, 0)
    solution = fmb.statics(held_slat(("rigid", False)))
    for track, (front, rear, torque) in (("t1", expected.fixed), ("t2", expected.free)):
        scale = abs(front) + abs(rear)
        assert pair_force(solution, track, "front", -1) == pytest.approx(front, abs=0.01 * scale)
        assert pair_force(solution, track, "rear", -1) == pytest.approx(rear, abs=0.01 * scale)
        assert solution[f"{track}_tooth force"][-1, 5] == pytest.approx(torque, abs=0.03 * abs(expected.fixed[2]))


@pytest.mark.parametrize("variant", ["profiles", "surfaces"])
def test_rollers_on_profiles_carry_the_same(variant):
    """Cylinders on the circles of the rack, or balls on the rack as a solid, wherever it is, in place of springs along
    fixed radii: retracted, held. The racks lie 0.1 mm off their centre, so the directions differ by 0.1 mrad to 1 mrad.
    """
    springs, others = (fmb.statics(held_slat((variant, on))) for on in (False, True))
    for track in ("t1", "t2"):
        for pair, _ in PAIRS:
            expected, found = (pair_force(solution, track, pair, -1) for solution in (springs, others))
            assert -found == pytest.approx(expected, abs=0.005 * 5.4e3)  # told on the roller
        torque = springs[f"{track}_tooth force"][-1, 5]
        assert others[f"{track}_tooth force"][-1, 5] == pytest.approx(torque, rel=1e-4)


@pytest.mark.slow
def test_six_slats_rest_on_surfaces():
    """All thirteen tracks, retracted: rollers as balls on racks that are solids, beside springs on fixed radii."""
    springs, others = at_rest(0), fmb.statics(fmb.load_model(FOLDER / "slats.toml", {"surfaces": True}))
    tracks = [f"s{number}_t{k}" for number in range(1, 7) for k in (1, 2, 3) if number == 6 or k < 3]
    for track in tracks:
        both = [[pair_force(solution, track, pair, -1) for pair, _ in PAIRS] for solution in (springs, others)]
        scale = np.abs(both[0]).sum()
        assert scale > 1e3
        np.testing.assert_allclose(both[1], [-force for force in both[0]], atol=5e-3 * scale)  # told on the roller


def test_side_rollers_on_surfaces_carry_the_same():
    """A slat pushed outboard by 3 kN: two side rollers of the fixed track hold it, as balls on the rack's flanks as
    springs do."""
    sides = [f"t1_{pair} side {side}" for pair, _ in PAIRS for side in SIDES]
    told = [fmb.ForceOf(f"{name} force", force=name) for name in sides]
    found = []
    for on in (False, True):
        model = held_slat(("surfaces", on))
        marker = next(name for name in model.marker_names() if name.startswith("beam."))
        push = fmb.PointLoad("push", marker=marker, force=(0, 3000.0, 0))
        solution = fmb.statics(model.with_parts(forces=[push], sensors=told))
        found.append([solution[f"{name} force"][-1, 1] for name in sides])
    assert np.abs(found[0]).max() > 3000.0
    np.testing.assert_allclose(found[1], found[0], atol=2e-3 * np.abs(found[0]).max())


@pytest.mark.slow
@pytest.mark.parametrize(("variant", "within"), [("profiles", 2e-3), ("surfaces", 2e-2)])
def test_rollers_on_profiles_lead_the_same_way(variant, within):
    """Extended, angles and forces agree; under way both rattle in the backlash, damped by different laws. On surfaces
    they rattle sideways too, and still do a little at the end."""
    springs, profiles = (run("slats", (variant, on), samples=101) for on in (False, True))
    for number in range(1, 7):
        off = np.abs(angle(springs, number) - angle(profiles, number))
        assert off.max() < 5e-4
        assert off[-1] < 1e-6
    for track in ("s1_t1", "s1_t2"):
        for pair, _ in PAIRS:
            expected, found = (pair_force(solution, track, pair, -1) for solution in (springs, profiles))
            assert -found == pytest.approx(expected, rel=within)
