"""`write_report`: the quality report of a reduced body as a self-contained web page, and as JSON beside it."""

from __future__ import annotations

import base64
import json
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import DataFileError
from flexmb.model.mode_table import mode_table

__all__ = ["report_numbers", "write_report"]

SCHEMA, VERSION = "flexmb.quality_report", 1
GOOD, FAIR = 0.01, 0.05  # relative frequency errors that are shown green and yellow

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #26303a; max-width: 72em; margin: 2em auto; padding: 0 1.5em }
h1 { font-size: 1.5em; margin-bottom: 0.1em } h2 { font-size: 1.15em; margin: 1.8em 0 0.4em }
p { margin: 0.3em 0 } .note { color: #66727e }
table { border-collapse: collapse; font-variant-numeric: tabular-nums }
th, td { padding: 0.2em 0.9em 0.2em 0; text-align: right; border-bottom: 1px solid #dfe6ee; white-space: nowrap }
th { color: #66727e; font-weight: 600 } th.text, td.text { text-align: left }
.bar { display: inline-block; height: 0.7em; background: #6f9fc8; margin-left: 0.5em; vertical-align: baseline }
.good { color: #2b7a4b } .fair { color: #a86f10 } .poor { color: #b3263d; font-weight: 600 }
.warning { border-left: 4px solid #c98a2b; padding: 0.3em 0.8em; background: #fbf5e9; margin: 0.4em 0 }
.fine { border-left: 4px solid #3a8f5c; padding: 0.3em 0.8em; background: #eef6f1 }
img { max-width: 100% }
"""


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
        "stress_modes": data.stress_modes is not None,
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
    path = Path(path)
    page, numbers = path.with_suffix(".html"), path.with_suffix(".json")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(_page(data, picture), encoding="utf-8")
        numbers.write_text(json.dumps(report_numbers(data), indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise DataFileError(
            f"Report '{page}'",
            found=f"cannot write it ({error})",
            expected="a writable folder with free space",
            remedy="Free space, or choose another folder",
        ) from error
    return page, numbers


def _page(data, picture) -> str:
    q = data.quality
    parts = [f"<h1>{escape(data.name)}</h1>", _summary(data)]
    if q:
        parts += [_warnings(q), _frequencies(q)]
    parts += [_coordinates(data)]
    if q:
        parts += [_interfaces(data, q), _mass(data, q), _effective_mass(q)]
    if picture is not None:
        encoded = base64.b64encode(Path(picture).read_bytes()).decode("ascii")
        parts.append(f'<h2>Modes</h2><img alt="mode shapes" src="data:image/png;base64,{encoded}">')
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(data.name)}: quality of the reduced body</title><style>{STYLE}</style></head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def _table(titles: list[tuple[str, bool]], rows: list[list[str]]) -> str:
    """Return a table; a title says whether its column is text, cells are HTML."""
    kind = ['class="text"' if text else "" for _, text in titles]
    head = "".join(f"<th {k}>{escape(title)}</th>" for (title, _), k in zip(titles, kind))
    body = "".join(
        "<tr>" + "".join(f"<td {k}>{cell}</td>" for cell, k in zip(row, kind)) + "</tr>\n" for row in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>\n{body}</tbody></table>"


def _percent(share: float, digits: int = 1) -> str:
    return f"{100.0 * share:.{digits}f} %"


def _bar(share: float) -> str:
    return f'<span class="bar" style="width:{6.0 * max(share, 0.0):.2f}em"></span>'


def _vector(values) -> str:
    return ", ".join(f"{x:.6g}" for x in values)


def _summary(data) -> str:
    f = data.frequencies
    span = f", {f.min():.4g} to {f.max():.4g} Hz" if len(f) else ""
    extras = [
        f"load shapes {', '.join(data.load_names)}" if data.load_names else "no load shapes",
        "geometric stiffness" if data.geometric is not None else "no geometric stiffness",
        "stress modes" if data.stress_modes is not None else "no stress modes",
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
    return (
        f"<h2>Free-free frequencies</h2><p>{q['normal_modes']} fixed-interface modes; static error at the interfaces "
        f"{q['static_error']:.1e}</p>" + _table(titles, rows)
    )


def _coordinates(data) -> str:
    table = mode_table(data)
    names = list(dict.fromkeys(name for row in table for name in row["participation"]))
    titles = [
        ("no.", False),
        ("frequency Hz", False),
        ("kind", True),
        ("interface", True),
        ("damping", False),
    ]
    titles += [("compliance", True), ("effective mass", True), *((name, False) for name in names)]
    rows = []
    for row in table:
        moves = sorted(row["effective_mass"].items(), key=lambda item: -item[1])
        cells = [str(row["number"]), f"{row['frequency']:.6g}", escape(row["kind"]), escape(row["interface"])]
        cells += [_percent(row["damping_ratio"], 2), _percent(row["compliance"]) + _bar(row["compliance"])]
        cells += [
            ", ".join(f"{escape(name)} {_percent(share)}" for name, share in moves[:2] if share >= 0.001)
        ]
        cells += [_percent(row["participation"].get(name, 0.0)) for name in names]
        rows.append(cells)
    return (
        "<h2>Modal coordinates</h2>"
        '<p class="note">Compliance: share of the static deflection of the interfaces under their own unit loads. '
        "Effective mass: of the fixed-interface mode it is mainly made of. Last columns: participation, shares of its "
        "kinetic energy.</p>" + _table(titles, rows)
    )


def _interfaces(data, q) -> str:
    titles = [("name", True), ("kind", True), ("nodes", False), ("freedoms", False), ("at, m", True)]
    rows = [
        [
            escape(i["name"]),
            escape(i["kind"]),
            str(i["nodes"]),
            str(len(i["freedoms"])),
            _vector(i["position"]),
        ]
        for i in q["interfaces"]
    ]
    first = data.n_interfaces
    rows += [
        [escape(name), "station", "", "", _vector(position)]
        for name, position in zip(data.marker_names[first:], data.marker_positions[first:])
    ]
    return "<h2>Interfaces and stations</h2>" + _table(titles, rows)


def _mass(data, q) -> str:
    mesh = q["mass"]
    titles = [("", True), ("reduced body", True), ("mesh", True)]
    diagonal = np.diag(np.array(mesh["inertia"]))
    rows = [
        ["mass, kg", f"{data.mass:.9g}", f"{mesh['mass']:.9g}"],
        ["centre of mass, m", _vector(data.center_of_mass), _vector(mesh["center_of_mass"])],
        ["inertia about it, kg m2", _vector(np.diag(data.inertia)), _vector(diagonal)],
    ]
    rigid = q["rigid_modes"]
    return (
        "<h2>Mass</h2>"
        + _table(titles, rows)
        + f"<p>{rigid['removed']} rigid motions removed; they meet a relative "
        f"force of {rigid['grounding']:.1e} in the FE model.</p>"
    )


def _effective_mass(q) -> str:
    table, f = q["effective_mass"], q["fixed_interface_frequencies"]
    titles = [("mode", False), ("frequency Hz", False), *((name, False) for name in table["directions"])]
    rows = [
        [str(k + 1), f"{f[k]:.6g}", *(_percent(share) for share in shares)]
        for k, shares in enumerate(table["per_mode"])
    ]
    rows.append(["", "sum", *(_percent(share) for share in table["sum"])])
    return "<h2>Effective mass of the fixed-interface modes</h2>" + _table(titles, rows)
