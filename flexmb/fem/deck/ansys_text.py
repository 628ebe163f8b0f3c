"""The text of an Ansys archive (.cdb, CDWRITE): blocks of nodes and elements as arrays, the other commands as words.

Formats: Mechanical APDL Command Reference, NBLOCK, EBLOCK, ETBLOCK, RLBLOCK, CMBLOCK, SECBLOCK, and the ``R5.0`` forms
that CDWRITE writes. Blocks are cut into columns all at once by the Fortran format on their second line.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.files import HUGE, deck_bytes

__all__ = ["Archive", "Command", "read_archive"]

FORMAT = re.compile(rb"^\s*\(\s*(\d+)\s*i\s*(\d+)\s*(?:,\s*(\d+)\s*[eg]\s*(\d+)\.\d+(?:e\d+)?)?.*\)\s*$", re.IGNORECASE)
MIXED = re.compile(rb"^\s*\(\s*(\d+)i(\d+)\s*,\s*(\d+)i(\d+)\s*,\s*(\d+)[eg](\d+)\.\d+(?:e\d+)?.*\)\s*$", re.IGNORECASE)
"""Integers of two widths, as Workbench writes them."""
MOST = 10**7
"""More entries than a count in front of a block says."""
HEADER = 11
"""Fields before the nodes: material, type, real, section, system, death, solid model, shape, count, -, number."""


@dataclass(frozen=True, eq=False)
class Command:
    """One command: its name in capitals, the words behind it, and where it stands."""

    name: str
    words: tuple[str, ...]
    where: str

    def text(self, i: int) -> str:
        """Return word i in capitals, blank if there are fewer."""
        return self.words[i].upper() if i < len(self.words) else ""

    def integer(self, i: int, default: int | None = None) -> int:
        """Return word i as an integer; MeshError if it is none."""
        value = self.real(i, None if default is None else float(default))
        if value != int(value):
            raise self.wrong(f"'{self.words[i]}' in field {i + 2}", "an integer")
        return int(value)

    def real(self, i: int, default: float | None = None) -> float:
        """Return word i as a finite number; MeshError if it is none, or blank without a default."""
        word = self.text(i)
        if not word and default is not None:
            return default
        try:
            value = float(word.replace("D", "E"))
        except ValueError:
            raise self.wrong(f"'{word}' in field {i + 2}", "a number") from None
        if not abs(value) < HUGE:
            raise self.wrong(f"'{word}' in field {i + 2}", f"a number below {HUGE:g}")
        return value

    def wrong(self, found: str, expected: str, remedy: str = "Correct it, or write the archive again") -> MeshError:
        """Return an error about this command."""
        return MeshError(f"{self.where}, {self.name}", found=found, expected=expected, remedy=remedy)


@dataclass(eq=False)
class Archive:
    """An archive: nodes, elements, types, real constants and components as arrays; the other commands in order.

    labels (n,), points (n, 3), angles (n, 3) in degrees: THXY, THYZ, THZX of the nodal systems. Elements: head (ne, 11)
    as in EBLOCK, nodes (ne, 20) by number with zeros behind. types: number to name or number and key options.
    """

    labels: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    points: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    angles: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    head: np.ndarray = field(default_factory=lambda: np.zeros((0, HEADER), np.int64))
    nodes: np.ndarray = field(default_factory=lambda: np.zeros((0, 20), np.int64))
    types: dict[int, str] = field(default_factory=dict)
    options: dict[tuple[int, int], int] = field(default_factory=dict)
    reals: dict[int, list[float]] = field(default_factory=dict)
    components: dict[str, tuple[str, np.ndarray]] = field(default_factory=dict)
    commands: list[Command] = field(default_factory=list)
    layers: dict[str, list[Command]] = field(default_factory=dict)
    """Lines of a SECBLOCK by the place of its command."""


class Lines:
    """The lines of a file and the one that is read next."""

    def __init__(self, path: Path):
        self.path = path
        self.text = deck_bytes(path, (), []).splitlines()
        self.at = 0

    def where(self, at: int | None = None) -> str:
        return f"{self.path}:{(self.at if at is None else at) + 1}"

    def wrong(self, what: str, found: str, expected: str) -> MeshError:
        return MeshError(
            f"{self.where()}, {what}",
            found=found,
            expected=expected,
            remedy="Write the archive again: CDWRITE, DB, name, cdb, , , , BLOCKED",
        )

    def layout(self, what: str) -> tuple[int, int, int, int]:
        """Read a format line such as (3i9,6e21.13e3): counts and widths of integers and reals."""
        line = self.text[self.at] if self.at < len(self.text) else b""
        match = FORMAT.match(line)
        if match is None:
            raise self.wrong(what, f"'{line[:60].decode('latin-1')}'", "a format such as (3i9,6e21.13e3)")
        self.at += 1
        integers, width, reals, wide = (int(word or 0) for word in match.groups())
        if not 1 <= integers <= 40 or not 1 <= width <= 30 or reals > 40 or wide > 40:
            raise self.wrong(what, f"the format {line[:60].decode('latin-1')}", "1 to 40 fields of 1 to 30 characters")
        return integers, width, reals, wide

    def node_layout(self) -> tuple[int, int, int, int]:
        """Read the format of NBLOCK, (3i9,6e21.13e3) or (1i7,2i9,6e21.13): widths of the number and of all integers,
        count and width of the reals."""
        line = self.text[self.at] if self.at < len(self.text) else b""
        mixed = MIXED.match(line)
        if mixed is None:
            integers, width, reals, wide = self.layout("NBLOCK")
            return width, integers * width, reals, wide
        self.at += 1
        one, first, more, second, reals, wide = (int(word) for word in mixed.groups())
        if not (1 <= one <= 40 and 1 <= more <= 40) or max(first, second, reals, wide) > 40 or first < 1:
            raise self.wrong("NBLOCK", f"the format {line[:60].decode('latin-1')}", "fields of 1 to 40 characters")
        return first, one * first + more * second, reals, wide

    def data(self, most: int | None = None) -> list[bytes]:
        """Return the lines up to the next command or the line -1, which is passed over; at most some lines."""
        start = self.at
        while self.at < len(self.text) and (most is None or self.at - start < most):
            line = self.text[self.at].lstrip()
            if line[:2] == b"-1" and not line[2:].strip(b" \t,"):
                rows = self.text[start : self.at]
                self.at += 1
                return rows
            if line[:1] and not (line[:1].isdigit() or line[:1] in b"+-."):
                break
            self.at += 1
        return self.text[start : self.at]


def read_archive(path: Path) -> Archive:
    """Return the content of an archive; MeshError with file and line for whatever cannot be read."""
    lines, out = Lines(path), Archive()
    makers = {"NBLOCK": _nodes, "EBLOCK": _elements, "ETBLOCK": _types, "RLBLOCK": _reals, "CMBLOCK": _component}
    while lines.at < len(lines.text):
        text = lines.text[lines.at].split(b"!")[0].decode("latin-1").strip()
        where = lines.where()
        lines.at += 1
        if not text or text[:1] in "/*-(" or "=" in text.split(",")[0]:
            continue
        head, *words = [word.strip() for word in text.split(",")]
        command = Command(head.upper(), tuple(words), where)
        if command.name in makers:
            makers[command.name](command, lines, out)
        elif command.name.startswith("SECBLO"):  # names count by their first letters
            out.commands.append(command)
            count = command.integer(0, 0) if command.text(0).isdecimal() else 0
            rows = lines.data(min(count, MOST))
            out.layers[where] = [
                Command("SECBLOCK", tuple(w.strip() for w in row.decode("latin-1").split(",")), where) for row in rows
            ]
        elif command.name == "ET":
            out.types[command.integer(0)] = command.text(1)
            for k in range(2, 8):
                if command.text(k):
                    out.options[command.integer(0), k - 1] = command.integer(k)
        elif command.name in ("KEYOP", "KEYOPT"):
            if command.text(0) and command.text(1) and command.text(1).isdecimal():
                out.options[command.integer(0), command.integer(1)] = command.integer(2, 0)
        else:
            out.commands.append(command)
    if not len(out.labels):
        raise MeshError(
            f"Deck '{path}'",
            found="no block of nodes (NBLOCK)",
            expected="an archive of Mechanical APDL",
            remedy="Write it with CDWRITE, DB, name, cdb, , , , BLOCKED",
        )
    _sorted(out, path)
    return out


def _columns(rows: list[bytes], count: int, width: int, lines: Lines, what: str, kind) -> np.ndarray:
    """Return fields (n, count) of lines of one width as numbers; blanks are zero."""
    size = count * width
    for at, row in enumerate(rows):
        if len(row) > size and row[size:].strip():
            lines.at -= len(rows) - at
            raise lines.wrong(what, f"{len(row)} characters in a line", f"{count} fields of {width}")
    raw = np.frombuffer(b"".join(row[:size].ljust(size) for row in rows), f"S{width}").reshape(len(rows), count)
    raw = np.char.strip(raw)
    raw = np.where(raw == b"", b"0", raw)
    try:
        return raw.astype(kind)
    except (ValueError, OverflowError):
        pass
    for at, words in enumerate(raw):
        for word in words:
            try:
                kind(word.replace(b"D", b"E"))
            except (ValueError, OverflowError):
                lines.at -= len(rows) - at
                shown = word.decode("latin-1")
                raise lines.wrong(what, f"'{shown}'", "a number in fixed columns") from None
    return np.char.replace(raw, b"D", b"E").astype(kind)


def _nodes(command: Command, lines: Lines, out: Archive) -> None:
    """NBLOCK: number, with SOLID two references of the solid model, then x, y, z and, with SOLID, three angles."""
    width, whole, reals, wide = lines.node_layout()
    rows = [row for row in lines.data() if row.strip()]
    left, right = [row[:width] for row in rows], [row[whole:] for row in rows]
    if not rows or reals < 3:
        raise lines.wrong("NBLOCK", f"{len(rows)} nodes of {reals} coordinates", "nodes with x, y, z")
    told = command.integer(3, 0)
    if told and told != len(rows):
        raise lines.wrong("NBLOCK", f"{len(rows)} nodes where the block says {told}", "as many as it says")
    labels = _columns(left, 1, width, lines, "NBLOCK", np.int64)[:, 0]
    values = _columns(right, reals, wide, lines, "NBLOCK", np.float64)
    values = np.hstack([values, np.zeros((len(rows), max(0, 6 - reals)))])
    if not (np.abs(values) < HUGE).all():
        raise lines.wrong("NBLOCK", "a coordinate that is not finite", f"numbers below {HUGE:g}")
    out.labels = np.concatenate([out.labels, labels])
    out.points, out.angles = np.vstack([out.points, values[:, :3]]), np.vstack([out.angles, values[:, 3:6]])


def _elements(command: Command, lines: Lines, out: Archive) -> None:
    """EBLOCK: eleven fields, then the nodes, over two lines if more than eight; without SOLID five, then the nodes."""
    integers, width, _, _ = lines.layout("EBLOCK")
    rows = [row for row in lines.data() if row.strip()]
    if not rows:
        return
    values = _columns(rows, integers, width, lines, "EBLOCK", np.int64)
    if command.text(1) != "SOLID":
        head = np.zeros((len(values), HEADER), np.int64)
        head[:, [10, 1, 2, 0, 4]] = values[:, :5]
        nodes = values[:, 5:]
        head[:, 8] = (nodes > 0).sum(axis=1)
    else:
        if integers < HEADER + 1:
            raise lines.wrong("EBLOCK", f"{integers} fields a line", f"{HEADER} and the nodes")
        first, per_line = [], integers - HEADER
        counts, at = values[:, 8].tolist(), 0
        while at < len(values):
            first.append(at)
            if not 0 < counts[at] <= 20:
                lines.at -= len(rows) - at
                raise lines.wrong("EBLOCK", f"an element of {counts[at]} nodes", "1 to 20 nodes")
            at += 1 + max(0, -(-(counts[at] - per_line) // integers))
        if at > len(values):
            raise lines.wrong("EBLOCK", "an element without its second line", "all nodes of the last element")
        start = np.array(first)
        head = values[start, :HEADER]
        nodes = values[start, HEADER:]
        long = head[:, 8] > per_line
        more = np.zeros((len(start), integers), np.int64)
        more[long] = values[start[long] + 1]
        nodes = np.hstack([nodes, more])
        nodes[np.arange(nodes.shape[1]) >= head[:, 8:9]] = 0
    nodes = np.hstack([nodes, np.zeros((len(nodes), 20), np.int64)])[:, :20]
    told = command.integer(3, 0)
    if told and told != len(head):
        raise lines.wrong("EBLOCK", f"{len(head)} elements where the block says {told}", "as many as it says")
    out.head, out.nodes = np.vstack([out.head, head]), np.vstack([out.nodes, nodes])


def _types(command: Command, lines: Lines, out: Archive) -> None:
    _, width, _, _ = lines.layout("ETBLOCK")
    rows = [row for row in lines.data() if row.strip()]
    for row in rows:
        words = [row[k : k + width].strip() for k in range(0, len(row), width)]
        try:
            numbers = [int(word or 0) for word in words]
        except ValueError:
            raise lines.wrong("ETBLOCK", f"'{row[:60].decode('latin-1')}'", "integers") from None
        if len(numbers) < 2:
            raise lines.wrong("ETBLOCK", f"'{row[:60].decode('latin-1')}'", "a type and its element")
        out.types[numbers[0]] = str(numbers[1])
        out.options.update({(numbers[0], k): value for k, value in enumerate(numbers[2:], 1) if value})


def _reals(command: Command, lines: Lines, out: Archive) -> None:
    """RLBLOCK: per set its number, the count of its constants and six of them, then seven a line."""
    integers, width, reals, wide = lines.layout("RLBLOCK")
    more, wide_more = _second(lines)
    for _ in range(min(command.integer(0, 0), MOST)):
        row = lines.text[lines.at] if lines.at < len(lines.text) else b""
        number, count = _columns([row[: integers * width]], integers, width, lines, "RLBLOCK", np.int64)[0][:2]
        values = list(_columns([row[integers * width :]], reals, wide, lines, "RLBLOCK", np.float64)[0])
        lines.at += 1
        while len(values) < count and lines.at < len(lines.text) and count < MOST:
            values += list(_columns([lines.text[lines.at]], more, wide_more, lines, "RLBLOCK", np.float64)[0])
            lines.at += 1
        if number < 1:
            raise lines.wrong("RLBLOCK", f"the set {number}", "a positive number")
        out.reals[int(number)] = [float(x) for x in values[:count]]


def _second(lines: Lines) -> tuple[int, int]:
    line = lines.text[lines.at] if lines.at < len(lines.text) else b""
    match = re.match(rb"^\s*\(\s*(\d+)\s*[eg]\s*(\d+)\.\d+.*\)\s*$", line, re.IGNORECASE)
    if match is None or not 1 <= int(match[1]) <= 40 or not 1 <= int(match[2]) <= 40:
        raise lines.wrong("RLBLOCK", f"'{line[:60].decode('latin-1')}'", "a format such as (7g16.9)")
    lines.at += 1
    return int(match[1]), int(match[2])


def _component(command: Command, lines: Lines, out: Archive) -> None:
    """CMBLOCK: numbers, a negative one closes the range from the number before it."""
    kind, count = command.text(1), command.integer(2, 0)
    integers, width, _, _ = lines.layout("CMBLOCK")
    rows: list[int] = []
    while len(rows) < count and lines.at < len(lines.text):
        row = lines.text[lines.at]
        rows += _columns([row], integers, width, lines, "CMBLOCK", np.int64)[0][: count - len(rows)].tolist()
        lines.at += 1
    found: list[int] = []
    for number in rows:
        if number < 0 and (not found or -number < found[-1] or -number - found[-1] > MOST):
            raise command.wrong(f"the range to {-number}", "a range from the number before it")
        found += range(found[-1] + 1, -number + 1) if number < 0 else [number]
    if kind.startswith(("NODE", "ELEM")):
        out.components[command.words[0]] = (kind[:4], np.array(found, np.int64))


def _sorted(out: Archive, path: Path) -> None:
    """Bring the nodes into the order of their numbers; refuse numbers below one and those given twice."""
    order = np.argsort(out.labels, kind="stable")
    out.labels, out.points, out.angles = out.labels[order], out.points[order], out.angles[order]
    same = np.flatnonzero(np.diff(out.labels) == 0)
    if out.labels[0] < 1 or len(same):
        number = int(out.labels[same[0]]) if len(same) else int(out.labels[0])
        raise MeshError(
            f"Deck '{path}', NBLOCK",
            found=f"the node {number}" + (" a second time" if len(same) else ""),
            expected="positive numbers, each once",
            remedy="Write the archive again",
        )
