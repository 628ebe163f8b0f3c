"""`ModelCompiler`: what the parts of a model write themselves into."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from weakref import proxy

import numpy as np

from flexmb.constraints import Combination
from flexmb.errors import CompileError
from flexmb.math.tables import DAMPED
from flexmb.model.model import Model
from flexmb.model.signal import as_signal
from flexmb.model.table import Table
from flexmb.system.loops import Loops
from flexmb.system.states import EACH, StateGroup, place_of_state

__all__ = ["ModelCompiler"]


class ModelCompiler:
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
        self.loops = Loops(proxy(self))  # no circle, which would keep all bulk data until garbage is searched for
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

    def span(self, marker: int) -> tuple[int, int, int]:
        """Return the number of the body that moves a marker, the first of its velocities that do, and how many."""
        return self.marker_body[marker], *self.marker_span[marker]

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
                remedy="Let an Actuator or a PointLoad follow it; a motion that depends on measured ones is a "
                "Constraint, or the motion of a heavy body which an Actuator moves, passed on by a Coupler",
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
