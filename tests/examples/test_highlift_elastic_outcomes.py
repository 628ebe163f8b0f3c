"""High-lift system with elastic parts: the outcomes 5.11, 5.13, 5.15 to 5.17 and 5.19.

What elastic means in each: 5.11 an elastic slat on rigid racks, an elastic nose on elastic arms; 5.13 the traces of
track 1 on their elastic brackets; 5.15 elastic flaps on elastic tracks, which carry the gearboxes; 5.16 and 5.17 the
elastic inboard flap in the whole system; 5.19 the rollers under an elastic slat. 5.12 is in the tests of the nose, 5.18
and 5.20, which are about the finite elements of the bodies, in those of the bodies; 5.1 to 5.10 and 5.14 in
`test_highlift_elastic`. Ranges are those of the rigid parts.
"""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import highlift_bodies
import numpy as np
import pytest
from highlift_runs import DATA, FOLDER, run
from highlift_slats import PAIRS, SLATS, by_hand, held_slat, pair_force
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb import fem, reduction

ELASTIC = ("rigid", False)
NOSE, FLAP, TRANSMISSION = DATA["droop_nose"], DATA["trailing_edge"]["inboard_flap"], DATA["transmission"]
LEVERS = [f"inboard_t{k}_lever angle" for k in (1, 2)] + [f"outboard_t{k}_lever angle" for k in (3, 4, 5)]
RATIO = np.array([TRANSMISSION["overall_ratio_track_1"]] + 4 * [TRANSMISSION["overall_ratio"]])
CHORDS = np.interp(FLAP["nose_points_y"], FLAP["y_range"], FLAP["chord"])
STRIPS = np.ptp(FLAP["y_range"]) / 7 * CHORDS


@pytest.mark.slow
def test_outcome_5_11_slat():
    """An elastic slat on hinges: its racks turn exactly in proportion to their pinions; the slat itself bends over
    its tracks by less than the half degree that the nose may have."""
    full, pinion = (float(np.radians(a)) for a in (SLATS["max_angle_deg"], SLATS["pinion"]["pinion_range_deg"]))
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
    off = np.degrees(solution["angle"] - full * progress)
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


@pytest.mark.slow
def test_outcome_5_13():
    """The distance of the rear ball from the path of the front ball, in the axes of the traces, which move on their
    brackets, at full speed: it grows from progress 0.4 on, to 0.65 m."""
    solution = run("operation", ELASTIC)
    trace = "inboard_t1_traces.trace"
    origin, turn = solution[fmb.Position("p", marker=trace)], solution[fmb.Orientation("o", marker=trace)]
    axes = Rotation.from_quat(np.roll(turn, -1, axis=1)).inv()
    front, rear = (
        axes.apply(solution[fmb.Position("p", marker=f"inboard_flap_root.{ball}_ball")] - origin)[:, :2]
        for ball in ("front", "rear")
    )
    path = np.gradient(front, solution.t, axis=0)
    path /= np.linalg.norm(path, axis=1)[:, None]
    d = rear - front
    distance = np.abs(path[:, 0] * d[:, 1] - path[:, 1] * d[:, 0])
    moving = (solution.t > 0.05) & (solution.t < 0.98)
    progress = solution["inboard_t2_lever angle"] / solution["inboard_t2_lever angle"][-1]
    assert distance[moving][-1] == pytest.approx(0.65, abs=0.01)
    assert np.all(np.diff(distance[moving & (progress > 0.4)]) > 0.0)


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


@cache
def flap(kind, modes=12, residuals=True):
    """Return the reduced inboard flap, the airload per dynamic pressure at the nose points, or where it acts.

    `kind` "nose": forces at the nose and a moment that corrects for the place; "real": the same coefficients at the
    centre of pressure of the retracted flap.
    """
    wing, places = DATA["trailing_edge"], FLAP["nose_points_y"]
    ribs = {
        "root": wing["track_1"]["y"],
        "tip": wing["track_2"]["y"],
        "rib": wing["interconnection_strut"]["y_inboard"],
    }
    fe = highlift_bodies.flap_model(FLAP, *FLAP["y_range"], ribs, places, "inboard_flap")
    noses = [f"nose_{k}" for k in range(1, 8)]
    points = noses
    if kind == "real":
        points, x = [f"pressure_{k}" for k in range(1, 8)], DATA["airloads"]["inboard"]["XCP"][0]
        for name, y, c in zip(points, places, CHORDS):
            rib = int(np.argmin(np.linalg.norm(fe.nodes - (FLAP["shear_centre_chord_fraction"] * c, y, 0.0), axis=1)))
            fe = fem.with_rigid_link(fem.with_node(fe, (x * c, y, 0.0), name=name), rib, name)
    at = [int(fe.node_sets[name][0]) for name in points]
    sizes = {
        "normal": ((0, 0, 1), STRIPS),
        "chord": ((1, 0, 0), STRIPS),
        "moment": ((0, 0, 0, 0, 1, 0), STRIPS * CHORDS),
    }
    shapes = {
        name: reduction.NodalForces({n: tuple(s * np.array(axis)) for n, s in zip(at, amounts)})
        for name, (axis, amounts) in sizes.items()
    }
    return reduction.reduce(
        fe,
        {rib: [int(fe.node_sets[rib][0])] for rib in ribs},
        modes=modes,
        stations={name: [int(fe.node_sets[name][0])] for name in noses},
        loads=shapes,
        residual_vectors=tuple(shapes) if residuals else (),
        geometric_stiffness=False,
    )


def carried(data, load, *without):
    """Return forces of struts, pendulum and traces and the deflections of the noses, retracted, at rest, under a
    multiple of the airload."""
    given = {"rigid": False, "load_factor": load, "geometric_stiffness": False}
    model = fmb.load_model(FOLDER / "operation.toml", given)
    bodies = [replace(body, data=data) if body.name == "inboard_flap_beam" else body for body in model.bodies]
    model = replace(model, bodies=tuple(bodies)).without(*(f"inboard_airload {name}" for name in without))
    noses = [fmb.Deflection(f"nose {k}", marker=f"inboard_flap_beam.nose_{k}") for k in (1, 7)]
    solution = fmb.statics(model.with_parts(sensors=noses))
    names = ("t1_strut", "t2_strut", "t2_pendulum", "upper trace", "lower trace")
    forces = np.concatenate([solution[f"inboard_{name} force"][-1, :3] for name in names])
    return forces, np.concatenate([solution[sensor.name][-1] for sensor in noses])


@pytest.mark.slow
def test_outcome_5_16():
    """Nose forces with their correction moment, and the load at its centre of pressure: the same forces in the struts,
    the pendulum and the traces of the elastic system, and the same deflections.

    To first order: on a flap that has turned, the places of both loads have moved differently. So what they differ by
    falls with the square of the load.
    """
    errors = []
    for load in (1.0, 0.1):
        (one, bent), (two, other) = carried(flap("nose"), load), carried(flap("real"), load, "moment")
        assert np.abs(one).max() > 5e2
        errors.append((np.abs(two - one).max(), np.abs(other - bent).max()))
    assert errors[1][0] < 2e-5 * np.abs(one).max()
    assert errors[1][1] < 2e-5 * np.abs(bent).max()
    for large, small in zip(*errors):
        assert small < 0.02 * large


@pytest.mark.slow
def test_outcome_5_17():
    """The deflection of the loaded flap in the elastic system gains with every normal mode, towards that with residual
    vectors of the loads, which further modes do not change."""
    exact = carried(flap("nose", 12), 0.1)[1]
    errors = []
    for modes in (0, 2, 4, 8, 16):
        errors.append(np.abs(carried(flap("nose", modes, residuals=False), 0.1)[1] - exact).max() / np.abs(exact).max())
    assert all(later < sooner for sooner, later in pairwise(errors))
    assert errors[-1] < 0.02 * errors[0]
    few = carried(flap("nose", 2), 0.1)[1]
    assert np.abs(few - exact).max() < 1e-6 * np.abs(exact).max()


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
