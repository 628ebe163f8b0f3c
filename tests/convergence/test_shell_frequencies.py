"""Orders of convergence of shells: simply supported plate (closed form, FE19) and its buckling load."""

import numpy as np
import pytest
from fem.beams import on, plate, simply_supported

from flexmb import fem
from flexmb.model.material import Material

MATERIAL = Material(young=210e9, poisson=0.3, density=7850.0)
T = 1e-3  # rotary inertia and its 1e-6 of the frequency are out of sight


@pytest.mark.parametrize("kind", ["quad", "triangle", "cross"])
def test_bending_frequency_has_order_two(kind):
    stiffness = MATERIAL.young * T**3 / (12 * (1 - 0.09))
    exact = np.pi * np.sqrt(stiffness / (MATERIAL.density * T))
    errors = []
    for cells in (6, 12, 24):
        fe = fem.shell(plate(cells, cells, 1.0, 1.0, kind), MATERIAL, T)
        fe = fem.with_supports(simply_supported(fe, 1.0, 1.0), directions=(0, 1, 5))
        errors.append(abs(fem.eigenmodes(fe, None, 1).frequencies[0] / exact - 1.0))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders[-1] == pytest.approx(2.0, abs=0.25)


@pytest.mark.parametrize("kind", ["quad", "triangle", "cross"])
def test_in_plane_frequency_has_order_two(kind):
    """Edges that slide along their normal: shear mode u ~ cos(pi x) sin(pi y), f = sqrt(2 G / rho) / 2
    (Gorman 2004).

    D. J. Gorman, Free in-plane vibration analysis of rectangular plates, J. Sound Vib. 272 (2004) 831-851.
    """
    exact = np.sqrt(2.0 * MATERIAL.shear / MATERIAL.density) / 2.0
    errors = []
    for cells in (6, 12, 24):
        fe = fem.shell(plate(cells, cells, 1.0, 1.0, kind), MATERIAL, T)
        fe = fem.with_supports(fe, directions=(2, 3, 4))
        fe = fem.with_supports(fe, np.union1d(on(fe, 1, 0.0), on(fe, 1, 1.0)), (0,))
        fe = fem.with_supports(fe, np.union1d(on(fe, 0, 0.0), on(fe, 0, 1.0)), (1,))
        errors.append(abs(fem.eigenmodes(fe, None, 3).frequencies[2] / exact - 1.0))
    assert np.log2(errors[1] / errors[2]) > 1.8
    assert errors[2] < 2e-3
