"""Loads that may stand anywhere on a line or a surface: which static responses join the basis, and what is missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh, null_space, orth

from flexmb.reduction.basis import NormalModes
from flexmb.reduction.statics import HeldBody

__all__ = ["Wandering", "doubts", "tell_missing", "wandering"]

POOR = 0.05
"""Share of the largest deflection that may be missing without a warning."""
HELD = 1e-9
"""Motion of the interfaces, relative to the largest, below which a displacement leaves them where they are."""


@dataclass(frozen=True, eq=False)
class Wandering:
    """A load that stands at one of many places.

    Parameters
    ----------
    told : dict
        What the quality report says of it.
    unit : (ndof, n), N
        The unit load at each place.
    compliance : (n,), m/N
        Static deflection of the full model at the load, along it, interfaces held.
    joining : (ndof, k), N
        Combinations whose static responses join the basis.
    """

    told: dict[str, Any]
    unit: np.ndarray
    compliance: np.ndarray
    joining: np.ndarray


def wandering(body: HeldBody, unit: np.ndarray, rest: float, told: dict[str, Any]) -> Wandering:
    """Return a load with the combinations of its unit loads that hold all but `rest` of the strain energies."""
    compliance = unit.T @ body.solve(unit)
    energy, combined = eigh(0.5 * (compliance + compliance.T))
    energy, combined = np.maximum(energy[::-1], 0.0), combined[:, ::-1]
    left = 1.0 - np.cumsum(energy) / max(energy.sum(), 1e-300)
    count = 0 if rest >= 1.0 else int(np.sum(left > rest)) + 1
    joining = unit @ combined[:, : min(count, int(np.sum(energy > 1e-14 * energy[0])))]
    return Wandering(
        {**told, "shapes": joining.shape[1], "rest": float(rest)}, unit, np.diag(compliance).copy(), joining
    )


def tell_missing(
    body: HeldBody,
    loads: Mapping[str, Wandering],
    basis: tuple[NormalModes, np.ndarray | None],
    before: tuple[NormalModes, np.ndarray | None],
) -> dict[str, Any]:
    """Return what is told of loads, and what of the deflection under them a basis lacks, and lacked before they joined.

    The largest deflection that is missing at rest with held interfaces, over the largest deflection. A basis is its
    fixed-interface shapes and the coordinates of its displacements, as `Chosen` has them.
    """
    told = {}
    for name, load in loads.items():
        largest = float(load.compliance.max(initial=0.0)) or 1.0
        lacking = [load.compliance - _compliance(body, *one, load.unit) for one in (basis, before)]
        missing, missing_before = (float(one.max(initial=0.0)) / largest for one in lacking)
        told[name] = {**load.told, "missing": missing, "missing_before": missing_before}
    return told


def doubts(told: Mapping[str, dict[str, Any]]) -> list[str]:
    """Return what a report warns of: loads under which the body is too stiff."""
    return [
        f"Under a load on '{name}' the body is too stiff: up to {100.0 * one['missing']:.3g} % of the largest "
        f"deflection is missing. Write rest={0.01 * one['rest']:.0e}, or take more modes."
        for name, one in told.items()
        if one["missing"] > POOR
    ]


def _compliance(body: HeldBody, normal: NormalModes, within: np.ndarray | None, unit: np.ndarray) -> np.ndarray:
    """Return the deflection of the reduced body at unit loads (ndof, n), along them, interfaces held: (n,), m/N."""
    inner = np.eye(len(normal.w2)) if within is None else _holding(body, within)
    if not inner.shape[1]:
        return np.zeros(unit.shape[1])
    shares = (normal.vectors @ inner).T @ unit
    stiffness = inner.T @ (normal.w2[:, None] * inner)
    return np.einsum("in,in->n", shares, np.linalg.solve(stiffness, shares))


def _holding(body: HeldBody, within: np.ndarray) -> np.ndarray:
    """Return which fixed-interface shapes (k, d) the displacements (nq + k, p) and rigid motions hold by themselves."""
    scale = body.coordinate_scale()[:, None]
    rigid = scale * body.rigid_coordinates
    moved = np.hstack([scale * within[: body.nq], rigid / np.maximum(np.linalg.norm(rigid, axis=0), 1e-300)])
    size = float(np.linalg.norm(moved[:, : within.shape[1]], axis=0).max(initial=0.0))
    moved[:, : within.shape[1]] /= size if size > 0.0 else 1.0
    still = null_space(moved, rcond=HELD) if moved.size else np.eye(moved.shape[1])
    inner = within[body.nq :] @ still[: within.shape[1]]
    return orth(inner, rcond=HELD) if inner.size else inner
