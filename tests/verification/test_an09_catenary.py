"""AN09: an inextensible rope hangs between level supports in a catenary, 2 a sinh(d / 2a) = L.

Reference: closed form. The rope begins as a circular arc of the same length.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

import flexmb as fmb
from flexmb import fem


def test_sag_and_tension(reference):
    case = reference("AN09")
    model, expected = case["model"], case["reference"]
    length, span = model["L"], model["span"]
    half = brentq(lambda a: np.sin(a) / a - span / length, 0.1, 3.0)
    angle, radius = np.linspace(-half, half, 9), 0.5 * length / half
    arc = np.stack([0.5 * span + radius * np.sin(angle), 0.0 * angle, -radius * (np.cos(angle) - np.cos(half))], axis=1)
    ends = ((np.cos(half), 0, -np.sin(half)), (np.cos(half), 0, np.sin(half)))
    area, young = 1e-4, 1e11
    rope = fmb.AncfCable(
        "rope",
        points=arc,
        elements=24,
        tangents=ends,
        straight=True,
        section=fem.Section.values(area, 1e-12, 1e-12, 2e-12),
        markers={"mid": 0.5},
        material=fmb.Material(young=young, poisson=0.3, density=model["mass_per_length"] / area),
    )
    assert rope.curve.length == pytest.approx(length, rel=1e-4)
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(markers={"B": (span, 0, 0)}), rope),
            gravity=(0, 0, -model["g"]),
            joints=(
                fmb.Spherical("A", markers=("ground.origin", "rope.start")),
                fmb.Spherical("B", markers=("ground.B", "rope.end")),
            ),
            sensors=(fmb.Position("mid", marker="rope.mid"), fmb.Reaction("force", joint="A")),
        )
    )
    assert -solution["mid"][-1, 2] == pytest.approx(expected["sag"], rel=1e-3)
    horizontal, vertical = -solution["force"][-1, 0], solution["force"][-1, 2]
    assert horizontal == pytest.approx(expected["H"], rel=5e-3)
    assert np.hypot(horizontal, vertical) == pytest.approx(expected["T_end"], rel=5e-3)
    forces = rope.section_forces(solution.final.q, [0.0, 0.5])[:, 0]
    np.testing.assert_allclose(forces, [expected["T_end"], expected["H"]], rtol=2e-2)
