"""SID files: the identities of the format, and nothing lost on the way there and back."""

import re
from dataclasses import replace

import numpy as np
import pytest
from reduction.solids import block
from tolerances import MACHINE

import flexmb as fmb
from flexmb import reduction
from flexmb.errors import DataFileError
from flexmb.io.sid import read_sid, skew, write_sid
from flexmb.io.sid_text import read_sid_text


@pytest.fixture(scope="module", params=["buckens", "a"])
def data(request):
    return reduction.reduce(
        block(divisions=(4, 2, 1)),
        {"a": "left", "b": "right"},
        modes=3,
        frame=request.param,
        compare=0,
        damping=0.02,
        stations={"m": "mid"},
    )


@pytest.fixture(scope="module")
def stiffened():
    return reduction.reduce(
        block(divisions=(4, 2, 1)),
        {"a": "left", "b": "right"},
        modes=3,
        frame="a",
        compare=0,
        geometric_stiffness=True,
        loads={"air": "top"},
        preload={"air": 1e6},
    )


def blocks_of(path):
    return read_sid_text(path.read_text(), "test").blocks


def test_identities_of_the_format(data, tmp_path):
    """Ct0 = mdCM1^T, Ge = 2 Cr1, Cr1 antisymmetric, Oe0 = -J1/2 and -J1 (checked on published files; formats 1)."""
    b = blocks_of(write_sid(data, tmp_path / "x.sid"))
    size = max(np.abs(b["Ct"].m0).max(), np.abs(b["J"].m1).max() * 1e-3)
    assert np.abs(b["Ct"].m0 - b["mdCM"].m1[:, :, 0]).max() < MACHINE * size
    m = data.n_modes
    Cr1 = b["Cr"].m1.transpose(1, 2, 0)
    assert np.abs(b["Ge"].m0.reshape(m, 3, m) - 2 * Cr1).max() < MACHINE
    assert np.abs(Cr1 + Cr1.transpose(2, 1, 0)).max() < 100 * MACHINE * np.abs(Cr1).max()
    J1 = b["J"].m1[:, :, 0]  # xx yy zz xy xz yz
    expected = np.column_stack([-0.5 * J1[:, 0], -0.5 * J1[:, 1], -0.5 * J1[:, 2], -J1[:, 3], -J1[:, 5], -J1[:, 4]])
    np.testing.assert_allclose(b["Oe"].m0, expected, atol=MACHINE * np.abs(J1).max())


def test_gyroscopic_rows_are_those_of_the_lumped_sum(tmp_path):
    """Gr_k = -2 sum m r~ phi_k~ (Wallrapp), for a lumped mass matrix computed node by node."""
    from scipy import sparse

    fe = block(divisions=(3, 1, 1))
    fe = replace(fe, M=sparse.diags(np.repeat(np.linspace(1.0, 2.0, len(fe.nodes)), 3)).tocsr())
    data = reduction.reduce(fe, {"a": "left", "b": "right"}, modes=2, compare=0, stress=False)
    Gr = blocks_of(write_sid(data, tmp_path / "x.sid"))["Gr"].m0
    mass = np.linspace(1.0, 2.0, len(fe.nodes))
    assert data.n_modes >= 2
    for k in range(data.n_modes):
        expected = -2.0 * np.einsum("n,nab,nbc->ac", mass, skew(fe.nodes), skew(data.shapes[:, :, k]))
        np.testing.assert_allclose(Gr[:, 3 * k : 3 * k + 3], expected, atol=1e-11 * np.abs(Gr).max())


def assert_same_inertia(a, b, order_two=True):
    for name in ("vv", "vw0", "vw1", "vn", "ww0", "ww1", "wn0", "wn1", "nn"):
        x, y = getattr(a, name), getattr(b, name)
        np.testing.assert_allclose(x, y, atol=1e-10 * max(np.abs(x).max(initial=0.0), 1e-3), err_msg=name)
    if order_two:  # only the symmetric part enters M_ww
        np.testing.assert_allclose(a.ww2 + a.ww2.swapaxes(0, 1), b.ww2 + b.ww2.swapaxes(0, 1), atol=1e-10)


def test_there_and_back(data, tmp_path):
    back = read_sid(write_sid(data, tmp_path / "body.sid"))
    assert back.name == "body"
    assert back.marker_names == data.marker_names
    assert_same_inertia(data.invariants, back.invariants)
    for name in (
        "marker_positions",
        "marker_translations",
        "marker_rotations",
        "stiffness",
        "frequencies",
        "damping_ratios",
    ):
        np.testing.assert_allclose(getattr(back, name), getattr(data, name), rtol=MACHINE, atol=MACHINE, err_msg=name)
    assert back.geometric is None


def test_geometric_stiffness_there_and_back(stiffened, tmp_path):
    """Modal rows for any motion: K0t A + K0r alpha + (K0w + centrifugal) w w, joint loads and preload."""
    back = read_sid(write_sid(stiffened, tmp_path / "body.sid"))
    assert_same_inertia(stiffened.invariants, back.invariants, order_two=False)
    rng = np.random.default_rng(1)
    w, alpha, A = rng.standard_normal((3, 3))
    B = skew(alpha) + skew(w) @ skew(w)
    rows = []
    for body in (stiffened, back):
        ww2 = body.invariants.ww2 + body.invariants.ww2.swapaxes(0, 1)
        rows.append(
            np.einsum("i,iab->ab", np.r_[A, B.ravel()], body.geometric.inertia)
            - 0.5 * np.einsum("a,jkab,b->jk", w, ww2, w)
        )
    np.testing.assert_allclose(rows[1], rows[0], atol=1e-10 * np.abs(rows[0]).max())
    g, h = stiffened.geometric, back.geometric
    np.testing.assert_allclose(h.interface, g.interface, atol=1e-12 * np.abs(g.interface).max())
    np.testing.assert_allclose(h.preload, g.preload, rtol=1e-12, atol=1e-9)


def test_what_geometric_stiffness_costs_in_inertia(stiffened, tmp_path):
    """Without J_2 the inertia of the deformed body is off by the square of the deformation; a plain file keeps it."""
    back = read_sid(write_sid(stiffened, tmp_path / "both.sid"))
    plain = read_sid(write_sid(replace(stiffened, geometric=None), tmp_path / "plain.sid"))

    def inertia(data, eta):
        i = data.invariants
        return i.ww0 + np.einsum("j,jab->ab", eta, i.ww1) + np.einsum("j,k,jkab->ab", eta, eta, i.ww2)

    eta = 1e-3 * np.random.default_rng(2).standard_normal(stiffened.n_modes)
    off = [np.linalg.norm(inertia(back, s * eta) - inertia(stiffened, s * eta)) for s in (1.0, 2.0)]
    assert off[1] == pytest.approx(4.0 * off[0], rel=1e-4)
    both = inertia(stiffened, eta) + inertia(stiffened, eta).T
    np.testing.assert_allclose(
        inertia(plain, eta) + inertia(plain, eta).T, both, rtol=1e-9, atol=1e-9 * np.abs(both).max()
    )
    moved = np.linalg.norm(stiffened.shapes @ eta, axis=1).max()
    assert 0.0 < off[0] < np.sqrt(2.0) * stiffened.mass * moved**2  # |u^2 I - u u^T| = sqrt(2) u^2


def test_the_same_motion(data, tmp_path):
    """A body spinning on a ball joint under a force, from the data and from their file."""

    def path(body):
        model = fmb.Model(
            gravity=(0, 0, -9.81),
            bodies=[
                fmb.Ground(markers={"O": tuple(body.marker_positions[0])}),
                fmb.FloatingBody("part", data=body, angular_velocity=(3.0, -20.0, 40.0)),
            ],
            joints=[fmb.Spherical("O", markers=("ground.O", "part.a"))],
            forces=[fmb.PointLoad("push", marker="part.b", force=(300.0, 200.0, -100.0))],
            sensors=[fmb.Position("b", marker="part.b")],
        )
        return fmb.simulate(model, 0.02, samples=5, integrator=fmb.GeneralizedAlpha(step=2e-4))["b"]

    found = path(read_sid(write_sid(data, tmp_path / "body.sid")))
    np.testing.assert_allclose(found, path(data), rtol=0, atol=1e-9)


def test_other_programs_write_other_layouts(data, tmp_path):
    """m1 as (row, column, mode), Fortran exponents, Ge by mode: read as the same body."""
    path = write_sid(data, tmp_path / "x.sid")
    m = data.n_modes

    def swap(match):
        return f"m1({match[1]},{match[3]},{match[2]}) ="

    text = re.sub(r"m1\(\s*(\d+),\s*(\d+),\s*(\d+)\) =", swap, path.read_text())
    head, ge, tail = re.split(r"(^ +Ge\n.*?end Ge\n)", text, flags=re.S | re.M)

    def by_mode(match):
        axis, mode = divmod(int(match[2]) - 1, m)
        return f"m0({match[1]},{3 * mode + axis + 1})"

    ge = re.sub(r"m0\(\s*(\d+),\s*(\d+)\)", by_mode, ge)
    other = tmp_path / "other.sid"
    other.write_text((head + ge + tail).replace("e+", "D+").replace("e-", "D-"))
    back = read_sid(other)
    assert_same_inertia(data.invariants, back.invariants)
    np.testing.assert_allclose(back.stiffness, data.stiffness, rtol=1e-14)


def damaged(data, tmp_path, change):
    path = write_sid(data, tmp_path / "x.sid")
    path.write_text(change(path.read_text()))
    return path


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (
            lambda t: t[: t.index("end Cr")],
            r"SID file '.*x\.sid': the block 'Cr' has no end\. Expected: an ASCII SID file",
        ),
        (lambda t: "hello\nworld\n", r"no Taylor block \(mdCM, J, Ct, \.\.\.\)"),
        (lambda t: re.sub(r" +Cr\n.*?end Cr\n", "", t, flags=re.S), r"no block Cr\. Expected: mdCM, J, Ct, Cr, Me, Ke"),
        (
            lambda t: t.replace("m0(    1,    1)       = ", "m0(    1,    1)       = ****"),
            r"'\*\*\*\*.*' in place of a number",
        ),
        (
            lambda t: t.replace("m0(    1,    1)", "m0(   99,    1)", 1),
            r"an index outside of block 'phi|AP|origin' ",
        ),
        (
            lambda t: re.sub(
                r"( +Ge\n)(.*?)(end Ge)",
                lambda x: x[1] + re.sub(r"= -?[1-9]\.", "= 7.", x[2]) + x[3],
                t,
                flags=re.S,
            ),
            r"Ge differs from 2 Cr1 by .* in the best layout\. Expected: an identity",
        ),
        (lambda t: t.replace("nrow         = ", "nrow         = x", 1), r"line \d+: the line 'nrow .*' in the block"),
        (lambda t: t.replace("m0(    1,    1)", "m0(    0,    1)", 1), r"the line 'm0\(    0,    1\) .* in the block"),
        (lambda t: t.replace("m0(    1,    1)", "m0(    1,    1", 1), r"the line 'm0\(    1,    1 .* in the block"),
        (
            lambda t: re.sub(r"(Me\n.*\n) *nrow .*\n *ncol .*\n", r"\1 nrow = 90000\n ncol = 90000\n", t),
            r"8\.1e\+09 numbers up to the block 'Me' .* in a file of \d+ bytes\. Expected: at most 1",
        ),
        (lambda t: re.sub(r"(Ct\n(?:.*\n){2} *ncol +=) 3", r"\1 4", t), r"the block 'Ct' is \d+ x 4 .*: \d+ x 3"),
        (lambda t: re.sub(r"mass  .*", "mass = 0", t), r"a mass of 0 kg\. Expected: a mass > 0"),
        (lambda t: re.sub(r"(Me\n(?:.*\n){6} *m0\(.*= ).*", r"\1-1.0", t), r"mode 1 has the modal mass -1 kg"),
        (lambda t: t.replace("e+00", "e+0d0", 1), r"in place of a number"),
        (lambda t: re.sub(r"(m0\(.*= ).*", r"\g<1>nan", t, count=1), r"'nan' in place of a number"),
    ],
)
def test_damaged_files(data, tmp_path, change, match):
    with pytest.raises(DataFileError, match=match):
        read_sid(damaged(data, tmp_path, change))


def test_cut_off_anywhere(data, tmp_path):
    """A file that ends early is refused wherever it ends, but for the last end marks, which carry nothing."""
    path = write_sid(data, tmp_path / "x.sid")
    whole = path.read_text()
    for end in np.linspace(0, whole.rindex("end Ke"), 41).astype(int):
        path.write_text(whole[:end])
        with pytest.raises(DataFileError, match=r"SID file '.*x\.sid'"):
            read_sid(path)


def test_missing_file(tmp_path):
    with pytest.raises(DataFileError, match=r"SID file '.*nothing\.sid': the file does not exist\..*Check the path"):
        read_sid(tmp_path / "nothing.sid")
