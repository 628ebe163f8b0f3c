"""The numbers of the recursion between its passes: one row per body, and the blocks of bodies with modes."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.math.structures import ArrayOf, FloatRows, Floats, Integers, structure

__all__ = ["BODY_STATE", "Store", "modal_views", "new_store"]

BODY_STATE = np.dtype(
    [
        ("R", float, (3, 3)),  # axes of the body
        ("lever", float, 3),  # m, C from the body's origin
        ("step", float, 3),  # m, C from the parent's
        ("P", float, (6, 6)),  # articulated inertia, modes eliminated
        ("load", float, 6),  # p
        ("rate", float, 6),  # of the twist of C, V
        ("bias", float, 6),  # velocity terms of the joint, c
        ("drop", float, 6),  # what is transmitted of their inertia
        ("free", np.int64),  # number of free motions, nf
        ("way", float, (6, 6)),  # directions: of the joint's equations, then the nf free motions N
        ("triangle", float, (6, 6)),  # factor of the equations in their directions, T
        ("along", float, 6),  # N^T p, by free motions
        ("U", float, (6, 6)),  # by free motions: P N D
        ("gain", float, (6, 6)),  # by free motions: D N^T P
        ("D", float, 36),  # (nf, nf), flat: (N^T P N)^-1
    ],
    align=True,
)
"""The numbers of a body at a state. Vectors are (linear, angular) at its own marker C, in W; names as in the theory."""


@structure
class Store(NamedTuple):
    """What the passes of the recursion leave for each other."""

    rows: Annotated[np.ndarray, ArrayOf(BODY_STATE)]
    """(nb,)"""
    plain: Floats
    """inverse mass matrices of bodies without a frame"""
    modal: Floats
    """see `modal_views`"""
    pivots: Integers
    """(sum of modes,) of the modal block"""
    eta: Floats
    """(sum of modes,) modal accelerations at V = 0"""
    parent: Floats
    """modal columns of what the parent's modes do at C, without and with stiffening, (6, m of the parent)"""
    failed: Integers
    """(2,) place of the body where the recursion ended, or -1; 1: singular inertia, 2: dependent equations"""
    scratch: FloatRows
    """(8, n)"""


def new_store(tables) -> Store:
    """Return storage for a tree."""

    def flat(size, kind=float):
        return np.zeros(max(1, int(size)), kind)

    return Store(
        rows=np.zeros(len(tables.iu), BODY_STATE),
        plain=flat(tables.i_plain[-1]),
        modal=flat(tables.i_modal[-1]),
        pivots=flat(tables.i_eta[-1], np.int64),
        eta=flat(tables.i_eta[-1]),
        parent=flat(tables.i_parent[-1]),
        failed=np.full(2, -1, np.int64),
        scratch=np.zeros((8, max(36, int(np.max(tables.nu, initial=0))))),
    )


@kernel
def modal_views(modal, at, m):
    """Return views: modal block (m, m), couplings (6, m), (m, 6), modal columns of J_C (6, m), and with stiffening."""
    b = at + m * m
    return (
        modal[at:b].reshape((m, m)),
        modal[b : b + 6 * m].reshape((6, m)),
        modal[b + 6 * m : b + 12 * m].reshape((m, 6)),
        modal[b + 12 * m : b + 18 * m].reshape((6, m)),
        modal[b + 18 * m : b + 24 * m].reshape((6, m)),
    )
