"""Pages can be read: lines that fit into a window, words that a reader knows, an index that names every page."""

import re

from architecture.sources import FILES, ROOT, for_each, name

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "meshes").rglob("*.md"))]
WIDTH = 140
PHRASES = {
    r"leave (it|them) away": "omit",
    r"handed on": "returned, passed",
    r"what (is|are) no\b": "what is not, non-",
    r"that shall\b": "to cut, to keep, ...",
    r"\bwho shall\b|\bwhat shall\b": "to do",
    r"(true and false|booleans) are none": "booleans do not count",
    r"(is|are) no numbers? any more": "is no longer finite",
    r"\bthereof\b|\btherewith\b|\bwherefore\b": "of it, with it, why",
}
"""Words that read as translated, and what to write instead."""


@for_each(PAGES)
def test_lines_of_pages_fit(path):
    """Rows of tables cannot be divided; everything else can."""
    lines = path.read_text(encoding="utf-8").splitlines()
    long = [k for k, line in enumerate(lines, 1) if len(line) > WIDTH and not line.lstrip().startswith("|")]
    assert not long, f"{path.relative_to(ROOT)}: lines {long} have more than {WIDTH} characters"


@for_each([*PAGES, *FILES])
def test_words_are_plain(path):
    text = re.sub(r"\s+(# )?", " ", path.read_text(encoding="utf-8"))
    found = [
        f"'{match[0]}': {instead}" for phrase, instead in PHRASES.items() for match in re.finditer(phrase, text, re.I)
    ]
    assert not found, f"{name(path)}: {found}"


def test_the_index_names_every_how_to_page():
    folder = ROOT / "docs" / "howto"
    listed = re.findall(r"^[a-z][\w-]*$", (folder / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(listed) == sorted(path.stem for path in folder.glob("*.md") if path.stem != "index")


def test_decisions_have_numbers_of_their_own():
    """Pages and comments name a decision by its number."""
    numbers = [path.name[:4] for path in sorted((ROOT / "docs" / "decisions").glob("0*.md"))]
    assert len(set(numbers)) == len(numbers), [one for one in numbers if numbers.count(one) > 1]
    for path in (ROOT / "docs" / "decisions").glob("0*.md"):
        assert path.read_text(encoding="utf-8").startswith(f"# {path.name[:4]}: "), path.name
