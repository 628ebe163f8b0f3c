"""Bases beyond Craig & Bampton: what each must be exact in, and numbers that others found for a beam."""

from dataclasses import replace

import numpy as np
import pytest
from reduction.beams import planar_beam
from reduction.solids import block
from scipy.linalg import eigh

import flexmb as fmb
from flexmb import parts, reduction
from flexmb.errors import ReductionError
from flexmb.reduction.framed_body import FramedBody
from flexmb.reduction.interfaces import resolve
from flexmb.reduction.markers import interface_motions
from flexmb.reduction.statics import HeldBody

ENDS = {"a": "left", "b": "right"}
SPANNED = [
    (reduction.CraigBampton(), 4),
    (reduction.Rubin(), 4),
    (reduction.Krylov((0.0, 150.0)), "usual"),
    (reduction.CharacteristicModes(1), 4),
    (reduction.Balanced(30), 6),
]


@pytest.fixture(scope="module")
def fe():
    return planar_beam(40)


def compliances(K, M, loads, hertz, zeta, rigid=None):
    """H = F^T ((1 + 2 i zeta) K - w2 M)^-1 F without the rigid motions, from all elastic modes (LAPACK).

    1 / w2 are found instead of w2: rounding is relative to the largest of them.
    """
    elastic = np.eye(len(K)) if rigid is None else np.linalg.qr(M @ rigid, mode="complete")[0][:, rigid.shape[1] :]
    mu, modes = eigh(elastic.T @ M @ elastic, elastic.T @ K @ elastic)
    share = modes.T @ (elastic.T @ loads)
    return np.array([(share.T / ((1 + 2j * zeta) - (2 * np.pi * f) ** 2 * mu)) @ share for f in hertz])


def of_beam(fe, loads, hertz, zeta):
    """The same of the free beam."""
    x = fe.nodes[:, 0]
    rigid = np.zeros((fe.ndof, 2))
    rigid[::2] = np.column_stack([np.ones(len(x)), x])
    rigid[1::2, 1] = 1.0
    return compliances(fe.K.toarray(), fe.M.toarray(), loads, hertz, zeta, rigid)


def of_reduced(data, loads, hertz, zeta):
    """The same of a reduced body, with the modal forces (m, k) of the loads."""
    return compliances(data.stiffness, data.invariants.nn, loads, hertz, zeta)


def of_floating(data, loads, hertz, zeta):
    """The same with its rigid motions in the plane, which clamped frames need: their shapes move the mass centre."""
    I, m = data.invariants, data.n_modes
    rigid = np.array([[I.vv[1, 1], I.vw0[1, 2]], [I.vw0[1, 2], I.ww0[2, 2]]])
    coupling = np.vstack([I.vn[1], I.wn0[2]])
    K = np.zeros((m + 2, m + 2))
    K[2:, 2:] = data.stiffness
    ends = data.marker_positions[:, 0]
    on_rigid = np.array([[1.0, 0.0, 1.0, 0.0], [ends[0], 1.0, ends[1], 1.0]])
    M = np.block([[rigid, coupling], [coupling.T, I.nn]])
    return compliances(K, M, np.vstack([on_rigid, loads]), hertz, zeta, np.eye(m + 2, 2))


def relative_error(full, other):
    worst = np.linalg.norm(full - other, 2, axis=(1, 2)).max()
    return worst / np.linalg.norm(full, 2, axis=(1, 2)).max()


def at_ends(fe, data):
    """Forces and moments at both ends (moments of 1 N times 1 m, half the beam): on the freedoms, and modal."""
    full = np.zeros((fe.ndof, 4))
    full[[0, 1, -2, -1], range(4)] = 1.0
    t, r = data.marker_translations, data.marker_rotations
    return full, np.column_stack([t[0, 1], r[0, 2], t[1, 1], r[1, 2]])


def test_error_over_order_of_a_beam_is_the_published_one():
    """Cantilever, force and deflection at the tip: relative error in the H-infinity norm at order 3, 5, 8, 12."""
    fe = planar_beam(60)
    K, M = fe.K.toarray()[2:, 2:], fe.M.toarray()[2:, 2:]
    force = np.zeros((len(K), 1))
    force[-2] = 1.0
    own = np.sqrt(eigh(K, M, eigvals_only=True)[:20]) / (2 * np.pi)
    hertz = np.unique(np.concatenate([own, 0.99 * own, 1.01 * own, np.linspace(0.0, own[-1], 150)]))
    full = compliances(K, M, force, hertz, 0.01)
    given = {"frame": "a", "loads": {"tip": {60: (0.0, 1.0, 0.0)}}, "compare": 0}
    one = {"a": "left"}
    couplings = resolve(fe, one)
    load = np.vstack([np.zeros((2, 1)), force])
    held = FramedBody(HeldBody(fe, couplings), 0, interface_motions(fe, couplings), load)
    static = eigh(K[:-2, :-2], M[:-2, :-2])[1]  # both freedoms of the tip held
    psi = np.vstack([-np.linalg.solve(K[:-2, :-2], K[:-2, -2:]), np.eye(2)])
    for order, modal, balanced in ((3, 8e-4, 8e-4), (5, 1.4e-4, 1.4e-4), (8, 2.5e-5, 3.6e-5), (12, 5.7e-6, 5.8e-6)):
        own_modes = reduction.reduce(fe, one, order, **given)
        error = relative_error(full, of_reduced(own_modes, own_modes.load_shapes[:, 6:].T, hertz, 0.01))
        assert error == pytest.approx(modal, rel=0.1)
        V = reduction.Balanced(60).vectors(held, order)[2:]
        error = relative_error(full, compliances(V.T @ K @ V, V.T @ M @ V, V.T @ force, hertz, 0.01))
        assert 0.5 * balanced < error < 1.1 * balanced
        both = reduction.reduce(fe, ENDS, order - 2, **given)
        basis = np.hstack([psi, np.vstack([static[:, : order - 2], np.zeros((2, order - 2))])])
        reference = compliances(basis.T @ K @ basis, basis.T @ M @ basis, basis.T @ force, hertz, 0.01)
        found = of_reduced(both, both.load_shapes[:, 6:].T, hertz, 0.01)
        assert relative_error(full, found) == pytest.approx(relative_error(full, reference), rel=1e-4)
    assert relative_error(full, found) == pytest.approx(1.8e-5, rel=0.05)


@pytest.mark.parametrize(("basis", "modes"), SPANNED)
@pytest.mark.parametrize("frame", ["buckens", "a"])
def test_bound_of_the_error_lies_above_the_error_and_near(fe, basis, modes, frame):
    data = reduction.reduce(fe, ENDS, modes, basis=basis, error_up_to=200.0, frame=frame, damping=0.02)
    told = data.quality["transfer"]
    full, modal = at_ends(fe, data)
    exact = of_beam(fe, full, told["frequencies"], 0.02)
    found = of_floating(data, modal, told["frequencies"], 0.02)
    true = np.linalg.norm(exact - found, 2, axis=(1, 2))
    bound = np.array(told["error"])
    assert told["relative"] == pytest.approx(bound.max() / max(told["response"]))
    assert 1.0 - 1e-4 <= bound.max() / true.max() <= 2.0
    large = true > 1e-6 * max(told["response"])  # the modes are known to 1e-9, over the damping
    assert np.all(bound[large] >= true[large] * (1.0 - 1e-3))
    assert np.all(bound[large] <= 10.0 * true[large])


@pytest.mark.parametrize("basis", ["CraigBampton", "Rubin", "Krylov", "CharacteristicModes", "Balanced"])
def test_an_accuracy_is_met_by_every_basis(fe, basis):
    data = reduction.reduce(fe, ENDS, "up to 200 Hz within 0.5 %", basis=basis)
    full, modal = at_ends(fe, data)
    hertz = data.quality["transfer"]["frequencies"]
    exact = of_beam(fe, full, hertz, 0.01)
    assert relative_error(exact, of_reduced(data, modal, hertz, 0.01)) < 0.005
    assert data.n_modes < 20


@pytest.mark.parametrize("basis", [reduction.Rubin(), reduction.Krylov(order=2), "Craig-Chang"])
@pytest.mark.parametrize("frame", ["buckens", "b"])
def test_statics_at_interfaces_is_exact_with_attachment_modes(fe, basis, frame):
    modes = "usual" if isinstance(basis, reduction.Krylov) else 3
    assert reduction.reduce(fe, ENDS, modes, basis=basis, frame=frame).quality["static_error"] < 1e-9


@pytest.mark.parametrize(("order", "moments"), [(1, 2), (2, 4)])
def test_krylov_matches_twice_as_many_moments_as_its_order(fe, order, moments):
    """At the frequency the response is exact; beside it the error grows with the power of 2 order."""
    data = reduction.reduce(fe, ENDS, basis=reduction.Krylov((100.0,), order))
    full, modal = at_ends(fe, data)
    w2 = (2 * np.pi * 100.0) ** 2 * np.array([1.0, 1.05, 1.1])
    hertz = np.sqrt(w2) / (2 * np.pi)
    exact = of_beam(fe, full, hertz, 0.0)
    error = np.linalg.norm(exact - of_reduced(data, modal, hertz, 0.0), 2, axis=(1, 2))
    size = np.linalg.norm(exact[0], 2)
    assert error[0] < 1e-7 * size
    assert error[2] / error[1] == pytest.approx(2.0**moments, rel=0.1)


def test_stations_join_a_two_sided_krylov_basis(fe):
    given = {"stations": {"mid": [20]}, "compare": 0}
    one = reduction.reduce(fe, ENDS, basis=reduction.Krylov((100.0,)), **given)
    two = reduction.reduce(fe, ENDS, basis=reduction.Krylov((100.0,), two_sided=True), **given)
    full, _ = at_ends(fe, one)
    place = np.zeros((fe.ndof, 1))
    place[40] = 1.0
    hertz = np.array([100.5])
    exact = of_beam(fe, np.hstack([full, place]), hertz, 0.0)[0][4, :4]
    errors = []
    for data in (one, two):
        modal = np.column_stack([at_ends(fe, data)[1], data.marker_translations[2, 1]])
        errors.append(np.abs(of_reduced(data, modal, hertz, 0.0)[0][4, :4] - exact).max())
    assert errors[1] < 0.05 * errors[0]


def test_twenty_krylov_vectors_where_a_hundred_modes_lie_below():
    """Loads at 104 to 107 kHz on the ends of a beam, whose 95th mode is there: 20 vectors leave 6e-6 of the response,
    102 shapes of Craig & Bampton a sixth."""
    fe, band = planar_beam(160), np.linspace(104e3, 107e3, 7)

    def error(modes, basis):
        data = reduction.reduce(fe, ENDS, modes, basis=basis, compare=0, stress=False)
        full, modal = at_ends(fe, data)
        return data.n_modes, relative_error(of_beam(fe, full, band, 0.01), of_floating(data, modal, band, 0.01))

    vectors, krylov = error("usual", reduction.Krylov((105.5e3,), order=5))
    modes, craig_bampton = error(100, reduction.CraigBampton())
    assert (vectors, modes) == (20, 102)
    assert krylov < 1e-4
    assert craig_bampton > 0.1


def test_dependent_directions_are_left_out(fe):
    """A high order at near frequencies spans less than its number of vectors: the basis stays well conditioned."""
    data = reduction.reduce(fe, ENDS, basis=reduction.Krylov((0.0, 0.1, 0.2, 0.3), order=4), compare=0)
    assert data.n_modes < 64
    assert np.abs(data.invariants.nn - np.eye(data.n_modes)).max() < 1e-9


def test_all_characteristic_modes_are_craig_and_bampton_s_basis(fe):
    whole = reduction.reduce(fe, ENDS, 4)
    same = reduction.reduce(fe, ENDS, 4, basis=reduction.CharacteristicModes(2))
    assert same.frequencies == pytest.approx(whole.frequencies, rel=1e-8)


def test_an_interface_of_many_nodes_is_reduced(fe):
    nodes = reduction.Nodes(list(range(0, 41, 2)))
    whole = reduction.reduce(fe, {"n": nodes}, 0)
    few = reduction.reduce(fe, {"n": nodes}, 0, basis=reduction.CharacteristicModes(8))
    assert whole.n_modes == 40
    assert few.n_modes == 8
    assert few.frequencies[:5] == pytest.approx(whole.frequencies[:5], rel=1e-6)
    assert "lock the body" in few.quality["warnings"][0]


def test_principal_displacements_are_those_of_the_snapshots(fe):
    w2, modes = eigh(fe.K.toarray(), fe.M.toarray())
    turn = np.random.default_rng(7).standard_normal((2, 9))
    data = reduction.reduce(fe, ENDS, basis=reduction.Pod(modes[:, 3:5] @ turn + modes[:, :1] @ turn[:1]))
    assert data.frequencies == pytest.approx(np.sqrt(w2[3:5]) / (2 * np.pi), rel=1e-6)
    finer = reduction.reduce(fe, ENDS, 8)
    again = reduction.Pod(reduction.snapshots_of(fe, finer, np.eye(finer.n_modes)), energy=1.0)
    assert reduction.reduce(fe, ENDS, basis=again).frequencies == pytest.approx(finer.frequencies, rel=1e-6)


ONE = {"push": {20: (0.0, 1.0, 0.0)}}
THREE = np.vstack([np.random.default_rng(2).standard_normal((82, 2)).T, np.ones(82)]).T @ [
    [1, 0, 1],
    [0, 1, 1],
    [0, 0, 0],
]
_AT = np.linspace(0.0, 2.0, 41)
STILL = np.array([np.column_stack([a + b * _AT, b + 0.0 * _AT]).ravel() for a, b in ((1, 0), (0, 1), (3, 2), (0, 0))]).T
"""Three snapshots of which one is a sum, and rigid motions of the beam."""


def test_what_is_unsound_is_refused_by_name(fe):
    for match, options in [
        ("MacNeal.*Rubin", {"basis": "MacNeal"}),
        ("One of: CraigBampton", {"basis": "Hintz"}),
        ("basis = 3", {"basis": 3}),
        ("order say how many", {"basis": "Krylov", "modes": 4}),
        ("'speed=3'", {"basis": "Krylov speed=3"}),
        ("basis = the class", {"basis": reduction.Krylov}),
        ("40 modes asked for|modes asked for", {"basis": "Rubin", "modes": 400}),
        ("snapshots of 3 freedoms", {"basis": reduction.Pod(np.ones((3, 2)))}),
        ("error_up_to", {"error_up_to": -1.0}),
        ("neither interfaces nor loads", {"interfaces": {}, "basis": "Rubin", "modes": "up to 200 Hz within 1 %"}),
        ("neither interfaces nor loads", {"interfaces": {}, "error_up_to": 100.0}),
        ("an accuracy 'of the frequencies'", {"interfaces": {}, "modes": "up to 200 Hz within 1 %"}),
        (
            "Basis Rubin: modes within 2 % of the frequencies.*Write modes='up to 200 Hz within 2 %'",
            {"basis": "Rubin", "modes": "up to 200 Hz within 2 % of the frequencies"},
        ),
        ("a body that nothing loads", {"interfaces": {}, "basis": "Balanced"}),
        ("a body that nothing loads", {"interfaces": {}, "basis": "Krylov"}),
        ("none of which joins.*residual_vectors='all'", {"interfaces": {}, "basis": "Krylov", "loads": ONE}),
        ("none of which joins.*residual_vectors='all'", {"interfaces": {}, "basis": "Balanced", "loads": ONE}),
        ("Guyan.*modes=0", {"basis": "Guyan"}),
        ("MacNeal.*Rubin", {"basis": "Mac Neal"}),
        ("Basis Pod: no snapshots.*snapshots_of", {"basis": "POD"}),
        ("8 modes asked for.*at most 2, .*more snapshots", {"basis": reduction.Pod(THREE), "modes": 8}),
        ("modes = 0.*energy", {"basis": reduction.Pod(THREE), "modes": 0}),
        ("4 snapshots of a body that is not deformed", {"basis": reduction.Pod(STILL)}),
        ("80 fixed-interface modes asked for. Expected: at most 78", {"basis": "CharacteristicModes", "modes": 80}),
        ("at best up to 2000 Hz.*statics=True", {"basis": reduction.Pod(THREE), "modes": "up to 2 kHz within 1 %"}),
    ]:
        with pytest.raises(ReductionError, match=match):
            reduction.reduce(fe, **{"interfaces": ENDS, **options})
    for wrong in ((), (1.0, 1.0), (-1.0,), "x"):
        with pytest.raises(ReductionError, match="different frequencies"):
            reduction.Krylov(wrong)
    with pytest.raises(ReductionError, match="a share above 0"):
        reduction.Pod(np.ones((3, 2)), energy=1.5)


def test_an_accuracy_that_takes_too_many_modes_is_refused(fe, monkeypatch):
    monkeypatch.setattr("flexmb.reduction.basis_choice.MOST_MODES", 8)
    with pytest.raises(ReductionError, match=r"with 8 modes.*of the frequencies'"):
        reduction.reduce(fe, ENDS, "up to 500 Hz within 0.001 %")


def test_too_few_shapes_for_the_joints_are_told(fe):
    with pytest.warns(fmb.ValidityWarning, match=r"Reduction of 'planar beam'.*independent ways.*they lock the body"):
        data = reduction.reduce(fe, ENDS, 1, basis=reduction.Balanced(20))
    assert "1 independent ways" in data.quality["warnings"][0]


def test_what_a_basis_does_not_meet_is_told(fe):
    few = reduction.reduce(fe, {"a": "left"}, 1, basis=reduction.CharacteristicModes(1))
    assert "error_up_to=" in few.quality["warnings"][0]
    bounded = reduction.reduce(fe, {"a": "left"}, 1, basis=reduction.CharacteristicModes(1), error_up_to=100.0)
    assert bounded.quality["warnings"][0].startswith("The response to loads up to 100 Hz may be off by")
    assert "may be off" in reduction.reduce(fe, ENDS, 0, error_up_to=200.0).quality["warnings"][-1]
    assert reduction.reduce(fe, ENDS, 8, basis="Rubin").quality["warnings"] == []


def test_bound_follows_units_and_report_tells_it(fe):
    data = reduction.reduce(fe, ENDS, 2, error_up_to=100.0)
    other = data.rescaled(length=1e3, mass=1e-3, time=10.0)
    told, scaled = data.quality["transfer"], other.quality["transfer"]
    assert np.allclose(scaled["frequencies"], np.array(told["frequencies"]) / 10.0)
    assert np.allclose(scaled["response"], np.array(told["response"]) * 1e2 / 1e-3)  # s2 / kg
    assert np.allclose(scaled["matrix"], np.array(told["matrix"]) * 1e2 / 1e-3, atol=0.0)
    assert scaled["relative"] == told["relative"]
    assert "Response to loads up to 100 Hz" in data.report()
    assert "basis Rubin()" in reduction.reduce(fe, ENDS, 2, basis="Rubin").report()


def test_parts_and_kept_models_take_a_basis(tmp_path, monkeypatch, fe):
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path))
    first = parts.reduced(fe, ENDS, 3, basis=reduction.Rubin())
    assert first.quality["basis"] == "Rubin()"
    assert parts.reduced(fe, ENDS, 3, basis="CraigBampton").quality["basis"] == "CraigBampton()"
    assert len(list(tmp_path.glob("*.h5"))) == 2
    assert replace(reduction.Krylov(), order=3).order == 3


def test_a_bound_does_not_outlive_the_shapes_and_axes_it_was_made_for(fe):
    solid = block()
    data = reduction.reduce(solid, {"a": "left", "b": "right"}, 2, error_up_to=2000.0, compare=0)
    assert "transfer" not in data.selected(5).quality
    assert "transfer" in data.selected(data.n_modes).quality
    before = np.array(data.quality["transfer"]["by_input"])
    quarter = np.array(data.rotated([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).quality["transfer"]["by_input"])
    assert quarter[:, :3] == pytest.approx(before[:, [1, 0, 2]])
    slanted = np.array(data.rotated((0.0, 0.0, 0.3)).quality["transfer"]["by_input"])
    assert np.all(slanted[:, 0] >= 0.95 * before[:, 0])
    matrix = np.array(data.quality["transfer"]["matrix"])
    turned = np.array(data.rotated([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).quality["transfer"]["matrix"])
    assert turned[:, :, 0, 1] == pytest.approx(-matrix[:, :, 1, 0], abs=1e-9 * np.abs(matrix).max())
    assert turned[:, :, 1, 2] == pytest.approx(matrix[:, :, 0, 2], abs=1e-9 * np.abs(matrix).max())
    planar = reduction.reduce(fe, ENDS, 2, error_up_to=100.0, compare=0)
    assert "transfer" not in planar.mirrored("yz").quality


def test_a_selection_says_what_statics_it_left(fe):
    """Compliance of four of ten coordinates at the ends of the beam, beside its matrices: the report's static error was
    that of all."""
    data = reduction.reduce(fe, ENDS, 8, loads={"rail": reduction.Track(list(range(41)), (0, 1, 0))}, error_up_to=50.0)
    few = data.selected(4)
    full, modal = at_ends(fe, few)
    kept = np.diag(of_reduced(few, modal, [0.0], 0.0)[0]).real / np.diag(of_beam(fe, full, [0.0], 0.0)[0]).real
    told = few.quality["warnings"][-1]
    assert f"4 of {data.n_modes} coordinates are kept" in told
    assert f" {100 * (1 - kept).mean():.3g} % of the static deflection" in told
    assert f" {100 * (1 - kept).max():.3g} % of one of them" in told
    assert "missing" not in few.quality["tracks"]["rail"]
    assert few.quality["tracks"]["rail"]["places"] == data.quality["tracks"]["rail"]["places"]
    assert "rail  " not in few.report()
    assert data.selected(data.n_modes).quality == data.quality


def test_model_files_name_a_basis(tmp_path, monkeypatch):
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "bodies"))
    bar = """
[[body]]
kind = "FloatingBody"
name = "bar"
[body.data]
{basis}
interfaces = { a = [0.0, 0.0, 0.0], b = [1.0, 0.0, 0.0] }
[[body.data.pieces]]
kind = "Line"
points = [[0, 0, 0], [1, 0, 0]]
elements = 8
section = { kind = "Section.rectangle", width = 0.02, height = 0.02 }
material = "steel"
"""
    for number, (line, found) in enumerate(
        [
            ('basis = "Rubin"\nmodes = 3', "Rubin()"),
            (
                'basis = { kind = "Krylov", frequencies = [0, 100] }',
                "Krylov(frequencies=(0.0, 100.0), order=1, two_sided=False)",
            ),
            ("", "CraigBampton()"),
        ]
    ):
        path = tmp_path / f"bar{number}.toml"
        path.write_text('name = "bar"\n' + bar.replace("{basis}", line))
        assert fmb.load_model(path).body("bar").data.quality["basis"] == found
