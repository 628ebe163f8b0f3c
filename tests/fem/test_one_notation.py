"""Supports and links name nodes in one notation; what could be read in two ways is refused.

Reference: a rod, one end held, stretched by F: u = F L / (E A).
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import MeshError, ReductionError

YOUNG, WIDTH, LENGTH, FORCE = 70e9, 0.02, 2.0, 300.0
STRETCH = FORCE * LENGTH / (YOUNG * WIDTH**2)
ALL = "xyzrxryrz"


@pytest.fixture(scope="module")
def rod():
    return fem.frame(
        points=np.linspace((0.0, 0.0, 0.0), (LENGTH, 0.0, 0.0), 5),
        section=fem.Section.rectangle(WIDTH, WIDTH),
        material=fmb.Material(young=YOUNG, poisson=0.3, density=2700.0),
    )


def pull(fe):
    field = np.zeros((len(fe.nodes), 6, 1))
    field[4, 0] = FORCE
    return fe.forces(field)[:, 0]


SAME = {
    "set": "start",
    "sets": ["start", "start"],
    "number": 0,
    "numbers": [0],
    "array": np.array([0]),
    "place": (0.0, 0.0, 0.0),
    "places": [(0.0, 0.0, 0.0)],
    "set to directions": {"start": ALL},
    "number to directions": {0: range(6)},
    "place to directions": {(0.0, 0.0, 0.0): ALL},
    "one after the other": {"start": "xyz", 0: "rxryrz"},
}


@pytest.mark.parametrize("fixed", SAME.values(), ids=SAME.keys())
def test_fixed_and_with_supports_read_the_same(rod, fixed):
    u = rod.field(fem.static(rod, pull(rod), fixed)[:, None])[4, 0, 0]
    assert u == pytest.approx(STRETCH, rel=1e-9)
    held = fem.with_supports(rod, fixed)
    u = held.field(fem.static(held, pull(held), None)[:, None])[4, 0, 0]
    assert u == pytest.approx(STRETCH, rel=1e-9)


def test_a_mask_and_supports_of_all_nodes(rod):
    mask = rod.dofs[:, 0] == 0
    assert np.array_equal(fem.with_supports(rod, mask).dofs, rod.dofs[~mask])
    assert np.array_equal(np.unique(fem.with_supports(rod, directions="zrxry").dofs[:, 1]), [0, 1, 5])


def test_a_place_is_no_node_number(rod):
    """Before, fixed=(2.0, 0, 0) held nodes 0 and 2, and [0.5] nothing, without a word."""
    held = fem.fixed_freedoms(rod, (LENGTH, 0.0, 0.0))
    assert np.array_equal(np.unique(rod.dofs[held, 0]), [4])


WRONG = {
    "half a node": ([0.5], r"nodes = \[0.5\]. Expected: names of node sets, node numbers, or the coordinates"),
    "a place without a node": ((0.3, 0.0, 0.0), r"no node at \[0.3, 0.0, 0.0\] m; the nearest, .* is 0.2 m away"),
    "a negative number": (-1, "node -1 does not exist. Expected: node numbers 0 to 4"),
    "rows of different lengths": ([[0, 1], [2]], "Expected: names of node sets, node numbers"),
    "a misspelt set": (["start", "edn"], "'edn' does not exist. One of: end, start. Did you mean 'end'"),
    "a node twice": ((2, 0, 0), r"three node numbers or a place.*Write \[0, 2\] for nodes, or \(2.0, 0.0, 0.0\)"),
    "directions twice": ({"start": "xw"}, "set 'start': directions 'xw'"),
    "directions of a number": ({0: "xw"}, "nodes 0: directions 'xw'"),
}


@pytest.mark.parametrize(("fixed", "words"), WRONG.values(), ids=WRONG.keys())
def test_both_refuse_the_same(rod, fixed, words):
    with pytest.raises(MeshError, match=words):
        fem.static(rod, pull(rod), fixed)
    with pytest.raises(MeshError, match=words):
        fem.with_supports(rod, fixed)


def test_directions_beside_a_mapping(rod):
    with pytest.raises(MeshError, match="directions 'x' beside a mapping"):
        fem.with_supports(rod, {"start": "y"}, "x")


def test_three_whole_numbers(rod):
    """Nodes in supports; in a reduction, where a tuple is a place, refused where they may be nodes."""
    three = fem.fixed_freedoms(rod, (0, 1, 3))
    assert np.array_equal(np.unique(rod.dofs[three, 0]), [0, 1, 3])
    far = fem.frame(
        points=[(0, 1, 2), (0, 3, 4), (1, 5, 6)],
        section=fem.Section.rectangle(1.0, 1.0),
        material=fmb.Material(young=1e9, poisson=0.3, density=1.0),
    )
    with pytest.raises(MeshError, match=r"\(0, 1, 2\), three node numbers or a place"):
        fem.with_supports(far, (0, 1, 2))
    with pytest.raises(
        ReductionError, match=r"Interface 'a': \(0, 1, 2\), three nodes or a place.*Write \[0, 1, 2\] for"
    ):
        reduction.reduce(far, {"a": (0, 1, 2)}, modes=0)
    with pytest.raises(ReductionError, match=r"Station 's': \(0, 1, 2\), three nodes or a place"):
        reduction.reduce(rod, {"a": "start"}, modes=0, stations={"s": (0, 1, 2)})
    assert reduction.reduce(rod, {"a": "start", "b": (2, 0, 0)}, modes=0).marker_positions[1].tolist() == [
        2.0,
        0.0,
        0.0,
    ]


@pytest.mark.parametrize("modes", [0, 3])
@pytest.mark.parametrize("other", [None, "end", reduction.Averaging("end"), reduction.Nodes("end")], ids=str)
@pytest.mark.parametrize("plane", [False, True])
def test_count_of_coordinates(rod, plane, other, modes):
    """nq + modes - r: 6 freedoms of an interface and 6 rigid motions in space, 3 and 3 in a plane."""
    fe = fem.with_supports(rod, directions="zrxry") if plane else rod
    data = reduction.reduce(fe, {"a": "start"} | ({} if other is None else {"b": other}), modes=modes)
    each = 3 if plane else 6
    assert data.n_modes == each * (1 if other is None else 2) + modes - each
    assert data.quality["rigid_modes"]["removed"] == each
