"""The numbers of the recursion between its passes: one row per body, and the blocks of bodies with modes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.math.structures import FloatRows, Floats, Integers

__all__ = [
    "AXES",
    "DROP",
    "FREE",
    "GAIN",
    "INVERSE",
    "LEVER",
    "LOAD",
    "RATE",
    "SPEED",
    "STEP",
    "SUM",
    "TRIANGLE",
    "WAY",
    "P",
    "Store",
    "U",
    "modal_views",
    "new_store",
]

# Places in the row of a body; vectors at its own marker C, in W.
AXES = 0  # (3, 3) axes of the body
LEVER = 9  # (3,) C from the body's origin
STEP = 12  # (3,) C from the parent's
SPEED = 15  # (6,) velocity terms of the joint, c
DROP = 21  # (6,) what is transmitted of their inertia
LOAD = 27  # (6,) load p
RATE = 33  # (6,) rate of the twist of C, V
SUM = 39  # (6,) N^T p, by free motions
P = 45  # (6, 6) articulated inertia, modes eliminated
WAY = 81  # 6 directions (6,): of the joint's equations, then the free motions N
U = 117  # by free motions (6,): P N D
GAIN = 153  # by free motions (6,): D N^T P
INVERSE = 189  # (nf, nf) D = (N^T P N)^-1
TRIANGLE = 225  # (6, 6) factor of the equations in their directions
FREE = 261  # number of free motions
WIDTH = 264


class Store(NamedTuple):
    """What the passes of the recursion leave for each other."""

    rows: FloatRows
    """(nb, WIDTH) see above"""
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
        rows=np.zeros((len(tables.iu), WIDTH)),
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
