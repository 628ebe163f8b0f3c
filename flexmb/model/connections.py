"""Which bodies of a model joints and forces connect."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping

from flexmb.model.model import Model

__all__ = ["Separations", "beside", "held_by_ground", "places_of", "reached"]


def places_of(part, model: Model) -> tuple[str, ...]:
    """Return the markers on which a joint or force acts, "body.marker"; its joint's where it names one."""
    places = [*(getattr(part, "markers", None) or ()), getattr(part, "marker", None)]
    if hasattr(part, "touching_markers"):
        places += part.touching_markers(model)
    if part.family == "Joint":
        places += part.resolved_markers(model)
    joint, body = getattr(part, "joint", None), getattr(part, "body", None)
    if isinstance(joint, str):
        places += getattr(model.joint(joint, part.title), "markers", ()) or ()
    if isinstance(body, str):
        places.append(f"{body}.")
    return tuple(place for place in places if isinstance(place, str) and place)


def beside(model: Model) -> dict[str, set[str]]:
    """Return by the name of each body those that a joint or a force connects with it; of a part that acts on many
    bodies one is connected with all others."""
    found: dict[str, set[str]] = {body.name: set() for body in model.bodies}
    for part in (*model.joints, *model.forces):
        together = {place.rpartition(".")[0] for place in places_of(part, model)} & found.keys()
        first = next(iter(together), "")
        for name in together - {first}:
            found[first].add(name)
            found[name].add(first)
    return found


def reached(connected: Mapping[str, set[str]], start: Iterable[str], without: str = "") -> set[str]:
    """Return the bodies that connections lead to from some bodies, these included, and never through `without`."""
    known = set(start) - {without}
    ahead = list(known)
    while ahead:
        new = connected[ahead.pop()] - known - {without}
        known |= new
        ahead += new
    return known


def held_by_ground(model: Model) -> set[str]:
    """Return the names of the bodies that joints and forces connect, directly or not, to a body that does not move."""
    return reached(beside(model), (body.name for body in model.bodies if not body.n_velocities))


class Separations:
    """Into which parts the connected bodies fall when any one of them is taken out, found once for all.

    Depth-first search; a subtree from which nothing leads above a body falls off with it (Hopcroft & Tarjan 1973).

    Parameters
    ----------
    connected : mapping of name to set of names
        As `beside` returns it.
    """

    def __init__(self, connected: Mapping[str, set[str]]):
        self._entry: dict[str, int] = {}
        self._last: dict[str, int] = {}
        self._lowest: dict[str, int] = {}
        self._root: dict[str, str] = {}
        self._children: dict[str, tuple[list[int], list[str]]] = {name: ([], []) for name in connected}
        for name in connected:
            if name not in self._entry:
                self._search(connected, name)

    def _search(self, connected: Mapping[str, set[str]], root: str) -> None:
        """Number the bodies that a root leads to, and find how far back each one's subtree reaches."""
        waiting = [(root, "", iter(connected[root]))]
        self._enter(root, root)
        while waiting:
            name, parent, ahead = waiting[-1]
            for other in ahead:
                if other not in self._entry:
                    self._enter(other, root)
                    entries, names = self._children[name]
                    entries.append(self._entry[other])
                    names.append(other)
                    waiting.append((other, name, iter(connected[other])))
                    break
                if other != parent:
                    self._lowest[name] = min(self._lowest[name], self._entry[other])
            else:
                waiting.pop()
                self._last[name] = len(self._entry) - 1
                if parent:
                    self._lowest[parent] = min(self._lowest[parent], self._lowest[name])

    def _enter(self, name: str, root: str) -> None:
        self._entry[name] = self._lowest[name] = len(self._entry)
        self._root[name] = root

    def part(self, without: str, name: str) -> tuple[str, str]:
        """Return in which part a body lies when another one is taken out: equal for bodies that stay connected."""
        entry = self._entry[name]
        if self._root[name] != self._root[without] or not self._entry[without] < entry <= self._last[without]:
            return self._root[name], ""
        entries, names = self._children[without]
        child = names[bisect_right(entries, entry) - 1]
        return self._root[name], child if self._lowest[child] >= self._entry[without] else ""
