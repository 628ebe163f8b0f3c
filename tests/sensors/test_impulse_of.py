"""Impulses of impacts, beside momentum by hand: P = m (1 + e) v of a ball, and the blow on the pin of a rod."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import FlexmbError, ModelError

PAIR = ("ground.origin", "ball.center")
MODEL = """
gravity = [0, 0, -9.81]
[[body]]
name = "ground"
kind = "Ground"
[[body]]
name = "ball"
kind = "PointMass"
mass = 2.0
at = [0, 0, 1]
[[sensor]]
name = "gap"
kind = "Distance"
markers = ["ground.origin", "ball.center"]
along = "z"
[[sensor]]
name = "blow"
kind = "ImpulseOf"
markers = ["ground.origin", "ball.center"]
[[event]]
kind = "Event"
name = "hit"
sensor = "gap"
below = 0.0
repeats = true
[event.then]
kind = "Impact"
markers = ["ground.origin", "ball.center"]
restitution = 0.5
along = "z"
"""


def bouncing(*more):
    """A ball of 2 kg falls from 1 m and keeps half of its speed."""
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), fmb.PointMass("ball", mass=2.0, at=(0, 0, 1.0))],
        sensors=[
            fmb.Distance("gap", markers=PAIR, along="z"),
            fmb.ImpulseOf("blow", markers=PAIR),
            fmb.ImpulseOf("other way", markers=PAIR[::-1]),
            *more,
        ],
        events=[
            fmb.Event("hit", sensor="gap", below=0.0, repeats=True, then=fmb.Impact(PAIR, restitution=0.5, along="z"))
        ],
    )


def test_every_bounce_has_its_impulse():
    """v = sqrt(2 g h) at first, half of it at each later bounce; all other samples are zero."""
    run = fmb.simulate(bouncing(), 1.2, samples=121)
    speed = np.sqrt(2 * 9.81)
    found = run["blow"][run["blow"] != 0.0]
    np.testing.assert_allclose(found, 2 * 1.5 * speed * np.array([1, 0.5, 0.25]), rtol=1e-5)
    np.testing.assert_array_equal(run["other way"], run["blow"])
    assert run.column_titles("blow") == ("impulse [N s]",)
    ends = np.cumsum([len(phase.t) for phase in run.phases])[:3] - 1
    np.testing.assert_array_equal(np.flatnonzero(run["blow"]), ends)
    assert [one.impulse for one in fmb.impulses(run)] == list(found)


def test_the_pin_of_a_rod_takes_its_part(tmp_path):
    """A ball of speed v strikes the end of a free rod on a pin, without rebound: P = v / (1/m + L^2/J), J = M L^2 / 3.

    The pin takes what is left of the rod's momentum, M w L / 2 - P. Kept in the file of the run, and read again.
    """
    M, m, L, v = 3.0, 0.5, 2.0, 4.0
    rod = fmb.RigidBody.rod("rod", length=L, mass=M, radius=1e-3)
    ball = fmb.PointMass("ball", mass=m, at=(L, -1.0, 0), velocity=(0, v, 0))
    pair = ("ball.center", "rod.end")
    model = fmb.Model(
        bodies=[fmb.Ground(), rod, ball],
        joints=[fmb.Revolute("pin", markers=("ground.origin", "rod.start"))],
        sensors=[
            fmb.Distance("gap", markers=pair),
            fmb.ImpulseOf("blow", markers=pair),
            fmb.ImpulseOf("pin", markers=pair, joint="pin"),
        ],
        events=[fmb.Event("hit", sensor="gap", below=1e-9, then=fmb.Impact(pair, restitution=0.0))],
    )
    run = fmb.simulate(model, 0.3, samples=31)
    P = v / (1 / m + L**2 / (M * L**2 / 3))
    assert run["blow"].sum() == pytest.approx(P, rel=1e-5)
    w = P * L / (M * L**2 / 3)
    np.testing.assert_allclose(run["pin"].sum(0)[:3], [0, M * w * L / 2 - P, 0], atol=1e-5)
    assert run.column_titles("pin")[0] == "px [N s]"
    run.save(tmp_path / "run.h5")
    kept = fmb.Solution.load(tmp_path / "run.h5")
    np.testing.assert_array_equal(kept["pin"], run["pin"])
    np.testing.assert_array_equal(kept["blow"], run["blow"])
    with pytest.raises(FlexmbError, match="read without its model"):
        fmb.impulses(kept)
    again = fmb.impulses(fmb.Solution.load(tmp_path / "run.h5", model=[phase.model for phase in run.phases]))
    assert [one.impulse for one in again] == [one.impulse for one in fmb.impulses(run)]


def test_of_a_model_file(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(MODEL)
    run = fmb.simulate(fmb.load_model(path), 0.6, samples=7)
    assert run["blow"].max() == pytest.approx(3.0 * np.sqrt(2 * 9.81), rel=1e-5)


def test_names_are_looked_up():
    with pytest.raises(ModelError, match=r"Sensor 'bad'.*ball\.centre"):
        fmb.simulate(bouncing(fmb.ImpulseOf("bad", markers=("ground.origin", "ball.centre"))), 0.1)
    with pytest.raises(ModelError, match=r"Sensor 'bad'.*hinge"):
        fmb.simulate(bouncing(fmb.ImpulseOf("bad", markers=PAIR, joint="hinge")), 0.1)
