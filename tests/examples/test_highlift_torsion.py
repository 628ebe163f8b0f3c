"""High-lift system: what the torsional stiffness of the inboard flap does to the share of its drive struts.

Reference: one statically indeterminate torque by the method of forces, with yields of the drives from the torques,
forces and angles of the data set.
"""

import runpy
from functools import cache

import numpy as np
import pytest
from highlift_runs import CHECK, DATA, FOLDER

SYSTEMS = ("parts, rigid tracks", "parts, elastic tracks", "elastic flap, rigid tracks")
TORSION = runpy.run_path(str(FOLDER / "torsion.py"))


@cache
def found(name):
    return TORSION["main"]({name: TORSION["SYSTEMS"][name]})[name]


@pytest.mark.slow
def test_two_equilibria_tell_all_others():
    """A bar between two ends that yield: shares over G J from a fiftieth to four times the shipped one."""
    for name in SYSTEMS:
        for stiffness, share in found(name)["computed"].items():
            assert found(name)["estimated"][stiffness] == pytest.approx(share, abs=4e-4), (name, stiffness)


@pytest.mark.slow
def test_the_effect_on_rigid_tracks_by_hand():
    """a = d theta/d l of each end from the data set; yields a^2/k, free twist (a2 F2 - a1 F1)/k."""
    wing, k = DATA["trailing_edge"], CHECK["eta"].index(0.8)
    angle = np.radians(np.gradient(CHECK["angle_inboard_deg"], 0.1)[k])
    forces = np.abs([CHECK["drive_strut_1"][k], CHECK["drive_strut_2"][k]])
    torques = np.array([CHECK["actuator_torque_1"][k], -CHECK["actuator_torque_2"][k]])
    ranges = np.radians([wing[f"track_{n}"]["drive"]["lever_range_deg"] for n in (1, 2)])
    a = angle * forces / (torques * ranges)
    yields = np.sum(a**2) / wing["track_1"]["drive"]["drive_stiffness"]
    twist = (a[1] * forces[1] - a[0] * forces[0]) / wing["track_1"]["drive"]["drive_stiffness"]
    system = found(SYSTEMS[0])
    assert abs(system["d0"]) == pytest.approx(twist, rel=0.05)
    assert system["c"] == pytest.approx(yields, rel=0.15)
    length = wing["track_2"]["y"] - wing["track_1"]["y"]
    torque = [twist / (yields + length / GJ) for GJ in (1.05e5, 2.1e6)]
    one, two = (forces[0] + a[0] * t for t in torque), (forces[1] - a[1] * t for t in torque)
    low, high = (f / (f + g) for f, g in zip(one, two))
    computed = system["computed"]
    assert high - low == pytest.approx(computed[2.1e6] - computed[1.05e5], rel=0.08)


@pytest.mark.slow
def test_the_elasticity_of_the_flap_does_not_matter():
    """On rigid tracks the share of an elastic flap grows with G J as that of parts; on elastic tracks by less."""
    parts, tracks, flap = (found(name)["computed"][2.1e6] - found(name)["computed"][1.05e5] for name in SYSTEMS)
    assert flap == pytest.approx(parts, rel=0.1)
    assert tracks < 0.5 * parts
