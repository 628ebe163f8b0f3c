"""`NotPositiveDefinite`: what a factorisation tells of a matrix that is singular or indefinite."""

from __future__ import annotations

from flexmb.errors import ReductionError

__all__ = ["NotPositiveDefinite"]


class NotPositiveDefinite(ReductionError):
    """The matrix is singular or indefinite; `freedom` is the row at which the factorisation broke down."""

    def __init__(self, freedom: int, found: str):
        super().__init__(
            "Sparse factorisation",
            found=found,
            expected="a symmetric positive definite matrix",
            remedy="Look for a mechanism or a missing support at this freedom",
        )
        self.freedom = freedom
