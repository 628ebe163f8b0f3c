"""Lines of a Nastran deck that repeat the line before: ``=`` copies a field, ``==`` the rest, ``*(x)`` adds x to it.

``=(n)`` or ``=n`` alone repeats the last such line n times, its additions once more each time (MSC Nastran Quick
Reference Guide, "Replication"). A line that begins with the name of the line before may copy fields too.
"""

from __future__ import annotations

import re

__all__ = ["Replication", "replicates"]

TIMES = re.compile(r"=\(?(\d+)\)?")
ADDED = re.compile(r"\*\(?([^()]+)\)?")
INSIDE = re.compile(rb"[, ]==?[ ]*(,|$|[ ])|[, ]\*\(", re.MULTILINE)
"""A field of a named line that copies or adds."""
MOST = 1_000_000
"""More copies than any deck asks for."""


def replicates(data: bytes) -> bool:
    """Whether lines of a file may stand for others."""
    return b"\n=" in data or INSIDE.search(data) is not None


class Replication:
    """Remembers the last line of fields and what was added to them."""

    def __init__(self) -> None:
        self.line = b""
        self.pattern: list[str] = []

    def read(self, line: bytes) -> list[bytes]:
        """Return the lines that one stands for: itself, or copies of the line before; it as it is where none is."""
        if line[:1] != b"=" or not self.line:
            if line[:1] not in (b"$", b"") and line[:1] != b"=":
                line = self._named(line)
                self.line, self.pattern = line, []
            return [line]
        words = _fields(line)
        times = 1
        if (match := TIMES.fullmatch(words[0])) and len(words) == 1:
            times = int(match[1])
            words = self.pattern
        if not words or times > MOST:
            return [line]
        out = []
        for _ in range(times):
            made = _copied(words, _fields(self.line))
            if made is None:
                return [line]
            self.line = ",".join(made).encode("latin-1")
            out.append(self.line)
        self.pattern = words
        return out

    def _named(self, line: bytes) -> bytes:
        """Return a line with a name of its own, what it copies from the line before of that name written out."""
        if not self.line or INSIDE.search(line) is None:
            return line
        words, before = _fields(line), _fields(self.line)
        copying = any(word in ("=", "==") or word.startswith("*(") for word in words[1:])
        if not copying or not words[0] or words[0].upper() != before[0].upper():
            return line
        made = _copied(words, before)
        return line if made is None else ",".join(made).encode("latin-1")


def _fields(line: bytes) -> list[str]:
    """Return the fields of one line, blanks at its end left away."""
    text = line.decode("latin-1")
    if "," in text:
        words = [word.strip() for word in text.split(",")]
    else:
        size = 16 if "*" in text[:8] and text[:1] != "=" else 8
        words = [text[:8].strip(), *(text[k : k + size].strip() for k in range(8, min(len(text), 72), size))]
    while words and not words[-1]:
        words.pop()
    return words


def _copied(words: list[str], before: list[str]) -> list[str] | None:
    """Return the fields of a copy; None where something is added to a word."""
    out: list[str] = []
    for k, word in enumerate(words):
        old = before[k] if k < len(before) else ""
        if word == "==":
            return out + before[k:]
        if word == "=":
            out.append(old)
        elif k and (match := ADDED.fullmatch(word)):
            try:
                out.append(_sum(old, match[1]))
            except ValueError:
                return None
        else:
            out.append(word)
    return out


def _sum(old: str, more: str) -> str:
    """Return the sum of two fields, whole where both are."""
    try:
        return str(int(old or "0") + int(more))
    except ValueError:
        return repr(float(_exponent(old or "0")) + float(_exponent(more)))


def _exponent(word: str) -> str:
    """Write 1.0+3 and 1.0D+3 with an E."""
    return re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", word.strip().upper().replace("D", "E")).replace("EE", "E")
