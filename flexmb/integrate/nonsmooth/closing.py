"""The way back of a step onto the positions: joints are closed, and what has struck comes out of its penetration.

Source: Acary 2013 (projection).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.integrate.alpha.world_translation import to_body_axes, turn
from flexmb.integrate.nonsmooth.apart import TOUCHING
from flexmb.integrate.nonsmooth.points import Touching
from flexmb.integrate.nonsmooth.problem import new_problem, sweep, write_problem
from flexmb.integrate.nonsmooth.stepping import open_equations
from flexmb.math.block_substitution import lu_solve
from flexmb.math.weights import no_matrix
from flexmb.system.program import advance, evaluate, keep_branches

__all__ = ["Closing", "in_body_axes", "place"]

CLOSED = 1e-10
"""What joints may be open at the end of a step, relative to the largest body of an equation."""
CLOSINGS = 12
PUSHES = 60
"""Sweeps in which penetrations are taken back: what is left is taken back in the next step."""


def in_body_axes(world: np.ndarray, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return velocities (nu,) in body axes, of those in the axes of the run: frames of `world` in W."""
    if not len(world):
        return u.copy()
    out = np.empty(len(u))
    to_body_axes(world, q, u, np.zeros(len(u)), out, np.empty(len(u)))
    return out


def place(system, work, world: np.ndarray, t: float, q: np.ndarray, u: np.ndarray) -> None:
    """Evaluate a state without a matrix; velocities in the axes of the run."""
    no_matrix(work.weights)
    evaluate(system.program, system.state(t, q, in_body_axes(world, q, u)), work)


@dataclass(frozen=True)
class Closing:
    """What closes the ends of steps; `work` holds the matrix of the step, factorized.

    parts: of the matrix; world: frames (n, 2) that are integrated in world axes
    """

    system: Any
    work: Any
    parts: Any
    world: np.ndarray
    touching: Touching

    def closed(
        self, t: float, q: np.ndarray, u: np.ndarray, struck: np.ndarray, deep: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return positions with closed joints and without penetration, and velocities that the joints permit.

        Only contacts whose keys are in `struck` are pushed apart, where one is deeper than `deep` (m).
        """
        system, program, work = self.system, self.system.program, self.work
        right = np.zeros(system.nu + system.ng)
        bounds = system.drift_bounds(CLOSED) if system.ng else np.zeros(0)
        for turn_ in range(CLOSINGS):
            place(system, work, self.world, t, q, u)
            open_equations(program, work, in_body_axes(self.world, q, u), right, False)
            off = bool(np.any(np.abs(right[system.nu :]) > bounds))
            overlaps = self._overlapping(struck, deep) if turn_ < 2 and self.touching.forces else None
            if not off and overlaps is None:
                break
            lu_solve(work.S, program.pattern, right)
            if overlaps is not None:
                self._push_apart(overlaps, right)
            keep_branches(program, work, q)
            advance(program, q.copy(), right[: system.nu], 1.0, q)
        if system.ng:
            for _ in range(CLOSINGS):
                place(system, work, self.world, t, q, u)
                body = in_body_axes(self.world, q, u)
                open_equations(program, work, body, right, True)
                if np.all(np.abs(right[system.nu :]) <= bounds):
                    break
                lu_solve(work.S, program.pattern, right)
                body += right[: system.nu]
                turn(self.world, q, body)
                u = body
        return q, u

    def _overlapping(self, struck: np.ndarray, deep: float):
        """Return the normal problem of points that are to be pushed apart; None if no penetration counts."""
        points = self.touching.found(self.work, 0.0, 0.1 * self.touching.small)
        if not len(points) or not np.any(points["gap"] < -deep):
            return None
        problem = new_problem(points, self.work, self.parts, True)
        write_problem(problem, self.work, self.work.S, self.system.program.pattern, self.parts)
        problem.shift[:] = points["gap"]
        problem.active[:] = np.isin(points["key"], struck) & (problem.D[::36] > 0.0)
        if not np.any((points["gap"] < -deep) & (problem.active == 1)):
            return None
        return problem

    def _push_apart(self, problem, x: np.ndarray) -> None:
        """Add the least displacement that opens all penetrations to `x`."""
        for k in range(PUSHES):
            change, _ = sweep(problem, self.parts, x, k % 2 == 1)
            if change <= 0.1 * TOUCHING * self.touching.small:
                break
