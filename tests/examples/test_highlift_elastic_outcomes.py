"""High-lift system with elastic parts: the outcomes 5.11, 5.15 and 5.19.

What elastic means in each: 5.11 an elastic slat on rigid racks, an elastic nose on elastic arms; 5.15 elastic flaps on
elastic tracks, which carry the gearboxes; 5.19 the rollers under an elastic slat. 5.12 is in the tests of the nose,
5.16 to 5.18 and 5.20, which are about the finite elements of the bodies, in those of the bodies; 5.1 to 5.10 and 5.14
in `test_highlift_elastic`. Ranges are those of the rigid parts.
"""

import numpy as np
import pytest
from highlift_runs import DATA, FOLDER, run
from highlift_slats import PAIRS, SLATS, by_hand, held_slat, pair_force

import flexmb as fmb

ELASTIC = ("rigid", False)
NOSE, TRANSMISSION = DATA["droop_nose"], DATA["transmission"]
LEVERS = [f"inboard_t{k}_lever angle" for k in (1, 2)] + [f"outboard_t{k}_lever angle" for k in (3, 4, 5)]
RATIO = np.array([TRANSMISSION["overall_ratio_track_1"]] + 4 * [TRANSMISSION["overall_ratio"]])


@pytest.mark.slow
def test_outcome_5_11_slat():
    """An elastic slat on hinges: its racks turn exactly in proportion to their pinions; the slat itself bends over
    its tracks by less than the half degree that the nose may have."""
    full, pinion = np.radians(SLATS["max_angle_deg"]), np.radians(SLATS["pinion"]["pinion_range_deg"])
    model = fmb.load_model(FOLDER / "slat.toml", {"rigid": False, "ideal": True})
    turn = fmb.expression(f"{pinion!r}*(10*min(t, 1)**3 - 15*min(t, 1)**4 + 6*min(t, 1)**5)")
    model = model.with_parts(
        joints=[fmb.Drive(f"{track} turn", joint=f"{track}_pinion", angle=turn) for track in ("t1", "t2")],
        sensors=[fmb.JointCoordinate(f"{track} rack", joint=f"{track}_guide") for track in ("t1", "t2")],
    )
    solution = fmb.simulate(model, t_end=1.0, samples=51)
    progress = solution["t1_pinion angle"] / pinion
    assert progress[-1] == pytest.approx(1.0, abs=1e-9)
    for track in ("t1", "t2"):
        rack = np.abs(solution[f"{track} rack"])
        assert np.abs(rack / full - progress).max() < 1e-6
    off = np.degrees(solution["angle value"] - full * progress)
    assert 1e-3 < np.abs(off).max() < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("load", [0.0, 1.0])
def test_outcome_5_11_nose(load):
    """An elastic nose on elastic arms: within half a degree of proportion, without load and with it."""
    solution = run("droop_operation", ELASTIC, ("load_factor", load))
    lever = solution["s2_lever angle"]
    progress = lever / -np.radians(NOSE["lever_range_deg"])
    for name in ("s2_nose angle", "s4_nose angle"):
        off = np.degrees(solution[name]) - NOSE["max_angle_deg"] * progress
        assert 0.04 < np.abs(off).max() < 0.5


def loaded(variant, torques):
    """Return the levers' angles (5,), rad, with torques (N m) on the actuators of the elastic system at rest."""
    given = {"rigid": False, "load_factor": 0.0, "transmission": variant}
    model = fmb.load_model(FOLDER / "driven.toml", given)
    joints = [name.replace("_lever angle", "_actuator") for name in LEVERS]
    loads = [fmb.Actuator(f"load {k}", joint=joint, effort=-t) for k, (joint, t) in enumerate(zip(joints, torques))]
    solution = fmb.statics(model.with_parts(forces=loads))
    return np.array([solution[name][-1] for name in LEVERS])


@pytest.mark.slow
@pytest.mark.parametrize("variant", [4, 5, 6])
def test_outcome_5_15_elastic_shafts(variant):
    """Levers lag by the springs in series: central shafts under the torque of all stations beyond, downdrive and cross
    shaft under their own; without central shafts their series stiffness is in the downdrive shaft. The gearboxes stand
    on elastic tracks, whose casings turn a little: 1 %."""
    torques = np.array([1e4, 2e4, 1.5e4, 1e4, 5e3])
    below = torques / RATIO  # at the speed of the central shafts
    shafts = np.array([section["stiffness"] for section in TRANSMISSION["shaft"]["sections"]])
    own = below / TRANSMISSION["downdrive_shaft"]["stiffness"]
    own += below * TRANSMISSION["input_gearbox_ratio"] ** 2 / TRANSMISSION["cross_shaft"]["stiffness"]
    for n in range(5):
        if variant == 6:
            own[n] += below[n] * np.sum(1.0 / shafts[: n + 1])
        else:
            first, last = (0, 5) if variant == 4 else (0, 2) if n < 2 else (3, 5)
            own[n] += sum(below[m:last].sum() / shafts[m] for m in range(first, n + 1))
    lag = loaded(variant - 3, torques) - loaded(variant, torques)
    np.testing.assert_allclose(lag, own / RATIO, rtol=0.01)


@pytest.mark.slow
def test_outcome_5_19():
    """Rollers under an elastic slat: without load no contact acts; overlaps follow the roller law and vanish as it
    stiffens; twice the backlash moves the zero point by half of it."""
    still = fmb.simulate(held_slat(ELASTIC, ("load_factor", 0.0)), 0.05, samples=6)
    strikes = [
        f"{pair} {ring} {side}" for pair, _ in PAIRS for ring in ("outer", "inner") for side in ("left", "right")
    ]
    for name in strikes:
        assert not np.any(still[f"t1_{name} force"])
        assert not np.any(still[f"t2_{name} force"])

    def lift(*settings):
        rest = fmb.statics(held_slat(ELASTIC, *settings))
        place = rest[fmb.Position("left", marker="t2_rack.left")]
        return (place[-1] - place[0])[2], pair_force(rest, "t2", "front", -1)

    gap, c = SLATS["rollers"]["backlash_main"] / 2, SLATS["rollers"]["c_N"]
    force = -by_hand(1, 0.0, 0).free[0] / 2  # of each of two contacts
    overlaps = []
    for factor in (1.0, 10.0, 100.0):
        moved, carried_by_pair = lift(("rollers_c_N", factor * c))
        assert carried_by_pair == pytest.approx(-2 * force, rel=0.01)
        overlaps.append(moved - gap)
        assert overlaps[-1] == pytest.approx((force / factor / c) ** (2 / 3), rel=0.02, abs=1e-7)
    assert overlaps[2] < 0.05 * overlaps[0]
    wider = lift(("rollers_backlash_main", 4 * gap))[0]
    assert wider - lift()[0] == pytest.approx(gap, rel=1e-2)
