"""The quality report: is it the mesh's body, up to which frequency does it hold, what was lost?"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.reduction.basis import Basis, NormalModes
from flexmb.reduction.interfaces import DIRECTIONS
from flexmb.reduction.statics import HeldBody

__all__ = ["quality_numbers"]


def quality_numbers(
    body: HeldBody, normal: NormalModes, basis: Basis, exact: NormalModes | None, clamped: int | None
) -> dict[str, Any]:
    """Return the report as numbers and text that JSON can hold (see `report` for the wording)."""
    fe = body.fe
    reduced = basis if clamped is None else _buckens(body, normal)
    return {
        "model": {
            "name": fe.name,
            "nodes": len(fe.nodes),
            "freedoms": fe.ndof,
            "factor_entries": int(body.nnz),
        },
        "interfaces": [
            {
                "name": c.name,
                "kind": c.label,
                "nodes": len(c.nodes),
                "freedoms": c.freedoms.tolist(),
                "position": c.position.tolist(),
            }
            for c in body.couplings
        ],
        "normal_modes": len(normal.w2),
        "fixed_interface_frequencies": (np.sqrt(normal.w2) / (2.0 * np.pi)).tolist(),
        "mass": _mass(body),
        "rigid_modes": {
            "removed": int(body.rigid.shape[1]),
            "grounding": body.grounding,
            "inertia_coupling": _inertia_coupling(body, basis) if clamped is None else None,
        },
        "effective_mass": _effective_mass(body, normal),
        "static_error": _static_error(body, reduced),
        "frequencies": _frequencies(reduced, exact),
        "modes": _mode_table(body, normal, basis),
    }


def _buckens(body: HeldBody, normal: NormalModes) -> Basis:
    from flexmb.reduction.basis import orthonormal_basis

    return orthonormal_basis(body, normal, None)


def _mass(body: HeldBody) -> dict[str, Any]:
    """Mass properties of the mesh, from M and the rigid motions."""
    rigid = body.fe.rigid_motions()
    G = rigid.T @ (body.fe.M @ rigid)
    mass = float(np.diag(G)[:3].max())
    first = G[:3, 3:] / mass  # M_vw = -m c~
    center = np.array([first[1, 2], first[2, 0], first[0, 1]])
    inertia = G[3:, 3:] - mass * (center @ center * np.eye(3) - np.outer(center, center))
    return {"mass": mass, "center_of_mass": center.tolist(), "inertia": inertia.tolist()}


def _inertia_coupling(body: HeldBody, basis: Basis) -> float:
    """Largest cosine between a rigid motion and a shape under M (zero in the Buckens frame)."""
    cross = body.rigid.T @ (body.fe.M @ basis.shapes)
    return float(np.abs(cross / np.sqrt(np.diag(body.rigid_mass))[:, None]).max(initial=0.0))


def _effective_mass(body: HeldBody, normal: NormalModes) -> dict[str, Any]:
    """Share of the rigid-body mass and inertia behind the interfaces that the normal modes hold, per direction."""
    fe = body.fe
    moving = body.rigid.copy()
    for coupling in body.couplings:
        if not coupling.averaging:
            moving[coupling.rows] = 0.0
    total = np.einsum("ij,ij->j", moving, fe.M @ moving)
    participation = (fe.M @ normal.vectors).T @ body.rigid
    share = participation**2 / np.where(total > 0.0, total, 1.0)
    return {
        "directions": [DIRECTIONS[d] for d in body.motions],
        "per_mode": share.tolist(),
        "sum": share.sum(axis=0).tolist(),
    }


def _static_error(body: HeldBody, basis: Basis) -> float:
    """Relative force error when self-balanced interface loads act on the reduced body: zero if statics is exact."""
    if body.nq <= body.rigid.shape[1]:
        return 0.0
    scale = body.coordinate_scale()
    S = body.condensed / np.outer(scale, scale)
    q = basis.content[: body.nq] * scale[:, None]
    flexibility = (q / basis.w2) @ q.T
    return float(np.abs(S @ flexibility @ S - S).max() / np.abs(S).max())


def _frequencies(basis: Basis, exact: NormalModes | None) -> list[dict[str, float]]:
    if exact is None:
        return []
    count = min(len(exact.w2), len(basis.w2))
    full, reduced = (np.sqrt(w2[:count]) / (2.0 * np.pi) for w2 in (exact.w2, basis.w2))
    return [
        {"full": float(a), "reduced": float(b), "error": float(b / a - 1.0)}
        for a, b in zip(full, reduced, strict=True)
    ]


def _mode_table(body: HeldBody, normal: NormalModes, basis: Basis) -> list[dict[str, Any]]:
    """For each coordinate: frequency, and what moves: the share of its kinetic energy by interface and normal mode."""
    weight = np.abs(basis.content * (basis.reduced_mass @ basis.content))
    weight /= np.maximum(weight.sum(axis=0), 1e-300)
    rows = []
    for j, w2 in enumerate(basis.w2):
        shares = {
            c.name: float(weight[where, j].sum())
            for c, where in zip(body.couplings, body.slices, strict=True)
        }
        inner = weight[body.nq :, j]
        row = {
            "number": j,
            "frequency": float(np.sqrt(w2) / (2.0 * np.pi)),
            "interfaces": shares,
            "normal": float(inner.sum()),
        }
        name, share = max(shares.items(), key=lambda item: item[1], default=("", 0.0))
        if len(inner) and inner.max() >= share:
            row["kind"] = f"normal mode {int(inner.argmax())}"
        else:
            row["kind"] = f"interface {name}" if name else "constraint mode"
        rows.append(row)
    return rows
