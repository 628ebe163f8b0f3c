"""FE19 with solids: a simply supported square plate under uniaxial compression, one layer of hex20.

Closed form N = 4 pi^2 D / b^2 (Timoshenko & Gere). The edges are held on the nodes of the middle plane: a soft support,
which lets the edge shear and lowers the load by some t / b, while coarse elements raise it (8 x 8: 0.6 % above).
"""

from dataclasses import replace

import numpy as np
import pytest
from fem.structured import structured

from flexmb import fem
from flexmb.model.material import Material

TOLERANCE = 5e-3
"""Stated by the case: thin plate."""


def test_uniaxial_buckling(reference):
    case = reference("FE19")
    model = case["model"]
    b, t = model["a"], model["t"]
    mesh = structured("hexahedron20", (12, 12, 1), (b, b, t))
    fe = fem.solid(mesh, Material(young=model["E"], poisson=model["nu"], density=model["rho"]))
    x, y, z = fe.nodes.T
    rim = (np.minimum(x, y) < 1e-9) | (np.maximum(x, y) > b - 1e-9)
    middle = np.abs(z - t / 2) < 1e-9
    pin, roll = (np.flatnonzero(middle & (np.hypot(x - at, y) < 1e-9)) for at in (0.0, b))
    fe = replace(fe, node_sets={"rim": np.flatnonzero(rim & middle), "pin": pin, "roll": roll})
    load = (fem.pressure_load(fe, "x0") + fem.pressure_load(fe, "x1")) / t  # 1 N/m on both edges
    factor = fem.buckling(fe, load, {"rim": "z", "pin": "xy", "roll": "y"})[0][0]
    assert abs(factor) == pytest.approx(case["reference"]["N_cr"], rel=TOLERANCE)
