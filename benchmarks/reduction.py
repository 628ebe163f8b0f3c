"""Reduction of tet10 solids: time and peak memory of every stage, beside the usual ways in Python.

    python benchmarks/reduction.py                      # 10k and 92k freedoms, ours only
    python benchmarks/reduction.py --sizes 11 24 36     # about 8k, 92k, 300k freedoms
    python benchmarks/reduction.py --peers superlu skfem exudyn

A 2:1:1 block with three rigid interfaces and 20 fixed-interface modes. Every case runs in a process of its own, with
one BLAS thread, and prints CPU seconds and the peak of resident memory.

Peers: ``superlu`` factorises K_ii with scipy's splu as it is by default and calls eigsh in shift-invert mode; ``skfem``
assembles K and M by plain vector forms; ``exudyn`` reduces the same matrices by FEMinterface (pip install exudyn);
``pardiso`` and ``cholmod`` are our own reduction with their factorisation.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import time

MODES, NU = 20, 0.3


def mesh_points(n):
    """Return a skfem tet10 mesh of a 2:1:1 block with n divisions along its length (n / 2 across)."""
    import numpy as np
    from skfem import MeshTet, MeshTet2

    half = max(n // 2, 1)
    axes = (np.linspace(0, 2, n + 1), np.linspace(0, 1, half + 1), np.linspace(0, 1, half + 1))
    return MeshTet2.from_mesh(MeshTet.init_tensor(*axes))


def model(n):
    """Return the FE model of the block with its interfaces left, right and a patch on top."""
    import numpy as np

    from flexmb import fem
    from flexmb.model.material import MATERIALS

    mesh = mesh_points(n)
    points = mesh.doflocs.T.copy()
    corners = mesh.nvertices
    cells = np.hstack([mesh.t[:4].T, corners + mesh.t2e.T])
    x, y, z = points.T
    sets = {
        "left": x < 1e-9,
        "right": x > 2 - 1e-9,
        "patch": (z > 1 - 1e-9) & (np.abs(x - 1) < 0.26) & (np.abs(y - 0.5) < 0.26),
    }
    named = {name: np.flatnonzero(mask) for name, mask in sets.items()}
    return fem.solid(fem.Mesh(points=points, cells=(("tetra10", cells),), node_sets=named), MATERIALS["steel"])


class Stages:
    """CPU seconds and peak memory from one stage to the next."""

    def __init__(self):
        self.rows, self._stage, self._since = [], None, 0.0

    def __call__(self, stage, fraction=0.0):
        now = time.process_time()
        if self._stage is not None:
            self.rows.append((self._stage, now - self._since, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6))
        self._stage, self._since = stage, now


def ours(n, backend=None):
    """Assembly, then everything that reduction.reduce does."""
    from flexmb import reduction

    settings = {"interfaces": {"a": "left", "b": "right", "c": "patch"}, "geometric_stiffness": True}
    reduction.reduce(model(8), modes=4, **settings, backend=backend)  # kernels are compiled or loaded
    stages = Stages()
    stages("assembly of K and M")
    fe = model(n)
    reduction.reduce(fe, modes=MODES, **settings, backend=backend, progress=stages)
    return {"freedoms": fe.ndof, "stages": stages.rows}


def pardiso(n):
    """As ours, factorised by PARDISO (pip install 'flexmb[fast]')."""
    from flexmb import reduction

    return ours(n, reduction.Pardiso())


def cholmod(n):
    """As ours, factorised by CHOLMOD (scikit-sparse)."""
    from flexmb import reduction

    return ours(n, reduction.Cholmod())


def superlu(n):
    """Craig-Bampton as one writes it with scipy: splu of K_ii, constraint modes, eigsh in shift-invert mode."""
    import numpy as np
    from scipy.sparse.linalg import LinearOperator, eigsh, splu

    from flexmb.reduction.interfaces import resolve

    fe = model(n)
    couplings = resolve(fe, {"a": "left", "b": "right", "c": "patch"})
    rows = np.concatenate([c.rows for c in couplings])
    inner = np.setdiff1d(np.arange(fe.ndof), rows)
    given = np.zeros((fe.ndof, 18))
    for number, coupling in enumerate(couplings):
        given[coupling.rows, 6 * number : 6 * number + 6] = coupling.matrix
    stages = Stages()
    stages("factorisation")
    K, M = fe.K[inner][:, inner].tocsc(), fe.M[inner][:, inner].tocsc()
    lu = splu(K)
    stages("constraint modes")
    lu.solve(-(fe.K @ given)[inner])
    stages("normal modes")
    eigsh(K, k=MODES, M=M, sigma=0.0, OPinv=LinearOperator(K.shape, lu.solve, dtype=float))
    stages("done")
    return {"freedoms": fe.ndof, "stages": stages.rows}


def skfem(n):
    """K and M by scikit-fem's vector forms."""
    from skfem import Basis, BilinearForm, ElementTetP2, ElementVector
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    mesh = mesh_points(n)
    stages = Stages()
    stages("assembly of K and M")
    basis = Basis(mesh, ElementVector(ElementTetP2()), intorder=4)
    linear_elasticity(*lame_parameters(210e9, NU)).assemble(basis)
    BilinearForm(lambda u, v, w: 7850.0 * dot(u, v)).assemble(basis)
    stages("done")
    return {"freedoms": int(basis.N), "stages": stages.rows}


def exudyn(n):
    """Hurty-Craig-Bampton modes of Exudyn's FEMinterface on the same matrices."""
    from exudyn.FEM import FEMinterface, HCBstaticModeSelection

    fe = model(n)
    other = FEMinterface()
    other.nodes = {"Position": fe.nodes}
    other.stiffnessMatrix, other.massMatrix = fe.K, fe.M
    sets = [fe.node_set(name) for name in ("left", "right", "patch")]
    stages = Stages()
    stages("constraint and normal modes")
    other.ComputeHurtyCraigBamptonModes(
        boundaryNodesList=[list(map(int, s)) for s in sets],
        nEigenModes=MODES,
        useSparseSolver=True,
        computationMode=HCBstaticModeSelection.RBE2,
    )
    stages("done")
    return {"freedoms": fe.ndof, "stages": stages.rows}


CASES = {case.__name__: case for case in (ours, pardiso, cholmod, superlu, skfem, exudyn)}


def run(case, n):
    """Run one case in a process of its own and print its table; return the CPU seconds by stage."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    child = subprocess.run(
        [sys.executable, __file__, "--one", case, str(n)],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if child.returncode:
        print(f"\n{case}, n = {n}: {child.stderr.strip().splitlines()[-1]}")
        return None
    result = json.loads(child.stdout.splitlines()[-1])
    print(f"\n{case}: {result['freedoms']} freedoms{'':>26} CPU s   peak GB")
    for stage, seconds, memory in result["stages"]:
        print(f"  {stage:<42} {seconds:>9.2f} {memory:>9.2f}")
    total = sum(row[1] for row in result["stages"])
    print(f"  {'total':<42} {total:>9.2f}", flush=True)
    return {row[0]: row[1] for row in result["stages"]}


def main():
    """Run the cases asked for and print the ratio to SuperLU and scikit-fem where they ran."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[11, 24], help="divisions along the block")
    parser.add_argument("--peers", nargs="*", default=[], choices=[name for name in CASES if name != "ours"])
    parser.add_argument("--one", nargs=2, metavar=("CASE", "SIZE"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(CASES[options.one[0]](int(options.one[1]))))
        return
    for n in options.sizes:
        mine = run("ours", n)
        other = {peer: run(peer, n) for peer in options.peers}
        if mine and other.get("superlu") and other.get("skfem"):
            parts = ("assembly of K and M", "factorisation and constraint modes", "normal modes")
            ratio = sum(sum(other[p].values()) for p in ("superlu", "skfem")) / sum(mine[p] for p in parts)
            print(f"\n  scipy SuperLU + scikit-fem forms: {ratio:.1f} times our time for the same work")


if __name__ == "__main__":
    main()
