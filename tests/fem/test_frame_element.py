"""The 12 x 12 matrices of beams against Przemieniecki's formulas and scikit-fem's Hermite element."""

import numpy as np
import pytest
from fem.beams import STEEL
from tolerances import MACHINE

from flexmb import fem
from flexmb.fem import Section
from flexmb.fem.frames.element import gauss

SECTION = Section.rectangle(0.03, 0.05)


def przemieniecki(section, length, shear):
    """Theory of Matrix Structural Analysis, table 11.1; u v w theta_x theta_y theta_z of both nodes."""
    e, g, L = STEEL.young, STEEL.shear, length
    k = np.zeros((12, 12))
    for a, value in ((0, e * section.area / L), (3, g * section.torsion / L)):
        k[np.ix_([a, a + 6], [a, a + 6])] = value * np.array([[1, -1], [-1, 1]])
    planes = (
        (1, 5, section.inertia_z, section.shear_y, 1.0),
        (2, 4, section.inertia_y, section.shear_z, -1.0),
    )
    for v, theta, inertia, kappa, sign in planes:
        phi = 12 * e * inertia / (g * section.area * kappa * L**2) if shear else 0.0
        s = sign * L
        block = np.array(
            [
                [12, 6 * s, -12, 6 * s],
                [6 * s, (4 + phi) * L**2, -6 * s, (2 - phi) * L**2],
                [-12, -6 * s, 12, -6 * s],
                [6 * s, (2 - phi) * L**2, -6 * s, (4 + phi) * L**2],
            ]
        )
        rows = [v, theta, v + 6, theta + 6]
        k[np.ix_(rows, rows)] = e * inertia / (L**3 * (1 + phi)) * block
    return k


def hermite_by_skfem(length, form):
    """Local 4 x 4 matrix (v, v', v, v') of scikit-fem's ElementLineHermite."""
    import skfem

    mesh = skfem.MeshLine(np.array([0.0, length]))
    basis = skfem.Basis(mesh, skfem.ElementLineHermite(), intorder=6)
    return skfem.BilinearForm(form).assemble(basis).toarray()


def local(fe_section=SECTION, length=0.7, **kwargs):
    return fem.frame([(0, 0, 0), (length, 0, 0)], section=fe_section, material=STEEL, **kwargs)


@pytest.mark.parametrize("shear", [True, False])
@pytest.mark.parametrize("length", [5e-4, 0.05, 0.7, 50.0])
def test_stiffness_is_the_book_formula(shear, length):
    found = local(length=length, shear=shear).K.toarray()
    expected = przemieniecki(SECTION, length, shear)
    scale = np.sqrt(np.outer(expected.diagonal(), expected.diagonal()))
    assert np.abs((found - expected) / scale).max() < MACHINE


def test_bending_matrices_are_those_of_scikit_fem():
    from skfem.helpers import d, dd, dot

    length, area = 0.7, SECTION.area
    fe = local(length=length, shear=False, rotary_inertia=False)
    bending = hermite_by_skfem(length, lambda u, v, w: dd(u)[0][0] * dd(v)[0][0])
    mass = hermite_by_skfem(length, lambda u, v, w: u * v)
    rows = [1, 5, 7, 11]
    ei = STEEL.young * SECTION.inertia_z
    np.testing.assert_allclose(
        fe.K.toarray()[np.ix_(rows, rows)], ei * bending, rtol=0, atol=MACHINE * ei * bending.max()
    )
    expected = STEEL.density * area * mass
    np.testing.assert_allclose(fe.M.toarray()[np.ix_(rows, rows)], expected, rtol=0, atol=MACHINE * expected.max())
    # the other plane: theta_y = -w'
    turn = np.diag([1.0, -1.0, 1.0, -1.0])
    rows = [2, 4, 8, 10]
    ei = STEEL.young * SECTION.inertia_y
    np.testing.assert_allclose(
        fe.K.toarray()[np.ix_(rows, rows)], ei * turn @ bending @ turn, atol=MACHINE * ei * bending.max()
    )
    # axial pull: geometric stiffness is that of a string with Hermite functions
    pull = np.zeros((2, 6))
    pull[1, 0] = 1e-3
    geometric = fe.blocks[0].geometric_stiffness(pull, fe.dofs).toarray()
    string = hermite_by_skfem(length, lambda u, v, w: dot(d(u), d(v)))
    force = STEEL.young * area * 1e-3 / length
    rows = [1, 5, 7, 11]
    np.testing.assert_allclose(geometric[np.ix_(rows, rows)], force * string, atol=MACHINE * force * string.max())


def test_rotary_inertia_is_that_of_scikit_fem():
    from skfem.helpers import d, dot

    with_it, without = (local(shear=False, rotary_inertia=r).M.toarray() for r in (True, False))
    slope = hermite_by_skfem(0.7, lambda u, v, w: dot(d(u), d(v)))
    rows = [1, 5, 7, 11]
    expected = STEEL.density * SECTION.inertia_z * slope
    found = (with_it - without)[np.ix_(rows, rows)]
    np.testing.assert_allclose(found, expected, atol=1e-10 * expected.max())


def test_axial_and_torsion_mass_are_linear():
    """rho A L / 6 [2 1; 1 2] and rho I_p L / 6 [2 1; 1 2] (scikit-fem's ElementLineP1 has the same mass)."""
    mass = local().M.toarray()
    pattern = np.array([[2, 1], [1, 2]]) * 0.7 * STEEL.density / 6
    np.testing.assert_allclose(mass[np.ix_([0, 6], [0, 6])], SECTION.area * pattern, rtol=MACHINE)
    np.testing.assert_allclose(mass[np.ix_([3, 9], [3, 9])], SECTION.polar_inertia * pattern, rtol=MACHINE)


def test_offset_centres_are_a_rigid_arm():
    """A section whose centres all lie at (y, z) is the centred beam moved by rigid arms."""
    y, z = 0.02, -0.03
    moved = SECTION.with_offsets(area_center=(y, z), shear_center=(y, z), mass_center=(y, z))
    arm = np.eye(6)
    arm[:3, 3:] = [[0, z, -y], [-z, 0, 0], [y, 0, 0]]
    both = np.kron(np.eye(2), arm)
    for matrix in ("K", "M"):
        centred, found = (getattr(local(s), matrix).toarray() for s in (SECTION, moved))
        expected = both.T @ centred @ both
        assert np.abs(found - expected).max() < MACHINE * np.abs(expected).max()


def test_force_through_the_shear_centre_does_not_twist():
    section = SECTION.with_offsets(shear_center=(0.02, 0.0))
    fe = fem.with_supports(local(section), "start")
    arm_moment = np.array([0, 0, 1.0, 0.02, 0, 0])  # force along z at y = 0.02: moment about x 0.02
    u = np.linalg.solve(fe.K.toarray(), arm_moment)
    assert abs(u[3]) < MACHINE * np.abs(u).max()
    u = np.linalg.solve(fe.K.toarray(), np.array([0, 0, 1.0, 0, 0, 0]))
    assert u[3] == pytest.approx(-0.02 * 0.7 / (STEEL.shear * SECTION.torsion), rel=1e-10)


def test_product_of_inertia_is_a_turned_section():
    """A rectangle turned by 30 degrees about x equals its turned axes."""
    angle = np.pi / 6
    c, s = np.cos(angle), np.sin(angle)
    iy, iz = SECTION.inertia_y, SECTION.inertia_z
    turned = Section.values(
        SECTION.area,
        iy * c * c + iz * s * s,
        iy * s * s + iz * c * c,
        SECTION.torsion,
        product_yz=(iz - iy) * s * c,
    )
    points = [(0, 0, 0), (0.7, 0, 0)]
    expected = fem.frame(points, section=SECTION, material=STEEL, orientation=(0, c, s))
    found = fem.frame(points, section=turned, material=STEEL)
    for matrix in ("K", "M"):
        a, b = getattr(expected, matrix).toarray(), getattr(found, matrix).toarray()
        assert np.abs(a - b).max() < 1e-11 * np.abs(a).max()


def test_taper_deflection_against_closed_form():
    """Cantilever, rectangle of width b, height tapering linearly h1 -> h2, tip force: integral of M^2 / EI,
    exact by quadrature."""
    root, tip, length = Section.rectangle(0.05, 0.05), Section.rectangle(0.05, 0.02), 1.0
    from scipy.integrate import quad

    def inertia(x):
        return 0.05 * (0.05 - 0.03 * x) ** 3 / 12

    expected = quad(lambda x: (length - x) ** 2 / (STEEL.young * inertia(x)), 0, length, epsabs=0, epsrel=1e-12)[0]
    for count, tolerance in ((1, 1e-3), (4, 1e-6)):
        points = np.linspace((0, 0, 0), (1, 0, 0), count + 1)
        fe = fem.frame(points, section=(root, tip), material=STEEL, shear=False)
        fe = fem.with_supports(fe, "start")
        load = np.zeros(fe.ndof)
        load[-4] = 1.0
        found = np.linalg.solve(fe.K.toarray(), load)[-4]
        assert found == pytest.approx(expected, rel=tolerance)


def test_interpolation_reproduces_rigid_motions_and_nodes(rng):
    elements = local(Section.box(0.06, 0.04, 0.004)).blocks[0].elements
    ends = rng.standard_normal(12)
    np.testing.assert_allclose(elements.interpolation(0.0)[0] @ ends, ends[:6], atol=MACHINE * 10)
    np.testing.assert_allclose(elements.interpolation(1.0)[0] @ ends, ends[6:], atol=MACHINE * 10)


def test_gauss_points_sum_to_one():
    assert sum(weight for _, weight in gauss(4)) == pytest.approx(1.0, rel=MACHINE)
