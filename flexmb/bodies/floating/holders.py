"""What holds the interfaces of a body: joints to the ground, joints to other bodies, forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmb.math.found_once import found_once
from flexmb.model.connections import Separations, beside

__all__ = ["Holders"]


class Holders:
    """Which motions of the interfaces of a body are held, and by whom.

    Parameters
    ----------
    body : str
        Name of the body.
    names : sequence of str
        Its interfaces, "body.marker".
    system : System
    """

    def __init__(self, body: str, names: list[str], system):
        self.count = len(names)
        place = {system.marker_index[name]: k for k, name in enumerate(names)}
        around = _surroundings(system)
        self.neighbours: dict[str, list[tuple[int, int, int]]] = {"": []}
        """By the name of the body beside it, "" for the ground and the body itself: leg, its equation, interface."""
        for n, marker, equation in around.legs.get(body, ()):
            if marker in place:
                beside = around.connected[equation] - {body}
                # an equation between places of the body alone holds always; its legs take no rigid motion away
                key = ", ".join(sorted(beside - around.firm))
                self.neighbours.setdefault(key, []).append((n, equation, place[marker]))
        self.loose = _loose(body, list(self.neighbours)[1:], around)
        """For each neighbour behind "": does it hang on the body alone? Then it holds nothing that stands."""
        self.pushed, self.turned = [], []
        for markers, everywhere in around.held.get(body, ()):
            for name in sorted(name for name in markers if name in names):
                self.turned.append(names.index(name))
                if everywhere:
                    self.pushed.append(names.index(name))

    def rows(self, R, work) -> list[np.ndarray]:
        """Return what is held by the ground, and by each neighbour: rows (n, 6 ni) on the motions in body axes."""
        found = []
        for legs in self.neighbours.values():
            number = {equation: k for k, equation in enumerate(dict.fromkeys(equation for _, equation, _ in legs))}
            rows = np.zeros((len(number), self.count, 6))
            for leg, equation, interface in legs:
                gradient = work.legs[leg]["gradient"]
                rows[number[equation], interface] += np.concatenate([R.T @ gradient[:3], R.T @ gradient[3:]])
            found.append(rows.reshape(len(rows), 6 * self.count))
        unit = np.eye(6 * self.count).reshape(self.count, 2, 3, 6 * self.count)
        if self.pushed:
            found.append(np.concatenate([unit[k, 0] for k in sorted(set(self.pushed))]))
        return found + [unit[k, 1] for k in sorted(set(self.turned))]


class _Surroundings(NamedTuple):
    """What all bodies of a system have beside them."""

    legs: dict[str, list[tuple[int, int, int]]]
    """By body: number, marker and equation of the legs of equations of places"""
    connected: dict[int, set[str]]
    """By equation: the bodies that it relates"""
    firm: set[str]
    """The ground and what is welded to it"""
    ground: set[str]
    separations: Separations
    held: dict[str, list[tuple[set[str], bool]]]
    """By body, for each force: the markers that it can hold against turning, and does it hold them against motion?"""


@found_once
def _surroundings(system) -> _Surroundings:
    """Return what bodies of a system have beside them (found once)."""
    bodies, model, table = _bodies_of_markers(system), system.model, system.tables["legs"]
    legs: dict[str, list[tuple[int, int, int]]] = {}
    connected: dict[int, set[str]] = {}
    for n, (marker, equation) in enumerate(zip(table["marker"].tolist(), table["equation"].tolist(), strict=True)):
        connected.setdefault(equation, set()).add(bodies[marker])
        if system.equation_owners[equation][1].level == 0:
            legs.setdefault(bodies[marker], []).append((n, marker, equation))
    held: dict[str, list[tuple[set[str], bool]]] = {}
    for force in model.forces:
        by_body: dict[str, set[str]] = {}
        for name in _held_by(force, model):
            by_body.setdefault(name.split(".")[0], set()).add(name)
        for body, markers in by_body.items():
            held.setdefault(body, []).append((markers, not hasattr(force, "place")))
    return _Surroundings(
        legs=legs,
        connected=connected,
        firm=_held_to_the_ground(system),
        ground={body.name for body in model.bodies if not body.n_velocities},
        separations=Separations(beside(model)),
        held=held,
    )


def _loose(body: str, neighbours: list[str], around: _Surroundings) -> list[bool]:
    """Return for each neighbour whether neither the ground nor another neighbour is reached from it but by the body."""
    groups = [set(key.split(", ")) for key in neighbours]
    found = []
    for group in groups:
        others = set().union(around.ground, *(other for other in groups if other is not group)) - group
        parts = {around.separations.part(body, name) for name in group}
        found.append(all(around.separations.part(body, name) not in parts for name in others))
    return found


def _bodies_of_markers(system) -> dict[int, str]:
    """Return the name of the body of every marker that has a name."""
    return {number: name.split(".")[0] for name, number in system.marker_index.items()}


def _held_to_the_ground(system) -> set[str]:
    """Return the ground and the bodies that joints of six equations hold to it, one behind the other."""
    firm = {body.name for body in system.model.bodies if not body.n_velocities}
    rigid = {body.name for body in system.model.bodies if body.n_velocities == 6}
    welds: dict[str, list[set[str]]] = {}
    for joint in system.model.joints:
        span = system.joint_equations[joint.name]
        if span.stop - span.start == 6:
            pair = {name.split(".")[0] for name in joint.resolved_markers(system.model)}
            for name in pair:
                welds.setdefault(name, []).append(pair)
    ahead = list(firm)
    while ahead:
        for pair in welds.get(ahead.pop(), ()):
            new = pair - firm
            if new <= rigid:
                firm |= new
                ahead += new
    return firm


def _held_by(force, model) -> tuple[str, ...]:
    """Return the markers that a force can hold against turning."""
    if not force.holds_turns:
        return ()
    if hasattr(force, "place"):
        coordinate, markers = force.place(model)
        return markers if coordinate.kind == "turn" else ()
    return getattr(force, "markers", None) or ()
