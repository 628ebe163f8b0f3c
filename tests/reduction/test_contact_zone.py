"""Attachment modes for contacts: the dent under a patch load as in the full model and in CalculiX."""

from dataclasses import replace

import numpy as np
import pytest
from by_turns import slow
from reduction.solids import STEEL, block_mesh

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import ReductionError

SIZE = (0.06, 0.06, 0.03)
CALCULIX = {"middle": 7.443713e-6, "beside": 7.598579e-6}
"""m, CalculiX 2.20 with the same mesh (C3D10), clamped below, 100 MPa on a square of 20 mm: sink of the node in its
middle, for squares at x = 30 mm and 40 mm."""


@pytest.fixture(scope="module")
def fe():
    mesh = block_mesh(SIZE, (6, 6, 3))
    x, top = mesh.points, mesh.facet_sets["top"]
    centre = x[top[:, :3]].mean(axis=1)
    near = {name: np.abs(centre[:, :2] - at).max(axis=1) < 0.01 for name, at in PLACES.items()}
    sets = {**mesh.facet_sets, **{name: top[own] for name, own in near.items()}}
    below = {"bottom": np.flatnonzero(x[:, 2] < 1e-9)}
    return fem.solid(replace(mesh, node_sets=below, facet_sets=sets), STEEL)


PLACES = {"middle": (0.03, 0.03), "beside": (0.04, 0.03)}


def sink(fe, name, **options):
    """Return how far the middle of the pressed square sinks, m, and the data."""
    node = int(np.argmin(np.linalg.norm(fe.nodes - (*PLACES[name], SIZE[2]), axis=1)))
    data = reduction.reduce(
        fe,
        {"bottom": "bottom"},
        12,
        stations={"there": [node]},
        loads={"press": name},
        compare=0,
        stress=False,
        **options,
    )
    model = fmb.Model(
        gravity=(0, 0, 0),
        bodies=[fmb.Ground(markers={"o": tuple(data.marker_positions[0])}), fmb.FloatingBody("b", data=data)],
        joints=[fmb.Fixed("hold", markers=("ground.o", "b.bottom"))],
        forces=[fmb.Pressure("p", load="b.press", amount=1e8)],
        sensors=[fmb.Position("r", marker="b.there")],
    )
    return SIZE[2] - fmb.statics(model)["r"][-1, 2], data


@pytest.mark.parametrize("name", [slow(name) if name == "beside" else name for name in PLACES])
def test_dent_under_a_patch(fe, name):
    """With twelve normal modes alone the surface is three times too stiff; with the zone within half a percent."""
    without, _ = sink(fe, name)
    found, data = sink(fe, name, contact="top")
    assert without == pytest.approx(0.32 * CALCULIX[name], rel=0.01)
    assert found == pytest.approx(CALCULIX[name], rel=5e-3)
    zone = data.quality["contact"]["top"]
    assert zone["patches"] == 72
    assert data.n_modes == 12 + zone["shapes"]
    assert zone["missing"] < 0.01
    assert zone["missing_before"] > 0.5
    assert "  top              72 facets: " in data.report()


def test_rest_chooses_how_many(fe):
    """Fewer shapes for a larger rest, all that there are for none, and none for all."""
    counts = []
    for rest in (1.0, 0.1, 1e-3, 1e-5):
        found, data = sink(fe, "middle", contact=reduction.ContactZone("top", rest=rest))
        counts.append(data.quality["contact"]["top"]["shapes"])
    assert counts[0] == 0
    assert counts == sorted(counts)
    assert counts[-1] == 72
    assert found == pytest.approx(CALCULIX["middle"], rel=5e-4)


def test_loads_that_the_zone_holds_already(fe):
    """A residual vector that is a sum of patch loads adds nothing, and two that are alike count once."""
    whole = reduction.ContactZone("top", rest=0.0)
    found, data = sink(fe, "middle", contact=whole, residual_vectors=("press",))
    assert data.n_modes == 12 + 72
    assert found == pytest.approx(CALCULIX["middle"], rel=5e-4)


@pytest.mark.parametrize(
    ("contact", "message"),
    [
        ("roof", "Contact 'roof'.*does not exist.*top"),
        (3.0, "name of a facet set"),
        (["top", ""], "name of a facet set"),
    ],
)
def test_refused(fe, contact, message):
    with pytest.raises(ReductionError, match=message):
        reduction.reduce(fe, {"bottom": "bottom"}, 2, contact=contact)


def test_rest_is_a_share():
    with pytest.raises(ReductionError, match=r"rest = 2\.0"):
        reduction.ContactZone("top", rest=2.0)
