"""`ContactZone`: a part of the surface that others will press on, and the shapes that it needs wherever they do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.surface_load import pressure_field
from flexmb.model.described import Described, is_number
from flexmb.reduction.loads import facets_of
from flexmb.reduction.statics import HeldBody
from flexmb.reduction.wandering_loads import Wandering, wandering

__all__ = ["ContactZone", "loads_on_zones", "zones_of"]

MOST_FACETS = 2000
"""Each has a static response of the full model."""


@dataclass(frozen=True)
class ContactZone(metaclass=Described):
    """Facets that can touch: static responses to a pressure on each of them join the basis, as far as they differ.

    With normal modes alone the dent under a contact
    comes from a series that converges slowly, and the body is too stiff where it is touched.

    Parameters
    ----------
    where : str
        Name of a facet set.
    rest : float
        Share of the strain energies of all responses that may be left out; 1 adds no shapes.
    """

    where: str
    rest: float = 1e-3

    def __post_init__(self):
        if not isinstance(self.where, str) or not self.where:
            raise ReductionError(
                "ContactZone",
                found=f"where = {self.where!r:.80}",
                expected="the name of a facet set",
                remedy="Write contact='tooth'",
            )
        if not is_number(self.rest) or not 0.0 <= self.rest <= 1.0:
            raise ReductionError(
                "ContactZone",
                found=f"rest = {self.rest!r}",
                expected="a share from 0 to 1",
                remedy="Leave it out for 1e-3",
            )

    def patches(self, fe: FEModel) -> np.ndarray:
        """Return the nodal forces of a pressure on each facet, of a unit force in all, (ndof, n), N."""
        part = f"Contact '{self.where}'"
        groups = facets_of(fe, self.where, part)
        if (count := sum(len(facets) for facets in groups)) > MOST_FACETS:
            raise ReductionError(
                part,
                found=f"{count} facets",
                expected=f"at most {MOST_FACETS}: each has a static response of the full model",
                remedy="Name the part of the surface that can touch",
            )
        found = []
        for facet in (facet for facets in groups for facet in facets):
            field = pressure_field(fe, facet[None], 1.0)
            found.append(fe.forces(field)[:, 0] / np.linalg.norm(field[:, :3, 0].sum(axis=0)))
        return np.array(found).T


def zones_of(contact: Any) -> dict[str, ContactZone]:
    """Return the zones by name; a bare text, or several, name facet sets."""
    given = contact if isinstance(contact, list | tuple) else () if contact is None else (contact,)
    zones = [one if isinstance(one, ContactZone) else ContactZone(one) for one in given]
    return {zone.where: zone for zone in zones}


def loads_on_zones(body: HeldBody, zones: Mapping[str, ContactZone]) -> dict[str, Wandering]:
    """Return the patch loads of all zones."""
    unit = {name: zone.patches(body.fe) for name, zone in zones.items()}
    return {
        name: wandering(body, unit[name], zone.rest, {"patches": unit[name].shape[1]}) for name, zone in zones.items()
    }
