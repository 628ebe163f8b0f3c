"""The quality report: is it the mesh's body, up to which frequency does it hold, what was lost?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmb.fem.fe_model import FEModel
from flexmb.model.effective_mass import effective_mass_table
from flexmb.reduction.basis import Basis, NormalModes, orthonormal_basis
from flexmb.reduction.basis_choice import Chosen
from flexmb.reduction.interfaces import Coupling
from flexmb.reduction.markers import MarkerMotion
from flexmb.reduction.statics import HeldBody
from flexmb.reduction.transfer_error import TransferError
from flexmb.told import tell

__all__ = ["quality_numbers"]

_POOR = 0.05  # relative frequency error that deserves a warning
_OF_PARTS = 0.02  # share of the response that the bases of parts may take without a warning
ABOVE = 1.01  # times a frequency that is to be met: three digits of it may lie below
_HEAVIEST = 25e3  # kg/m3; osmium has 22.6e3
_FASTEST = 20e3  # m/s; diamond has 18e3


def quality_numbers(
    body: HeldBody,
    chosen: Chosen,
    basis: Basis,
    exact: NormalModes | None,
    error: TransferError | None,
    clamped: int | None,
    stations: Sequence[MarkerMotion] = (),
    band: float = np.inf,
) -> dict[str, Any]:
    """Return the report as numbers and text that JSON can hold (flexmb.model.modal_neutral_report words it).

    Frequencies above `band`, Hz, were not asked to be right: nothing is said of them.
    """
    fe, normal = body.fe, chosen.normal
    reduced = basis if clamped is None else orthonormal_basis(body, normal, None, chosen.within)
    numbers = {
        "model": {
            "name": fe.name,
            "nodes": len(fe.nodes),
            "freedoms": fe.ndof,
            "factor_entries": int(body.nnz),
            **({} if fe.condensed is None else {"parts": dict(fe.condensed.reach)}),
        },
        "interfaces": [_interface(body.fe, c) for c in body.couplings],
        "basis": chosen.words,
        "normal_modes": len(normal.w2),
        "joined_shapes": len(normal.w2) - len(chosen.before()[0].w2) if chosen.within is None else 0,
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
    if error is not None:
        numbers["transfer"] = error.numbers()
    if fe.source:
        numbers["source"] = dict(fe.source)
    own = _warnings(body, numbers, band) if chosen.within is None else _of_spanned(body, reduced, numbers)
    own += _of_response(numbers) + _of_parts(numbers, band)
    found = [*fe.warnings, *own, *_of_model(body, numbers), *_far_stations(body, stations)]
    return {**numbers, "warnings": found}


def _interface(fe: FEModel, coupling: Coupling) -> dict[str, Any]:
    alone = {"node": fe.node_name(int(coupling.nodes[0]))} if len(coupling.nodes) == 1 else {}
    return {
        "name": coupling.name,
        **alone,
        "kind": coupling.label,
        "nodes": len(coupling.nodes),
        "freedoms": coupling.freedoms.tolist(),
        "position": coupling.position.tolist(),
    }


def _far_stations(body: HeldBody, stations: Sequence[MarkerMotion]) -> list[str]:
    """Doubt the unit of stations that lie further away than the part is large; they move as on a rigid arm."""
    found = []
    for station in stations:
        distance = float(np.linalg.norm(body.fe.nodes - station.position, axis=1).min())
        if distance > 2.0 * body.length:
            found.append(
                f"Station '{station.name}' is {distance:.3g} m away from the nearest node of a part of "
                f"{2.0 * body.length:.3g} m. Coordinates are metres; it follows the nearest elements as on a rigid arm."
            )
    return found


def _warnings(body: HeldBody, numbers: dict[str, Any], band: float) -> list[str]:
    """Say what looks wrong and what to do about it."""
    found = []
    poor = [n for n, row in enumerate(numbers["frequencies"]) if row["error"] > _POOR and row["full"] <= band]
    if poor:
        row = numbers["frequencies"][poor[0]]
        asked = f"up to {ABOVE * row['full']:.3g} Hz within 1 % of the frequencies"
        found.append(
            f"The reduced frequency {poor[0] + 1} ({row['reduced']:.4g} Hz) is {100 * row['error']:.1f} % above "
            f"the full model. Take more modes, or modes='{asked}'."
        )
    if numbers["static_error"] > 1e-6:
        found.append(
            f"Interface loads meet a static error of {numbers['static_error']:.1e}: the stiffness matrix is badly "
            "scaled or nearly singular. Look for very soft or very stiff elements."
        )
    return found


def _of_spanned(body: HeldBody, basis: Basis, numbers: dict[str, Any]) -> list[str]:
    """Say what a basis that is not Craig & Bampton's lacks at the interfaces: joints act on what it has."""
    found: list[str] = []
    q = basis.content[: body.nq] * body.coordinate_scale()[:, None]
    size = np.linalg.svd(q / np.sqrt(basis.w2), compute_uv=False) if q.size else np.zeros(0)
    moves, asked = int(np.sum(size > 1e-6 * size.max(initial=0.0))), body.nq - body.rigid.shape[1]
    if moves < asked:
        found.append(
            f"The interfaces move in {moves} independent ways, apart from rigid motions, and have {asked} freedoms: "
            f"where joints hold more of them they lock the body. Basis {numbers['basis'].partition('(')[0]}: take more "
            "shapes, or one that holds the static responses."
        )
        tell(f"Reduction of '{body.fe.name}': {found[-1]}")
    row = next((r for r in numbers["frequencies"] if r["error"] > _POOR), None)
    if row is not None and "transfer" not in numbers:
        found.append(
            f"A free-free frequency of {row['full']:.4g} Hz of the full model is {row['reduced']:.4g} Hz in the "
            f"reduced. error_up_to={row['full']:.3g} tells what the response to loads lacks; take more shapes if they "
            "excite it."
        )
    if moves >= asked and numbers["static_error"] > 0.01:
        found.append(
            f"Interface loads meet a static error of {100.0 * numbers['static_error']:.3g} % with {numbers['basis']}. "
            "Take a basis that is exact in statics: Rubin, Krylov with the frequency 0, Pod with statics=True."
        )
        tell(f"Reduction of '{body.fe.name}': {found[-1]}")
    return found


def _of_response(numbers: dict[str, Any]) -> list[str]:
    """Say where the response to loads is not met in the band that was asked for."""
    told = numbers.get("transfer")
    found = []
    if told is not None and told.get("by_parts", 0.0) > _OF_PARTS:
        found.append(
            f"The bases of the parts take {100.0 * told['by_parts']:.3g} % of the largest response, at "
            f"{told['by_parts_at']:.4g} Hz: the bound compares with the joined parts. Reduce the parts again with more "
            "modes."
        )
    if told is None or told["relative"] <= _POOR:
        return found
    return [
        *found,
        f"The response to loads up to {told['frequencies'][-1]:.4g} Hz may be off by {100.0 * told['relative']:.3g} % "
        f"of the largest, at {told['worst']:.4g} Hz. Take more modes, or write modes='up to "
        f"{told['frequencies'][-1]:.4g} Hz within 1 %'; loads beside interfaces join by residual_vectors.",
    ]


def _of_parts(numbers: dict[str, Any], band: float) -> list[str]:
    """Say where a band was asked for that the parts of an assembly do not hold: nothing here compares with the mesh."""
    asked = numbers["transfer"]["frequencies"][-1] if "transfer" in numbers else band
    short = {name: f for name, f in numbers["model"].get("parts", {}).items() if f is not None and f < asked}
    if not short or not np.isfinite(asked):
        return []
    reach = ", ".join(f"{name} up to {f:.3g} Hz" for name, f in short.items())
    return [
        f"The bases of parts hold {reach}: what is said up to {asked:.4g} Hz compares with the joined parts, not with "
        f"the whole mesh. Reduce these parts again with modes='up to {asked:.4g} Hz within 1 %'."
    ]


def _of_model(body: HeldBody, numbers: dict[str, Any]) -> list[str]:
    """Say what looks wrong with the FE model."""
    found = []
    if body.grounding > 1e-8:
        found.append(
            f"Rigid motions meet a relative force of {body.grounding:.1e}. Matrices written with few digits do "
            "this; so does a weak spring to the ground: remove it."
        )
    extent = np.ptp(body.fe.nodes, axis=0)
    solid = extent.min() > 0.02 * extent.max()  # the box of a beam or a sheet says nothing
    density = numbers["mass"]["mass"] / np.prod(extent) if solid else 0.0
    if density > _HEAVIEST:
        found.append(
            f"The mass fills its bounding box with {density:.3g} kg/m3, more than any metal. Check the units: metres, "
            "kilograms, newtons, seconds (a mesh in millimetres needs points * 1e-3)."
        )
    speed = max((row["full"] for row in numbers["frequencies"][:1]), default=0.0) * body.length
    if speed > _FASTEST:
        found.append(
            f"The first frequency times the size is {speed:.3g} m/s, faster than sound in any solid. Check "
            "the units of stiffness and mass."
        )
    return found


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
    """Share of the body's mass and inertia (about its centroid) that the normal modes move, per direction.

    The sum falls short of one by the mass that moves with the interfaces.
    """
    participation, rigid_mass = np.zeros((len(normal.w2), 6)), np.zeros((6, 6))
    participation[:, body.motions] = (body.fe.M @ normal.vectors).T @ body.rigid
    rigid_mass[np.ix_(body.motions, body.motions)] = body.rigid_mass
    return effective_mass_table(participation, rigid_mass)


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
        {"full": float(a), "reduced": float(b), "error": float(b / a - 1.0)} for a, b in zip(full, reduced, strict=True)
    ]


def _mode_table(body: HeldBody, normal: NormalModes, basis: Basis) -> list[dict[str, Any]]:
    """For each coordinate: frequency, and what moves: the share of its kinetic energy by interface and normal mode."""
    weight = np.abs(basis.content * (basis.reduced_mass @ basis.content))
    weight /= np.maximum(weight.sum(axis=0), 1e-300)
    rows = []
    for j, w2 in enumerate(basis.w2):
        shares = {c.name: float(weight[where, j].sum()) for c, where in zip(body.couplings, body.slices, strict=True)}
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
