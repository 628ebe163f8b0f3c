"""The complete wing of the high-lift example: it assembles, nothing is dependent, and every device moves as it does
alone.

Reference: the runs of the parts. They hang on the wing, which stands still, so none may feel the others.
"""

import numpy as np
import pytest
from by_turns import slow
from highlift_runs import DATA, FOLDER, run

import flexmb as fmb

ALONE = {
    "te": ("operation", ("inboard_t2_flap angle", "outboard_t4_flap angle", "inboard_t2_strut force")),
    "nose": ("droop_operation", ("s2_nose angle", "s4_nose angle", "s2_drive strut force", "drive 4 torque")),
}
"""Case of each device, by the prefix in the wing, and sensors that are compared."""


@pytest.mark.parametrize("case", [slow("wing"), "wing_driven"])
def test_the_wing_assembles(case):
    """All parts, no dependent equation, nothing to be moved for it; with and without transmissions."""
    model = fmb.load_model(FOLDER / f"{case}.toml")
    report = fmb.check(model)
    assert not report.redundant
    assert report.mobility == report.gruebler
    assert report.assembly_error < 1e-4  # m, of rollers and teeth
    names = {body.name for body in model.bodies}
    assert {f"slats_s{k}_beam" for k in range(1, 7)} <= names
    assert {f"nose_s{k}_arm" for k in range(1, 6)} <= names
    assert {"te_inboard_t1_lever", "te_outboard_t5_lever"} <= names
    assert ("te_drive_pcu" in names) == (case == "wing_driven")


def test_devices_stand_where_the_data_set_has_them():
    """Interface points in W: joints of the outer tracks, and hinge line and slats along the swept leading edge."""
    model = fmb.load_model(FOLDER / "wing.toml")
    places = {name: np.array(pose.at) for name, pose in model.body("ground").markers.items()}
    track = DATA["trailing_edge"]["outboard_tracks"][2]
    np.testing.assert_allclose(places["te_outboard_t5_A"], track["actuator_axis_in_W"], atol=2e-6)
    frame, sweep = DATA["frames"]["leading_edge"], np.radians(DATA["frames"]["leading_edge"]["sweep_deg"])
    along = np.array([np.sin(sweep), np.cos(sweep), 0.0])
    for k, Y in enumerate(DATA["droop_nose"]["hinge_arm_Y"], 1):
        np.testing.assert_allclose(places[f"nose_s{k}_A"], np.array(frame["origin_in_W"]) + Y * along, atol=1e-9)
    start = places["slats_s6_origin"] - places["slats_s1_origin"]
    np.testing.assert_allclose(start, (DATA["slats"]["start_Y"][5] - DATA["slats"]["start_Y"][0]) * along, atol=1e-9)


@pytest.mark.slow
def test_one_parameter_makes_the_wing_elastic():
    """Flaps, tracks, nose, hinge arms and slats: eighteen elastic bodies."""
    model = fmb.load_model(FOLDER / "wing.toml", {"rigid": False})
    elastic = [body.name for body in model.bodies if body.has_frame and body.n_vector]
    assert len(elastic) == 18
    report = fmb.check(model)
    assert not report.redundant
    assert report.mobility == report.gruebler


@pytest.mark.slow
def test_extension():
    """In one second: every device as alone, the slats at 27 deg.

    Struts vibrate, and alone a device takes other steps: forces are compared by the root mean square of their
    difference.
    """
    solution = run("wing")
    assert solution.status.ok
    assert solution["loop closure"].max() < 1e-6
    for prefix, (case, names) in ALONE.items():
        alone = run(case)
        for name in names:
            difference = solution[f"{prefix}_{name}"] - alone[name]
            if name.endswith("angle"):
                assert np.abs(difference).max() < 1e-4
            else:
                assert np.sqrt(np.mean(difference**2)) < 5e-3 * np.abs(alone[name]).max()
    for k in range(1, 7):
        turn = solution[f"slats_s{k}_t1_pinion angle"][-1] / DATA["slats"]["pinion"]["ratio_pinion_to_slat"]
        assert np.degrees(turn) == pytest.approx(DATA["slats"]["max_angle_deg"], abs=1e-6)


@pytest.mark.slow
def test_extension_with_transmission():
    """The first second at the speed of the real drive: levers and drive unit as without leading edge."""
    settings = {"t_end": 1.0, "samples": 21}
    solution, alone = run("wing_driven", **settings), run("driven", **settings)
    for name in ("inboard_t1_lever angle", "outboard_t5_lever angle", "drive_pcu torque"):
        expected = alone[name]
        np.testing.assert_allclose(solution[f"te_{name}"], expected, atol=5e-3 * np.abs(expected).max(), err_msg=name)
