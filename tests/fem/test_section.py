"""Constants of cross-sections against closed forms, tables and a finite element solution of St-Venant
torsion."""

from math import pi

import numpy as np
import pytest
from tolerances import MACHINE

from flexmb import fem
from flexmb.errors import MeshError
from flexmb.fem import Section
from flexmb.fem.frames import shapes as section_shapes


def torsion_by_elements(inside, width, height, n):
    """J = 4 int psi of Prandtl's function -lap psi = 1, by scikit-fem's quadratic quadrilaterals; holes
    float freely."""
    import skfem
    from skfem.helpers import dot, grad

    mesh = skfem.MeshQuad.init_tensor(
        np.linspace(-width / 2, width / 2, n[0] + 1), np.linspace(-height / 2, height / 2, n[1] + 1)
    )
    basis = skfem.Basis(mesh, skfem.ElementQuad2())
    centre = mesh.p[:, mesh.t].mean(axis=1)
    hole = ~inside(*centre)
    stiff = np.where(hole, 1e9, 1.0)  # the stress function is constant in a hole, free outside
    k = skfem.BilinearForm(lambda u, v, w: stiff[:, None] * dot(grad(u), grad(v))).assemble(basis)
    f = skfem.LinearForm(lambda v, w: v).assemble(basis)
    psi = skfem.solve(*skfem.condense(k, f, D=basis.get_dofs()))
    return 4.0 * float(f @ psi)


def test_rectangle_torsion_constants_of_the_book():
    """Timoshenko & Goodier, Theory of Elasticity, table in art. 109: J = beta a b^3."""
    for ratio, beta in ((1.0, 0.1406), (1.5, 0.196), (2.0, 0.229), (3.0, 0.263), (10.0, 0.312)):
        assert Section.rectangle(ratio * 0.01, 0.01).torsion / (ratio * 1e-8) == pytest.approx(beta, abs=6e-4)


def test_rectangle_bending_is_named_by_its_plane():
    section = Section.rectangle(0.02, 0.01)
    assert section.inertia_z == pytest.approx(0.01 * 0.02**3 / 12, rel=MACHINE)
    assert section.inertia_y == pytest.approx(0.02 * 0.01**3 / 12, rel=MACHINE)
    assert section.shear_y == pytest.approx(5 / 6, rel=MACHINE)


def test_round_sections_have_closed_forms():
    tube = Section.tube(0.04, 0.003)
    assert tube.torsion == pytest.approx(pi / 32 * (0.04**4 - 0.034**4), rel=MACHINE)
    assert Section.solid_circle(0.04).area == pytest.approx(pi * 0.04**2 / 4, rel=MACHINE)
    assert tube.polar_inertia == pytest.approx(tube.torsion, rel=MACHINE)


def test_rectangle_torsion_against_elements():
    found = torsion_by_elements(lambda y, z: np.full(y.shape, True), 0.03, 0.01, (24, 12))
    assert Section.rectangle(0.03, 0.01).torsion == pytest.approx(found, rel=1e-5)


@pytest.mark.parametrize(("wall", "tolerance"), [(0.005, 0.03), (0.0025, 0.015)])
def test_box_torsion_against_elements(wall, tolerance):
    """A closed box: the Prandtl function is an unknown constant over the hole, its load is the area of the
    hole."""
    width, height = 0.1, 0.06
    found = torsion_by_elements(
        lambda y, z: (np.abs(y) > width / 2 - wall) | (np.abs(z) > height / 2 - wall), width, height, (40, 24)
    )
    assert Section.box(width, height, wall).torsion == pytest.approx(found, rel=tolerance)


def test_i_torsion_against_elements():
    """An open section: only its own elements, so the surroundings are held at zero by mirroring the
    rectangle's edge."""
    import skfem
    from skfem.helpers import dot, grad

    width, height, flange, web = 0.1, 0.1, 0.01, 0.006
    y = np.unique(
        np.concatenate([np.linspace(-0.05, -0.003, 24), np.linspace(-0.003, 0.003, 5), np.linspace(0.003, 0.05, 24)])
    )
    z = np.unique(
        np.concatenate([np.linspace(-0.05, -0.04, 7), np.linspace(-0.04, 0.04, 40), np.linspace(0.04, 0.05, 7)])
    )
    mesh = skfem.MeshQuad.init_tensor(y, z)
    centre = mesh.p[:, mesh.t].mean(axis=1)
    mesh = mesh.remove_elements(
        np.flatnonzero((np.abs(centre[0]) > web / 2) & (np.abs(centre[1]) < height / 2 - flange))
    )
    basis = skfem.Basis(mesh, skfem.ElementQuad2())
    k = skfem.BilinearForm(lambda u, v, w: dot(grad(u), grad(v))).assemble(basis)
    f = skfem.LinearForm(lambda v, w: v).assemble(basis)
    found = 4.0 * float(f @ skfem.solve(*skfem.condense(k, f, D=basis.get_dofs())))
    assert Section.i(width, height, flange, web).torsion == pytest.approx(found, rel=0.01)


def test_cowper_factors():
    """Cowper 1966, table 1, and its thin-walled limit by shear flow (Jourawski) at poisson = 0."""
    assert Section.rectangle(1, 1, poisson=0.3).shear_y == pytest.approx(13 / 15.3, rel=MACHINE)
    assert Section.solid_circle(1, poisson=0.3).shear_z == pytest.approx(7.8 / 8.8, rel=MACHINE)
    thin = section_shapes.cowper_hollow_circle(1.0 - 1e-9, 0.3)
    assert thin == pytest.approx(2 * 1.3 / (4 + 0.9), rel=1e-6)  # 2 (1 + nu) / (4 + 3 nu)


@pytest.mark.parametrize("shape", ["box", "i"])
def test_shear_factors_by_shear_flow(shape):
    """Energy of the shear flow q = V S / I in thin walls equals V^2 / (2 G A kappa); Cowper's factor at
    poisson = 0."""
    b, h, flange, web = 0.08, 0.12, 0.004, 0.003
    webs = 2 if shape == "box" else 1
    inertia = 2 * b * flange * h**2 / 4 + webs * web * h**3 / 12
    s = np.linspace(0.0, b / 2, 2001)
    in_flange = flange * s * h / 2  # from the middle of a box flange, or from the tip of an I flange
    at_corner = in_flange[-1] if shape == "box" else 2 * in_flange[-1]
    z = np.linspace(-h / 2, h / 2, 2001)
    in_web = at_corner + web * (h**2 / 4 - z**2) / 2
    energy = (4 * np.trapezoid(in_flange**2, s) / flange + webs * np.trapezoid(in_web**2, z) / web) / inertia**2
    area = 2 * b * flange + webs * h * web
    formula = section_shapes.cowper_box if shape == "box" else section_shapes.cowper_i
    assert formula(b, h, flange, web, 0.0) == pytest.approx(1.0 / (energy * area), rel=1e-5)


def test_taper_interpolates_dimensions():
    middle = Section.rectangle(0.02, 0.04).between(Section.rectangle(0.04, 0.02), 0.5)
    assert middle == Section.rectangle(0.03, 0.03)
    values = Section.values(1.0, 2.0, 3.0, 4.0).between(Section.values(3.0, 2.0, 1.0, 4.0), 0.5)
    assert (values.area, values.inertia_z) == (2.0, 2.0)
    offset = Section.tube(0.04, 0.002).with_offsets(shear_center=(0.01, 0.0))
    assert offset.between(Section.tube(0.02, 0.002), 0.5).shear_center == (0.005, 0.0)


@pytest.mark.parametrize(
    ("make", "found", "remedy"),
    [
        (lambda: Section.rectangle(0.0, 0.1), "width = 0.0 m", "in metres"),
        (lambda: Section.tube(0.04, 0.02), "a wall of 0.02 m", "rectangle or solid_circle"),
        (lambda: Section.box(0.1, 0.05, 0.03), "a wall of 0.03 m", "rectangle or solid_circle"),
        (lambda: Section.i(0.1, 0.1, 0.01, 0.2), "web = 0.2 m", "in metres"),
        (
            lambda: fem.Section.values(1.0, 1.0, 1.0, 1.0, product_yz=2.0),
            "product_yz = 2.0 m4",
            "area centre",
        ),
    ],
)
def test_messages(make, found, remedy):
    with pytest.raises(MeshError) as caught:
        make()
    assert found in caught.value.found
    assert remedy in caught.value.remedy
