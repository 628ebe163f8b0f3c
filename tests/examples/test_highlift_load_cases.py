"""Load cases of the high-lift system: a lever that stays behind, a wing that is longer than its flaps.

Reference: the flap angles of the data set over the progress, from which the twist follows; the statement that links
leave the flaps free in spanwise direction.
"""

import runpy

import numpy as np
import pytest
from highlift_runs import CHECK, DATA, FOLDER, RANGE, run, slow_run

CASES = runpy.run_path(str(FOLDER / "load_cases.py"))


@pytest.mark.slow
def test_a_lever_behind_twists_the_flap():
    """Lever 2 behind by 2 %: at progress 0.8 the flap is twisted by the angle that track 2 lacks, 1.6 degrees.

    Slowly and with stiff drives. The torsion of the flap carries it: strut 1 pulls more, strut 2 pushes less.
    """
    stiff = (("track_1_drive_drive_stiffness", 1e10), ("track_2_drive_drive_stiffness", 1e10))
    behind, plain = slow_run(*stiff, ("asymmetry", 0.02)), slow_run(*stiff)
    eta, angle = np.array(CHECK["eta"]), np.array(CHECK["angle_inboard_deg"])
    smooth = np.polynomial.Polynomial.fit(eta, angle, 8)
    lacking = smooth(0.8) - smooth(0.8 * 0.98)
    found = []
    for solution, share in ((behind, 0.98), (plain, 1.0)):
        progress = solution["inboard_t2_lever angle"] / (share * RANGE)
        found.append(np.degrees(np.interp(0.8, progress, solution["inboard_flap_twist"])))
        found.append(np.interp(0.8, progress, solution["inboard_t1_strut force"][:, 0]))
    assert abs(found[0] - found[2]) == pytest.approx(lacking, rel=0.06)
    assert found[1] > 1.3 * found[3]


@pytest.mark.slow
def test_a_warm_wing_does_not_load_the_flaps():
    """A wing longer by 0.1 % (3.6 mm between the tracks): the links lean, forces change by less than 2 %."""
    warm, plain = (CASES["forces"](run("operation", *given)) for given in ((("thermal_strain", 1e-3),), ()))
    for name in ("strut 1 [kN]", "strut 2 [kN]", "pendulum 2 [kN]", "torque 2 [kN m]"):
        assert warm[name] == pytest.approx(plain[name], rel=0.02)
    assert DATA["trailing_edge"]["track_2"]["y"] - DATA["trailing_edge"]["track_1"]["y"] == pytest.approx(3.55)


def test_the_share_of_a_strut():
    """By the two forces at progress 0.8 of a run."""
    solution = run("operation")
    share = CASES["share"](solution)
    assert 1.0 / 6.0 < share < 1.0 / 4.0  # strut 2 carries 3 to 5 times as much
