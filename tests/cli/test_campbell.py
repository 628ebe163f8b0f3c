"""`flexmb campbell`: a disc on soft supports beside its closed form; what cannot be asked."""

import csv

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli import main

A, C, MASS, K, TILT = 0.1, 0.18, 10.0, 4e5, 3e3
"""Moments across and along, kg m2; mass, kg; stiffness of the supports, N/m and N m."""

ROTOR = f"""
[parameters]
speed = 100.0

[[body]]
kind = "Ground"
markers = {{ o = [0, 0, 0] }}

[[body]]
kind = "RigidBody"
name = "hub"
mass = 1e-3
inertia = [1e-6, 1e-6, 1e-6]
markers = {{ o = [0, 0, 0] }}

[[body]]
kind = "RigidBody"
name = "disc"
mass = {MASS}
inertia = [{A}, {A}, {C}]
markers = {{ o = [0, 0, 0] }}

[[joint]]
kind = "Revolute"
name = "bearing"
markers = ["hub.o", "disc.o"]

[[joint]]
kind = "Drive"
name = "spin"
joint = "bearing"
angle = "= speed*t"

[[force]]
kind = "Bushing"
name = "support"
markers = ["ground.o", "hub.o"]
stiffness = [{K}, {K}, 4e7, {TILT}, {TILT}, 1e5]
"""


@pytest.fixture
def rotor(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rotor.toml").write_text(ROTOR)
    return tmp_path


def whirl(speed):
    """A w^2 -+ C W w - K = 0: forward and backward whirl of a disc that tilts, rad/s."""
    root = np.sqrt((C * speed) ** 2 + 4.0 * A * TILT)
    return np.array([root + C * speed, root - C * speed]) / (2.0 * A)


def test_a_disc_on_soft_supports(rotor, capsys):
    """Seen from the casing an unbalance meets sqrt(k/m), and backward whirl its own speed at sqrt(K/(A + C))."""
    assert main(["campbell", "rotor.toml", "--over", "speed=0:400:41", "--modes", "4", "-o", "plots/c.png"]) == 0
    printed = capsys.readouterr().out
    assert "observed from W" in printed
    found = [
        line.split(" at ")[1].split(" rad/s, ") for line in printed.splitlines() if line.startswith("Order 1: mode")
    ]
    expected = np.sort([np.sqrt(TILT / (A + C)), np.sqrt(K / MASS), np.sqrt(K / MASS)])
    np.testing.assert_allclose([float(speed) for speed, _ in found], expected, rtol=1e-3)  # by line between speeds
    np.testing.assert_allclose(
        [float(rpm.removesuffix(" rpm")) for _, rpm in found], expected * 30.0 / np.pi, rtol=1e-3
    )
    assert (rotor / "plots/c.png").read_bytes().startswith(b"\x89PNG")
    titles, *rows = csv.reader((rotor / "plots/c.csv").open())
    assert titles[:3] == ["speed [rad/s]", "frequency 1 [Hz]", "damping ratio 1"]
    for speed, *numbers in np.array(rows, float):
        across = np.sqrt(K / MASS)
        np.testing.assert_allclose(
            np.sort(numbers[::2]) * 2.0 * np.pi, np.sort([*whirl(speed), across, across]), rtol=1e-4
        )
        np.testing.assert_allclose(numbers[1::2], 0.0, atol=1e-9)


def test_an_order_that_nothing_meets(rotor, capsys):
    assert main(["campbell", "rotor.toml", "--over", "speed=0:20:3", "--order", "0.5", "-o", "c.svg"]) == 0
    assert "Order 0.5: no critical speed between these" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--over", "speed=0:400"], "NAME=START:STOP:COUNT"),
        (["--over", "sped=0:400:5"], "Did you mean 'speed'?"),
        (["--over", "speed=400:0:5"], "5 speeds from 400 to 0 rad/s"),
        (["--over", "speed=0:400:5", "--set", "speed=3"], "--set speed beside it"),
        (["--over", "speed=0:20:3", "--modes", "0"], "--modes 0"),
        (["--over", "speed=0:20:3", "-o", "c.xyz"], "the ending '.xyz'"),
    ],
)
def test_what_cannot_be_asked(rotor, capsys, arguments, told):
    assert main(["campbell", "rotor.toml", *arguments]) != 0
    assert told in capsys.readouterr().err


def test_a_change_of_the_observer_is_told(rotor):
    """A hub without mass lets the disc's own axes do, a heavier one needs those of the casing."""

    def model(speed):
        share = 1.0 if speed > 50.0 else 1e-3
        light = {"mass": 1e-3 * share, "inertia": (1e-6 * share,) * 3}
        return fmb.load_model("rotor.toml", {"speed": speed}).changed("hub", **light)

    with pytest.warns(fmb.ValidityWarning, match=r"each body from 20 rad/s on; W from 60 rad/s on"):
        fmb.campbell(model, [0.0, 20.0, 40.0, 60.0, 80.0], modes=2)
