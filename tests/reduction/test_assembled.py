"""Reduction of the second level: reduced parts joined and reduced again, beside the reduction of the whole mesh."""

import numpy as np
import pytest
from reduction.solids import STEEL, block_mesh
from scipy.linalg import eigh

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import MeshError, ReductionError

ALUMINIUM = fmb.MATERIALS["aluminium"]
SECTION = fem.Section.rectangle(0.02, 0.03)


def beam(first, last, elements):
    points = np.column_stack([np.linspace(first, last, elements + 1), *np.zeros((2, elements + 1))])
    return fem.frame(points=points, section=SECTION, material=ALUMINIUM)


def part(fe, modes, ends=None, **options):
    ends = ends or {"a": [0], "b": [len(fe.nodes) - 1]}
    return fe, reduction.reduce(fe, ends, modes, geometric_stiffness=True, compare=0, **options)


def two_beams(modes=(8, 12), **options):
    left, right = (part(beam(*ends), n) for ends, n in zip(((0.0, 0.8, 8), (0.8, 2.0, 12)), modes))
    fe = reduction.assembled({"left": left, "right": right}, fixed=[("left.b", "right.a")])
    return reduction.reduce(fe, {"a": "left.a", "b": "right.b"}, 6, geometric_stiffness=True, compare=0, **options)


def aligned(data, reference):
    """Signs by which the shapes of two bodies with different frequencies agree."""
    signs = np.sign(np.einsum("kij,kij->j", data.marker_translations[:2], reference.marker_translations[:2]))
    turns = np.sign(np.einsum("kij,kij->j", data.marker_rotations[:2], reference.marker_rotations[:2]))
    return np.where(np.abs(data.marker_translations[:2]).max(axis=(0, 1)) > 1e-6, signs, turns)


def close(found, expected, relative):
    assert np.abs(found - expected).max() <= relative * np.abs(expected).max()


@pytest.fixture(scope="module")
def whole_beam():
    return part(beam(0.0, 2.0, 20), 6)[1]


def test_parts_with_all_their_modes_give_the_body_of_the_whole_mesh(whole_beam):
    """Mass, invariants, frequencies, geometric stiffness of spin and of forces, and stress, through both levels."""
    data, ref = two_beams((42, 66)), whole_beam
    s = aligned(data, ref)
    pair = np.outer(s, s)
    close(data.frequencies, ref.frequencies, 1e-9)
    for name, sign in (("vv", 1.0), ("ww0", 1.0), ("vn", s), ("wn0", s), ("vw1", s[:, None, None])):
        assert np.abs(getattr(data.invariants, name) * sign - getattr(ref.invariants, name)).max() < 1e-8, name
    close(data.invariants.ww2 * pair[:, :, None, None], ref.invariants.ww2, 1e-7)
    close(data.geometric.inertia * pair, ref.geometric.inertia, 1e-7)
    close(data.geometric.interface * pair, ref.geometric.interface, 1e-7)
    lower, upper = np.arange(1, 8), np.arange(10, 21)
    close((data.stress_modes * s)[lower], ref.stress_modes[lower], 1e-6)
    close((data.stress_modes * s)[upper], ref.stress_modes[upper - 1], 1e-6)


def test_the_error_is_that_of_the_bases_of_the_parts(whole_beam):
    """It falls with their modes; six of the joined body are within 1e-4 with eight and twelve of the parts."""
    ref, errors = whole_beam.frequencies[:6], []
    for modes in ((0, 0), (2, 3), (8, 12)):
        errors.append(np.abs(two_beams(modes).frequencies[:6] / ref - 1.0).max())
    assert errors[0] > 4.0 * errors[1]
    assert errors[1] > 100.0 * errors[2]
    assert errors[2] < 1e-4
    assert two_beams((8, 12), error_up_to=300.0).quality["transfer"]["relative"] < 1.0


def test_what_the_bases_of_parts_cost_is_told():
    """Against dense matrices of the whole beam: bases of parts take 1.2 and 14 % of its response, where the bound,
    beside the joined parts, is 3e-6 and 6e-15."""
    whole = beam(0.0, 2.0, 20)
    K, M = whole.K.toarray(), whole.M.toarray()
    elastic = np.linalg.qr(M @ whole.rigid_motions(), mode="complete")[0][:, 6:]
    mu, modes = eigh(elastic.T @ M @ elastic, elastic.T @ K @ elastic)
    shares = (modes.T @ elastic.T)[:, np.r_[:6, whole.ndof - 6 : whole.ndof]]

    def true(data):
        told, loss = data.quality["transfer"], 1.0 + 2j * data.quality["transfer"]["damping"]
        size = np.tile(np.repeat([1.0, told["length"]], 3), 2)
        own_mu, own = eigh(data.invariants.nn, data.stiffness)
        moved = np.concatenate([data.marker_translations[:2], data.marker_rotations[:2]], axis=1).reshape(12, -1)
        answers = []
        for values, share in ((mu, shares * size), (own_mu, own.T @ (moved * size[:, None]).T)):
            squares = (2.0 * np.pi * np.array(told["frequencies"])) ** 2
            answers.append(np.array([(share.T / (loss - square * values)) @ share for square in squares]))
        full, found = answers
        return np.linalg.norm(full - found, 2, axis=(1, 2)).max() / np.linalg.norm(full, 2, axis=(1, 2)).max()

    for modes, level in (((2, 3), "Rubin"), ((5, 6), "Rubin"), ((2, 3), "CraigBampton")):
        parts = {
            name: part(beam(*ends), n, error_up_to=400.0)
            for name, ends, n in zip(("left", "right"), ((0.0, 0.8, 8), (0.8, 2.0, 12)), modes)
        }
        fe = reduction.assembled(parts, fixed=[("left.b", "right.a")])
        given = {"error_up_to": 150.0, "compare": 0, "basis": level}
        data = reduction.reduce(fe, {"a": "left.a", "b": "right.b"}, 8 if level == "Rubin" else 2, **given)
        told, error = data.quality["transfer"], true(data)
        assert error < 1.05 * (told["by_parts"] + told["relative"])
        if level == "Rubin":
            assert told["relative"] < 0.1 * error
            assert 0.95 * error < told["by_parts"] < 1.5 * error
        assert any("bases of the parts take" in text for text in data.quality["warnings"]) == (told["by_parts"] > 0.02)
        assert "beside the joined parts" in data.report()
        assert f"of the parts    about {told['by_parts']:.2e}" in data.report()
        assert data.rescaled(time=10.0).quality["transfer"]["by_parts_at"] == pytest.approx(0.1 * told["by_parts_at"])
    silent = two_beams(error_up_to=150.0)
    assert "by_parts" not in silent.quality["transfer"]
    assert "of the parts    not known: reduce them with error_up_to" in silent.report()


def test_what_the_parts_do_not_hold_is_told(whole_beam):
    """A bound of 1 % beside the joined parts says nothing of the whole mesh: without modes of the parts the third
    frequency is 4 % too high."""
    asked = "up to 150 Hz within 1 %"

    def joined(modes, **options):
        parts = {}
        for name, *ends in (("left", 0.0, 0.8, 8), ("right", 0.8, 2.0, 12)):
            fe = beam(*ends)
            parts[name] = fe, reduction.reduce(fe, {"a": [0], "b": [len(fe.nodes) - 1]}, modes, **options)
        fe = reduction.assembled(parts, fixed=[("left.b", "right.a")])
        return reduction.reduce(fe, {"a": "left.a", "b": "right.b"}, asked, compare=4)

    data = joined(0)
    assert data.quality["transfer"]["relative"] < 0.01
    assert data.frequencies[2] > 1.04 * whole_beam.frequencies[2]
    told = data.quality["warnings"][-1]
    assert "left up to" in told
    assert "not with the whole mesh. Reduce these parts again with modes='up to 150 Hz within 1 %'" in told
    assert "joined parts, not with the whole mesh; their bases hold up to: left " in data.report()
    assert any("left up to 0 Hz" in text for text in joined(0, compare=0).quality["warnings"])
    fine = joined(asked)
    assert not fine.quality["warnings"]
    assert fine.frequencies[:4] == pytest.approx(whole_beam.frequencies[:4], rel=0.01)
    assert "left 150 Hz, right 150 Hz" in fine.report()


def test_a_spring_joins_two_masses():
    """Two short bars on a soft spring: ``sqrt(k (1/m1 + 1/m2))`` along it; the other five motions are free of it."""
    k = 1e4
    left, right = part(beam(0.0, 0.2, 2), 0), part(beam(0.3, 0.6, 3), 0)
    stiffness = (k, 1e9, 1e9, 1e8, 1e8, 1e8)
    fe = fem.with_spring(reduction.assembled({"left": left, "right": right}), "left.b", stiffness, to="right.a")
    data = reduction.reduce(fe, {"a": "left.a", "b": "right.b"}, 0, compare=0)
    m1, m2 = left[1].mass, right[1].mass
    exact = np.sqrt(k * (1.0 / m1 + 1.0 / m2)) / (2.0 * np.pi)
    assert data.frequencies[0] == pytest.approx(exact, rel=1e-4)
    assert data.mass == pytest.approx(m1 + m2, rel=1e-12)


def test_solids_joined_at_faces_stiffen_like_the_whole(tmp_path):
    """Two blocks of tet10 on a common rigid face, beside one mesh in which that face is rigid; all through files."""

    def block(first, divisions):
        mesh = block_mesh((0.2, 0.06, 0.04), divisions)
        return fem.solid(shifted(mesh, first), STEEL)

    def shifted(mesh, first):
        return fem.Mesh(
            points=mesh.points + np.array([first, 0.0, 0.0]),
            cells=mesh.cells,
            node_sets=mesh.node_sets,
            facet_sets=mesh.facet_sets,
        )

    one, other = block(0.0, (3, 2, 1)), block(0.2, (3, 2, 1))
    ends = {"a": "left", "b": "right"}
    parts = {"one": part(one, 60, ends), "other": part(other, 60, ends)}
    for key, (fe, data) in parts.items():
        stored = data.save(tmp_path / f"{key}.h5")
        parts[key] = fe, fmb.ModalNeutralData.load(stored)
    fe = reduction.assembled(parts, fixed=[("one.b", "other.a")])
    data = reduction.reduce(fe, {"a": "one.a", "b": "other.b"}, 4, geometric_stiffness=True, compare=0)
    joined = fem.joined(one, other)
    face = np.flatnonzero(np.isclose(joined.nodes[:, 0], 0.2))
    linked = fem.with_rigid_link(joined, tuple(joined.nodes[face].mean(axis=0)), face, "face")
    outer = {
        "a": np.flatnonzero(joined.nodes[:, 0] < 1e-9).tolist(),
        "b": np.flatnonzero(joined.nodes[:, 0] > 0.4 - 1e-9).tolist(),
    }
    ref = reduction.reduce(linked, outer, 4, geometric_stiffness=True, compare=0)
    assert np.abs(data.frequencies[:6] / ref.frequencies[:6] - 1.0).max() < 2e-3
    low = slice(0, 4)
    signs = aligned(data, ref)[low]
    spun = (data.geometric.inertia[:, low, low] * np.outer(signs, signs), ref.geometric.inertia[:, low, low])
    pulled = (
        data.geometric.interface[:, :, low, low] * np.outer(signs, signs),
        ref.geometric.interface[:, :, low, low],
    )
    close(*spun, 0.02)
    close(*pulled, 0.02)
    force = reduction.NodalForces({int(fe.node_set("one.right")[0]): (0.0, 0.0, 1.0)})
    with pytest.raises(ReductionError, match="interface 'b' of a part"):
        reduction.reduce(fe, {"a": "one.a"}, 2, loads={"tip": force}, geometric_stiffness=True, compare=0)


def test_what_cannot_be_joined_is_named():
    left, right = part(beam(0.0, 0.8, 4), 2), part(beam(0.8, 2.0, 6), 2)
    both = {"left": left, "right": right}
    for parts, options, words in (
        ({}, {}, "a mapping of names"),
        ({"left": left[1]}, {}, r"\(FEModel, ModalNeutralData\)"),
        ({"left": (left[0], right[1])}, {}, "the same finite elements"),
        (both, {"fixed": [("left.b", "right.c")]}, "'right.c'"),
        (both, {"fixed": [("left.a", "right.a")]}, "0.8 m between them"),
        (both, {"fixed": [("left.b", "right.a"), ("right.a", "left.b")]}, "fixed to each other already"),
    ):
        with pytest.raises(ReductionError, match=words):
            reduction.assembled(parts, **options)
    loose = reduction.assembled(both)
    with pytest.raises(ReductionError, match="not connected"):
        reduction.reduce(loose, {"a": "left.a", "b": "right.b"}, 2, compare=0)
    for changed in (
        lambda: fem.with_mass(loose, "left.a", 1.0),
        lambda: fem.with_rigid_link(loose, "left.a", "right.b"),
        lambda: fem.with_supports(loose, "left.a"),
    ):
        with pytest.raises(MeshError, match="reduced"):
            changed()
    with pytest.warns(UserWarning, match="3 independent ways"):
        few = reduction.reduce(left[0], {"a": [0], "b": [4]}, 3, basis="Balanced", compare=0)
    with pytest.raises(ReductionError, match="12 motions of its interfaces, of which"):
        reduction.assembled({"left": (left[0], few)})


def test_data_of_other_elements_are_refused():
    """Another material, another unit of mass: the body was a mixture of both."""
    fe, data = part(beam(0.0, 0.8, 8), 4)
    steel = fem.frame(points=fe.nodes, section=SECTION, material=STEEL)
    with pytest.raises(ReductionError, match="a mass of"):
        reduction.assembled({"left": (steel, data)})
    with pytest.raises(ReductionError, match="of its elements"):
        reduction.assembled({"left": (fe, reduction.rescaled(data, mass=2.0))})
    with pytest.raises(ReductionError, match="modal stiffness"):
        reduction.assembled({"left": (fem.with_spring(fe, 8, (1e6, 1e6, 1e6, 0, 0, 0)), data)})


def test_a_preload_of_a_part_is_not_lost_in_silence():
    loads = {"pull": reduction.NodalForces({8: [1.0, 0.0, 0.0]})}
    loaded = part(beam(0.0, 0.8, 8), 4, loads=loads, preload={"pull": 1e5})
    with pytest.raises(ReductionError, match="a preload"):
        reduction.assembled({"left": loaded})


def nested_beam(modes, outer=6, **options):
    """Beam of five parts: two pairs, joined and reduced, then joined with the fifth: three levels."""
    ends = ((0.0, 0.3, 3), (0.3, 0.8, 5), (0.8, 1.2, 4), (1.2, 1.7, 5), (1.7, 2.0, 3))
    parts = [part(beam(*span), n) for span, n in zip(ends, modes)]

    def pair(one, other, more):
        fe = reduction.assembled({"one": one, "other": other}, fixed=[("one.b", "other.a")])
        return part(fe, more, {"a": "one.a", "b": "other.b"})

    first, second = pair(*parts[:2], modes[5]), pair(*parts[2:4], modes[6])
    fe = reduction.assembled(
        {"first": first, "second": second, "last": parts[4]},
        fixed=[("first.b", "second.a"), ("second.b", "last.a")],
    )
    return fe, reduction.reduce(
        fe, {"a": "first.a", "b": "last.b"}, outer, geometric_stiffness=True, compare=0, **options
    )


def test_three_levels_give_the_body_of_the_whole_mesh(whole_beam):
    """Mass, invariants, frequencies, geometric stiffness and stress of a beam in five parts, joined twice."""
    (_, data), ref = nested_beam((12, 24, 18, 24, 12, 42, 48)), whole_beam
    s = aligned(data, ref)
    pair = np.outer(s, s)
    close(data.frequencies, ref.frequencies, 1e-8)
    for name, sign in (("vv", 1.0), ("ww0", 1.0), ("vn", s), ("wn0", s), ("vw1", s[:, None, None])):
        assert np.abs(getattr(data.invariants, name) * sign - getattr(ref.invariants, name)).max() < 1e-8, name
    close(data.invariants.ww2 * pair[:, :, None, None], ref.invariants.ww2, 1e-7)
    close(data.geometric.inertia * pair, ref.geometric.inertia, 1e-7)
    close(data.geometric.interface * pair, ref.geometric.interface, 1e-7)
    close((data.stress_modes * s)[1:3], ref.stress_modes[1:3], 1e-6)
    few = nested_beam((2, 4, 3, 4, 2, 6, 6))[1]
    assert 1e-9 < np.abs(few.frequencies[:6] / ref.frequencies[:6] - 1.0).max() < 1e-2


def test_the_place_of_an_inner_joint_is_known_in_the_third_level(whole_beam):
    """The node at which parts of a part are joined moves as the beam does there, and turns with it."""
    fe, data = nested_beam((12, 24, 18, 24, 12, 42, 48))
    node, s = int(fe.node_set("first.one.b")[0]), aligned(data, whole_beam)
    assert fe.nodes[node] == pytest.approx((0.3, 0.0, 0.0))
    close(data.shapes[node] * s, whole_beam.shapes[3], 1e-7)
    close(data.rotation_shapes[node] * s, whole_beam.rotation_shapes[3], 1e-7)


def test_a_spring_within_a_part_stays_in_the_third_level():
    """Two masses on a spring, reduced, and a third fixed to one: ``sqrt(k (1/m1 + 1/(m2 + m3)))`` along it."""
    k = 1e4
    left, right, last = (part(beam(*span), 0) for span in ((0.0, 0.2, 2), (0.3, 0.6, 3), (0.6, 1.0, 4)))
    stiffness = (k, 1e9, 1e9, 1e8, 1e8, 1e8)
    fe = fem.with_spring(reduction.assembled({"left": left, "right": right}), "left.b", stiffness, to="right.a")
    pair = part(fe, 0, {"a": "left.a", "b": "right.b"})
    whole = reduction.assembled({"pair": pair, "last": last}, fixed=[("pair.b", "last.a")])
    data = reduction.reduce(whole, {"a": "pair.a", "b": "last.b"}, 0, compare=0)
    m1, m2 = left[1].mass, right[1].mass + last[1].mass
    exact = np.sqrt(k * (1.0 / m1 + 1.0 / m2)) / (2.0 * np.pi)
    assert data.frequencies[0] == pytest.approx(exact, rel=1e-4)


def test_rigid_faces_stiffen_as_much_in_the_third_level():
    """Three blocks on rigid faces, joined at once, and two first: the forces in inner faces count once."""

    def block(first):
        mesh = block_mesh((0.2, 0.06, 0.04), (2, 1, 1))
        points = mesh.points + np.array([first, 0.0, 0.0])
        fe = fem.solid(
            fem.Mesh(points=points, cells=mesh.cells, node_sets=mesh.node_sets, facet_sets=mesh.facet_sets), STEEL
        )
        return part(fe, 60, {"a": "left", "b": "right"})

    one, two, three = (block(x) for x in (0.0, 0.2, 0.4))
    at_once = reduction.assembled(
        {"one": one, "two": two, "three": three}, fixed=[("one.b", "two.a"), ("two.b", "three.a")]
    )
    ref = part(at_once, 4, {"a": "one.a", "b": "three.b"})[1]
    fe = reduction.assembled({"one": one, "two": two}, fixed=[("one.b", "two.a")])
    pair = part(fe, fe.ndof - 12, {"a": "one.a", "b": "two.b"})
    nested = reduction.assembled({"pair": pair, "three": three}, fixed=[("pair.b", "three.a")])
    assert len(nested.condensed.couplings) == 6  # two of each block, none twice
    data = part(nested, 4, {"a": "pair.a", "b": "three.b"})[1]
    s = aligned(data, ref)
    pair = np.outer(s, s)
    close(data.frequencies, ref.frequencies, 1e-7)
    close(data.geometric.inertia * pair, ref.geometric.inertia, 1e-6)
    close(data.geometric.interface * pair, ref.geometric.interface, 1e-6)
