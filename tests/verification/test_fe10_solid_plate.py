"""FE10, NAFEMS FV52: free vibration of a simply supported thick plate of solids.

National Agency for Finite Element Methods and Standards, Selected Benchmarks for Natural Frequency Analysis
(1987), test FV52: 10 m x 10 m x 1 m, u_z = 0 along the four edges of the bottom face. Three rigid motions in the
plane come first; modes 4 to 10 are compared. The line support of a solid has no mesh limit: not refined further.
"""

import numpy as np
import pytest
from fem.structured import structured

from flexmb import fem
from flexmb.model.material import Material


@pytest.mark.parametrize("cell_type", ["hexahedron20", "hexahedron27"])
def test_fv52(reference, cell_type):
    case = reference("FE10")
    model = case["model"]
    mesh = structured(cell_type, (4, 4, 1), (model["a"], model["a"], model["t"]))
    fe = fem.solid(mesh, Material(young=model["E"], poisson=model["nu"], density=model["rho"]))
    sides = np.unique(np.concatenate([mesh.node_sets[s] for s in ("x0", "x1", "y0", "y1")]))
    edges = np.intersect1d(sides, mesh.node_sets["z0"])
    held = np.isin(fe.dofs[:, 0], edges) & (fe.dofs[:, 1] == 2)
    frequencies = fem.eigenmodes(fe, held, n=10).frequencies
    assert frequencies[2] < 1e-3 * frequencies[3]
    assert frequencies[3:] == pytest.approx(case["reference"]["NAFEMS_target_Hz"], rel=0.03)
