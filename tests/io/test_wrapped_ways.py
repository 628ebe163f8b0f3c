"""What is drawn of a way over a cylinder: pieces that join, outside the cylinder, as long as the way."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.io.scene import Scene

RADIUS = 0.05


def winch(radius) -> fmb.Solution:
    """Return an arm that turns by a turn and a half about a drum, with a muscle from the ground around the drum."""
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"axis": (0, 0, 0), "o": (0.0, -0.4, 0.1)}),
            fmb.RigidBody("arm", mass=1.0, inertia=(1, 1, 1), markers={"axis": (0, 0, 0), "end": (0.3, 0, 0)}),
        ],
        joints=[
            fmb.Revolute("turn", markers=("ground.axis", "arm.axis")),
            fmb.Drive("drive", joint="turn", angle=fmb.ramp(rate=np.sign(radius) * 3 * np.pi)),
        ],
        forces=[
            fmb.Muscle(
                "m",
                through=("ground.o", "ground.axis", "arm.end"),
                radii=(0, radius, 0),
                excitation=0.5,
                strength=100.0,
                fibre=0.2,
                tendon=0.3,
                tendon_strain=1.0,
            )
        ],
    )
    return fmb.simulate(model, t_end=1.0, samples=41)


def test_pieces_join_and_are_as_long_as_the_way():
    scene = Scene(winch(RADIUS))
    part = scene.part("springs")
    ways = [carrier for carrier in part.carriers if carrier[0] == "way"]
    for frame in (0, 20, 40):
        phase, k = scene.samples[frame]
        maps = [scene._map(carrier, phase) for carrier in ways]
        starts, along = (np.array([m[0][k] for m in maps]), np.array([m[1][k][:, 2] for m in maps]))
        np.testing.assert_allclose(starts[1:], (starts + along)[:-1], atol=1e-12)
        np.testing.assert_allclose(starts[0], (0.0, -0.4, 0.1), atol=1e-12)
        places = starts + np.linspace(0, 1, 9)[:, None, None] * along
        chord = np.linalg.norm(along, axis=1)[0]
        assert np.hypot(places[..., 0], places[..., 1]).min() > RADIUS - 0.13 * chord**2 / RADIUS  # sagitta
        turn = 0.5 * np.pi + 3 * np.pi * scene.times[frame]
        far = np.arccos(RADIUS / 0.4), np.arccos(RADIUS / 0.3)
        plane = np.sqrt(0.4**2 - RADIUS**2) + np.sqrt(0.3**2 - RADIUS**2) + RADIUS * (turn - sum(far))
        whole = np.hypot(plane, 0.1) if turn > sum(far) else np.linalg.norm((0.3, 0.4, 0.1))
        assert np.linalg.norm(along, axis=1).sum() == pytest.approx(whole, rel=2e-2)
        assert np.linalg.norm(along, axis=1).sum() < whole + 1e-12
