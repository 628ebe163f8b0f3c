"""Closed loops of rigid links: what multipliers of the cut equations do to the joints, and those that close the loops.

The wrench of a unit multiplier is passed on to the roots as the force in the articulated-body algorithm. At every joint
on its way it leaves an amount ``b = S^T W``, and with the inertia ``D^-1`` that the joint moves there, the mobility of
the cut equations is ``A_mn = sum b_m D b_n`` over the joints on both ways: the factors of the inverse mass matrix
(Rodriguez, Jain & Kreutz-Delgado 1991). A is factorised in its profile; equations that depend on others give no
multiplier.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.structures import FloatRows, Floats, Integers, structure
from flexmb.tree.rigid.passes import solve_factor
from flexmb.tree.rigid.places import BALL, BEND, FRAME, SINGLE

__all__ = ["Closing", "add_multipliers", "closing", "factorise", "leave", "pass_on", "solve_multipliers", "wrench_at"]

RANK = 1e-7
"""Pivots below this part of the largest entry, or of 1, count as dependence, all relative to free bodies: see
`loops.RANK`. Entries beyond 1 are those of bodies that hardly resist (`needles.least_inertia`), and no measure."""
ROUNDING = 1e-13
"""The same where all equations are dependent; also of an equation's own entry."""


@structure
class Closing(NamedTuple):
    """The cut equations in an order with a small profile."""

    equations: Integers
    """(nc,) their numbers"""
    mobility: Floats
    """(nc,) what each does between free bodies, about"""
    start: Integers
    """(nc + 1,) first link on the way of each to the roots"""
    link: Integers
    """(ne,) the links on the ways, leaves first"""
    at: Integers
    """(ne,) first of the link's numbers in push and give"""
    start_meet: Integers
    """(nl + 1,) first way through each link"""
    equation: Integers
    """(nm,) which equations these are"""
    meet: Integers
    """(nm,) and their `at`"""
    first: Integers
    """(nc,) first column of every row of the profile"""
    row: Integers
    """(nc + 1,) where the row begins"""
    A: Floats
    """the matrix, a profile"""
    L: Floats
    """its factor"""
    d: Floats
    """(nc,) pivots, zero for dependent equations"""
    push: Floats
    """S^T W on all ways"""
    give: Floats
    """the same times D"""
    wrench: FloatRows
    """(nl, 6) scratch, zero between calls"""
    x: Floats
    """(nc,) right side, multipliers"""


def closing(links, marks, equations, legs, mobility) -> Closing:
    """Return the tables of cut equations (nc,), which act on the markers of `legs`, with their mobilities (nc,)."""
    link_of = {int(mark["marker"]): int(mark["link"]) for mark in marks}
    acting: dict[int, list[int]] = {int(e): [] for e in equations}
    for leg in legs:
        if int(leg["equation"]) in acting and int(leg["marker"]) in link_of:
            acting[int(leg["equation"])].append(link_of[int(leg["marker"])])
    ways = [_way(links, acting[int(e)]) for e in equations]
    order = _ordered(links, ways)
    ways = [ways[n] for n in order]
    start = np.cumsum([0] + [len(way) for way in ways])
    link = np.array([k for way in ways for k in way], np.int64)
    freedoms = np.where(links["kind"] == BEND, links["modes"], np.maximum(links["kind"], 0))
    size = freedoms[link] if len(link) else np.zeros(0, np.int64)
    at = np.concatenate([[0], np.cumsum(size)])
    through: list[list[tuple[int, int]]] = [[] for _ in links]
    first = np.arange(len(ways))
    for n, way in enumerate(ways):
        for i, k in enumerate(way):
            if size[start[n] + i]:
                through[k].append((n, int(at[start[n] + i])))
    for met in through:
        for n, _ in met:
            first[n] = min(first[n], met[0][0])
    row = np.concatenate([[0], np.cumsum(np.arange(len(ways)) - first + 1)])
    nc, numbers = len(ways), max(1, int(at[-1]))
    return Closing(
        equations=np.asarray(equations, np.int64)[order],
        mobility=np.asarray(mobility, float)[order],
        start=start.astype(np.int64),
        link=link,
        at=at[:-1].astype(np.int64),
        start_meet=np.cumsum([0] + [len(met) for met in through]).astype(np.int64),
        equation=np.array([n for met in through for n, _ in met], np.int64),
        meet=np.array([a for met in through for _, a in met], np.int64),
        first=first.astype(np.int64),
        row=row.astype(np.int64),
        A=np.zeros(int(row[-1])),
        L=np.zeros(int(row[-1])),
        d=np.zeros(nc),
        push=np.zeros(numbers),
        give=np.zeros(numbers),
        wrench=np.zeros((len(links), 6)),
        x=np.zeros(nc),
    )


def _way(links, ends: list[int]) -> list[int]:
    """Return the links from some links to the roots, leaves first."""
    found = set()
    for k in ends:
        while k >= 0 and k not in found:
            found.add(k)
            k = int(links["parent"][k])
    return sorted(found, reverse=True)


def _ordered(links, ways) -> np.ndarray:
    """Return an order of the ways in which those that share a moving link are near each other."""
    pairs = [(n, k) for n, way in enumerate(ways) for k in way if links["kind"][k] > 0 or links["kind"][k] == BEND]
    if len(ways) < 2 or not pairs:
        return np.arange(len(ways))
    n, k = np.array(pairs).T
    share = sparse.csr_matrix((np.ones(len(n)), (n, k)), shape=(len(ways), len(links)))
    return np.asarray(reverse_cuthill_mckee((share @ share.T).tocsr(), symmetric_mode=True), np.int64)


@kernel
def wrench_at(pose, s, force, out):
    """Add the wrench (6,) of a force and moment in W at a place s of a link, to its (moment, force) in link axes."""
    a, b, c = force[0], force[1], force[2]
    x, y, z = force[3], force[4], force[5]
    R = pose.R
    f = R[0, 0] * a + R[1, 0] * b + R[2, 0] * c
    g = R[0, 1] * a + R[1, 1] * b + R[2, 1] * c
    h = R[0, 2] * a + R[1, 2] * b + R[2, 2] * c
    out[0] += R[0, 0] * x + R[1, 0] * y + R[2, 0] * z + s[1] * h - s[2] * g
    out[1] += R[0, 1] * x + R[1, 1] * y + R[2, 1] * z + s[2] * f - s[0] * h
    out[2] += R[0, 2] * x + R[1, 2] * y + R[2, 2] * z + s[0] * g - s[1] * f
    out[3] += f
    out[4] += g
    out[5] += h


@kernel
def leave(link, row, block, W, push, give):
    """Write what a wrench (6,) leaves at the joint of a link, and subtract what the joint's motion takes of it."""
    if link.kind == SINGLE:
        b = link.turn * W[2] + link.slide * W[5]
        push[0], give[0] = b, 0.0
        if link.driven == 0:
            give[0] = b * row.mobility
            for i in range(6):
                W[i] -= row.gain[i] * b
    elif link.kind == BALL or link.kind == FRAME:
        n = 3 if link.kind == BALL else 6
        for i in range(n):
            push[i] = give[i] = W[i]
        solve_factor(block.L, n, give)
        if n == 3:
            for i in range(3):
                for j in range(3):
                    W[3 + i] -= block.gain[i, j] * W[j]
            W[:3] = 0.0


@kernel
def pass_on(row, W, of_parent):
    """Add a wrench of a link to its parent's."""
    x, y, z = row.r[0], row.r[1], row.r[2]
    f, g, h = 0.0, 0.0, 0.0
    for i in range(3):
        p, q, r = row.R[i, 0], row.R[i, 1], row.R[i, 2]
        of_parent[i] += p * W[0] + q * W[1] + r * W[2]
        force = p * W[3] + q * W[4] + r * W[5]
        of_parent[3 + i] += force
        if i == 0:
            f = force
        elif i == 1:
            g = force
        else:
            h = force
    of_parent[0] += y * h - z * g
    of_parent[1] += z * f - x * h
    of_parent[2] += x * g - y * f


@inner_kernel
def _responses(tree, c, work):
    """Write what unit multipliers leave at the joints on their ways."""
    links, rows, blocks, poses, marks, mark_of = (
        tree.links,
        tree.rows,
        tree.blocks,
        tree.poses,
        tree.marks,
        tree.mark_of,
    )
    for n in range(len(c.equations)):
        equation = work.equations[c.equations[n]]
        for m in range(equation.leg, equation.leg + equation.legs):
            leg = work.legs[m]
            place = mark_of[leg.marker]
            if place >= 0:
                mark = marks[place]
                wrench_at(poses[mark.link], mark.s, leg.gradient, c.wrench[mark.link])
        for e in range(c.start[n], c.start[n + 1]):
            k = c.link[e]
            link, W = links[k], c.wrench[k]
            size = max(link.kind, 0)
            span = slice(c.at[e], c.at[e] + size)
            if size > 0:
                leave(link, rows[k], blocks[link.block], W, c.push[span], c.give[span])
            if link.parent >= 0:
                pass_on(rows[k], W, c.wrench[link.parent])
            W[:] = 0.0


@kernel
def factorise(tree, c, work):
    """Write the mobility matrix of the cut equations and factorise it, L d L^T, in its profile."""
    links = tree.links
    _responses(tree, c, work)
    c.A[:] = 0.0
    for k in range(len(links)):
        size = links[k].kind
        for i in range(c.start_meet[k], c.start_meet[k + 1]):
            n, p = c.equation[i], c.meet[i]
            at = c.row[n] - c.first[n]
            for j in range(c.start_meet[k], i + 1):
                q = c.meet[j]
                x = 0.0
                for m in range(size):
                    x += c.push[p + m] * c.give[q + m]
                c.A[at + c.equation[j]] += x
    most = 0.0
    for i in range(len(c.equations)):
        most = max(most, c.A[c.row[i] + i - c.first[i]] / c.mobility[i])
    least = max(RANK * min(most, 1.0), ROUNDING)
    for i in range(len(c.equations)):
        at, low = c.row[i] - c.first[i], c.first[i]
        for j in range(low, i):
            x = c.A[at + j]
            back = c.row[j] - c.first[j]
            for k in range(max(low, c.first[j]), j):
                x -= c.L[at + k] * c.L[back + k]
            c.L[at + j] = x
        pivot = c.A[at + i]
        for j in range(low, i):  # from products with the pivots to the factor
            x = c.L[at + j]
            if c.d[j] > 0.0:
                c.L[at + j] = x / c.d[j]
                pivot -= x * c.L[at + j]
            else:
                c.L[at + j] = 0.0
        c.d[i] = pivot if pivot > max(least * c.mobility[i], ROUNDING * c.A[at + i]) else 0.0


@kernel
def solve_multipliers(c):
    """Solve A x = b with the factors; x replaces b, which stands in c.x."""
    x = c.x
    for i in range(len(x)):
        at = c.row[i] - c.first[i]
        for j in range(c.first[i], i):
            x[i] -= c.L[at + j] * x[j]
    for i in range(len(x)):
        x[i] = x[i] / c.d[i] if c.d[i] > 0.0 else 0.0
    for i in range(len(x) - 1, -1, -1):
        at = c.row[i] - c.first[i]
        for j in range(c.first[i], i):
            x[j] -= c.L[at + j] * x[i]


@kernel
def add_multipliers(tree, c):
    """Add the multipliers c.x to the loads of the joints, after those were passed on."""
    links, rows, blocks = tree.links, tree.rows, tree.blocks
    for k in range(len(links)):
        link, row = links[k], rows[k]
        for i in range(c.start_meet[k], c.start_meet[k + 1]):
            lam, p = c.x[c.equation[i]], c.meet[i]
            if link.kind == SINGLE:
                row.load += lam * c.push[p]
            else:
                for m in range(link.kind):
                    blocks[link.block].load[m] += lam * c.push[p + m]
