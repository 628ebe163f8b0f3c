"""What cables and beams share: a line of nodes in W, its section and material, places of markers along it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar

import numpy as np

from flexmb.bodies.frame_state import check_frame, check_initial_strain
from flexmb.bodies.line.curve import Curve, curve_through
from flexmb.bodies.line.sections import checked_masses, checked_sections, section_constants
from flexmb.bodies.line.skin import tube_patches
from flexmb.bodies.line.stretches import Stretch, checked_stretches, places_of
from flexmb.errors import ModelError
from flexmb.model.described import is_number
from flexmb.model.kinds import Body
from flexmb.model.material import Material
from flexmb.model.plausibility import material_doubts, section_doubts
from flexmb.model.pose import rotation3
from flexmb.model.skin import SkinFacets, SkinPatch, checked_skins
from flexmb.told import tell

__all__ = ["AncfLine", "between_middles", "element_momentum"]

MOST = 100_000
"""Elements of one line: so many of a cable take half a minute to check, and 2 GB."""

COLLAPSED = 0.01
"""Share of its length or volume below which an element counts as collapsed."""


@dataclass(frozen=True, eq=False)
class AncfLine(Body):
    """A line of elements whose nodes have positions and gradients in W; its fields are described by the kinds."""

    name: str
    _: KW_ONLY
    points: Any
    elements: int
    section: Any
    material: Material
    at: Any = (0.0, 0.0, 0.0)
    rotation: Any = None
    tangents: Any = None
    initial_strain: float = 0.0
    straight: bool = False
    velocity: Any = (0.0, 0.0, 0.0)
    angular_velocity: Any = (0.0, 0.0, 0.0)
    lumped_masses: Any = ()
    stretches: Mapping[str, Any] = field(default_factory=dict)
    markers: Mapping[str, Any] = field(default_factory=dict)
    skins: Mapping[str, Any] = field(default_factory=dict)

    has_frame: ClassVar[bool] = False
    drawn: ClassVar[str] = "line"
    node_size: ClassVar[int]
    intervals: ClassVar[int] = 1
    """Distances between nodes in an element."""
    needs: ClassVar[tuple[str, ...]] = ()
    """What the section must have."""
    closed: ClassVar[bool] = False
    force_titles: ClassVar[tuple[str, ...]]
    strain_titles: ClassVar[tuple[str, ...]]

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "_sections", checked_sections(self.section, self.needs, self.title))
        object.__setattr__(self, "lumped_masses", checked_masses(self.lumped_masses, self.title))
        if not isinstance(self.material, Material):
            raise ModelError(
                self.title,
                found=f"material = {self.material!r}",
                expected="a Material",
                remedy="Write material=fmb.MATERIALS['steel']",
            )
        check_frame(self)
        check_initial_strain(self)
        self._check_elements()
        curve = curve_through(
            self.points, self.elements * self.intervals, self.title, tangents=self.tangents, closed=self.closed
        )
        R = np.asarray(self.rotation)
        object.__setattr__(self, "_curve", Curve(np.array(self.at) + curve.r @ R.T, curve.t @ R.T, curve.length))
        object.__setattr__(self, "points", np.asarray(self.points, float))
        object.__setattr__(self, "markers", dict(self.markers or {}))
        stretches = checked_stretches(self.stretches, self.elements, curve.length, self.title)
        object.__setattr__(self, "_stretches", stretches)
        self._doubt(curve.length)
        own = {name: self._place(name, value) for name, value in {"start": 0.0, "end": 1.0, **self.markers}.items()}
        object.__setattr__(self, "skins", checked_skins(self.skins, self.title, needs=("radius",), lacks=("nodes",)))
        places, patches, facets = tube_patches(self.skins, curve.length, self.title)
        object.__setattr__(self, "_places", own | places_of(stretches) | places)
        object.__setattr__(self, "_patches", patches)
        object.__setattr__(self, "_facets", facets)

    def _doubt(self, length: float) -> None:
        """Warn of a material, or of sections beside the length, m, that can hardly be meant."""
        found = material_doubts(self.material.young, self.material.density)
        for section in self.sections[:1]:
            moments = [getattr(section, name, 0.0) for name in ("inertia_y", "inertia_z")]
            # the depth of a rectangle with that radius of gyration
            found += section_doubts(float(np.sqrt(12.0 * max(moments) / section.area)), length, "a section")
        for text in found:
            tell(f"{self.title}: {text}")

    def _check_elements(self) -> None:
        least = 3 if self.closed else 1
        if not isinstance(self.elements, int | np.integer) or not least <= self.elements <= MOST:
            raise ModelError(
                self.title,
                found=f"elements = {self.elements!r}",
                expected=f"a whole number from {least} to {MOST}" + (" for a closed line" if self.closed else ""),
                remedy="Write elements=16",
            )

    def _place(self, name: str, value) -> tuple[float, np.ndarray | None]:
        fraction, rotation = value if isinstance(value, tuple | list) and len(value) == 2 else (value, None)
        if not is_number(fraction) or not 0.0 <= fraction <= 1.0:
            raise ModelError(
                self.title,
                found=f"marker {name} at {fraction!r}",
                expected="a fraction of the length, 0 to 1, or (fraction, rotation)",
                remedy=f"Write markers={{'{name}': 0.5}}",
            )
        return float(fraction), None if rotation is None else rotation3(
            rotation, self.title, f"rotation of marker {name}"
        )

    @property
    def curve(self) -> Curve:
        """The nodes of the initial line, in W."""
        return self._curve  # type: ignore[attr-defined]

    @property
    def places(self) -> dict[str, tuple[float, np.ndarray | None]]:
        """Fraction of the length and given rotation of every marker."""
        return self._places  # type: ignore[attr-defined]

    @property
    def element_length(self) -> float:
        """Length of an element as drawn, m."""
        return self.curve.length / self.elements

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
        return {name: skin.radius for name, skin in self.skins.items()}

    @property
    def loaded_stretches(self) -> dict[str, Stretch]:
        """The stretches for distributed loads, by name."""
        return self._stretches  # type: ignore[attr-defined]

    @property
    def sections(self) -> tuple[Any, ...]:
        """Sections at equal distances along the line; one is the same everywhere."""
        return self._sections  # type: ignore[attr-defined]

    def constants(self, fractions, *names: str) -> np.ndarray:
        """Return constants of the section by name at fractions (n,) of the length: (len(names), n)."""
        return section_constants(self.sections, fractions, names)

    def masses_of(self, e: int) -> list[tuple[float, float]]:
        """Return place in the element, 0 to 1, and mass, kg, of the lumped masses on element e."""
        found = [(*self.element_at(fraction), mass) for fraction, mass in self.lumped_masses]
        return [(x, mass) for element, x, mass in found if element == e]

    @property
    def mass(self) -> float:
        """Mass, kg, lumped masses included."""
        q, u = self.initial_state()
        u = np.zeros_like(u).reshape(-1, self.node_size)
        u[:, 0] = 1.0
        return float(self.momentum(q[None], u.reshape(1, -1))[0, 0])

    @property
    def n_vector(self) -> int:
        """Coordinates of all nodes."""
        return self.node_size * len(self.curve.r)

    @property
    def block_size(self) -> int:
        """A node is a block of the iteration matrix."""
        return self.node_size

    def element_nodes(self) -> np.ndarray:
        """Return the nodes of every element (elements, intervals + 1)."""
        first = self.intervals * np.arange(self.elements)
        return (first[:, None] + np.arange(self.intervals + 1)) % len(self.curve.r)

    def couplings(self) -> np.ndarray:
        """Return the pairs of nodes in every element."""
        nodes = self.element_nodes()
        pairs = [(i, j) for i in range(self.intervals) for j in range(i + 1, self.intervals + 1)]
        return np.stack([nodes[:, pair] for pair in pairs], axis=1).reshape(-1, 2)

    def element_at(self, fraction: float) -> tuple[int, float]:
        """Return the element and the place in it, 0 to 1, of a fraction of the length."""
        at = fraction * self.elements
        steps = at * self.intervals
        if abs(steps - round(steps)) < 1e-9 * max(1.0, steps):
            at = round(steps) / self.intervals
        e = min(int(at), self.elements - 1)
        return e, at - e

    def elements_at(self, fractions) -> tuple[np.ndarray, np.ndarray]:
        """Return the elements (n,) and places in them, 0 to 1, of fractions (n,) of the length."""
        found = [self.element_at(float(fraction)) for fraction in np.atleast_1d(fractions)]
        return np.array([e for e, _ in found], int), np.array([x for _, x in found], float)

    def marker_nodes(self, fraction: float) -> np.ndarray:
        """Return the nodes that move a marker: the node at its place, or the nodes of its element."""
        e, x = self.element_at(fraction)
        nodes = self.element_nodes()[e]
        step = x * self.intervals
        return nodes[[round(step)]] if step == round(step) else nodes

    def marker_blocks(self) -> dict[str, tuple[int, int]]:
        """Return the nodes that move each marker."""
        blocks = {}
        for name, (fraction, _) in self.places.items():
            nodes = self.marker_nodes(fraction)
            if nodes[0] <= nodes[-1]:
                blocks[name] = int(nodes[0]), len(nodes)
        return blocks

    def marker_gaps(self) -> dict[str, tuple[int, ...]]:
        """Return the nodes between the last and the first, where a marker is on the element that closes the line."""
        between = tuple(range(1, len(self.curve.r) - 1))
        nodes = {name: self.marker_nodes(fraction) for name, (fraction, _) in self.places.items()}
        return {name: between for name, found in nodes.items() if found[0] > found[-1]}

    def rigid_velocities(self, gradients: np.ndarray) -> np.ndarray:
        """Return the rates of positions and gradients (n, k, 3) of the nodes in the rigid motion at the start."""
        w = np.array(self.angular_velocity)
        r = np.array(self.velocity) + np.cross(w, self.curve.r - np.array(self.at))
        return np.concatenate([r[:, None], np.cross(w, gradients)], axis=1)

    def shares_of_size(self, q: np.ndarray) -> np.ndarray:
        """Return what is left of the elements (elements,) of their length or volume as drawn, q (nq,);
        < 0: inverted.
        """
        raise TypeError(f"{type(self).__name__} does not say how its elements collapse")

    def inversion(self, q: np.ndarray) -> tuple[int, str] | None:
        """Return the first sample (nt, nq) at which an element has collapsed or turned inside out,
        and which; or None.
        """
        for k, row in enumerate(q):
            share = self.shares_of_size(row)
            if not share.min() > COLLAPSED:
                e = int(np.argmin(np.where(np.isfinite(share), share, -np.inf)))
                how = "turned inside out" if share[e] < 0.0 else f"collapsed to {100.0 * share[e]:.2g} % of its size"
                return k, f"element {e} of {self.elements} has {how}"
        return None

    def element_mass(self) -> tuple[np.ndarray, np.ndarray]:
        """Return masses of the elements' vectors (elements, nv, nv) and their moments (elements, nv), kg (m, m2)."""
        raise TypeError(f"{type(self).__name__} does not say what its mass is")

    def momentum(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return linear and angular momentum about the origin of W, (nt, 6), for coordinates and velocities (nt, nq).

        Positions and gradients are vectors q_s with x = sum of N_s q_s: P = sum m_s u_s, L = sum M_st q_s x u_t.
        """
        return element_momentum(self.element_nodes(), *self.element_mass(), q, u)


def element_momentum(nodes, mass, moments, q, u) -> np.ndarray:
    """Return linear and angular momentum (nt, 6) of elements with `nodes` (ne, k) for q, u (nt, nq).

    Every node has the same number of vectors; masses (ne, nv, nv) and moments (ne, nv) are per element.
    """
    width = moments.shape[1] // nodes.shape[1]
    of_element = (width * nodes[:, :, None] + np.arange(width)).reshape(len(nodes), -1)
    x, v = (np.asarray(z, float).reshape(len(z), -1, 3)[:, of_element] for z in (q, u))
    P = np.einsum("es,nesi->ni", moments, v)
    return np.hstack([P, np.cross(x, np.einsum("est,neti->nesi", mass, v)).sum(axis=(1, 2))])


def between_middles(values: np.ndarray, fractions) -> np.ndarray:
    """Return values (elements, ...) of the elements' middles at fractions of the length, linear between and beyond."""
    n, fractions = len(values), np.atleast_1d(np.asarray(fractions, float))
    if n == 1:
        return np.repeat(values, len(fractions), axis=0)
    at = fractions * n - 0.5
    k = np.clip(np.floor(at).astype(int), 0, n - 2)
    share = (at - k).reshape((-1,) + (1,) * (values.ndim - 1))
    return values[k] + share * (values[k + 1] - values[k])
