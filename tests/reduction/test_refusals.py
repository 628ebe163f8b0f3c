"""What cannot be reduced is refused with a message that names the place and the remedy."""

from dataclasses import replace

import numpy as np
import pytest
from reduction.beams import planar_beam
from reduction.solids import STEEL, block, block_mesh
from scipy import sparse

from flexmb import fem, reduction
from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.links.links import with_rigid_link

BOTH = {"a": "left", "b": "right"}


@pytest.fixture(scope="module")
def fe():
    return block()


def assert_refused(match, fe, interfaces=None, **options):
    with pytest.raises(ReductionError, match=match):
        reduction.reduce(fe, BOTH if interfaces is None else interfaces, **options)


def test_unknown_group(fe):
    assert_refused(
        r"Interface 'a': the group 'lefft' does not exist in FE model 'block'\. One of: edge, left, mid, right, "
        r"skin, top\. Did you mean 'left'\?",
        fe,
        {"a": "lefft"},
    )


def test_unknown_group_of_a_station(fe):
    assert_refused(r"Station 's': the group 'middle' does not exist", fe, stations={"s": "middle"})


def test_overlapping_interfaces(fe):
    mixed = [*fe.node_set("left")[:4].tolist(), *fe.node_set("right").tolist()]
    assert_refused(
        r"Interfaces 'a' and 'c': 4 common nodes, first node \d+\..*Shrink one", fe, {"a": "left", "c": mixed}
    )


def test_empty_set(fe):
    model = replace(fe, node_sets={**fe.node_sets, "none": np.zeros(0, int)})
    assert_refused(
        r"Interface 'a': the selection 'none' has no nodes\. Expected: at least one node\. Check the group",
        model,
        {"a": "none"},
    )


@pytest.mark.parametrize("kind", [reduction.Rigid, reduction.Averaging])
def test_collinear_set(fe, kind):
    assert_refused(
        r"Interface 'a': \d+ collinear nodes without rotational freedoms: no rotation y.*off the line",
        fe,
        {"a": kind("edge"), "b": "right"},
    )


@pytest.mark.parametrize("kind", [reduction.Rigid, reduction.Averaging])
def test_single_node_of_a_solid(fe, kind):
    assert_refused(
        r"a single node without rotational freedoms: no rotation x, rotation y, rotation z",
        fe,
        {"a": kind([3])},
    )


def test_node_numbers_out_of_range(fe):
    assert_refused(rf"Interface 'a': node number 100000\. Expected: 0 to {len(fe.nodes) - 1}", fe, {"a": [0, 100000]})


def test_selection_of_another_kind(fe):
    assert_refused(
        r"Interface 'a': \['x', 3\]\. Expected: a set name, node numbers \(int\) or coordinates", fe, {"a": ["x", 3]}
    )


def test_coordinates_without_a_node(fe):
    assert_refused(
        r"Interface 'a': no node at \(0\.2, 0\.5, 0\.0\) m; the nearest is node \d+ at .*as a station",
        fe,
        {"a": (0.2, 0.5, 0.0)},
    )


def test_weights_of_an_averaging_interface(fe):
    assert_refused(
        r"weights of shape \(2,\).*positive weights",
        fe,
        {"a": reduction.Averaging("left", weights=[1.0, 2.0])},
    )


def test_more_modes_than_freedoms():
    fe = planar_beam(n_el=3)
    assert_refused(
        r"FE model 'planar beam': 5 fixed-interface modes asked for\. Expected: at most 4, the freedoms with mass",
        fe,
        modes=5,
    )
    assert reduction.reduce(fe, BOTH, modes=4).n_modes == 4 + 4 - 2


def test_more_modes_than_masses():
    """Only two inner freedoms carry mass: three modes are one too many, although three freedoms more are there."""
    fe = planar_beam(n_el=3)
    lumped = sparse.diags(np.where(fe.dofs[:, 1] == 1, 1.0, 0.0)).tocsr()
    assert_refused(
        r"3 fixed-interface modes asked for\. Expected: at most 2, the freedoms with mass",
        replace(fe, M=lumped),
        modes=3,
    )


@pytest.mark.parametrize("modes", [-1, 2.5, True, "up to 200", "up to 1.2.3 Hz", "up to e Hz", "many", None])
def test_unreadable_mode_choice(fe, modes):
    assert_refused(r"Reduction: modes = .*a count, or a text like 'up to 200 Hz within 1 %'", fe, modes=modes)


@pytest.mark.parametrize(
    ("values", "match"),
    [((-1.0,), r"frequency = -1\.0 Hz"), ((1e308,), "up to 1e\\+12 Hz"), ((200.0, 0.0), r"accuracy = 0\.0")],
)
def test_accuracies_that_no_body_has_are_refused(values, match):
    with pytest.raises(ReductionError, match=match):
        reduction.UpTo(*values)


def test_disconnected_parts():
    bar = planar_beam(n_el=4)
    fe = FEModel(
        nodes=np.vstack([bar.nodes, bar.nodes + [3, 0, 0]]),
        name="two bars",
        dofs=np.vstack([bar.dofs, bar.dofs + [5, 0]]),
        K=sparse.block_diag([bar.K, bar.K]).tocsr(),
        M=sparse.block_diag([bar.M, bar.M]).tocsr(),
    )
    assert_refused(
        r"FE model 'two bars': 2 parts that are not connected; the smallest has 5 nodes, e\.g\. node \d+ at "
        r"\([03], 0, 0\) m\. Expected: one connected part\. Merge duplicate nodes",
        fe,
        {"a": [0], "b": [4]},
    )


def hinged_frame():
    """Two beams with coincident nodes 2 and 3 that share translations only: the second one swings on a ball joint."""
    fe = fem.frame(
        [(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 0, 0.5), (3, 0, 0)],
        connectivity=[(0, 1), (1, 2), (3, 4)],
        section=fem.Section.rectangle(0.02, 0.02),
        material=STEEL,
        name="hinged",
    )
    nodes = fe.nodes.copy()
    nodes[3] = nodes[2]
    straight = fem.frame([(2, 0, 0), (3, 0, 0)], section=fem.Section.rectangle(0.02, 0.02), material=STEEL)
    K, M = fe.K.tolil(), fe.M.tolil()
    K[18:30, 18:30], M[18:30, 18:30] = straight.K.toarray(), straight.M.toarray()
    tie = sparse.lil_matrix((30, 27))
    keep = [i for i in range(30) if i not in (18, 19, 20)]
    for column, row in enumerate(keep):
        tie[row, column] = 1.0
    for direction in range(3):
        tie[18 + direction, keep.index(12 + direction)] = 1.0
    return FEModel(
        nodes=nodes,
        dofs=fe.dofs[keep],
        K=(tie.T @ K @ tie).tocsr(),
        M=(tie.T @ M @ tie).tocsr(),
        name="hinged",
    )


def test_mechanism_behind_the_interfaces():
    assert_refused(
        r"FE model 'hinged': a mechanism: node [234] at .* m moves freely in (rotation )?[xyz] while the interfaces "
        r"are held.*not joined, a hinge",
        hinged_frame(),
        {"a": [0]},
    )


def test_mechanism_between_the_interfaces():
    assert_refused(r"FE model 'hinged': a mechanism: node \d at", hinged_frame(), {"a": [0], "b": [2]})


def test_hinge_between_two_interfaces_that_hold_both_halves():
    """Solids that share one edge: no part is loose while the interfaces are held, yet one swings about the other."""
    mesh = block_mesh(divisions=(2, 1, 1))
    moved = mesh.points + [0.4, 0.0, 0.0]
    moved[mesh.points[:, 2] > 1e-9, 2] += 1e-3  # only the nodes of the lower edge meet
    first, second = fem.solid(mesh, STEEL), fem.solid(replace(mesh, points=moved, node_sets={}), STEEL)
    fe = fem.joined(first, second, name="two blocks")
    far = np.flatnonzero(fe.nodes[:, 0] > fe.nodes[:, 0].max() - 1e-9)
    assert_refused(
        r"FE model 'two blocks': a mechanism: node \d+ at .* moves freely in [xyz]; the interfaces move "
        r"against each other without strain energy",
        fe,
        {"a": "left", "b": far.tolist()},
        compare=0,
    )


def test_freedom_without_stiffness():
    fe = planar_beam(n_el=4)
    K = fe.K.tolil()
    K[5, :] = 0.0
    K[:, 5] = 0.0
    assert_refused(r"FE model 'planar beam'", replace(fe, K=K.tocsr()))


def test_grounded_stiffness():
    fe = planar_beam(n_el=4)
    K = fe.K.tolil()
    K[4, 4] *= 1.5
    assert_refused(
        r"rigid motion in y meets a force \(relative .*\): the stiffness is grounded\. Expected: a "
        r"free body.*Remove supports",
        replace(fe, K=K.tocsr()),
    )


def test_massless_model():
    fe = planar_beam(n_el=4)
    assert_refused(r"no mass resists rigid motion in y.*Give the material a density", replace(fe, M=0.0 * fe.M))


def test_massless_interface():
    """A beam without mass hangs a third node on: its interface moves no mass at all."""
    beam = fem.frame([(0, 0, 0), (1, 0, 0), (2, 0, 0)], section=fem.Section.rectangle(0.02, 0.02), material=STEEL)
    M = sparse.lil_matrix((18, 18))
    M[:6, :6] = np.diag([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])
    assert_refused(
        r"an interface motion without mass, largest at node \d.*Give this region a density, a lumped mass or inertia",
        replace(beam, M=M.tocsr(), blocks=()),
        {"a": [0], "b": [2]},
        modes=0,
        compare=0,
    )


def test_geometric_stiffness_needs_elements():
    assert_refused(
        r"geometric stiffness was requested, but there are no elements.*geometric_stiffness=False",
        planar_beam(),
        geometric_stiffness=True,
    )


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"preload": {"air": 1.0}}, r"a preload, but geometric_stiffness=False.*Write geometric_stiffness=True"),
        ({"preload": {"air": "x"}, "geometric_stiffness": True}, r"Preload 'air': the factor 'x'"),
        ({"compare": -1}, r"compare = -1.*a count from 0"),
        ({"damping": "1 %"}, r"Damping: '1 %'.*a fraction of critical damping"),
        ({"damping": reduction.Bands((("a", 0.1),))}, r"Damping: \(\('a', 0\.1\),\)"),
    ],
)
def test_settings_that_cannot_be(fe, options, match):
    assert_refused(match, fe, loads={"air": {0: (0.0, 1.0, 0.0)}}, **options)


def test_frame_of_another_name(fe):
    assert_refused(
        r"Frame 'aa': no interface of that name\. Expected: 'buckens' or one of: a, b\. Did you mean 'a'\?",
        fe,
        frame="aa",
    )


def test_frame_at_a_bare_node(fe):
    assert_refused(
        r"Frame 'n': the interface has 3 freedoms\. Expected: 6, enough to hold",
        fe,
        {"a": "left", "n": reduction.Nodes([len(fe.nodes) - 1])}
        if len(fe.nodes) - 1 not in fe.node_set("left")
        else {"a": "right", "n": reduction.Nodes([len(fe.nodes) - 1])},
        frame="n",
    )


def test_station_with_the_name_of_an_interface(fe):
    assert_refused(r"Station 'a': an interface has the same name", fe, stations={"a": "mid"})


def test_unknown_residual_load(fe):
    assert_refused(
        r"Load 'airr': no load shape of that name\. One of: air\. Did you mean 'air'\?",
        fe,
        loads={"air": "top"},
        residual_vectors=["airr"],
    )


def test_interface_on_a_linked_node():
    points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)]
    beam = fem.frame(points, section=fem.Section.rectangle(0.02, 0.02), material=STEEL)
    linked = with_rigid_link(beam, 2, [3])
    assert_refused(
        r"Interface 'b': 1 of its nodes have no independent freedoms \(a link makes them follow other nodes\), first "
        r"node 3.*Choose the node that the link hangs on",
        linked,
        {"a": [0], "b": [3]},
    )


def spring_between(nodes, i: int, j: int, stiffness) -> np.ndarray:
    """Return the stiffness of a spring between two nodes of six freedoms, which acts at the second one."""
    x, y, z = nodes[j] - nodes[i]
    moved = np.eye(6)
    moved[:3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    G = np.zeros((6, 6 * len(nodes)))
    G[:, 6 * i : 6 * i + 6], G[:, 6 * j : 6 * j + 6] = -moved, np.eye(6)
    return G.T @ np.diag(stiffness) @ G


def in_a_row(K) -> fem.FEModel:
    """Return lumped masses in a row with a stiffness, whose entries of zero stay."""
    n = len(K.toarray()) // 6
    nodes = np.array([(k, 0.0, 0.0) for k in range(n)])
    M = sparse.diags_array([1.0, 1.0, 1.0, 0.25, 0.25, 0.25] * n).tocsr()
    return fem.FEModel(K=K, M=M, nodes=nodes, dofs=np.array([(k, d) for k in range(n) for d in range(6)]))


@pytest.mark.parametrize("basis", ["CraigBampton", "Rubin"])
@pytest.mark.parametrize("stiffness", [(1, 0, 0, 0, 0, 0), (1, 1, 1, 0, 0, 0), (1, 1, 1, 1, 1, 0)], ids=str)
def test_a_spring_that_does_not_resist_all_motions_of_two_interfaces(stiffness, basis):
    """Exact zeros of the condensed stiffness were divided by, and ended in an error of the eigenvalue solver."""
    K = 2.0**30 * spring_between(np.array([(0.0, 0, 0), (1, 0, 0)]), 0, 1, stiffness)
    with pytest.raises(ReductionError, match=r"a mechanism: node . at .*interfaces move against each other without"):
        reduction.reduce(in_a_row(sparse.csr_array(K)), {"a": [0], "b": [1]}, 0, basis=basis)


@pytest.mark.parametrize("basis", ["CraigBampton", "Rubin"])
@pytest.mark.parametrize(("link", "told"), [(0.0, "2 parts that are not connected"), (1e-310, "a mechanism")])
def test_interfaces_that_only_zeros_or_the_least_numbers_join(link, told, basis):
    """Each interface holds a stiff part rigidly, and what is between the two has no energy at all."""
    nodes = np.array([(float(k), 0, 0) for k in range(4)])
    ends = 2.0**30 * (spring_between(nodes, 0, 1, np.ones(6)) + spring_between(nodes, 2, 3, np.ones(6)))
    between = spring_between(nodes, 1, 2, np.ones(6))
    i, j = np.nonzero(ends + between)
    K = sparse.csr_array(((ends + link * between)[i, j], (i, j)), shape=ends.shape)
    with pytest.raises(ReductionError, match=told):
        reduction.reduce(in_a_row(K), {"a": [0, 1], "b": [2, 3]}, 0, basis=basis)


@pytest.mark.parametrize(
    "options",
    [{}, {"modes": 0}, {"modes": "up to 500 Hz within 1 %"}, {"basis": "Rubin"}, {"basis": "Balanced"}],
    ids=str,
)
def test_a_rigid_interface_of_all_nodes(fe, options):
    """Nothing is left that deforms: without modes and with other bases it was an IndexError of the eigensolver."""
    model = replace(fe, node_sets={**fe.node_sets, "volume": np.arange(len(fe.nodes))})
    everything = rf"Interface 'big': 'volume' selects all {len(fe.nodes)} nodes of FE model 'block'.*Name a surface"
    assert_refused(everything, model, {"big": "volume"}, **options)


def test_an_interface_of_all_nodes_beside_others(fe):
    model = replace(fe, node_sets={**fe.node_sets, "volume": np.arange(len(fe.nodes))})
    match = rf"Interfaces 'a' and 'big': \d+ common nodes.*'big' has all {len(fe.nodes)} nodes of the part"
    assert_refused(match, model, {"a": "left", "big": reduction.Averaging("volume")})
    assert reduction.reduce(model, {"big": reduction.Averaging("volume")}, 4).n_modes == 4


def test_bare_nodes_of_a_whole_mesh(monkeypatch):
    """Each is an interface of its own: of a mesh of some thousand nodes the reduction would not end."""
    model = block()
    monkeypatch.setattr("flexmb.reduction.interfaces.MOST_BARE", 20)
    match = rf"Interface 'big': \[0, 1.* selects {len(model.nodes)} of {len(model.nodes)} nodes.*at most 20 bare nodes"
    assert_refused(match, model, {"big": reduction.Nodes(list(range(len(model.nodes))))})
