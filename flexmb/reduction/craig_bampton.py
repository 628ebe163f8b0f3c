"""`reduce`: FE model in, modal neutral data out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmb.errors import ReductionError, did_you_mean
from flexmb.fem.fe_model import FEModel
from flexmb.math.factor import Backend
from flexmb.model.described import check_kind, check_mapping, is_number, whole
from flexmb.model.modal_arrays import GeometricStiffness
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.numbering import Numbering
from flexmb.reduction.assembled import check_within
from flexmb.reduction.bases import CraigBampton
from flexmb.reduction.basis import Basis, free_modes, orthonormal_basis
from flexmb.reduction.basis_choice import Chosen, choose_basis, parse_basis
from flexmb.reduction.contact_zone import ContactZone, loads_on_zones, zones_of
from flexmb.reduction.damping import by_dampers, damping_ratios, one_ratio
from flexmb.reduction.framed_body import FramedBody
from flexmb.reduction.geometric import by_loads, geometric_matrices
from flexmb.reduction.interfaces import Coupling, offered, resolve
from flexmb.reduction.invariants import inertia_invariants
from flexmb.reduction.left_out import left_out_stiffness
from flexmb.reduction.load_turning import holding_interface, load_turning, reaction, wrench_turning
from flexmb.reduction.loads import load_vectors, loads_of
from flexmb.reduction.markers import MarkerMotion, interface_motions, station_motions
from flexmb.reduction.mode_choice import HIGHEST, USUAL, UpTo, parse_modes
from flexmb.reduction.quality import quality_numbers
from flexmb.reduction.statics import HeldBody
from flexmb.reduction.stress import middle_surface, stress_modes
from flexmb.reduction.tracks import Track, expanded, loads_on_tracks
from flexmb.reduction.transfer_error import TransferError, transfer_error
from flexmb.reduction.wandering_loads import doubts, tell_missing
from flexmb.told import tell

__all__ = ["joining", "reduce"]

Progress = Callable[[str, float], None]


def reduce(
    fe: FEModel,
    interfaces: Mapping[str, Any] | Sequence[str] | str,
    modes: int | str | UpTo = USUAL,
    *,
    basis: Any = CraigBampton(),  # noqa: B008 # frozen
    geometric_stiffness: bool = False,
    stations: Mapping[str, Any] | None = None,
    loads: Mapping[str, Any] | None = None,
    frame: str = "buckens",
    damping: Any = None,
    stress: bool = True,
    residual_vectors: Sequence[str] | str = (),
    preload: Mapping[str, float] | None = None,
    contact: Any = None,
    compare: int = 6,
    error_up_to: float | None = None,
    backend: Backend | None = None,
    progress: Progress | None = None,
) -> ModalNeutralData:
    """Reduce an FE model to the data of a flexible body (docs/theory/reduction.md), by Craig-Bampton modes by default.

    Parameters
    ----------
    fe : FEModel
        A free body; its elements are needed for stress and geometric stiffness only.
    interfaces : mapping of name to set name, node numbers (list), coordinates (tuple), or a coupling object
        Where joints and forces act. A bare selection is a rigid coupling; see `Rigid`, `Averaging`, `Nodes`.
        Names of the reference points of a deck, or "all" of them, are interfaces by themselves. Numbers are rows of
        ``fe.nodes``; ``"node 63241"`` names a node by its number in the deck.
    modes : int, text or UpTo
        Number of normal modes, usually 12 (0: Guyan), or ``"up to 200 Hz within 1 %"``: of the response to
        the loads of the body; ``"... of the frequencies"`` of the free-free ones, with `CraigBampton` only.
    basis : `CraigBampton`, `Rubin`, `Krylov`, `Pod`, `CharacteristicModes`, `Balanced`, or text
        Which displacements the body has; ``"Krylov frequencies=0,120 order=2"`` is `Krylov` with these fields.
    geometric_stiffness, stress : bool
        Stiffness of unit inertia, interface and distributed loads; stress modes, where the elements give them.
    stations : mapping of name to set name, node numbers or coordinates, m
        Observed points; they need no node.
    loads : mapping of name to facet set, `Pressure`, `LineLoad`, `NodalForces`, `Track` or table
        Load shapes of unit size; a facet set means unit pressure (1 Pa) onto it, against the outward normal.
    frame : str
        "buckens", or the name of the interface at which the body frame is clamped.
    damping : None, float, (m,), `Rayleigh` or `Bands`
        Proposed fraction of critical damping.
    residual_vectors, preload : names of load shapes, or "all"; mapping of load name to factor
        Loads whose static response joins the basis; constant load whose geometric stiffness is always there.
    contact : name of a facet set, `ContactZone`, or several
        Where others will press: responses to pressures on its facets join the basis.
    compare : int
        How many free-free frequencies of the full model are computed for the quality report.
    error_up_to : float, Hz, optional
        Bounds the error of the response to loads up to this frequency, for the report and the check of runs.
    backend, progress : Backend, callable (stage, fraction), or None
        Sparse factorisation, see flexmb.math.factor; a function called with the progress.

    Returns
    -------
    ModalNeutralData
        With `CraigBampton` it has nq + modes - r flexible coordinates. nq counts the freedoms of the interfaces: 6 of a
        rigid or averaging one, otherwise the freedoms of its nodes. r counts the rigid motions of the model: 6, or 3 in
        a plane, see ``quality["rigid_modes"]["removed"]``. Residual vectors add one each.

    Raises
    ------
    ReductionError
        The interfaces or the FE model do not allow it; the message names the place.
    """
    check_kind(fe, FEModel, "Reduction", MADE_BY, ReductionError)
    named = offered(fe, interfaces) if isinstance(interfaces, str | list | tuple) else interfaces
    settings = _Settings(
        named,  # type: ignore[arg-type] # checked below
        parse_modes(modes),
        parse_basis(basis),
        geometric_stiffness,
        stations or {},
        loads or {},
        frame,
        damping,
        stress,
        joining(residual_vectors, loads or {}),
        preload or {},
        zones_of(contact),
        whole(compare),
        error_up_to,
    )
    for words, given in (("interfaces", named), ("stations", stations or {}), ("loads", loads or {})):
        check_mapping(given, "Reduction", words, f'{{"{EXAMPLES[words]}": "name of a set"}}', ReductionError)
    _check_names(settings)
    return _reduced(fe, settings, backend, progress or _silent)


MADE_BY = "Make it with fem.solid(mesh, material), fem.frame, fem.shell or fem.from_matrices"
EXAMPLES = {"interfaces": "a", "stations": "mid", "loads": "air"}


@dataclass(frozen=True, eq=False)
class _Settings:
    """What `reduce` is asked for, apart from how it is computed."""

    interfaces: Mapping[str, Any]
    modes: int | UpTo | None
    basis: Any
    geometric_stiffness: bool
    stations: Mapping[str, Any]
    loads: Mapping[str, Any]
    frame: str
    damping: Any
    stress: bool
    residual_vectors: tuple[str, ...]
    preload: Mapping[str, float]
    contact: Mapping[str, ContactZone]
    compare: int
    error_up_to: float | None


def _silent(stage: str, fraction: float) -> None:
    """Say nothing."""


def _reduced(fe: FEModel, asked: _Settings, backend: Backend | None, say: Progress) -> ModalNeutralData:
    say("interfaces", 0.0)
    couplings = resolve(fe, asked.interfaces)
    markers = interface_motions(fe, couplings) + station_motions(fe, asked.stations)
    shapes, tracks = expanded(fe, asked.loads)
    loads = loads_of(shapes)
    forces = load_vectors(fe, loads)
    names = list(loads)
    if fe.condensed is not None and asked.geometric_stiffness:
        check_within(fe.condensed, names, load_vectors(fe.condensed.whole, loads))
    say("factorisation and constraint modes", 0.05)
    body = HeldBody(fe, couplings, backend)
    say("normal modes", 0.3)
    residual = forces[:, [names.index(name) for name in asked.residual_vectors]]
    rolling, pressing = loads_on_tracks(body, forces, names, tracks), loads_on_zones(body, asked.contact)
    joining = np.hstack([residual, *(load.joining for load in (*rolling.values(), *pressing.values()))])
    clamped = None if asked.frame == "buckens" else _frame_interface(asked.frame, couplings, body)
    framed = FramedBody(body, clamped, markers, forces, joining)
    chosen = choose_basis(framed, asked.basis, asked.modes, joining, asked.damping)
    normal, exact = chosen.normal, chosen.exact
    band = asked.modes.frequency if isinstance(asked.modes, UpTo) else np.inf
    basis = orthonormal_basis(body, normal, clamped, chosen.within)
    say("geometric stiffness", 0.6)
    interfaces, turning = markers[: len(couplings)], load_turning(body, basis.shapes, markers[: len(couplings)], loads)
    matrices, preload_turning = _stiffening(body, basis, interfaces, forces, turning, names, asked, clamped)
    say("full model for comparison", 0.7)
    if exact is None and asked.compare:
        exact = free_modes(body, asked.compare, start=basis.shapes)
    error = _bounded(framed, basis, chosen, asked)
    told = {
        words: tell_missing(body, wandering, (normal, chosen.within), chosen.before())
        for words, wandering in (("tracks", rolling), ("contact", pressing))
        if wandering
    }
    say("invariants, stress modes and report", 0.9)
    body.release_factor()
    quality = quality_numbers(body, chosen, basis, exact, error, clamped, markers[len(couplings) :], band)
    quality |= told
    quality["warnings"] += [text for loads in told.values() for text in doubts(loads)]
    if words := middle_surface(fe) if asked.stress else "":
        tell(words, UserWarning)
        quality["warnings"].append(words)
    dampers, words = by_dampers(fe, basis.shapes, basis.w2, asked.damping)
    if words:
        tell(f"Reduction of '{fe.name}': {words}")
        quality["warnings"].append(words)
    data = _data(fe, markers, basis, names, forces, asked.stress)
    data = replace(
        data,
        n_interfaces=len(couplings),
        damping_ratios=damping_ratios(asked.damping, basis.w2, dampers),
        geometric=None if matrices is None else _of_shapes(matrices, len(basis.w2), len(couplings)),
        left_out=left_out_stiffness(body, basis, interfaces, forces, matrices),
        load_turning=turning,
        preload_turning=preload_turning,
        frame=asked.frame,
        quality=quality,
    )
    say("done", 1.0)
    return data


def _bounded(framed: FramedBody, basis: Basis, chosen: Chosen, asked: _Settings) -> TransferError | None:
    """Return the bound of the error of the response, where it was asked for or is known."""
    if asked.error_up_to is None:
        return chosen.error
    free = framed.freed()
    zeta = one_ratio(asked.damping, free.modes_in_band(asked.error_up_to))
    return transfer_error(free, free.elastic(basis.shapes), asked.error_up_to, zeta)


def _stiffening(
    body: HeldBody,
    basis: Basis,
    interfaces: Sequence[MarkerMotion],
    forces: np.ndarray,
    turning: np.ndarray,
    names: list[str],
    asked: _Settings,
    clamped: int | None,
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Return the geometric stiffness of all loads on the shapes and three turns, (n, m + 3, m + 3), of parts of parts
    on the shapes alone, and how the generalised force of the preload changes with the shapes."""
    if not asked.geometric_stiffness:
        return None, None
    factors = np.array([asked.preload.get(name, 0.0) for name in names])
    constant, held, number = forces @ factors, np.zeros(body.fe.ndof), holding_interface(body)
    change = np.einsum("n,nij->ij", factors, turning) if asked.preload else None
    if change is not None:
        marker = None if number is None else interfaces[number]
        wrench = reaction(body, marker, constant)
        if marker is not None:
            held, change = marker.matrix.T @ wrench, change + wrench_turning(marker, basis.shapes, wrench)
    support = _support(body, number if clamped is None else clamped)
    turns = [] if body.fe.condensed is not None else [body.fe.rigid_motions()[:, 3:]]
    motions = np.hstack([basis.shapes, *turns])
    return geometric_matrices(body, motions, interfaces, forces, constant, support, held), change


def _of_shapes(matrices: np.ndarray, m: int, interfaces: int) -> GeometricStiffness:
    """Return the geometric stiffness of the shapes alone."""
    return GeometricStiffness(**by_loads(np.ascontiguousarray(matrices[:, :m, :m]), interfaces))


def _data(
    fe: FEModel, markers: Sequence[MarkerMotion], basis: Basis, load_names: list[str], forces: np.ndarray, stress: bool
) -> ModalNeutralData:
    """Return what follows from the shapes alone."""
    m, field = len(basis.w2), fe.field(basis.shapes)
    motions = np.stack([marker.matrix @ basis.shapes for marker in markers]) if markers else np.zeros((0, 6, m))
    rotations = field[:, 3:].copy() if np.any(fe.dofs[:, 1] >= 3) else None
    return ModalNeutralData(
        name=fe.name,
        nodes=fe.nodes,
        cells=tuple((b.cell_type, b.connectivity) for b in fe.blocks if len(b.connectivity)),
        shapes=field[:, :3].copy(),
        rotation_shapes=rotations,
        marker_names=tuple(marker.name for marker in markers),
        n_interfaces=0,
        marker_positions=np.array([marker.position for marker in markers]).reshape(-1, 3),
        marker_translations=motions[:, :3],
        marker_rotations=motions[:, 3:],
        stiffness=np.diag(basis.w2),
        damping_ratios=np.zeros(m),
        frequencies=np.sqrt(basis.w2) / (2.0 * np.pi),
        invariants=inertia_invariants(fe, basis.shapes),
        load_names=tuple(load_names),
        load_shapes=np.vstack([fe.rigid_motions().T @ forces, basis.shapes.T @ forces]).T,
        stress_modes=stress_modes(fe, field) if stress and fe.blocks else None,
        node_sets=_node_sets(fe),
        numbering=None if fe.numbering is None else _numbering(fe),
    )


def _node_sets(fe: FEModel) -> dict[str, np.ndarray]:
    """Return the named sets of the model as nodes: where the stress of a region is wanted."""
    facets = {name: np.unique(rows[rows >= 0]) for name, rows in fe.facet_sets.items()}
    sets = {**facets, **fe.node_sets}
    return {name: np.unique(np.asarray(nodes, np.int32)) for name, nodes in sets.items()}


def _numbering(fe: FEModel) -> Numbering:
    """Return the numbers in the file of the nodes, and of the cells that are drawn."""
    counts = [len(block.connectivity) for block in fe.blocks]
    whole = fe.numbering.padded(len(fe.nodes), counts)  # type: ignore[union-attr]
    return replace(whole, cells=tuple(labels for labels in whole.cells if len(labels)))


def _support(body: HeldBody, number: int | None) -> np.ndarray:
    """Hold the unit loads at an interface: where the frame is clamped, or the first that holds the body alone."""
    if number is None:
        return body.determinate_support()
    return np.arange(body.slices[number].start, body.slices[number].stop)


def _frame_interface(frame: str, couplings: Sequence[Coupling], body: HeldBody) -> int:
    names = [c.name for c in couplings]
    number = names.index(frame)
    if len(couplings[number].freedoms) != body.rigid.shape[1]:
        raise ReductionError(
            f"Frame '{frame}'",
            found=f"the interface has {len(couplings[number].freedoms)} freedoms",
            expected=f"{body.rigid.shape[1]}, enough to hold the frame",
            remedy="Clamp the frame at a rigid or averaging interface, or use frame='buckens'",
        )
    return number


def joining(asked: Sequence[str] | str, loads: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of loads that are to join; "all" are those that do not join by themselves."""
    if asked == "all":
        return tuple(name for name, load in loads.items() if not isinstance(load, Track))
    return (asked,) if isinstance(asked, str) else tuple(asked)


def _check_names(asked: _Settings) -> None:
    interfaces, stations, loads, frame = asked.interfaces, asked.stations, asked.loads, asked.frame
    band = asked.error_up_to
    if band is not None and (not is_number(band) or not 0.0 < band <= HIGHEST):
        raise ReductionError(
            "Reduction",
            found=f"error_up_to = {band!r:.80} Hz",
            expected=f"a frequency above 0 and up to {HIGHEST:.0e} Hz",
            remedy="Leave it out for no bound of the error",
        )
    if asked.preload and not asked.geometric_stiffness:
        raise ReductionError(
            "Reduction",
            found="a preload, but geometric_stiffness=False",
            expected="geometric stiffness: a constant load acts through it alone",
            remedy="Write geometric_stiffness=True, or give the load to the mechanism",
        )
    for name, factor in asked.preload.items():
        if not is_number(factor):
            raise ReductionError(
                f"Preload '{name}'",
                found=f"the factor {factor!r}",
                expected="a number",
                remedy='Write preload={"air": 5e3} for 5e3 times the unit load',
            )
    if isinstance(asked.compare, bool) or not isinstance(asked.compare, int | np.integer) or asked.compare < 0:
        raise ReductionError(
            "Reduction",
            found=f"compare = {asked.compare!r}",
            expected="a count from 0 upwards",
            remedy="Give how many frequencies of the full model the report compares",
        )
    common = sorted(set(interfaces) & set(stations))
    if common:
        raise ReductionError(
            f"Station '{common[0]}'",
            found="an interface has the same name",
            expected="different marker names",
            remedy="Rename the station",
        )
    if frame != "buckens" and frame not in interfaces:
        raise ReductionError(
            f"Frame '{frame}'",
            found="no interface of that name",
            expected=f"'buckens' or one of: {', '.join(interfaces) or 'none'}",
            remedy=did_you_mean(frame, interfaces),
        )
    for name in [*asked.residual_vectors, *asked.preload]:
        if name not in loads or isinstance(loads[name], Track):
            raise ReductionError(
                f"Load '{name}'",
                found="a track: its shapes join by themselves" if name in loads else "no load shape of that name",
                expected=f"One of: {', '.join(joining('all', loads)) or 'none'}",
                remedy="Leave it out" if name in loads else did_you_mean(name, joining("all", loads)),
            )
