"""`Track`: a line of nodes along which a load moves, and the shapes that it needs wherever it stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.model.described import Described, finite_array, is_number
from flexmb.reduction.loads import NodalForces
from flexmb.reduction.selection import nodes_of
from flexmb.reduction.statics import HeldBody

__all__ = ["Track", "expanded", "joining_forces", "principal_forces"]


@dataclass(frozen=True)
class Track(metaclass=Described):
    """Unit forces at the nodes of a line, over which a load travels: a roller on a rail, a contact that wanders.

    Each node has a load shape of its own, "rail 0", "rail 1", ...; `flexmb.moving_load` applies those beside the load.
    The static responses to them join the basis, as far as the principal ones hold them: with normal modes alone the
    deflection under the load comes from a series that converges slowly.

    Parameters
    ----------
    where : name of a set, node numbers, or coordinates (k, 3), m
        Nodes in a line; node numbers in the order given, nodes of a set along its longest extent.
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
        nodes = nodes_of(fe, self.where, part)
        given = np.asarray(self.where) if not isinstance(self.where, str) else np.zeros(0)
        if given.dtype.kind in "iu" and given.ndim == 1 and len(np.unique(given)) == len(given) == len(nodes):
            nodes = given.astype(int)
        elif len(nodes) > 1:
            arms = fe.nodes[nodes] - fe.nodes[nodes].mean(axis=0)
            nodes = nodes[np.argsort(arms @ np.linalg.svd(arms, full_matrices=False)[2][0])]
        if len(nodes) < 2:
            raise ReductionError(
                part, found=f"{len(nodes)} node", expected="at least two nodes in a line", remedy="Name a longer line"
            )
        steps = np.linalg.norm(np.diff(fe.nodes[nodes], axis=0), axis=1)
        return nodes, np.concatenate([[0.0], np.cumsum(steps)])


def expanded(fe: FEModel, loads: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the load shapes with a unit force per node in the place of each track, and the tracks as numbers.

    A track becomes ``{"places": [m along it], "loads": [names], "rest": share}``, as the quality report keeps it.
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
        tracks[name] = {"places": places.tolist(), "loads": names, "rest": float(load.rest)}
    return found, tracks


def _principal(body: HeldBody, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the strain energies of the principal responses to unit forces (ndof, n), descending, and what causes them.

    The combinations (n, n) of the forces; interfaces are held.
    """
    compliance = forces.T @ body.solve(forces)
    energy, combined = eigh(0.5 * (compliance + compliance.T))
    return np.maximum(energy[::-1], 0.0), combined[:, ::-1]


def joining_forces(body: HeldBody, forces: np.ndarray, names: list[str], tracks: Mapping[str, Any]) -> np.ndarray:
    """Return the combinations of the unit forces of all tracks whose static responses join the basis, (ndof, k)."""
    chosen = [np.zeros((len(forces), 0))]
    for track in tracks.values():
        unit = forces[:, [names.index(name) for name in track["loads"]]]
        chosen.append(principal_forces(body, unit, track["rest"]))
        track["shapes"] = chosen[-1].shape[1]
    return np.hstack(chosen)


def principal_forces(body: HeldBody, unit: np.ndarray, rest: float) -> np.ndarray:
    """Return the combinations of unit forces (ndof, n) that hold all but `rest` of the strain energies, (ndof, k)."""
    energy, combined = _principal(body, unit)
    left = 1.0 - np.cumsum(energy) / max(energy.sum(), 1e-300)
    count = 0 if rest >= 1.0 else int(np.sum(left > rest)) + 1
    return unit @ combined[:, : min(count, int(np.sum(energy > 1e-14 * energy[0])))]
