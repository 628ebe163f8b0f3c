"""What the code cites exists: equations by their label, pages by their path.

The code cites an equation of docs/theory as ``eq. (label)``; labels begin with a letter, so the numbered
equations of papers, "eq. (41)", are left alone.
"""

import re
from functools import cache

from architecture.sources import FILES, ROOT, for_each, name

THEORY = ROOT / "docs" / "theory"
CITED = re.compile(r"\beqs?\.\s+((?:\([a-z][\w-]*\)(?:,\s*|\s+and\s+|\s+to\s+)?)+)")
LABEL = re.compile(r"\(([a-z][\w-]*)\)")
DEFINED = re.compile(r"^:label:\s*([\w-]+)\s*$|^\$\$\s*\(([\w-]+)\)\s*$", re.MULTILINE)
PAGE = re.compile(r"\bdocs/[\w./-]+\.md\b")


@cache
def defined_labels():
    pages = THEORY.glob("*.md")
    return [first or second for page in pages for first, second in DEFINED.findall(page.read_text("utf-8"))]


def test_labels_are_unique():
    labels = defined_labels()
    twice = sorted({label for label in labels if labels.count(label) > 1})
    assert not twice, f"defined twice in docs/theory: {twice}"


@for_each(FILES)
def test_cited_equations_exist(path):
    text = path.read_text(encoding="utf-8")
    cited = {label for group in CITED.findall(text) for label in LABEL.findall(group)}
    missing = sorted(cited - set(defined_labels()))
    assert not missing, f"{name(path)} cites {missing}, which no page of docs/theory defines"


@for_each(FILES)
def test_cited_pages_exist(path):
    missing = [page for page in PAGE.findall(path.read_text(encoding="utf-8")) if not (ROOT / page).is_file()]
    assert not missing, f"{name(path)} cites {missing}"
