"""Order of convergence of the solid elements: 2 p in the frequency, p the polynomial order.

A unit cube whose faces slide without friction (zero normal displacement) has closed-form modes; the lowest is a
shear wave with two half waves, u = (sin pi x cos pi y, -cos pi x sin pi y, 0): omega = c_s pi sqrt(2), three times.
"""

import numpy as np
import pytest
from fem.structured import CELL_TYPES, structured

from flexmb import fem
from flexmb.fem.solids.elements import SOLID_ELEMENTS
from flexmb.model.material import Material

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")

MATERIAL = Material(young=2.6, poisson=0.3, density=1.0)  # shear modulus 1, c_s = 1
EXACT = np.sqrt(2.0) / 2.0  # Hz


def error(cell_type, n):
    fe = fem.solid(structured(cell_type, (n, n, n)), MATERIAL)
    sliding = {f"{axis}{end}": axis for axis in "xyz" for end in (0, 1)}
    return abs(fem.eigenmodes(fe, sliding, n=3).frequencies.mean() / EXACT - 1.0)


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_order(cell_type):
    p = SOLID_ELEMENTS[cell_type].order
    coarse, fine = (3, 6) if p == 2 else (4, 8)
    order = np.log2(error(cell_type, coarse) / error(cell_type, fine))
    assert order == pytest.approx(2 * p, abs=0.5)
