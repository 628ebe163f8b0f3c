"""MBDyn files: the invariants against sums over nodes and the deformed body, and nothing lost there and back."""

import re
from dataclasses import replace

import numpy as np
import pytest
from reduction.solids import block
from scipy import sparse
from tolerances import MACHINE, SOLVER

import flexmb as fmb
from flexmb import reduction
from flexmb.errors import DataFileError
from flexmb.io.mbdyn_fem import read_mbdyn_fem, write_mbdyn_fem
from flexmb.io.mbdyn_text import read_groups
from flexmb.io.sid import skew

ENDS = {"a": "left", "b": "right"}


@pytest.fixture(scope="module")
def lumped():
    """FE model with one mass per node, not the same everywhere, and the masses (n,)."""
    fe = block(divisions=(3, 1, 1))
    mass = np.linspace(0.01, 0.03, len(fe.nodes))
    return replace(fe, M=sparse.diags(np.repeat(mass, 3)).tocsr()), mass


@pytest.fixture(scope="module", params=["buckens", "a"])
def point_masses(request, lumped):
    fe, mass = lumped
    return reduction.reduce(fe, ENDS, modes=3, frame=request.param, compare=0), mass


@pytest.fixture(scope="module")
def stiffened():
    options = {"modes": 3, "frame": "a", "compare": 0, "damping": 0.02, "geometric_stiffness": True}
    return reduction.reduce(block(divisions=(4, 2, 1)), ENDS, stations={"m p": "mid"}, **options)


def groups_of(path, n):
    """The invariants of a file as the element of MBDyn indexes them (modal.cc, reading groups 14 to 18)."""
    record = read_groups(path, "test")
    g, m = record.groups, record.n_modes
    assert n == len(record.labels)
    return {
        "I3": g[14].reshape(3, m),
        "I4": g[15].reshape(3, m),
        "I8": g[16].reshape(3, m, 3).transpose(1, 0, 2),
        "I5": g[17].reshape(3, m, m),
        "I9": g[18].reshape(3, m, m, 3).transpose(1, 2, 0, 3),
        "mass": g[12][0],
        "c": g[12][1:4],
        "J": g[12][4:].reshape(3, 3),
    }


def assert_close(found, expected, scale=None):
    scale = np.abs(expected).max() if scale is None else scale
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e3 * MACHINE * scale)


def test_invariants_are_the_sums_over_the_nodes(point_masses, tmp_path):
    """I3 = sum m U, I4 = sum m f x U, I5_jk = sum m U_j x U_k, I8_j = -sum m f~ U_j~, I9_jk = sum m U_j~ U_k~."""
    data, mass = point_masses
    found = groups_of(write_mbdyn_fem(data, tmp_path / "x.fem"), 2)
    f, U = data.nodes, data.shapes
    fx, Ux = skew(f), skew(U.transpose(0, 2, 1))
    size = np.abs(np.einsum("n,nab,njbc->jac", mass, fx, Ux)).max()
    assert_close(found["I3"], np.einsum("n,naj->aj", mass, U), mass.sum() * np.abs(U).max())
    assert_close(found["I4"], np.einsum("n,naj->aj", mass, np.cross(f[:, :, None], U, axis=1)), size)
    assert_close(found["I5"], np.einsum("n,najk->ajk", mass, np.cross(U[:, :, :, None], U[:, :, None, :], axis=1)))
    assert_close(found["I8"], -np.einsum("n,nab,njbc->jac", mass, fx, Ux))
    assert_close(found["I9"], np.einsum("n,njab,nkbc->jkac", mass, Ux, Ux))


def test_deformed_inertia_as_the_program_adds_it(point_masses, tmp_path, rng):
    """J = I7 + I8 q + (I8 q)^T - I9 q q, S = I2 + I3 q, momentum of the modes = (I4 + I5 q) q': the deformed nodes'."""
    data, mass = point_masses
    g = groups_of(write_mbdyn_fem(data, tmp_path / "x.fem"), 2)
    q = 0.02 * rng.standard_normal(data.n_modes) / np.abs(data.shapes).max()
    rate = rng.standard_normal(data.n_modes)
    place, velocity = data.nodes + data.shapes @ q, data.shapes @ rate
    I7 = g["J"] + g["mass"] * (g["c"] @ g["c"] * np.eye(3) - np.outer(g["c"], g["c"]))
    first = np.einsum("jab,j->ab", g["I8"], q)
    J = I7 + first + first.T - np.einsum("jkab,j,k->ab", g["I9"], q, q)
    exact = -np.einsum("n,nab,nbc->ac", mass, skew(place), skew(place))
    assert_close(J, exact)
    with_plus = J + 2 * np.einsum("jkab,j,k->ab", g["I9"], q, q)  # the sign of the manual's formula
    assert np.abs(with_plus - exact).max() > 1e-4 * np.abs(exact).max()
    assert_close(g["mass"] * g["c"] + g["I3"] @ q, mass @ place)
    momentum = (g["I4"] + np.einsum("ajk,j->ak", g["I5"], q)) @ rate
    assert_close(momentum, mass @ np.cross(place, velocity))
    # Coriolis moment as in modal.cc, 2 (I8 - I9 q) q' w, is the rate of J at w and w x momentum of the modes
    w = rng.standard_normal(3)
    found = 2 * (np.einsum("jab,j->ab", g["I8"], rate) - np.einsum("jkab,j,k->ab", g["I9"], q, rate)) @ w
    exact = 2 * mass @ np.cross(place, np.cross(w, velocity))
    assert_close(found, exact)


def test_stress_stiffening_as_the_program_adds_it(stiffened, tmp_path, rng):
    """K + 1-6 w w + 7-9 w' + 10-12 (a - g) + forces on the body (modalad.cc) = what flexmb adds, for any motion."""
    record = read_groups(write_mbdyn_fem(stiffened, tmp_path / "x.fem"), "test")
    K0 = record.stress_stiffness
    assert sorted(K0) == list(range(1, 12 + 6 * 2 + 1))
    w, alpha, A = rng.standard_normal((3, 3))
    load = rng.standard_normal((2, 6))
    pairs = [w[0] ** 2, w[1] ** 2, w[2] ** 2, w[0] * w[1], w[1] * w[2], w[2] * w[0]]
    found = sum(factor * K0[k + 1] for k, factor in enumerate([*pairs, *alpha, *A, *load.ravel()]))
    field = np.r_[A, (skew(alpha) + skew(w) @ skew(w)).ravel()]
    g = stiffened.geometric
    expected = np.einsum("i,iab->ab", field, g.inertia) + np.einsum("ni,niab->ab", load, g.interface)
    assert_close(found, expected)


def same_numbers(a, b, names):
    for name in names:
        x, y = getattr(a, name), getattr(b, name)
        np.testing.assert_allclose(y, x, rtol=0, atol=1e-10 * max(np.abs(x).max(initial=0.0), 1e-6), err_msg=name)


def test_there_and_back(stiffened, tmp_path):
    back = read_mbdyn_fem(write_mbdyn_fem(stiffened, tmp_path / "body.fem"))
    assert back.name == "body"
    assert back.marker_names == ("a", "b", "m_p")
    assert back.n_interfaces == 2
    names = ("marker_positions", "marker_translations", "marker_rotations", "stiffness", "frequencies")
    same_numbers(stiffened, back, (*names, "damping_ratios"))
    names = ("vv", "vw0", "vw1", "vn", "ww0", "ww1", "ww2", "wn0", "wn1", "nn")
    same_numbers(stiffened.invariants, back.invariants, names)
    same_numbers(stiffened.geometric, back.geometric, ("inertia", "interface"))


def test_a_preload_stiffens(stiffened, tmp_path):
    preload = np.diag(np.linspace(1.0, 2.0, stiffened.n_modes)) * stiffened.stiffness[0, 0]
    data = replace(stiffened, geometric=replace(stiffened.geometric, preload=preload))
    back = read_mbdyn_fem(write_mbdyn_fem(data, tmp_path / "body.fem"))
    assert_close(back.stiffness, stiffened.stiffness + preload)


def test_the_same_accelerations(stiffened, tmp_path):
    """A spinning, loaded body on a ball joint."""

    def accelerations(data):
        body = fmb.FloatingBody("part", data=data, angular_velocity=(3.0, -20.0, 40.0))
        model = fmb.Model(
            gravity=(0, 0, -9.81),
            bodies=[fmb.Ground(markers={"O": tuple(data.marker_positions[0])}), body],
            joints=[fmb.Spherical("O", markers=("ground.O", "part.a"))],
            forces=[fmb.PointLoad("push", marker="part.b", force=(300.0, 200.0, -100.0))],
        )
        return fmb.accelerations(model)["part"]

    back = read_mbdyn_fem(write_mbdyn_fem(stiffened, tmp_path / "body.fem"))
    np.testing.assert_allclose(accelerations(back), accelerations(stiffened), rtol=SOLVER)


def test_legacy_files_end_with_group_13(stiffened, tmp_path):
    path = write_mbdyn_fem(stiffened, tmp_path / "old.fem", legacy=True)
    assert [int(n) for n in re.findall(r"RECORD GROUP (\d+)", path.read_text())] == [*range(1, 11), 12, 13]
    back = read_mbdyn_fem(path)
    assert back.geometric is None
    assert not back.invariants.ww1.any()
    same_numbers(stiffened, back, ("stiffness", "mass", "center_of_mass", "inertia"))


def test_lumped_masses_give_the_couplings(point_masses, tmp_path):
    """Group 11 instead of 14 to 18: the invariants are built from the nodes, as the program does."""
    data, mass = point_masses
    path = write_mbdyn_fem(data, tmp_path / "lumped.fem", legacy=True, lumped_mass=mass)
    back = read_mbdyn_fem(path)
    assert len(back.marker_names) == 2 + len(data.nodes)
    names = ("vv", "vw0", "vw1", "vn", "ww0", "ww1", "wn0", "wn1", "nn")
    size = np.abs(data.invariants.wn1).max()
    for name in names:
        np.testing.assert_allclose(getattr(back.invariants, name), getattr(data.invariants, name), atol=1e-9 * size)
    same_numbers(data.invariants, back.invariants, ("ww2",))


def test_files_of_other_programs(tmp_path):
    """The example of the manual: comments without stars, masses lumped, mass 3, J = diag(11, 3, 11)."""
    text = """three nodes
** RECORD GROUP 1, HEADER
 revision and so on
  REV0 3 3 0 0 1
** RECORD GROUP 2
 1001 1002 1003
these were labels
** RECORD GROUP 5, X
 0 0 0
** RECORD GROUP 6, Y
 -2.
 0
 2.D0
** RECORD GROUP 7
 0 0 0
** RECORD GROUP 8
** rejected
9 9 9 9 9 9 9 9 9 9 9 9
9 9 9 9 9 9
** 1
0 0 1 0 0 0
0 0 0 0 0 0
0 0 1 0 0 0
** 2
1 0 0 0 0 0
0 0 0 0 0 0
1 0 0 0 0 0
** RECORD GROUP 9
2 0
0 2
** RECORD GROUP 10
1 0
0 1e2
** RECORD GROUP 11
1 1 1 1 1 1
1 1 1 1 1 1
1 1 1 1 1 1
"""
    path = tmp_path / "hand.fem"
    path.write_text(text)
    data = read_mbdyn_fem(path)
    assert data.marker_names == ("1001", "1002", "1003")
    np.testing.assert_allclose(data.mass, 3.0)
    np.testing.assert_allclose(data.inertia, np.diag([11.0, 3.0, 11.0]))
    np.testing.assert_allclose(data.marker_translations[:, 2, 0], [1, 0, 1])
    np.testing.assert_allclose(2 * np.pi * data.frequencies, np.sqrt([0.5, 50.0]))


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (
            lambda t: t[: t.index("** RECORD GROUP 9")],
            r"MBDyn file '.*x\.fem': no record group 9, 10\. Expected: record groups",
        ),
        (lambda t: t.replace("REV0 3", "REV0 three"), r"the header 'REV0 three .*a revision and five whole numbers"),
        (lambda t: t.replace("REV0 3", "REV0 4"), r"3 of 4 values in record group 5\. Expected: 4, as the header says"),
        (lambda t: t.replace("  a\n  b\n  m_p\n", " a b\n"), r"2 of 3 values in record group 2"),
        (lambda t: t[: t.rindex("** END") - 2000], r"\d+ of \d+ values in record group 19"),
        (
            lambda t: re.sub(r"GROUP 12,.*\n", "GROUP 99,\n", t),
            r"neither record group 11 nor 12\. Expected: lumped masses",
        ),
        (lambda t: t.replace("REV0 3", "REV0 3000000000"), r"a header of 3000000000 nodes .*: the shapes and matrices"),
        (
            lambda t: re.sub(r"REV0 3 \d+ 0 0 0", "REV0 3 1 0 0 7", t),
            r"the header 'REV0 3 1 0 0 7'.*not all modes reject",
        ),
        (lambda t: re.sub(r"(GROUP 9,.*\n *)\S+", r"\1nan", t), r"0 of \d+ values in record group 9"),
        (lambda t: re.sub(r"(GROUP 9,.*\n *)\S+", r"\1-1.0", t), r"mode 1 has the modal mass -1 kg"),
        (lambda t: t.replace("\n  23\n", "\n  99\n"), r"index 99 in record group 19\. Expected: 1 to 30"),
    ],
)
def test_damaged_files(stiffened, tmp_path, change, match):
    path = write_mbdyn_fem(stiffened, tmp_path / "x.fem")
    path.write_text(change(path.read_text()))
    with pytest.raises(DataFileError, match=match):
        read_mbdyn_fem(path)


def test_refused(stiffened, tmp_path):
    with pytest.raises(DataFileError, match=r"MBDyn file '.*none\.fem': the file does not exist"):
        read_mbdyn_fem(tmp_path / "none.fem")
    twins = replace(stiffened, marker_names=("a b", "a_b", "c"))
    with pytest.raises(DataFileError, match=r"two markers with the label 'a_b'\. .*Rename one"):
        write_mbdyn_fem(twins, tmp_path / "x.fem")
    for options in ({"legacy": True, "lumped_mass": [1.0]}, {"lumped_mass": np.ones(len(stiffened.nodes))}):
        with pytest.raises(DataFileError, match=r"lumped_mass of shape .*MBDyn would add both.*one mass per node"):
            write_mbdyn_fem(stiffened, tmp_path / "x.fem", **options)
