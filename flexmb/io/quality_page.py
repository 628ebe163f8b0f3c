"""`write_report`: the quality report of a reduced body as a self-contained web page, and as JSON beside it."""

from __future__ import annotations

import base64
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.io.page_files import write_page
from flexmb.io.web_page import page, percent, table, vector
from flexmb.model.modal_neutral_report import basis_words, beside_words, response_lines, wandering_lines
from flexmb.model.mode_table import mode_table

__all__ = ["report_numbers", "source_section", "write_report"]

SCHEMA, VERSION = "flexmb.quality_report", 1
GOOD, FAIR = 0.01, 0.05  # relative frequency errors that are shown green and yellow


def report_numbers(data) -> dict[str, Any]:
    """Return the quality report as JSON can hold it: the body, the table of its coordinates, and ``data.quality``."""
    return {
        "schema": SCHEMA,
        "schema_version": VERSION,
        "name": data.name,
        "nodes": len(data.nodes),
        "frame": data.frame,
        "mass": data.mass,
        "center_of_mass": data.center_of_mass.tolist(),
        "inertia": data.inertia.tolist(),
        "interfaces": list(data.marker_names[: data.n_interfaces]),
        "stations": list(data.marker_names[data.n_interfaces :]),
        "load_shapes": list(data.load_names),
        "geometric_stiffness": data.geometric is not None,
        "stress_modes": data.has_stress,
        "coordinates": mode_table(data),
        "quality": data.quality,
    }


def write_report(data, path: str | Path, *, picture: str | Path | None = None) -> tuple[Path, Path]:
    """Write the quality report as a web page that needs no other file, and as JSON, and return both paths.

    Parameters
    ----------
    data : ModalNeutralData
    path : path
        ``conrod.h5`` or ``conrod.html`` writes ``conrod.html`` and ``conrod.json``.
    picture : path, optional
        A PNG to show in the page, such as the one of `flexmb.view.mode_sheet`.
    """
    return write_page(path, lambda: _page(data, picture), lambda: report_numbers(data))


def _page(data, picture) -> str:
    q = data.quality
    parts = [f"<h1>{escape(data.name)}</h1>", _summary(data)]
    if q:
        parts += [_warnings(q), _frequencies(q), _told(data, q)]
    parts += [_coordinates(data)]
    if q:
        parts += [_interfaces(data, q), _mass(data, q), _effective_mass(q), source_section(q.get("source", {}))]
    if picture is not None:
        encoded = base64.b64encode(Path(picture).read_bytes()).decode("ascii")
        parts.append(f'<h2>Modes</h2><img alt="mode shapes" src="data:image/png;base64,{encoded}">')
    return page(f"{data.name}: quality of the reduced body", parts)


def _bar(share: float) -> str:
    return f'<span class="bar" style="width:{6.0 * max(share, 0.0):.2f}em"></span>'


def _summary(data) -> str:
    f = data.frequencies
    span = f", {f.min():.4g} to {f.max():.4g} Hz" if len(f) else ""
    extras = [
        f"load shapes {', '.join(data.load_names)}" if data.load_names else "no load shapes",
        "geometric stiffness" if data.geometric is not None else "no geometric stiffness",
        "stress modes" if data.has_stress else "no stress modes",
    ]
    return (
        f"<p>{len(data.nodes)} nodes, {data.n_modes} flexible coordinates{span}; body frame: {escape(data.frame)}</p>"
        f'<p class="note">{escape("; ".join(extras))}</p>'
    )


def _warnings(q) -> str:
    found = [f'<div class="warning">{escape(text)}</div>' for text in q["warnings"]]
    return "<h2>Warnings</h2>" + ("".join(found) or '<div class="fine">None.</div>')


def _frequencies(q) -> str:
    if not q["frequencies"]:
        return "<h2>Frequencies</h2><p>Not compared with the full model.</p>"
    rows = []
    for number, row in enumerate(q["frequencies"], 1):
        grade = "good" if row["error"] <= GOOD else "fair" if row["error"] <= FAIR else "poor"
        error = f'<span class="{grade}">{100.0 * row["error"]:.3g} %</span>'
        rows.append([str(number), f"{row['full']:.6g}", f"{row['reduced']:.6g}", error])
    titles = [("mode", False), ("full model Hz", False), ("reduced Hz", False), ("error", False)]
    beside = f'<p class="note">{escape(_sentence(beside_words(q)))}.</p>' if beside_words(q) else ""
    return (
        f"<h2>Free-free frequencies</h2><p>{escape(_sentence(basis_words(q)))}; static error at the interfaces "
        f"{q['static_error']:.1e}</p>{beside}" + table(titles, rows)
    )


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _told(data, q) -> str:
    """Return the bound of the response's error and what is missing under loads that move, where they are known."""
    found = []
    for title, *lines in filter(None, (response_lines(q)[1:], wandering_lines(data, q)[1:])):
        found += [f"<h2>{escape(title)}</h2>", *(f"<p>{escape(' '.join(line.split()))}</p>" for line in lines)]
    return "".join(found)


def _coordinates(data) -> str:
    modes = mode_table(data)
    names = list(dict.fromkeys(name for row in modes for name in row["participation"]))
    titles = [
        ("no.", False),
        ("frequency Hz", False),
        ("kind", True),
        ("interface", True),
        ("damping", False),
    ]
    titles += [("compliance", True), ("effective mass", True), *((name, False) for name in names)]
    rows = []
    for row in modes:
        moves = sorted(row["effective_mass"].items(), key=lambda item: -item[1])
        cells = [str(row["number"]), f"{row['frequency']:.6g}", escape(row["kind"]), escape(row["interface"])]
        cells += [percent(row["damping_ratio"], 2), percent(row["compliance"]) + _bar(row["compliance"])]
        cells += [", ".join(f"{escape(name)} {percent(share)}" for name, share in moves[:2] if share >= 0.001)]
        cells += [percent(row["participation"].get(name, 0.0)) for name in names]
        rows.append(cells)
    return (
        "<h2>Modal coordinates</h2>"
        '<p class="note">Compliance: share of the static deflection of the interfaces under their own unit loads. '
        "Effective mass: of the fixed-interface mode it is mainly made of. Last columns: participation, shares of its "
        "kinetic energy.</p>" + table(titles, rows)
    )


def _interfaces(data, q) -> str:
    titles = [("name", True), ("kind", True), ("nodes", False), ("freedoms", False), ("at, m", True)]
    rows = [
        [
            escape(i["name"]),
            escape(i["kind"]),
            escape(i.get("node", str(i["nodes"]))),
            str(len(i["freedoms"])),
            vector(i["position"]),
        ]
        for i in q["interfaces"]
    ]
    first = data.n_interfaces
    rows += [
        [escape(name), "station", "", "", vector(position)]
        for name, position in zip(data.marker_names[first:], data.marker_positions[first:])
    ]
    return "<h2>Interfaces and stations</h2>" + table(titles, rows)


def source_section(found) -> str:
    """Return the inventory of the deck that an FE model comes from (`FEModel.source`); empty without one."""
    if not found:
        return ""
    titles = [("", True), ("of the deck", True), ("count", False)]
    words = (("read", "read"), ("approximated", "approximated"), ("left out", "left_out"), ("not needed", "not_needed"))
    rows = [[title, escape(text), str(n)] for title, key in words for text, n in found.get(key, {}).items()]
    units = found["units"] or "as in the deck, not known"
    head = f"{found['program']} deck {found['file']}, {found['nodes']} nodes; units: {units}"
    return f"<h2>Source</h2><p>{escape(head)}</p>" + table(titles, rows)


def _mass(data, q) -> str:
    mesh = q["mass"]
    titles = [("", True), ("reduced body", True), ("mesh", True)]
    diagonal = np.diag(np.array(mesh["inertia"]))
    rows = [
        ["mass, kg", f"{data.mass:.9g}", f"{mesh['mass']:.9g}"],
        ["centre of mass, m", vector(data.center_of_mass), vector(mesh["center_of_mass"])],
        ["inertia about it, kg m2", vector(np.diag(data.inertia)), vector(diagonal)],
    ]
    rigid = q["rigid_modes"]
    return (
        "<h2>Mass</h2>" + table(titles, rows) + f"<p>{rigid['removed']} rigid motions removed; they meet a relative "
        f"force of {rigid['grounding']:.1e} in the FE model.</p>"
    )


def _effective_mass(q) -> str:
    shares_of, f = q["effective_mass"], q["fixed_interface_frequencies"]
    titles = [("mode", False), ("frequency Hz", False), *((name, False) for name in shares_of["directions"])]
    rows = [
        [str(k + 1), f"{f[k]:.6g}", *(percent(share) for share in shares)]
        for k, shares in enumerate(shares_of["per_mode"])
    ]
    rows.append(["", "sum", *(percent(share) for share in shares_of["sum"])])
    return "<h2>Effective mass of the fixed-interface modes</h2>" + table(titles, rows)
