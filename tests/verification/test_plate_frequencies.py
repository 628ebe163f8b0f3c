"""Eigenfrequencies of plates: Navier's and Mindlin's closed forms for hinged edges, Leissa's cantilever plate.

References: Navier's solution; Mindlin 1951 (rotary inertia and shear, k = 5/6); A. W. Leissa, Vibration of Plates,
NASA SP-160 (1969), square cantilever plate, nu = 0.3.
"""

import numpy as np
import pytest
from by_turns import slow

import flexmb as fmb

MATERIAL = fmb.Material(young=1e9, poisson=0.3, density=1e3)
HINGES = {"s0": (-np.pi / 2, 0, 0), "s1": (-np.pi / 2, 0, 0), "t0": (0, np.pi / 2, 0), "t1": (0, np.pi / 2, 0)}


def frequencies(n, h, shear, edges, joint):
    """Return w a2 sqrt(rho h / D) of a unit square of n by n elements."""
    body = fmb.AncfPlate.rectangle("p", edges=(1.0, 1.0), elements=(n, n), thickness=h, material=MATERIAL, shear=shear)
    ground, joints = {}, ()
    for edge in edges:
        body, own, held = body.held(edge, edge, joint, rotation=None if joint is fmb.Fixed else HINGES[edge])
        ground, joints = {**ground, **own}, joints + held
    found = fmb.linearize(fmb.Model(bodies=(fmb.Ground(markers=ground), body), joints=joints, gravity=(0, 0, 0)))
    D = MATERIAL.young * h**3 / 12.0 / (1.0 - MATERIAL.poisson**2)
    return 2.0 * np.pi * np.sort(found.frequencies) * np.sqrt(MATERIAL.density * h / D)


def mindlin(h, i, j):
    """Return the same of the exact hinged plate with shear: the lower root for waves i, j."""
    D, G = MATERIAL.young * h**3 / 12.0 / (1.0 - MATERIAL.poisson**2), MATERIAL.shear
    S, k2 = 5.0 / 6.0 * G * h, np.pi**2 * (i * i + j * j)
    stiffness = np.array([[S * k2, S * np.sqrt(k2)], [S * np.sqrt(k2), D * k2 + S]])
    mass = MATERIAL.density * np.array([h, h**3 / 12.0])
    w2 = np.linalg.eigvals(stiffness / mass[:, None]).real.min()
    return np.sqrt(w2 * MATERIAL.density * h / D)


def test_thin_hinged_square():
    """8 by 8 elements: 1 % of Navier for the first, 3.5 % for the fourth; order two from 4 by 4 on, from below."""
    exact = np.pi**2 * np.array([2, 5, 5, 8])
    coarse, fine = (frequencies(n, 0.01, False, HINGES, fmb.Revolute)[:4] for n in (4, 8))
    np.testing.assert_allclose(fine, exact, rtol=0.035)
    assert fine[0] == pytest.approx(exact[0], rel=0.01)
    assert np.log2((exact[0] - coarse[0]) / (exact[0] - fine[0])) == pytest.approx(2.0, abs=0.3)


@pytest.mark.parametrize("h", [slow(0.001), slow(0.01), slow(0.1), 0.2])
def test_shear_deformable_hinged_square(h):
    """8 by 8 elements, thin to thick: 2 % of Mindlin for the first mode, order two from 4 by 4 on."""
    exact = mindlin(h, 1, 1)
    coarse, fine = (frequencies(n, h, True, HINGES, fmb.Revolute)[0] for n in (4, 8))
    assert fine == pytest.approx(exact, rel=0.02)
    assert np.log2((coarse - exact) / (fine - exact)) == pytest.approx(2.0, abs=0.3)


@pytest.mark.parametrize(("h", "digits"), [(0.001, 2e-5), (0.0005, 2e-4)])
def test_thin_plates_keep_their_digits(h, digits):
    """The stretch of the thickness is 1e12 times (1.6e13) as stiff as the bending: the error of 4 by 4 elements stays
    that of h = L / 250, 7.250 %."""
    found, thick = (frequencies(4, x, True, HINGES, fmb.Revolute)[0] / mindlin(x, 1, 1) for x in (h, 0.004))
    assert found == pytest.approx(thick, rel=digits)


@pytest.mark.parametrize(
    ("n", "shear", "tolerance"),
    [slow(7, False, 0.01, id="thin"), slow(8, True, 0.035, id="shear")],
)
def test_cantilever_square(n, shear, tolerance):
    """7 by 7 thin or 8 by 8 shear-deformable elements, five modes of Leissa: bending, twist, second bending, and two
    that mix them.
    """
    leissa = [3.4917, 8.5246, 21.429, 27.331, 31.111]
    found = frequencies(n, 0.01, shear, ("s0",), fmb.Fixed)[:5]
    np.testing.assert_allclose(found, leissa, rtol=tolerance)
