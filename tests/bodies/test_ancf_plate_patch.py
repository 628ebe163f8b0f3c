"""Patch tests of the plates: states of constant strain, curvature and twist are in equilibrium in any mesh."""

import numpy as np
import pytest
from bodies.ancf_states import SOFT
from by_turns import every_second
from contracts.random_models import derivative

import flexmb as fmb
from flexmb.system import compile
from flexmb.system.program import evaluate

KINDS = pytest.mark.parametrize("shear", [False, True], ids=["thin", "shear"])
H = 0.1
BENDING = SOFT.young * H**3 / 12.0 / (1.0 - SOFT.poisson**2)
UNEVEN = np.array([0.0, 0.5, 0.8, 1.5])


def plate(points, shear):
    return fmb.AncfPlate("p", points=points, thickness=H, material=SOFT, shear=shear)


def skewed():
    """A grid of parallelograms of different size."""
    return np.array([[(x + 0.3 * y, y - 0.1 * x, 0.0) for y in UNEVEN] for x in 1.2 * UNEVEN])


def distorted():
    """A grid whose inner points lie anywhere."""
    points = skewed()
    points[1:-1, 1:-1, :2] += 0.1 * np.array([[(1, -1), (-0.5, 0.7)], [(0.8, 0.9), (-1, 0.4)]])
    return points


def inner_forces(body, q):
    """Return the forces on the nodes inside (n, k) and the greatest force on any."""
    system = compile(fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0)))
    work = system.workspace()
    work.weights[0].wanted = 0
    evaluate(system.program, system.state(0.0, q.ravel()), work)
    ns, nt = body.elements
    grid = body.surface.cells.reshape(ns, nt, 4)
    inside = np.unique(grid[1:, 1:, 0])
    forces = work.residual.reshape(len(body.surface.r), -1)
    return forces[inside], np.abs(forces).max()


@pytest.mark.parametrize(
    ("shear", "points"),
    [(False, skewed()), (True, skewed()), (True, distorted())],
    ids=["thin, skewed", "shear, skewed", "shear, distorted"],
)
def test_membrane(shear, points):
    """A linear map of the plane, with large strain: no force inside, the same membrane forces everywhere."""
    body = plate(points, shear)
    F = np.array([[1.2, 0.1, 0.0], [-0.2, 0.9, 0.0], [0.0, 0.0, 1.0]])
    q = body.initial_state()[0].reshape(-1, 3) @ F.T
    forces, greatest = inner_forces(body, q)
    np.testing.assert_allclose(forces, 0.0, atol=1e-12 * greatest)
    found = body.resultants(q.ravel(), [(0.1, 0.2), (0.5, 0.5), (0.9, 0.3)])  # between and beyond the middles
    first = body.surface.cells[0]
    e = body.surface.r[first[1]] - body.surface.r[first[0]]
    e, n = e / np.linalg.norm(e), np.array([0.0, 0.0, 1.0])
    if not np.array_equal(points, distorted()):  # there the axes of the elements differ
        axes = np.stack([e, np.cross(n, e)])
        E = axes @ (0.5 * (F.T @ F - np.eye(3))) @ axes.T
        stress = (
            SOFT.young
            * H
            / (1 - SOFT.poisson**2)
            * np.array(
                [E[0, 0] + SOFT.poisson * E[1, 1], E[1, 1] + SOFT.poisson * E[0, 0], (1 - SOFT.poisson) * E[0, 1]]
            )
        )
        np.testing.assert_allclose(found[:, :3], np.tile(stress, (3, 1)), rtol=1e-10)
    np.testing.assert_allclose(found[:, 3:], 0.0, atol=1e-10 * greatest)


@pytest.mark.parametrize(
    "curvature", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.4, -0.7, 0.3)], ids=["x", "y", "twist", "all"]
)
@pytest.mark.parametrize(
    ("shear", "points"),
    [(False, skewed()), (True, skewed()), (True, distorted())],
    ids=["thin, skewed", "shear, skewed", "shear, distorted"],
)
def test_bending_and_twist(shear, points, curvature):
    """A small deflection w of constant curvature: no force inside, and the moments of the closed form."""
    body = plate(points, shear)
    a, b, c = curvature

    def bent(size):
        nodal = body.initial_state()[0].reshape(len(body.surface.r), -1, 3).copy()
        x, y = nodal[:, 0, 0].copy(), nodal[:, 0, 1].copy()
        slope = size * np.stack([a * x + c * y, b * y + c * x], axis=1)
        nodal[:, 0, 2] = size * (0.5 * a * x * x + 0.5 * b * y * y + c * x * y)
        if shear:
            nodal[:, 1, :2] = -slope
        else:
            nodal[:, 1:, 2] = np.einsum("nvi,ni->nv", nodal[:, 1:, :2], slope)
        return nodal

    rate = derivative(lambda x: inner_forces(body, bent(x))[0], 1e-3)
    np.testing.assert_allclose(rate, 0.0, atol=1e-9 * BENDING)
    found = body.resultants(bent(1e-6).ravel())[:, 3:6] / 1e-6
    # moments are those of curvature of the material above the surface: tension there if w bends down
    total = -BENDING * (1 + SOFT.poisson) * (a + b)
    np.testing.assert_allclose(found[:, 0] + found[:, 1], total, atol=1e-6 * BENDING)
    determinant = BENDING**2 * ((a + SOFT.poisson * b) * (b + SOFT.poisson * a) - ((1 - SOFT.poisson) * c) ** 2)
    np.testing.assert_allclose(found[:, 0] * found[:, 1] - found[:, 2] ** 2, determinant, atol=1e-5 * BENDING**2)


def deflection(shear, thickness, n=8):
    """Return the deflection in the middle of a square with hinged edges under pressure, as a multiple of p a4 / D."""
    material = fmb.Material(young=1e9, poisson=0.3, density=1e3)
    body = fmb.AncfPlate.rectangle(
        "p",
        edges=(1.0, 1.0),
        elements=(n, n),
        thickness=thickness,
        material=material,
        shear=shear,
        markers={"m": (0.5, 0.5)},
    )
    ground, joints = {}, ()
    for edge, turn in {
        "s0": (-np.pi / 2, 0, 0),
        "s1": (-np.pi / 2, 0, 0),
        "t0": (0, np.pi / 2, 0),
        "t1": (0, np.pi / 2, 0),
    }.items():
        body, own, hinges = body.held(edge, edge, fmb.Revolute, rotation=turn)
        ground, joints = {**ground, **own}, joints + hinges
    D = material.young * thickness**3 / 12.0 / (1.0 - material.poisson**2)
    pressure = 2.0 * D * thickness  # deflects by a hundredth of the thickness
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(markers=ground), body),
            joints=joints,
            gravity=(0, 0, 0),
            forces=(fmb.Pressure("p", load="p.pressure", amount=pressure),),
            sensors=(fmb.Position("m", marker="p.m"),),
        ),
        tolerance=1e-7,
    )
    return solution["m"][-1][2] * D / pressure


@pytest.mark.parametrize(("shear", "thickness"), every_second([False, True], [0.2, 0.05, 0.01, 0.001]))
def test_no_locking(shear, thickness):
    """Navier's 0.0040624 p a4 / D, plus 0.073671 p a2 / k G h of shear: 2.5 % with 8 by 8 elements, thick and thin.

    Hinged edges: w = w_Kirchhoff + psi / k G h with -Laplace psi = p (Wang 1995), both sums in closed form.
    """
    expected = 0.00406235
    if shear:  # D / k G h = h^2 / (5 (1 - nu)) for k = 5/6
        expected += 0.0736713 * thickness**2 / (5.0 * 0.7)
    assert deflection(shear, thickness) == pytest.approx(expected, rel=0.025)
