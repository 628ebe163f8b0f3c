"""FE19: simply supported square plate, closed form: N = 4 pi^2 D / b^2, f = pi (m^2 + n^2) / 2 a^2 sqrt(D /
rho t)."""

import numpy as np
import pytest
from fem.beams import on, plate, simply_supported

from flexmb import fem
from flexmb.model.material import Material

TOLERANCE = 5e-3


@pytest.fixture
def case(reference):
    return reference("FE19")


def supported(case, kind, cells):
    model = case["model"]
    material = Material(young=model["E"], poisson=model["nu"], density=model["rho"])
    return fem.shell(plate(cells, cells, 1.0, 1.0, kind), material, model["t"])


@pytest.mark.parametrize("kind", ["quad", "triangle", "cross"])
def test_frequencies(case, kind):
    fe = fem.with_supports(simply_supported(supported(case, kind, 32), 1.0, 1.0), directions=(0, 1, 5))
    f11, f12, f22 = case["reference"]["f_Hz"]
    np.testing.assert_allclose(fem.eigenmodes(fe, None, 4).frequencies, [f11, f12, f12, f22], rtol=TOLERANCE)


@pytest.mark.parametrize("kind", ["quad", "triangle", "cross"])
def test_uniaxial_buckling(case, kind):
    cells = 16
    fe = supported(case, kind, cells)
    held = simply_supported(fe, 1.0, 1.0)
    held = fem.with_supports(fem.with_supports(held, on(fe, 0, 0.0), (0,)), [0], (1,))
    load = np.zeros((len(fe.nodes), 6, 1))
    edge = on(fe, 0, 1.0)
    load[edge, 0, 0] = -1.0 / cells
    load[edge[[0, -1]], 0, 0] *= 0.5
    factor = fem.buckling(held, held.forces(load)[:, 0], None)[0][0]
    assert factor == pytest.approx(case["reference"]["N_cr"], rel=TOLERANCE)
