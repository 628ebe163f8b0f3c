"""Eigenfrequencies of a clamped block against those that CalculiX (ccx 2.20) prints, to its seven digits.

The block is skewed and has three different sides, so that no two modes coincide. Elements whose matrices are the
same in both programs agree to 1e-6; the tetrahedra differ by the mass rule of CalculiX (four points) until they use it.
"""

import re
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from fem.structured import structured

from flexmb import fem
from flexmb.fem.solids.elements import SOLID_ELEMENTS
from flexmb.model.material import Material

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")

STEEL = Material(young=210e9, poisson=0.3, density=7850.0)
NAMES = {"tetra10": "C3D10", "hexahedron20": "C3D20"}
COUNT = 6


def calculix_frequencies(program, folder, mesh, clamped):
    """Run CalculiX and return the frequencies of its table, Hz."""
    ((cell_type, cells),) = mesh.cells
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i},{x:.16g},{y:.16g},{z:.16g}" for i, (x, y, z) in enumerate(mesh.points, 1)]
    lines.append(f"*ELEMENT, TYPE={NAMES[cell_type]}, ELSET=EALL")
    for i, row in enumerate(cells + 1, 1):
        words = [str(i), *map(str, row)]
        lines += [",".join(words[k : k + 12]) + ("," if k + 12 < len(words) else "") for k in range(0, len(words), 12)]
    lines += ["*NSET, NSET=FIXED", *(f"{node + 1}," for node in clamped), "*BOUNDARY", "FIXED,1,3"]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{STEEL.young},{STEEL.poisson}", "*DENSITY", f"{STEEL.density}"]
    lines += ["*SOLID SECTION, ELSET=EALL, MATERIAL=M", "*STEP", "*FREQUENCY", f"{COUNT}", "*END STEP", ""]
    (folder / "job.inp").write_text("\n".join(lines))
    subprocess.run([program, "job"], cwd=folder, capture_output=True, check=True, timeout=60)
    text = (folder / "job.dat").read_text().split("P A R T I C I P A T I O N")[0]
    rows = re.findall(r"^\s+\d+\s+(\S+)\s+(\S+)\s+(\S+)\s+(\S+)\s*$", text, re.MULTILINE)
    return np.array([float(row[2]) for row in rows])


@pytest.mark.parametrize("cell_type", list(NAMES))
def test_frequencies(ccx, tmp_path, cell_type):
    mesh = structured(cell_type, (4, 2, 2), (1.0, 0.12, 0.17), skew=0.1)
    clamped = np.flatnonzero(mesh.points[:, 0] < 1e-9)
    published = calculix_frequencies(ccx, tmp_path, mesh, clamped)
    assert len(published) == COUNT
    fe = fem.solid(mesh, STEEL)
    ours = fem.eigenmodes(fe, clamped, COUNT).frequencies
    if cell_type == "tetra10":
        # four points integrate the mass of a quadratic tetrahedron to less than full order: at most 1 % here
        np.testing.assert_allclose(ours, published, rtol=1e-2)
        rule = replace(SOLID_ELEMENTS[cell_type], mass_order=2)
        ours = fem.eigenmodes(fem.solid(mesh, STEEL, elements={cell_type: rule}), clamped, COUNT).frequencies
    np.testing.assert_allclose(ours, published, rtol=1e-6)
