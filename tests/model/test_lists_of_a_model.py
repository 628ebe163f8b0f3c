"""Each list of a model takes parts of its own family, and names what belongs elsewhere."""

import pytest

import flexmb as fmb

STONE = fmb.PointMass("stone", mass=1.0)
BETWEEN = {"markers": ("ground.origin", "stone.center")}
PARTS = {
    "bodies": fmb.PointMass("other", mass=1.0),
    "surfaces": fmb.Surface("ball", marker="stone.center", shape=fmb.Sphere(0.1)),
    "joints": fmb.Spherical("joint", **BETWEEN),
    "forces": fmb.SpringDamper("spring", **BETWEEN, stiffness=1.0, length=0.1),
    "sensors": fmb.Distance("distance", **BETWEEN),
    "events": fmb.Event("event", at=0.1, then=fmb.Stop()),
}


@pytest.mark.parametrize("place", PARTS)
@pytest.mark.parametrize("kind", PARTS)
def test_a_part_belongs_into_one_list(place, kind):
    """A sensor called Distance stood among the joints and ended `check` with an AttributeError."""
    bodies = [fmb.Ground(), STONE]
    parts = {"bodies": bodies, place: [*(bodies if place == "bodies" else ()), PARTS[kind]]}
    if place == kind:
        assert PARTS[kind] in getattr(fmb.Model(**parts), place)
        return
    with pytest.raises(fmb.ModelError) as told:
        fmb.Model(**parts)
    assert f"{place} holds {PARTS[kind].title}, a {type(PARTS[kind]).__name__}" in str(told.value)
    assert f"Put it into {kind}=[...]" in str(told.value)
