"""The section of a report that says where flexible bodies are stressed most, by the numbers of their decks."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from flexmb.io.web_page import table, vector
from flexmb.results import recover
from flexmb.view.quantities import number, scaled
from flexmb.view.report_results import Run

__all__ = ["stresses"]


def stresses(runs: Sequence[Run]) -> str:
    """The largest von Mises stress of every flexible body over all times: where and when."""
    found = [(run, *peak) for run in runs for peak in _peaks(run.solution)]
    if not found:
        return ""
    factor, unit = scaled("Pa", max(value for *_, value in found))
    titles = [
        ("body", True),
        ("at", True),
        ("place in body axes, m", True),
        (f"von Mises {unit}", False),
        ("at s", False),
    ]
    if len(runs) > 1:
        titles.insert(1, ("run", True))
    rows = []
    for run, body, where, place, time, value in found:
        row = [escape(body), escape(where), vector(place), number(factor * value), f"{time:.4g}"]
        if len(runs) > 1:
            row.insert(1, escape(run.name))
        rows.append(row)
    return "<h2>Largest stress</h2>" + table(titles, rows)


def _peaks(solution):
    """Yield (body, node in words, its place (3,), time s, von Mises stress Pa) of every body with stress modes."""
    best: dict[str, tuple[str, np.ndarray, float, float]] = {}
    for count, phase in enumerate(solution.phases):
        if phase.model is None:
            return
        series = solution.series(count)
        for body in phase.model.bodies:
            data = getattr(body, "reduced", None)
            if data is None or not data.has_stress:
                continue
            value, time = recover.von_mises_envelope(data, phase.t, series.modal_coordinates(body.name))
            node = int(np.argmax(value))
            if body.name not in best or value[node] > best[body.name][3]:
                best[body.name] = (data.node_name(node), data.nodes[node], float(time[node]), float(value[node]))
    for name, peak in best.items():
        yield name, *peak
