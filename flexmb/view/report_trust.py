"""The section of a report that shows how far its runs can be trusted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from flexmb.io.web_page import table
from flexmb.view.quantities import number
from flexmb.view.report_results import Run

__all__ = ["trust"]


def trust(runs: Sequence[Run], verified: Mapping[str, Any]) -> str:
    """What `flexmb verify` found about each run, if it was asked."""
    parts = [_of_one(run.name if len(runs) > 1 else "", verified[run.name]) for run in runs if run.name in verified]
    return "<h2>How far this can be trusted</h2>" + "".join(parts) if parts else ""


def _of_one(name: str, found: Any) -> str:
    title = f"<h3>{escape(name)}</h3>" if name else ""
    verdict = f"<p><b>{escape(found.verdict[:1].upper() + found.verdict[1:])}.</b></p>"
    notes = "".join(f'<p class="note">{escape(text)}</p>' for text in _remarks(found))
    return title + verdict + _checks(found) + _answers(found) + notes


def _checks(found: Any) -> str:
    titles = [("the solution itself", True), ("found", False), ("limit", False), ("", True), ("where", True)]
    rows = [
        [escape(c.name), f"{c.share:.1e}", f"{c.limit:.1e}", "holds" if c.holds else "<b>does not</b>", escape(c.worst)]
        for c in found.checks
    ]
    return f'<div class="scroll">{table(titles, rows)}</div>' if rows else ""


def _answers(found: Any) -> str:
    names = list(dict.fromkeys(name for answer in found.answers for name in answer.course))
    titles = [
        ("answer", True),
        ("unit", True),
        ("largest", False),
        ("relative to", True),
        *((f"by {name}", False) for name in names),
    ]
    rows = [
        [
            escape(answer.name),
            escape(answer.unit),
            number(answer.largest),
            escape(answer.compared_with),
            *(f"{100.0 * answer.course[name]:.2g} %" if name in answer.course else "-" for name in names),
            escape(answer.verdict) if answer.holds else f"<b>{escape(answer.verdict)}</b>",
        ]
        for answer in found.answers
    ]
    return f'<div class="scroll">{table([*titles, ("verdict", True)], rows)}</div>' if rows else ""


def _remarks(found: Any) -> list[str]:
    return [*(f"Compared with: {text}." for text in found.runs), *(f"{text}." for text in found.notes)]
