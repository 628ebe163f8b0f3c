"""Files of other programs, which may hold anything: what a parser stumbles over is told as an error of that file."""

from __future__ import annotations

import string
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from flexmb.errors import FlexmbError, MeshError

__all__ = ["read_market", "understood", "whole_numbers"]

_CHARACTERS = (string.digits + "+-.eE \t\r\n").encode()
_FORMATS = (("coordinate", "array"), ("real", "integer", "double"), ("general", "symmetric"))


@contextmanager
def understood(part: str, expected: str, remedy: str) -> Iterator[None]:
    """Turn whatever a parser raises inside the ``with`` block into a MeshError of the `part`."""
    try:
        yield
    except FlexmbError:
        raise
    except Exception as error:  # numpy, scipy and meshio raise whatever their parsers run into
        text = " ".join(str(error).split()) or type(error).__name__
        if isinstance(error, KeyError) and str(error.args[0]).isdigit():  # of the table of node numbers
            text = f"a cell names the node {error.args[0]}, which does not exist"
        if isinstance(error, MemoryError):
            text = f"it asks for more memory than there is; {text}"
        raise MeshError(
            part, found=f"the file cannot be read ({text[:200]})", expected=expected, remedy=remedy
        ) from error


def whole_numbers(part: str, what: str, values, lowest: int, highest: int) -> np.ndarray:
    """Return numbers of a file as int64; MeshError unless all are whole and within the bounds."""
    numbers = np.asarray(values)
    if numbers.dtype.kind not in "iuf":
        raise MeshError(part, found=f"{what} that are no numbers", expected="whole numbers", remedy="Export again")
    with np.errstate(invalid="ignore"):
        wrong = ~((numbers >= lowest) & (numbers <= highest) & (numbers == np.floor(numbers)))
    if wrong.any():
        raise MeshError(
            part,
            found=f"{what} {numbers[wrong].flat[0]:.12g}",
            expected=f"whole numbers from {lowest} to {highest}",
            remedy="The file is damaged or of another kind: export it again",
        )
    return numbers.astype(np.int64)


def read_market(path: Path):
    """Return the matrix of a Matrix-Market file, checked as text before scipy's reader, which trusts it, sees it."""
    from scipy.io import mmread

    part = f"Matrix file '{path}'"
    content = path.read_bytes()
    lines = content.split(b"\n", 1)
    words = lines[0].decode("ascii", "replace").lower().split()
    if len(words) != 5 or any(word not in known for word, known in zip(words[2:], _FORMATS)):
        raise MeshError(
            part,
            found=f"the header '{' '.join(words)[:80]}'",
            expected="%%MatrixMarket matrix, coordinate or array, real, general or symmetric",
            remedy="Export the real matrix with its values",
        )
    body = lines[1] if len(lines) > 1 else b""
    while body.lstrip().startswith(b"%"):
        body = body.lstrip().partition(b"\n")[2]
    strange = body.translate(None, _CHARACTERS)
    if strange:
        raise MeshError(
            part,
            found=f"the characters {strange[:20]!r} among the numbers",
            expected="rows, columns and values",
            remedy="The file is damaged: export it again",
        )
    head, _, rest = body.lstrip().partition(b"\n")
    sizes = [int(word) if word.isdigit() else -1 for word in head.split()]
    count = np.prod([float(n) for n in sizes[:2]]) if words[2] == "array" else float(sizes[-1] if sizes else -1)
    least = 2.0 if words[2] == "array" else 6.0  # a value and its end; two numbers before it
    if words[2] == "array" and words[4] == "symmetric":
        least = 1.0
    if len(sizes) != (2 if words[2] == "array" else 3) or min(sizes) < 1 or least * count > len(rest) + 1:
        raise MeshError(
            part,
            found=f"the sizes '{head.decode()[:60]}' before {len(rest)} bytes of entries",
            expected="rows, columns and (coordinate) entries that are there",
            remedy="The file is cut off or damaged: export it again",
        )
    if words[2] == "coordinate" and max(sizes[:2]) > sizes[2]:
        raise MeshError(
            part,
            found=f"{sizes[0]} x {sizes[1]} with {sizes[2]} entries",
            expected="an entry in every row: a stiffness or mass matrix",
            remedy="Export the matrix again, with its diagonal",
        )
    return mmread(path)
