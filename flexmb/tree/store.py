"""The numbers of the recursion between its passes."""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from flexmb.math.kernel import kernel

__all__ = ["Store", "modal_views", "new_store"]

Store = namedtuple(
    "Store",
    "R lever step free basis triangle P U K D through c drop load V wrench plain modal pivots eta parent failed scratch",
)
"""Of every body of the tree, at its own marker C and in W.

R (nb, 3, 3) : axes of the body; lever: C from the body's origin; step: C from that of the parent (nb, 3)
free (nb,) : number of free motions of the joint
basis (nb, 6, 6), columns : directions of the joint's equations, then the free motions N; triangle (nb, 6, 6): factor of the
equations in these directions
P (nb, 6, 6) : articulated inertia, modes eliminated; D = (N^T P N)^-1, U = P N D (6, nf), K = D N^T P (nf, 6)
through (nb, 6, 6) : what it transmits, P - U N^T P
c (nb, 6) : velocity terms of the joint; drop (nb, 6) = through c
load, V, wrench (nb, 6) : load, rate of the twist of C, wrench of the joint
plain : inverse mass matrices of bodies without a frame
modal : factors of the modal block (m, m), couplings (6, m) and (m, 6), modal columns of J_C, and with stiffening, (6, m)
pivots, eta (sum of m,) : of the modal block; modal accelerations at V = 0
parent : modal columns E, and with stiffening, of what the parent's modes do at C, (6, m of the parent)
failed (2,) : place of the body where the recursion ended, or -1; 1: singular inertia, 2: dependent equations of its joint
"""


def new_store(tables) -> Store:
    """Return storage for a tree."""
    n = len(tables.iu)
    six, three = (n, 6, 6), (n, 3)

    def flat(size):
        return np.zeros(max(1, int(size)))

    return Store(
        R=np.zeros((n, 3, 3)), lever=np.zeros(three), step=np.zeros(three), free=np.zeros(n, np.int64), basis=np.zeros(six),
        triangle=np.zeros(six), P=np.zeros(six), U=np.zeros(six), K=np.zeros(six), D=np.zeros(six), through=np.zeros(six),
        c=np.zeros((n, 6)), drop=np.zeros((n, 6)), load=np.zeros((n, 6)), V=np.zeros((n, 6)), wrench=np.zeros((n, 6)),
        plain=flat(tables.i_plain[-1]), modal=flat(tables.i_modal[-1]),
        pivots=np.zeros(max(1, int(tables.i_eta[-1])), np.int64), eta=flat(tables.i_eta[-1]),
        parent=flat(tables.i_parent[-1]), failed=np.full(2, -1, np.int64),
        scratch=np.zeros((6, max(6, int(np.max(tables.nu, initial=0))))))


@kernel
def modal_views(tables, store, k):
    """Return the views of the modal block (m, m), couplings (6, m) and (m, 6), Jacobians (6, m), without and with H."""
    m = tables.i_eta[k + 1] - tables.i_eta[k]
    a = tables.i_modal[k]
    b = a + m * m
    return (store.modal[a:b].reshape((m, m)), store.modal[b : b + 6 * m].reshape((6, m)),
            store.modal[b + 6 * m : b + 12 * m].reshape((m, 6)), store.modal[b + 12 * m : b + 18 * m].reshape((6, m)),
            store.modal[b + 18 * m : b + 24 * m].reshape((6, m)))
