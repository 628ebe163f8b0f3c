"""The bulk data of a Nastran deck as cards: INCLUDE files in their places, continuations joined.

Fields of 8 characters, of 16 (names with ``*``), or between commas, in any mixture. The executive and case control are
passed over, but for the sets of supports and multipoint constraints that they choose. Grid points and cells, of which
there are many, are cut into columns all at once.
"""

from __future__ import annotations

import re
from array import array
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.files import HUGE
from flexmb.fem.deck.nastran_source import BEGIN, Lines, Places, control, deck_lines
from flexmb.fem.ranges import LARGEST

__all__ = ["Bulk", "Card", "FieldTable", "read_bulk"]

END = re.compile(rb"^\s*ENDDATA\b", re.IGNORECASE)
CONTINUED = re.compile(r"[+*]([A-Za-z]\w*)?")
APART = re.compile(r"([\d.])\s+([EeDd]?[+-]\d+)$")
"""Blanks between a number and its exponent."""
MANY = frozenset(
    ("GRID", "CTETRA", "CHEXA", "CPENTA", "CPYRAM", "CTRIA3", "CTRIAR", "CTRIA6", "CQUAD4", "CQUADR", "CQUAD8")
)
"""Cards that are cut as tables."""
FIELDS = 24
"""Columns of such a table, the name included: a CHEXA of 20 nodes has 23."""
LONGEST = 64
"""Characters of a field between commas."""
CHUNK = 4_000
"""Cards that are cut together: their text is copied once more meanwhile."""


@dataclass(slots=True, eq=False)
class Card:
    """One card: its name, its fields (the name first), and where it stands."""

    name: str
    fields: list[str]
    where: str

    def text(self, i: int) -> str:
        """Return field i, blank if the card is shorter."""
        return self.fields[i] if i < len(self.fields) else ""

    def integer(self, i: int, default: int | None = None) -> int:
        """Return field i as an integer; MeshError if it is none, or blank without a default."""
        word = self.text(i)
        if not word and default is not None:
            return default
        try:
            value = int(word) if "_" not in word else None
        except ValueError:
            try:
                number = _real(word)
                value = int(number) if number == int(number) else None
            except (ValueError, OverflowError):
                value = None
        if value is None or abs(value) >= LARGEST:
            raise self.wrong(i, "an integer")
        return value

    def real(self, i: int, default: float | None = None) -> float:
        """Return field i as a finite number; MeshError if it is none, or blank without a default."""
        word = self.text(i)
        if not word and default is not None:
            return default
        try:
            value = _real(word)
        except ValueError:
            raise self.wrong(i, "a number") from None
        if not abs(value) < HUGE:
            raise self.wrong(i, f"a number below {HUGE:g}")
        return value

    def is_real(self, i: int) -> bool:
        """Whether field i is written as a real number (with a point or an exponent)."""
        word = self.text(i)
        try:
            _real(word)
        except ValueError:
            return False
        return bool(word) and not re.fullmatch(r"[+-]?\d+", word)

    def wrong(self, i: int, expected: str) -> MeshError:
        """Return the error of a field that is not as expected."""
        return MeshError(
            f"{self.where}, card {self.name} {self.text(1)}",
            found=f"field {i + 1} reads '{self.text(i)}'",
            expected=expected,
            remedy="Correct the card, or write the deck again",
        )

    def refused(self, found: str, expected: str, remedy: str = "Correct the card") -> MeshError:
        """Return an error about the card as a whole."""
        return MeshError(
            f"{self.where}, card {self.name} {self.text(1)}", found=found, expected=expected, remedy=remedy
        )


@dataclass(eq=False)
class FieldTable:
    """Cards of one name as columns of bytes, (n,) by number of the field, blank ones left away; their lines (n,)."""

    name: str
    columns: dict[int, np.ndarray]
    lines: np.ndarray
    places: Places

    def __len__(self) -> int:
        return len(self.lines)

    def blank(self, i: int) -> np.ndarray:
        """Whether field i is blank, (n,)."""
        return self.column(i) == b""

    def column(self, i: int) -> np.ndarray:
        """Return the words of field i, (n,) of bytes."""
        return self.columns[i] if i in self.columns else np.zeros(len(self), "S1")

    def integers(self, i: int, default: int = 0) -> np.ndarray:
        """Return field i of all cards, (n,); blanks become `default`."""
        column = np.where(self.blank(i), str(default).encode(), self.column(i))
        try:
            return column.astype(np.int64)
        except (ValueError, OverflowError):
            return np.array([self.card(k).integer(i, default) for k in range(len(column))], np.int64)

    def reals(self, i: int, default: float = 0.0) -> np.ndarray:
        """Return field i of all cards, (n,); blanks become `default`."""
        column = np.where(self.blank(i), repr(default).encode(), self.column(i))
        try:
            values = column.astype(float)
        except ValueError:  # 1.5-3, 1.0D+2
            values = np.empty(len(column))
            for k, word in enumerate(column):
                try:
                    values[k] = _real(word.decode("latin-1"))
                except ValueError:
                    raise self.card(k).wrong(i, "a number") from None
        if not (np.abs(values) < HUGE).all():
            raise self.card(int(np.argmin(np.abs(values) < HUGE))).wrong(i, f"a number below {HUGE:g}")
        return values

    def card(self, k: int) -> Card:
        """Return card k."""
        last = max(self.columns, default=0)
        words = [self.column(i)[k].decode("latin-1") for i in range(1, last + 1)]
        return Card(self.name, [self.name, *words], self.where(k))

    def where(self, k: int) -> str:
        """Return words for the place of card k."""
        return self.places.where(int(self.lines[k]))

    def alike(self, k: int, other: int) -> bool:
        """Whether two cards read the same."""
        return all(column[k] == column[other] for column in self.columns.values())

    def chosen(self, rows: np.ndarray) -> FieldTable:
        """Return some of the cards."""
        columns = {i: column[rows] for i, column in self.columns.items()}
        return FieldTable(self.name, columns, self.lines[rows], self.places)


@dataclass(eq=False)
class Bulk:
    """The bulk data: few cards one by one, many as tables; the chosen SPC and MPC sets; comments with names.

    `ended` is False where BEGIN BULK opens the data and no ENDDATA closes them.
    """

    cards: dict[str, list[Card]] = field(default_factory=dict)
    tables: dict[str, FieldTable] = field(default_factory=dict)
    choices: dict[str, int] = field(default_factory=dict)
    comments: list[str] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    ended: bool = True

    def of(self, *names: str) -> list[Card]:
        """Return the cards of some names, in the order of the file for each name."""
        return [card for name in names for card in self.cards.get(name, ())]


def read_bulk(path: Path) -> Bulk:
    """Read a deck; MeshError names file and line of what cannot be read."""
    lines = deck_lines(path)
    start, choices = control(lines, path)
    bulk = Bulk(choices=choices, ended=not (start and BEGIN.match(lines[start - 1])))
    starts: dict[bytes, array] = {}
    begun = False
    for k in range(start, len(lines)):
        text = lines[k]
        first = text[:1]
        if first == b"$" or not text:
            if text[:2] in (b"$H", b"$ ", b"$*") and len(bulk.comments) < 100_000:
                bulk.comments.append(text.decode("latin-1"))
            continue
        if first in b" +*," and begun:
            continue
        if first in b"eE" and END.match(text):
            bulk.ended = True
            break
        begun = True
        key = text[:8].split(b",")[0].strip().rstrip(b"* ").upper()
        if key not in starts:
            starts[key] = array("I")
        starts[key].append(k)
    for key, found in starts.items():
        name = key.decode("latin-1")
        bulk.counts[name] += len(found)
        if name in MANY:
            bulk.tables[name] = _table(name, found, lines)
        else:
            bulk.cards[name] = [Card(name, _words(lines.card(k), lines.where(k)), lines.where(k)) for k in found]
    return bulk


def _words(parts: list[bytes], where: str) -> list[str]:
    """Return the fields of a card, the name first, the lines of its continuations joined at full width."""
    words: list[str] = []
    width = 8
    for number, line in enumerate(parts):
        text = line.decode("latin-1")
        if "," in text:
            fields = [word.strip() for word in text.split(",")]
            if fields[-1].startswith("+"):
                fields[-1] = "".join(fields[-1].split())  # "+ A" is one name of a continuation
            large = fields[0].endswith("*") or fields[0].startswith("*")
            data = [part for word in fields[1:] for part in (word.split() or [""])]  # blanks separate fields too
            per_line = 4 if large else 8
            longer = len(data) > per_line + 1 and any(data[per_line + 1 :])
            if longer and data[per_line] and not CONTINUED.fullmatch(data[per_line]):
                words += [""] * (-(len(words) - 1) % width) if number else [fields[0].rstrip("* ").upper()]
                words, width = words + data, per_line  # a line may hold more than eight fields: they go on
                continue
            if longer:
                raise MeshError(
                    f"{where}, card {text.split(',')[0]}",
                    found=f"{len(data)} fields in one line",
                    expected=f"at most {per_line}, and the name of a continuation",
                    remedy="Continue the card on another line",
                )
            if len(data) > per_line and (not data[per_line] or CONTINUED.fullmatch(data[per_line])):
                data = data[:per_line]
            elif data and number + 1 < len(parts) and CONTINUED.fullmatch(data[-1]):
                data = data[:-1]
        else:
            head = text[:8]
            large = "*" in head
            size, per_line = (16, 4) if large else (8, 8)
            data = [text[k : k + size].strip() for k in range(8, min(len(text), 72), size)]
        if number == 0:
            words = [text.split(",")[0][:8].strip().rstrip("* ").upper()]
        else:
            words += [""] * (-(len(words) - 1) % width)
        width = per_line
        words += data
    return words


def _table(name: str, found: array, lines: Lines) -> FieldTable:
    """Return cards as columns; those in fields of 8 are cut all together, some thousands at a time."""
    columns: dict[int, np.ndarray] = {}
    for begin in range(0, len(found), CHUNK):
        rows = found[begin : begin + CHUNK]
        plain, text = [], []
        other: dict[int, list[bytes]] = {}
        for row, k in enumerate(rows):
            parts = lines.card(k)
            if any(b"," in p or b"*" in p[:8] for p in parts):
                other[row] = _cut(name, parts, lines.where(k))
                continue
            plain.append(row)
            text.append(b"".join([parts[0][:72].ljust(72), *(p[8:72].ljust(64) for p in parts[1:3])]).ljust(200)[:200])
        raw = np.frombuffer(b"".join(text), "S8").reshape(len(plain), 25)[:, :FIELDS]
        # between commas a field is as long as it likes: one that is cut loses its exponent
        longest = max((len(word) for words in other.values() for word in words), default=0)
        chunk = np.zeros((len(rows), FIELDS), f"S{max(longest, 16)}" if other else "S8")
        chunk[plain] = np.char.strip(raw)
        for row, words in other.items():
            chunk[row] = words
        for i in np.flatnonzero((chunk != b"").any(axis=0)).tolist():
            if i and (i not in columns or columns[i].itemsize < chunk.itemsize):
                grown = np.zeros(len(found), chunk.dtype)
                grown[:begin] = columns.get(i, grown)[:begin]
                columns[i] = grown
            if i:
                columns[i][begin : begin + len(rows)] = chunk[:, i]
    return FieldTable(name, columns, np.array(found, np.uint32), lines.places)


def _cut(name: str, parts: list[bytes], where: str) -> list[bytes]:
    """Return the fields of one card of a table."""
    words = _words(parts, where)
    long = next((word for word in words if len(word) > LONGEST), None)
    if long is not None:
        raise MeshError(
            f"{where}, card {name} {words[1][:LONGEST]}",
            found=f"a field of {len(long)} characters, '{long[:20]}...'",
            expected=f"at most {LONGEST}",
            remedy="Write the deck again",
        )
    if len(words) > FIELDS and any(words[FIELDS:]):
        raise MeshError(
            f"{where}, card {name} {words[1]}",
            found=f"{len(words)} fields",
            expected=f"at most {FIELDS}",
            remedy="Write the deck again",
        )
    return [word.encode("latin-1") for word in (words + [""] * FIELDS)[:FIELDS]]


def _real(word: str) -> float:
    """Return 1.0, 1.0E+3, 1.0D+3, 1.0+3 or 1.0 +3 as a number."""
    text = APART.sub(r"\1\2", word.strip()).upper().replace("D", "E")
    if not text or text[-1] in "NFY" or "_" in text:
        raise ValueError(word)
    if "E" not in text:
        text = re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", text)
    return float(text)
