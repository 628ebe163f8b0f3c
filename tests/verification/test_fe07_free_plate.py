"""FE07, NAFEMS FV12: free thin square plate, in-plane freedoms suppressed.

Compared with converged Kirchhoff-Ritz values; the handbook's are 0.3 to 1 % above them from the fifth mode
on.
"""

import numpy as np
import pytest
from fem.beams import plate

from flexmb import fem
from flexmb.model.material import Material

TOLERANCE = 1e-3


@pytest.mark.parametrize(("kind", "cells"), [("quad", 32), ("triangle", 32), ("cross", 24)])
def test_frequencies(reference, kind, cells):
    case = reference("FE07")
    model = case["model"]
    material = Material(young=model["E"], poisson=model["nu"], density=model["rho"])
    fe = fem.shell(plate(cells, cells, model["a"], model["a"], kind), material, model["t"])
    fe = fem.with_supports(fe, directions=(0, 1, 5))
    found = fem.eigenmodes(fe, None, 10).frequencies
    assert found[2] < 1e-2  # three rigid motions; 1e-6 of the scale of the matrix
    np.testing.assert_allclose(found[3:], case["reference"]["Kirchhoff_Ritz_Hz"][:7], rtol=TOLERANCE)
