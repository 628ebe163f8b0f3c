"""`System`: the compiled model. It is constant; what an evaluation writes lives in a workspace, one per thread."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flexmb.math.energies import Energy
from flexmb.math.tables import State, Work
from flexmb.math.weights import Weights
from flexmb.model.model import Model
from flexmb.model.primitives import Equation
from flexmb.system.holds import Hold
from flexmb.system.lengths import Lengths
from flexmb.system.program import Program
from flexmb.system.signal_times import SignalTimes
from flexmb.system.states import StateGroup, place_of_state

__all__ = ["System"]


@dataclass(frozen=True, kw_only=True, eq=False)
class System:
    """A compiled model: offsets, record tables and kernels.

    Parameters
    ----------
    model : Model
    program : Program
        Constant input of the compiled evaluation.
    q0, u0 : (nq,), (nu,)
        Configuration and velocity as described (before assembly).
    tables : dict of arrays
        Prototypes of the record tables of a workspace, and positions in the iteration matrix.
    n_pairs : int
        Of the pairs of markers those that kernels write to; behind them are pairs that only the pattern needs.
    marker_index, joint_index, force_index : dict of name to number
    load_index : mapping of (body, load shape) to number
    force_rows : (nf, 3)
        Kind, first and last byte of the row of every force.
    equation_names : tuple of str
        "joint: primitive" of every equation.
    equation_owners : tuple of (int, Equation)
        Number of the joint, and the primitive, of every equation.
    joint_equations : dict of joint name to slice
    body_slices : dict of body name to (slice of q, slice of u)
    states : tuple of StateGroup
        First-order states of forces and blocks.
    state_slices : dict of owner to (slice of q, slice of u)
        Where their integrals and they themselves stand.
    values : dict of sensor name to int
        Numbers of the signals whose values sensors read.
    branch_names : tuple of str
        What the last coordinates of q count: full turns of a joint, the place on a curve (see `keep_branches`).
    sizes : (ng,), optional
        What multipliers are measured by where some are not unique.
    redundant : tuple of int
        Equations that depend on others at the assembled configuration.
    indeterminate : tuple of int
        Equations whose multipliers are not unique there: these, and those that they depend on.
    gaps : (ng,), m or rad
        How far equations may stay open at the start because they depend on each other; zero if none does.
    misfits : dict of joint name to (float, float), m and rad
        What they do leave open, because they contradict each other within the digits of a mesh.
    signal_times : SignalTimes
        When signals of forces and drives are not smooth, or change fast.
    prescribing : slice
        The signals that drives prescribe.
    rates_read : (n,) int
        These, and the signals whose rates forces read: where rates jump, accelerations do.
    inputs : dict of name to (n,) int
        Where the values of inputs stand in ``program.signals.args``.
    holds : tuple of Hold
        Blocks that hold values, whose jumps are found from outside.
    switch_kinds : (nk, 5)
        Address, first and last byte of the rows, and number of switches of the kinds of forces with a kink.
    switch_owners : tuple of str
        Title of the force or block of every switch.
    unlocated : tuple of str
        Sentences about kinks of signals that steps may pass over.
    lengths : Lengths
        What distances and residuals are compared with; all 1 m before assembly.
    implicit : bool
        Forces may follow accelerations: these have their share in the mass matrix.
    samples_reactions : tuple of str
        Joints whose reactions samplers read.
    units : (nu,), 1/m or 1
        Makes increments of velocities comparable: displacements relative to the length of the assembly, and radians.
    least_inertia : (nu,), kg or kg m2
        With which equations are at least judged, by the arms of joints (`needles.least_inertia`); 0 before assembly.
    """

    model: Model
    program: Program
    q0: np.ndarray
    u0: np.ndarray
    n_signals: int
    n_loads: int
    n_channels: int
    implicit: bool = False
    samples_reactions: tuple[str, ...] = ()
    n_pairs: int
    size_J: int
    size_H: int
    tables: dict[str, np.ndarray]
    marker_index: dict[str, int]
    joint_index: dict[str, int]
    force_index: dict[str, int]
    force_rows: np.ndarray
    equation_names: tuple[str, ...]
    equation_owners: tuple[tuple[int, Equation], ...]
    joint_equations: dict[str, slice]
    joints: tuple[Any, ...]
    gaps: np.ndarray
    body_slices: dict[str, tuple[slice, slice]]
    signal_times: SignalTimes
    prescribing: slice
    rates_read: np.ndarray
    lengths: Lengths
    units: np.ndarray
    least_inertia: np.ndarray
    switch_kinds: np.ndarray
    switch_owners: tuple[str, ...] = ()
    unlocated: tuple[str, ...] = ()
    values: Mapping[str, int] = field(default_factory=dict)
    inputs: Mapping[str, np.ndarray] = field(default_factory=dict)
    load_index: Mapping[tuple[str, str], int] = field(default_factory=dict)
    states: tuple[StateGroup, ...] = ()
    holds: tuple[Hold, ...] = ()
    state_slices: Mapping[str, tuple[slice, slice]] = field(default_factory=dict)
    branch_names: tuple[str, ...] = ()
    redundant: tuple[int, ...] = ()
    indeterminate: tuple[int, ...] = ()
    sizes: np.ndarray | None = None
    misfits: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __repr__(self):
        return f"System({self.model!r}: {self.nq} coordinates, {self.nu} velocities, {self.ng} equations)"

    @property
    def nq(self) -> int:
        """Number of coordinates."""
        return len(self.q0)

    @property
    def nu(self) -> int:
        """Number of velocities."""
        return len(self.u0)

    @property
    def ng(self) -> int:
        """Number of constraint equations."""
        return len(self.equation_names)

    @property
    def slices(self) -> dict[str, tuple[slice, slice]]:
        """Where bodies, and then owners of states, stand in q and u: in the order of their numbers."""
        return {**self.body_slices, **self.state_slices}

    def has_frame(self, name: str) -> bool:
        """Is it a body with a frame?"""
        return name in self.body_slices and bool(self.model.body(name).has_frame)

    def place_of_state(self, of: str, state: str | None, asker: str) -> tuple[str, int]:
        """Return the owner of a state, and its number there; ModelError, naming the asker, if there is none."""
        return place_of_state({group.title: group for group in self.states}, of, state, asker)

    @property
    def is_state(self) -> np.ndarray:
        """Which velocities are first-order states, (nu,) of bool."""
        found = np.zeros(self.nu, bool)
        for _, span in self.state_slices.values():
            found[span] = True
        return found

    @property
    def state_sizes(self) -> np.ndarray:
        """Values of the states, in their order, up to which errors are absolute."""
        return np.array([size for group in self.states for size in group.size])

    def bounds(self, tolerance: float) -> np.ndarray:
        """Return the residuals (ng,), m or rad, up to which equations count as satisfied: never less than rounding."""
        lengths = self.lengths
        return np.maximum(tolerance * lengths.equations, np.where(lengths.are_lengths, lengths.rounding, 0.0))

    def drift_bounds(self, drift: float) -> np.ndarray:
        """Return the residuals (ng,), m or rad, at which a moving state is put back on the constraints.

        Lengths are compared with the largest body that the equation relates, not with the assembly: bars of 1 m are
        held as closely in a row of four hundred as in one of two. Ten times the rounding of positions can be reached.
        """
        lengths, whole = self.lengths, self.bounds(drift)
        own = np.maximum(drift * lengths.related, 10.0 * lengths.rounding)
        return np.where(lengths.are_lengths, np.minimum(own, whole), whole)

    @property
    def multiplier_weights(self) -> np.ndarray:
        """Weights of the multipliers in the norm that is least where equations are dependent."""
        weight = self.sizes
        return weight / weight.max() if weight is not None and np.any(weight > 0.0) else np.ones(self.ng)

    def workspace(self) -> Work:
        """Return new scratch arrays for one thread."""
        tables = self.tables
        return Work(
            markers=tables["markers"].copy(),
            J=np.zeros(max(1, self.size_J)),
            H=np.zeros(max(1, self.size_H)),
            equations=tables["equations"].copy(),
            legs=tables["legs"].copy(),
            pairs=tables["pairs"][: self.n_pairs].copy(),
            residual=np.zeros(self.nu),
            S=np.zeros(int(self.program.pattern.row_start[-1])),
            rows=tables["rows"],
            transposed=tables["transposed"],
            pair_rows=tables["pair_rows"],
            branches=np.zeros(len(self.branch_names)),
            weights=Weights.table(),
            energy=Energy.table(),
            loads=np.zeros(max(1, self.n_loads)),
            channels=np.zeros((1 + self.n_channels, 6)),  # never empty; more than one row: some load follows
        )

    def state(self, t=0.0, q=None, u=None, a=None, lam=None) -> State:
        """Return a state with arrays of its own; what is not given is the described start, or zero.

        Branches come last in q, the branches of sensors after all others. So a state of the same model with other
        sensors fits.
        """

        def array(value, size):
            return np.zeros(size) if value is None else np.array(value, float)

        full = np.array(self.q0 if q is None else q, float)
        if len(full) != self.nq and len(full) >= self.program.branches:
            full = np.concatenate([full[: self.nq], self.q0[len(full) :]])
        return State(
            t=float(t),
            q=full,
            u=np.array(self.u0 if u is None else u, float),
            a=array(a, self.nu),
            lam=array(lam, self.ng),
            signals=np.zeros((max(1, self.n_signals), 3)),
        )

    def own_copy(self) -> System:
        """Return the system with scratch space of its own, for use in another thread."""
        pattern = self.program.pattern
        pattern = pattern._replace(scratch=pattern.scratch.copy())
        return replace(self, program=self.program._replace(pattern=pattern))

    def owner(self, unknown: int) -> str:
        """Return the title of the body or the name of the equation to which an unknown belongs."""
        if unknown >= self.nu:
            return f"Equation '{self.equation_names[unknown - self.nu]}'"
        for body in self.model.bodies:
            span = self.body_slices[body.name][1]
            if span.start <= unknown < span.stop:
                return f"{body.title}, {_freedom(body, unknown - span.start)}"
        for group in self.states:
            span = self.state_slices[group.title][1]
            if span.start <= unknown < span.stop:
                return f"{group.title}, state '{group.names[unknown - span.start]}'"
        return f"Unknown {unknown}"

    def is_turn(self, unknown: int) -> bool:
        """Is a velocity the angular velocity of a frame?"""
        return any(3 <= unknown - iu < 6 for _, iu in self.program.frames[:, :2])


def _freedom(body, k: int) -> str:
    """Return the k-th velocity of a body in words."""
    if body.has_frame and k < 6:
        return f"{'rotation about' if k >= 3 else 'translation along'} its {'xyz'[k % 3]}-axis"
    k -= 6 * body.has_frame
    if body.reduced is not None:
        return f"mode {k + 1}"
    if body.n_vector == 3:
        return f"translation along {'xyz'[k]}"
    return f"node {k // body.block_size + 1}" if body.block_size < body.n_vector else f"coordinate {k + 1}"
