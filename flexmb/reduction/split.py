"""`split`: the parts of a cut FE model, reduced one by one, with the cuts as interfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flexmb.errors import ReductionError, did_you_mean
from flexmb.fem.fe_model import FEModel
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.reduction.bases import CraigBampton
from flexmb.reduction.craig_bampton import reduce
from flexmb.reduction.mode_choice import USUAL, UpTo
from flexmb.reduction.selection import is_point, points_of

__all__ = ["split"]


def split(
    parts: Sequence[FEModel],
    interfaces: Mapping[str, Any],
    modes: int | str | UpTo = USUAL,
    *,
    basis: Any = CraigBampton(),  # noqa: B008 # frozen
    geometric_stiffness: bool = True,
    stations: Mapping[str, Any] | None = None,
    loads: Mapping[str, Any] | None = None,
    damping: Any = None,
    stress: bool = True,
) -> tuple[ModalNeutralData, ...]:
    """Reduce the parts of an FE model, each with its cuts as rigid interfaces.

    Between two parts the section of the cut keeps its shape; it may turn as far as it likes, since every part has its
    own floating frame.

    Parameters
    ----------
    parts : sequence of FEModel
        From `flexmb.fem.split`.
    interfaces, stations : as `reduce`
        Named sets or coordinates (node numbers belong to a part and would be ambiguous); each goes to the part it lies
        in.
    modes, basis : as `reduce`
        Normal modes of each part, 8 unless given, and which displacements it has.
    loads : as `reduce`
        Each goes to all parts that have a piece of its set, under the same name: "air" of every part is one pressure.
    geometric_stiffness, damping, stress : as `reduce`

    Returns
    -------
    tuple of ModalNeutralData
        For `flexmb.FloatingBody.split`.

    Raises
    ------
    ReductionError
        An interface in no part, or in several.
    """
    own: list[tuple[dict, dict, dict]] = [({}, {}, {}) for _ in parts]
    for what, given, place in (("Interface", interfaces, 0), ("Station", stations or {}, 1)):
        for name, where in given.items():
            own[_owner(parts, what, name, where)][place][name] = where
    for name, load in (loads or {}).items():
        owners = [k for k, part in enumerate(parts) if _has(part, getattr(load, "where", load))]
        if not owners:
            raise _unknown(parts, "Load", name, getattr(load, "where", load))
        for k in owners:
            own[k][2][name] = load
    return tuple(
        reduce(
            part,
            {**faces, **{cut: cut for cut in part.node_sets if cut.startswith("cut_")}},
            8 if modes == USUAL and isinstance(basis, CraigBampton) else modes,
            basis=basis,
            geometric_stiffness=geometric_stiffness,
            stations=points,
            loads=shapes,
            damping=damping,
            stress=stress,
        )
        for part, (faces, points, shapes) in zip(parts, own)
    )


def _has(part: FEModel, where) -> bool:
    return isinstance(where, str) and (where in part.node_sets or where in part.facet_sets)


def _owner(parts: Sequence[FEModel], what: str, name: str, where) -> int:
    """Return the number of the part in which a set or a point lies."""
    selection = getattr(where, "where", where)
    if is_point(selection):
        distance = [np.linalg.norm(p.nodes[:, None] - points_of(selection), axis=2).min(axis=0).sum() for p in parts]
        return int(np.argmin(distance))
    owners = [k for k, part in enumerate(parts) if _has(part, selection)]
    if not owners:
        raise _unknown(parts, what, name, selection)
    if len(owners) > 1:
        raise ReductionError(
            f"{what} '{name}'",
            found=f"the set '{selection}' lies in the parts {[k + 1 for k in owners]}",
            expected="a set within one part",
            remedy="Move the cut, or name one set per part",
        )
    return owners[0]


def _unknown(parts: Sequence[FEModel], what: str, name: str, where) -> ReductionError:
    known = sorted({key for part in parts for key in (*part.node_sets, *part.facet_sets)})
    return ReductionError(
        f"{what} '{name}'",
        found=f"{where!r} is not a set of any part",
        expected=f"One of: {', '.join(known) or 'none'}, or coordinates",
        remedy=did_you_mean(str(where), known) or "Name a set of the mesh, or give coordinates",
    )
