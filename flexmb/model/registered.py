"""Registration of kinds: the import line in the room of a family is all that makes one known."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["kinds_of", "registered"]

_known: dict[type, dict[str, Any]] = {}
"""Kinds by name that the rooms have imported, by family."""


def registered(namespace: Mapping[str, Any], family: type) -> dict[str, Any]:
    """Return by name the kinds of a family that a room imports from its own files; `namespace` is its `globals()`."""
    room = f"{namespace['__name__']}."
    found = [value for value in namespace.values() if isinstance(value, type) and issubclass(value, family)]
    kinds = {kind.__name__: kind for kind in found if kind is not family and kind.__module__.startswith(room)}
    _known.setdefault(family, {}).update(kinds)
    return kinds


def kinds_of(family: type) -> dict[str, Any]:
    """Return by name the kinds of a family that rooms have registered: for files inside such a room, which cannot
    import it.
    """
    return dict(_known.get(family, {}))
