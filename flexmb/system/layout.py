"""`Layout`: where bodies and states stand in q and u, and the numbers of their markers."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import INTEGRALS
from flexmb.model.model import Model
from flexmb.system.lengths import require_places
from flexmb.system.states import StateGroup

__all__ = ["Layout", "check_size"]

MOST = 2_000_000
"""Velocities of a model: its matrices take some 10 kB for each."""


class Layout:
    """Offsets of bodies in q and u, and the numbers of their markers."""

    def __init__(self, model: Model, compiler):
        self.iq, self.iu, self.first_marker = [], [], []
        frames, vectors = [], []
        q, u = [np.empty(0)], [np.empty(0)]
        nq = nu = 0
        for number, body in enumerate(model.bodies):
            self.iq.append(nq)
            self.iu.append(nu)
            compiler.first_coordinate[body.name] = nq
            self.first_marker.append(len(compiler.marker_index))
            q0, u0 = body.initial_state()
            if body.has_frame:
                frames.append((nq, nu))
            if body.n_vector:
                vectors.append((nq + 7 * body.has_frame, nu + 6 * body.has_frame, body.n_vector, body.has_frame))
            R = np.eye(3)
            origin = np.zeros(3)
            if body.has_frame:
                euler_to_matrix(q0[3:7], R)
                origin = q0[:3]
            elif body.n_vector:
                origin = q0[:3]
            first_pose = len(compiler.start_poses)
            blocks, gaps, size = body.marker_blocks(), body.marker_gaps(), body.block_size
            for marker, pose in body.marker_poses().items():
                compiler.marker_index[f"{body.name}.{marker}"] = len(compiler.marker_index)
                compiler.marker_names.append(f"{body.name}.{marker}")
                compiler.marker_body.append(number)
                if marker in gaps:
                    compiler.marker_gaps[compiler.marker_index[f"{body.name}.{marker}"]] = gaps[marker]
                first, count = blocks.get(marker, (0, len(u0) // size if size else 0))
                compiler.marker_span.append((first * size, count * size))
                compiler.start_poses.append((origin + R @ np.array(pose.at), R @ pose.matrix))
            require_places([body], [np.array([r for r, _ in compiler.start_poses[first_pose:]])])
            q.append(q0)
            u.append(u0)
            nq, nu = nq + len(q0), nu + len(u0)
        self.iq.append(nq)
        self.iu.append(nu)
        self.first_marker.append(len(compiler.marker_index))
        self.q, self.u = np.concatenate(q), np.concatenate(u)
        self.frames = np.array(frames, np.int64).reshape(-1, 2)
        self.vectors = np.array(vectors, np.int64).reshape(-1, 4)

    def append(self, groups: Iterable[StateGroup]) -> None:
        """Give groups of states their places behind all bodies: their integrals in q, themselves in u."""
        for group in groups:
            n, iq, iu = len(group.names), self.iq[-1], self.iu[-1]
            self.iq.append(iq + n)
            self.iu.append(iu + n)
            self.q, self.u = np.concatenate([self.q, np.zeros(n)]), np.concatenate([self.u, group.start])
            if len(self.vectors) and self.vectors[-1, 3] == INTEGRALS:  # they follow each other: one vector
                self.vectors[-1, 2] += n
            else:
                self.vectors = np.vstack([self.vectors, [iq, iu, n, INTEGRALS]])

    def slices(self, names: Iterable[str], first: int = 0) -> dict[str, tuple[slice, slice]]:
        """Return where bodies (or groups of states) stand in q and in u, by name; their numbers begin with `first`."""
        return {
            name: (slice(self.iq[k], self.iq[k + 1]), slice(self.iu[k], self.iu[k + 1]))
            for k, name in enumerate(names, first)
        }

    def size(self, body: int) -> int:
        """Return the number of velocities of a body."""
        return self.iu[body + 1] - self.iu[body]


def check_size(model: Model, layout: Layout) -> None:
    """Raise CompileError if nothing moves, or more than any computer can bear."""
    if layout.iu[-1] == 0:
        raise CompileError(
            f"Model '{model.name}'",
            found="no body that can move",
            expected="at least one",
            remedy="Add a RigidBody, PointMass or FloatingBody",
        )
    if layout.iu[-1] > MOST:
        raise CompileError(
            f"Model '{model.name}'",
            found=f"{layout.iu[-1]} velocities",
            expected=f"at most {MOST}",
            remedy="Use fewer elements, or fewer copies of a part",
        )
