"""Checks of foreign matrices that need no elements."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from flexmb.errors import MeshError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.plausibility import WAVE_SPEED
from flexmb.fem.told import tell
from flexmb.math.factor import NotPositiveDefinite, factor

__all__ = ["check_definite", "check_rigid_motions", "check_symmetric", "check_wave_speed"]

SYMMETRIC = 1e-6
"""Relative difference of K from its transpose that is still taken as rounding of a text file."""
RIGID = 1e-6
"""Energy of a rigid motion, relative to the same displacements without the neighbours, that counts
as free."""
LANGUAGE = ("x", "y", "z", "about x", "about y", "about z")


def check_symmetric(part: str, symbol: str, matrix) -> sparse.csr_matrix:
    """Return the symmetric part; raise MeshError unless the matrix is square, finite and symmetric."""
    if np.iscomplexobj(matrix.data if sparse.issparse(matrix) else matrix):
        raise MeshError(
            part,
            found=f"{symbol} is complex",
            expected="a real matrix",
            remedy="Leave out structural damping; damping ratios are given to the reduction",
        )
    matrix = sparse.csr_matrix(matrix, dtype=float)
    if matrix.shape[0] != matrix.shape[1]:
        raise MeshError(
            part,
            found=f"{symbol} has the shape {matrix.shape}",
            expected="a square matrix",
            remedy="Check the file",
        )
    if not np.isfinite(matrix.data).all():
        raise MeshError(
            part,
            found=f"{symbol} holds {int((~np.isfinite(matrix.data)).sum())} numbers that are not finite",
            expected="finite numbers",
            remedy="Export the matrices again",
        )
    largest = abs(matrix).max()
    difference = abs(matrix - matrix.T).max()
    if difference > SYMMETRIC * largest:
        triangle = sparse.tril(matrix, -1).nnz == 0 or sparse.triu(matrix, 1).nnz == 0
        raise MeshError(
            part,
            found=f"{symbol} differs from its transpose by {difference / largest:.1e} of its largest entry",
            expected="a symmetric matrix",
            remedy="Only one triangle is stored: add the transpose without the diagonal"
            if triangle
            else "Leave out follower forces, gyroscopic terms and unsymmetric contact",
        )
    return (0.5 * (matrix + matrix.T)).tocsr()


def check_definite(part: str, fe: FEModel) -> None:
    """Raise MeshError unless M and K are positive semidefinite (their diagonals first: that names the
    freedom)."""
    for symbol, matrix, cause in (
        ("K", fe.K, "a sign error, or the export of a buckled or contact state"),
        ("M", fe.M, "a sign error, or K and M exchanged"),
    ):
        diagonal = matrix.diagonal()
        if diagonal.min() < 0.0:
            row = int(diagonal.argmin())
            raise MeshError(
                part,
                found=f"{symbol} has {diagonal[row]:.3g} on the diagonal at node {fe.dofs[row, 0]}, "
                f"direction {fe.dofs[row, 1]}",
                expected="numbers >= 0",
                remedy=f"Look for {cause}",
            )
        if not diagonal.any():
            raise MeshError(
                part,
                found=f"{symbol} is zero",
                expected="a stiffness and a mass",
                remedy="Check the names of the matrices in the file",
            )
        lift = np.where(diagonal > 0.0, diagonal, diagonal.max())
        lifted = (matrix + sparse.diags(1e-6 * lift)).tocsr()
        scale = sparse.diags(1.0 / np.sqrt(lift))
        try:
            # coordinates only speed the ordering up
            factor((scale @ lifted @ scale).tocsr(), fe.nodes[fe.dofs[:, 0]]).solve(np.ones(fe.ndof))
        except NotPositiveDefinite as error:
            raise MeshError(
                part,
                found=f"{symbol} has negative eigenvalues",
                expected="a positive semidefinite matrix",
                remedy=f"Look for {cause}",
            ) from error


def check_rigid_motions(part: str, fe: FEModel) -> None:
    """Warn if a rigid motion costs energy (K is supported or grounded) or if the three directions weigh
    differently."""
    motions = fe.rigid_motions()
    energy = np.einsum("ik,ik->k", motions, fe.K @ motions)
    own = np.einsum("ik,i,ik->k", motions, fe.K.diagonal(), motions)
    resisted = [LANGUAGE[k] for k in range(6) if energy[k] > RIGID * own[k]]
    if resisted:
        tell(
            f"{part}: rigid motion {', '.join(resisted)} costs energy, as of a supported or grounded part. A body "
            "of a mechanism must be free: export the matrices without supports; check node positions, directions "
            "and units."
        )
    masses = np.einsum("ik,ik->k", motions, fe.M @ motions)[:3]
    if np.ptp(masses) > 1e-3 * masses.max():
        tell(
            f"{part}: the mass along x, y, z is {masses[0]:.4g}, {masses[1]:.4g}, {masses[2]:.4g} kg. Freedoms are "
            "missing in K and M (supports, condensed nodes), or dofs are in another order."
        )


def check_wave_speed(part: str, fe: FEModel) -> None:
    """Warn of an implausible speed of sound, estimated from K_ii / M_ii and the distance of the nearest
    node."""
    speed = wave_speed(fe)
    if speed is not None and not WAVE_SPEED[0] < speed < WAVE_SPEED[1]:
        tell(
            f"{part}: the speed of sound is about {speed:.2g} m/s; solids have {WAVE_SPEED[0]:g} to "
            f"{WAVE_SPEED[1]:g}. Units: matrices in N, mm, tonne, s need length_unit=1e-3, mass_unit=1e3."
        )


def wave_speed(fe: FEModel) -> float | None:
    """Return the median over the nodes of ``h sqrt(K_ii / 3 M_ii)``, m/s, with the stiffest translation i
    of a node.

    A bar with linear elements and consistent mass has ``K_ii = 2 E A / h``, ``M_ii = 2 rho A h / 3``: the
    result is sqrt(E / rho).
    """
    from scipy.spatial import cKDTree

    stiff, mass = fe.K.diagonal(), fe.M.diagonal()
    moving = (fe.dofs[:, 1] < 3) & (mass > 0.0)
    if moving.sum() == 0 or len(fe.nodes) < 2:
        return None
    ratio = np.zeros(len(fe.nodes))
    np.maximum.at(ratio, fe.dofs[moving, 0], stiff[moving] / mass[moving])
    distance = cKDTree(fe.nodes).query(fe.nodes, k=2)[0][:, 1]
    speeds = (distance * np.sqrt(ratio / 3.0))[(ratio > 0.0) & (distance > 0.0)]
    return float(np.median(speeds)) if len(speeds) else None
