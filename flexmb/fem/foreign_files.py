"""Files of other programs, which may hold anything: a parser's failure becomes an error that names the file."""

from __future__ import annotations

import string
import warnings
from collections.abc import Collection, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import numpy as np
from scipy import sparse

from flexmb.errors import FlexmbError, MeshError
from flexmb.fem.foreign_memory import memory_for
from flexmb.found import no_file_because

__all__ = ["read_market", "require_file", "understood", "understood_matrix", "whole_numbers"]

FULL = (".op2",)
"""Matrices are made full while they are read; their rows are bounded instead."""
_CHARACTERS = (string.digits + "+-.eE \t\r\n").encode()
_FORMATS = (("coordinate", "array"), ("real", "integer", "double"), ("general", "symmetric"))


def require_file(part: str, path: Path, expected: str, remedy: str, suffixes: Collection[str] = ()) -> None:
    """Raise MeshError of the `part` unless a file is at `path`; `suffixes` are of files that may be meant instead."""
    if (found := no_file_because(path, suffixes)) is not None:
        raise MeshError(part, found=found.what, expected=expected, remedy=found.remedy or remedy)


@contextmanager
def understood(part: str, expected: str, remedy: str, path: Path | None = None) -> Iterator[None]:
    """Turn whatever a parser raises inside the ``with`` block into a MeshError of the `part`.

    With the `path` of the file that is read there, its size bounds the memory that may be taken.
    """
    try:
        with nullcontext() if path is None else memory_for(path):
            yield
    except FlexmbError:
        raise
    except (Exception, SystemExit) as error:  # numpy, scipy, meshio raise what they run into; meshio would end us too
        text = " ".join(str(error).split()) or type(error).__name__
        if isinstance(error, KeyError) and str(error.args[0]).isdigit():  # of the table of node numbers
            text = f"a cell names the node {error.args[0]}, which does not exist"
        if isinstance(error, MemoryError):
            text = f"it asks for more memory than there is, or than a file of its size needs; {text}"
        raise MeshError(
            part, found=f"the file cannot be read ({text[:200]})", expected=expected, remedy=remedy
        ) from error


def understood_matrix(path: Path):
    """Return the context in which a matrix file is read: what its reader stumbles over is an error of this file."""
    return understood(
        f"Matrix file '{path}'",
        f"a complete file of the format {path.suffix}",
        "Export the matrices again: the file was cut off, or it is of another kind",
        None if path.suffix.lower() in FULL else path,
    )


def whole_numbers(part: str, what: str, values, lowest: int, highest: int) -> np.ndarray:
    """Return numbers of a file as int64; MeshError unless all are whole and within the bounds."""
    numbers = np.asarray(values)
    if numbers.dtype.kind not in "iuf":
        raise MeshError(part, found=f"{what} that are not numbers", expected="whole numbers", remedy="Export again")
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


def read_market(path: Path) -> sparse.coo_matrix:
    """Return the matrix of a Matrix-Market file (Boisvert, Pozo, Remington: The Matrix Market exchange formats, 1996).

    Read here and not by scipy, whose compiled reader ends the process at a line that lacks its value.
    """
    part = f"Matrix file '{path}'"
    first, _, body = path.read_bytes().partition(b"\n")
    words = first.decode("ascii", "replace").lower().split()
    if len(words) != 5 or any(word not in known for word, known in zip(words[2:], _FORMATS)):
        raise MeshError(
            part,
            found=f"the header '{' '.join(words)[:80]}'",
            expected="%%MatrixMarket matrix, coordinate or array, real, general or symmetric",
            remedy="Export the real matrix with its values",
        )
    body = body.lstrip()
    while body.startswith(b"%"):
        body = body.partition(b"\n")[2].lstrip()
    head, _, rest = body.partition(b"\n")
    sizes = [int(word) if word.isdigit() else -1 for word in head.split()]
    dense, symmetric = words[2] == "array", words[4] == "symmetric"
    if len(sizes) != (2 if dense else 3) or min(sizes) < 1 or (symmetric and sizes[0] != sizes[1]):
        raise _market_error(part, f"the sizes '{head.decode('ascii', 'replace')[:60]}'", "rows, columns and entries")
    rows, columns = sizes[:2]
    count = (rows * (rows + 1) // 2 if symmetric else rows * columns) if dense else 3 * sizes[2]
    if 2 * count > len(rest) + 1:
        raise _market_error(part, f"{len(rest)} bytes of entries", f"{count} numbers, as the sizes say")
    if not dense and max(rows, columns) > sizes[2]:
        raise _market_error(part, f"{rows} x {columns} with {sizes[2]} entries", "an entry in every row")
    if rest.translate(None, _CHARACTERS):
        strange = rest.translate(None, _CHARACTERS)[:20]
        raise _market_error(part, f"the characters {strange!r} among the numbers", "rows, columns and values")
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # of text that is no number
        numbers = np.fromstring(rest, sep=" ")
    if len(numbers) != count:
        raise _market_error(part, f"{len(numbers)} numbers", f"{count}, as the sizes say")
    if dense:
        j, i = np.triu_indices(rows) if symmetric else np.divmod(np.arange(count), rows)  # column by column
        values = numbers
    else:
        table = numbers.reshape(-1, 3)
        i = whole_numbers(part, "the row", table[:, 0], 1, rows) - 1
        j = whole_numbers(part, "the column", table[:, 1], 1, columns) - 1
        values = table[:, 2]
    if symmetric:
        below = i != j
        i, j, values = (np.concatenate(pair) for pair in ((i, j[below]), (j, i[below]), (values, values[below])))
    return sparse.coo_matrix((values, (i, j)), shape=(rows, columns))


def _market_error(part: str, found: str, expected: str) -> MeshError:
    return MeshError(part, found=found, expected=expected, remedy="The file is cut off or damaged: export it again")
