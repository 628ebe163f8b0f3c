"""The basis that is asked for, as large as it must be: by its description, by a number, or by an accuracy."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields
from typing import Any

import numpy as np

from flexmb.errors import ReductionError, did_you_mean
from flexmb.reduction.bases import (
    Balanced,
    CharacteristicModes,
    CraigBampton,
    Krylov,
    Pod,
    Rubin,
    SpannedBasis,
    described,
)
from flexmb.reduction.basis import NormalModes, available_modes, orthonormal_basis, with_residuals
from flexmb.reduction.damping import one_ratio
from flexmb.reduction.framed_body import FramedBody
from flexmb.reduction.mode_choice import UpTo, choose_modes
from flexmb.reduction.subspace import in_coordinates, orthonormal_blocks
from flexmb.reduction.transfer_error import TransferError, transfer_error

__all__ = ["BASES", "Chosen", "choose_basis", "parse_basis"]

BASES: dict[str, Callable[..., Any]] = {
    kind.__name__: kind for kind in (CraigBampton, Rubin, Krylov, CharacteristicModes, Balanced)
}
"""Bases that a text can name; `Pod` needs snapshots."""
SAME = {
    "craigchang": "Rubin",
    "characteristicconstraintmodes": "CharacteristicModes",
    "balancedtruncation": "Balanced",
    "momentmatching": "Krylov",
}
"""Other names of bases."""
REFUSED = {
    "macneal": (
        "MacNeal",
        "residual flexibility without mass",
        "mass in every flexible coordinate: the equations of motion are solved for their accelerations",
        "Take basis='Rubin': the same modes and the same statics, with the mass of the residual shapes",
    ),
    "guyan": (
        "Guyan",
        "static deformation of the interfaces without normal modes",
        "a basis that has a number of modes",
        "Leave basis out and write modes=0: the same",
    ),
    "pod": (
        "Pod",
        "no snapshots",
        "displacements of the body in a run",
        "Write basis=reduction.Pod(reduction.snapshots_of(fe, data, coordinates)); basis = { kind = 'Pod', run = "
        "'first.h5#beam' } in a model file, --basis 'Pod run=first.h5#beam' in the shell",
    ),
}
"""Names that are refused, and what to do instead: part, found, expected, remedy."""
MOST_MODES = 500
"""Normal modes from which an accuracy is called out of reach: more cost more memory than the part itself."""
STEPS = 60
"""How often a basis grows before the accuracy counts as out of reach."""
IDLE = 3
"""How often it grows by no shape until then."""
EXACT = 1e-7
"""Error of a basis that holds all shapes there are: no accuracy is told apart below it."""


@dataclass(frozen=True, eq=False)
class Chosen:
    """What a basis spans.

    Parameters
    ----------
    normal : NormalModes
        Fixed-interface shapes of the basis.
    within : (nq + k, p) or None
        Coordinates of the displacements in constraint modes and `normal`; None: all of both.
    before : callable returning (NormalModes, (nq + k, p) or None)
        Both without the static responses to loads that join.
    exact : NormalModes or None
        Free-free modes of the full model, where they were needed.
    error : TransferError or None
        Where an accuracy was asked for.
    words : str
        The description of what was taken.
    """

    normal: NormalModes
    within: np.ndarray | None
    before: Callable[[], tuple[NormalModes, np.ndarray | None]]
    exact: NormalModes | None
    error: TransferError | None
    words: str


def parse_basis(basis: Any) -> Any:
    """Read a basis: a description, or a text such as ``"Rubin"`` or ``"Krylov frequencies=0,120 order=2"``."""
    if isinstance(basis, CraigBampton | Pod) or (hasattr(basis, "vectors") and not isinstance(basis, type)):
        return basis
    words = re.sub(r",\s+", ",", basis).split() if isinstance(basis, str) else []
    told = [word for word in words if "=" not in word]
    name = "".join(c for c in "".join(told).lower() if c.isalnum())
    if name in REFUSED:
        part, found, expected, remedy = REFUSED[name]
        raise ReductionError(f"Basis {part}", found=found, expected=expected, remedy=remedy)
    names = {kind.lower(): kind for kind in BASES}
    kind = SAME.get(name, names.get(name, ""))
    if not kind:
        known = ", ".join((*BASES, "Pod(snapshots)"))
        raise ReductionError(
            "Reduction",
            found=f"basis = {basis!r}",
            expected=f"One of: {known}",
            remedy=did_you_mean(" ".join(told), BASES)
            or "Write basis='Rubin', or basis='Krylov frequencies=0,120 order=2'",
        )
    return BASES[kind](
        **{key: _value(kind, key, value) for key, _, value in (word.partition("=") for word in words[len(told) :])}
    )


def _value(kind: str, key: str, text: str) -> Any:
    """Return the value of a field of a basis from its text; ReductionError where it cannot be read."""
    known = {f.name: f.default for f in fields(BASES[kind])}  # type: ignore[arg-type] # all are dataclasses
    default = known.get(key, MISSING)
    try:
        if default is MISSING:
            raise ValueError
        if isinstance(default, bool):
            return {"true": True, "false": False}[text.lower()]
        if isinstance(default, tuple):
            return tuple(float(piece) for piece in text.split(","))
        return type(default)(text)
    except (KeyError, ValueError):
        raise ReductionError(
            f"Basis {kind}",
            found=f"'{key}={text}'",
            expected=f"fields of {kind}: {', '.join(known) or 'none'}",
            remedy="Write for example 'Krylov frequencies=0,120 order=2'",
        ) from None


def choose_basis(framed: FramedBody, basis: Any, modes: int | UpTo | None, joining: np.ndarray, damping: Any) -> Chosen:
    """Return what a basis spans.

    Parameters
    ----------
    framed : FramedBody
    basis : CraigBampton or SpannedBasis
    modes : int, UpTo or None
        An accuracy is one of the response between the loads of the body, in the largest singular value; for
        `CraigBampton` also one of the free-free frequencies.
    joining : (ndof, k), N
        Loads whose static response joins.
    damping : float or anything
        At which responses are compared, where it is one number.
    """
    body = framed.body
    if isinstance(basis, CraigBampton):
        if isinstance(modes, UpTo) and modes.response:
            normal, error, own = _fixed_modes(framed, modes, joining, damping)
            return Chosen(normal, None, lambda: (own, None), None, error, described(basis))
        own, exact = choose_modes(body, 12 if modes is None else modes)
        return Chosen(with_residuals(body, own, joining), None, lambda: (own, None), exact, None, described(basis))
    if isinstance(modes, UpTo) and not modes.response:
        raise ReductionError(
            f"Basis {type(basis).__name__}",
            found=f"modes within {100.0 * modes.accuracy:.3g} % of the frequencies",
            expected="an accuracy of the response; by frequencies normal modes with held interfaces are chosen",
            remedy=f"Write modes='up to {modes.frequency:g} Hz within {100.0 * modes.accuracy:.3g} %', or take "
            "basis='CraigBampton'",
        )
    error = None
    if isinstance(modes, UpTo):
        basis, count, vectors, error = _accurate(framed, basis, modes, joining, damping)
    else:
        count = basis.check(modes)
        vectors = _vectors(framed, basis, count, joining)
    normal, within = in_coordinates(framed, vectors)
    return Chosen(normal, within, lambda: _alone(framed, basis, count), None, error, described(basis))


def _alone(framed: FramedBody, basis: SpannedBasis, count: int) -> tuple[NormalModes, np.ndarray | None]:
    """Return the fixed-interface shapes and coordinates of a basis that knows of no loads but those on interfaces."""
    alone = framed.without_joining()
    if not alone.excitation.any() and not isinstance(basis, Rubin):
        return available_modes(framed.body, 0), None
    return in_coordinates(alone, basis.vectors(alone, basis.most(alone, count)))


def _fixed_modes(framed: FramedBody, asked: UpTo, joining: np.ndarray, damping: Any):
    """Return the fixed-interface shapes with which Craig & Bampton's basis meets an accuracy of the response, its
    error, and the normal modes alone."""
    body, free = framed.body, framed.freed()
    zeta = one_ratio(damping, free.modes_in_band(asked.frequency))
    found, modes = 8, available_modes(body, 0)

    def tried(count: int) -> tuple[NormalModes, TransferError, NormalModes]:
        own = NormalModes(modes.vectors[:, :count], modes.w2[:count])
        normal = with_residuals(body, own, joining)
        shapes = free.elastic(orthonormal_basis(body, normal, None).shapes)
        return normal, transfer_error(free, shapes, asked.frequency, zeta), own

    low, best, all_found = 0, tried(0), False
    while best[1].relative > asked.accuracy and len(modes.w2) < MOST_MODES and not all_found:
        low, found = len(modes.w2) + 1, min(2 * found, MOST_MODES)
        modes = available_modes(body, found, start=modes.vectors)
        all_found = len(modes.w2) < found
        best = tried(len(modes.w2))
    if best[1].relative > max(asked.accuracy, EXACT if all_found else 0.0):
        raise ReductionError(
            "Basis CraigBampton",
            found=f"an error of {100.0 * best[1].relative:.3g} % up to {asked.frequency:g} Hz "
            f"with {len(modes.w2)} modes{', all there are' if all_found else ''}",
            expected=f"at most {100.0 * asked.accuracy:.3g} % of the largest response",
            remedy=f"Let loads with a large error join by residual_vectors, ask for less, take another basis, or write "
            f"modes='up to {asked.frequency:g} Hz within {100.0 * asked.accuracy:.3g} % of the frequencies'",
        )
    high = len(modes.w2)
    while low < high:  # errors mostly fall with every mode: what is found meets the accuracy, fewer might meet it too
        middle = (low + high) // 2
        trial = tried(middle)
        if trial[1].relative <= asked.accuracy:
            high, best = middle, trial
        else:
            low = middle + 1
    return best


def _vectors(framed: FramedBody, basis: SpannedBasis, count: int, joining: np.ndarray) -> np.ndarray:
    """Return the displacements of a basis and the static responses to the loads that join."""
    M, spanned = framed.body.fe.M, basis.vectors(framed, count)
    return orthonormal_blocks(M, [spanned, framed.solve(joining)]) if joining.shape[1] else spanned


def _accurate(framed: FramedBody, basis: SpannedBasis, asked: UpTo, joining: np.ndarray, damping: Any):
    """Return the first basis that meets the accuracy, its number of modes, its displacements and their error."""
    limit = (2.0 * np.pi * asked.frequency) ** 2
    free = framed.freed()
    zeta = one_ratio(damping, free.modes_in_band(asked.frequency))
    count = 0 if isinstance(basis, Krylov) else max(1, int(np.sum(framed.modes_beyond(limit).w2 <= limit)))
    best, size, idle = np.inf, 0, 0
    for _ in range(STEPS):
        count = basis.most(framed, count)
        vectors = _vectors(framed, basis, count, joining)
        shapes = orthonormal_blocks(free.body.fe.M, [free.elastic(vectors)])
        error = transfer_error(free, shapes, asked.frequency, zeta)
        best, idle = min(best, error.relative), idle + 1 if vectors.shape[1] == size else 0
        size = vectors.shape[1]
        if error.relative <= max(asked.accuracy, EXACT if idle else 0.0):
            return basis, count, vectors, error
        larger = basis.grown(count, error.worst)
        if larger is None or idle == IDLE:
            break
        basis, count = larger
    hint = {"Pod": "give more snapshots or statics=True, ", "Balanced": "give more candidates, "}
    raise ReductionError(
        f"Basis {type(basis).__name__}",
        found=f"an error of {100.0 * best:.3g} % at best up to {asked.frequency:g} Hz, with {size} shapes "
        f"({described(basis)})",
        expected=f"at most {100.0 * asked.accuracy:.3g} % of the largest response",
        remedy=f"Let loads with a large error join by residual_vectors, {hint.get(type(basis).__name__, '')}ask for "
        "less, or take another basis",
    )
