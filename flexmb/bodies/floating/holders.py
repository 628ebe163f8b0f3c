"""What holds the interfaces of a body: joints to the ground, joints to other bodies, forces."""

from __future__ import annotations

import numpy as np

from flexmb.model.connections import beside, reached

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
        legs = system.tables["legs"]
        bodies = _bodies_of_markers(system)
        firm = _held_to_the_ground(system, bodies)
        self.neighbours: dict[str, list[tuple[int, int, int]]] = {"": []}
        """By the name of the body beside it, "" for the ground and the body itself: leg, its equation, interface."""
        connected: dict[int, set[str]] = {}
        for marker, equation in zip(legs["marker"].tolist(), legs["equation"].tolist(), strict=True):
            connected.setdefault(equation, set()).add(bodies[marker])
        for n, (marker, equation) in enumerate(zip(legs["marker"].tolist(), legs["equation"].tolist(), strict=True)):
            if marker in place and system.equation_owners[equation][1].level == 0:
                beside = connected[equation] - {body}
                # an equation between places of the body alone holds always; its legs take no rigid motion away
                key = ", ".join(sorted(beside - firm))
                self.neighbours.setdefault(key, []).append((n, equation, place[marker]))
        self.loose = _loose(body, list(self.neighbours)[1:], system.model)
        """For each neighbour behind "": does it hang on the body alone? Then it holds nothing that stands."""
        self.pushed, self.turned = [], []
        for force in system.model.forces:
            for name in sorted({name for name in _held_by(force, system.model) if name in names}):
                self.turned.append(names.index(name))
                if not hasattr(force, "place"):
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


def _loose(body: str, neighbours: list[str], model) -> list[bool]:
    """Return for each neighbour whether neither the ground nor another neighbour is reached from it but by the body."""
    connected = beside(model)
    ground = {one.name for one in model.bodies if not one.n_velocities}
    groups = [set(key.split(", ")) for key in neighbours]
    found = []
    for group in groups:
        others = set().union(ground, *(other for other in groups if other is not group)) - group
        found.append(not reached(connected, group, without=body) & others)
    return found


def _bodies_of_markers(system) -> dict[int, str]:
    """Return the name of the body of every marker that has a name."""
    return {number: name.split(".")[0] for name, number in system.marker_index.items()}


def _held_to_the_ground(system, bodies: dict[int, str]) -> set[str]:
    """Return the ground and the bodies that joints of six equations hold to it, one behind the other."""
    firm = {body.name for body in system.model.bodies if not body.n_velocities}
    rigid = {body.name for body in system.model.bodies if body.n_velocities == 6}
    welds = []
    for joint in system.model.joints:
        span = system.joint_equations[joint.name]
        if span.stop - span.start == 6:
            welds.append({name.split(".")[0] for name in joint.resolved_markers(system.model)})
    for _ in welds:
        for pair in welds:
            if pair & firm and pair <= firm | rigid:
                firm |= pair
    return firm


def _held_by(force, model) -> tuple[str, ...]:
    """Return the markers that a force can hold against turning."""
    if not force.holds_turns:
        return ()
    if hasattr(force, "place"):
        coordinate, markers = force.place(model)
        return markers if coordinate.kind == "turn" else ()
    return getattr(force, "markers", None) or ()
