"""Forces that follow accelerations: they have a share in the mass matrix, which then is not symmetric."""

from __future__ import annotations

from flexmb.errors import CompileError

__all__ = ["refuse_accelerations"]


def refuse_accelerations(system, asker: str) -> None:
    """Raise CompileError if forces follow accelerations, of which the asker knows nothing."""
    if system.implicit:
        raise CompileError(
            asker,
            found="signals that follow accelerations",
            expected="forces of place, motion and time: the mass matrix of the bodies alone",
            remedy="Use GeneralizedAlpha, IDA or Explicit with Augmented, or sample the acceleration (Sampled)",
        )
