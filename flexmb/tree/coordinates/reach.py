"""Inverse kinematics: joint coordinates that bring a marker to a pose, by damped least squares within limits.

Levenberg 1944 and Marquardt 1963 on the error (way and rotation vector); coordinates that would leave their limits are
held there, and the step is taken again without them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.math.rotations import advance_frame, log_euler, matrix_to_euler
from flexmb.model.pose import Pose
from flexmb.tree.coordinates.motions import FREE, HINGED

__all__ = ["reach"]

ITERATIONS = 200
STARTS = 12
"""Starting points that are tried: the given one, then others within the limits, always the same ones."""
LEAST = 1e-14
"""Damping, relative, at which a step that gains nothing ends the search."""


def _rotation_vector(R: np.ndarray) -> np.ndarray:
    p, theta = np.empty(4), np.empty(3)
    matrix_to_euler(np.ascontiguousarray(R), p)
    log_euler(p, theta)
    return theta


def advanced(tree, q: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Return relative coordinates q (nq,) moved by an increment (nv,) of the rates:
    Euler parameters on their sphere.
    """
    out = q.copy()
    for row in tree.rows:
        iq, iv, rates, own = (int(row[name]) for name in ("iq", "iv", "rates", "coordinates"))
        if row["held"] == FREE:
            advance_frame(q[iq : iq + 7], step[iv : iv + 6], 1.0, out[iq : iq + 7])
        elif row["held"] == HINGED and row["ball"] >= 0:
            ball = int(row["ball"])
            out[iq : iq + ball] += step[iv : iv + ball]
            frame, moved = np.concatenate([np.zeros(3), q[iq + ball : iq + ball + 4]]), np.empty(7)
            advance_frame(frame, np.concatenate([np.zeros(3), step[iv + ball : iv + ball + 3]]), 1.0, moved)
            out[iq + ball : iq + ball + 4] = moved[3:]
        else:
            out[iq : iq + own] += step[iv : iv + own]
        out[iq + own : iq + own + row["modes"]] += step[iv + rates : iv + rates + row["modes"]]
    return out


class _Search:
    """What the search for a pose knows: the marker, its aim, which rates may move, and the limits of coordinates."""

    def __init__(self, tree, marker: str, aim: Pose, orientation: bool, limits: Mapping[str, Any]):
        self.tree, self.marker, self.aim, self.orientation = tree, marker, aim, orientation
        J = tree.jacobian(marker, tree.start.q)
        driven = {tree.rate_places[name] for name in tree.drives}
        self.rates = np.array(
            [
                k
                for row in tree.rows
                if row["held"] == HINGED
                for k in range(row["iv"], row["iv"] + row["rates"])
                if k not in driven and np.any(J[:, k])
            ],
            int,
        )
        if not len(self.rates):
            raise ModelError(
                "JointTree",
                found=f"no joint moves marker '{marker}'",
                expected="a joint with freedoms between it and the ground",
                remedy="Name another marker",
            )
        self.low, self.high = (np.full(len(tree.rate_names), x) for x in (-np.inf, np.inf))
        self.q_of = {
            tree.rate_places[name]: k
            for k, name in enumerate(tree.names)
            if name in tree.rate_names and "ball_" not in name
        }
        for name, (low, high) in limits.items():
            place = tree.index(name)
            rate = next((k for k, i in self.q_of.items() if i == place), None)
            if rate is None or not low < high:
                raise ModelError(
                    "JointTree",
                    found=f"limits of '{name}': {low!r} to {high!r}",
                    expected="a turn or slide with a lower limit below the upper one",
                    remedy="Write limits={'A.turn': (-1.5, 1.5)}; balls have no limits",
                )
            self.low[rate], self.high[rate] = low, high
        self.length = max(1e-9, float(np.linalg.norm(J[:3, self.rates], axis=0).max(initial=0.0)))

    def error(self, q: np.ndarray) -> np.ndarray:
        """Return way (m) and rotation vector times a length (m) from the marker to its aim."""
        r, R = self.tree.pose(self.marker, q)
        way = np.asarray(self.aim.at) - r
        turn = self.length * (R @ _rotation_vector(R.T @ self.aim.matrix)) if self.orientation else np.zeros(3)
        return np.concatenate([way, turn])

    def room(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return how far each rate may move down and up."""
        low, high = np.full(len(self.low), -np.inf), np.full(len(self.low), np.inf)
        for rate, place in self.q_of.items():
            low[rate], high[rate] = self.low[rate] - q[place], self.high[rate] - q[place]
        return low, high

    def step(self, J: np.ndarray, error: np.ndarray, damping: float, room) -> np.ndarray:
        """Return the damped step (nv,); rates at their limits that would go on are held."""
        moving, step = list(self.rates), np.zeros(len(self.low))
        while moving:
            A = J[:, moving]
            x = A.T @ np.linalg.solve(A @ A.T + damping * np.eye(6), error - J @ step)
            below, above = room[0][moving] - x, x - room[1][moving]
            worst = int(np.argmax(np.maximum(below, above)))
            if max(below[worst], above[worst]) <= 0.0:
                step[moving] = x
                break
            rate = moving.pop(worst)
            step[rate] = room[0][rate] if below[worst] > above[worst] else room[1][rate]
        return step

    def descend(self, q: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the coordinates where the error from a starting point is least, and that error.

        One step more is taken behind the tolerance: near singular poses a small error of the pose is a large one of the
        coordinates, and the last step, quadratic, costs nothing else.
        """
        error, damping, reached = self.error(q), 1e-3, False
        for _ in range(ITERATIONS):
            if reached:
                break
            reached = bool(np.linalg.norm(error) <= tolerance)
            damping = LEAST if reached else damping
            J = self.tree.jacobian(self.marker, q)
            J[3:] *= self.length if self.orientation else 0.0
            unit = max(np.einsum("ij,ij->", J, J), 1e-300)
            while damping < 1e8:
                there = advanced(self.tree, q, self.step(J, error, damping * unit, self.room(q)))
                other = self.error(there)
                if np.linalg.norm(other) < np.linalg.norm(error) * (1.0 - LEAST):
                    break
                damping *= 8.0
            else:
                break
            q, error, damping = there, other, max(damping * 0.1, LEAST)
        return q, error

    def other_start(self, q: np.ndarray, number: int) -> np.ndarray:
        """Return another starting point within the limits, spread evenly (a Weyl sequence)."""
        step = np.zeros(len(self.low))
        low, high = self.room(q)
        for n, rate in enumerate(self.rates):
            share = (0.5 + number * np.sqrt(n + 2.0)) % 1.0
            a, b = low[rate], high[rate]
            if not (np.isfinite(a) and np.isfinite(b)):
                turns = self.tree.rate_names[rate].rsplit(".", 1)[-1].startswith(("turn", "ball"))
                width = np.pi if turns else self.length
                a, b = max(a, -width), min(b, width)
            step[rate] = a + share * (b - a)
        return advanced(self.tree, q, step)


def reach(
    tree, marker: str, aim: Pose, start: np.ndarray, limits: Mapping[str, Any], orientation: bool, tolerance: float
) -> np.ndarray:
    """Return the coordinates (nq,) that bring a marker to a pose; see `JointTree.reach`."""
    search = _Search(tree, marker, aim, orientation, limits)
    low, high = search.room(start)
    inside = advanced(tree, start, np.clip(np.zeros(len(low)), low, high))
    best, least = inside, np.full(6, np.inf)
    for number in range(STARTS):
        q, error = search.descend(search.other_start(inside, number) if number else inside, tolerance)
        if np.linalg.norm(error) < np.linalg.norm(least):
            best, least = q, error
        if np.linalg.norm(least) <= tolerance:
            return best
    gap, angle = np.linalg.norm(least[:3]), np.linalg.norm(least[3:]) / search.length
    turned = f" and {angle:.6g} rad" if orientation else ""
    at = ", ".join(f"{name} = {x:.6g}" for name, x in zip(tree.names, best, strict=True))
    raise ModelError(
        "JointTree",
        found=f"marker '{marker}' gets no closer to its target than {gap:.6g} m{turned}, at {at}",
        expected="a pose within reach and limits",
        remedy="Move the target closer, widen the limits, or give another start",
    )
