"""AN04: the 45-degree bend, a curved cantilever loaded out of its plane (Bathe & Bolourchi 1979).

Reference: shooting solution of the geometrically exact beam; published tips scatter with the torsion constant.
"""

import numpy as np
import pytest
from verification.cantilever_beam import loaded_tip

import flexmb as fmb
from flexmb import fem

ANGLE = np.linspace(0.0, np.pi / 4, 9)
ARC = 100.0 * np.stack([1.0 - np.cos(ANGLE), np.sin(ANGLE), 0.0 * ANGLE], axis=1)
ENDS = ((0, 1, 0), (np.sqrt(0.5), np.sqrt(0.5), 0))


@pytest.mark.parametrize("key", ["300", "450", "600", "600_variantB"])
def test_tip(reference, key):
    """Eight elements, 0.1 % of the displacement."""
    case = reference("AN04")
    torsion, kappa = (0.140577, 5 / 6) if "variantB" in key else (1 / 6, 1.0)
    body = fmb.AncfBeam(
        "b",
        points=ARC,
        tangents=ENDS,
        elements=8,
        section=fem.Section.values(1.0, 1 / 12, 1 / 12, torsion, kappa, kappa),
        material=fmb.Material(young=case["model"]["E"], poisson=0.0, density=1000.0),
    )
    moved, _ = loaded_tip(body, (0, 0, float(key[:3])))
    np.testing.assert_allclose(ARC[-1] + moved, case["reference"][key], atol=1e-3 * np.linalg.norm(moved))
