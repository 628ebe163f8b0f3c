"""`compile`: names become indices, parts become record tables."""

from __future__ import annotations

import numpy as np

from flexmb.constraints import EQUATIONS
from flexmb.math.block_lu import on_demand_for
from flexmb.math.jets import SignalCode, run_program
from flexmb.math.tables import MARKER, STIFF
from flexmb.model.described import check_kind
from flexmb.model.model import Model
from flexmb.model.primitives import Equation
from flexmb.model.signal import pack
from flexmb.model.table import Table
from flexmb.system.combinations import combination_rows
from flexmb.system.force_tables import rows_of_forces, switches_of
from flexmb.system.inputs import places_of_inputs
from flexmb.system.layout import Layout, check_size
from flexmb.system.lengths import unit_lengths
from flexmb.system.model_compiler import ModelCompiler
from flexmb.system.program import Program, compile_shared, evaluation, kernel_table, row_kernels
from flexmb.system.signal_times import SignalTimes
from flexmb.system.sparsity import sparsity
from flexmb.system.states import STATES
from flexmb.system.system import System

__all__ = ["compile"]


def _grouped(items: list[tuple[Table, tuple]]) -> tuple[list[Table], list[np.ndarray]]:
    """Return the tables and their record arrays, in order of first use."""
    tables: dict[str, tuple[Table, list[tuple]]] = {}
    for table, row in items:
        tables.setdefault(table.name, (table, []))[1].append(row)
    return [t for t, _ in tables.values()], [np.array(rows, t.row) for t, rows in tables.values()]


def _append(grouped: tuple[list, list], more: tuple[list, list]) -> None:
    """Append tables and their record arrays to others."""
    for own, others in zip(grouped, more, strict=True):
        own += others


def _body_rows(model: Model, compiler: ModelCompiler, layout: Layout):
    items = []
    for k, body in enumerate(model.bodies):
        if body.table is None:
            continue
        first = layout.first_marker[k]
        count = layout.first_marker[k + 1] - first
        header = {"iq": layout.iq[k], "iu": layout.iu[k], "marker": first, "n_markers": count}
        compiler.writing = body.title
        items.append((body.table, body.table.filled(body, {**header, **body.record(compiler, compiler)})))
    return _grouped(items)


def _force_items(model: Model, compiler: ModelCompiler) -> list[tuple[Table, tuple]]:
    """Return the rows of all forces, and of what sensors follow."""
    items = []
    for force in model.forces:
        compiler.writing = force.title
        compiler.asked = []
        row = force.table.filled(force, force.record(compiler))
        items.append((force.table, row))
        pairs = tuple(dict.fromkeys(compiler.asked))
        compiler.written[force.name] = force.table, row, pairs, force.title in compiler.followers
    # last, so that the coordinates of a model begin alike whatever is watched
    for sensor in model.sensors:
        compiler.writing = sensor.title
        items += [(table, table.filled(sensor, row)) for table, row in sensor.followed(compiler)]
    for joint in model.joints:
        compiler.writing = joint.title
        compiler.loops.watch(*joint.watched(model))
    before, after = compiler.loops.rows()
    return [*before, *items, *after]


def _state_rows(compiler: ModelCompiler, layout: Layout):
    """Return the table of groups of states; their own places in the matrix follow the couplings of all bodies."""
    bodies = compiler.model.bodies
    at = layout.iu[len(bodies)] + sum(2 * b.block_size * len(b.couplings()) for b in bodies)
    rows = []
    for k, group in enumerate(compiler.states.values(), len(bodies)):
        iu, n = layout.iu[k], len(group.names)
        rows.append((STATES, (iu, group.marker, n, at + iu - layout.iu[len(bodies)])))
    return _grouped(rows)


class _Constraints:
    """The equations of all joints: rows, legs, and which joint each belongs to."""

    def __init__(self, model: Model, compiler: ModelCompiler):
        self.joints, self.names = [], []
        self.levels: list[int] = []
        self.owners: list[tuple[int, Equation]] = []
        self.slices: dict[str, slice] = {}
        items, legs = [], []
        for number, description in enumerate(model.joints):
            compiler.writing = description.title
            markers = tuple(compiler.marker(m) for m in description.resolved_markers(model))
            joint = description.resolved(np.array([compiler.position(m) for m in markers]))
            self.joints.append(joint)
            start = len(self.names)
            for primitive in joint.equations_in(model):
                involved = primitive.involved(markers)
                a, b = (*involved, *involved)[:2]
                pair = compiler.pair(a, b, STIFF if primitive.stiffens else 0)
                header = {"equation": len(self.names), "leg": len(legs), "a": a, "b": b, "pair": pair}
                row = primitive.table.filled(primitive, {**header, **primitive.record(compiler, markers)})
                items.append((primitive.table, row))
                for k in range(primitive.count):
                    legs += [(marker, len(self.names)) for marker in involved]
                    self.levels.append(primitive.level)
                    self.names.append(f"{joint.name}: {_describe(primitive, k)}")
                    self.owners.append((number, primitive))
            self.slices[joint.name] = slice(start, len(self.names))
        order = {kind.table.name: k for k, kind in enumerate(EQUATIONS)}
        items.sort(key=lambda item: order[item[0].name])
        self.tables, self.rows = _grouped(items)
        self.legs = legs


def _describe(primitive, k: int) -> str:
    """Return how messages call equation `k` of a primitive: "Perpendicular z x", "Coincident[y]", "OnCurve[2]"."""
    axes = [
        axis if isinstance(axis, str) else "xyz"[axis]
        for name, axis in vars(primitive).items()
        if name.startswith("axis") and axis != -1
    ]
    which = {1: ("",), 2: ("[1]", "[2]"), 3: ("[x]", "[y]", "[z]")}[primitive.count][k]
    return " ".join([type(primitive).__name__, *axes]) + which


def _markers(compiler: ModelCompiler, layout: Layout) -> tuple[np.ndarray, int]:
    """Return the marker table and the size of the flat Jacobians."""
    markers = np.zeros(len(compiler.marker_body), MARKER)
    body = markers["body"] = np.array(compiler.marker_body, np.int64)
    first, nu = np.array(compiler.marker_span, np.int64).reshape(-1, 2).T
    for k, (r, R) in enumerate(compiler.start_poses):
        markers["r"][k], markers["R"][k] = r, R
    markers["iu"], markers["nu"], markers["iJ"] = np.array(layout.iu)[body] + first, nu, 6 * (np.cumsum(nu) - nu)
    widths = [b.block_size for b in compiler.model.bodies] + [len(g.names) for g in compiler.states.values()]
    markers["width"] = np.array(widths)[body]
    markers["iH"] = -1
    return markers, int(6 * np.sum(nu))


def _markers_of_bodies(compiler: ModelCompiler) -> dict[str, int]:
    """Return the numbers of the markers by name, without those of groups of states."""
    n_bodies = len(compiler.model.bodies)
    return {name: k for name, k in compiler.marker_index.items() if compiler.marker_body[k] < n_bodies}


def _table_bytes(arrays: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return all record arrays as one byte array, each beginning at a multiple of 64, and their bounds."""
    raw = np.concatenate([*(a.view(np.uint8).ravel() for a in arrays), np.zeros(0, np.uint8)])
    bounds = np.cumsum([0] + [a.nbytes for a in arrays])
    return raw, bounds.astype(np.int64)


def _program(
    compiler: ModelCompiler, layout: Layout, constraints: _Constraints, signals, pattern, tables, records
) -> Program:
    """Return what kernels read: `tables` of bodies and of forces, `records` as bytes and where each table begins."""
    body_tables, force_tables = tables
    raw, starts = records
    tables_of_all = *body_tables, *constraints.tables, *force_tables
    needed = {*on_demand_for(pattern), *([run_program] if signals else ())}
    for called in needed.union(*(t.on_demand for t in tables_of_all)):
        called.ready()
    compile_shared(row_kernels(tables_of_all))
    return Program(
        place=kernel_table([t.kernels["place"] for t in body_tables]),
        inertia=kernel_table([t.kernels["inertia"] for t in body_tables]),
        energy=kernel_table([t.kernels["energy"] for t in body_tables]),
        equations=kernel_table([t.kernels["evaluate"] for t in constraints.tables]),
        forces=kernel_table([t.kernels["apply"] for t in force_tables]),
        raw=raw,
        starts=starts,
        bulk=compiler.bulk_data(),
        signals=SignalCode(*pack(signals)),
        frames=layout.frames,
        vectors=layout.vectors,
        pattern=pattern,
        regularisation=np.zeros(len(constraints.names)),
        floor_at=np.zeros((0, 2), np.int64),
        floor=np.zeros(0),
        equation_level=np.array(constraints.levels, np.int64),
        branches=len(layout.q),
        evaluation=evaluation.compiled.address,
    )


def compile(model: Model) -> System:
    """Return the compiled system of a model.

    Raises
    ------
    CompileError
        If the parts do not fit together.
    """
    check_kind(model, Model, "Model", "Give a flexmb.Model(bodies=[...]), or flexmb.load_model('file.toml')")
    compiler = ModelCompiler(model)
    layout = Layout(model, compiler)
    check_size(model, layout)
    body_tables, body_rows = _body_rows(model, compiler, layout)
    others = len(compiler.signals)
    constraints = _Constraints(model, compiler)
    prescribing = slice(others, len(compiler.signals))
    compiler.equations = constraints.slices
    force_tables, force_rows = _grouped(_force_items(model, compiler))
    layout.append(compiler.states.values())
    for more in (_state_rows(compiler, layout), _grouped(combination_rows(compiler, layout))):
        _append((body_tables, body_rows), more)
    markers, size_J = _markers(compiler, layout)
    size_J += compiler.loops.size
    for body in model.bodies:
        body.stiffen(compiler, markers)
    pattern, tables = sparsity(model, compiler, layout, constraints, markers)
    n_pairs = compiler.loops.find_places(markers, tables)
    signals = [s.program() for s in compiler.signals]
    inputs = places_of_inputs(signals, compiler.signal_titles, prescribing)
    raw, starts = _table_bytes([*body_rows, *constraints.rows, *force_rows])
    first_force = len(body_tables) + len(constraints.tables)
    program = _program(compiler, layout, constraints, signals, pattern, (body_tables, force_tables), (raw, starts))
    return System(
        model=model,
        program=program,
        q0=np.concatenate([layout.q, list(compiler.branches.values())]),
        u0=layout.u,
        n_signals=len(compiler.signals),
        n_loads=len(compiler.load_index),
        load_index=dict(compiler.load_index),
        n_channels=compiler.loops.n_channels,
        implicit=compiler.loops.follows_accelerations,
        samples_reactions=compiler.loops.follows_reactions,
        values=compiler.values,
        size_J=size_J,
        n_pairs=n_pairs,
        size_H=compiler.size_H,
        tables={"markers": markers, **tables},
        marker_index=_markers_of_bodies(compiler),
        joint_index={j.name: k for k, j in enumerate(model.joints)},
        force_index={f.name: k for k, f in enumerate(model.forces)},
        equation_names=tuple(constraints.names),
        equation_owners=tuple(constraints.owners),
        force_rows=rows_of_forces(model, force_tables, starts[first_force:]),
        joint_equations=constraints.slices,
        joints=tuple(constraints.joints),
        gaps=np.zeros(len(constraints.names)),
        body_slices=layout.slices([b.name for b in model.bodies]),
        states=tuple(compiler.states.values()),
        state_slices=layout.slices(compiler.states, len(model.bodies)),
        branch_names=tuple(compiler.branches),
        signal_times=SignalTimes(signals, tuple(compiler.signal_titles), compiler.loops.clocks()),
        prescribing=prescribing,
        rates_read=np.array([*compiler.rates_read, *range(others, prescribing.stop)], np.int64),
        inputs=inputs,
        holds=tuple(compiler.loops.holds),
        **switches_of(model, force_tables, force_rows, starts[first_force:], compiler.loops),
        lengths=unit_lengths(len(model.bodies), len(constraints.names)),
        units=np.ones(layout.iu[-1]),
        least_inertia=np.zeros(layout.iu[-1]),
    )
