"""The flap drive as a control loop of blocks: as the `Motor` while it turns; the brake carries the loads."""

from importlib import util

import numpy as np
import pytest
from highlift_runs import DATA, FOLDER

STALL = DATA["transmission"]["pcu_stall_torque"]


def example():
    spec = util.spec_from_file_location("drive_loop", FOLDER / "drive_loop.py")
    module = util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_the_loop_is_the_motor_and_the_brake_holds():
    found = example().main(turn_time=4.0)
    assert found["difference"] < 1e-7 * found["travel"]
    assert found["torque"] == pytest.approx(found["loads"], rel=1e-5)
    assert found["brake"] == pytest.approx(found["loads"], rel=1e-6)
    assert found["creep"] < 1e-9
    assert found["engaged"] == pytest.approx(4.0, abs=0.05)


@pytest.mark.slow
def test_the_limiter_limits():
    """Loads above the stall torque: the motor gives 250 N m, all that it may, and the shaft falls behind."""
    drive = example()
    ratio = DATA["transmission"]["input_gearbox_ratio"]
    run = drive.extension(drive.with_loop(drive.loaded(4.0, load=1.2 * STALL * ratio / 5)), 1.0, rest=0.0)
    late = run.t > 0.8
    np.testing.assert_allclose(run["motor torque"][late], STALL, rtol=1e-9)
    assert np.abs(run["motor torque"]).max() <= STALL * (1 + 1e-12)
    assert np.all(np.diff(run["pcu angle"][late], 2) < 0.0)
