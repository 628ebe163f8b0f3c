"""Transverse shear of laminates: closed forms, and exact elasticity in cylindrical bending by the state space method
(N. J. Pagano, J. Compos. Mater. 3 (1969) 398-411)."""

import warnings

import numpy as np
import pytest
from scipy.linalg import expm

import flexmb as fmb
from flexmb import fem
from flexmb.fem.shells.laminate_block import laminate
from flexmb.fem.shells.laminate_shear import shear_compliance

INF = float("inf")
CARBON = np.diag([140e9, 9e9, 5e9])  # Poisson's ratio 0: nothing but shear bends beyond the beam theory
CARBON_ACROSS = (5e9, 3e9)
CORE = np.diag([1e6, 1e6, 1e5])
CORE_ACROSS = (220e6, 110e6)


def test_one_isotropic_layer_has_five_sixths():
    g, t = 27e9, 3e-3
    q = 70e9 / (1 - 0.3**2) * np.array([[1, 0.3, 0], [0.3, 1, 0], [0, 0, 0.35]])
    assert shear_compliance([(q, t, 0.4)], [(g, g)]) == pytest.approx(np.eye(2) * 6 / 5 / (g * t), rel=1e-12)


def test_a_ply_turns_as_a_tensor():
    """S = (6/5 t) R diag(1/G) R^T: a shear force along 1 shears along 2 as well."""
    t, angle = 2e-3, np.radians(30)
    c, s = np.cos(angle), np.sin(angle)
    a, b = (1 / x for x in CARBON_ACROSS)
    expected = (
        6 / 5 / t * np.array([[c * c * a + s * s * b, c * s * (a - b)], [c * s * (a - b), s * s * a + c * c * b]])
    )
    assert shear_compliance([(CARBON, t, angle)], [CARBON_ACROSS]) == pytest.approx(expected, rel=1e-12)


def test_a_sandwich_shears_in_its_core():
    """Thin faces: S = c / ((c + t)^2 G) along both axes of the honeycomb (D. Zenkert, Sandwich Construction, 1995)."""
    t, c = 0.2e-3, 20e-3
    face = np.diag([70e9, 70e9, 26e9])
    plies = [(face, t, 0.0), (CORE, c, 0.0), (face, t, 0.0)]
    found = shear_compliance(plies, [(INF, INF), CORE_ACROSS, (INF, INF)])
    assert found == pytest.approx(np.diag([c / (c + t) ** 2 / g for g in CORE_ACROSS]), rel=1e-3)


def deflection(layers, p):
    """Return the mean deflection under a load of 1 cos(p x) on a stack in cylindrical bending, exactly.

    Layers are (E, G, thickness), Poisson's ratio 0, rigid through the thickness. The state (u, w, s_zz, s_xz) has
    u' = -p w + s_xz / G, w' = 0, s_zz' = -p s_xz, s_xz' = p^2 E u for u sin, w cos, s_zz cos, s_xz sin (p x), signs by
    the equilibrium of a slice.
    """
    transfer = np.eye(4)
    for e, g, t in layers:
        a = np.zeros((4, 4))
        a[0, 1], a[0, 3] = p, 1 / g  # g_xz = u_z + w_x, w_x = -p w sin
        a[2, 3] = -p  # s_xz,x + s_zz,z = 0
        a[3, 0] = e * p * p  # s_xx,x + s_xz,z = 0, s_xx,x = -E p^2 u sin
        transfer = expm(a * t) @ transfer
    # bottom: s_zz = s_xz = 0; top: s_xz = 0, s_zz = 1
    block = transfer[2:, :2]
    return np.linalg.solve(block, [1.0, 0.0])[1]


@pytest.mark.parametrize("angles", [(0, 90, 0), (0, 90), (90, 0, 0, 90, 0), (0, 0, 90)])
@pytest.mark.parametrize("axis", [0, 1])
def test_cross_plies_beside_exact_elasticity(angles, axis):
    t = 1e-3
    plies = [(CARBON, t, np.radians(a)) for a in angles]
    layers = []
    for a in angles:
        along = (a == 90) == (axis == 1)
        layers.append((140e9 if along else 9e9, CARBON_ACROSS[0] if along else CARBON_ACROSS[1], t))
    a, b, d = (m[axis, axis] for m in laminate(plies, -len(angles) * t / 2))
    p = 0.05 / (len(angles) * t)  # a wave 125 times as long as the stack is thick
    shearing = abs(deflection(layers, p)) - 1 / ((d - b * b / a) * p**4)
    assert shear_compliance(plies, [CARBON_ACROSS] * len(plies))[axis, axis] == pytest.approx(shearing * p**2, rel=3e-3)


HONEYCOMB = """MAT1,1,70.+9,,0.,2700.
MAT8,2,1.+6,1.+6,0.,1.+5,220.+6,110.+6,50.
PCOMP,1,,,,,,,,+
+,1,.0005,0.,,2,.02,0.,,+
+,1,.0005,0."""
MODULI = """MAT1,1,70.+9,,0.,2700.
MAT2,2,1.+9,.3+9,,.5+9
PSHELL,1,1,.02,1,,2"""


def strip(tmp_path, angle, section, kind="CQUAD4", n=8):
    """A strip along x, clamped at one end; its first axis is turned by an angle."""
    length, width = 0.2, 0.05
    rows = ["BEGIN BULK", section]
    number = lambda i, j: 1 + i + (n + 1) * j  # noqa: E731
    rows += [f"GRID,{number(i, j)},,{length * i / n},{width * j / 2},0." for i in range(n + 1) for j in range(3)]
    for i in range(n):
        for j in range(2):
            a, b, c, d = number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)
            if kind == "CQUAD4":
                rows.append(f"CQUAD4,{2 * (i + n * j) + 1},1,{a},{b},{c},{d},{angle}")
            else:
                rows.append(f"CTRIA3,{2 * (i + n * j) + 1},1,{a},{b},{c},{angle}")
                rows.append(f"CTRIA3,{2 * (i + n * j) + 2},1,{d},{a},{c},{angle + 90.0}")
    rows += [f"SPC1,1,123456,{number(0, j)}" for j in range(3)]
    path = tmp_path / "strip.bdf"
    path.write_text("\n".join([*rows, "ENDDATA"]))
    return fem.read_deck(path, show=False)


def deflection_of_the_tip(fe):
    """Return the mean deflection of the end of a strip under a force of 1 N across it."""
    tips = np.flatnonzero(np.abs(fe.nodes[:, 0] - 0.2) < 1e-9)
    load = np.zeros(fe.ndof)
    for node, share in zip(tips[np.argsort(fe.nodes[tips, 1])], (0.25, 0.5, 0.25), strict=True):
        load[(fe.dofs[:, 0] == node) & (fe.dofs[:, 1] == 2)] = share
    held = fe.supports["spc_1"]
    free = ~np.isin(6 * fe.dofs[:, 0] + fe.dofs[:, 1], 6 * held[:, 0] + held[:, 1])
    u = np.zeros(fe.ndof)
    u[free] = np.linalg.solve(fe.K[free][:, free].toarray(), load[free])
    return float(load @ u)


@pytest.mark.parametrize("kind", ["CQUAD4", "CTRIA3"])
@pytest.mark.parametrize(("angle", "shear"), [(0.0, 220e6), (90.0, 110e6), (45.0, 440e6 / 3)])
def test_a_strip_of_honeycomb_by_direction(tmp_path, kind, angle, shear):
    """F l^3 / 3 B + F l S, each with the shear modulus of its direction; their mean was taken for all before."""
    tip = deflection_of_the_tip(strip(tmp_path, angle, HONEYCOMB, kind))
    bending = 70e9 * 0.05 * (0.021**3 - 0.02**3) / 12
    expected = 0.2**3 / 3 / bending + 0.2 * 0.02 / 0.0205**2 / shear / 0.05
    assert tip == pytest.approx(expected, rel=5e-3 if kind == "CQUAD4" else 1e-2)


@pytest.mark.parametrize("angle", [0.0, 60.0])
def test_shear_moduli_of_a_pshell(tmp_path, angle):
    """MID3 of a PSHELL is a MAT2 with G11, G12, G22 across: S = H^-1 / (5/6 t), turned with the material axes."""
    tip = deflection_of_the_tip(strip(tmp_path, angle, MODULI))
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    soft = np.linalg.inv(5 / 6 * 0.02 * np.array([[1e9, 0.3e9], [0.3e9, 0.5e9]]))
    along = np.array([c, -s])  # x in material axes
    bending = 70e9 * 0.05 * 0.02**3 / 12
    assert tip == pytest.approx(0.2**3 / 3 / bending + 0.2 / 0.05 * along @ soft @ along, rel=6e-3)


def test_shear_moduli_of_nothing_are_refused(tmp_path):
    with pytest.raises(fmb.MeshError, match=r"card PSHELL 1: TS/T = 0 with transverse shear moduli"):
        strip(tmp_path, 0.0, "MAT1,1,70.+9,,0.,2700.\nPSHELL,1,1,.02,1,,1,0.")


def test_a_layup_as_thick_as_the_element_is_wide(tmp_path):
    """One square element of four like plies, as thick as it is wide, is the PSHELL, and at its end Timoshenko."""
    tips = []
    for card in ("PCOMP,1\n,1,.1,,,1,.2\n,1,.3,,,1,.4\n", "PSHELL,1,1,1.,1,,1\n"):
        (tmp_path / "part.bdf").write_text(
            "BEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\n"
            f"CQUAD4,1,1,1,2,3,4\nMAT1,1,2.9+7,,0.,1.\nSPC1,1,123456,1,4\n{card}ENDDATA\n"
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            fe = fem.read_deck(tmp_path / "part.bdf", show=False)
        force = np.zeros((4, 6, 1))
        force[1:3, 2, 0] = 0.5
        u = fem.static(fe, fe.forces(force)[:, 0], fem.fixed_freedoms(fe, "spc_1"))
        tips.append(fe.field(u[:, None])[1, 2, 0])
    exact = 1.0 / (3.0 * 2.9e7 / 12.0) + 1.0 / (5.0 / 6.0 * 1.45e7)
    np.testing.assert_allclose(tips, exact, rtol=1e-4)
    assert tips[0] == pytest.approx(tips[1], rel=1e-9)
