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
    "number of NumPy": np.int64(0),
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
    "a node twice in a list": ([2, 0, 0], r"three node numbers or a place.*Write \[0, 2\] for nodes, or \(2.0, 0.0, 0"),
    "a node twice in an array": (np.array([2, 0, 0]), r"nodes = \(2, 0, 0\), three node numbers or a place"),
    "a node twice, no node at the place": ([3, 1, 1], r"nodes = \(3, 1, 1\), three node numbers or a place"),
    "whole places": ([(2, 0, 0)], r"Write coordinates with a decimal point, \(2\.0, 0\.0, 0\.0\)"),
    "floats for numbers": (np.array([0.0, 4.0]), r"Node numbers are whole numbers.*numbers\.astype\(int\)"),
    "three floats for numbers": (np.array([0.0, 4.0, 2.0]), r"no node at .*for node numbers.*numbers\.astype\(int\)"),
    "no directions": ({"start": None}, "set 'start': directions None.*Write \"xyzrxryrz\" for all six"),
    "no directions of a number": ({"end": "x", 0: None}, "nodes 0: directions None"),
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


def test_three_whole_numbers_of_one_node(rod):
    """Functions of one node read a place with a decimal point, or a tuple for a new node, and numbers otherwise."""
    at_end = fem.with_mass(rod, 4, 3.0).M
    for node in ("end", ["end"], [4], np.array([4]), (2.0, 0, 0), [2.0, 0.0, 0.0], [(2.0, 0.0, 0.0)]):
        assert abs(fem.with_mass(rod, node, 3.0).M - at_end).max() == 0.0
        spring = fem.with_spring(rod, node, [1e5] * 6)
        assert abs(spring.K - fem.with_spring(rod, 4, [1e5] * 6).K).max() == 0.0
    for node in ([2, 0, 0], (2, 0, 0), np.array([2, 0, 0])):
        for act in (lambda where: fem.with_mass(rod, where, 3.0), lambda where: fem.with_spring(rod, where, [1.0] * 6)):
            with pytest.raises(MeshError, match=r"\(2, 0, 0\), three node numbers or a place.*or \(2.0, 0.0, 0.0\)"):
                act(node)
    with pytest.raises(MeshError, match=r"\[0, 1, 3\] has 3 nodes.*with a decimal point"):
        fem.with_mass(rod, [0, 1, 3], 3.0)


def test_the_reference_of_a_link(rod):
    for reference in ((2, 0, 1), [2.0, 0.0, 1.0], np.array([2.0, 0.0, 1.0])):
        linked = fem.with_rigid_link(rod, reference, "end", "hub")
        assert linked.nodes[linked.node_sets["hub"]].tolist() == [[2.0, 0.0, 1.0]]
    for reference in ("start", ["start"], [0], 0):
        assert len(fem.with_rigid_link(rod, reference, "end").nodes) == 5
    for link in (fem.with_rigid_link, fem.with_averaging_link):
        with pytest.raises(MeshError, match=r"\(2, 0, 0\), three node numbers or a place"):
            link(rod, [2, 0, 0], "end")
        for wrong in ((0.0, 1.0), (1, 2), (0.0, np.nan, 0.0)):
            with pytest.raises(MeshError, match=r"a new node at .*Expected: its coordinates x, y, z, m"):
                link(rod, wrong, "end")


def test_no_places_at_all(rod):
    """An empty list of places is an empty list of nodes."""
    for wrong in (np.zeros((0, 2)), np.zeros((0, 3, 3))):
        with pytest.raises(MeshError, match="Expected: names of node sets, node numbers, or the coordinates"):
            fem.fixed_freedoms(rod, wrong)
    assert not fem.fixed_freedoms(rod, np.zeros((0, 3), int)).any()
    empty = np.zeros((0, 3))
    assert not fem.fixed_freedoms(rod, empty).any()
    assert fem.with_supports(rod, empty).ndof == rod.ndof
    for link in (fem.with_rigid_link, fem.with_averaging_link):
        with pytest.raises(MeshError, match=r"no nodes|0 node"):
            link(rod, 0, empty)


def test_a_repeated_number_in_a_reduction(rod):
    """As an interface, [2, 0, 0] held nodes 0 and 2 together, and (2, 0, 0) the node at the end."""
    for where in ([2, 0, 0], np.array([2, 0, 0])):
        with pytest.raises(ReductionError, match=r"Interface 'a': .*three node numbers or a place.*\(2.0, 0.0, 0.0\)"):
            reduction.reduce(rod, {"a": where}, modes=0)


def test_two_nodes_at_one_place(rod):
    """Before, the lower number was held without a word."""
    both, place = fem.with_node(rod, (LENGTH, 0.0, 0.0)), (LENGTH, 0.0, 0.0)
    words = r"2 nodes at .* m: node 4, node 5\. Expected: .* one node\. Write their numbers, \[4, 5\]"
    for act in (
        lambda: fem.fixed_freedoms(both, place),
        lambda: fem.with_supports(both, {place: "x"}),
        lambda: fem.with_supports(both, [place]),
        lambda: fem.with_mass(both, place, 1.0),
        lambda: fem.with_rigid_link(both, 0, place),
    ):
        with pytest.raises(MeshError, match=words):
            act()
    with pytest.raises(ReductionError, match=r"2 nodes at .* m: node 4, node 5\. .*Write their numbers, \[4, 5\]"):
        reduction.reduce(both, {"a": 0, "b": place}, modes=0)


def test_a_place_where_one_node_carries_the_other(rod):
    """A link takes the freedoms of the end: the place is that of the node it hangs on."""
    linked = fem.with_rigid_link(rod, (LENGTH, 0.0, 0.0), "end", "foot")
    held = fem.fixed_freedoms(linked, (LENGTH, 0.0, 0.0))
    assert set(linked.dofs[held, 0]) == set(linked.node_sets["foot"].tolist()) == {5}
    data = reduction.reduce(linked, {"a": "start", "b": (LENGTH, 0.0, 0.0)}, modes=0)
    assert data.marker_positions[1] == pytest.approx([LENGTH, 0.0, 0.0])
