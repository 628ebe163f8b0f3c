"""`compile`: names become indices, parts become record tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmb.constraints import EQUATIONS, Combination
from flexmb.errors import CompileError
from flexmb.math.jets import SignalCode
from flexmb.math.tables import DAMPED, MARKER, STIFF
from flexmb.model.described import check_kind
from flexmb.model.model import Model
from flexmb.model.primitives import Equation
from flexmb.model.signal import as_signal, pack
from flexmb.model.table import Table
from flexmb.system.combinations import combination_rows
from flexmb.system.force_tables import rows_of_forces, switches_of
from flexmb.system.inputs import places_of_inputs
from flexmb.system.layout import Layout, check_size
from flexmb.system.lengths import unit_lengths
from flexmb.system.loops import Loops
from flexmb.system.program import Program, evaluation, kernel_table
from flexmb.system.signal_times import SignalTimes
from flexmb.system.sparsity import sparsity
from flexmb.system.states import EACH, STATES, StateGroup, place_of_state
from flexmb.system.system import System

__all__ = ["compile"]


class _Compiler:
    """Collects rows, markers, signals, pairs and bulk data while the parts write themselves."""

    def __init__(self, model: Model):
        self.model = model
        self.gravity = np.array(model.gravity)
        self.marker_index: dict[str, int] = {}
        self.marker_names: list[str] = []
        self.marker_body: list[int] = []
        self.marker_span: list[tuple[int, int]] = []
        self.marker_gaps: dict[int, tuple[int, ...]] = {}
        self.start_poses: list[tuple[np.ndarray, np.ndarray]] = []
        self.first_coordinate: dict[str, int] = {}
        self.surface_places: dict[str, int] = {}
        self.signals: list[Any] = []
        self.signal_titles: list[str] = []  # of the parts that have them
        self.rates_read: list[int] = []  # signals whose rates forces read
        self.writing = ""
        self.pairs: dict[tuple[int, int, int], int] = {}
        self.active_pairs: dict[int, int] = {}
        self.load_index: dict[tuple[str, str], int] = {}
        self.size_H = 0
        self.branches: dict[str, float] = {}
        self.branch_index: dict[str, int] = {}
        self.equations: dict[str, slice] = {}  # of the joints, when forces are recorded
        self.states: dict[str, StateGroup] = {}
        self.loops = Loops(self)
        self.asked: list[int] = []  # pairs of the part that is being written
        self.followers: set[str] = set()
        self.written: dict[str, tuple[Table, tuple, tuple[int, ...], bool]] = {}
        self.combinations: dict[Combination, int] = {}
        self.values: dict[str, int] = {}
        self._bulk: list[np.ndarray] = []
        self._bulk_size = 0
        self._stored: dict[int, tuple[np.ndarray, int]] = {}

    def marker(self, name: str) -> int:
        """Return the number of "body.marker"."""
        return self.marker_index[name]

    def marker_name(self, marker: int) -> str:
        """Return "body.marker" of a number."""
        return self.marker_names[marker]

    def position(self, marker: int) -> np.ndarray:
        """Return the position (3,), m, in W of a marker as described."""
        return self.start_poses[marker][0]

    def pose(self, marker: int) -> tuple[np.ndarray, np.ndarray]:
        """Return position (3,), m, and axes (3, 3) in W of a marker as described."""
        return self.start_poses[marker]

    def surface(self, surface) -> tuple[int, int]:
        """Return the number of the marker of a surface, and where the surface begins in the bulk data."""
        if surface.name not in self.surface_places:
            self.surface_places[surface.name] = self.bulk(surface.packed)
        return self.marker(surface.marker), self.surface_places[surface.name]

    def branch(self, name: str, value: float = 0.0) -> int:
        """Return the number of the branch coordinate `name`, which begins with `value`."""
        self.branches.setdefault(name, value)
        return self.branch_index.setdefault(name, len(self.branch_index))

    def signal(self, value, rate: bool = False) -> int:
        """Return the number of a signal; `rate` if a force reads its rate too."""
        signal = as_signal(value, f"Model '{self.model.name}'", "signal")
        if signal.follows:
            raise CompileError(
                self.writing,
                found=f"a signal ({signal.word}) that follows measurements",
                expected="a function of time",
                remedy="Let an Actuator or a PointLoad follow it; a motion that depends on measured ones "
                "is a Constraint",
            )
        self.signals.append(signal)
        self.signal_titles.append(self.writing)
        if rate:
            self.rates_read.append(len(self.signals) - 1)
        return len(self.signals) - 1

    def follow(self, value, *markers: int) -> tuple[int, tuple[int, ...]]:
        """Return the number of a signal that may follow measurements, and a channel for every marker."""
        signal = as_signal(value, self.writing, "signal")
        if signal.follows:
            self.followers.add(self.writing)
        return self.loops.follow(signal, markers)

    def value(self, name: str, value) -> None:
        """Let the value of a signal be known by a name."""
        self.values[name] = self.follow(value)[0]

    def pair(self, a: int, b: int, writes: int = DAMPED, *, alone: bool = False) -> int:
        """Return the number of a pair of markers; `writes`: DAMPED, STIFF, DIRECT, or 0 for no derivatives.

        A force that has the pair `alone` may set it to 0 in evaluations in which it writes nothing.
        """
        index = self.pairs.setdefault((a, b, len(self.pairs) if alone else -1), len(self.pairs))
        if writes:
            self.active_pairs[index] = max(writes, self.active_pairs.get(index, writes))
        self.asked.append(index)
        return index

    def load(self, body: str, name: str) -> int:
        """Return the number of a load shape of a body."""
        return self.load_index.setdefault((body, name), len(self.load_index))

    def load_marker(self, body: str, name: str) -> int:
        """Return the number of a marker with one freedom, the amount of a load shape: the first row of its Jacobian."""
        marker, bodies = f"{body}.load: {name}", self.model.bodies
        if marker not in self.marker_index:
            number = next(k for k, other in enumerate(bodies) if other.name == body)
            self.start_poses.append(self.start_poses[self.marker_body.index(number)])
            self.marker_index[marker] = len(self.marker_index)
            self.marker_names.append(marker)
            self.marker_body.append(number)
            self.marker_span.append((0, bodies[number].n_velocities))
        return self.marker_index[marker]

    def combined(self, combination: Combination) -> int:
        """Return the number of a marker with one freedom, whose place is a combination of flexible coordinates."""
        if combination not in self.combinations:
            number = next(k for k, body in enumerate(self.model.bodies) if body.name == combination.body)
            name = f"{combination.body}.combination {len(self.combinations) + 1}"
            self.combinations[combination] = self.marker_index[name] = len(self.marker_index)
            self.marker_names.append(name)
            self.marker_body.append(number)
            self.marker_span.append((0, self.model.bodies[number].n_velocities))
            self.start_poses.append((np.zeros(3), np.eye(3)))
        return self.combinations[combination]

    def state_marker(self, owner: str, states: Mapping[str, float], sizes: Mapping[str, float] | None = None) -> int:
        """Return the number of the first marker whose twists are the states of `owner`, each with its start."""
        if owner not in self.states:
            group = StateGroup.of(owner, states, sizes or {}, len(self.marker_index))
            body = len(self.model.bodies) + len(self.states)
            self.states[owner] = group
            for k in range(group.markers):
                name = f"{owner}, states {EACH * k + 1}"
                self.marker_index[name] = len(self.marker_index)
                self.marker_names.append(name)
                self.marker_body.append(body)
                self.marker_span.append((0, len(group.names)))
                self.start_poses.append((np.zeros(3), np.eye(3)))
        return self.states[owner].marker

    def state_place(self, of: str, state: str | None) -> tuple[int, int]:
        """Return the marker of a state, and its component there."""
        owner, k = place_of_state(self.states, of, state, self.writing)
        return self.states[owner].marker + k // EACH, k % EACH

    def coordinate(self, body: str) -> int:
        """Return the number of the first coordinate of a body."""
        return self.first_coordinate[body]

    def reserve_H(self, size: int) -> int:
        """Return where `size` numbers begin in the workspace array H."""
        start = self.size_H
        self.size_H += size
        return start

    def couplings(self, body: str) -> int:
        """Return where the couplings of the body's blocks begin in the workspace array rows."""
        at = sum(b.n_velocities for b in self.model.bodies)
        for other in self.model.bodies:
            if other.name == body:
                break
            at += 2 * other.block_size * len(other.couplings())
        return at

    def joint(self, name: str):
        """Return the description of a joint."""
        return self.model.joint(name)

    def bulk(self, array: np.ndarray) -> int:
        """Append numbers to the bulk data and return where they begin; the same array is stored once."""
        if id(array) not in self._stored:  # the array is kept, so that no other gets its number
            self._stored[id(array)] = array, self._bulk_size
            self._bulk.append(np.ascontiguousarray(array, float).ravel())
            self._bulk_size += self._bulk[-1].size
        return self._stored[id(array)][1]

    def bulk_data(self) -> np.ndarray:
        """Return all bulk data."""
        return np.concatenate([*self._bulk, np.zeros(1)])


def _grouped(items: list[tuple[Table, tuple]]) -> tuple[list[Table], list[np.ndarray]]:
    """Return the tables and their record arrays, in order of first use."""
    tables: dict[str, tuple[Table, list[tuple]]] = {}
    for table, row in items:
        tables.setdefault(table.name, (table, []))[1].append(row)
    return [t for t, _ in tables.values()], [np.array(rows, t.row) for t, rows in tables.values()]


def _body_rows(model: Model, compiler: _Compiler, layout: Layout):
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


def _force_items(model: Model, compiler: _Compiler) -> list[tuple[Table, tuple]]:
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
    before, after = compiler.loops.rows()
    return [*before, *items, *after]


def _state_rows(compiler: _Compiler, layout: Layout):
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

    def __init__(self, model: Model, compiler: _Compiler):
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


def _markers(compiler: _Compiler, layout: Layout) -> tuple[np.ndarray, int]:
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


def _table_bytes(arrays: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return all record arrays as one byte array, each beginning at a multiple of 64, and their bounds."""
    raw = np.concatenate([*(a.view(np.uint8).ravel() for a in arrays), np.zeros(0, np.uint8)])
    bounds = np.cumsum([0] + [a.nbytes for a in arrays])
    return raw, bounds.astype(np.int64)


def compile(model: Model) -> System:
    """Return the compiled system of a model.

    Raises
    ------
    CompileError
        If the parts do not fit together.
    """
    check_kind(model, Model, "Model", "Give a flexmb.Model(bodies=[...]), or flexmb.load_model('file.toml')")
    compiler = _Compiler(model)
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
        for own, others_of_it in zip((body_tables, body_rows), more, strict=True):
            own += others_of_it
    markers, size_J = _markers(compiler, layout)
    for body in model.bodies:
        body.stiffen(compiler, markers)
    pattern, tables = sparsity(model, compiler, layout, constraints, markers)
    signals = [s.program() for s in compiler.signals]
    inputs = places_of_inputs(signals, compiler.signal_titles, prescribing)
    raw, starts = _table_bytes([*body_rows, *constraints.rows, *force_rows])
    first_force = len(body_tables) + len(constraints.tables)
    switch_kinds, switch_owners = switches_of(model, force_tables, force_rows, starts[first_force:], compiler.loops)
    program = Program(
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
    return System(
        model=model,
        program=program,
        q0=np.concatenate([layout.q, list(compiler.branches.values())]),
        u0=layout.u,
        n_signals=len(compiler.signals),
        n_loads=len(compiler.load_index),
        n_channels=compiler.loops.n_channels,
        implicit=compiler.loops.follows_accelerations,
        samples_reactions=compiler.loops.follows_reactions,
        values=compiler.values,
        size_J=size_J,
        size_H=compiler.size_H,
        tables={"markers": markers, **tables},
        marker_index={
            name: k for name, k in compiler.marker_index.items() if compiler.marker_body[k] < len(model.bodies)
        },
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
        switch_kinds=switch_kinds,
        switch_owners=switch_owners,
        lengths=unit_lengths(len(model.bodies), len(constraints.names)),
        units=np.ones(layout.iu[-1]),
    )
