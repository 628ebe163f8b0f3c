"""`FloatingBody`: a reduced elastic body in a floating frame, with geometric stiffness."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar

import numpy as np

from flexmb.bodies.floating.kernels import energy, inertia, place
from flexmb.bodies.floating.modal_link import modal_link
from flexmb.bodies.floating.momentum import floating_momentum
from flexmb.bodies.floating.row import ROW, pack
from flexmb.bodies.floating.skin import with_skins
from flexmb.bodies.floating.validity import FloatingWatch
from flexmb.bodies.frame_state import check_frame, frame_state
from flexmb.errors import ModelError, did_you_mean
from flexmb.model.data_source import DataSource
from flexmb.model.described import entries_of, finite_array
from flexmb.model.kinds import Body
from flexmb.model.modal_link import ModalLink
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.plausibility import damping_doubts
from flexmb.model.pose import Pose, as_pose, vector3
from flexmb.model.skin import SkinFacets, SkinPatch, checked_skins
from flexmb.model.table import Table
from flexmb.told import tell

__all__ = ["FloatingBody"]

STIFFENING = ("inertia", "interface", "loads", "preload")
"""The groups of geometric stiffness, in the order of their matrices."""
BALANCED = frozenset({"inertia", "interface"})
"""Groups that belong together: what accelerates a body in vibration are the loads at its interfaces."""
NEAR = 1e-6
"""Of the body's size: the digits of a mesh file, by which a described place of a marker may differ from its own."""


@dataclass(frozen=True, eq=False)
class FloatingBody(Body):
    """An elastic body, reduced to modes, that moves at large in its floating frame.

    Parameters
    ----------
    name : str
    data : ModalNeutralData, or a description that they are made of (`flexmb.parts.Part`)
        Its markers are the interfaces and stations of the data.
    at, rotation : (3,) m; rotation vector, matrix or scipy Rotation
        Where the axes of the mesh are at the start, in W.
    velocity, angular_velocity : (3,), m/s and rad/s, in W
    damping : float, (m,) or (m, m)
        Fraction of critical damping of all modes or of each, or a damping matrix (N s/m); added to the data's own.
        Modes are those of the body alone: held by joints it moves more slowly and is damped less (theory, eq.
        (modal-damping)); `linearize(model).damping_ratios` tells how much.
    modes : int or sequence of int, optional
        The first so many modes, or these; default: all.
    geometric_stiffness : bool or sequence of str
        True for all groups the data has, or some of "inertia", "interface", "loads", "preload"; False for none.
        "inertia" and "interface" belong together: what accelerates the body in vibration are its joints.
    rigid : bool
        Leave out all deformation: the same body, rigid, for comparison.
    markers : mapping of interface or station to pose, optional
        Their axes, in body axes, where a joint's axis is not the z-axis of the mesh:
        ``{"bore": Pose.axes(z=(0, 1, 0))}``. Their positions come from the data.
    skins : mapping of name to Skin, optional
        Parts of its free surface that can touch, for a `SkinSurface`: they move with its modes.

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
    skins: Mapping[str, Any] = field(default_factory=dict)

    drawn: ClassVar[str] = "cells"
    watch: ClassVar[Any] = FloatingWatch
    table: ClassVar[Table] = Table("FloatingBody", ROW, {"place": place, "inertia": inertia, "energy": energy})

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "data", _reduced(self.data))
        if not isinstance(self.data, ModalNeutralData):
            raise ModelError(
                self.title,
                found="no data" if self.data is None else f"data of the class {type(self.data).__name__}",
                expected="ModalNeutralData",
                remedy="Make it with flexmb.reduction.reduce, or load it with ModalNeutralData.load",
            )
        check_frame(self)
        self._check_markers()
        modes = 0 if self.rigid else self.modes
        try:
            reduced = self.data if modes is None else self.data.selected(modes)
        except ModelError as error:
            known = {"expected": error.expected, "remedy": error.remedy}
            raise ModelError(self.title, found=f"modes = {modes!r:.200}", **known) from None
        object.__setattr__(self, "skins", checked_skins(self.skins, self.title, needs=(), lacks=("between",)))
        found: Any = with_skins(reduced, self.skins, self.title) if self.skins else (reduced, {}, {}, {})
        for name, value in zip(("_reduced", "_patches", "_facets", "_thickness"), found, strict=True):
            object.__setattr__(self, name, value)
        m = reduced.n_modes
        damping = finite_array(self.damping)
        fits = m == 0 or damping.shape in ((), (self.data.n_modes,), (m,), (m, m))
        if not fits or (damping.ndim < 2 and np.any(damping < 0.0)):
            raise ModelError(
                self.title,
                found=f"damping = {self.damping!r:.200}",
                expected=f"a fraction >= 0, ({m},) fractions, or a matrix ({m}, {m})",
                remedy="Write damping=0.01 for 1 % of critical damping",
            )
        for doubt in damping_doubts(damping) if damping.ndim < 2 else ():
            tell(f"{self.title}: {doubt}.")
        groups = self.stiffening_groups
        unknown = [name for name in groups if name not in STIFFENING]
        if unknown or self.geometric_stiffness is None:
            raise ModelError(
                self.title,
                found=f"geometric_stiffness = {self.geometric_stiffness!r}",
                expected=f"True, False or some of {', '.join(STIFFENING)}",
                remedy="Use True for all of them",
            )
        if len(BALANCED & {*groups}) == 1 and m and _balances(reduced.geometric):
            (own,), (other,) = BALANCED & {*groups}, BALANCED - {*groups}
            tell(
                f"{self.title} has geometric stiffness of {own} without that of {other}: in vibration they balance "
                "each other, and one of them alone can make it grow without limit. Use both, or "
                "geometric_stiffness=False"
            )

    @classmethod
    def similar(cls, name: str, *, data: ModalNeutralData, scale: float, **fields) -> FloatingBody:
        """Make a body that is geometrically similar to the data: all lengths times `scale`, same material.

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
        data = _reduced(data)
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

        Position and motion refer to the whole; `flexmb.Fixed.at_cuts` joins the parts.
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
        known = self.data.nodes if len(self.data.nodes) else np.vstack([np.zeros(3), self.data.marker_positions])
        near = NEAR * float(np.linalg.norm(np.ptp(known, axis=0)))
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
            if any(pose.at) and np.linalg.norm(np.subtract(pose.at, at)) > near:
                raise ModelError(
                    self.title,
                    found=f"marker {name} at {_told(pose.at)} m",
                    expected=f"its place in the data, {_told(at)} m",
                    remedy="Give axes only, or add a station to the reduction at that place",
                )
            poses[name] = Pose(at, pose.matrix)
        object.__setattr__(self, "markers", poses or None)

    @property
    def reduced(self) -> ModalNeutralData:
        """The data with the modes in use."""
        return self._reduced  # type: ignore[attr-defined]

    @property
    def skin_patches(self) -> Mapping[str, tuple[SkinPatch, ...]]:
        """The pieces of every skin."""
        return self._patches  # type: ignore[attr-defined]

    @property
    def skin_facets(self) -> Mapping[str, SkinFacets]:
        """The faces of the skins that have them."""
        return self._facets  # type: ignore[attr-defined]

    @property
    def skin_thickness(self) -> Mapping[str, float]:
        """Twice the volume per area behind every skin, m."""
        return self._thickness  # type: ignore[attr-defined]

    def momentum(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return linear and angular momentum about the origin of W, (nt, 6)."""
        return floating_momentum(self.reduced, q, u)

    def rest_inertia(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Return mass, first moment (3,) and inertia (3, 3) of the undeformed body about the origin of its frame."""
        i = self.reduced.invariants  # vw0 = -h~
        return self.reduced.mass, np.array([i.vw0[1, 2], i.vw0[2, 0], i.vw0[0, 1]]), i.ww0.copy()

    def modal_link(self) -> ModalLink | None:
        """Return what the body is as a link of a tree; None for planar data."""
        return modal_link(self)

    def link_source(self):
        """Return the data, by identity, and what of the body's own fields the link follows from."""
        turned = tuple((name, pose.at, pose.matrix.tobytes()) for name, pose in (self.markers or {}).items())
        damping = np.asarray(self.damping, float)
        return id(self.reduced), self.stiffening_groups, damping.shape, damping.tobytes(), turned

    @property
    def stiffening_groups(self) -> tuple[str, ...]:
        """Names of the groups of geometric stiffness that act."""
        value = self.geometric_stiffness
        if isinstance(value, bool | np.bool_):
            return STIFFENING if value else ()
        return tuple(str(name) for name in entries_of(value))

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

    @property
    def stations(self) -> tuple[str, ...]:  # type: ignore[override]
        """Markers behind the interfaces; none where the data do not say which are interfaces."""
        data = self.reduced
        return tuple(data.marker_names[data.n_interfaces :]) if data.n_interfaces else ()

    def bounds(self):
        """Return the box around the nodes of the mesh, m, in body axes."""
        nodes = self.reduced.nodes
        return (nodes.min(axis=0), nodes.max(axis=0)) if len(nodes) else super().bounds()

    def initial_state(self):
        """Return (r, p, eta = 0) and the twist in body axes with eta' = 0."""
        q, u = frame_state(self)
        rest = np.zeros(self.n_vector)
        return np.concatenate([q, rest]), np.concatenate([u, rest])

    def record(self, compiler, place):
        """Return the row: invariants, markers and stiffness as bulk data."""
        data = self.reduced
        mass, markers, elastic, stiffening, turning = pack(
            data, self.damping_matrix(), self.stiffening_groups, list(self.marker_poses().values())
        )
        first_load = 0
        for k, name in enumerate(data.load_names):
            index = compiler.load(self.name, name)
            first_load = index if k == 0 else first_load
        return {
            "modes": data.n_modes,
            "interfaces": data.n_interfaces,
            "loads": len(data.load_names),
            "first_load": first_load,
            "turning": turning,
            "stiffening": stiffening,
            "mass": place.bulk(mass),
            "geometry": place.bulk(markers),
            "elastic": place.bulk(elastic),
            "gravity": compiler.gravity,
        }

    def stiffen(self, compiler, markers):
        """Reserve room for the derivatives of the stiffening by the interfaces' wrenches."""
        data = self.reduced
        if data.geometric is None or not data.n_modes or "interface" not in self.stiffening_groups:
            return
        for name in data.marker_names[: data.n_interfaces]:
            number = compiler.marker(f"{self.name}.{name}")
            markers[number]["iH"] = compiler.reserve_H(6 * int(markers[number]["nu"]))


def _balances(geometric: Any) -> bool:
    """Do data have both groups that belong together?"""
    return geometric is not None and bool(np.any(geometric.inertia) and np.any(geometric.interface))


def _told(at) -> str:
    """Return a place in words."""
    return f"({', '.join(f'{x:.6g}' for x in at)})"


def _reduced(data: Any) -> Any:
    """Return the data of a description; anything else as it is."""
    return data.reduced() if isinstance(data, DataSource) else data
