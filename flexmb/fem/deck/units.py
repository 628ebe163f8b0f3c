"""Units of decks: a deck says nothing about them, so they are given, and everything is converted at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmb.errors import MeshError, did_you_mean
from flexmb.fem.deck.contents import Deck
from flexmb.fem.deck.links import LinkRows
from flexmb.fem.frames.section import Section

__all__ = ["SYSTEMS", "converted", "factors"]

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048}
MASSES = {
    "kg": 1.0,
    "g": 1e-3,
    "t": 1e3,
    "lbf s2/in": 4.4482216152605 / 0.0254,
    "slug": 4.4482216152605 / 0.3048,
    "lbm": 0.45359237,
}
TIMES = {"s": 1.0, "ms": 1e-3}
"""SI values of the units (lbf and in are exact by definition; NIST SP 811)."""

SYSTEMS = ("m, kg, s", "mm, t, s", "mm, kg, ms", "mm, kg, s", "in, lbf s2/in, s", "ft, slug, s")
"""Systems that are tried where none is given."""


def factors(units: str, part: str) -> tuple[float, float, float]:
    """Return the SI values of length, mass and time of a system such as "mm, t, s"."""
    names = {"SI": "m, kg, s", "si": "m, kg, s"}
    words = [" ".join(word.split()) for word in names.get(units, units).split(",")] if isinstance(units, str) else []
    tables = (LENGTHS, MASSES, TIMES)
    if len(words) != 3 or any(word not in table for word, table in zip(words, tables)):
        raise MeshError(
            part,
            found=f"units = {units!r}",
            expected=f"length, mass and time, as in: {'; '.join(SYSTEMS)}",
            remedy=did_you_mean(str(units), SYSTEMS) or "Write for example units='mm, t, s'",
        )
    length, mass, time = (table[word] for word, table in zip(words, tables))
    return length, mass, time


def converted(deck: Deck, units: str | None, part: str) -> Deck:
    """Return the deck in m, kg and s; unchanged without units."""
    if units is None:
        return deck
    length, mass, time = factors(units, part)
    force, pressure = mass * length / time**2, mass / length / time**2
    line, surface = mass / length, mass / length**2
    density, spring = mass / length**3, mass / time**2
    for solid in deck.solids:
        solid.elasticity, solid.density = solid.elasticity * pressure, solid.density * density
    for shell in deck.shells:
        shell.membrane, shell.coupling, shell.bending = (
            shell.membrane * spring,
            shell.coupling * force,
            shell.bending * force * length,
        )
        shell.shear, shell.faces = shell.shear / spring, shell.faces * pressure
        shell.offset, shell.thickness, shell.depths = (
            x * length for x in (shell.offset, shell.thickness, shell.depths)
        )
        shell.mass = shell.mass * surface
    for beam in deck.beams:
        seen: dict[Section, Section] = {}
        beam.sections = [(_section(a, length, line, seen), _section(b, length, line, seen)) for a, b in beam.sections]
        beam.material = replace(
            beam.material, young=beam.material.young * pressure, density=beam.material.density * density
        )
        beam.offsets = beam.offsets * length
    for rod in deck.rods:
        rod.axial, rod.torsion = rod.axial * force, rod.torsion * force * length**2
        rod.mass, rod.polar = rod.mass * line, rod.polar * mass * length
    turn = np.tile([1.0, 1.0, 1.0, length, length, length], 2)
    for lump in deck.lumped_parts:
        factor = {"stiffness": spring, "mass": mass, "damping": mass / time}[lump.kind]
        scale = np.resize(turn, len(lump.matrix))
        lump.matrix = factor * scale[:, None] * lump.matrix * scale[None, :]
    for link in deck.links:
        _scale_link(link, length)
    turns = np.array([1.0, 1.0, 1.0, length, length, length])
    deck.slanted = {name: [(node, row * turns) for node, row in rows] for name, rows in deck.slanted.items()}
    deck.points = deck.points * length
    deck.units = units
    return deck


def _section(section: Section, length: float, line: float, seen: dict[Section, Section]) -> Section:
    if section not in seen:
        moved: dict = {
            name: tuple(x * length for x in getattr(section, name))
            for name in ("area_center", "shear_center", "mass_center", "line_mass_center")
        }
        seen[section] = replace(
            section,
            area=section.area * length**2,
            inertia_y=section.inertia_y * length**4,
            inertia_z=section.inertia_z * length**4,
            product_yz=section.product_yz * length**4,
            torsion=section.torsion * length**4,
            polar=None if section.polar is None else section.polar * length**4,
            fibres=tuple((y * length, z * length) for y, z in section.fibres),
            line_mass=section.line_mass * line,
            shape=("values",),
            **moved,
        )
    return seen[section]


def _scale_link(link: LinkRows, length: float) -> None:
    """Scale coefficients between translations and rotations; angles have no unit."""
    for k, (dependent, rows, columns) in enumerate(zip(link.dependent, link.rows, link.columns, strict=True)):
        start = int(sum(len(block) for block in link.dependent[:k]))
        turns_row, turns_column = dependent[rows - start] % 6 >= 3, columns % 6 >= 3
        link.values[k] = link.values[k] * np.where(turns_column & ~turns_row, length, 1.0)
        link.values[k] = link.values[k] * np.where(turns_row & ~turns_column, 1.0 / length, 1.0)
