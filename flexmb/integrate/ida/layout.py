"""The constant tables of the stabilised form: where the entries of its Jacobian come from and go to."""

from __future__ import annotations

from itertools import product

import numpy as np

from flexmb.integrate.ida.stabilised import Stabilised
from flexmb.math.tables import ONE_WAY

__all__ = ["layout"]


def _block_entries(system) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (position in S, row, column) of the entries of the blocks (u, u), (u, lam) and (lam, u), without fill."""
    pattern, tables = system.program.pattern, system.tables
    used = np.zeros(int(pattern.row_start[-1]), bool)
    for at, size in zip(tables["rows"], tables["widths"], strict=True):
        used[at : at + size] = True
    markers = tables["markers"]
    for leg in tables["legs"]:
        size, width = (int(markers[leg["marker"]][name]) for name in ("nu", "width"))
        used[tables["transposed"][leg["iT"] : leg["iT"] + size]] = True
        for at in tables["transposed"][leg["iS"] : leg["iS"] + (size // width if size else 0)]:
            used[at : at + width] = True
    for pair in tables["pairs"]:
        ends = [(int(markers[pair[side]]["nu"]), int(markers[pair[side]]["width"])) for side in "ab"]
        start, sides = pair["iS"], [size for size, _ in ends]
        blocks = ((sides[0], ends[1]),) if pair["active"] == ONE_WAY else product(sides, ends)
        for rows, (columns, width) in blocks:
            if pair["active"] and rows and columns:
                count = rows * (columns // width)
                for at in tables["pair_rows"][start : start + count]:
                    used[at : at + width] = True
                start += count
    row, column = np.empty(len(used), np.int64), np.empty(len(used), np.int64)
    for place, block in enumerate(pattern.row_block):
        at = pattern.row_start[place]
        row[at : pattern.row_start[place + 1]] = pattern.order[place]
        for k in range(pattern.segment_start[block], pattern.segment_start[block + 1]):
            first, size = pattern.column[k], pattern.length[k]
            column[at : at + size] = pattern.order[first : first + size]
            at += size
    nu = system.nu
    lam_row, lam_column = row >= nu, column >= nu
    own, transposed, gradient = (
        np.stack([places, row[places] - rows, column[places] - columns], axis=1)
        for places, rows, columns in (
            (np.flatnonzero(used & ~lam_row & ~lam_column), 0, 0),
            (np.flatnonzero(used & ~lam_row & lam_column), 0, nu),
            (np.flatnonzero(used & lam_row & ~lam_column), nu, 0),
        )
    )
    return own, transposed, gradient


def _colours(system) -> tuple[np.ndarray, int]:
    """Return the group of every velocity, such that two bodies of a group share no equation, and the number of groups.

    Only motions at large have a group: frames and points.
    """
    markers, legs = system.tables["markers"], system.tables["legs"]
    bodies_of: dict[int, set[int]] = {}
    for leg in legs:
        bodies_of.setdefault(int(leg["equation"]), set()).add(int(markers[leg["marker"]]["iu"]))
    neighbours: dict[int, set[int]] = {}
    for bodies in bodies_of.values():
        for body in bodies:
            neighbours.setdefault(body, set()).update(bodies - {body})
    colour, of_body = np.full(system.nu, -1), {}
    large = [(int(iu), 6) for _, iu in system.program.frames]
    large += [(int(iu), 3) for _, iu, size, flexible in system.program.vectors if size == 3 and not flexible]
    for body, size in sorted(large):
        taken = {of_body.get(other, -1) for other in neighbours.get(body, ())}
        of_body[body] = next(k for k in range(len(taken) + 1) if k not in taken)
        colour[body : body + size] = of_body[body]
    return colour, int(colour.max(initial=-1)) + 1


def layout(system, extent: np.ndarray, length_rate: float, yielding: np.ndarray) -> Stabilised:
    """Return the state and tables for a system.

    `extent` (nu,) as in the room's `extents`, `length_rate` kappa in 1/s, `yielding` (2, ng) epsilon in s.
    """
    nu, ng = system.nu, system.ng
    colour, colours = _colours(system)
    frame_of, offset, coordinate = np.full(nu, -1), np.zeros(nu, np.int64), np.zeros(nu, np.int64)
    for f, (iq, iu) in enumerate(system.program.frames):
        frame_of[iu : iu + 6], offset[iu : iu + 6], coordinate[iu : iu + 6] = f, np.arange(6), iq
    for iq, iu, size, _ in system.program.vectors:
        coordinate[iu : iu + size] = iq + np.arange(size)
        offset[iu : iu + size] = np.arange(size)
    held = np.where(system.program.equation_level == 0, 1, 0)
    own, transposed, gradient = _block_entries(system)
    state = system.state()
    return Stabilised(
        q=state.q,
        u=state.u,
        a=state.a,
        lam=state.lam,
        mu=np.zeros(ng),
        signals=state.signals,
        held=held,
        yielding=yielding,
        usual=np.zeros(ng),
        metric=1.0 / extent**2,
        kin=np.zeros(nu),
        speed=np.zeros(ng),
        length_rate=np.array([length_rate]),
        frame_of=frame_of,
        offset=offset,
        coordinate=coordinate,
        own=own,
        transposed=transposed,
        gradient=gradient,
        K=np.zeros(int(system.program.pattern.row_start[-1])),
        colour=colour,
        colours=colours,
        near=state.q.copy(),
        turning=np.zeros(len(gradient)),
    )
