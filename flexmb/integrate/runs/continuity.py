"""Continuity across an event: positions do not jump, and states are known, whatever the event changes."""

from __future__ import annotations

import numpy as np

from flexmb.errors import ModelError

__all__ = ["require_continuity", "require_known_states"]

JUMP = 1e-3
"""Relative to the model's size, or in rad: assembly closes smaller gaps, as in a drawing."""


def require_continuity(event, system, before: dict, after: np.ndarray) -> None:
    """Raise ModelError if the assembly of the next phase has moved a body.

    Parameters
    ----------
    event : Event
    system : System
        Of the next phase.
    before : dict of body name to (q, u)
        State at the event.
    after : (nq,)
        Configuration with which the next phase begins.
    """
    jumps = [(0.0, 0.0, 0.0, "")]
    for body, size in zip(system.model.bodies, system.lengths.bodies, strict=True):
        if body.name in before and body.n_velocities:
            old, new = before[body.name][0], after[system.body_slices[body.name][0]]
            change, turn = new - old, 0.0
            if body.has_frame:
                # p and -p are one orientation; the arc between Euler parameters is half the angle
                chord = min(float(np.linalg.norm(new[3:7] + sign * old[3:7])) for sign in (-1.0, 1.0))
                turn = 4.0 * float(np.arcsin(0.5 * chord))
                change = np.delete(change, slice(3, 7))
            length = float(np.abs(change).max())
            jumps.append((max(length / size, turn), length, turn, body.title))
    largest = max(jumps)
    if largest[0] > JUMP:
        _, length, turn, title = largest
        raise ModelError(
            event.title,
            found=f"what it changes moves {title} by {length:.3g} m and {turn:.3g} rad at once",
            expected="a mechanism that continues from its present position",
            remedy="Let a drive or a length that is changed begin with the value that it has at the event: a ramp "
            "from there, or a table over time",
        )


def require_known_states(event, before, after) -> None:
    """Raise ModelError if a system `after` an event has states or held values that it had not `before`."""
    known = {*before.state_slices, *(hold.title for hold in before.holds)}
    for owner in (*after.state_slices, *(hold.title for hold in after.holds)):
        if owner not in known:
            raise ModelError(
                owner,
                found=f"states that are not known after {event.title}: the part that gave its name is gone",
                expected="blocks with the same names before and after",
                remedy="Give the block a name",
            )
