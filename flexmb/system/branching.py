"""Where motions branch: configurations with more instantaneous freedoms than finite ones.

In a singular configuration (a folded chain, a flat toggle, links in one line) equations depend on each other that do
not depend anywhere near it: velocities are possible that no motion follows. What is permanent, a loop of revolute
joints, is not singular. Both are told apart by a short step along a velocity that the equations permit: beside a
regular place the same equations are dependent, and closing them again changes the step by a part as small as the step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import null_space

from flexmb.errors import CompileError
from flexmb.math.weights import no_matrix, weigh_mass
from flexmb.system.mobility import constraint_matrix, dependent_equations, indeterminate_equations
from flexmb.system.program import advance, evaluate, increment
from flexmb.system.projection import project
from flexmb.system.system import System

__all__ = ["STEP", "Branching", "Neighbourhood", "branching", "require_motion_to_begin"]

STEP = 1e-2
"""Length of the step, relative to the assembly, or rad."""
SHORT = 1e-3
"""A shorter one, tried first: soft bodies bend within the other so much that closing changes it, a regular place or
not, while beside a singular place the part that is changed does not fall with the step."""
BENT = 0.1
"""Part of a step that closing may change beside a regular configuration."""
DIRECTIONS = 12
"""Most velocities tried to count finite freedoms."""
BOUND = 1e-10
"""Residual of the constraints, relative to lengths, at which closing ends."""
NONE = 1e-6
"""Part of a wished velocity, below which what the equations leave of it is rounding."""
CLOSED = 1e-2
"""Largest residual after a step, relative to its square, by which equations open along it in a singular place."""
MOST = 5000
"""Equations of a model beyond which it is not looked at: every step costs as much as its assembly."""
SMALL = 800
"""Equations up to which the joints of the extra self-stress are told apart from others."""


class Branching(NamedTuple):
    """A singular configuration.

    instantaneous, finite : int, freedoms of velocities, and of motions
    joints : tuple of str, those whose equations depend on each other here and not beside
    """

    instantaneous: int
    finite: int
    joints: tuple[str, ...]

    def __str__(self) -> str:
        joints = ", ".join(f"'{name}'" for name in self.joints) or "the joints of its loops"
        return (
            f"a singular configuration: {self.instantaneous} instantaneous freedoms, {self.finite} of motions; "
            f"there depend on each other: {joints}"
        )


class Neighbourhood:
    """Steps from a state back onto the constraints."""

    def __init__(self, system: System, state, work):
        self.system, self.state, self.work = system, state, work
        self.right = np.zeros(system.nu + system.ng)
        self.bounds = np.maximum(BOUND * system.lengths.equations, system.bounds(0.0))
        body = [s for b in system.model.bodies if b.has_frame for s in [system.body_slices[b.name][1]]]
        self.moves = np.zeros(system.nu, bool)
        for span in body:
            self.moves[span.start : min(span.start + 6, span.stop)] = True
        if not np.any(self.moves):
            self.moves[:] = ~system.is_state

    def velocity(self, wish: np.ndarray) -> np.ndarray | None:
        """Return the velocity nearest to a wish that the equations permit at rest, of unit size; None if none is."""
        found = []
        for u in (wish, np.zeros(self.system.nu)):
            state = self.at(self.state.q, u)
            self._project(state)
            found.append(state.u)
        change = found[0] - found[1]
        size, wished = (float(np.max(np.abs(x * self.system.units))) for x in (change, wish))
        return change / size if size > NONE * wished else None

    def any_velocity(self, rng) -> np.ndarray | None:
        """Return a random velocity that the equations permit, of bodies with frames where they can move; or None."""
        wish = rng.normal(size=self.system.nu) / self.system.units
        framed = self.velocity(np.where(self.moves, wish, 0.0))
        return self.velocity(wish) if framed is None else framed

    def closed(self, change: np.ndarray, t: float):
        """Return the state after a change of the configuration, closed again, or None; and what closing changed of it.

        The second number is the size of what was changed over the size of the change; the third all that changed.
        """
        system = self.system
        state = self.at(self.state.q, np.zeros(system.nu), t)
        advance(system.program, self.state.q, change, 1.0, state.q)
        self._project(state)
        no_matrix(self.work.weights)
        evaluate(system.program, state, self.work)
        g = np.where(system.program.equation_level == 0, np.abs(self.work.equations["g"]), 0.0)
        size = float(np.max(np.abs(change * system.units)))
        if not np.all(g <= np.maximum(CLOSED * size * size * system.lengths.equations, self.bounds)):
            return None, np.inf, change
        reached = np.zeros(system.nu)
        increment(system.program, self.state.q, state.q, reached)
        length = np.linalg.norm(change * system.units)
        return state, float(np.linalg.norm((reached - change) * system.units) / length), reached

    def _project(self, state) -> None:
        system = self.system
        project(system.program, state, self.work, self.right, state.q, self.bounds, system.gaps, system.units, 60)

    def moving(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return the velocity nearest to `u` that the equations permit at the closed configuration `q`."""
        state = self.at(q.copy(), u.copy())
        self._project(state)
        return state.u

    def dependent(self, state) -> tuple[int, ...]:
        """Return the equations that depend on others at a state."""
        M, G = self.matrices(state)
        return tuple(int(k) for k in dependent_equations(self.system, M, G))

    def matrices(self, state):
        """Return the mass matrix and the gradient at a state."""
        system, work = self.system, self.work
        weigh_mass(work.weights)
        program = system.program
        bare = program._replace(regularisation=np.zeros(system.ng), floor=np.zeros(len(program.floor)))
        evaluate(bare, state, work)
        return constraint_matrix(system, work)

    def at(self, q, u, t: float | None = None):
        """Return a state of the system."""
        return self.system.state(self.state.t if t is None else t, q, u)


def branching(system: System, state, work) -> Branching | None:
    """Return how motions branch at an assembled state, None where it is regular."""
    if not system.redundant or system.ng > MOST:
        return None
    near, rng = Neighbourhood(system, state, work), np.random.default_rng(0)
    here = near.dependent(near.at(state.q, np.zeros(system.nu)))
    freedoms = system.nu - system.ng + len(here)
    if not freedoms or not here:
        return None

    def step(size: float):
        way = near.any_velocity(rng)
        return None if way is None else near.closed(size * way, state.t)

    for size in (SHORT, STEP):
        first = step(size)
        if first is None:  # what is free is not seen in the velocities tried: nothing can be said
            return None
        beside, changed, _ = first
        if beside is not None and changed <= BENT and len(near.dependent(beside)) == len(here):
            return None
    found, reached = [] if beside is None else [beside], []
    for other, _, way in filter(None, (step(STEP) for _ in range(min(freedoms + 2, DIRECTIONS)))):
        reached.append(np.zeros(system.nu) if other is None else way * system.units / STEP)
        if other is not None:
            found.append(other)
    counts = [len(near.dependent(other)) for other in found]
    least = min(counts, default=len(here))
    if least < len(here):
        finite = system.nu - system.ng + least
    else:  # of more freedoms than were tried, those that were not reached are not missed
        held = int(np.sum(np.linalg.svd(np.array(reached), compute_uv=False) > BENT))
        finite = freedoms - max(0, min(freedoms, len(reached)) - held)
    if finite >= freedoms:
        return None
    return Branching(freedoms, finite, _joints(near, here, found[counts.index(least)] if counts else None))


def _joints(near: Neighbourhood, here, other) -> tuple[str, ...]:
    """Return the joints in the states of self-stress that a state has, and another beside it has not (or all)."""
    system, names = near.system, near.system.equation_names
    at = near.at(near.state.q, np.zeros(system.nu))
    M, gradient = near.matrices(at)
    chosen = {names[k].rpartition(": ")[0] for k in indeterminate_equations(M, gradient, here)}
    if other is not None and system.ng <= SMALL:
        scale = system.lengths.equations
        G, G1 = (near.matrices(state)[1].toarray() / scale[:, None] / system.units for state in (at, other))
        Y = null_space(G.T, rcond=1e-6)
        if Y.shape[1]:
            shares = Y @ np.linalg.svd(Y.T @ G1)[0][:, 0]
            own = np.flatnonzero(np.abs(shares) > BENT * np.max(np.abs(shares)))
            chosen = {names[k].rpartition(": ")[0] for k in own}
    return tuple(joint.name for joint in system.model.joints if joint.name in chosen)


def require_motion_to_begin(system: System, state, work) -> list[str]:
    """Raise CompileError where no motion has the velocity and acceleration of a singular start; tell of other ones.

    At a regular state closing the equations changes a short step along u t + a t^2/2 by a part as small as the step. At
    a singular one the accelerations belong to more freedoms than there are: forces would have to be infinite to
    guide the motion, or nothing decides which branch it takes.
    """
    found = branching(system, state, work)
    if found is None:
        return []
    remedy = (
        f"Start beside it: flexmb.disturbed(model) moves the bodies by {STEP:g} of its size along a velocity, "
        "onto one of the branches; or give positions some tenths of a degree away"
    )
    speed, rate = (float(np.max(np.abs(x * system.units), initial=0.0)) for x in (state.u, state.a))
    if speed or rate:
        h = min(STEP / speed if speed else np.inf, np.sqrt(2.0 * STEP / rate) if rate else np.inf)
        near = Neighbourhood(system, state, work)
        _, changed, _ = near.closed(h * state.u + 0.5 * h * h * state.a, state.t + h)
        if changed > BENT:
            raise CompileError(
                f"Model '{system.model.name}'",
                found=f"the start is {found}; its accelerations belong to none of the motions (closing the joints "
                f"changes the first step by {100.0 * min(changed, 1.0):.0f} %)",
                expected="a start from which one motion goes on",
                remedy=remedy,
            )
    return [
        f"Model '{system.model.name}': the start is {found}. A motion goes on from it; small differences decide which "
        f"branch it takes. {remedy}"
    ]
