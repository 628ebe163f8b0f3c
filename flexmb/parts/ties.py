"""What ties and loads the nodes of a part: rigid arms, links, masses, springs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.links.connectors import with_mass, with_spring
from flexmb.fem.links.links import with_averaging_link, with_node, with_rigid_link
from flexmb.model.described import Described, finite_array
from flexmb.parts.places import chosen_nodes, components

__all__ = ["Arm", "AveragingLink", "Mass", "RigidLink", "Spring"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Arm(metaclass=Described):
    """New nodes on rigid arms: one for every node of a set.

    Parameters
    ----------
    of : str, node numbers or (3,), m
        The nodes that the arms stand on: beams or shells, whose nodes can turn.
    offset : (3,), m
        From each node to the end of its arm; every component is a number, or a list with one for each node of the set.
    name : str
        Set of the new nodes.
    extends : bool
        The set exists already, and the new nodes join it.
    """

    of: Any
    offset: Any
    name: str
    extends: bool = False

    @property
    def title(self) -> str:
        """How messages call it."""
        return f"Arm '{self.name}'"

    def applied(self, fe: FEModel) -> FEModel:
        """Return the model with the new nodes, linked."""
        nodes = chosen_nodes(fe, self.of, self.title)
        arms = components(self.offset, len(nodes), self.title, "offset")
        if not np.all(np.any(arms, axis=1)):
            at = np.round(fe.nodes[nodes[~np.any(arms, axis=1)][0]], 6).tolist()
            raise ModelError(
                self.title,
                found=f"an arm of length 0 at {at} m",
                expected="a new node away from the one that it stands on",
                remedy=f"Correct the offset, or leave the arm out and name the nodes themselves, {self.of!r:.60}",
            )
        ends = fe.nodes[nodes] + arms
        before = len(fe.nodes)
        if not self.extends:
            _check_new(fe, self.name, self.title)
        held = fe.node_sets.get(self.name, np.zeros(0, int)) if self.extends else np.zeros(0, int)
        for end in ends:
            fe = with_node(fe, end)
        fe = _with_set(fe, self.name, np.concatenate([held, np.arange(before, before + len(nodes))]))
        for k, node in enumerate(nodes):
            fe = with_rigid_link(fe, int(node), [before + k])
        return fe


@dataclass(frozen=True, kw_only=True, eq=False)
class RigidLink(metaclass=Described):
    """Nodes that follow a reference node rigidly (RBE2).

    Parameters
    ----------
    nodes : str, node numbers or coordinates, m
        What follows.
    reference : name of a set of one node, or (3,), m
        What it follows; coordinates make a new node.
    name : str, optional
        Set of the reference node.
    """

    nodes: Any
    reference: Any
    name: str | None = None

    def applied(self, fe: FEModel) -> FEModel:
        """Return the linked model."""
        title = f"RigidLink '{self.name}'" if self.name else "RigidLink"
        nodes = chosen_nodes(fe, self.nodes, title)
        return with_rigid_link(fe, _reference(fe, self.reference, title), nodes, name=self.name)


@dataclass(frozen=True, kw_only=True, eq=False)
class AveragingLink(metaclass=Described):
    """A reference node that follows the mean motion of others (RBE3), for masses: interfaces have their own couplings.

    Parameters
    ----------
    nodes : str, node numbers or coordinates, m
        What is followed.
    reference : (3,), m
        A new node.
    weights : sequence of float, optional
        One per node in ascending order.
    name : str, optional
        Set of the reference node.
    """

    nodes: Any
    reference: Any
    weights: Any = None
    name: str | None = None

    def applied(self, fe: FEModel) -> FEModel:
        """Return the linked model."""
        title = f"AveragingLink '{self.name}'" if self.name else "AveragingLink"
        nodes = chosen_nodes(fe, self.nodes, title)
        return with_averaging_link(fe, _reference(fe, self.reference, title), nodes, self.weights, name=self.name)


@dataclass(frozen=True, kw_only=True, eq=False)
class Mass(metaclass=Described):
    """Rigid masses at nodes.

    Parameters
    ----------
    at : str, node numbers or coordinates, m
        Every node gets a mass.
    mass : float or list of float, kg
        Of each node.
    inertia : (3,) or (3, 3), kg m2, optional
        About the centre of the mass.
    offset : (3,), m
        From the node to the centre of the mass.
    """

    at: Any
    mass: Any
    inertia: Any = None
    offset: Any = (0.0, 0.0, 0.0)

    def applied(self, fe: FEModel) -> FEModel:
        """Return the model with the masses."""
        title = f"Mass at {self.at!r:.60}"
        nodes = chosen_nodes(fe, self.at, title)
        for node, mass in zip(nodes, components((self.mass, 0, 0), len(nodes), title, "mass")[:, 0]):
            fe = with_mass(fe, int(node), float(mass), self.inertia, self.offset)
        return fe


@dataclass(frozen=True, kw_only=True, eq=False)
class Spring(metaclass=Described):
    """A spring between two nodes; to the ground there are the forces of the mechanism.

    Parameters
    ----------
    at, to : name of a set of one node, node number or coordinates, m
        Its two ends.
    stiffness : (6,) or (6, 6), N/m and N m/rad
        Along and about the body axes.
    """

    at: Any
    to: Any
    stiffness: Any

    def applied(self, fe: FEModel) -> FEModel:
        """Return the model with the spring."""
        ends = [chosen_nodes(fe, where, f"Spring at {where!r:.60}", single=True)[0] for where in (self.at, self.to)]
        return with_spring(fe, int(ends[0]), self.stiffness, to=int(ends[1]))


def _reference(fe: FEModel, given: Any, title: str) -> Any:
    """Return a node number for a name, or the coordinates of a new node."""
    if isinstance(given, str):
        return int(chosen_nodes(fe, given, title, single=True)[0])
    point = finite_array(given)
    if point.shape != (3,):
        raise ModelError(
            f"{title}, reference",
            found=f"{given!r:.80}",
            expected="the name of a set of one node, or three numbers, m",
            remedy="Write reference = [0.1, 0, 0]",
        )
    return tuple(point.tolist())


def _with_set(fe: FEModel, name: str, nodes: np.ndarray) -> FEModel:
    return replace(fe, node_sets={**fe.node_sets, name: nodes})


def _check_new(fe: FEModel, name: str, title: str) -> None:
    if name in fe.node_sets or name in fe.facet_sets:
        raise ModelError(
            title,
            found=f"a set '{name}' exists already",
            expected="a new name",
            remedy="Rename the arm",
        )
