"""`reduced`: reductions of finite element models that are at hand, kept beside the parts."""

from __future__ import annotations

import inspect
from typing import Any

from flexmb.fem.fe_model import FEModel
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.parts.body_cache import kept
from flexmb.parts.fingerprint import fingerprint
from flexmb.reduction.craig_bampton import reduce
from flexmb.reduction.mode_choice import USUAL

__all__ = ["reduced"]

HOW = ("backend", "progress")
"""Settings that say how data are computed, not which."""


def reduced(fe: FEModel, interfaces: Any, modes: Any = USUAL, **settings: Any) -> ModalNeutralData:
    """Reduce an FE model as `flexmb.reduction.reduce` does, once: the data are kept by content (`flexmb cache`).

    Another matrix, mesh, set or setting is another content. The model has to be at hand for that; a `Part` is found by
    its description alone.

    Parameters
    ----------
    fe : FEModel
    interfaces, modes, settings : as `flexmb.reduction.reduce`

    Raises
    ------
    ReductionError
        As `flexmb.reduction.reduce`.
    """
    if not isinstance(fe, FEModel):
        return reduce(fe, interfaces, modes, **settings)  # says what is wrong
    given = inspect.signature(reduce).bind(fe, interfaces, modes, **settings)
    given.apply_defaults()
    asked = {name: value for name, value in given.arguments.items() if name != "fe" and name not in HOW}
    return kept(fe.name, {"model": fingerprint(fe, (asked,))}, lambda: reduce(*given.args, **given.kwargs))
