"""The kinds that model files know: the lists of the rooms of parts, and the objects allowed in their fields."""

from __future__ import annotations

from functools import cache

__all__ = ["FAMILIES", "TABLES", "formulations", "integrators", "parts", "values"]

FAMILIES = {
    "body": "bodies",
    "surface": "surfaces",
    "joint": "joints",
    "force": "forces",
    "sensor": "sensors",
    "event": "events",
}
"""Name of the table in a file: family of the model."""

TABLES = (
    "name",
    "gravity",
    "origin",
    "base",
    "parameters_from",
    "parameters",
    "signals",
    *FAMILIES,
    "moving_load",
    "assembly",
    "note",
    "simulation",
)
"""What a model file may hold at its top."""


@cache
def parts() -> dict[str, dict[str, type]]:
    """Return the kinds of each family by the name of its table."""
    from flexmb import bodies, events, forces, joints, sensors, surfaces

    rooms = {"body": bodies, "surface": surfaces, "joint": joints, "force": forces, "sensor": sensors, "event": events}
    return {table: dict(getattr(room, "KINDS", {})) for table, room in rooms.items()}


@cache
def values() -> dict[str, type]:
    """Return the classes of objects allowed in a field as ``{kind = ...}``."""
    from flexmb import bodies, events, forces, joints, profiles, sensors, surfaces
    from flexmb.fem.frames.section import Section
    from flexmb.model.material import Material

    known: dict[str, type] = {"Material": Material, "Section": Section, **events.ACTIONS, **profiles.KINDS}
    for room in (bodies, surfaces, joints, forces, sensors, events):
        known.update(getattr(room, "VALUES", {}))
    return known


@cache
def integrators() -> dict[str, type]:
    """Return the integrators by name."""
    from flexmb import integrate

    return dict(integrate.KINDS)


@cache
def formulations() -> dict[str, type]:
    """Return the formulations that an integrator takes, by name."""
    from flexmb import integrate

    return dict(integrate.FORMULATIONS)
