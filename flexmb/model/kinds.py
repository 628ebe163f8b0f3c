"""The families of parts and what a kind must provide. Descriptions are frozen; kernels live beside their kind."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import check_mapping
from flexmb.model.measurement import Measurement, complaint_of
from flexmb.model.modal_link import ModalLink
from flexmb.model.part import Part
from flexmb.model.part_names import marker_pair
from flexmb.model.pose import Pose
from flexmb.model.primitives import Equation, Freedom
from flexmb.model.table import Compiler, Table

__all__ = ["Body", "Force", "Joint", "Sensor"]


@dataclass(frozen=True, eq=False)
class Body(Part):
    """A body promises marker kinematics: position, orientation, twist and Jacobian of its markers.

    Its configuration is an optional frame (r in W, Euler parameters; 7 numbers, 6 velocities in body axes) followed by
    a plain vector (`n_vector` numbers, as many velocities).
    """

    _: KW_ONLY
    markers: Mapping[str, Any] = None  # type: ignore[assignment]

    family: ClassVar[str] = "Body"
    table: ClassVar[Table | None] = None
    has_frame: ClassVar[bool] = True
    drawn: ClassVar[str] = "shape"
    """What pictures show of it: "supports" (it stands still), "shape", "cells" (of its modal neutral data), "line"
    (with `section_axes`, `section_forces`, `section_strains`) or "sheet" (with `surface_points`, `resultants`)."""
    takes_markers: ClassVar[bool] = False
    """Can its field `markers` hold further poses?"""
    stations: ClassVar[tuple[str, ...]] = ()
    """Markers that only observe: no shape of the body is made for forces there."""
    watch: ClassVar[Any] = None
    """Class (bodies of the kind, system) that measures how far they are from what they hold for; None: nothing."""

    def __post_init__(self):
        super().__post_init__()
        check_mapping({} if self.markers is None else self.markers, self.title, "markers", '{"A": (0.1, 0, 0)}')

    @property
    def n_vector(self) -> int:
        """Number of coordinates beyond the frame."""
        return 0

    @property
    def reduced(self) -> Any:
        """The modal neutral data of a reduced body, with the modes in use; None for all others."""
        return None

    def momentum(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return linear and angular momentum about the origin of W, (nt, 6), for coordinates and velocities (nt, ..).

        Raises
        ------
        ModelError
            If the kind does not tell it.
        """
        raise ModelError(
            self.title,
            found=f"a {type(self).__name__} does not provide its momentum",
            expected="rigid bodies, point masses and floating bodies",
            remedy="Leave the Momentum sensor out of models with this kind of body",
        )

    def rest_inertia(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Return the ten numbers of a body with a frame, undeformed and in its axes, about its origin.

        A point has its mass alone. Mass, kg; first moment (3,), kg m; inertia (3, 3), kg m2.
        """
        raise TypeError(f"{type(self).__name__} does not say what its inertia is")

    def modal_link(self) -> ModalLink | None:
        """Return what a body with a frame and modes is as a link of a tree; None if its kind does not tell."""
        return None

    def link_source(self) -> Hashable | None:
        """Return what `modal_link` follows from: bodies with equal sources are equal links; None: unknown."""
        return None

    @property
    def n_velocities(self) -> int:
        """Number of velocities."""
        return 6 * self.has_frame + self.n_vector

    @property
    def block_size(self) -> int:
        """Number of velocities in a block of the iteration matrix; by default the whole body is one dense block.

        A body of many elements names the velocities of a node as its block, and in `couplings` the nodes that share an
        element. Then the matrix is factorised node by node, at a cost that grows linearly with a chain of elements.
        """
        return self.n_velocities

    def couplings(self) -> np.ndarray:
        """Return the pairs (nc, 2) of blocks that depend on each other, first < second."""
        return np.empty((0, 2), int)

    def marker_blocks(self) -> dict[str, tuple[int, int]]:
        """Return first block and number of blocks that move a marker, by name; by default all move every marker."""
        return {}

    def marker_gaps(self) -> dict[str, tuple[int, ...]]:
        """Return by name the blocks among `marker_blocks` that do not move the marker."""
        return {}

    def marker_poses(self) -> dict[str, Pose]:
        """Return the poses of all markers in body axes, undeformed, by name."""
        raise TypeError(f"{type(self).__name__} does not say what its markers are")

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the box around the material of a body with a frame, least and largest coordinates, m, in its axes.

        By default around its markers: what is beyond acts on nothing.
        """
        at = np.array([pose.at for pose in self.marker_poses().values()] or [(0.0, 0.0, 0.0)])
        return at.min(axis=0), at.max(axis=0)

    def initial_state(self) -> tuple[np.ndarray, np.ndarray]:
        """Return configuration and velocity at the start."""
        raise TypeError(f"{type(self).__name__} does not say where it starts")

    def record(self, compiler: Compiler, place: Compiler) -> dict[str, Any]:
        """Return fields of the body's row by name (see `Table.filled`); `place.bulk(array)` stores bulk data."""
        raise TypeError(f"{type(self).__name__} does not write a row")

    def inversion(self, q: np.ndarray) -> tuple[int, str] | None:
        """Return the first sample (nt, nq) at which an element has collapsed or turned inside out,
        and which; or None.
        """
        return None

    def stiffen(self, compiler, markers: np.ndarray) -> None:
        """Mark in the marker table the markers whose wrenches stiffen the body (reduced bodies only)."""


@dataclass(frozen=True, eq=False)
class Joint(Part):
    """A joint forbids relative motions of two markers and permits the others."""

    _: KW_ONLY
    markers: tuple[str, str] = ("", "")

    family: ClassVar[str] = "Joint"
    forbids: ClassVar[tuple[Equation, ...]] = ()
    permits: ClassVar[tuple[Freedom, ...]] = ()
    prescribes: ClassVar[bool] = False
    """Does it drive the coordinate of another joint?"""
    works: ClassVar[bool] = False
    """Can its ideal force do work on what moves as it demands, by its equations alone?"""
    couples: ClassVar[bool] = False
    """Does it relate the coordinates of other joints?"""
    drawn: ClassVar[str] = "freedoms"
    """What pictures show of it: "freedoms" (solids that permit what it permits), "link" (a bar from marker to marker)
    or "shapes" (nothing: the shapes of its bodies show it)."""

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "markers", marker_pair(self.markers, self.title))

    def check(self, model) -> None:
        """Raise ModelError if a marker does not exist or both are on one body."""
        (a, _), (b, _) = (model.marker(m, self.title) for m in self.markers)
        if a.name == b.name:
            raise ModelError(
                self.title,
                found=f"both markers are on body '{a.name}'",
                expected="markers of two bodies",
                remedy="Joints act between different bodies",
            )

    def equations(self) -> tuple[Equation, ...]:
        """Return the primitive equations of this joint (of its fields, where they depend on them)."""
        return self.forbids

    @property
    def coordinates(self) -> tuple[Freedom, ...]:
        """Freedoms that drives, couplers and forces may act on."""
        return self.permits

    def equations_in(self, model) -> tuple[Equation, ...]:
        """Return the primitive equations of this joint, where they depend on other joints of the model."""
        return self.equations()

    def resolved(self, positions: np.ndarray):
        """Return the joint with its defaults taken from the marker positions (2, 3), m, in W, as described."""
        return self

    def watched(self, model) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        """Return scalars that forces of the joint read, and their programs: steps end where these are not smooth."""
        return (), ()

    def places(self, model) -> tuple[str, ...]:
        """Return the markers whose coordinates in W it relates; joints between bodies have none."""
        return ()

    def resolved_markers(self, model) -> tuple[str, ...]:
        """Return the names of the two markers (a drive has its joint's markers, a coupler the four of both joints)."""
        return self.markers


@dataclass(frozen=True, eq=False)
class Force(Part):
    """A force acts on markers or load shapes."""

    family: ClassVar[str] = "Force"
    reads_reactions: ClassVar[bool] = False
    """Does it depend on the multipliers of joints (friction)?"""
    strikes: ClassVar[bool] = False
    """Does it begin at a place and stiffen from there (contacts, stops)?"""
    attracts: ClassVar[bool] = False
    """Is it the attraction by the centre of an orbit that the origin of W may follow?"""
    flattens: ClassVar[bool] = False
    """Does it add the flattening of that centre?"""
    lasting: ClassVar[bool] = False
    """Does it rule motions over many revolutions, in which the errors of steps add up (orbits)?"""
    without_value: ClassVar[str] = ""
    """What to do where its law has no value, beyond its range."""
    holds_turns: ClassVar[bool] = False
    """Can it hold its markers against turning?"""
    unseen: ClassVar[str] = ""
    """What steps do not see of its law, and what to do: runs and checks say it."""
    table: ClassVar[Table]

    def unseen_in(self, model) -> str:
        """Return what steps do not see of its law in a model."""
        return self.unseen

    def feels(self, system, work, equation: int) -> bool:
        """Does it change with the multiplier of an equation of its joint, if it reads reactions?"""
        return True

    def slip_unit(self, model) -> str:
        """Return the unit, m or rad, of the way that its friction lets go what should stand; "" without it."""
        return ""

    def travels(self, model) -> Any:
        """Return the share that it has in a load that travels over a track of a body; None if it has none."""
        return None

    @property
    def impulsive(self) -> bool:
        """Does it stop bodies at once, by impulses, so that it needs a method of impulses?"""
        return False

    def require_marker_pair(self) -> None:
        """Raise ModelError if the field `markers` is not a pair of names; store it as a tuple."""
        object.__setattr__(self, "markers", marker_pair(self.markers, self.title))  # type: ignore[attr-defined]

    def measure(self, model) -> str | None:
        """Return the marker at which `ForceOf` reports the wrench (the second one)."""
        markers = getattr(self, "markers", None)
        return markers[1] if markers else getattr(self, "marker", None)

    def in_statics(self, system, start, markers: np.ndarray) -> Force:
        """Return what stands for this force while an equilibrium is sought from a state, with the same states.

        Parameters
        ----------
        system, start : System, State
            With signals as they are at the time of the equilibrium.
        markers : records of the evaluated markers, by number
        """
        return self

    def undirected(self, place: Callable[[str], np.ndarray]) -> str:
        """Return what of it has no direction where its markers are; `place` returns the position of a marker in W."""
        return ""

    def complaint(self) -> str:
        """Return what went wrong while this force was evaluated (forces that call foreign functions)."""
        return next((told for value in vars(self).values() if (told := complaint_of(value))), "")

    def record(self, compiler: Compiler) -> dict[str, Any]:
        """Return fields of the row by name, where they differ from the fields of the force (see `Table.filled`)."""
        raise TypeError(f"{type(self).__name__} does not write a row")


@dataclass(frozen=True, eq=False)
class Sensor(Part):
    """A quantity read from the state."""

    family: ClassVar[str] = "Sensor"
    reads_reactions: ClassVar[bool] = False
    """Do its values come from the multipliers of its `joint`? Then reading them warns where joints share a load."""
    absent: ClassVar[float] = math.nan
    """Value in phases whose model has lost the part that is read: a joint that is gone carries no load."""
    titles: ClassVar[tuple[str, ...]] = ("",)
    """Titles of the columns with units, where they depend on nothing."""
    known_later: ClassVar[str] = "it is computed from the samples of a run"
    """Why it cannot be measured while the motion is computed, if it cannot."""

    def check(self, model) -> None:
        """Raise ModelError if a marker that it reads does not exist."""
        for marker in self.markers_read(model):
            model.marker(marker, self.title)

    def columns(self, model) -> tuple[str, ...]:
        """Return the titles of the columns of the values, with units: ("fx [N]", ...)."""
        return self.titles

    def joined(self, pieces) -> np.ndarray:
        """Return the values of consecutive phases as one array."""
        return np.concatenate(pieces)

    def markers_read(self, model) -> tuple[str, ...]:
        """Return the names of the markers whose motion this sensor needs."""
        return ()

    def doubt(self, model) -> str:
        """Return what is perhaps not meant by what it reads, if anything."""
        return ""

    def followed(self, compiler: Compiler) -> list[tuple[Table, dict[str, Any]]]:
        """Return the tables and rows, by field name, of what must be followed from step to step (turns of a joint)."""
        return []

    def measured(self, model) -> tuple[Any, ...]:
        """Return the scalars (`flexmb.constraints.Measured`), one for each column, that can be read while the motion is
        computed, with their gradients; ModelError for quantities that are known only afterwards.
        """
        raise ModelError(
            self.title,
            found=f"{type(self).__name__} cannot be measured while the motion is computed: {self.known_later}",
            expected="Position, Velocity, AngularVelocity, Distance, JointCoordinate or AxisCosine; in loops State too",
            remedy="Measure positions, velocities or joint coordinates",
        )

    def signal(self) -> Any:
        """Return the signal whose value this is; None for what is measured."""
        return None

    def reading(self, column: int = 0) -> Measurement:
        """Return a column of it as a signal, measured while the motion is computed."""
        return Measurement(self, column)

    def values(self, series) -> np.ndarray:
        """Return the quantity at every time of the `series` (see results), (nt,) or (nt, k)."""
        raise TypeError(f"{type(self).__name__} has no values")
