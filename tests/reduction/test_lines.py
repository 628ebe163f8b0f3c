"""Tracks on lines that nobody put in order: how long they are, where they begin, and what is no line."""

import numpy as np
import pytest
from reduction.solids import block_mesh

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import ReductionError

STEEL = fmb.MATERIALS["steel"]
RADIUS, PIECES = 0.5, 36


def arc(angle, closed=False):
    """A curved beam with the set "rail" of all its nodes, numbered without order."""
    turn = np.linspace(0.0, angle, PIECES + 1)[: PIECES if closed else None]
    along = np.column_stack([RADIUS * np.cos(turn), RADIUS * np.sin(turn), 0.0 * turn])
    number = np.concatenate([[0], 1 + np.random.default_rng(3).permutation(len(turn) - 1)])  # of each place along it
    points = np.empty_like(along)
    points[number] = along
    pairs = np.column_stack([number[:-1], number[1:]])
    pairs = np.vstack([pairs, [number[-1], number[0]]]) if closed else pairs
    fe = fem.frame(
        points,
        connectivity=pairs,
        section=fem.Section.rectangle(0.02, 0.02),
        material=STEEL,
        node_sets={"rail": sorted(number)},
    )
    return fe, number


def track(fe, where):
    held = {"a": "right"} if "right" in fe.node_sets else {"a": [0]}
    data = reduction.reduce(fe, held, 1, loads={"rail": reduction.Track(where)}, compare=0, stress=False)
    return data.quality["tracks"]["rail"]


@pytest.mark.parametrize("angle", [0.5 * np.pi, 1.5 * np.pi, 1.9 * np.pi])
def test_a_curved_track_is_as_long_as_its_arc_and_begins_at_the_lower_number(angle):
    fe, number = arc(angle)
    chords = 2.0 * RADIUS * np.sin(0.5 * angle / PIECES) * np.arange(PIECES + 1)
    for where in ("rail", number.tolist(), fe.nodes[number]):
        found = track(fe, where)
        assert found["nodes"] == number.tolist()
        assert found["places"] == pytest.approx(chords, rel=1e-12)
    backwards = track(fe, fe.nodes[number[::-1]])
    assert backwards["nodes"] == number[::-1].tolist()


def test_an_edge_of_a_solid_is_a_line_with_its_midside_nodes():
    fe = fem.solid(block_mesh(), STEEL)
    assert track(fe, "edge")["places"] == pytest.approx([0.0, 0.015, 0.03, 0.045, 0.06])


def test_what_is_no_line_is_refused_with_what_to_do():
    fe, number = arc(1.5 * np.pi)
    ring, around = arc(2.0 * np.pi, closed=True)
    solid = fem.solid(block_mesh(), STEEL)
    plate = np.array([(x, y, 0.0) for x in np.linspace(0.0, 1.0, 11) for y in (0.0, 0.3)])
    strip = fem.shell(
        fem.Mesh(
            points=plate,
            cells=(("quad", np.array([(2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1) for k in range(10)])),),
            node_sets={"both": np.arange(22), "one": np.arange(0, 22, 2)},
            facet_sets={},
            name="strip",
        ),
        STEEL,
        0.01,
    )
    for match, body, where in [
        ("turns back at node .*in the order in which the load passes", fe, sorted(number.tolist())),
        ("node 5 twice", fe, [5, 6, 7, 5]),
        ("a ring: its ends.*from where the load comes on", ring, "rail"),
        ("spread about node .*contact=", solid, "top"),
        ("in one element, 1[0-9] places apart", strip, "both"),
    ]:
        with pytest.raises(ReductionError, match=match):
            track(body, where)
    assert len(track(ring, around.tolist())["nodes"]) == PIECES  # who says where it begins may go around
    assert track(strip, "one")["places"][-1] == pytest.approx(1.0)


def test_two_rails_in_one_set_are_no_line():
    """Joined at their nearer ends they would make a U."""
    x = np.linspace(0.0, 1.0, 11)
    rails = [np.column_stack([x, 0.0 * x + y, 0.0 * x]) for y in (0.0, 0.3)]
    points = np.vstack([*rails, [(0.0, 0.15, 0.0), (1.0, 0.15, 0.0)]])
    pairs = [(k, k + 1) for k in range(21) if k != 10] + [(0, 22), (22, 11), (10, 23), (23, 21)]
    fe = fem.frame(
        points,
        connectivity=pairs,
        section=fem.Section.rectangle(0.02, 0.02),
        material=STEEL,
        node_sets={"both": range(22), "thinned": [0, 1, 2, 4, 5, 7, 8, 9, 10]},
    )
    with pytest.raises(ReductionError, match=r"a gap of 0\.3 m between node \d+ and node \d+"):
        track(fe, "both")
    assert track(fe, "thinned")["places"][-1] == pytest.approx(1.0)
    assert track(fe, [*range(11), *range(21, 10, -1)])["places"][-1] == pytest.approx(2.3)  # as somebody says


def test_nodes_at_one_place_are_refused():
    fe = fem.frame(
        [(0, 0, 0), (1, 0, 0), (1, 0, 0), (2, 0, 0)],
        connectivity=[(0, 1), (2, 3), (0, 3)],
        section=fem.Section.rectangle(0.02, 0.02),
        material=STEEL,
        node_sets={"rail": [0, 1, 2, 3]},
    )
    for where in ("rail", [0, 1, 2, 3]):
        with pytest.raises(ReductionError, match="node 1 and node 2 at one place"):
            track(fe, where)
