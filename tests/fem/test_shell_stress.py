"""Stress of shell triangles at nodes: bending of a strip, order on an edge, folds, lonely cells."""

import warnings
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from fem.beams import plate

from flexmb import fem, reduction
from flexmb.errors import MeshError
from flexmb.fem.meshes.mesh import Mesh
from flexmb.model.material import Material

STEEL = Material(young=210e9, poisson=0.3, density=7850.0)
LENGTH, HEIGHT, T = 2.0, 0.5, 0.01


def bent(fe, curvature=1e-3):
    """Pure bending in the plane, u = -k x y, v = k (x2 + nu y2) / 2 about the middle, with its rotation: (n, 6, 1)."""
    x, y = fe.nodes[:, 0] - LENGTH / 2, fe.nodes[:, 1] - HEIGHT / 2
    field = np.zeros((len(x), 6, 1))
    field[:, 0, 0] = -curvature * x * y
    field[:, 1, 0] = 0.5 * curvature * (x**2 + STEEL.poisson * y**2)
    field[:, 5, 0] = curvature * x
    return field, -STEEL.young * curvature * y


@pytest.mark.parametrize("kind", ["triangle", "cross"])
@pytest.mark.parametrize("rows", [2, 8])
def test_bending_of_a_strip(kind, rows):
    """sigma = -E k y at every node: quadratics through exact displacements are the displacements."""
    fe = fem.shell(plate(4 * rows, rows, LENGTH, HEIGHT, kind), STEEL, T)
    field, expected = bent(fe)
    stress = fe.blocks[0].nodal_stress(field)
    assert np.abs(stress[:, 0, 0] - expected).max() < 1e-9 * np.abs(expected).max()
    assert np.abs(stress[:, [1, 3], 0]).max() < 1e-9 * np.abs(expected).max()


def test_a_loaded_strip_of_eight_triangles_over_its_height():
    """End moments on the finite elements themselves: the outer fibre has 6 M / (t h2) within 0.1 %."""
    fe = fem.shell(plate(32, 8, LENGTH, HEIGHT, "triangle"), STEEL, T)
    load, x, y = np.zeros((len(fe.nodes), 6, 1)), fe.nodes[:, 0], fe.nodes[:, 1] - HEIGHT / 2
    for end, sign in ((0.0, -1.0), (LENGTH, 1.0)):
        edge = np.flatnonzero(np.abs(x - end) < 1e-9)
        edge = edge[np.argsort(y[edge])]
        for a, b in pairwise(edge):  # a linear traction, 1 MPa in the outer fibre
            share = sign * 1e6 * T * (y[b] - y[a]) / (HEIGHT / 2)
            load[a, 0, 0] += share * (y[a] / 3 + y[b] / 6)
            load[b, 0, 0] += share * (y[a] / 6 + y[b] / 3)
    held = fem.with_supports(fe, directions=(2, 3, 4))
    middle = [int(np.linalg.norm(fe.nodes - (end, HEIGHT / 2, 0.0), axis=1).argmin()) for end in (0.0, LENGTH)]
    held = fem.with_supports(fem.with_supports(held, middle[:1], (0, 1)), middle[1:], (1,))
    field = held.field(fem.static(held, held.forces(load), None))
    outer = int(np.linalg.norm(fe.nodes - (LENGTH / 2, HEIGHT, 0.0), axis=1).argmin())
    assert fe.blocks[0].nodal_stress(field)[outer, 0, 0] == pytest.approx(1e6, rel=1e-3)


@pytest.mark.parametrize("side", [-1.0, 0.0, 1.0])
def test_bending_out_of_the_plane(side):
    """w = a x3 + b y2: curvatures w_xx = 6 a x, w_yy = 2 b; sigma = -C kappa t / 2 on the top."""
    a, b = 3e-3, -2e-3
    fe = fem.shell(plate(8, 4, LENGTH, HEIGHT, "triangle"), STEEL, T, stress_side=side)
    x, y = fe.nodes[:, 0], fe.nodes[:, 1]
    field = np.zeros((len(x), 6, 1))
    field[:, 2, 0] = a * x**3 + b * y**2
    field[:, 3, 0], field[:, 4, 0] = 2 * b * y, -3 * a * x**2
    nu, modulus = STEEL.poisson, STEEL.young / (1 - STEEL.poisson**2)
    expected = -0.5 * side * T * modulus * (6 * a * x + nu * 2 * b)
    top = fe.blocks[0].nodal_stress(field)[:, 0, 0] * np.sign(fe.blocks[0].axes[0, 2, 2])
    np.testing.assert_allclose(top, expected, atol=1e-9 * modulus * T * a)


def test_order_on_an_edge():
    """A smooth field, u = sin x cosh y, at all nodes: the greatest error falls with the square of the size."""
    errors = []
    for rows in (8, 16):
        fe = fem.shell(plate(2 * rows, rows, 1.0, HEIGHT, "triangle"), STEEL, T)
        x, y = 3.0 * fe.nodes[:, 0], 3.0 * fe.nodes[:, 1]
        field = np.zeros((len(x), 6, 1))
        field[:, 0, 0] = np.sin(x) * np.cosh(y)
        modulus = STEEL.young / (1 - STEEL.poisson**2)
        exact = 3.0 * modulus * np.cos(x) * np.cosh(y)
        errors.append(np.abs(fe.blocks[0].nodal_stress(field)[:, 0, 0] - exact).max())
    assert errors[0] / errors[1] > 3.3


def test_a_fold():
    """Two plates at a right angle, stretched along the fold by a field with a kink across it: each keeps its own."""
    flat = plate(8, 8, 1.0, 1.0, "triangle")
    points = flat.points.copy()
    up = points[:, 1] > 0.5
    points[up, 2], points[up, 1] = points[up, 1] - 0.5, 0.5
    fe = fem.shell(replace(flat, points=points), STEEL, T)
    field = np.zeros((len(points), 6, 1))
    field[:, 2, 0] = 1e-3 * points[:, 2]  # the wall is stretched upwards, the floor not at all
    stress = fe.blocks[0].nodal_stress(field)[:, :, 0]
    modulus = STEEL.young / (1 - STEEL.poisson**2)
    wall, floor = points[:, 2] > 1e-9, points[:, 1] < 0.5 - 1e-9
    np.testing.assert_allclose(stress[wall, 2], 1e-3 * modulus, rtol=1e-9)
    np.testing.assert_allclose(stress[floor], 0.0, atol=1e-9 * modulus)


def test_too_few_nodes_for_a_fit():
    """A lonely triangle and a strip of single triangles show the mean of their corners, as in constant strain."""
    for points, cells in (
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (2, 0, 0)], [(0, 1, 2), (1, 3, 2), (1, 4, 3)]),
    ):
        fe = fem.shell(Mesh(points=np.array(points, float), cells=(("triangle", np.array(cells)),)), STEEL, T)
        field = np.zeros((len(points), 6, 1))
        field[:, 0, 0] = 1e-3 * fe.nodes[:, 0]
        stress = fe.blocks[0].nodal_stress(field)[:, 0, 0]
        np.testing.assert_allclose(stress, 1e-3 * STEEL.young / (1 - STEEL.poisson**2), rtol=1e-9)


@pytest.mark.parametrize("side", [None, 0.0, 1.0])
def test_stress_without_bending_is_never_silent(side):
    """A reduction warns where nobody chose the side of the stress."""
    mesh = plate(2, 2, 1.0, 1.0, "quad")
    fe = fem.shell(mesh, STEEL, 0.01, stress_side=side)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        data = reduction.reduce(fe, {"a": 0}, 2)
    assert sum("middle surface, without bending" in str(w.message) for w in told) == (side is None)
    assert sum("middle surface" in w for w in data.quality["warnings"]) == (side is None)


@pytest.mark.parametrize("side", ["top", 1.5, float("nan"), True])
def test_sides_are_numbers_from_bottom_to_top(side):
    mesh = plate(2, 2, 1.0, 1.0, "quad")
    with pytest.raises(MeshError, match="stress_side"):
        fem.shell(mesh, STEEL, 0.01, stress_side=side)
