"""Web pages that need no other file: style, tables, numbers."""

from __future__ import annotations

from html import escape

__all__ = ["STYLE", "page", "percent", "table", "vector"]

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


def page(title: str, parts: list[str], style: str = "") -> str:
    """Return a whole page: its title, its parts one below the other, and more style than the usual one."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(title)}</title><style>{STYLE}{style}</style></head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def table(titles: list[tuple[str, bool]], rows: list[list[str]]) -> str:
    """Return a table; a title says whether its column is text, cells are HTML."""
    kind = ['class="text"' if text else "" for _, text in titles]
    head = "".join(f"<th {k}>{escape(title)}</th>" for (title, _), k in zip(titles, kind))
    body = "".join("<tr>" + "".join(f"<td {k}>{cell}</td>" for cell, k in zip(row, kind)) + "</tr>\n" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>\n{body}</tbody></table>"


def percent(share: float, digits: int = 1) -> str:
    """Return 0.123 as "12.3 %"."""
    return f"{100.0 * share:.{digits}f} %"


def vector(values) -> str:
    """Return numbers separated by commas."""
    return ", ".join(f"{x:.6g}" for x in values)
