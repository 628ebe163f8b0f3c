"""The quality report of modal neutral data as text: how good is it, up to which frequency, what was lost?"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import DataFileError
from flexmb.model.modal_arrays import ModalArrays
from flexmb.model.mode_table import mode_table

__all__ = ["Quality", "basis_words", "beside_words", "report", "response_lines", "wandering_lines"]


class Quality(dict):
    """The numbers of a quality report by name, as JSON can hold them; printed as the paragraphs of the report."""

    def __str__(self) -> str:
        if not {"mass", "interfaces", "frequencies", "effective_mass", "warnings"} <= set(self):
            return "no quality report" if not self else super().__repr__()
        mass = f"Mass of the mesh {self['mass']['mass']:.9g} kg"
        parts = [[mass], _interfaces(self), _frequencies(self), _effective_mass(self), _warnings(self)]
        return "\n\n".join("\n".join(lines) for lines in parts)


def report(data: ModalArrays) -> str:
    """Return the quality report, one paragraph per question; ``data.quality`` holds every number.

    Parameters
    ----------
    data : ModalNeutralData
        Fresh from the reduction or read from a file.
    """
    try:
        return _report(data)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise DataFileError(
            f"Modal neutral data '{data.name}'",
            found=f"a quality report that cannot be printed ({' '.join(repr(error).split())[:120]})",
            expected="the entries that the reduction writes",
            remedy="Reduce the part again: the file is damaged, or of another release",
        ) from error


def _report(data: ModalArrays) -> str:
    q = data.quality
    title = f"Modal neutral data '{data.name}'"
    lines = [title, "=" * len(title), *_body(data)]
    if q:
        lines += [
            *_source(q),
            "",
            *_mass(data, q),
            "",
            *_interfaces(q),
            "",
            *_frequencies(q),
            *response_lines(q),
            *wandering_lines(data, q),
            "",
            *_effective_mass(q),
            "",
            *_modes(data),
        ]
        lines += ["", *_warnings(q)]
    return "\n".join(lines)


def _body(data: ModalArrays) -> list[str]:
    f = data.frequencies
    span = f"{f.min():.6g} to {f.max():.6g} Hz" if len(f) else "no modes"
    rows = [f"{len(data.nodes)} nodes, {data.n_modes} flexible coordinates ({span}), frame: {data.frame}"]
    extras = [f"{len(data.load_names)} load shapes ({', '.join(data.load_names)})"] if data.load_names else []
    extras += ["geometric stiffness"] if data.geometric is not None else []
    extras += ["stress modes"] if data.has_stress else []
    rows.append(f"with {', '.join(extras)}" if extras else "without load shapes, geometric stiffness, stress modes")
    if data.stress_modes is not None and data.n_modes and not data.has_stress:
        rows.append("its elements are beams, rods or springs, which give no stress at nodes")
    return rows


def _source(q: dict[str, Any]) -> list[str]:
    """Where the FE model comes from, and what of the deck is not as it was."""
    found = q.get("source")
    if not found:
        return []
    units = found["units"] or "as in the deck, not known"
    lines = ["", "Source", f"  {found['program']} deck '{found['file']}', {found['nodes']} nodes; units: {units}"]
    lines.append("  read          " + (", ".join(f"{n} {name}" for name, n in found["read"].items()) or "nothing"))
    for title, key in (("approximated", "approximated"), ("left out", "left_out")):
        lines += [f"  {title:<13} {text} ({n})" for text, n in found[key].items()]
    return lines


def _mass(data: ModalArrays, q: dict[str, Any]) -> list[str]:
    mesh = q["mass"]
    vector = lambda a: "(" + ", ".join(f"{x:.6g}" for x in a) + ")"  # noqa: E731
    scale = max(np.abs(mesh["inertia"]).max(), 1e-300)
    off = np.where(np.abs(data.inertia) > 1e-12 * scale, data.inertia, 0.0)[[0, 1, 2], [1, 2, 0]]
    error = np.abs(data.inertia - np.array(mesh["inertia"])).max() / scale
    return [
        "Mass",
        f"  mass            {data.mass:.9g} kg (mesh {mesh['mass']:.9g} kg)",
        f"  centre of mass  {vector(data.center_of_mass)} m",
        f"  inertia         {vector(np.diag(data.inertia))} kg m2 about it, xy yz zx "
        f"{vector(off)}; difference from the mesh {error:.1e}",
        f"  rigid motions   {q['rigid_modes']['removed']} removed; relative force in the FE model "
        f"{q['rigid_modes']['grounding']:.1e} (zero if nothing ties it to the ground)",
    ]


def _interfaces(q: dict[str, Any]) -> list[str]:
    rows = [
        f"  {i['name']:<16} {i['kind']:<11} {i['nodes']:>6} nodes  {len(i['freedoms'])} freedoms  at "
        f"({', '.join(f'{x:.6g}' for x in i['position'])}) m{', ' + i['node'] if 'node' in i else ''}"
        for i in q["interfaces"]
    ]
    return [
        "Interfaces",
        *rows,
        f"  static error    {q['static_error']:.1e} (interface loads: zero if statics is exact)",
    ]


def _frequencies(q: dict[str, Any]) -> list[str]:
    if not q["frequencies"]:
        return ["Frequencies", "  not compared with the full model (compare=0)"]
    rows = [
        f"  {n + 1:>4} {r['full']:>14.6g} {r['reduced']:>14.6g} {100 * r['error']:>10.3g} %"
        for n, r in enumerate(q["frequencies"])
    ]
    good = 0.0
    for row in q["frequencies"]:
        if row["error"] > 0.01:
            break
        good = row["full"]
    beside = beside_words(q)
    return [
        f"Free-free frequencies (within 1 % up to {good:.4g} Hz, {basis_words(q)})",
        *([f"  {beside}"] if beside else []),
        f"  {'mode':>4} {'joined Hz' if beside else 'full model Hz':>14} {'reduced Hz':>14} {'error':>12}",
        *rows,
    ]


def beside_words(q: dict[str, Any]) -> str:
    """Return what is compared with, where it is not the whole mesh, and what is known of it."""
    parts = q.get("model", {}).get("parts", {})
    known = ", ".join(f"{name} {'unknown' if f is None else f'{f:.4g} Hz'}" for name, f in parts.items())
    return f"compared with the joined parts, not with the whole mesh; their bases hold up to: {known}" if parts else ""


def basis_words(q: dict[str, Any]) -> str:
    """Return words for the basis; data of older releases do not name it."""
    name = q.get("basis", "CraigBampton()")
    if name != "CraigBampton()":
        return f"basis {name}"
    joined = q.get("joined_shapes", 0)
    return f"{q['normal_modes'] - joined} fixed-interface modes" + (f" and {joined} shapes of loads" if joined else "")


def response_lines(q: dict[str, Any]) -> list[str]:
    """Say how far the response to loads is off, where it was bounded."""
    if "transfer" not in q:
        return []
    t = q["transfer"]
    error, response = (np.array(t[name]) for name in ("error", "response"))
    share = np.where(response > 0.0, error / np.where(response > 0.0, response, 1.0), np.inf)
    there, largest = int(np.argmax(share)), int(np.argmax(response))
    return [
        "",
        f"Response to loads up to {t['frequencies'][-1]:.4g} Hz with {100 * t['damping']:.3g} % damping",
        f"  error           at most {t['relative']:.2e} of the largest response, at {t['worst']:.4g} Hz"
        + (", beside the joined parts" if q["model"].get("parts") else ""),
        *_by_parts(q, t),
        f"  response        largest at {t['frequencies'][largest]:.4g} Hz; the error is at most "
        f"{min(100.0 * share[there], 999.0):.3g} % of the response at the same frequency, at "
        f"{t['frequencies'][there]:.4g} Hz",
    ]


def _by_parts(q: dict[str, Any], t: dict[str, Any]) -> list[str]:
    """Say what the bases of parts add to the error of an assembly."""
    if not q["model"].get("parts"):
        return []
    if "by_parts" not in t:
        return ["  of the parts    not known: reduce them with error_up_to"]
    return [f"  of the parts    about {t['by_parts']:.2e} of the largest response, at {t['by_parts_at']:.4g} Hz"]


def wandering_lines(data: ModalArrays, q: dict[str, Any]) -> list[str]:
    """Say where loads move or press, and what of the deflection under them is missing; older data do not know."""
    rows = []
    for name, track in q.get("tracks", {}).items():
        ends = data.nodes[[track["nodes"][k] for k in (0, -1)]] if "nodes" in track else []
        along = " to ".join(f"({', '.join(f'{x:.4g}' for x in end)})" for end in ends)
        rows.append((name, f"{len(track['places'])} nodes, {track['places'][-1]:.6g} m, {along}", track))
    rows += [(name, f"{zone['patches']} facets", zone) for name, zone in q.get("contact", {}).items()]
    known = [
        f"  {name:<16} {where}: {told['shapes']} shapes joined, {100.0 * told['missing']:.3g} % missing; without them "
        f"{100.0 * told['missing_before']:.3g} %"
        for name, where, told in rows
        if "missing" in told
    ]
    title = "Loads that move: error of the deflection under them at rest, interfaces held, over the largest deflection"
    return ["", title, *known] if known else []


def _effective_mass(q: dict[str, Any]) -> list[str]:
    table = q["effective_mass"]
    cells = ", ".join(
        f"{name} {100 * share:.1f} %" for name, share in zip(table["directions"], table["sum"], strict=True)
    )
    return [
        "Effective mass: share of mass and inertia that the fixed-interface modes move",
        f"  {cells or 'none'}",
    ]


def _modes(data: ModalArrays) -> list[str]:
    """Number, frequency, what it is, its part in static deflection, the mass it moves, what moves in it."""
    rows = []
    for row in mode_table(data):
        kind = row["kind"] + (f" {row['interface']}" if row["kind"] == "interface motion" else "")
        direction, mass = max(row["effective_mass"].items(), key=lambda item: item[1], default=("", 0.0))
        moves = f"{direction} {100 * mass:.1f} %" if mass else "-"
        shares = "  ".join(f"{name} {100 * share:.1f} %" for name, share in row["participation"].items())
        rows.append(
            f"  {row['number']:>4} {row['frequency']:>14.6g}  {kind:<24} {100 * row['compliance']:>6.2f} %  "
            f"{moves:<18} {shares}"
        )
    return [
        "Modal coordinates (compliance: share of the static deflection at the interfaces; effective mass: the largest; "
        "participation: shares of kinetic energy)",
        f"  {'no.':>4} {'frequency Hz':>14}  {'kind':<24} {'compliance':>10} {'effective mass':<18}  participation",
        *rows,
    ]


def _warnings(q: dict[str, Any]) -> list[str]:
    return ["Warnings", *(f"  - {text}" for text in q["warnings"])] if q.get("warnings") else ["No warnings."]
