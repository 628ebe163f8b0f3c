"""The table of every modal coordinate: what it is, its frequency, what moves in it, what it is worth."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.model.modal_arrays import ModalArrays

__all__ = ["left_out_compliance", "mode_table"]


def mode_table(data: ModalArrays) -> list[dict[str, Any]]:
    """Return one row per flexible coordinate, as JSON can hold it.

    Keys of a row: ``number`` from 1; ``kind``, "normal mode 3" or "interface motion"; ``interface``, the one that
    moves most ("" if none does); ``frequency``, Hz; ``damping_ratio``; ``effective_mass``, shares by direction of the
    fixed-interface mode it is mainly made of (empty for interface motions); ``participation``, shares of its kinetic
    energy by interface and of all "normal modes"; ``compliance``, its share of the deflection of the interfaces under
    their own static unit loads, mean over their freedoms (sums to one over all coordinates).
    """
    described = data.quality.get("modes", [])
    compliance = _compliance_shares(data)
    rows = []
    for j, frequency in enumerate(data.frequencies):
        known = described[j] if j < len(described) else {}
        interfaces = known.get("interfaces", {})
        normal = known.get("kind", "").removeprefix("normal mode ")
        rows.append(
            {
                "number": j + 1,
                "kind": f"normal mode {int(normal) + 1}" if normal.isdigit() else "interface motion" if known else "",
                "interface": max(interfaces, key=interfaces.get, default=""),
                "frequency": float(frequency),
                "damping_ratio": float(data.damping_ratios[j]),
                "effective_mass": _effective_mass(data, int(normal)) if normal.isdigit() else {},
                "participation": {**interfaces, **({"normal modes": known["normal"]} if known else {})},
                "compliance": float(compliance[j]),
            }
        )
    return rows


def _effective_mass(data: ModalArrays, number: int) -> dict[str, float]:
    """Return the shares of one fixed-interface mode by direction."""
    table = data.quality.get("effective_mass", {"directions": [], "per_mode": []})
    shares = table["per_mode"][number] if number < len(table["per_mode"]) else []
    return dict(zip(table["directions"], shares))


def left_out_compliance(data: ModalArrays, kept: np.ndarray) -> tuple[float, float]:
    """Return the share of the static deflection of interfaces that other coordinates than `kept` have.

    Of a freedom under its own load: the mean over all freedoms, and the largest.
    """
    shares = _shares(data)
    left = 1.0 - shares[:, np.unique(kept)].sum(axis=1)
    return (float(left.mean()), float(left.max())) if len(left) else (0.0, 0.0)


def _compliance_shares(data: ModalArrays) -> np.ndarray:
    """Return phi_ij^2 / k_j over its sum over j, mean over the freedoms i of the interfaces, (m,)."""
    shares = _shares(data)
    return shares.mean(axis=0) if len(shares) else np.zeros(data.n_modes)


def _shares(data: ModalArrays) -> np.ndarray:
    """Return phi_ij^2 / k_j over its sum over j for the freedoms i of the interfaces that move, (k, m)."""
    k, n = np.diag(data.stiffness), data.n_interfaces
    shapes = np.concatenate([data.marker_translations[:n], data.marker_rotations[:n]], axis=1).reshape(-1, len(k))
    terms = shapes**2 / np.where(k > 0.0, k, np.inf)
    total = terms.sum(axis=1)
    moving = total > 1e-20 * total.max(initial=0.0)
    return terms[moving] / total[moving, None]
