"""The motion of links, compiled: second rates with forces and loops, and the way back onto the loops.

Forces and cut joints see what they always see, markers: their kernels run as in every evaluation, on those of the
links.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.energies import clear_energy
from flexmb.math.jets import sample_signals
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.plain_loops import largest_size
from flexmb.math.rotations import euler_product, exp_euler
from flexmb.math.structures import array_type
from flexmb.math.tables import FLOATS, INTEGERS, NUMBER, WORK, State, caller, pointer_kernel, void
from flexmb.math.weights import no_matrix
from flexmb.system.program import run_kernels
from flexmb.tree.coordinates.settle import count_turns, prescribe, unit_length
from flexmb.tree.flexible import closing as flexible_closing
from flexmb.tree.flexible import passes as flexible_passes
from flexmb.tree.flexible.passes import write_bodies
from flexmb.tree.rigid import called as rigid_passes
from flexmb.tree.rigid.closing import wrench_at
from flexmb.tree.rigid.link_tree import LINK_TREE, LinkTree, call_pass, call_spread
from flexmb.tree.rigid.places import BALL, BEND, FRAME, SINGLE
from flexmb.tree.rigid.states import move_states, place_states

__all__ = [
    "act_on_links",
    "close_links",
    "closing_rates",
    "evaluate_links",
    "evaluate_loops",
    "link_rates",
    "loops_are_open",
    "place_marks",
    "pose_links",
    "ready",
]

EVALUATION = void(LINK_TREE, WORK, NUMBER)
CLOSURE = void(LINK_TREE, WORK, NUMBER, array_type(FLOATS), array_type(FLOATS), array_type(INTEGERS))

call_links, call_closure = caller(EVALUATION), caller(CLOSURE)


def ready(tree: LinkTree) -> LinkTree:
    """Return the links with the addresses of the kernels that they need, compiled."""
    run, bends = tree.run[0], len(tree.flexible.bodies) > 0
    passes = flexible_passes if bends else rigid_passes
    run.evaluation = evaluation.compiled.address
    run.place, run.gather = passes.placing.compiled.address, passes.gathering.compiled.address
    run.spread = passes.spreading.compiled.address
    if len(tree.closing.equations):
        loops = flexible_closing if bends else rigid_passes
        run.closure = closure.compiled.address
        run.factorise, run.solve = loops.factorising.compiled.address, loops.solving.compiled.address
    return tree


@kernel
def pose_links(tree):
    """Write where all links are in W."""
    links, rows, poses = tree.links, tree.rows, tree.poses
    for k in range(len(links)):
        link, row, pose = links[k], rows[k], poses[k]
        if link.parent < 0:
            pose.R[:] = row.R
            pose.r[:] = row.r
            continue
        of_parent = poses[link.parent]
        for i in range(3):
            a, b, c = of_parent.R[i, 0], of_parent.R[i, 1], of_parent.R[i, 2]
            for j in range(3):
                pose.R[i, j] = a * row.R[0, j] + b * row.R[1, j] + c * row.R[2, j]
            pose.r[i] = of_parent.r[i] + a * row.r[0] + b * row.r[1] + c * row.r[2]


@kernel
def place_marks(tree, work):
    """Write position, axes and velocities of the markers, and their states, without wrenches."""
    marks, markers, poses, rows = tree.marks, work.markers, tree.poses, tree.rows
    for n in range(len(marks)):
        mark = marks[n]
        marker, pose, row = markers[mark.marker], poses[mark.link], rows[mark.link]
        x, y, z = mark.s[0], mark.s[1], mark.s[2]
        a, b, c = row.twist[0], row.twist[1], row.twist[2]
        u, v, w = row.twist[3] + b * z - c * y, row.twist[4] + c * x - a * z, row.twist[5] + a * y - b * x
        for i in range(3):
            p, q, r = pose.R[i, 0], pose.R[i, 1], pose.R[i, 2]
            marker.r[i] = pose.r[i] + p * x + q * y + r * z
            marker.v[i] = p * u + q * v + r * w
            marker.w[i] = p * a + q * b + r * c
            for j in range(3):
                marker.R[i, j] = p * mark.A[0, j] + q * mark.A[1, j] + r * mark.A[2, j]
        for i in range(6):
            marker.wrench[i] = 0.0
    place_states(tree, work)


@kernel
def evaluate_loops(tree, chart, program, work, t):
    """Run the kernels of cut joints, on the markers."""
    clear_energy(work.energy)
    no_matrix(work.weights)
    sample_signals(
        t,
        program.signals,
        tree.signals,
    )
    count_turns(chart, program, t, tree.x, tree.q)
    state = State(t, tree.q, tree.u, tree.rest, tree.lam, tree.signals)
    if len(tree.flexible.bodies) > 0:
        write_bodies(tree, work)
    run_kernels(program.equations, len(program.inertia), program, state, work)


@kernel
def act_on_links(tree, chart, program, work, t):
    """Run the kernels of cut joints and forces, and give the wrenches of these to the links."""
    evaluate_loops(tree, chart, program, work, t)
    if len(program.forces) == 0:
        return
    state = State(t, tree.q, tree.u, tree.rest, tree.lam, tree.signals)
    run_kernels(program.forces, len(program.inertia) + len(program.equations), program, state, work)
    W = np.empty(6)
    marks, markers, poses, rows = tree.marks, work.markers, tree.poses, tree.rows
    for n in range(len(marks)):
        mark = marks[n]
        wrench = markers[mark.marker].wrench
        W[:] = 0.0
        wrench_at(poses[mark.link], mark.s, wrench, W)
        for i in range(6):
            rows[mark.link].force[i] -= W[i]


@kernel
def closing_rates(tree, closing, work, second):
    """Write what is left of the cut equations to closing.x, with the opposite sign:
    of their rates, or of second rates; in the still these are what the links' rates give alone.
    """
    still = tree.run[0].still == 1
    g, marks, mark_of, rows, poses = tree.gravity, tree.marks, tree.mark_of, tree.rows, tree.poses
    for n in range(len(closing.equations)):
        equation = work.equations[closing.equations[n]]
        s = equation.drift if second else equation.rate
        if still:
            s = 0.0
        for m in range(equation.leg, equation.leg + equation.legs):
            leg = work.legs[m]
            place = mark_of[leg.marker]
            if place < 0:
                continue
            if not second:
                marker = work.markers[leg.marker]
                for i in range(3):
                    s += leg.gradient[i] * marker.v[i] + leg.gradient[3 + i] * marker.w[i]
                continue
            mark = marks[place]
            row, pose = rows[mark.link], poses[mark.link]
            x, y, z = mark.s[0], mark.s[1], mark.s[2]
            a, b, c = row.twist[0], row.twist[1], row.twist[2]
            # the velocity of the marker, of which the spatial acceleration does not know that it turns
            u, v, w = row.twist[3] + b * z - c * y, row.twist[4] + c * x - a * z, row.twist[5] + a * y - b * x
            d, e, f = row.rate[0], row.rate[1], row.rate[2]
            u, v, w = (
                row.rate[3] + e * z - f * y + b * w - c * v,
                row.rate[4] + f * x - d * z + c * u - a * w,
                row.rate[5] + d * y - e * x + a * v - b * u,
            )
            for i in range(3):
                p, q, r = pose.R[i, 0], pose.R[i, 1], pose.R[i, 2]
                fall = 0.0 if still else g[i]
                s += leg.gradient[i] * (p * u + q * v + r * w + fall) + leg.gradient[3 + i] * (p * d + q * e + r * f)
        closing.x[n] = -s


@inner_kernel
def _drive(tree, chart, t):
    """Write the motion of the drives at time t to tree.x, tree.v, tree.a."""
    if len(chart.driven) > 0:
        sample_signals(t, chart.signals, chart.sampled)
        prescribe(chart.driven, chart.sampled, tree.x, tree.v, tree.a)


@inner_kernel
def _placed(tree, chart, program, work, t):
    """Place links and markers, let forces act, and pass inertias and forces on; run.failed tells of the last."""
    call_pass(tree.run[0].place, tree, work)
    if len(tree.marks) > 0 or len(program.forces) > 0:
        pose_links(tree)
        place_marks(tree, work)
        act_on_links(tree, chart, program, work, t)
    elif len(tree.flexible.bodies) > 0:
        clear_energy(work.energy)
    call_pass(tree.run[0].gather, tree, work)


@pointer_kernel(EVALUATION)
def evaluation(tree, work, t):
    """Write the second rates tree.a at tree.x, tree.v, with forces tree.tau on the rates: see `evaluate_links`."""
    # taken out once: each takes a count of references for every array in it
    c, chart, program = tree.closing, tree.chart, tree.program
    unit_length(chart.rows, tree.x)
    _drive(tree, chart, t)
    _placed(tree, chart, program, work, t)
    if tree.run[0].failed >= 0:
        return
    call_spread(tree.run[0].spread, tree, 1.0)
    if len(c.equations) > 0:
        call_pass(tree.run[0].factorise, tree, work)
        closing_rates(tree, c, work, True)
        call_spread(tree.run[0].solve, tree, 1.0)
    move_states(tree, work, 1.0)
    tree.powers[:] = 0.0
    if len(tree.marks) > 0 or len(program.forces) > 0 or len(tree.flexible.bodies) > 0:
        tree.powers[0], tree.powers[2] = work.energy[0].load_power, work.energy[0].dissipation
    for n in range(len(chart.driven)):
        k = chart.driven[n, 1]
        tree.powers[1] += tree.tau[k] * tree.v[k]
    for n in range(len(c.equations)):
        tree.powers[1] -= c.x[n] * work.equations[c.equations[n]].rate


@kernel
def evaluate_links(tree, work, t):
    """Write the second rates tree.a at tree.x, tree.v and time t, with forces tree.tau on the rates.

    Also the powers (3,) of loads, drives and dissipation. Coordinates and rates of drives follow their signals,
    and the forces on them are written to tree.tau. The run's `failed` is -1, or the link whose motion has no inertia.
    """
    call_links(tree.run[0].evaluation, tree, work, t)


@kernel
def link_rates(tree, work, t, x, v):
    """Write the second rates tree.a of x and v; return -1, or the link whose motion has no inertia."""
    tree.x[:], tree.v[:] = x, v
    tree.tau[:] = 0.0
    call_links(tree.run[0].evaluation, tree, work, t)
    return tree.run[0].failed


@kernel
def loops_are_open(tree, work, bounds, lengths):
    """Have the loops come open in the evaluation before, by more than their bounds (ng,), or their velocities, per
    radian of the fastest motion? `lengths` (ng,), m, of the bodies that an equation relates make it an angle.
    """
    c = tree.closing
    fastest, spin = 0.0, 0.0
    for n in range(len(tree.marks)):
        marker = work.markers[tree.marks[n].marker]
        for i in range(3):
            fastest, spin = max(fastest, abs(marker.v[i])), max(spin, abs(marker.w[i]))
    closing_rates(tree, c, work, False)
    for n in range(len(c.equations)):
        k = c.equations[n]
        if abs(work.equations[k].g) > bounds[k] or abs(c.x[n]) > bounds[k] * max(spin, fastest / lengths[k]):
            return True
    return False


@inner_kernel
def _advance(tree, change):
    """Write tree.x [+] change (nv,): Euler parameters by the rotation in their own axes."""
    dp, p = np.empty(4), np.empty(4)
    for k in range(len(tree.links)):
        link = tree.links[k]
        at, iv = link.coordinate, link.rate
        if link.kind == SINGLE:
            tree.x[at] += change[iv]
        elif link.kind == BEND:
            for i in range(link.modes):
                tree.x[at + i] += change[iv + i]
        elif link.kind == BALL or link.kind == FRAME:
            if link.kind == FRAME:
                pose = tree.poses[k]
                for i in range(3):
                    for j in range(3):
                        tree.x[at + i] += pose.R[i, j] * change[iv + j]
                at, iv = at + 3, iv + 3
            exp_euler(change[iv : iv + 3], dp)
            p[:] = tree.x[at : at + 4]
            euler_product(p, dp, tree.x[at : at + 4])


@inner_kernel
def _changes(tree):
    """Write the changes of coordinates or rates tree.a that multipliers for the right side in closing.x give."""
    tree.a[:] = 0.0
    call_spread(tree.run[0].solve, tree, 0.0)


@pointer_kernel(CLOSURE)
def closure(tree, work, t, bounds, gaps, level):
    """Move tree.x and tree.v onto the closed loops: see `close_links`."""
    c, chart, program = tree.closing, tree.chart, tree.program
    for turn in range(12):
        _drive(tree, chart, t)
        tree.a[:] = 0.0
        tree.tau[:] = 0.0
        _placed(tree, chart, program, work, t)
        if tree.run[0].failed >= 0:
            return
        tree.run[0].failed = 1
        call_pass(tree.run[0].factorise, tree, work)
        largest, closed = 0.0, True
        for n in range(len(c.equations)):
            k = c.equations[n]
            c.x[n] = -work.equations[k].g if level[k] == 0 else 0.0
            largest = max(largest, abs(c.x[n]) / bounds[k] if c.d[n] != 0.0 else 0.0)
            closed = closed and abs(c.x[n]) <= max(gaps[k], bounds[k])
        if not np.isfinite(largest):
            return
        if largest <= 1.0 and turn > 0:
            break
        _changes(tree)
        stride = largest_size(tree.a)
        _advance(tree, tree.a * min(1.0, 0.5 / max(stride, 1e-300)))
    for _ in range(2):
        closing_rates(tree, c, work, False)
        _changes(tree)
        tree.v[:] += tree.a
        call_pass(tree.run[0].place, tree, work)
        place_marks(tree, work)
    tree.run[0].failed = -1 if closed else 1


@kernel
def close_links(tree, work, t, bounds, gaps, level):
    """Move tree.x with least motion, in the metric of the mass matrix, onto the closed loops, then tree.v; drives stay.

    Equations are closed to `bounds` (ng,); dependent ones may stay open by up to `gaps` (ng,).
    `level` (ng,): 1 for velocity. Returns whether that worked.
    """
    call_closure(tree.run[0].closure, tree, work, t, bounds, gaps, level)
    return tree.run[0].failed < 0
