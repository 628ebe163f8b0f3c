"""The keywords of an Abaqus or CalculiX deck as blocks: INCLUDE files in their places, continued lines joined."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from flexmb.errors import MeshError
from flexmb.fem.deck.abaqus_keywords import taken
from flexmb.fem.deck.files import HUGE, beside, deck_bytes
from flexmb.files import resolved

__all__ = ["Block", "is_number", "read_blocks"]


@dataclass(slots=True, eq=False)
class Block:
    """One keyword with its parameters (names in capitals without spaces) and its data lines."""

    name: str
    parameters: dict[str, str]
    where: str
    lines: list[str] = field(default_factory=list)

    def rows(self) -> list[list[str]]:
        """Return the words of the data lines."""
        return [[word.strip() for word in line.split(",")] for line in self.lines]

    def words(self) -> list[str]:
        """Return the words of all data lines in one list, empty ones at the end of a line left out."""
        out: list[str] = []
        for row in self.rows():
            while row and not row[-1]:
                row.pop()
            out += row
        return out

    def reals(self, row: list[str], count: int | None = None, default: float | None = None) -> list[float]:
        """Return the words of a row as finite numbers; MeshError if one is none."""
        out = []
        for word in row if count is None else (row + [""] * count)[:count]:
            if not word and default is not None:
                out.append(default)
                continue
            try:
                value = float(word.upper().replace("D", "E"))
            except ValueError:
                raise self.wrong(f"'{word}' among '{', '.join(row)[:60]}'", "numbers") from None
            if not abs(value) < HUGE:
                raise self.wrong(f"'{word}'", f"numbers below {HUGE:g}")
            out.append(value)
        return out

    def integers(self, row: list[str], least: int = 0) -> list[int]:
        """Return the words of a row as integers; MeshError if one is none, or if there are fewer than `least`."""
        words = [word for word in row if word]
        if len(words) < least or not all(is_number(word.lstrip("+-")) for word in words):
            raise self.wrong(f"'{', '.join(row)[:60]}'", "integers")
        try:
            return [int(word) for word in words]
        except ValueError:  # two signs
            raise self.wrong(f"'{', '.join(row)[:60]}'", "integers") from None

    def need(self, parameter: str) -> str:
        """Return a parameter; MeshError if the keyword has none of that name."""
        if not self.parameters.get(parameter):
            raise self.wrong(f"no {parameter}=", f"{parameter}= with a name")
        return self.parameters[parameter]

    def wrong(self, found: str, expected: str, remedy: str = "Correct the deck, or write it again") -> MeshError:
        """Return an error about this keyword."""
        return MeshError(f"{self.where}, *{self.name}", found=found, expected=expected, remedy=remedy)


def is_number(word: str) -> bool:
    """Is a word a whole number of 64 bits without sign?"""
    return word.isascii() and word.isdigit() and len(word) < 19


def read_blocks(path: Path) -> list[Block]:
    """Return the keywords of a deck in order."""
    blocks: list[Block] = []
    _read(path, path.parent, blocks, (), [])
    if not blocks:
        raise MeshError(
            f"Deck '{path}'",
            found="no keyword (a line that begins with *)",
            expected="an Abaqus or CalculiX deck",
            remedy="Check whether the file is one",
        )
    return blocks


def _read(path: Path, main: Path, blocks: list[Block], above: tuple[Path, ...], read: list[Path]) -> None:
    data = deck_bytes(path, above, read)
    lines = data.decode("utf-8", "replace").splitlines()
    k = 0
    while k < len(lines):
        line, k = lines[k], k + 1
        text = line.strip()
        if not text or text.startswith("**"):
            continue
        if not text.startswith("*"):
            if blocks:
                blocks[-1].lines.append(text)
            elif not above:
                raise MeshError(
                    f"{path}:{k}",
                    found=f"'{text[:60]}' before the first keyword",
                    expected="a keyword: * and its name",
                    remedy="Check whether the file is an Abaqus or CalculiX deck",
                )
            continue
        start = k
        while text.endswith(",") and k < len(lines) and not lines[k].strip().startswith("*"):
            text, k = text + lines[k].strip(), k + 1
        head, *rest = text[1:].split(",")
        parameters = {}
        for word in rest:
            name, _, value = word.partition("=")
            parameters["".join(name.split()).upper()] = value.strip().strip('"')
        block = Block(" ".join(head.split()).upper(), parameters, f"{path}:{start}")
        if block.name != "INCLUDE":
            blocks.append(block)
        if block.name == "INCLUDE" or ("INPUT" in parameters and taken(block.name)):  # data lines in a file
            _include(block, path, main, blocks, above, read)


def _include(
    block: Block, path: Path, main: Path, blocks: list[Block], above: tuple[Path, ...], read: list[Path]
) -> None:
    name = block.need("INPUT").replace("\\", "/")
    if (found := beside(name, main, path)) is not None:
        _read(found, main, blocks, (*above, resolved(path)), read)
        return
    raise block.wrong(f"INPUT={name[:120]}: no such file", f"a file beside '{main}'", "Put the included file there")
