"""Damaged and hostile variants of a file, seeded: bytes, words and numbers, lines."""

from __future__ import annotations

import random
import re

__all__ = ["NUMBERS", "damaged", "generator", "mutant"]

NUMBERS = (
    *("0", "-0.0", "1", "-1", "1.5", "2", "7", "1000000000", "2147483648", "-2147483649", "9223372036854775808"),
    *("1e-320", "1e-300", "1e300", "1.7e308", "-1.7e308", "1e400", "nan", "inf", "-inf", "9" * 400, "1.0D+03", "0x10"),
    *("", "*****", "1 2", "1,2", "true", "1_000", "١", "3.", ".5", "+3", "- 3"),
)
"""What may stand in place of a number."""

WORDS = (
    *(
        '""',
        '"\\u0000"',
        '"' + "n" * 5000 + '"',
        '"= 1/0"',
        '"= t"',
        '"= x"',
        '"/dev/zero"',
        '"../x"',
        '"."',
        "[]",
        "{}",
    ),
    *("[1, 2]", "[[1, 2], [3]]", "[true]", "true", "{ kind = 1 }", '["a", "b"]', "1979-05-27", '"= ' + "(" * 900 + '"'),
    *("{ ramp = [] }", "{ sum = [] }", '{ kind = "Material" }', "{ a = { a = 1 } }", '"= pi**pi**pi**pi"', "'ü'"),
)
"""What may stand in place of a value of a model file."""

_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+\.?\d*(?:[eEdD][-+]?\d+)?")
_VALUE = re.compile(r'"[^"\n]*"|\[[^\]\n]*\]|(?<![\w.])[-+]?\d[\w.+-]*|true|false')
_NAME = re.compile(r"[A-Za-z_]\w*")


def generator(seed: int, k: int) -> random.Random:
    """Return the random numbers of input `k`."""
    return random.Random(seed * 1_000_003 + k)


def mutant(seed_bytes: bytes, rng: random.Random, *, values: bool = False) -> bytes:
    """Return a file changed in one to four places; `values` also puts values of model files in place of values."""
    data = seed_bytes
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        if rng.random() < (0.85 if values else 0.6):
            data = _text_change(data, rng, values)
        else:
            data = damaged(data, rng)
    return data


def damaged(data: bytes, rng: random.Random) -> bytes:
    """Change, insert, remove or repeat bytes, or cut the file off."""
    if not data:
        return data
    i, way = rng.randrange(len(data)), rng.randrange(9)
    length = min(rng.choice((1, 2, 4, 8, 64, 512)), len(data) - i)
    if way in (0, 1):
        return data[:i] + bytes([data[i] ^ (1 << rng.randrange(8))]) + data[i + 1 :]
    if way == 2:
        return data[:i] + bytes(rng.randrange(256) for _ in range(length)) + data[i + length :]
    if way == 3:
        return data[:i] + bytes([rng.choice((0, 255, 127, 128))]) * length + data[i + length :]
    if way == 4:
        return data[:i]
    if way == 5:
        return data[:i] + data[i + length :]
    if way == 6:
        return data[:i] + data[i : i + length] * rng.choice((2, 3, 50)) + data[i + length :]
    if way == 7:
        number = rng.choice((0, 1, 2**31 - 1, 2**32 - 1, 2**63 - 1, 2**64 - 1, 1 << rng.randrange(64)))
        width = rng.choice((4, 8))
        return data[:i] + (number % (1 << 8 * width)).to_bytes(width, "little") + data[i + width :]
    j = rng.randrange(len(data))
    return data[:i] + data[j : j + length] + data[i + length :]


def _text_change(data: bytes, rng: random.Random, values: bool) -> bytes:
    text = data.decode("latin-1")
    way = rng.randrange(10)
    if way < 4:
        return _replaced(text, _NUMBER, rng, NUMBERS)
    if values and way < 8:
        return _replaced(text, _VALUE, rng, (*WORDS, *NUMBERS, *(m[0] for m in _some(text, _VALUE, rng))))
    if way == 8:
        return _replaced(text, _NAME, rng, tuple(m[0] for m in _some(text, _NAME, rng)) or ("x",))
    lines = text.split("\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    if rng.random() < 0.4:
        del lines[i]
    elif rng.random() < 0.5:
        lines.insert(i, lines[j])
    else:
        lines[i], lines[j] = lines[j], lines[i]
    return "\n".join(lines).encode("latin-1", "replace")


def _some(text: str, pattern: re.Pattern, rng: random.Random) -> list[re.Match]:
    """Return a few matches at random places: finding all of a large file takes too long."""
    found = []
    for _ in range(6):
        match = pattern.search(text, rng.randrange(len(text) + 1))
        found += [match] if match else []
    return found


def _replaced(text: str, pattern: re.Pattern, rng: random.Random, choices: tuple[str, ...]) -> bytes:
    places = _some(text, pattern, rng)
    if not places:
        return damaged(text.encode("latin-1"), rng)
    match = rng.choice(places)
    whole = text[: match.start()] + rng.choice(choices) + text[match.end() :]
    return whole.encode("latin-1", "ignore") if rng.random() < 0.9 else whole.encode("utf-8", "replace")
