"""How far a floating body is from what its linear reduction holds for: deformation, load and speed.

Five numbers, each 1 at the limit:

- deformation: largest nodal displacement relative to `DEFORMATION` of the body's size; beyond, linear strain and the
  first-order kinematics of the markers err by percents;
- load: the geometric stiffness of the present loads, sum s_i G_i, relative to the one at which K + sum s_i G_i is
  singular: the buckling load of the body as joints to the ground hold it and whatever its neighbours hold. Data that
  do not tell how supports change it are taken in their frame (free for the mean frame);
- left out: change of stiffness by the present loads where the reduction has no geometric stiffness, relative to
  `CHANGE`; beside it the part of it that softens, relative to all of the stiffness: 1 where the body buckles;
- inner inertia: change of stiffness that vibration inside the body seems to make where its frame is clamped to an
  interface, relative to `INNER`; none in the mean frame;
- speed: angular velocity relative to the frequency of the highest retained mode; beyond, the centrifugal field changes
  the body in shapes that were left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from flexmb.bodies.floating.inner_inertia import INNER, InnerInertia
from flexmb.bodies.floating.left_out import LeftOut
from flexmb.bodies.floating.row import ROW, mean_motion, stiffness_matrices
from flexmb.bodies.floating.stiffness import load_scales, mean_acceleration
from flexmb.math.kernel import kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.vectors import matvec_t
from flexmb.model.modal_arrays import GeometricStiffness

__all__ = ["CHANGE", "DEFORMATION", "FloatingWatch"]

DEFORMATION = 0.1
"""Largest displacement, relative to the body's size, that counts as small."""
CHANGE = 0.1
"""Change of the stiffness by loads, relative to it, that may be left out."""
UNKNOWN = (
    "{title} has no geometric stiffness, and it is not known by how much loads change its stiffness: no run warns "
    "where it would buckle. Reduce it again with geometric_stiffness=True (--geometric-stiffness; of a part in a model "
    "file geometric_stiffness = true) or, if it was made of matrices alone, compare its load with a buckling load of "
    "the program that wrote them."
)
SWITCHED_OFF = (
    "{title} has geometric stiffness{of} that is not used (geometric_stiffness={given!r}): no run warns where loads "
    "change its stiffness. Leave that out, or compare with a run that has it."
)
OWN_FRAME = (
    "{title}: how joints and other bodies hold it is not known to its data (parts of parts, files of former versions, "
    "more than some forty interfaces), so its buckling load is that {frame}, which may be several times too high or "
    "too low. Reduce it again, or compare with linearize: a frequency falls to zero where it buckles."
)
LOOKS = 32
"""Samples of a block at which the load is looked at; it costs an evaluation and an eigenvalue problem."""


@kernel
def _scales(rows, data, state, work, first, out):
    """Write the scales s_i of the unit loads of each row's body to `out` from number `first[row]` on."""
    R = np.empty((3, 3))
    fall = np.empty(3)
    acceleration = np.empty(6)
    for n in range(rows.shape[0]):
        row = rows[n]
        if row.stiffening == 0:
            continue
        A = state.a[row.iu : row.iu + 6 + row.modes].copy()
        euler_to_matrix(state.q[row.iq + 3 : row.iq + 7], R)
        matvec_t(R, row.gravity, fall)
        for i in range(3):
            A[i] -= fall[i]
        mean_acceleration(mean_motion(data, row.mass, row.modes), A, acceleration)
        load_scales(
            state.u[row.iu : row.iu + 6],
            acceleration,
            R,
            work.markers[row.marker : row.marker + row.interfaces],
            work.loads[row.first_load : row.first_load + row.loads],
            out[first[n] : first[n] + row.stiffening],
        )


def _switched_off(body: Any, geometric: GeometricStiffness) -> str:
    """Return a note on the groups of geometric stiffness that a body has and does not use; empty if there are none."""
    has = [f.name for f in fields(geometric) if np.any(getattr(geometric, f.name))]
    unused = [name for name in has if name not in body.stiffening_groups]
    if not unused:
        return ""
    of = "" if len(unused) == len(has) else f" of {' and '.join(unused)}"
    return SWITCHED_OFF.format(title=body.title, of=of, given=body.geometric_stiffness)


class _Limits:
    """Size, watched nodes, highest frequency, stiffness and unit loads of one body."""

    def __init__(self, body, row, system):
        data, bulk = body.reduced, system.program.bulk
        self.title, self.modes = body.title, data.n_modes
        nodes, shapes = data.nodes, data.shapes
        if not len(nodes):  # of SID and MBDyn files: markers are all that is known of the geometry
            nodes = np.vstack([np.zeros((1, 3)), data.marker_positions])
            shapes = np.concatenate([np.zeros((1, 3, data.n_modes)), data.marker_translations])
        self.size = float(np.linalg.norm(np.ptp(nodes, axis=0))) or 1.0
        some = slice(None, None, 1 + len(nodes) // 4096)  # a fine mesh need not be looked at node by node
        furthest = some.step * np.linalg.norm(shapes[some], axis=1).argmax(axis=0)
        watched = np.unique(np.concatenate([furthest, nodes.argmin(axis=0), nodes.argmax(axis=0)]))
        self.shapes, self.nodes = shapes[watched], nodes[watched]
        # of the matrices, not of the report: data made by hand need not tell its frequencies
        mass = data.invariants.nn
        self.highest = float(np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(mass, data.stiffness))).max()))
        G = stiffness_matrices(bulk, *(row[name] for name in ("elastic", "modes", "loads", "turning", "stiffening")))[4]
        self.G = G.swapaxes(0, 1)
        clamped = data.frame != "buckens"
        if len(self.G) or clamped:
            w, vectors = np.linalg.eigh(data.stiffness)
            self.inverse = (vectors / np.sqrt(np.maximum(w, 1e-12 * w[-1]))).T  # inverse @ K @ inverse^T = I
        self.inner = InnerInertia(row, bulk, self.inverse) if clamped else None
        interfaces = [f"interface '{name}'" for name in data.marker_names[: data.n_interfaces]]
        self.causes = (
            12 * ["acceleration"]
            + [name for name in interfaces for _ in range(6)]
            + [f"load '{name}'" for name in data.load_names]
            + ["preload"]
        )
        self.note = ""
        if data.geometric is not None:
            self.note = _switched_off(body, data.geometric)
            if not self.note and data.left_out is None and row["stiffening"]:
                own = f"of its frame, clamped to '{data.frame}'" if clamped else "of a body that nothing holds"
                self.note = OWN_FRAME.format(title=body.title, frame=own)
        elif data.left_out is None:
            self.note = UNKNOWN.format(title=body.title)
        known, acting = data.left_out is not None, bool(row["stiffening"])
        compared = LeftOut(body, data, row, self.causes, system) if known and not self.note else None
        self.held, self.left_out = (compared, None) if acting else (None, compared)

    def deformation(self, eta):
        """Return the displacement relative to the size, (nt, watched nodes), from eta (nt, m)."""
        U = eta @ self.shapes.reshape(-1, self.modes).T
        return np.linalg.norm(U.reshape(len(eta), -1, 3), axis=2) / self.size

    def load(self, scales, losses):
        """Return the load relative to the buckling load, (nt,), and its greatest cause, for scales (nt, n).

        `losses` are shares and causes as supports hold the body; none where they are not known.
        """
        if losses:
            values, causes = zip(*losses)
            return np.array(values), causes[int(np.argmax(values))]
        if not len(self.G):
            return np.zeros(len(scales)), ""
        stiffening = np.einsum("ti,ijk->tjk", scales, self.G)
        values, vectors = np.linalg.eigh(self.inverse @ stiffening @ self.inverse.T)
        k = int(values[:, 0].argmin())
        shape = self.inverse.T @ vectors[k, :, 0]
        parts: dict[str, float] = {}
        for cause, part in zip(self.causes, scales[k] * np.einsum("j,ijk,k->i", shape, self.G, shape), strict=True):
            parts[cause] = parts.get(cause, 0.0) + part
        return np.maximum(0.0, -values[:, 0]), min(parts, key=lambda cause: parts[cause])


class FloatingWatch:
    """Measures the floating bodies of a system.

    Parameters
    ----------
    bodies : sequence of FloatingBody
    system : System
    """

    def __init__(self, bodies, system):
        program = system.program
        kind = list(program.place).index(bodies[0].table.kernels["place"].compiled.address)
        rows = program.raw[program.starts[kind] : program.starts[kind + 1]].view(ROW)
        elastic = [(body, row) for body, row in zip(bodies, rows, strict=True) if row["modes"] > 0]
        self.limits = [_Limits(body, row, system) for body, row in elastic]
        self.notes = [limits.note for limits in self.limits if limits.note]
        self.unstiffened = [n for n, limits in enumerate(self.limits) if limits.left_out is not None]
        self.held = [n for n, limits in enumerate(self.limits) if limits.held is not None]
        self.spans = [system.body_slices[body.name] for body, _ in elastic]
        self.bulk = program.bulk
        self.rows = rows[rows["modes"] > 0]
        self.first = np.concatenate([[0], np.cumsum(self.rows["stiffening"])]).astype(np.int64)

    def measure(self, rows: Mapping[str, np.ndarray], evaluated: Callable[[int], Any]) -> Iterator[tuple]:
        """Yield (title of the body, measure, place, sample numbers, values), each 1 at its limit.

        Parameters
        ----------
        rows : mapping of "t", "q", "u" ... to arrays with one row per sample
            A block of samples.
        evaluated : callable k -> (state, work)
            Evaluates the equations of motion at sample k.
        """
        everything = np.arange(len(rows["t"]))
        looks = np.unique(np.linspace(0, len(everything) - 1, LOOKS).astype(int))
        scales, left_out = np.zeros((len(looks), self.first[-1])), {n: [] for n in self.unstiffened}
        losses = {n: [] for n in self.held}
        if self.first[-1] or left_out:
            for row, k in zip(scales, looks):
                state, work = evaluated(k)
                _scales(self.rows, self.bulk, state, work, self.first, row)
                for n, found in left_out.items():
                    found.append(self.limits[n].left_out.share(self.bulk, state, work))
                for n, found in losses.items():
                    found.append(self.limits[n].held.loss(self.bulk, state, work))
        for n, (body, (iq, iu)) in enumerate(zip(self.limits, self.spans)):
            q, u = rows["q"][:, iq], rows["u"][:, iu]
            share = body.deformation(q[:, 7:])
            x, y, z = body.nodes[share.max(axis=0).argmax()]
            place = f"at ({x:.4g}, {y:.4g}, {z:.4g}) m"
            yield body.title, "deformation", place, everything, share.max(axis=1) / DEFORMATION
            values, cause = body.load(scales[:, self.first[n] : self.first[n + 1]], losses.get(n, ()))
            yield body.title, "load", f"most of it from {cause}" if cause else "", looks, values
            if body.inner is not None:
                yield body.title, "inner inertia", "", looks, body.inner.share(rows["a"][looks]) / INNER
            if n in left_out:
                changes, causes, softer = zip(*left_out[n])
                cause = causes[int(np.argmax(changes))]
                yield body.title, "softening left out", "", looks, np.array(softer)
                yield body.title, "left out", f"most of it by {cause}", looks, np.array(changes) / CHANGE
            yield body.title, "speed", "", everything, np.linalg.norm(u[:, 3:6], axis=1) / (body.highest or np.inf)
