"""Equal parts of triangles."""

from __future__ import annotations

from collections.abc import Iterator

__all__ = ["centres_of_parts"]


def centres_of_parts(n: int) -> Iterator[tuple[float, float, float]]:
    """Yield the weights of the corners at the centres of n^2 equal triangles of a triangle."""
    for i in range(n):
        for j in range(n - i):
            yield (n - i - j - 2 / 3) / n, (i + 1 / 3) / n, (j + 1 / 3) / n
            if i + j < n - 1:
                yield (n - i - j - 4 / 3) / n, (i + 2 / 3) / n, (j + 2 / 3) / n
