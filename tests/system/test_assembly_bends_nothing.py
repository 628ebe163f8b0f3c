"""A drawing that leaves gaps: bodies are moved together, elastic ones without a force in them.

Reference: statics. Where nothing is loaded and nothing moves, no joint carries anything.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction


@pytest.fixture(scope="module")
def data():
    points = np.linspace((0, 0, 0), (0.1, 0, 0), 9)
    beam = fem.frame(points, section=fem.Section.rectangle(0.02, 0.02), material=fmb.MATERIALS["steel"])
    return reduction.reduce(beam, {"a": [0], "b": [8]}, modes=6)


@pytest.mark.parametrize("gap", [(1e-3, 0, 0), (0, 0, 1e-3), (5e-7, 5e-7, 0)])
def test_a_part_that_is_drawn_beside_its_seat(data, gap):
    """0.8 kg at the end of a stiff beam: a millimetre bent it by 0.1 um, and it rang with 778 N."""
    mass = fmb.RigidBody("mass", mass=0.8, inertia=(1e-3,) * 3, at=np.add((0.1, 0, 0), gap))
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.FloatingBody("beam", data=data), mass],
        joints=[
            fmb.Fixed("foot", markers=("ground.origin", "beam.a")),
            fmb.Fixed("seat", markers=("beam.b", "mass.center")),
        ],
        sensors=[fmb.Reaction(name, joint=name) for name in ("foot", "seat")],
    )
    solution = fmb.simulate(model, 1e-3, samples=11)
    for name in ("foot", "seat"):
        assert np.abs(solution[name]).max() < 1e-2  # N, N m


def test_what_must_bend_is_bent(data):
    """Two ends held 20 um too far apart: E A d/L, as before."""
    ground = fmb.Ground(markers={"left": (0, 0, 0), "right": (0.10002, 0, 0)})
    model = fmb.Model(
        bodies=[ground, fmb.FloatingBody("beam", data=data)],
        joints=[
            fmb.Fixed("left", markers=("ground.left", "beam.a")),
            fmb.Fixed("r", markers=("ground.right", "beam.b")),
        ],
        sensors=[fmb.Reaction("end", joint="r")],
    )
    with pytest.warns(fmb.ValidityWarning, match="strain the body"):
        rest = fmb.statics(model)
    assert abs(rest["end"][-1, 0]) == pytest.approx(210e9 * 4e-4 * 2e-4, rel=1e-3)
