"""`Track`: a line of nodes along which a load moves, and the shapes that it needs wherever it stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.model.described import Described, finite_array, is_number
from flexmb.reduction.lines import in_line
from flexmb.reduction.loads import NodalForces
from flexmb.reduction.statics import HeldBody
from flexmb.reduction.wandering_loads import Wandering, wandering

__all__ = ["Track", "expanded", "loads_on_tracks"]


@dataclass(frozen=True)
class Track(metaclass=Described):
    """Unit forces at the nodes of a line, over which a load travels: a roller on a rail, a contact that wanders.

    Each node has a load shape of its own, "rail 0", "rail 1", ...; `flexmb.moving_load` applies those beside the load.
    The static responses to them join the basis, as far as the principal ones hold them: with normal modes alone the
    deflection under the load comes from a series that converges slowly.

    Parameters
    ----------
    where : name of a set, node numbers, or coordinates (k, 3), m
        Nodes in a line, straight or curved: numbers and coordinates in the order given; nodes of a set are put in
        order, from the end with the lower node number.
    direction : (3,)
        Of the force, in body axes.
    rest : float
        Share of the strain energies of all responses that may be left out, equal to that of the mean static deflection
        under the load; 1 adds no shapes.
    """

    where: Any
    direction: Any = (0.0, 0.0, 1.0)
    rest: float = 1e-3

    def __post_init__(self):
        along = finite_array(self.direction)
        if along.shape != (3,) or not np.linalg.norm(along) > 0.0:
            raise ReductionError(
                "Track",
                found=f"direction = {self.direction!r}",
                expected="three numbers, not all zero",
                remedy="Write direction=(0, 0, 1)",
            )
        if not is_number(self.rest) or not 0.0 <= self.rest <= 1.0:
            raise ReductionError(
                "Track",
                found=f"rest = {self.rest!r}",
                expected="a share from 0 to 1",
                remedy="Leave it out for 1e-3",
            )

    def line(self, fe: FEModel, part: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the nodes in order (n,), and how far along the line they lie (n,), m."""
        return in_line(fe, self.where, part)


def expanded(fe: FEModel, loads: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the load shapes with a unit force per node in the place of each track, and the tracks as numbers.

    A track becomes ``{"nodes": [rows], "places": [m along it], "loads": [names], "rest": share}``, as the quality
    report keeps it.
    """
    found: dict[str, Any] = {}
    tracks: dict[str, Any] = {}
    for name, load in loads.items():
        if not isinstance(load, Track):
            found[name] = load
            continue
        nodes, places = load.line(fe, f"Track '{name}'")
        unit = np.asarray(load.direction, float) / np.linalg.norm(load.direction)
        names = [f"{name} {k}" for k in range(len(nodes))]
        twice = next((one for one in names if one in loads), None)
        if twice is not None:
            raise ReductionError(
                f"Track '{name}'",
                found=f"another load with the name '{twice}'",
                expected="names of their own for the nodes of a track",
                remedy="Rename the other load",
            )
        found |= {one: NodalForces({int(node): unit}) for one, node in zip(names, nodes)}
        tracks[name] = {
            "nodes": nodes.tolist(),
            "places": places.tolist(),
            "loads": names,
            "rest": float(load.rest),
        }
    return found, tracks


def loads_on_tracks(
    body: HeldBody, forces: np.ndarray, names: list[str], tracks: Mapping[str, Any]
) -> dict[str, Wandering]:
    """Return the loads of all tracks, whose unit forces are columns of `forces` (ndof, nl) with these names."""
    unit = {name: forces[:, [names.index(load) for load in track["loads"]]] for name, track in tracks.items()}
    return {name: wandering(body, unit[name], track["rest"], track) for name, track in tracks.items()}
