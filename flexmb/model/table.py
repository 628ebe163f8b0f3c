"""`Table`: how a kind is stored and run; `Compiler`: what a part may ask while it writes its row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

__all__ = ["Compiler", "Table", "in_order"]


@dataclass(frozen=True)
class Table:
    """How the rows of a kind are stored and which kernels run over them.

    Parameters
    ----------
    name : str
        Unique name of the kind.
    row : numpy dtype
        Record type of a row.
    kernels : mapping of stage name to PointerKernel
        Bodies: "place", "inertia", "energy". Equations: "evaluate". Forces: "apply", and "switch" where they have a
        kink (see `flexmb.math.switches`).
    switches : int or str
        How many places with a kink a row has, or the field of the row that counts them.
    on_demand : tuple of kernels on demand
        Those that the kernels call: they are made ready with the model, as row kernels cannot pass errors on.
    """

    name: str
    row: np.dtype
    kernels: Mapping[str, Any]
    switches: int | str = 0
    on_demand: tuple[Any, ...] = ()

    def filled(self, part: Any, values: Mapping[str, Any]) -> tuple:
        """Return a row: fields by name from `values`, all others from what `part` has of the same name."""
        found, used = [], 0
        for name, inner in self._entries:
            if name in values:
                value, used = values[name], used + 1
            else:
                value = getattr(part, name)
            found.append(value if inner is None else in_order(inner, value))
        if used < len(values):
            unknown = sorted(values.keys() - set(self.row.names or ()))
            raise TypeError(f"rows of {self.name} have no {', '.join(unknown)}")
        return tuple(found)

    @cached_property
    def _entries(self) -> tuple[tuple[str, np.dtype | None], ...]:
        """Names of the fields, with their types where they are records."""
        return tuple((name, self.row[name] if self.row[name].names else None) for name in self.row.names or ())


def in_order(kind: np.dtype, values: Mapping[str, Any]) -> tuple:
    """Return a record as numpy takes it, from its fields by name; records inside it come by name as well."""
    return tuple(in_order(kind[name], values[name]) if kind[name].names else values[name] for name in kind.names or ())


class Compiler(Protocol):
    """What a part may ask while it writes its row (implemented by the system room). Everything has a number."""

    model: Any
    gravity: np.ndarray
    """(3,) m/s2, in W"""
    equations: dict[str, slice]
    """of the joints, when forces are recorded"""
    marker_index: dict[str, int]

    def marker(self, name: str) -> int:
        """Return the number of "body.marker"."""

    def marker_name(self, marker: int) -> str:
        """Return "body.marker" of a number."""

    def span(self, marker: int) -> tuple[int, int, int]:
        """Return the body whose coordinates move a marker, the first of these, and how many they are."""

    def position(self, marker: int) -> np.ndarray:
        """Return the position (3,), m, in W of a marker as described."""

    def pose(self, marker: int) -> tuple[np.ndarray, np.ndarray]:
        """Return position (3,), m, and axes (3, 3) in W of a marker as described."""

    def surface(self, name: str) -> tuple[int, int]:
        """Return the number of the marker of a surface, and where the surface begins in the bulk data."""

    def signal(self, value: Any) -> int:
        """Return the number of a signal."""

    def follow(self, value: Any, *markers: int) -> tuple[int, tuple[int, ...]]:
        """Return the number of a signal that may follow measurements, and a channel for every marker on which a force
        acts by it (-1: a function of time). Into `work.channels` the force writes how its wrench there changes with it.
        """

    def value(self, name: str, value: Any) -> None:
        """Let the value of a signal be known by a name."""

    def pair(self, a: int, b: int, writes: int = ..., *, alone: bool = ...) -> int:
        """Return the number of a pair of markers, to whose stiffness (and damping) the kernel adds."""

    def branch(self, name: str, value: float = ...) -> int:
        """Return the number of the branch coordinate `name`, which begins with `value`."""

    def load(self, body: str, name: str) -> int:
        """Return the number of a load shape of a body."""

    def load_marker(self, body: str, name: str) -> int:
        """Return the number of a marker with one freedom, the amount of a load shape."""

    def state_marker(self, owner: str, states: Mapping[str, float], sizes: Mapping[str, float] | None = ...) -> int:
        """Return the number of the first marker whose twists are the first-order states of `owner`.

        `states` are their names and starting values, `sizes` values up to which their errors are absolute (1.0). State
        k is component k % 6 of the twist of marker k // 6 from there; the wrench on it is the state's rate.
        """

    def state_place(self, of: str, state: str | None) -> tuple[int, int]:
        """Return the marker of a state of a part by name, and its component there."""

    def coordinate(self, body: str) -> int:
        """Return the number of the first coordinate of a body."""

    def couplings(self, body: str) -> int:
        """Return where the couplings of the body's blocks begin in the workspace array rows."""

    def reserve_H(self, size: int) -> int:
        """Return where `size` numbers begin in the workspace array H."""

    def joint(self, name: str) -> Any:
        """Return the description of a joint."""

    def bulk(self, array: np.ndarray) -> int:
        """Append numbers to the bulk data and return where they begin; the same array is stored once."""
