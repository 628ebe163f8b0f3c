"""GS06: frequencies of a rotating square cantilever plate (Yoo & Chung 2001, recomputed by Ritz), shell elements.

The clamped edge holds back the lateral contraction of the stretched plate. A body frame that turns against that edge
(Buckens) needs the geometric stiffness of the rigid coupling to give the frequencies of the frame clamped there.
"""

from dataclasses import replace

import numpy as np
import pytest
from fem.beams import plate
from verification.rotating_beams import angular_frequencies

import flexmb as fmb
from flexmb import fem, reduction

THICKNESS = 0.005


def body(frame):
    """Unit plate in the x-z plane with D = rho t = 1, clamped at x = 0."""
    material = fmb.Material(young=12 * (1 - 0.3**2) / THICKNESS**3, poisson=0.3, density=1 / THICKNESS)
    mesh = plate(10, 10, 1.0, 1.0, "quad")
    fe = fem.shell(replace(mesh, points=mesh.points[:, [0, 2, 1]]), material, THICKNESS)
    edge = np.flatnonzero(np.abs(fe.nodes[:, 0]) < 1e-9)
    data = reduction.reduce(fe, {"root": edge}, 15, frame=frame, geometric_stiffness=True, stress=False)
    return fmb.FloatingBody("plate", data=data, at=(0, 0, -0.5))  # its root is the middle of the edge


@pytest.mark.parametrize("frame", ["buckens", "root"])
def test_frequencies(reference, frame):
    plate = body(frame)
    for radius in (0.0, 1.0):
        for speed in (0.0, 1.0, 5.0, 10.0):
            expected = reference("GS06")["reference"][f"hub={radius},gamma={speed}"]
            np.testing.assert_allclose(angular_frequencies(plate, speed, radius=radius)[:5], expected, rtol=0.01)
