"""`RigidBody`: six freedoms, constant inertia in body axes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from flexmb.bodies.frame_markers import MARKER_SIZE, add_load_stiffness, pack_markers, place_marker
from flexmb.bodies.frame_momentum import rigid_momentum
from flexmb.bodies.frame_state import check_frame, frame_state
from flexmb.bodies.inertia_tensor import inertia_tensor
from flexmb.bodies.rows import HEADER, add_own_block, add_product_skew, add_to_residual
from flexmb.bodies.shape import Ball, Box, Shape, Tube, checked_shapes
from flexmb.errors import ModelError
from flexmb.math.kernel import inner_kernel
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import row_kernel
from flexmb.math.vectors import add_cross, add_skew, cross, dot, matvec, matvec_t
from flexmb.model.described import is_number, named_arguments
from flexmb.model.kinds import Body
from flexmb.model.pose import Pose, as_pose, vector3
from flexmb.model.table import Table

__all__ = ["RigidBody"]

BESIDE = 1.0 + 1e-9
"""Size of a solid, relative, within which a marker is on it."""

ROW = np.dtype(
    [
        *HEADER,
        ("data", np.int64),  # markers in the bulk data
        ("mass", float),  # kg
        ("c", float, 3),  # m, centre of mass in body axes
        ("inertia", float, (3, 3)),  # kg m2, about the body's origin
        ("gravity", float, 3),  # m/s2, in W
    ],
    align=True,
)


@row_kernel
def place(raw, data, state, work):
    """Write the kinematics of all markers of rigid bodies."""
    rows = raw.view(ROW)
    R = np.empty((3, 3))
    scratch = np.empty((2, 3))
    for n in range(rows.shape[0]):
        row = rows[n]
        q = state.q[row.iq : row.iq + 7]
        u = state.u[row.iu : row.iu + 6]
        euler_to_matrix(q[3:7], R)
        for k in range(row.n_markers):
            start = row.data + MARKER_SIZE * k
            s = data[start : start + 3]
            axes = data[start + 3 : start + MARKER_SIZE].reshape((3, 3))
            place_marker(work.markers[row.marker + k], work.J, q[0:3], R, u, s, axes, scratch)


@inner_kernel
def _add_tangent(row, v, w, weights, B):
    """Add mass and gyroscopic damping to the body block, and h/2 M ad(u).

    The last term: the variation at the end of a step is not the increment over it (theory: integrators). Where steps
    translate in world axes, cd takes the place of h/2 in what translations have of it: acceleration R^T v_W' - w x v.
    """
    m, c, J = row.mass, row.c, row.inertia
    cm, cd, half = weights.mass, weights.damping, weights.half_step
    turning, shifted = (-cd, cd) if weights.world_axes == 1 else (half, half)
    Jw = np.empty(3)
    t = np.empty(3)
    for i in range(3):
        B[i, i] += cm * m
        for j in range(3):
            B[3 + i, 3 + j] += cm * J[i, j]
    add_skew(B, 0, 3, -cm * m, c)
    add_skew(B, 3, 0, cm * m, c)
    if cd == 0.0:
        return
    matvec(J, w, Jw)
    add_skew(B, 0, 0, (cd + turning) * m, w)
    add_product_skew(B, 3, 0, (cd + turning) * m, c, w)
    add_skew(B, 0, 3, (shifted - cd) * m, v)
    cross(w, c, t)
    add_skew(B, 0, 3, -cd * m, t)
    add_product_skew(B, 0, 3, -cd * m, w, c)
    add_product_skew(B, 0, 3, -half * m, c, w)
    add_product_skew(B, 3, 3, (shifted - cd) * m, c, v)
    add_skew(B, 3, 3, -cd, Jw)
    for j in range(3):
        # columns of w~ J and of J w~
        k, n = (j + 1) % 3, (j + 2) % 3
        for i in range(3):
            i1, i2 = (i + 1) % 3, (i + 2) % 3
            B[3 + i, 3 + j] += cd * (w[i1] * J[i2, j] - w[i2] * J[i1, j])
            B[3 + i, 3 + j] += half * (J[i, k] * w[n] - J[i, n] * w[k])


@row_kernel
def inertia(raw, data, state, work):
    """Newton-Euler about the body's origin, in body axes; gravity as an acceleration of the frame.

    With the momentum ``p = m (v + w x c)``, A = v' - R^T g::

        force  = m (A + w' x c) + w x p
        moment = m c x A + J w' + w x (J w) + m c x (w x v)

    (v x p + m w x (c x v) = m c x (w x v) by Jacobi's identity.) The tangent has the same terms, differentiated.
    """
    rows = raw.view(ROW)
    R = np.empty((3, 3))
    fall = np.empty(3)
    A = np.empty(3)
    Jw = np.empty(3)
    p = np.empty(3)
    t = np.empty(3)
    F = np.empty(3)
    N = np.empty(3)
    B = np.empty((6, 6))
    weights = work.weights[0]
    for n in range(rows.shape[0]):
        row = rows[n]
        iu, m, c, J = row.iu, row.mass, row.c, row.inertia
        v = state.u[iu : iu + 3]
        w = state.u[iu + 3 : iu + 6]
        euler_to_matrix(state.q[row.iq + 3 : row.iq + 7], R)
        matvec_t(R, row.gravity, fall)
        for i in range(3):
            A[i] = state.a[iu + i] - fall[i]
        alpha = state.a[iu + 3 : iu + 6]
        # force
        cross(w, c, p)
        for i in range(3):
            p[i] = m * (v[i] + p[i])
            t[i] = A[i]
        add_cross(alpha, c, t)
        force = work.residual[iu : iu + 3]
        for i in range(3):
            force[i] += m * t[i]
        add_cross(w, p, force)
        # moment: c x (A + w x v), J w' + w x J w
        moment = work.residual[iu + 3 : iu + 6]
        cross(w, v, t)
        for i in range(3):
            t[i] = m * (t[i] + A[i])
        add_cross(c, t, moment)
        matvec(J, w, Jw)
        add_cross(w, Jw, moment)
        matvec(J, alpha, t)
        for i in range(3):
            moment[i] += t[i]
        for k in range(row.n_markers):
            add_to_residual(work, iu, work.markers[row.marker + k])
        if weights.wanted == 0:
            continue
        B[:] = 0.0
        _add_tangent(row, v, w, weights, B)
        ck = weights.stiffness
        if ck != 0.0:
            for i in range(3):
                t[i] = m * fall[i]
            add_skew(B, 0, 3, -ck, t)
            add_product_skew(B, 3, 3, -ck, c, t)
            for k in range(row.n_markers):
                start = row.data + MARKER_SIZE * k
                marker = work.markers[row.marker + k]
                add_load_stiffness(B, ck, R, data[start : start + 3], marker.wrench, F, N)
        add_own_block(work, iu, B, 6)


@row_kernel
def energy(raw, data, state, work):
    """T = 1/2 m v.v + m v.(w x c) + 1/2 w.J w; V = -m g.(r + R c)."""
    rows = raw.view(ROW)
    R = np.empty((3, 3))
    t = np.empty(3)
    for n in range(rows.shape[0]):
        row = rows[n]
        v = state.u[row.iu : row.iu + 3]
        w = state.u[row.iu + 3 : row.iu + 6]
        cross(w, row.c, t)
        kinetic = 0.5 * row.mass * dot(v, v) + row.mass * dot(v, t)
        matvec(row.inertia, w, t)
        work.energy[0].kinetic += kinetic + 0.5 * dot(w, t)
        euler_to_matrix(state.q[row.iq + 3 : row.iq + 7], R)
        matvec(R, row.c, t)
        for i in range(3):
            work.energy[0].potential -= row.mass * row.gravity[i] * (state.q[row.iq + i] + t[i])


@dataclass(frozen=True, eq=False)
class RigidBody(Body):
    """A rigid body with mass, centre of mass and inertia.

    Parameters
    ----------
    name : str
    mass : float, kg
        Zero, as moments of inertia, for motions that joints hold: a weightless link.
    inertia : (3,) or (3, 3), kg m2
        Principal values or tensor about the centre of mass, in body axes (J_xy = -int x y dm). Where rounding to
        32 bits made J_xy and J_yx differ, both become their mean.
    center_of_mass : (3,), m
        In body axes.
    at, rotation : (3,) m; rotation vector, matrix or scipy Rotation
        Where the body frame is at the start, in W.
    velocity, angular_velocity : (3,), m/s and rad/s
        Of the body's origin at the start, in world axes.
    markers : mapping of name to pose
        In body axes. The marker ``center`` (centre of mass) always exists.
    shape : shape or sequence of shapes, optional
        What is drawn: `Ball`, `Box`, `Tube`, `Extrusion`; without it bars between the markers. `.box`, `.cylinder` and
        `.sphere` are drawn as they are, unless a marker lies outside.

    Examples
    --------
    >>> RigidBody.sphere("ball", radius=0.1, density=7850.0).mass.__round__(2)
    32.88
    """

    name: str
    _: KW_ONLY
    mass: float
    inertia: Any
    center_of_mass: Any = (0.0, 0.0, 0.0)
    at: Any = (0.0, 0.0, 0.0)
    rotation: Any = None
    velocity: Any = (0.0, 0.0, 0.0)
    angular_velocity: Any = (0.0, 0.0, 0.0)
    markers: Mapping[str, Any] = field(default_factory=dict)
    shape: Any = ()

    takes_markers: ClassVar[bool] = True
    table: ClassVar[Table] = Table("RigidBody", ROW, {"place": place, "inertia": inertia, "energy": energy})

    def __post_init__(self):
        super().__post_init__()
        self.require_positive("mass", zero=True)
        object.__setattr__(self, "center_of_mass", vector3(self.center_of_mass, self.title, "center_of_mass"))
        check_frame(self)
        object.__setattr__(self, "inertia", inertia_tensor(self.title, self.inertia))
        poses = {name: as_pose(pose, self.title, f"marker {name}") for name, pose in (self.markers or {}).items()}
        object.__setattr__(self, "markers", poses)
        object.__setattr__(self, "shape", checked_shapes(self))

    def marker_poses(self) -> dict[str, Pose]:
        """Return the markers by name, ``center`` first."""
        return {"center": Pose(self.center_of_mass), **self.markers}

    def initial_state(self):
        """Return (r, p) and the twist in body axes."""
        return frame_state(self)

    def momentum(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return linear and angular momentum about the origin of W, (nt, 6)."""
        return rigid_momentum(self.mass, self.center_of_mass, self.inertia, q, u)

    def rest_inertia(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Return mass, first moment (3,) and inertia (3, 3) about the origin (Steiner)."""
        c = np.array(self.center_of_mass)
        return self.mass, self.mass * c, self.inertia + self.mass * (c @ c * np.eye(3) - np.outer(c, c))

    def record(self, compiler, place):
        """Return the row: inertia about the body's origin, marker offsets."""
        _, _, origin = self.rest_inertia()
        bulk = place.bulk(pack_markers(self.marker_poses()))
        return {"data": bulk, "c": self.center_of_mass, "inertia": origin, "gravity": compiler.gravity}

    @classmethod
    @named_arguments
    def rod(cls, name: str, *, length: float, mass: float, radius: float | None = None, **fields) -> RigidBody:
        """Make a slender (or round) rod along x from the origin to (length, 0, 0), markers ``start`` and ``end``.

        Without a radius the rod is slender: m L^2 / 12 across, exactly. About its axis it has the inertia of a round
        rod of radius L / 100, because a body without inertia there could not be simulated.
        """
        _require_positive(name, length=length, mass=mass, **({} if radius is None else {"radius": radius}))
        axial = 0.5 * mass * (0.01 * length if radius is None else radius) ** 2
        lateral = mass * (length**2 / 12.0 + (0.0 if radius is None else radius) ** 2 / 4.0)
        markers = {"start": (0.0, 0.0, 0.0), "end": (length, 0.0, 0.0), **fields.pop("markers", {})}
        return cls(
            name,
            mass=mass,
            inertia=(axial, lateral, lateral),
            center_of_mass=(0.5 * length, 0.0, 0.0),
            markers=markers,
            **fields,
        )

    @classmethod
    @named_arguments
    def box(cls, name: str, *, size, density: float, **fields) -> RigidBody:
        """Make a box with edges `size` (3,), m, centred on its origin."""
        _require_positive(name, density=density)
        _require_no_mass(name, fields)
        x, y, z = size = vector3(size, f"Body '{name}'", "size")
        mass = density * x * y * z
        inertia = (mass * (y * y + z * z) / 12.0, mass * (x * x + z * z) / 12.0, mass * (x * x + y * y) / 12.0)
        _require_positive(name, **dict(zip(("size[0]", "size[1]", "size[2]"), size)))
        body = cls(name, mass=mass, inertia=inertia, **fields)
        return _drawn(body, Box(size=size), lambda r: np.all(np.abs(r) <= 0.5 * BESIDE * np.array(size)))

    @classmethod
    @named_arguments
    def cylinder(cls, name: str, *, radius: float, length: float, density: float, **fields) -> RigidBody:
        """Make a solid cylinder about its z-axis, centred on its origin."""
        _require_positive(name, radius=radius, length=length, density=density)
        _require_no_mass(name, fields)
        mass = density * np.pi * radius**2 * length
        lateral = mass * (radius**2 / 4.0 + length**2 / 12.0)
        body = cls(name, mass=mass, inertia=(lateral, lateral, 0.5 * mass * radius**2), **fields)
        shape = Tube(start=(0.0, 0.0, -0.5 * length), end=(0.0, 0.0, 0.5 * length), radius=radius)
        inside = lambda r: np.hypot(*r[:2]) <= BESIDE * radius and abs(r[2]) <= 0.5 * BESIDE * length  # noqa: E731
        return _drawn(body, shape, inside)

    @classmethod
    @named_arguments
    def sphere(cls, name: str, *, radius: float, density: float, **fields) -> RigidBody:
        """Make a solid sphere centred on its origin."""
        _require_positive(name, radius=radius, density=density)
        _require_no_mass(name, fields)
        mass = density * 4.0 / 3.0 * np.pi * radius**3
        body = cls(name, mass=mass, inertia=(0.4 * mass * radius**2,) * 3, **fields)
        return _drawn(body, Ball(radius=radius), lambda r: np.linalg.norm(r) <= BESIDE * radius)


def _drawn(body: RigidBody, shape: Shape, inside: Callable[[np.ndarray], Any]) -> RigidBody:
    """Return a body with the shape that it is made of, unless it has one, or a marker outside, which gets a bar."""
    if body.shape or not all(inside(np.array(pose.at)) for pose in body.marker_poses().values()):
        return body
    return replace(body, shape=shape)


def _require_no_mass(name: str, fields: Mapping[str, Any]) -> None:
    """Raise ModelError if a shaped body is given what follows from its shape."""
    for field_name in ("mass", "inertia"):
        if field_name in fields:
            raise ModelError(
                f"Body '{name}'",
                found=f"{field_name} = {fields[field_name]!r:.80} beside a shape with a density",
                expected="one of them: mass and inertia follow from shape and density",
                remedy="Give density = mass/volume, or write a RigidBody with mass and inertia",
            )


def _require_positive(name: str, **values: Any) -> None:
    """Raise ModelError if one of the sizes of a shaped body is no positive number."""
    for field_name, value in values.items():
        if not is_number(value) or value <= 0.0:
            raise ModelError(
                f"Body '{name}'",
                found=f"{field_name} = {value!r}",
                expected="a number > 0 in SI units",
                remedy=f"Give {field_name} a value in m, kg or kg/m3",
            )
