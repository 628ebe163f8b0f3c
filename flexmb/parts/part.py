"""`Part`: a flexible body as a description: finite elements, and how they are reduced."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from flexmb.errors import FlexmbError, ModelError
from flexmb.fem.deck import read_deck
from flexmb.fem.fe_model import FEModel
from flexmb.fem.joined import joined
from flexmb.model.data_source import plain
from flexmb.model.described import Described, check_mapping, entries_of, is_number, whole
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.parts.body_cache import kept
from flexmb.parts.fingerprint import fingerprint
from flexmb.parts.limits import check_count, check_file
from flexmb.parts.nodal_loads import Each
from flexmb.parts.places import check_near
from flexmb.parts.watchers import tell_progress
from flexmb.reduction.craig_bampton import joining, reduce
from flexmb.reduction.mode_choice import USUAL, parse_modes
from flexmb.told import speaking_of

__all__ = ["Part"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Part(metaclass=Described):
    """A flexible body that is described, not stored: it is reduced when it is asked for, and kept by its content.

    Parameters
    ----------
    name : str
    pieces : list of Line, Plate, MeshFile, Extrusion
        What the finite elements are; nodes of different pieces at the same place become one.
    deck : path
        Instead of pieces: a whole deck of Nastran, Abaqus or CalculiX, as in `flexmb.fem.read_deck`.
    units : str, of a deck
        "mm, t, s", what the deck is written in.
    lumped : bool, of a deck
        Masses lumped at nodes; by default as the deck says.
    stress_side : float, of a deck
        Side of shells whose stress is kept: -1 (bottom), 0 (middle) or +1 (top). Pieces have their own.
    links : list of Arm, RigidLink, AveragingLink
        In this order, after the pieces are joined.
    masses : list of Mass, Spring
        After the links.
    interfaces : mapping of name to place, or "all" of a deck
        Where joints and forces act: the name of a set, node numbers, three coordinates (m), `Rigid`, `Averaging` or
        `Nodes`. A bare place is a rigid coupling.
    modes : int or str
        How many normal modes, usually 12; or "up to 200 Hz within 1 %".
    basis : kind of basis, or text
        Which displacements the body has: `CraigBampton` unless given, or "Krylov frequencies=0,120 order=2".
    stations : mapping of name to place
        Points that are only observed: places as of interfaces, or `Each`; they need no node.
    loads : mapping of name to load
        Load shapes of unit size. The name of a surface alone is a unit pressure (1 Pa) onto it.
    residual_vectors : list of str, or "all"
        Loads whose static response joins the basis.
    geometric_stiffness : bool
        Keep how inertia, interface loads and load shapes change the stiffness.
    stress : bool
        Keep the stress of solids and shells.
    frame : str
        "buckens", or the name of the interface at which the body frame is clamped.
    damping : float, list of float, `Rayleigh` or `Bands`, -
        Fraction of critical damping of all modes, or of each.
    preload : mapping of load to float
        Constant loads, as factors of load shapes, whose geometric stiffness is always there.
    contact : str, or several
        Surfaces on which others will press: responses to pressures there join the basis.
    compare : int
        How many frequencies of the full model are computed for the report.
    error_up_to : float, Hz
        Bounds the error of the response to loads up to this frequency.
    parameters, model : mapping of name to value, and name of the model file
        What the description was made with; noted in the data, without a part in what is computed.
    """

    files: ClassVar[tuple[str, ...]] = ("deck",)

    name: str = "part"
    pieces: Any = ()
    deck: Any = None
    units: str | None = None
    lumped: bool | None = None
    stress_side: float | None = None
    links: Any = ()
    masses: Any = ()
    interfaces: Any = field(default_factory=dict)
    modes: Any = USUAL
    basis: Any = None
    stations: Mapping[str, Any] = field(default_factory=dict)
    loads: Mapping[str, Any] = field(default_factory=dict)
    residual_vectors: Any = ()
    geometric_stiffness: bool = False
    stress: bool = True
    frame: str = "buckens"
    damping: Any = None
    preload: Mapping[str, float] = field(default_factory=dict)
    contact: Any = None
    compare: int = 6
    error_up_to: float | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    model: str = ""

    @property
    def title(self) -> str:
        """How messages call it."""
        return f"Part '{self.name}'"

    def __post_init__(self):
        for name in ("pieces", "links", "masses"):
            given = getattr(self, name)
            entries = entries_of(given)
            offered = "finite_elements" if name == "pieces" else "applied"
            wrong = [entry for entry in entries if not hasattr(entry, offered)]
            if wrong:
                raise ModelError(
                    f"{self.title}, {name}",
                    found=f"{wrong[0]!r:.80}",
                    expected="descriptions of flexmb.parts, in model files tables with kind",
                    remedy="See the reference of parts",
                )
            object.__setattr__(self, name, entries)
        if bool(self.pieces) == (self.deck is not None):
            raise ModelError(
                self.title,
                found="both pieces and a deck" if self.pieces else "neither pieces nor a deck",
                expected="what the finite elements are, in one way",
                remedy='Write pieces = [{ kind = "Line", ... }], or deck = "flap.bdf"',
            )
        if self.deck is not None:
            check_file(Path(self.deck), f"{self.title}, deck")
            self._check_of_deck()
        elif given := [name for name in ("units", "lumped", "stress_side") if getattr(self, name) is not None]:
            raise ModelError(
                self.title,
                found=f"{given[0]} = {getattr(self, given[0])!r} without a deck",
                expected="SI units everywhere else, a MeshFile has scale; lumped and stress_side are fields of pieces",
                remedy=f"Remove {given[0]}",
            )
        for words in ("stations", "loads"):
            check_mapping(getattr(self, words), self.title, words, '{"tip": "name of a set"}')
        if isinstance(self.interfaces, np.ndarray) or not self.interfaces:
            raise ModelError(
                f"{self.title}, interfaces",
                found="none",
                expected="the places where joints and forces hold the part: its modes and deflections follow from them",
                remedy='Write interfaces = { root = "start", tip = "end" }',
            )
        names = [piece.name for piece in self.pieces if piece.name]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ModelError(
                f"{self.title}, pieces",
                found=f"the name '{twice}' twice",
                expected="a name for each piece",
                remedy="Rename one of them",
            )
        asked = self.residual_vectors
        asked = joining(asked, self.loads) if isinstance(asked, str) and asked == "all" else entries_of(asked)
        if not all(isinstance(name, str) for name in asked):
            raise ModelError(
                f"{self.title}, residual_vectors",
                found=f"{self.residual_vectors!r:.80}",
                expected='names of loads, or "all"',
                remedy='Write residual_vectors = "all"',
            )
        object.__setattr__(self, "residual_vectors", asked)
        object.__setattr__(self, "modes", whole(self.modes))
        try:
            parse_modes(self.modes)
        except FlexmbError as error:
            raise ModelError(
                self.title,
                found=error.found,
                expected=error.expected,
                remedy='Write modes = 8 or modes = "up to 200 Hz within 1 %", or leave it out for 12',
            ) from None

    def reduced(self) -> ModalNeutralData:
        """Return the data of the body: from the cache, or reduced now."""
        recipe = self.recipe()
        data = kept(self.name, recipe, self._made)
        noted = {"parameters": plain(self.parameters), "model": self.model}
        return replace(data, recipe={**recipe, **noted})

    def recipe(self) -> dict[str, Any]:
        """Return what the body is made from, as JSON can hold it: the description and the contents of its files."""
        own = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("parameters", "model")}
        loads = {name: load for name, load in self.loads.items() if hasattr(load, "content")}
        files = {Path(p.file).name: p.content() for p in (*self.pieces, *loads.values()) if hasattr(p, "content")}
        if self.deck is not None:
            files[Path(self.deck).name] = self._deck_content()
            own["deck"] = Path(self.deck).name
        described = plain({name: value for name, value in own.items() if value is not None})
        for entry, piece in zip(described["pieces"], self.pieces):
            if hasattr(piece, "content"):
                entry["file"] = Path(piece.file).name
        for name, load in loads.items():
            described["loads"][name]["file"] = Path(load.file).name
        return {"part": described, "files": files}

    def _check_of_deck(self) -> None:
        if self.lumped is not None and not isinstance(self.lumped, bool):
            raise ModelError(
                self.title, found=f"lumped = {self.lumped!r}", expected="true or false", remedy="Write lumped = false"
            )
        if self.stress_side is not None and not (is_number(self.stress_side) and abs(self.stress_side) <= 1.0):
            raise ModelError(
                self.title,
                found=f"stress_side = {self.stress_side!r}",
                expected="-1 (bottom), 0 (middle) or +1 (top)",
                remedy="Write stress_side = 1 for the outer fibres on top",
            )

    def _read(self) -> FEModel:
        return read_deck(self.deck, units=self.units, lumped=self.lumped, stress_side=self.stress_side, show=False)

    def _deck_content(self) -> dict[str, str]:
        data = Path(self.deck).read_bytes()
        found = {"sha256": hashlib.sha256(data).hexdigest()}
        upper = data.upper()
        if b"INCLUDE" in upper or b"INPUT" in upper:  # what it includes counts too
            found["read"] = fingerprint(self._read(), ())
        return found

    def finite_elements(self) -> FEModel:
        """Return the FE model: pieces joined, links, masses and springs in place."""
        if self.deck is not None:
            fe = replace(self._read(), name=self.name)
        else:
            models, nodes = [], 0
            for piece in self.pieces:
                models.append(_prefixed(piece))
                nodes += len(models[-1].nodes)
                check_count(nodes / 4.0, self.title, "elements")  # quadratic elements have up to as many nodes each
            fe = models[0] if len(models) == 1 else joined(*models)
            fe = replace(fe, name=self.name)
        for tie in (*self.links, *self.masses):
            fe = tie.applied(fe)
        self._check_one_piece(fe)
        return fe

    def _made(self) -> ModalNeutralData:
        """Reduce the finite elements."""
        say = lambda stage, fraction: tell_progress(self.name, stage, fraction)  # noqa: E731
        try:
            say("finite elements", 0.0)
            with speaking_of(self.title):
                fe = self.finite_elements()
            loads = {
                name: load.on_nodes(fe, f"Load '{name}'") if hasattr(load, "on_nodes") else load
                for name, load in self.loads.items()
            }
            stations: dict[str, Any] = {}
            for name, place in self.stations.items():
                stations.update(place.stations(fe, name) if isinstance(place, Each) else {name: place})
                check_near(fe, place, f"Station '{name}'")
            return reduce(
                fe,
                self.interfaces,
                modes=self.modes,
                **({} if self.basis is None else {"basis": self.basis}),
                geometric_stiffness=self.geometric_stiffness,
                stations=stations,
                loads=loads,
                frame=self.frame,
                damping=self.damping,
                stress=self.stress,
                residual_vectors=tuple(self.residual_vectors),
                preload=self.preload,
                contact=self.contact,
                compare=self.compare,
                error_up_to=self.error_up_to,
                progress=say,
            )
        except FlexmbError as error:
            if error.part.startswith(self.title):
                raise
            raise type(error)(
                f"{self.title}: {error.part}", found=error.found, expected=error.expected, remedy=error.remedy
            ) from None

    def _check_one_piece(self, fe: FEModel) -> None:
        """Raise ModelError if the part falls apart: pieces that were meant to meet do not."""
        if self.deck is not None:
            return  # decks hold what they hold; reduction tells about mechanisms
        coupled = fe.K.tocoo()
        nodes = fe.dofs[:, 0]
        graph = sparse.coo_matrix(
            (np.ones(coupled.nnz), (nodes[coupled.row], nodes[coupled.col])), (len(fe.nodes),) * 2
        )
        label = connected_components(graph, directed=False)[1]
        own = np.unique(label[nodes])
        if len(own) > 1:
            places = [np.round(fe.nodes[nodes[label[nodes] == piece]].mean(axis=0), 6).tolist() for piece in own[:2]]
            raise ModelError(
                self.title,
                found=f"{len(own)} separate pieces, the first about {places[0]} m, another about {places[1]} m",
                expected="pieces with common nodes, or links between them",
                remedy="Let them share points (the same size on a common edge), or add a RigidLink",
            )


def _prefixed(piece: Any) -> FEModel:
    """Return the elements of a piece; a named line or mesh puts its name before its sets' names."""
    fe = piece.finite_elements()
    own = set(getattr(piece, "nodes", {}))
    prefix = f"{piece.name}." if piece.name else ""
    new = lambda name: name if name in own or name.split(".")[0] == piece.name else prefix + name  # noqa: E731
    sets = {new(name): nodes for name, nodes in fe.node_sets.items()}
    if piece.name and piece.name not in sets:
        sets[piece.name] = np.arange(len(fe.nodes))
    return replace(fe, node_sets=sets, facet_sets={new(name): facets for name, facets in fe.facet_sets.items()})
