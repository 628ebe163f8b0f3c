"""`write_deck_report`: what is in a deck, and what is wrong with it, as a web page and as JSON beside it."""

from __future__ import annotations

import base64
from html import escape
from pathlib import Path
from typing import Any

from flexmb.fem.deck.checks import DeckChecks
from flexmb.io.page_files import write_page
from flexmb.io.quality_page import source_section
from flexmb.io.web_page import page, table, vector

__all__ = ["deck_numbers", "write_deck_report"]

SCHEMA, VERSION = "flexmb.deck_report", 1


def deck_numbers(checks: DeckChecks) -> dict[str, Any]:
    """Return what was found in a deck as JSON can hold it: source and inventory, checks, interfaces, supports, sets."""
    fe = checks.fe
    points = {
        name: {
            "node": fe.node_name(at.node),
            "position": fe.nodes[at.node].tolist(),
            "follows": "the mean of others" if at.averaged is not None else "its own freedoms",
        }
        for name, at in fe.reference_points.items()
    }
    return {
        "schema": SCHEMA,
        "schema_version": VERSION,
        "name": fe.name,
        "freedoms": fe.ndof,
        "source": dict(fe.source),
        "warnings": list(fe.warnings),
        "checks": checks.numbers(),
        "interfaces": points,
        "supports": {
            name: len(held) + (fe.slanted[name].shape[0] if name in fe.slanted else 0)
            for name, held in fe.supports.items()
        },
        "sets": {name: len(nodes) for name, nodes in fe.node_sets.items()},
    }


def write_deck_report(checks: DeckChecks, path: str | Path, *, picture: str | Path | None = None) -> tuple[Path, Path]:
    """Write what was found in a deck as a web page that needs no other file, and as JSON, and return both paths.

    Parameters
    ----------
    checks : DeckChecks
        Of `flexmb.fem.deck_checks`.
    path : path
        ``wing.bdf`` or ``wing.html`` writes ``wing.html`` and ``wing.json``.
    picture : path, optional
        A PNG to show in the page, such as the one of `flexmb.view.model_picture`.
    """
    found = deck_numbers(checks)
    return write_page(path, lambda: _page(checks, found, picture), lambda: found)


def _page(checks: DeckChecks, found: dict[str, Any], picture) -> str:
    fe = checks.fe
    warnings = [f'<div class="warning">{escape(text)}</div>' for text in fe.warnings]
    parts = [f"<h1>{escape(fe.name)}</h1>", f"<p>{len(fe.nodes)} nodes, {fe.ndof} freedoms</p>"]
    parts.append("<h2>Warnings</h2>" + ("".join(warnings) or '<div class="fine">None.</div>'))
    sentences = "".join(f"<li>{escape(text)}</li>" for text in checks.sentences())
    parts.append(f"<h2>What was found</h2><ul>{sentences}</ul>")
    if picture is not None:
        encoded = base64.b64encode(Path(picture).read_bytes()).decode("ascii")
        parts.append(f'<img alt="the model" src="data:image/png;base64,{encoded}">')
    titles = [("interface", True), ("node", True), ("at", True), ("moves by", True)]
    rows = [
        [escape(name), escape(one["node"]), vector(one["position"]), one["follows"]]
        for name, one in found["interfaces"].items()
    ]
    parts.append("<h2>Interfaces that the deck offers</h2>" + (table(titles, rows) if rows else "<p>None.</p>"))
    for title, word in (("Supports, kept but not applied", "supports"), ("Sets", "sets")):
        if found[word]:
            counted = [[escape(name), str(n)] for name, n in found[word].items()]
            unit = "freedoms" if word == "supports" else "nodes"
            parts.append(f"<h2>{title}</h2>" + table([("name", True), (unit, False)], counted))
    parts.append(source_section(fe.source))
    return page(f"{fe.name}: what is in the deck", parts)
