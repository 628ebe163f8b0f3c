"""Nastran decks: every part weighs, bends and vibrates as closed forms and the blocks of `fem` say."""

import tracemalloc
import warnings

import numpy as np
import pytest
from scipy.optimize import brentq

from flexmb import fem, reduction
from flexmb.errors import MeshError
from flexmb.fem.deck.inventory import mass_and_center
from flexmb.fem.deck.nastran import read_nastran_deck

E, RHO, LENGTH = 210e9, 7850.0, 2.0
WIDTH, HEIGHT = 0.05, 0.08  # along z and along y of the bar

quiet = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")
pytestmark = quiet


def deck(tmp_path, bulk, control="", name="part.bdf", **options):
    """Read the bulk data of a deck."""
    path = tmp_path / name
    path.write_text(f"SOL 103\nCEND\n{control}\nBEGIN BULK\n{bulk}\nENDDATA\n")
    return fem.read_deck(path, show=False, **options)


def beam(count=20, card="CBAR", prop=None, extra="", shift=lambda k: "", grid=lambda k, x: f"GRID,{k},,{x},0.,0."):
    """Return the bulk data of a straight beam along x of BAR section."""
    rows = [grid(k + 1, LENGTH * k / count) for k in range(count + 1)]
    rows += [f"{card},{k + 1},1,{k + 1},{k + 2},0.,1.,0.{shift(k)}" for k in range(count)]
    rows += [prop or f"PBARL,1,1,,BAR,,,,,+\n+,{WIDTH},{HEIGHT}", f"MAT1,1,{E:.6e},,.3,{RHO}", "SPC1,1,123456,1"]
    return "\n".join([*rows, extra])


def bernoulli(inertia, area):
    """First three frequencies of a cantilever, Hz."""
    roots = np.array([1.8751040687, 4.6940911330, 7.8547574382])
    return (roots / LENGTH) ** 2 * np.sqrt(E * inertia / (RHO * area)) / (2 * np.pi)


def test_cantilever_of_bars(tmp_path):
    fe = deck(tmp_path, beam(40), "SPC = 1", lumped=False)
    found = fem.eigenmodes(fe, "spc", 4).frequencies
    weak = bernoulli(HEIGHT * WIDTH**3 / 12, WIDTH * HEIGHT)
    strong = bernoulli(WIDTH * HEIGHT**3 / 12, WIDTH * HEIGHT)
    np.testing.assert_allclose(found[:3], [weak[0], strong[0], weak[1]], rtol=6e-3)  # shear and rotary inertia
    mass, centre = mass_and_center(fe)
    np.testing.assert_allclose(
        [mass, *centre], [RHO * WIDTH * HEIGHT * LENGTH, LENGTH / 2, 0, 0], rtol=1e-12, atol=1e-12
    )


def test_lumped_masses_are_points(tmp_path):
    """As in Nastran: half of a bar at each end, without rotary inertia; COUPMASS asks for the consistent matrix."""
    fe = deck(tmp_path, beam(4))
    assert fe.M.diagonal()[fe.dofs[:, 1] >= 3].max() == 0.0
    assert (fe.M != fe.M.T).nnz == 0
    np.testing.assert_array_equal((fe.M - fe.M.multiply(np.eye(fe.ndof))).nnz, 0)
    coupled = deck(tmp_path, beam(4, extra="PARAM,COUPMASS,1"))
    assert coupled.M.diagonal()[coupled.dofs[:, 1] >= 3].max() > 0.0


def test_a_continuation_whose_name_has_a_blank(tmp_path):
    """`+ A` behind eight fields was taken for two more: "10 fields in one line"."""
    card = "CONM2,9,2,,3.0,,,,,{}\n{},4.0,,5.0,,,6.0"
    plain, blank = (deck(tmp_path, beam(4, extra=card.format(mark, mark))) for mark in ("+A", "+ A"))
    assert (plain.M != blank.M).nnz == 0
    assert plain.M.diagonal()[plain.dofs[:, 1] == 5].max() == pytest.approx(6.0)


@pytest.mark.parametrize("word", ["0", "-1", "NO"])
def test_masses_that_are_not_coupled(tmp_path, word):
    """Only a positive COUPMASS couples; 0 did too. MSC Nastran lumps with 0, by the frequencies that it printed."""
    given = deck(tmp_path, beam(4, extra=f"PARAM,COUPMASS,{word}"))
    assert (given.M != deck(tmp_path, beam(4)).M).nnz == 0


@pytest.mark.parametrize("style", ["free", "small", "large", "continued"])
def test_field_formats_are_one_deck(tmp_path, style):
    def grid(k, x):
        if style == "small":
            return f"GRID    {k:8d}        {x:8.4f}      0.      0."
        if style == "large":
            return f"GRID*   {k:16d}                {x:16.9f}              0.+\n+                     0."
        return f"grid, {k},, {x} , 0., 0.0" if style == "free" else f"GRID,{k},,{x:.8f},+A\n+A,0.,0."

    if style == "continued":
        grid = lambda k, x: f"GRID,{k},,{x:.8f},0.,0.,,,,+A\n+A"  # noqa: E731
    np.testing.assert_allclose(deck(tmp_path, beam(5, grid=grid)).K.toarray(), deck(tmp_path, beam(5)).K.toarray())


def test_numbers_without_e(tmp_path):
    a = deck(tmp_path, beam(3).replace(f"{E:.6e}", "2.1+11"))
    np.testing.assert_allclose(a.K.toarray(), deck(tmp_path, beam(3)).K.toarray(), rtol=1e-12)


def test_blanks_before_an_exponent_and_before_the_star_of_a_name(tmp_path):
    """As in demonstration decks of NASTRAN-95: `10.4  +6`, and `CONM2  *` for fields of 16."""
    plain = deck(tmp_path, beam(3, extra="CONM2,5,2,,3.5"))
    apart = beam(3, extra=f"CONM2  *{5:16d}{2:16d}{'':16}{'3.5':>16}")
    apart = apart.replace(f"MAT1,1,{E:.6e},,.3,{RHO}", f"MAT1    1       2.1 +11         .3      {RHO}")
    assert "2.1 +11" in apart
    np.testing.assert_allclose(deck(tmp_path, apart).K.toarray(), plain.K.toarray(), rtol=1e-12)
    np.testing.assert_allclose(deck(tmp_path, apart).M.toarray(), plain.M.toarray(), rtol=1e-12)


def test_coordinate_systems(tmp_path):
    """A ring in cylindrical coordinates, on a system that stands on another one."""
    ring = [
        "CORD2R,7,0,1.,0.,0.,1.,0.,1.,+\n+,1.,1.,0.",
        "CORD2C,8,7,0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0.",
        *(f"GRID,{k + 1},8,2.,{45.0 * k},.5,8" for k in range(8)),
        *(f"CROD,{k + 1},1,{k + 1},{(k + 1) % 8 + 1}" for k in range(8)),
        "PROD,1,1,1.e-4,1.e-8",
        f"MAT1,1,{E:.6e},,.3,{RHO}",
    ]
    fe = deck(tmp_path, "\n".join(ring))
    angle = np.radians(45.0 * np.arange(8))  # x of system 7 is the basic y, y of it minus the basic x
    np.testing.assert_allclose(fe.nodes[:, :2], [[1 - 2 * np.sin(a), 2 * np.cos(a)] for a in angle], atol=1e-12)
    np.testing.assert_allclose(fe.nodes[:, 2], 0.5)
    np.testing.assert_array_equal(fe.labels, range(1, 9))


def test_offsets_move_the_stiffness(tmp_path):
    """Both ends off by the same arm: a beam that lies there, seen from the nodes."""
    arm = ",,+\n+,,,0.,.1,.2,0.,.1,.2"
    shifted = deck(tmp_path, beam(2, shift=lambda k: arm), lumped=False)
    straight = deck(tmp_path, beam(2), lumped=False)
    rigid = np.eye(6)
    rigid[:3, 3:] = [[0, 0.2, -0.1], [-0.2, 0, 0], [0.1, 0, 0]]
    turn = np.kron(np.eye(3), rigid)
    np.testing.assert_allclose(shifted.K.toarray(), turn.T @ straight.K.toarray() @ turn, rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(shifted.M.toarray(), turn.T @ straight.M.toarray() @ turn, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("through_rbe2", [False, True])
def test_offset_along_the_beam_is_a_lever_in_buckling(tmp_path, through_rbe2):
    """A column clamped below with a rigid piece a = L / 2 on top, under a dead load: tan(k L) = 1 / (k a).

    ``y'' + k^2 y = k^2 d`` with ``d = y(L) + a y'(L)``, k^2 = P / (E I) (Timoshenko and Gere, Theory of Elastic
    Stability, section 2.1, for the column alone).
    """
    length, count, inertia = 2.0, 16, 2e-6
    rows = [f"GRID,{k + 1},,{length * k / count},0.,0." for k in range(count)]
    rows.append(f"GRID,{count + 1},,{1.5 * length},0.,0.")
    for k in range(count):
        last = f",,+\n+,,,,,,{-0.5 * length},0.,0." if k == count - 1 else ""
        rows.append(f"CBAR,{k + 1},1,{k + 1},{k + 2},0.,1.,0.{last}")
    rows.append(f"PBAR,1,1,4.e-3,{inertia},{9 * inertia},1.e-6\nMAT1,1,{E:.6e},,.3,{RHO}")
    top = count + 1
    if through_rbe2:  # a link on the link: its reference carries the load, its dependent node the offset
        rows[count] = f"GRID,{count + 1},,{1.2 * length},0.,0."
        rows[-2] = rows[-2].replace(f"{-0.5 * length}", f"{-0.2 * length:.6g}")
        rows.append(f"GRID,90,,{1.5 * length},0.,0.\nRBE2,91,90,123456,{count + 1}")
        top = 90
    fe = deck(tmp_path, "\n".join(rows), lumped=False)
    node = int(np.flatnonzero(fe.labels == top)[0])
    load = np.zeros((len(fe.nodes), 6, 1))
    load[node, 0] = -1.0
    found = fem.buckling(fe, fe.forces(load)[:, 0], fixed=[0], n=1)[0][0]
    angle = brentq(lambda x: x * np.tan(x) - 2.0, 0.1, 1.5)
    assert found == pytest.approx(E * inertia * (angle / length) ** 2, rel=1e-3)


def test_pinned_end(tmp_path):
    """A bar clamped at A and hinged at B carries 3 E I / L^3 there instead of 12."""
    text = beam(1).replace("CBAR,1,1,1,2,0.,1.,0.", "CBAR,1,1,1,2,0.,1.,0.,,+\n+,,56")
    text = text.replace("PBARL,1,1,,BAR,,,,,+\n+,0.05,0.08", "PBAR,1,1,4.e-3,2.e-6,1.e-6,1.e-6")
    fe = deck(tmp_path, text)
    free = fe.dofs[:, 0] != 0  # node 2, and the end of the beam behind its hinge
    K = fe.K[free][:, free].toarray()
    row = list(map(tuple, fe.dofs[free])).index((1, 1))
    others = [k for k in range(len(K)) if k != row]
    stiff = K[row, row] - K[row, others] @ np.linalg.lstsq(K[np.ix_(others, others)], K[others, row], rcond=None)[0]
    assert stiff == pytest.approx(3 * E * 2e-6 / LENGTH**3, rel=1e-6)


def test_tapered_beam_weighs_its_volume(tmp_path):
    prop = "PBEAML,1,1,,BAR,,,,,+\n+,.04,.08,0.,YES,1.,.02,.04,0."
    fe = deck(tmp_path, beam(1, card="CBEAM", prop=prop), lumped=False)
    # area linear between the ends, as the program interpolates it
    assert mass_and_center(fe)[0] == pytest.approx(RHO * LENGTH * 0.5 * (0.0032 + 0.0008), rel=1e-9)


def test_concentrated_mass(tmp_path):
    mass = "CONM2,100,21,,5.,.1,.2,.3,,+\n+,.4,.01,.5,.02,.03,.6"
    fe = deck(tmp_path, beam(20, extra=mass))
    bare = deck(tmp_path, beam(20))
    added = (fe.M - bare.M).toarray()[-6:, -6:]
    x, y, z = 0.1, 0.2, 0.3
    arm = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    inertia = np.array([[0.4, -0.01, -0.02], [-0.01, 0.5, -0.03], [-0.02, -0.03, 0.6]])
    np.testing.assert_allclose(added[3:, 3:], 5 * arm.T @ arm + inertia, rtol=1e-12)
    np.testing.assert_allclose(added[:3, 3:], -5 * arm, atol=1e-12)
    np.testing.assert_allclose(
        mass_and_center(fe)[1] * mass_and_center(fe)[0] - mass_and_center(bare)[1] * mass_and_center(bare)[0],
        5 * np.array([LENGTH + x, y, z]),
        rtol=1e-9,
    )


def test_weight_in_pounds(tmp_path):
    fe = deck(tmp_path, beam(3, extra="PARAM,WTMASS,.00259"))
    assert mass_and_center(fe)[0] == pytest.approx(0.00259 * mass_and_center(deck(tmp_path, beam(3)))[0])


def test_rigid_element_and_mean(tmp_path):
    """RBE2 and RBE3 on a block; a load on the mean is spread, a rigid end moves as one."""
    fe = deck(tmp_path, block("RBE2,900,500,123456,2,4,6,8", "RBE3,901,,501,123456,1.,123,1,+\n+,3,5,7"))
    assert set(fe.reference_points) == {"rbe2_900", "rbe3_901"}
    rigid = fe.field(fe.rigid_motions())
    arms = fe.nodes
    np.testing.assert_allclose(rigid[:, :3, 4], np.cross([0, 1, 0], arms), atol=1e-12)  # links carry rigid motions
    data = reduction.reduce(fe, interfaces="all", modes=4, compare=0)
    assert data.marker_names == ("rbe2_900", "rbe3_901")
    np.testing.assert_allclose(data.marker_positions, [[1.0, 0.5, 0.5], [0.0, 0.5, 0.5]])


def block(*cards):
    """Return the bulk data of one hexahedron of 1 m with two more points at its ends."""
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    rows = [f"GRID,{k + 1},,{x}.,{y}.,{z}." for k, (x, y, z) in enumerate(corners)]
    rows += ["GRID,500,,1.,.5,.5", "GRID,501,,0.,.5,.5", "CHEXA,1,1,1,2,4,3,5,6,+\n+,8,7"]
    return "\n".join([*rows, "PSOLID,1,1", f"MAT1,1,{E:.6e},,.3,{RHO}", *cards])


@pytest.mark.parametrize("length", [1e-3, 2.0, 2400.0, 3e5])
@pytest.mark.parametrize("ends", ["123456", "1234,23", "12346,3"])
def test_rigid_bar_of_any_length(tmp_path, length, ends):
    """The far end moves as a rigid body does, in millimetres as well as in metres."""
    far = f"{length:.4e}".replace("e+", "+").replace("e-", "-")
    bushes = "CBUSH,1,6,1,,,,,0\nCBUSH,2,6,2,,,,,0\nPBUSH,6,K,1.,1.,1.,1.,1.,1."
    fe = deck(tmp_path, f"GRID,1,,0.,0.,0.\nGRID,2,,{far},0.,0.\nRBAR,7,1,2,{ends}\n{bushes}\nCONM2,1,1,,1.")
    assert fe.ndof == 6
    motion = fe.expansion.toarray()
    along = motion @ np.linalg.inv(motion[:6])  # six unit motions of node 1
    expected = np.eye(6)
    expected[1, 5], expected[2, 4] = length, -length
    np.testing.assert_allclose(along[6:12], expected, atol=1e-9 * max(length, 1.0))


def test_multipoint_constraint(tmp_path):
    """u_2x = 2 u_1x - u_3y, with components in the displacement system of node 2, which is turned by 90 degrees."""
    text = block("MPC,5,2,2,-1.,1,1,2.,,+\n+,,3,2,-1.", "CORD2R,9,0,0.,0.,0.,0.,0.,1.,+\n+,0.,1.,0.")
    fe = deck(tmp_path, text.replace("GRID,2,,1.,0.,0.", "GRID,2,,1.,0.,0.,9"), "MPC = 5")
    # direction 2 of the system 9 is minus the basic x
    field = fe.field(np.random.default_rng(1).standard_normal((fe.ndof, 1)))[:, :, 0]
    assert -field[1, 0] == pytest.approx(2 * field[0, 0] - field[2, 1])
    assert fe.ndof == deck(tmp_path, block()).ndof - 1


@pytest.mark.parametrize(
    ("terms", "match"),
    [
        ("2,12,-1.,1,1,2.", r"field 4 reads '12'.*one digit"),
        ("2,,-1.,1,1,2.", r"field 4 reads ''.*one digit"),
        ("2,2,0.,1,1,2.", "one with the factor 0"),
        ("2,2,0.,1,1,0.", "one with the factor 0"),
    ],
    ids=["several components", "no component", "nothing follows", "zeros"],
)
def test_multipoint_constraint_that_says_too_little(tmp_path, terms, match):
    with pytest.raises(MeshError, match=match):
        deck(tmp_path, block(f"MPC,5,{terms}"), "MPC = 5")


def test_bushing_between_coincident_nodes(tmp_path):
    text = "\n".join(
        ["GRID,1,,0.,0.,0.", "GRID,2,,0.,0.,0.", "CBUSH,1,1,1,2,,,,0", "PBUSH,1,K,1.,2.,3.,4.,5.,6.,+\n+,,B,.1"]
    )
    fe = deck(tmp_path, text + "\nCONM2,9,2,,1.\nCONM2,8,1,,1.")
    K = fe.K.toarray()
    np.testing.assert_allclose(np.diag(K)[:6], [1, 2, 3, 4, 5, 6])
    np.testing.assert_allclose(K[:6, 6:], -np.diag([1, 2, 3, 4, 5, 6.0]))
    assert fe.C is not None
    assert fe.C[0, 0] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("place", "x"),
    [
        (",,", 0.2),
        ("0.,,", 0.0),
        (".25,,", 0.1),
        ("1.,,", 0.4),
        ("0.,-1,.3", 0.0),
        (".25,0,.3,0.,0.", 0.3),
        (",7,.3,0.,0.", 0.35),
    ],
)
def test_place_of_a_bushing_on_an_arm(tmp_path, place, x):
    """A force at node 2, node 1 held: F / k + F (0.4 - x)^2 / k_r, where S, or OCID with S1 .. S3, puts the spring."""
    rows = ["GRID,1,,0.,0.,0.", "GRID,2,,.4,0.,0.", "CORD2R,7,,.05,0.,0.,.05,0.,1.,+\n+,1.05,0.,0."]
    rows += [f"CBUSH,1,1,1,2,,,,0,+\n+,{place}", "PBUSH,1,K,1.+5,2.+5,3.+5,1.+3,2.+3,3.+3"]
    fe = deck(tmp_path, "\n".join([*rows, "CONM2,9,2,,1.", "CONM2,8,1,,1."]))
    free = np.flatnonzero(fe.dofs[:, 0] == 1)
    force = (fe.dofs[free, 1] == 2) * 10.0
    moved = np.linalg.solve(fe.K.toarray()[np.ix_(free, free)], force)
    expected = 10.0 / 3e5 + 10.0 * (0.4 - x) ** 2 / 2e3
    assert moved[fe.dofs[free, 1] == 2] == pytest.approx(expected, rel=1e-9)


@pytest.mark.filterwarnings("default::flexmb.fem.meshes.mesh.MeshWarning")
@pytest.mark.parametrize(
    ("cards", "words"),
    [
        ("CBUSH,1,4,1,2,,,,0\nPBUSH,4,K,1.,1.,1.,1.,1.,1.,+\n+,,M,5.", r"PBUSH 4: mass M = 5 \(1\)"),
        ("CBUSH1D,1,4,1,2\nPBUSH1D,4,7.,,5.", r"PBUSH1D 4: mass M = 5 \(1\)"),
        ("CBUSH,1,4,1,2,,,,0\nPBUSH,4,KMAG,,3.", r"PBUSH 4: stiffness KMAG = 0, 3 \(1\)"),
    ],
)
def test_masses_of_bushings_are_left_out_by_name(tmp_path, cards, words):
    rows = ["GRID,1,,0.,0.,0.", "GRID,2,,.4,0.,0.", cards, "CELAS2,8,1.,1,1,2,1", "CONM2,9,2,,1.", "CONM2,8,1,,1."]
    with pytest.warns(fem.MeshWarning, match=words):
        fe = deck(tmp_path, "\n".join(rows))
    assert mass_and_center(fe)[0] == pytest.approx(2.0)


@pytest.mark.parametrize(("kind", "flag", "factor"), [(8, "", 0.5), (8, 1, 5.0), (6, "", 0.25), (6, 1, 2.5)])
def test_thicknesses_at_corners_of_second_order_shells(tmp_path, kind, flag, factor):
    """T1 .. T4 are thicknesses, with TFLAG = 1 shares of the property's: the last field of CQUAD8 and of CTRIA6."""
    corners, middles = ["0.,0.", "1.,0.", "1.,1.", "0.,1."], [".5,0.", "1.,.5", ".5,1.", "0.,.5"]
    if kind == 8:  # the last node has number 1, as the flag has
        places = dict(zip((2, 3, 4, 5, 6, 7, 8, 1), [*corners, *middles], strict=True))
        card = f"CQUAD8,1,1,2,3,4,5,6,7,+\n+,8,1,.5,.5,.5,.5,,,+\n+,{flag}"
    else:
        places = dict(zip((2, 3, 5, 6, 7, 8), [*corners[:2], corners[3], ".5,0.", ".5,.5", "0.,.5"], strict=True))
        card = f"CTRIA6,1,1,2,3,5,6,7,8,+\n+,,,.5,.5,.5,{flag}"
    rows = [f"GRID,{k},,{xy},0." for k, xy in places.items()]
    fe = deck(tmp_path, "\n".join([*rows, card, "PSHELL,1,1,10.,1", "MAT1,1,7.+10,,.3,1."]))
    assert mass_and_center(fe)[0] == pytest.approx(factor)


def test_laminate_of_one_ply_is_a_plate(tmp_path):
    """A PCOMP of four plies of steel equals the PSHELL of their sum; one above the nodes equals an offset."""
    grids = "\n".join(f"GRID,{k + 1},,{x},{y},0." for k, (x, y) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)]))
    common = f"{grids}\nCQUAD4,1,1,1,2,3,4\nMAT1,1,{E:.6e},,.3,{RHO}\n"
    plate = deck(tmp_path, common.replace("x", "x") + "PSHELL,1,1,.02,1,,1")
    layers = deck(tmp_path, common + "PCOMP,1,,,,,,,SYM,+\n+,1,.005,0.,,1,.005,90.")
    np.testing.assert_allclose(layers.K.toarray(), plate.K.toarray(), rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose(layers.M.toarray(), plate.M.toarray(), rtol=1e-12)
    lower = deck(tmp_path, common + "PCOMP,1,0.\n+,1,.02,0.")  # all above the nodes
    offset = deck(tmp_path, common.replace("CQUAD4,1,1,1,2,3,4", "CQUAD4,1,1,1,2,3,4,,.01") + "PSHELL,1,1,.02,1,,1")
    x, t, curvature = lower.nodes[:, 0], 0.02, 1e-2
    field = np.zeros((4, 6, 1))  # bending about y that does not stretch the middle of the plate
    field[:, 0, 0], field[:, 2, 0], field[:, 4, 0] = t / 2 * curvature * x, curvature * x**2 / 2, -curvature * x
    for plate in (lower, offset):
        energy = 0.5 * float((plate.vectors(field).T @ plate.K @ plate.vectors(field))[0, 0])
        assert energy == pytest.approx(0.5 * E * t**3 / 12 / (1 - 0.09) * curvature**2, rel=1e-9)


@pytest.mark.parametrize("offset", [0.0, 0.03])
def test_stress_of_triangles_in_bending_is_exact(tmp_path, offset):
    """w = (a x^2 + b y^2) / 2 + c x y on an irregular mesh: -E' (a + nu b) t / 2 on top, at edges and corners too."""
    rng, n, thickness = np.random.default_rng(5), 5, 0.01
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1)))
    inside = (x > 0) & (x < 1) & (y > 0) & (y < 1)
    x[inside] += rng.uniform(-0.05, 0.05, inside.sum())
    rows = [f"GRID,{k + 1},,{a:.12f},{b:.12f},0." for k, (a, b) in enumerate(zip(x, y, strict=True))]
    for k, (i, j) in enumerate((i, j) for i in range(n) for j in range(n)):
        p = j * (n + 1) + i + 1
        rows += [f"CTRIA3,{2 * k + 1},1,{p},{p + 1},{p + n + 2},,{offset}"]
        rows += [f"CTRIA3,{2 * k + 2},1,{p},{p + n + 2},{p + n + 1},,{offset}"]
    fe = deck(tmp_path, "\n".join([*rows, f"PSHELL,1,1,{thickness},1", f"MAT1,1,{E:.6e},,.3,{RHO}"]))
    (block,) = (b for b in fe.blocks if b.cell_type == "triangle")
    a, b, c = 0.3, -0.2, 0.15
    w_x, w_y = a * x + c * y, b * y + c * x
    field = np.zeros((len(x), 6, 1))
    field[:, :, 0] = np.stack(  # nodes lie `offset` below the plane of the plate
        [offset * w_x, offset * w_y, 0.5 * (a * x * x + b * y * y) + c * x * y, w_y, -w_x, 0 * x], axis=1
    )
    factor = -0.5 * thickness * E / (1 - 0.3**2)
    expected = np.array([factor * (a + 0.3 * b), factor * (b + 0.3 * a), 0.0, factor * 0.7 * c, 0.0, 0.0])
    for side, sign in ((1.0, 1.0), (-1.0, -1.0)):
        found = block.surface_stress(field, side)[:, :, 0]
        np.testing.assert_allclose(found, np.tile(sign * expected, (len(x), 1)), atol=1e-6 * np.abs(expected).max())
    top = fem.read_deck(tmp_path / "part.bdf", show=False, stress_side=1)
    np.testing.assert_allclose(top.blocks[0].nodal_stress(field)[0, :, 0], expected, atol=1e-6 * np.abs(expected).max())
    with pytest.raises(MeshError, match="stress_side = 2"):
        fem.read_deck(tmp_path / "part.bdf", show=False, stress_side=2)


def test_missing_midside_node_and_pyramid(tmp_path):
    """Constant strain passes through hexahedra with left out midside nodes and split pyramids."""
    text = block().replace("CHEXA,1,1,1,2,4,3,5,6,+\n+,8,7", "CHEXA,1,1,1,2,4,3,5,6,+\n+,8,7,600")
    fe = deck(tmp_path, text + "\nGRID,600,,.5,0.,0.")
    strain = np.array([[1e-3, 2e-3, 0], [0, -1e-3, 5e-4], [3e-4, 0, 2e-3]])
    field = np.zeros((len(fe.nodes), 6, 1))
    field[:, :3, 0] = fe.nodes @ strain.T
    force = fe.K @ fe.vectors(field)
    apex = "\n".join(["GRID,700,,.5,.5,2.", "CPYRAM,2,1,5,6,8,7,700"])
    assert mass_and_center(deck(tmp_path, block(apex)))[0] == pytest.approx(RHO * (1 + 1 / 3))
    inner = fe.dofs[:, 0] == list(fe.labels).index(600)
    assert np.abs(force[inner]).max() <= 1.1 * np.abs(force).max()
    energy = 0.5 * float((fe.vectors(field).T @ force)[0, 0])
    sym = 0.5 * (strain + strain.T)
    lame, shear = E * 0.3 / (1.3 * 0.4), E / 2.6
    assert energy == pytest.approx(0.5 * lame * np.trace(sym) ** 2 + shear * (sym**2).sum(), rel=1e-9)


def test_supports_are_kept_not_applied(tmp_path):
    fe = deck(tmp_path, beam(3, extra="SPC,2,4,13\nSPCADD,3,1,2"), "SPC = 3")
    assert set(fe.supports) == {"spc", "spc_1", "spc_2", "spc_3"}
    assert fe.ndof == 24
    np.testing.assert_array_equal(fe.supports["spc_2"], [[3, 0], [3, 2]])
    assert fem.fixed_freedoms(fe, "spc").sum() == 8


def test_include_from_the_main_deck_and_beside(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "a.inc").write_text("INCLUDE 'b.inc'\nINCLUDE 'top.inc'\n")
    (tmp_path / "sub" / "b.inc").write_text(beam(3))
    (tmp_path / "top.inc").write_text("CONM2,77,2,,1.\n")
    fe = deck(tmp_path, "INCLUDE 'sub/a.inc'")
    assert mass_and_center(fe)[0] == pytest.approx(1 + RHO * WIDTH * HEIGHT * LENGTH)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("GRID,2,", "GRID,99,"), r"names the node 2, which does not exist"),
        (("MAT1,1,", "MAT1,2,"), r"the material 1, which does not exist"),
        (("PBARL,1,", "PBARL,5,"), r"part.bdf:\d+, card CBAR 1.*the property 1, which does not exist"),
        (("BAR,,,,,+\n+,0.05,0.08", "BAR,,,,,+\n+,0.05,abc"), r"field 11 reads 'abc'"),
        (("PBARL,1,1,,BAR", "PBARL,1,1,,RAIL"), r"the shape RAIL.*BAR"),
        (("GRID,3,,", "GRID,3,42,"), r"coordinate system 42, which does not exist"),
        (("MAT1,1,", "MAT10,1,"), r"MAT10"),
        (("CBAR,1,1,1,2,0.,1.,0.", "CBAR,1,1,1,2,1.,0.,0."), r"along the beam"),
        (("CBAR,2,1,2,3", "CBAR,2,1,2,2"), r"ends at one place"),
        (("SPC1,1,123456,1", "INCLUDE 'part.bdf'"), r"include each other"),
        (("SPC1,1,123456,1", "INCLUDE 'gone.bdf'"), r"INCLUDE 'gone.bdf': no such file"),
        (("SPC1,1,123456,1", "CORD2R,3,4,,,,,,1.,+\n+,1.\nCORD2R,4,3,,,,,,1.,+\n+,1.\nGRID,50,3,1."), r"3 -> 4 -> 3"),
        (("SPC1,1,123456,1", "RBE2,5,1,123456,2\nRBE2,6,3,123456,2"), r"depends on RBE2 5.*RBE2 6"),
        (("SPC1,1,123456,1", "RBE2,5,1,123456,2\nRBE2,6,2,123456,1"), r"follows itself"),
        (("SPC1,1,123456,1", "RBE3,5,,1,123456,1.,123,2,3,+\n+,4"), r"do not determine.*Add points"),
        (("SPC1,1,123456,1", "GRID,2,,5.,0.,0."), r"grid point 2 a second time"),
    ],
)
def test_bad_decks(tmp_path, change, words):
    text = beam(3)
    assert change[0] in text
    with pytest.raises(MeshError, match=f"(?s){words}"):
        deck(tmp_path, text.replace(*change, 1))


def test_binary_junk(tmp_path):
    path = tmp_path / "part.bdf"
    path.write_bytes(bytes(range(256)) * 20)
    with pytest.raises(MeshError, match="binary"):
        fem.read_deck(path)


@pytest.mark.filterwarnings("default::flexmb.fem.meshes.mesh.MeshWarning")
def test_what_is_left_out_is_said(tmp_path):
    with pytest.warns(fem.MeshWarning, match=r"left out: CGAP: contact; give the mechanism .* \(1\)"):
        with_gap = deck(tmp_path, beam(3, extra="CGAP,60,2,1,2,1.,0.,0.\nPGAP,2,0.,,1.e6"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plain = deck(tmp_path, beam(3))
    assert abs(with_gap.K - plain.K).max() == 0.0  # nothing of the gap's stiffness came in
    assert with_gap.K.nnz > 0


def test_inventory(tmp_path, capsys):
    path = tmp_path / "part.bdf"
    path.write_text(f"BEGIN BULK\n{beam(3)}\nENDDATA\n")
    fem.read_deck(path)
    text = capsys.readouterr().out
    assert "3 CBAR, 4 GRID, 1 PBARL, 1 SPC1" in text
    assert "mass          62.8 at (1, 0, 0)" in text


def test_mutated_decks_never_end_in_a_traceback(tmp_path):
    """600 decks with changed, lost and repeated bytes: read, or refused by name."""
    random = np.random.default_rng(20261122)
    seeds = [beam(3, extra="CONM2,9,2,,1.,.1,.2\nRBE2,5,1,123456,4"), block("RBE3,901,,501,123456,1.,123,1,+\n+,3,5,7")]
    path = tmp_path / "m.bdf"
    refused = 0
    for k in range(600):
        data = bytearray(f"CEND\nBEGIN BULK\n{seeds[k % 2]}\nENDDATA\n".encode())
        for _ in range(int(random.integers(1, 4))):
            at = int(random.integers(20, len(data)))
            kind = random.integers(4)
            if kind == 0:
                data[at] = int(random.integers(32, 127))
            elif kind == 1:
                del data[at : at + int(random.integers(1, 12))]
            elif kind == 2:
                data[at:at] = data[at : at + int(random.integers(1, 30))]
            else:
                data[at:at] = random.choice([b"-1", b"9" * 20, b"1e308", b",,,", b"nan", b"THRU"])
        path.write_bytes(bytes(data))
        try:
            fem.read_deck(path, show=False)
        except MeshError:
            refused += 1
    assert 50 < refused < 590


@pytest.mark.parametrize("end", ["\r\n", "\r"])
def test_line_ends_of_other_systems(tmp_path, end):
    """A tetrahedron, with tabs and comments in some lines; messages still name the line."""
    text = (
        "BEGIN BULK\nGRID\t1\t\t0.\t0.\t0.  $ origin\nGRID,2,,1.,0.,0.\n$ comment\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n"
    )
    text += "CTETRA,1,1,1,2,3,4\nPSOLID,1,1\nMAT1,1,2.1+11,,.3,7850.\n"
    path = tmp_path / "ends.bdf"
    path.write_bytes((text + "ENDDATA\n").replace("\n", end).encode())
    fe = fem.read_deck(path, show=False)
    np.testing.assert_array_equal(fe.nodes, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    path.write_bytes((text + "GRID,5,,x,0.,0.\nENDDATA\n").replace("\n", end).encode())
    with pytest.raises(MeshError, match=r"ends\.bdf:10, card GRID"):
        fem.read_deck(path, show=False)


@pytest.mark.slow
def test_memory_of_reading(tmp_path):
    """A deck of 64 000 nodes takes less than 2.7 times its file at its peak (2.4), all buffers of Python counted."""
    n, lines = 40, ["BEGIN BULK"]
    for k in range(n**3):
        x, y, z = 0.01 * (k % n), 0.01 * (k // n % n), 0.01 * (k // n**2)
        lines.append(f"GRID    {k + 1:8d}        {x:8.4f}{y:8.4f}{z:8.4f}")
    corner = [1 + a + n * b + n * n * c for c in range(n - 1) for b in range(n - 1) for a in range(n - 1)]
    for label, p in enumerate(corner, 1):
        q = p + n * n
        lines.append(f"CHEXA   {label:8d}       1{p:8d}{p + 1:8d}{p + 1 + n:8d}{p + n:8d}{q:8d}{q + 1:8d}+")
        lines.append(f"+       {q + 1 + n:8d}{q + n:8d}")
    lines += ["PSOLID         1       1", "MAT1           1 2.1+11              .3   7850.", "ENDDATA"]
    path = tmp_path / "cube.bdf"
    path.write_text("\n".join(lines))
    size = path.stat().st_size
    del lines
    tracemalloc.start()
    read = read_nastran_deck(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(read.labels) == n**3
    assert peak < 2.7 * size


def test_geometry_of_p_elements_and_k6rot_are_named(tmp_path, capsys):
    """Curved edges are left out by name; PARAM,K6ROT, which holds shells in their plane, stands among what was read."""
    bulk = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nCQUAD4,1,1,1,2,3,4\n"
    bulk += "PSHELL,1,1,.01,1\nMAT1,1,2.1+11,,.3,7850.\nPARAM,K6ROT,100.\nFEEDGE,9,1,2,,GMCURV,5\n"
    path = tmp_path / "part.bdf"
    path.write_text(f"BEGIN BULK\n{bulk}ENDDATA\n")
    with pytest.warns(fem.MeshWarning, match=r"FEEDGE: curved edges"):
        fem.read_deck(path)
    assert "K6ROT" in capsys.readouterr().out


NSM_DECK = (
    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,3.,0.,0.\nGRID,6,,3.,1.,0.\n"
    "CQUAD4,1,1,1,2,3,4\nCQUAD4,2,1,2,5,6,3\nPSHELL,1,1,.01,1\nCBAR,3,2,1,4,1.,0.,0.\nPBARL,2,1,,ROD\n,.02\n"
    "CROD,4,3,5,6\nPROD,3,1,1.-4\nMAT1,1,2.1+11,,.3,0.\n"
)


@pytest.mark.parametrize(
    ("cards", "mass"),
    [
        ("NSM1,7,PSHELL,5.,1", 15.0),  # per area on 1 + 2 m2
        ("NSM1,7,PSHELL,5.,ALL", 15.0),
        ("NSM1,7,ELEMENT,5.,2", 10.0),
        ("NSML1,7,PSHELL,6.,1", 6.0),  # a total
        ("NSML1,7,ELEMENT,6.,1,THRU,2", 6.0),
        ("NSM,7,PBARL,2,4.\nNSM,7,PROD,3,3.", 7.0),  # per length on 1 m each
        ("NSML,7,PROD,3,2.5", 2.5),
        ("NSMADD,7,11,12\nNSM1,11,PSHELL,1.,1\nNSML1,12,PBARL,2.,2", 5.0),
        ("NSM1,8,PSHELL,5.,1", 0.0),  # not chosen
    ],
)
def test_nonstructural_mass_of_lists(tmp_path, cards, mass):
    fe = deck(tmp_path, f"{NSM_DECK}{cards}", control="NSM = 7")
    assert mass_and_center(fe)[0] == pytest.approx(mass, rel=1e-12, abs=1e-20)


def test_totals_are_shared_out_by_area(tmp_path):
    """6 kg on plates of 1 and 2 m2 whose centres lie at x = 0.5 and 2."""
    fe = deck(tmp_path, f"{NSM_DECK}NSML1,7,PSHELL,6.,1", control="NSM = 7", lumped=False)
    np.testing.assert_allclose(mass_and_center(fe)[1], [(2 * 0.5 + 4 * 2.0) / 6, 0.5, 0.0], atol=1e-12)


def test_nonstructural_mass_that_fits_nothing(tmp_path):
    with pytest.raises(MeshError, match=r"NSM1 7: no elements of PBEAM 1"):
        deck(tmp_path, f"{NSM_DECK}NSM1,7,PBEAM,5.,1", control="NSM = 7")


@pytest.mark.filterwarnings("default::flexmb.fem.meshes.mesh.MeshWarning")
def test_materials_without_density_are_named(tmp_path):
    """MAT1 2 of the bar weighs nothing; MAT1 3, which only bends and shears the plate, has no mass to give."""
    rows = ["GRID,1,,0.,0.,0.", "GRID,2,,1.,0.,0.", "GRID,3,,1.,1.,0.", "GRID,4,,0.,1.,0.", "CQUAD4,1,1,1,2,3,4"]
    rows += ["PSHELL,1,1,.01,3,,3", "MAT1,1,7.+10,,.3,2700.", "MAT1,2,7.+10,,.3", "MAT1,3,7.+10,,.3"]
    rows += ["CROD,2,2,1,2", "PROD,2,2,1.-4"]
    with pytest.warns(fem.MeshWarning, match=r"materials without density, .*: MAT1 2$"):
        fe = deck(tmp_path, "\n".join(rows))
    assert mass_and_center(fe)[0] == pytest.approx(27.0)


def test_permanent_supports_of_grdset(tmp_path):
    """GRDSET holds 1345 of all grid points without supports of their own: a beam that bends in one plane only."""
    rows = beam(10).replace("SPC1,1,123456,1", "SPC,1,1,123456").replace("GRID,5,,0.8,0.,0.", "GRID,5,,0.8,0.,0.,,5")
    fe = deck(tmp_path, "GRDSET,,,,,,,1345\n" + rows, "SPC = 1", lumped=False)
    held = {tuple(row) for row in fe.supports["grid_ps"].tolist()}
    assert held == {(n, d) for n in range(11) if n != 4 for d in (0, 2, 3, 4)} | {(4, 4)}
    whole = "GRDSET,,,,,,,1345\n" + beam(40).replace("SPC1,1,123456,1", "SPC,1,1,123456")
    found = fem.eigenmodes(deck(tmp_path, whole, "SPC = 1", lumped=False), "spc", 3).frequencies
    np.testing.assert_allclose(found, bernoulli(WIDTH * HEIGHT**3 / 12, WIDTH * HEIGHT), rtol=3e-2)


def test_bars_without_area_are_a_shear_frame(tmp_path):
    """Three storeys of bars with A = 0 and I1 = 50, 100, 150: k = 12 E I / l^3 = 600, 1200, 1800, no shear deformation.

    Masses 1, 1.5, 2: 14.5217, 31.0477, 46.0995 rad/s (R. W. Clough, J. Penzien, Dynamics of Structures, example of
    chapter 12; computed here from the matrices).
    """
    rows = ["GRID,1,,0.,300.,0.", "GRID,2,,0.,200.,0.", "GRID,3,,0.,100.,0.", "GRID,4,,0.,0.,0.", "MAT1,1,1.+6"]
    for k, (inertia, mass) in enumerate(((50.0, 1.0), (100.0, 1.5), (150.0, 2.0)), 1):
        rows += [f"PBAR,{k},1,0.,{inertia}", f"CBAR,{k},{k},{k},{k + 1},1.,0.,0.", f"CONM2,{k + 10},{k},,{mass}"]
    fe = deck(tmp_path, "\n".join([*rows, "SPC1,1,123456,4", "SPC1,1,23456,1,2,3"]), "SPC = 1")
    stiff = np.array([[600.0, -600.0, 0.0], [-600.0, 1800.0, -1200.0], [0.0, -1200.0, 3000.0]])
    mass = np.array([1.0, 1.5, 2.0])
    exact = np.sqrt(np.linalg.eigvalsh(stiff / np.sqrt(np.outer(mass, mass)))) / (2 * np.pi)
    np.testing.assert_allclose(2 * np.pi * exact, [14.5217, 31.0477, 46.0995], rtol=1e-4)
    np.testing.assert_allclose(fem.eigenmodes(fe, "spc", 3).frequencies, exact, rtol=1e-5)


def test_coupled_mass_of_rods_and_blanks_between_components(tmp_path):
    """COUPMASS of a CROD as MSC Nastran has it: 5/12 and 1/12 along, one half at each end across."""
    bulk = (
        "GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\nCROD,1,1,1,2\nPROD,1,1,3.-4\nMAT1,1,2.1+11,,.3,7850.\nPARAM,COUPMASS,1\n"
    )
    fe = deck(tmp_path, bulk + "SPC1    1       12 456  1\nSPC1    1       3       1", "SPC = 1")
    row = {(int(n), int(d)): k for k, (n, d) in enumerate(fe.dofs)}
    mass = RHO * 3e-4 * 2.0
    m = fe.M.toarray()
    along = m[np.ix_([row[0, 0], row[1, 0]], [row[0, 0], row[1, 0]])]
    across = m[np.ix_([row[0, 1], row[1, 1]], [row[0, 1], row[1, 1]])]
    np.testing.assert_allclose(along, mass * np.array([[5, 1], [1, 5]]) / 12, rtol=1e-12)
    np.testing.assert_allclose(across, mass * np.eye(2) / 2, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(fe.supports["spc"], [[0, k] for k in range(6)])


def test_factors_of_one_are_no_factors(tmp_path):
    """PARAM, CK1 is 1 by default: written so it changes nothing; 0 leaves the matrix out, an imaginary part damps."""
    for value, told in (("1.", False), ("1.0,0.0", False), ("2.", True), ("0.", True), ("1.,.02", True)):
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            fe = deck(tmp_path, beam(2, extra=f"PARAM,CK1,{value}"))
        listed = [words for words in fe.source["left_out"] if "CK1" in words]
        assert len(listed) == told
        assert any("CK1" in str(w.message) for w in found) == told


def test_equations_solved_together_are_all_named(tmp_path):
    """Two equations of a node with turned axes that say the same are refused with both names."""
    text = block("MPC,5,2,1,-1.,1,1,1.\nMPC,5,2,1,-2.,1,1,2.", "CORD2R,9,0,0.,0.,0.,0.,0.,1.,+\n+,.6,.8,0.")
    with pytest.raises(MeshError, match=r"bdf:19, MPC 5 and .*bdf:20, MPC 5: equations that do not determine"):
        deck(tmp_path, text.replace("GRID,2,,1.,0.,0.", "GRID,2,,1.,0.,0.,9"), "MPC = 5")
