"""`Forces`: a load shape of nodal forces and moments on a set of nodes; `Each`: a station at each of its nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flexmb.fem.fe_model import FEModel
from flexmb.model.described import Described
from flexmb.parts.places import chosen_nodes, components
from flexmb.reduction.loads import NodalForces

__all__ = ["Each", "Forces"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Each(metaclass=Described):
    """A station at every node of a set: `name` becomes ``name_1``, ``name_2`` ... in ascending order.

    Parameters
    ----------
    of : str, node numbers or coordinates, m
        The nodes.
    """

    of: Any

    def stations(self, fe: FEModel, name: str) -> dict[str, list[int]]:
        """Return the stations by name."""
        nodes = chosen_nodes(fe, self.of, f"Station '{name}'")
        return {f"{name}_{k}": [int(node)] for k, node in enumerate(nodes, 1)}


@dataclass(frozen=True, kw_only=True, eq=False)
class Forces(metaclass=Described):
    """Nodal forces and moments of a unit load on the nodes of a set.

    Parameters
    ----------
    on : str, node numbers or coordinates, m
        The nodes that are loaded.
    force : (3,), N
        Every component is a number for all nodes, or a list with one for each node of the set.
    moment : (3,), N m
        Likewise.
    turns_with : str, optional
        As in `flexmb.reduction.LineLoad`.
    """

    on: Any
    force: Any = (0.0, 0.0, 0.0)
    moment: Any = (0.0, 0.0, 0.0)
    turns_with: str | None = None

    def on_nodes(self, fe: FEModel, title: str) -> NodalForces:
        """Return the table of nodal forces of a model."""
        nodes = chosen_nodes(fe, self.on, title)
        force = components(self.force, len(nodes), title, "force")
        moment = components(self.moment, len(nodes), title, "moment")
        turning = bool(moment.any())
        rows = zip(nodes.tolist(), force.tolist(), moment.tolist())
        table = {node: (*f, *m) if turning else tuple(f) for node, f, m in rows}
        return NodalForces(table, turns_with=self.turns_with)
