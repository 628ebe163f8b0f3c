"""First-order states of forces and blocks, x' = f(t, x, what is measured), in the layout of the bodies' coordinates.

A state is a velocity: it stands among the velocities u, its rate among the accelerations, and its time integral, which
nothing reads, among the coordinates. A group of states has the equation of motion of a body of unit mass,

    x' - f(t, x, q, u) = 0                                                            eq. (state-residual)

so every integrator, formulation and analysis sees an unknown like any other, at its own order: for generalized-alpha
this is a scheme for first-order equations as Brüls & Golinval 2006 have it. The group has markers whose twists are the
states, six each. What acts on such a marker is f, and the stiffness and damping between it and other markers are the
derivatives of f, and of forces by states.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.math.tables import row_kernel
from flexmb.model.table import Table

__all__ = ["EACH", "STATES", "StateGroup", "place_of_state"]

EACH = 6
"""States of a marker."""

ROW = np.dtype(
    [
        ("iu", np.int64),  # first state among the velocities
        ("marker", np.int64),  # first marker
        ("n", np.int64),  # number of states
        ("at", np.int64),  # first of work.rows that belongs to them
    ],
    align=True,
)


@row_kernel
def place(raw, data, state, work):
    """The twists of the markers are the states."""
    rows = raw.view(ROW)
    for m in range(rows.shape[0]):
        row = rows[m]
        for k in range(row.n):
            marker = work.markers[row.marker + k // 6]
            i, x = k % 6, state.u[row.iu + k]
            work.J[marker.iJ + i * row.n + k] = 1.0
            if i < 3:
                marker.v[i] = x
                marker.R[i, i] = 1.0
            else:
                marker.w[i - 3] = x


@row_kernel
def inertia(raw, data, state, work):
    """x' - f, with f the wrenches of the markers."""
    rows = raw.view(ROW)
    for m in range(rows.shape[0]):
        row = rows[m]
        for k in range(row.n):
            f = work.markers[row.marker + k // 6].wrench[k % 6]
            work.residual[row.iu + k] += state.a[row.iu + k] - f
            if work.weights[0].wanted == 1:
                work.S[work.rows[row.at + k] + k] += work.weights[0].mass


@row_kernel
def energy(raw, data, state, work):
    """States have no energy of their own."""


STATES = Table("States", ROW, {"place": place, "inertia": inertia, "energy": energy})


def place_of_state(groups: Mapping[str, StateGroup], of: str, state: str | None, asker: str) -> tuple[str, int]:
    """Return the owner of the state of a part, and its number there; ModelError with what there is otherwise.

    Parameters
    ----------
    groups : mapping of owner to StateGroup
    of : str
        Name of the force or block.
    state : str or None
        None: the only one.
    asker : str
        For messages.
    """
    owners = {owner.partition(" ")[2].strip("'"): owner for owner in groups}
    if of not in owners:
        raise ModelError(
            asker,
            found=f"'{of}' has no states",
            expected=f"One of: {', '.join(owners) or 'no part of the model has states'}",
            remedy=did_you_mean(of, owners) or "Name a force or a block that has states",
        )
    names = groups[owners[of]].names
    if state is None and len(names) == 1:
        return owners[of], 0
    if state not in names:
        raise ModelError(
            asker,
            found=f"state = {state!r} of '{of}'",
            expected=f"One of: {', '.join(names)}",
            remedy=did_you_mean(str(state), names) or "Name one of its states",
        )
    return owners[of], names.index(state)


@dataclass(frozen=True)
class StateGroup:
    """The states of a part.

    Parameters
    ----------
    title : str
        Of the part, for messages.
    names : tuple of str
    start : (n,)
    size : (n,)
        Values up to which errors are absolute.
    marker : int
        The first marker; each has six states.
    """

    title: str
    names: tuple[str, ...]
    start: tuple[float, ...]
    size: tuple[float, ...]
    marker: int

    @classmethod
    def of(cls, title: str, states: Mapping[str, float], sizes: Mapping[str, float], marker: int) -> StateGroup:
        """Return the group of states with their starting values by name."""
        size = tuple(float(sizes.get(name, 1.0)) for name in states)
        return cls(title, tuple(states), tuple(float(x) for x in states.values()), size, marker)

    @property
    def markers(self) -> int:
        """Number of markers."""
        return -(-len(self.names) // EACH)
