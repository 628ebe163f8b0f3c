"""`RelativeUnknowns`: the joint coordinates of a tree as what an integrator solves for."""

from __future__ import annotations

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.energies import powers
from flexmb.math.jets import sample_signals
from flexmb.math.tables import State
from flexmb.system.branches import Followed
from flexmb.system.program import keep_branches
from flexmb.tree.coordinates.joint_tree import JointTree
from flexmb.tree.coordinates.motions import HINGED, POINTS
from flexmb.tree.coordinates.passes import read_second_rates
from flexmb.tree.coordinates.settle import coordinate_rates, count_turns, move, new_chart, prescribe, unit_length
from flexmb.tree.rigid.link_tree import LinkTree
from flexmb.tree.rigid.motion import link_rates

__all__ = ["RelativeUnknowns"]


class RelativeUnknowns:
    """Joint coordinates x (nx,) and rates v (nv,) of a system, as unknowns of an integrator.

    Bodies are placed through their joints, which therefore cannot open; drives of tree joints are followed exactly.
    Only equations of cut joints are left to be closed.

    Attributes
    ----------
    tree : JointTree
    closes : bool
        Does the evaluation after a step matter: for cut joints, or to count their turns?
    links : LinkTree or None
        The model as links, if it is one of points, rigid and reduced bodies.
    recursion : str
        "links", or "bodies" and why not the passes over links.
    """

    def __init__(self, system, state: State, work, cut: tuple[str, ...] = ()):
        self.system, self.work = system, work
        self.tree = tree = JointTree.of(system, state, tuple(cut))
        self.nx, self.nv = len(tree.names), len(tree.rate_names)
        self._followed = Followed(system, state, work)
        self.chart = new_chart(tree, state.q, self._followed)
        self.closes = bool(len(tree.tree.tables.cut_equations)) or len(tree.counted) < len(self.chart.branches)
        self.turns, self.balls = _angles(tree.rows)
        self.links, self.recursion = _links(tree, self.chart)
        self._scratch = np.zeros(self.nv)

    def vectors(self) -> list[tuple[int, int, int, int]]:
        """Return (coordinate, rate, velocity of the system, count) of modes and points: where each begins."""
        found = []
        for row in self.tree.rows[self.tree.rows["modes"] > 0]:
            frame = 0 if row["held"] == POINTS else 6
            own, rates = row["iq"] + row["coordinates"], row["iv"] + row["rates"]
            found.append((int(own), int(rates), int(row["u"]) + frame, int(row["modes"])))
        return found

    def of(self, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return x, v and the second rates of a state."""
        own = self.tree.read(state, self.work)
        return own.q, own.v, own.a

    def state(self, t: float, x: np.ndarray, v: np.ndarray) -> State:
        """Return the state of all bodies, without accelerations; x and v get unit Euler parameters and the drives."""
        system = self.system
        state = system.state(t)
        chart = self.chart
        unit_length(chart.rows, x)
        self._drive(t, x, v, self._scratch)
        move(chart.rows, system.program, self.work, chart.start, x, v, state)
        count_turns(chart, system.program, t, x, state.q)
        return state

    def _drive(self, t: float, x: np.ndarray, v: np.ndarray, a: np.ndarray) -> None:
        """Write the motion of the drives at time t."""
        chart = self.chart
        if len(chart.driven):
            sample_signals(t, chart.signals, chart.sampled)
            prescribe(chart.driven, chart.sampled, x, v, a)

    def reached(self, state: State, x: np.ndarray, v: np.ndarray, drifted: bool) -> tuple[np.ndarray, np.ndarray]:
        """Return the unknowns of a state that has been reached, and count turns from it; it has just been evaluated.

        If it has `drifted` off the constraints, and was put back, x and v are those before that.
        """
        keep_branches(self.system.program, self.work, state.q)
        self._followed.reached(state.t, self.work.branches)
        if not drifted:
            return x, v
        q, v, _ = self.of(state)
        q[self.turns] += 2.0 * np.pi * np.round((x - q)[self.turns] / (2.0 * np.pi))
        for at in self.balls:
            q[at : at + 4] *= np.copysign(1.0, q[at : at + 4] @ x[at : at + 4])
        return q, v

    def rates(self, t: float, x: np.ndarray, v: np.ndarray, solve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return x', v' and the powers (3,) of loads and drives; `solve` writes the accelerations of a state.

        Rigid and reduced bodies take the passes in link axes.
        """
        change, a = np.zeros(self.nx), np.zeros(self.nv)
        x, v = x.copy(), v.copy()
        if self.links is not None:
            if link_rates(self.links, self.work, t, x, v) >= 0:
                raise ValueError("a motion without inertia")
            x, v, a, power = (part.copy() for part in (self.links.x, self.links.v, self.links.a, self.links.powers))
        else:
            state = self.state(t, x, v)
            solve(state)
            read_second_rates(self.tree.rows, state, self.work, v, a)
            a[self.chart.driven[:, 1]] = self.chart.sampled[:, 2]
            power = powers(self.work.energy)
        coordinate_rates(self.tree.rows, x, v, change)
        return change, a, power


def _links(tree: JointTree, chart) -> tuple[LinkTree | None, str]:
    """Return the model as links in axes of their own, if all its motions have inertia; and what was chosen."""
    if not tree.rate_names:
        return None, "bodies: nothing moves"
    if tree.system.implicit:
        return None, "bodies: forces follow accelerations"
    try:
        return tree.linked(chart), "links"
    except CompileError as error:
        return None, f"bodies: {error.part}: {error.found}"


def _angles(rows) -> tuple[np.ndarray, list[int]]:
    """Return the places of all angles among the coordinates, and where the Euler parameters of balls begin."""
    turns = [
        int(row["iq"] + row[name])
        for row in rows
        if row["held"] == HINGED
        for name in ("turn", "turn_b")
        if row[name] >= 0
    ]
    balls = [int(row["iq"] + row["ball"]) for row in rows if row["held"] == HINGED and row["ball"] >= 0]
    return np.array(turns, np.int64), balls
