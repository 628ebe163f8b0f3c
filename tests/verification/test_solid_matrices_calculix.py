"""K and M of solids against CalculiX (ccx 2.20), which writes its matrices with SOLVER=MATRIXSTORAGE.

Elements with the same integration rule give the same numbers (the files hold 14 digits). CalculiX integrates the
mass of tetrahedra with the points of the stiffness, one and four, which is less than exact; the comparison uses its
rule. Its wedges have fewer points than ours in the plane of the triangle and are left out.
"""

import subprocess
from dataclasses import replace

import numpy as np
import pytest
from fem.structured import structured
from scipy import sparse

from flexmb import fem
from flexmb.fem.solids.elements import SOLID_ELEMENTS
from flexmb.model.material import Material
from flexmb.model.orthotropic_material import OrthotropicMaterial

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")

MATERIAL = Material(young=210.0, poisson=0.3, density=7.85)
PLY = OrthotropicMaterial(young=(135.0, 10.0, 9.0), poisson=(0.3, 0.4, 0.25), shear=(5.0, 3.5, 4.0), density=1.6)
NAMES = {"tetra": "C3D4", "tetra10": "C3D10", "hexahedron": "C3D8", "hexahedron20": "C3D20"}
CALCULIX_MASS_ORDER = {"tetra": 1, "tetra10": 2}


def isotropic():
    return f"*ELASTIC\n{MATERIAL.young}, {MATERIAL.poisson}\n*DENSITY\n{MATERIAL.density}\n"


def orthotropic():
    (e1, e2, e3), (nu12, nu23, nu13), (g12, g23, g13) = PLY.young, PLY.poisson, PLY.shear
    return (
        "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
        f"{e1}, {e2}, {e3}, {nu12}, {nu13}, {nu23}, {g12}, {g13},\n{g23}\n*DENSITY\n{PLY.density}\n"
    )


def calculix(program, folder, mesh, law):
    """Run CalculiX and return its (K, M) in the order of our freedoms."""
    ((cell_type, cells),) = mesh.cells
    lines = ["*NODE, NSET=ALL"] + [f"{i},{x:.16g},{y:.16g},{z:.16g}" for i, (x, y, z) in enumerate(mesh.points, 1)]
    lines.append(f"*ELEMENT, TYPE={NAMES[cell_type]}, ELSET=EALL")
    for i, row in enumerate(cells + 1, 1):
        words = [str(i), *map(str, row)]
        lines += [",".join(words[k : k + 12]) + ("," if k + 12 < len(words) else "") for k in range(0, len(words), 12)]
    lines += [
        "*MATERIAL, NAME=M",
        law.rstrip(),
        "*SOLID SECTION, ELSET=EALL, MATERIAL=M",
        "*STEP",
        "*FREQUENCY, SOLVER=MATRIXSTORAGE",
        "1",
        "*END STEP",
        "",
    ]
    (folder / "job.inp").write_text("\n".join(lines))
    subprocess.run([program, "job"], cwd=folder, capture_output=True, check=False, timeout=60)
    words = [line.split(".") for line in (folder / "job.dof").read_text().split()]
    place = np.array([3 * (int(node) - 1) + int(direction) - 1 for node, direction in words])
    matrices = []
    for suffix in ("sti", "mas"):
        table = np.loadtxt(folder / f"job.{suffix}")
        i, j = place[table[:, 0].astype(int) - 1], place[table[:, 1].astype(int) - 1]
        upper = sparse.coo_matrix((table[:, 2], (i, j)), shape=(len(place),) * 2).tocsr()
        matrices.append(upper + upper.T - sparse.diags(upper.diagonal()))
    return matrices


@pytest.mark.parametrize("cell_type", list(NAMES))
def test_matrices_equal_those_of_calculix(ccx, tmp_path, cell_type):
    mesh = structured(cell_type, (2, 1, 2), (1.0, 0.7, 1.3))
    k, m = calculix(ccx, tmp_path, mesh, isotropic())
    element = SOLID_ELEMENTS[cell_type].compatible()
    element = replace(element, mass_order=CALCULIX_MASS_ORDER.get(cell_type, element.mass_order))
    fe = fem.solid(mesh, MATERIAL, elements={cell_type: element})
    assert abs(fe.K - k).max() < 1e-10 * abs(k).max()
    assert abs(fe.M - m).max() < 1e-10 * abs(m).max()


def test_orthotropic_stiffness_equals_that_of_calculix(ccx, tmp_path):
    mesh = structured("tetra10", (2, 1, 1), skew=0.1)
    k, _ = calculix(ccx, tmp_path, mesh, orthotropic())
    assert abs(fem.solid(mesh, PLY).K - k).max() < 1e-10 * abs(k).max()
