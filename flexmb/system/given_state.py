"""States that are given to an analysis: results of another one, checked against the system."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import ModelError

__all__ = ["given_state", "refuse_states"]


def refuse_states(system, asker: str) -> None:
    """Raise ModelError if the system has first-order states, of which the asker knows nothing."""
    if system.states:
        first = system.states[0]
        raise ModelError(
            asker,
            found=f"{first.title} has states of its own: {', '.join(first.names[:4])}",
            expected="forces of positions, velocities and time alone",
            remedy=f"Leave {first.title} out of the model for this analysis, or use simulate, statics or linearize",
        )


def given_state(given: Any, system, asker: str, *, reactions: bool = True):
    """Return the State of an Instant, or of the last sample of a Solution; ModelError unless it fits the system.

    It may come from the same model with other sensors: those have only branches, which stand last in q. Without its
    `reactions`, also from one with other joints between the same bodies.
    """
    given = getattr(given, "final", given)
    if not all(hasattr(given, name) for name in ("t", "q", "u")):
        raise ModelError(
            asker,
            found=f"a state of the class {type(given).__name__}",
            expected="a Solution or an Instant of one",
            remedy="Give the result of statics or simulate, or its .final",
        )
    a, lam = getattr(given, "a", None), getattr(given, "lam", None) if reactions else None
    sizes = [np.size(given.q), np.size(given.u), system.ng if lam is None else np.size(lam)]
    if sizes[0] < system.program.branches or sizes[1:] != [system.nu, system.ng]:
        raise ModelError(
            asker,
            found=f"a state with {sizes[0]} coordinates, {sizes[1]} velocities and {sizes[2]} multipliers",
            expected=f"{system.nq}, {system.nu} and {system.ng}, as in model '{system.model.name}'",
            remedy="Give a state of this model",
        )
    return system.state(given.t, given.q, given.u, a, lam)
