"""`FloatingBody`: a reduced elastic body in a floating frame, with geometric stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.bodies.floating_inertia import (
    add_inertia,
    add_inertia_damping,
    add_inertia_stiffness,
    mass_matrix,
    rates,
)
from flexmb.bodies.floating_markers import add_marker_stiffness, place_flexible_marker
from flexmb.bodies.floating_row import ROW, geometry, invariants, pack, stiffness_matrices
from flexmb.bodies.floating_stiffness import add_stiffening, add_stiffening_tangent, load_scales
from flexmb.bodies.floating_validity import FloatingWatch
from flexmb.bodies.frame_state import check_frame, frame_state
from flexmb.bodies.rows import add_own_block, add_to_residual
from flexmb.errors import ModelError, did_you_mean
from flexmb.math.kernel import inner_kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import add_combination, cross, matvec_t
from flexmb.model.kinds import Body, Table
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.pose import Pose, as_pose, vector3

__all__ = ["FloatingBody"]

STIFFENING = ("inertia", "interface", "loads", "preload")
"""The groups of geometric stiffness, in the order of their matrices."""


@row_kernel
def place(raw, data, state, work):
    """Write the kinematics of all markers of floating bodies."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        row = rows[n]
        m = row.modes
        q = state.q[row.iq : row.iq + 7 + m]
        u = state.u[row.iu : row.iu + 6 + m]
        for k in range(row.n_markers):
            s, axes, translation, rotation = geometry(data, row.geometry, k, m)
            place_flexible_marker(work.markers[row.marker + k], work.J, q, u, m, s, axes, translation, rotation)


@inner_kernel
def _elastic(K, D, shapes, eta, rate, u, first_load, work, residual):
    """Add K eta + D eta' and subtract the load shapes; add to the rates of work and dissipation."""
    m = len(eta)
    add_combination(eta, K, residual[6:])  # K is symmetric
    for i in range(m):
        damping = 0.0
        for j in range(m):
            damping += D[i, j] * rate[j]
        residual[6 + i] += damping
        work.energy[5] += damping * rate[i]
    for n in range(len(shapes)):
        amount = work.loads[first_load + n]
        if amount != 0.0:
            for i in range(6 + m):
                residual[i] -= amount * shapes[n, i]
                work.energy[3] += amount * shapes[n, i] * u[i]


@inner_kernel
def _add_step_term(M, u, weights, B):
    """Add h/2 M ad(u): the variation at the end of a step against the increment over it (theory: integrators).

    Where steps translate in world axes, cd takes the place of h/2 in what translations have of it, see `RigidBody`.
    """
    cd, half = weights[1], abs(weights[4])
    turning, shifted = (-cd, cd) if weights[4] < 0.0 else (half, half)
    v = u[0:3]
    w = u[3:6]
    e = np.zeros(3)
    a = np.empty(3)
    b = np.empty(3)
    for i in range(3):
        e[:] = 0.0
        e[i] = 1.0
        cross(w, e, a)
        cross(v, e, b)
        for k in range(M.shape[0]):
            for c in range(3):
                B[k, i] += turning * M[k, c] * a[c]
                B[k, 3 + i] += shifted * M[k, c] * b[c] + half * M[k, 3 + c] * a[c]


@row_kernel
def inertia(raw, data, state, work):
    """Inertia, velocity terms, gravity, elasticity, geometric stiffness and marker loads, with the tangent."""
    rows = raw.view(ROW)
    weights = work.coefficients
    R = np.empty((3, 3))
    fall = np.empty(3)
    vwd, wwd = np.empty((3, 3)), np.empty(6)
    for n in range(rows.shape[0]):
        row = rows[n]
        m, iu = row.modes, row.iu
        size = 6 + m
        eta = state.q[row.iq + 7 : row.iq + 7 + m]
        u = state.u[iu : iu + size]
        residual = work.residual[iu : iu + size]
        terms = invariants(data, row.mass, m)
        K, D, shapes, G = stiffness_matrices(data, row.elastic, m, row.loads, row.stiffening)
        M, W = np.empty((size, size)), np.empty((m, 6))
        wnd, swing = np.empty((3, m)), np.empty((m, 3))
        A, P = np.empty(size), np.empty(size)
        euler_to_matrix(state.q[row.iq + 3 : row.iq + 7], R)
        matvec_t(R, row.gravity, fall)
        for i in range(size):
            A[i] = state.a[iu + i]
        for i in range(3):
            A[i] -= fall[i]
        mass_matrix(terms, eta, M, W)
        rates(terms, W, u, wnd, vwd, wwd, swing)
        add_inertia(terms, M, W, u, A, wnd, vwd, wwd, swing, P, residual)
        _elastic(K, D, shapes, eta, u[6:], u, row.first_load, work, residual)
        s, g = np.empty(row.stiffening), np.empty((row.stiffening, m))
        if row.stiffening > 0:
            load_scales(u, A, R, work.markers, row.marker, row.interfaces, row.loads, row.first_load, work.loads, s)
            add_stiffening(G, s, eta, g, residual[6:])
        for k in range(row.n_markers):
            add_to_residual(work, iu, work.markers[row.marker + k])
        if weights[3] == 0.0:
            continue
        B = np.zeros((size, size))
        for i in range(size):
            for j in range(size):
                B[i, j] = weights[0] * M[i, j]
        if weights[1] != 0.0:
            add_inertia_damping(terms, M, W, u, wnd, vwd, wwd, swing, P, weights[1], B)
            _add_step_term(M, u, weights, B)
        if weights[2] != 0.0:
            add_inertia_stiffness(terms, W, u, A, swing, weights[2], B)
            for i in range(size):
                # gravity: -M[:, :3] fall~
                for j in range(3):
                    a, b = (j + 1) % 3, (j + 2) % 3
                    B[i, 3 + j] -= weights[2] * (M[i, a] * fall[b] - M[i, b] * fall[a])
            for k in range(row.n_markers):
                r, _, translation, rotation = geometry(data, row.geometry, k, m)
                add_marker_stiffness(
                    B,
                    weights[2],
                    R,
                    state.q[row.iq : row.iq + 7 + m],
                    m,
                    r,
                    translation,
                    rotation,
                    work.markers[row.marker + k].wrench,
                )
        for i in range(m):
            for j in range(m):
                B[6 + i, 6 + j] += weights[2] * K[i, j] + weights[1] * D[i, j]
        if row.stiffening > 0:
            add_stiffening_tangent(G, s, g, u, R, row.interfaces, fall, weights, B, work.markers, row.marker, work.H)
        add_own_block(work, iu, B, size)


@row_kernel
def energy(raw, data, state, work):
    """T = 1/2 u.P, V = 1/2 eta.K eta - m g.(r + R c(eta))."""
    rows = raw.view(ROW)
    R = np.empty((3, 3))
    fall = np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        m = row.modes
        eta = state.q[row.iq + 7 : row.iq + 7 + m]
        u = state.u[row.iu : row.iu + 6 + m]
        terms = invariants(data, row.mass, m)
        vv, vw0, vn = terms[0], terms[1], terms[3]
        M, W = np.empty((6 + m, 6 + m)), np.empty((m, 6))
        mass_matrix(terms, eta, M, W)
        for i in range(6 + m):
            for j in range(6 + m):
                work.energy[0] += 0.5 * u[i] * M[i, j] * u[j]
        K, _, _, _ = stiffness_matrices(data, row.elastic, m, row.loads, row.stiffening)
        for i in range(m):
            for j in range(m):
                work.energy[1] += 0.5 * eta[i] * K[i, j] * eta[j]
        euler_to_matrix(state.q[row.iq + 3 : row.iq + 7], R)
        matvec_t(R, row.gravity, fall)
        # first moment of mass, m c = (M_vw)_zy and cyclic, plus the modes'
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            moment = vw0[a, b]
            for j in range(m):
                moment += vn[i, j] * eta[j]
            work.energy[2] -= fall[i] * moment
            work.energy[2] -= vv[i, i] * row.gravity[i] * state.q[row.iq + i]


@dataclass(frozen=True, eq=False)
class FloatingBody(Body):
    """An elastic body, reduced to modes, that moves at large in its floating frame.

    Parameters
    ----------
    name : str
    data : ModalNeutralData
        Its markers are the interfaces and stations of the data.
    at, rotation : (3,) m; rotation vector, matrix or scipy Rotation
        Where the axes of the mesh are at the start, in W.
    velocity, angular_velocity : (3,), m/s and rad/s, in W
    damping : float, (m,) or (m, m)
        Fraction of critical damping of all modes or of each, or a damping matrix (N s/m); added to the data's own.
    modes : int or sequence of int, optional
        The first so many modes, or these; default: all.
    geometric_stiffness : bool or sequence of str
        True for all groups the data has, or some of "inertia", "interface", "loads", "preload"; False for none.
    rigid : bool
        Leave out all deformation: the same body, rigid, for comparison.
    markers : mapping of interface or station to pose, optional
        Their axes, in body axes, where a joint's axis is not the z-axis of the mesh:
        ``{"bore": Pose.axes(z=(0, 1, 0))}``. Their places are those of the data.

    Source: Banerjee 1993, eqs. 17-21, 41; Shabana, Dynamics of Multibody Systems, ch. 5.
    """

    name: str
    _: KW_ONLY
    data: ModalNeutralData
    at: Any = (0.0, 0.0, 0.0)
    rotation: Any = None
    velocity: Any = (0.0, 0.0, 0.0)
    angular_velocity: Any = (0.0, 0.0, 0.0)
    damping: Any = 0.0
    modes: Any = None
    geometric_stiffness: Any = True
    rigid: bool = False
    markers: Any = None

    watch: ClassVar[Any] = FloatingWatch
    table: ClassVar[Table] = Table("FloatingBody", ROW, {"place": place, "inertia": inertia, "energy": energy})

    def __post_init__(self):
        super().__post_init__()
        if not isinstance(self.data, ModalNeutralData):
            raise ModelError(
                self.title,
                found=f"data = {type(self.data).__name__}",
                expected="ModalNeutralData",
                remedy="Make it with flexmb.reduction.reduce, or load it with ModalNeutralData.load",
            )
        check_frame(self)
        self._check_markers()
        modes = 0 if self.rigid else self.modes
        reduced = self.data if modes is None else self.data.selected(modes)
        object.__setattr__(self, "_reduced", reduced)
        m = reduced.n_modes
        damping = np.asarray(self.damping, float)
        fits = m == 0 or damping.shape in ((), (self.data.n_modes,), (m,), (m, m))
        if not fits or (damping.ndim < 2 and np.any(damping < 0.0)):
            raise ModelError(
                self.title,
                found=f"damping with the shape {damping.shape}",
                expected=f"a fraction >= 0, ({m},) fractions, or a matrix ({m}, {m})",
                remedy="Write damping=0.01 for 1 % of critical damping",
            )
        groups = self.stiffening_groups
        unknown = [name for name in groups if name not in STIFFENING]
        if unknown:
            raise ModelError(
                self.title,
                found=f"geometric_stiffness names {unknown}",
                expected=f"some of {STIFFENING}",
                remedy="Use True for all of them",
            )

    @classmethod
    def similar(cls, name: str, *, data: ModalNeutralData, scale: float, **fields) -> FloatingBody:
        """Make a body that is geometrically similar to that of the data: all lengths times `scale`, same material.

        Masses then grow with scale^3, stiffness with scale, frequencies with 1/scale; equal strains mean equal
        stresses. So a part can be made longer, with all its other measures, without a new reduction.
        """
        if isinstance(scale, bool) or not isinstance(scale, int | float) or not 0.0 < scale < np.inf:
            raise ModelError(
                f"Body '{name}'",
                found=f"scale = {scale!r}",
                expected="a positive number",
                remedy="scale=1.05 makes all lengths 5 % longer",
            )
        if scale != 1.0:
            data = data.rescaled(length=scale, mass=scale**3, time=scale)
        return cls(name, data=data, **fields)

    @classmethod
    def split(
        cls,
        name: str,
        parts: Sequence[ModalNeutralData],
        *,
        at=(0.0, 0.0, 0.0),
        rotation: Any = None,
        velocity=(0.0, 0.0, 0.0),
        angular_velocity=(0.0, 0.0, 0.0),
        damping: Any = 0.0,
        geometric_stiffness: Any = True,
        rigid: bool = False,
    ) -> tuple[FloatingBody, ...]:
        """Return the bodies "name_1", "name_2" ... of the parts of a body (`flexmb.reduction.split`).

        Place and motion are those of the whole; `flexmb.Fixed.at_cuts` joins them.
        """
        return tuple(
            cls(
                f"{name}_{k}",
                data=data,
                at=at,
                rotation=rotation,
                velocity=velocity,
                damping=damping,
                angular_velocity=angular_velocity,
                geometric_stiffness=geometric_stiffness,
                rigid=rigid,
            )
            for k, data in enumerate(parts, 1)
        )

    def _check_markers(self) -> None:
        """Store the given marker axes as poses at the places of the data."""
        places = dict(zip(self.data.marker_names, self.data.marker_positions, strict=True))
        poses = {}
        for name, value in (self.markers or {}).items():
            if name not in places:
                raise ModelError(
                    self.title,
                    found=f"markers turns '{name}', which the data does not have",
                    expected=f"Interfaces and stations: {', '.join(places)}",
                    remedy=did_you_mean(name, places) or "Add it to the reduction as interface or station",
                )
            pose, at = as_pose(value, self.title, f"marker {name}"), vector3(places[name], self.title, name)
            if any(pose.at) and not np.allclose(pose.at, at, rtol=1e-6, atol=1e-9):
                raise ModelError(
                    self.title,
                    found=f"marker {name} at {pose.at} m",
                    expected=f"its place in the data, {at} m",
                    remedy="Give axes only, or add a station to the reduction at that place",
                )
            poses[name] = Pose(at, pose.matrix)
        object.__setattr__(self, "markers", poses or None)

    @property
    def reduced(self) -> ModalNeutralData:
        """The data with the modes in use."""
        return self._reduced  # type: ignore[attr-defined]

    @property
    def stiffening_groups(self) -> tuple[str, ...]:
        """Names of the groups of geometric stiffness that act."""
        value = self.geometric_stiffness
        if isinstance(value, bool | np.bool_):
            return STIFFENING if value else ()
        return (value,) if isinstance(value, str) else tuple(value)

    @property
    def n_vector(self) -> int:
        """Number of flexible coordinates."""
        return self.reduced.n_modes

    def damping_matrix(self) -> np.ndarray:
        """Return the modal damping matrix (m, m), N s/m: 2 zeta_j sqrt(k_jj m_jj) on the diagonal, or as given."""
        data = self.reduced
        m = data.n_modes
        damping = np.asarray(self.damping, float)
        if damping.ndim == 2:
            return damping
        if damping.ndim == 1 and len(damping) != m:
            damping = damping[:m] if self.modes is None or np.isscalar(self.modes) else damping[list(self.modes)]
        zeta = data.damping_ratios + damping
        k, mass = np.diag(data.stiffness), np.diag(data.invariants.nn)
        return np.diag(2.0 * zeta * np.sqrt(np.maximum(k, 0.0) * mass))

    def marker_poses(self) -> dict[str, Pose]:
        """Return the interfaces and stations of the data, undeformed."""
        data, turned = self.reduced, self.markers or {}
        return {
            name: turned.get(name, Pose(tuple(at)))
            for name, at in zip(data.marker_names, data.marker_positions, strict=True)
        }

    def initial_state(self):
        """Return (r, p, eta = 0) and the twist in body axes with eta' = 0."""
        q, u = frame_state(self)
        rest = np.zeros(self.n_vector)
        return np.concatenate([q, rest]), np.concatenate([u, rest])

    def record(self, compiler, place):
        """Return the row: invariants, markers and stiffness as bulk data."""
        data = self.reduced
        mass, markers, elastic, stiffening = pack(
            data, self.damping_matrix(), self.stiffening_groups, list(self.marker_poses().values())
        )
        first_load = 0
        for k, name in enumerate(data.load_names):
            index = compiler.load(self.name, name)
            first_load = index if k == 0 else first_load
        return (
            data.n_modes,
            data.n_interfaces,
            len(data.load_names),
            first_load,
            stiffening,
            place.bulk(mass),
            place.bulk(markers),
            place.bulk(elastic),
            compiler.gravity,
        )

    def stiffen(self, compiler, markers):
        """Reserve room for the derivatives of the stiffening by the interfaces' wrenches."""
        data = self.reduced
        if data.geometric is None or not data.n_modes or "interface" not in self.stiffening_groups:
            return
        for name in data.marker_names[: data.n_interfaces]:
            number = compiler.marker(f"{self.name}.{name}")
            markers[number]["iH"] = compiler.reserve_H(6 * int(markers[number]["nu"]))
