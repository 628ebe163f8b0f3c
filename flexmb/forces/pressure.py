"""`Pressure`: a distributed load on an elastic body."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.math.tables import row_kernel
from flexmb.model.kinds import Force, Table
from flexmb.model.signal import as_signal

__all__ = ["Pressure"]

ROW = np.dtype([("load", np.int64), ("signal", np.int64)], align=True)


@row_kernel
def apply(raw, data, state, work):
    """Add the amount to that of the load shape; the body turns it into forces, eq. (load-shape)."""
    rows = raw.view(ROW)
    for n in range(rows.shape[0]):
        work.loads[rows[n].load] += state.signals[rows[n].signal, 0]


@dataclass(frozen=True, eq=False)
class Pressure(Force):
    """Apply a load shape of an elastic body times a function of time; it turns with the body.

    A load shape is named where the body is reduced: ``reduction.reduce(fe, loads={"air": "upper_skin"})``.

    Parameters
    ----------
    name : str
    load : str
        "body.load".
    amount : signal, Pa (or -)
        Pressure for a load made of a surface, factor for one made of forces.
    """

    name: str
    _: KW_ONLY
    load: str
    amount: Any

    table: ClassVar[Table] = Table("Pressure", ROW, {"apply": apply})

    def __post_init__(self):
        super().__post_init__()
        if not isinstance(self.load, str) or "." not in self.load:
            raise ModelError(self.title, found=f"load = {self.load!r}", expected="'body.load'",
                             remedy="Write load='flap.air'")
        object.__setattr__(self, "amount", as_signal(self.amount, self.title, "amount"))

    def check(self, model) -> None:
        """Raise ModelError if the body has no such load."""
        name, _, load = self.load.partition(".")
        body = model.body(name, self.title)
        known = tuple(getattr(getattr(body, "data", None), "load_names", ()))
        if load not in known:
            raise ModelError(self.title, found=f"body '{name}' has no load '{load}'",
                             expected=f"One of: {', '.join(known)}" if known else "a FloatingBody with load shapes",
                             remedy=did_you_mean(load, known) or "Name loads in reduction.reduce(..., loads={...})")

    def record(self, compiler):
        """Return the row."""
        body, _, load = self.load.partition(".")
        return (compiler.load(body, load), compiler.signal(self.amount))
