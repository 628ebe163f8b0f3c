"""FE09, NAFEMS FV32: in-plane vibration of a cantilevered tapered membrane."""

from dataclasses import replace

import numpy as np
import pytest
from fem.beams import on, plate

from flexmb import fem
from flexmb.model.material import Material

TOLERANCE = 5e-3


def frequencies(case, kind, nx, ny):
    model = case["model"]
    material = Material(young=model["E"], poisson=model["nu"], density=model["rho"])
    mesh = plate(nx, ny, model["length"], 1.0, kind)
    points = mesh.points.copy()
    height = model["root_height"] + (model["tip_height"] - model["root_height"]) * points[:, 0] / model["length"]
    points[:, 1] = (points[:, 1] - 0.5) * height
    fe = fem.shell(replace(mesh, points=points), material, model["t"])
    fe = fem.with_supports(fem.with_supports(fe, directions=(2, 3, 4)), on(fe, 0, 0.0), (0, 1, 5))
    return fem.eigenmodes(fe, None, 6).frequencies


@pytest.mark.parametrize(("kind", "nx", "ny"), [("quad", 32, 16), ("triangle", 80, 40)])
def test_frequencies(reference, kind, nx, ny):
    case = reference("FE09")
    expected = case["reference"]["NAFEMS_target_Hz"]
    np.testing.assert_allclose(frequencies(case, kind, nx, ny), expected, rtol=TOLERANCE)
