"""The lines of a Nastran deck: INCLUDE files in their places, the case control up to the bulk data."""

from __future__ import annotations

import re
from array import array
from bisect import bisect_right
from collections.abc import Iterator
from pathlib import Path

from flexmb.errors import MeshError
from flexmb.fem.deck.files import beside, deck_bytes
from flexmb.fem.deck.nastran_replication import Replication, replicates
from flexmb.files import resolved

__all__ = ["BEGIN", "Lines", "Places", "control", "deck_lines"]

INCLUDE = re.compile(rb"""^\s*INCLUDE\s+(.*)$""", re.IGNORECASE)
BEGIN = re.compile(rb"^\s*BEGIN\s*(BULK|SUPER|ARBMODEL|AUXMODEL)?\b\s*(.*)$", re.IGNORECASE)
SUPER = re.compile(rb"^BEGIN[^\n]*SUPER", re.IGNORECASE | re.MULTILINE)
CHOICE = re.compile(rb"^\s*(SPC|MPC|NSM)\s*(\([^)]*\))?\s*=\s*(\d+)", re.IGNORECASE)


class Places:
    """Where the lines of a deck stand: runs of lines that follow each other in one file."""

    def __init__(self) -> None:
        self.files: list[Path] = []
        self.first: list[int] = []  # line of the deck with which each run begins
        self.file: list[int] = []
        self.line: list[int] = []
        self._next = (-1, -1)

    def add(self, k: int, number: int, line: int) -> None:
        """Tell that line k of the deck is this one of a file."""
        if (number, line) != self._next:
            self.first.append(k)
            self.file.append(number)
            self.line.append(line)
        self._next = (number, line + 1)

    def run(self, k: int) -> int:
        """Return the number of the run in which line k of the deck stands."""
        return bisect_right(self.first, k) - 1

    def where(self, k: int) -> str:
        """Return words for the place of line k."""
        run = self.run(k)
        return f"{self.files[self.file[run]]}:{self.line[run] + k - self.first[run]}"


class Lines:
    """All lines of a deck, tabs expanded, without comments behind and blanks at the end.

    The bytes of the files are kept as they are, and the begin and size of every line in them: a line takes 8 bytes
    beside its text. Lines that are not as in the file stand in `changed`.
    """

    def __init__(self) -> None:
        self.data: list[bytes] = []
        self.begin, self.size = array("I"), array("I")
        self.changed: dict[int, bytes] = {}
        self.places = Places()
        self._low, self._high, self._text = 0, 0, b""

    def __len__(self) -> int:
        return len(self.begin)

    def __getitem__(self, k: int) -> bytes:
        if k in self.changed:
            return self.changed[k]
        if not self._low <= k < self._high:  # lines are read one after the other: the file changes seldom
            run, first = self.places.run(k), self.places.first
            self._low, self._high = first[run], first[run + 1] if run + 1 < len(first) else len(self)
            self._text = self.data[self.places.file[run]]
        begin = self.begin[k]
        return self._text[begin : begin + self.size[k]]

    def __iter__(self) -> Iterator[bytes]:
        return (self[k] for k in range(len(self)))

    def add(self, number: int, k: int, begin: int, line: bytes, as_written: bool) -> None:
        """Add line k of a file that begins at a place of its bytes."""
        if not as_written:
            self.changed[len(self.begin)] = line
        self.places.add(len(self.begin), number, k)
        self.begin.append(begin)
        self.size.append(len(line))

    def where(self, k: int) -> str:
        """Return words for the place of line k."""
        return self.places.where(k)

    def card(self, k: int) -> list[bytes]:
        """Return line k and the lines that continue it."""
        parts = [self[k]]
        for at in range(k + 1, len(self)):
            line = self[at]
            if line[:1] == b"$" or not line:
                continue
            if line[:1] not in b" +*,":
                break
            parts.append(line)
        return parts


def deck_lines(path: Path) -> Lines:
    """Return the lines of a deck, with INCLUDE files in their places."""
    lines = Lines()
    _read(path, path.parent, lines, ())
    return lines


def _read(path: Path, main: Path, lines: Lines, above: tuple[Path, ...]) -> None:
    """Add all lines of a file and of those it includes."""
    number = len(lines.places.files)
    data = deck_bytes(path, above, lines.places.files)
    if len(data) >= 1 << 32:
        lines.begin = array("Q", lines.begin)
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    lines.data += [b""] * (number + 1 - len(lines.data))
    lines.data[number] = data
    waiting: tuple[bytes, int] | None = None
    copies = Replication() if replicates(data) else None
    k, begin, last = 0, 0, len(data)
    while begin < last:
        k, start = k + 1, begin
        stop = data.find(b"\n", begin)
        stop = last if stop < 0 else stop
        begin, line, as_written, place = stop + 1, data[begin:stop].rstrip(), True, k
        if b"\t" in line:
            line, as_written = line.expandtabs(8).rstrip(), False
        if waiting is not None:
            line, place, as_written = waiting[0] + line.strip(), waiting[1], False
            waiting = None
        if line[:1] not in b"$" and line[:16].lstrip()[:7].upper() == b"INCLUDE" and (match := INCLUDE.match(line)):
            name = match[1].strip()
            if name[:1] in (b"'", b'"') and name.count(name[:1]) < 2 and begin < last:
                waiting = (line, place)
                continue
            _read(_included(name, path, main, place), main, lines, (*above, resolved(path)))
            continue
        if line and line[:1] != b"$" and b"$" in line:
            line = line[: line.index(b"$")].rstrip()
        if copies is None:
            lines.add(number, place, start, line, as_written)
            continue
        for copy in copies.read(line):
            lines.add(number, place, start, copy, as_written and copy is line)


def _included(name: bytes, path: Path, main: Path, k: int) -> Path:
    """Return the file of an INCLUDE, beside the main deck or beside the including file."""
    text = name.decode("utf-8", "replace").strip()
    if text[:1] in "'\"" and text:
        text = text[1:].split(text[0])[0]
    else:
        text = text.split("$")[0].strip()
    text = text.replace("\\", "/") if "/" not in text else text
    if (found := beside(text, main, path)) is not None:
        return found
    raise MeshError(
        f"Deck '{path}', line {k}",
        found=f"INCLUDE '{text[:120]}': no such file",
        expected=f"a file beside the main deck ('{main}') or beside the file that includes it",
        remedy="Put the included file there, or write one flat deck",
    )


def control(lines: Lines, path: Path) -> tuple[int, dict[str, int]]:
    """Return the number of the first bulk line, and what the case control chooses."""
    choices: dict[str, int] = {}
    begin = cend = None
    for k, text in enumerate(lines):
        if text[:1] == b"$":
            continue
        upper = text[:12].lstrip().upper()
        if upper.startswith(b"CEND"):
            cend = k
        if upper.startswith(b"BEGIN") and (match := BEGIN.match(text)):
            if b"SUPER" in (match[1] or b"").upper() + match[2].upper():
                raise MeshError(
                    lines.where(k),
                    found="a deck of superelements (BEGIN SUPER)",
                    expected="one residual structure",
                    remedy="Write the deck flat, or read each superelement from its own file",
                )
            begin = k
            break
        if upper.startswith((b"GRID", b"CQUAD4", b"CTETRA", b"CHEXA", b"ENDDATA")) and cend is None:
            break  # no control sections: an included file or a punched mesh
        if cend is not None and (match := CHOICE.match(text)):
            choices.setdefault(match[1].upper().decode(), int(match[3]))
    if begin is not None:
        if any(SUPER.search(data) for data in lines.data):
            raise MeshError(
                f"Deck '{path}'",
                found="superelements (BEGIN SUPER)",
                expected="one residual structure",
                remedy="Write the deck flat, or read each superelement from its own file",
            )
        return begin + 1, choices
    return (cend + 1 if cend is not None else 0), choices
