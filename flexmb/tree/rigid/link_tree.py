"""`LinkTree`: links with the forces, cut joints and drives that act on them, as tables for the kernels."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.constraints import EQUATIONS
from flexmb.math.jets import SignalCode
from flexmb.math.program import Program
from flexmb.math.structures import ArrayOf, FloatRows, Floats, IntegerRows, Integers, Record, numba_type, structure
from flexmb.math.tables import NUMBER, WORK, caller, void
from flexmb.tree.any_body.loops import mobilities
from flexmb.tree.coordinates.motions import MOTION
from flexmb.tree.coordinates.settle import Chart
from flexmb.tree.flexible.tables import Flexible, Packed, new_flexible
from flexmb.tree.rigid.closing import Closing, closing
from flexmb.tree.rigid.links import MARK, link_marks, link_rows
from flexmb.tree.rigid.places import BALL, FRAME, LINK, LINK_FACTOR, LINK_POSE, LINK_STATE
from flexmb.tree.rigid.points import require_heavy_points
from flexmb.tree.rigid.states import state_rows

__all__ = ["LINK_TREE", "PASS", "SPREAD", "LinkTree", "call_pass", "call_spread", "link_tree", "no_links"]


class LinkRun(Record):
    """Which kernels the links need, by their addresses, and what came of the last call."""

    evaluation: int
    closure: int
    """of what closes loops"""
    place: int
    """of the passes over rigid links, or over a tree with flexible ones, as the next four"""
    gather: int
    spread: int
    factorise: int
    """of what factorises the mobility of the cut equations, and solves for their multipliers"""
    solve: int
    invert: int
    """of the pass that finds the forces of given second rates"""
    still: int
    """1: inertia alone counts, at zero rates: no weight, no forces, nothing that stiff or loaded modes do"""
    failed: int
    """see `evaluate_links`"""


@structure
class LinkTree(NamedTuple):
    """Rigid and flexible links with what acts on them."""

    links: Annotated[np.ndarray, ArrayOf(LINK)]
    rows: Annotated[np.ndarray, ArrayOf(LINK_STATE)]
    """(nl + 1,)"""
    blocks: Annotated[np.ndarray, ArrayOf(LINK_FACTOR)]
    """of links of several freedoms"""
    poses: Annotated[np.ndarray, ArrayOf(LINK_POSE)]
    """(nl,)"""
    marks: Annotated[np.ndarray, ArrayOf(MARK)]
    """markers that forces or cut joints see"""
    mark_of: Integers
    """(markers,) their places, -1: does not move or is not seen"""
    states: IntegerRows
    """(ns, 3) of forces and blocks: marker, place in its twist, rate"""
    gravity: Floats
    """(3,) m/s2"""
    closing: Closing
    flexible: Flexible
    chart: Chart
    program: Program
    """the kernels of forces and cut joints"""
    signals: FloatRows
    """(ns, 3) that they read"""
    lam: Floats
    """(ng,) zero"""
    q: Floats
    """(nq,) scratch, as what follows"""
    u: Floats
    """(nu,)"""
    rest: Floats
    """(nu,) zero"""
    x: Floats
    """(nx,)"""
    v: Floats
    """(nv,)"""
    a: Floats
    """(nv,)"""
    tau: Floats
    """(nv,)"""
    powers: Floats
    """(3,) W, of loads, drives and dissipation"""
    run: Annotated[np.ndarray, ArrayOf(LinkRun.dtype)]
    """one row"""


LINK_TREE = numba_type(LinkTree)
PASS = void(LINK_TREE, WORK)
SPREAD = void(LINK_TREE, NUMBER)

call_pass, call_spread = caller(PASS), caller(SPREAD)


def _cut_program(program, equations: np.ndarray):
    """Return the program with the rows of some equations only: joints in the tree hold by themselves."""
    kinds = {
        kind.table.kernels["evaluate"].compiled.address: kind.table.row
        for kind in EQUATIONS
        if "compiled" in vars(kind.table.kernels["evaluate"])
    }
    first, last = len(program.inertia), len(program.inertia) + len(program.equations)
    starts, pieces = [0], []
    for k in range(len(program.starts) - 1):
        raw = program.raw[program.starts[k] : program.starts[k + 1]]
        if k < first:
            raw = raw[:0]
        elif k < last:
            rows = raw.view(kinds[int(program.equations[k - first])])
            raw = rows[np.isin(rows["equation"], equations)].view(np.uint8)
        pieces.append(raw)
        starts.append(starts[-1] + len(raw))
    return program._replace(raw=np.concatenate(pieces), starts=np.array(starts, np.int64))


def link_tree(tree, chart, state, work) -> LinkTree:
    """Return the links of a `JointTree` with all that acts on them; `work` holds an evaluation at `state`."""
    system = tree.system
    equations = tree.tree.tables.cut_equations
    legs = system.tables["legs"]
    everything = len(system.program.forces) > 0  # forces do not say which markers they see
    wanted = range(len(work.markers)) if everything else np.unique(legs["marker"][np.isin(legs["equation"], equations)])
    drawn = link_rows(tree, state, work, wanted)
    marks = link_marks(tree, drawn, work, wanted)
    links = np.array(drawn.rows, LINK)
    mark_of = np.full(len(work.markers), -1, np.int64)
    mark_of[marks["marker"]] = np.arange(len(marks))
    mobility = np.zeros(len(equations))
    mobilities(work, equations, system.least_inertia, mobility)
    require_heavy_points(tree, work, mobility)
    nx, nv = len(tree.names), len(tree.rate_names)
    blocks = int(np.sum((links["kind"] == BALL) | (links["kind"] == FRAME)))
    loops = closing(links, marks, equations, legs, mobility)
    return LinkTree(
        links=links,
        rows=np.zeros(len(links) + 1, LINK_STATE),
        blocks=np.zeros(max(1, blocks), LINK_FACTOR),
        poses=np.zeros(len(links), LINK_POSE),
        marks=marks,
        mark_of=mark_of,
        states=state_rows(system, {name: int(row["iv"]) for name, row in zip(tree.tree.order, tree.rows, strict=True)}),
        gravity=np.array(tree.model.gravity, float),
        closing=loops,
        flexible=drawn.flexible(links, len(loops.push) if len(equations) else 0, len(loops.A)),
        chart=chart,
        program=_cut_program(system.program, equations),
        signals=np.zeros((max(1, system.n_signals), 3)),
        lam=np.zeros(system.ng),
        q=np.zeros(system.nq),
        u=np.zeros(system.nu),
        rest=np.zeros(system.nu),
        x=np.zeros(nx),
        v=np.zeros(nv),
        a=np.zeros(nv),
        tau=np.zeros(nv),
        powers=np.zeros(3),
        run=LinkRun.table(),
    )


def no_links(system, state) -> LinkTree:
    """Return no links: what kernels get for which bodies have coordinates of their own."""
    none, table, whole, pairs = np.zeros(0), np.zeros((0, 2), np.int64), np.zeros(0, np.int64), np.zeros((0, 3))
    links = np.zeros(0, LINK)
    chart = Chart(
        rows=np.zeros(0, MOTION),
        driven=table,
        signals=SignalCode(whole, whole, none, none, whole),
        sampled=pairs,
        counted=table,
        **dict.fromkeys(("clock", "branches", "pace", "start"), none),
    )
    return LinkTree(
        links=links,
        rows=np.zeros(0, LINK_STATE),
        blocks=np.zeros(0, LINK_FACTOR),
        poses=np.zeros(0, LINK_POSE),
        marks=np.zeros(0, MARK),
        mark_of=whole,
        states=np.zeros((0, 3), np.int64),
        gravity=none,
        closing=closing(links, [], [], [], []),
        flexible=new_flexible(links, [], [], Packed(), whole, 0, 0),
        chart=chart,
        program=system.program,
        signals=state.signals,
        **dict.fromkeys(("lam", "q", "u", "rest", "x", "v", "a", "tau", "powers"), none),
        run=LinkRun.table(),
    )
