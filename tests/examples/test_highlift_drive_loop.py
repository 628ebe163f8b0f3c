"""The flap drive as a control loop of blocks: as the `Motor` while it turns; the brake carries the loads."""

from importlib import util

import numpy as np
import pytest
from highlift_runs import DATA, FOLDER

import flexmb as fmb
from flexmb.integrate.runs.added_error import ADDED_UP

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


@pytest.mark.slow
def test_errors_of_a_fast_extension_are_not_told_where_there_are_none():
    """Half a second, with new starts where the target bends: stiff bushings, of up to 28 rad a step, shook the
    estimate of the errors. 0.022 m of a wheel were told, 111 % of its motion; a tenth of the tolerance changes nothing.
    """
    model = example().loaded(0.5)
    runs = [
        fmb.simulate(model, 0.52, samples=53, integrator=fmb.GeneralizedAlpha(rtol=rtol, largest=0.01))
        for rtol in (1e-6, 1e-7)
    ]
    assert max(run.statistics[ADDED_UP] for run in runs) < 0.02
    assert not any(run.statistics.get("warnings") for run in runs)
    angles = [run["s5_input angle"] for run in runs]
    assert np.abs(angles[0] - angles[1]).max() < 1e-5 * np.abs(angles[0]).max()
