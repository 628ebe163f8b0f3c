"""`Energy`: kinetic, strain and potential energy of the system, and the works that change their sum."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.kinds import Sensor

__all__ = ["Energy"]

STORED = ("kinetic", "strain", "potential")
WORKS = ("work_of_loads", "work_of_drives", "dissipated")


@dataclass(frozen=True, eq=False)
class Energy(Sensor):
    """Energy of the whole system, (nt,), J.

    ``total = kinetic + strain + potential``: strain belongs to flexible bodies, potential to gravity and springs. The
    balance is ``total(t) - total(0) = work_of_loads + work_of_drives - dissipated``.

    Parameters
    ----------
    name : str
    kind : str
        "total", "kinetic", "strain", "potential", or since the start "work_of_loads", "work_of_drives", "dissipated".
    """

    _: KW_ONLY
    kind: str = "total"

    def __post_init__(self):
        super().__post_init__()
        known = ("total", *STORED, *WORKS)
        if self.kind not in known:
            raise ModelError(
                self.title,
                found=f"kind = {self.kind!r}",
                expected=f"One of: {', '.join(known)}",
                remedy=did_you_mean(str(self.kind), known) or "Omit it for the total energy",
            )

    def columns(self, model) -> tuple[str, ...]:
        """Return the title with the unit."""
        return (f"{self.kind} [J]",)

    def values(self, series) -> np.ndarray:
        """Return the energy (nt,), J."""
        if self.kind in WORKS:
            return series.works[:, WORKS.index(self.kind)]
        if self.kind == "total":
            return series.energy.sum(axis=1)
        return series.energy[:, STORED.index(self.kind)]
