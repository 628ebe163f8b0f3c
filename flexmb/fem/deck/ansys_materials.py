"""Materials and sections of an Ansys archive: MPDATA or MP, SECTYPE with SECDATA, SECBLOCK, SECOFFSET, SECCONTROLS."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.deck.ansys_text import Archive, Command
from flexmb.fem.deck.contents import Deck
from flexmb.math.definiteness import definite

__all__ = ["AnsysSection", "Solid", "materials", "sections"]

DIRECTIONS = (("EX", "EY", "EZ"), ("PRXY", "PRYZ", "PRXZ"), ("NUXY", "NUYZ", "NUXZ"), ("GXY", "GYZ", "GXZ"))
ANOTHER = frozenset(("ANEL", "ELAS", "HYPE", "MOON", "BB", "AHYPER", "SMA", "FLUI", "GASK", "FCON", "USER"))
"""Tables of materials (TB) that replace the linear elasticity of MP."""

ALIKE = 1e-5
"""Relative difference of constants below which a material counts as isotropic: archives keep nine digits."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A material: elasticity (6, 6) for xx yy zz xy yz zx, plane stress (3, 3), density, E and nu where isotropic."""

    name: str
    density: float
    solid: np.ndarray
    plane: np.ndarray
    young: float
    poisson: float
    across: tuple[float, float]
    isotropic: bool


@dataclass(eq=False)
class AnsysSection:
    """A section: its type and shape, the numbers of SECDATA in order, layers, place of the nodes, controls."""

    kind: str
    shape: str
    where: Command
    data: list[float] = field(default_factory=list)
    layers: list[tuple[float, int, float]] = field(default_factory=list)
    place: str = ""
    shift: tuple[float, float] = (0.0, 0.0)
    controls: list[float] = field(default_factory=list)


def materials(archive: Archive, deck: Deck) -> dict[int, Solid | str]:
    """Return the materials by number; words instead of one that has no linear elasticity."""
    values: dict[int, dict[str, float]] = {}
    tables: dict[int, str] = {}
    for command in archive.commands:
        if command.name == "MP":
            label, number, value = command.text(0), command.integer(1), command.real(2, 0.0)
            if any(command.text(k) and command.real(k) for k in range(3, 7)):
                deck.inventory.approximated[f"MP {label}: temperature, its constant part"] += 1
        elif command.name == "MPDATA":
            first = 2 if command.text(0).startswith("R") and "." in command.text(0) else 0
            label, number, start = command.text(first), command.integer(first + 1), command.integer(first + 2, 1)
            if start > 1 and label in values.get(number, {}):
                continue
            value = command.real(first + 3, 0.0)
            if command.text(first + 4):
                deck.inventory.approximated[f"MPDATA {label}: a table over temperature, its first value"] += 1
        elif command.name == "TB":
            if command.text(0)[:4] in ANOTHER:
                tables[command.integer(1, 1)] = command.text(0)
            else:
                deck.inventory.approximated[f"TB {command.text(0)}: not linear, passed over"] += 1
            continue
        else:
            continue
        values.setdefault(number, {})[label] = value
    out: dict[int, Solid | str] = {}
    for number in values.keys() | tables.keys():
        if number in tables:
            out[number] = f"TB,{tables[number]}"
        elif "EX" not in values[number]:
            out[number] = "no EX"
        else:
            if not any(key in values[number] for key in DIRECTIONS[1] + DIRECTIONS[2]):
                deck.inventory.approximated[f"material {number} without Poisson's ratio, 0.3"] += 1
            out[number] = _material(number, values[number])
    deck.inventory.read["materials"] = len(out)
    return out


def _material(number: int, v: dict[str, float]) -> Solid:
    """Return an isotropic or orthotropic material.

    PR are the major ratios, ``PRXY / EX = NUXY / EY`` (Mechanical APDL Theory Reference, structural fundamentals).
    """
    name = f"material {number}"
    density = v.get("DENS", 0.0)
    young = [v.get(key, v["EX"]) for key in DIRECTIONS[0]]
    ratios = []
    for k, (i, j) in enumerate(((0, 1), (1, 2), (0, 2))):
        major, minor = DIRECTIONS[1][k], DIRECTIONS[2][k]
        fallback = ratios[0] if ratios else (0.3 if not any(x in v for x in DIRECTIONS[1] + DIRECTIONS[2]) else 0.0)
        ratios.append(v[major] if major in v else v[minor] * young[i] / young[j] if minor in v else fallback)
    shear = [v.get(key, young[0] / (2.0 * (1.0 + ratios[0]))) for key in DIRECTIONS[3]]
    compliance = np.zeros((6, 6))
    if min(young) > 0.0 and min(shear) > 0.0:
        for k, (i, j) in enumerate(((0, 1), (1, 2), (0, 2))):
            compliance[i, j] = compliance[j, i] = -min(ratios[k], 0.4999) / young[i]
        compliance[range(6), range(6)] = [*(1.0 / e for e in young), *(1.0 / g for g in shear)]
    if density < 0.0 or not definite(compliance):
        raise MeshError(
            f"Ansys {name}",
            found=", ".join(f"{key} = {value:g}" for key, value in sorted(v.items())),
            expected="moduli above zero, ratios of a stable material, a density that is not negative",
            remedy="Correct its MP or MPDATA commands",
        )
    solid, flat = np.linalg.inv(compliance), np.linalg.inv(compliance[np.ix_([0, 1, 3], [0, 1, 3])])
    g = young[0] / (2.0 * (1.0 + ratios[0]))
    isotropic = max(young) - min(young) <= ALIKE * young[0] and max(ratios) - min(ratios) <= ALIKE
    isotropic = isotropic and max(abs(x - g) for x in shear) <= ALIKE * g
    return Solid(name, density, solid, flat, young[0], min(ratios[0], 0.4999), (shear[2], shear[1]), isotropic)


def sections(archive: Archive) -> dict[int, AnsysSection]:
    """Return the sections by number; SECDATA and the like belong to the SECTYPE before them."""
    out: dict[int, AnsysSection] = {}
    current: AnsysSection | None = None
    for command in archive.commands:
        if command.name == "SECTYPE":
            current = out[command.integer(0)] = AnsysSection(command.text(1)[:4], command.text(2)[:4], command)
        elif command.name[:6] not in ("SECDAT", "SECBLO", "SECOFF", "SECCON"):
            continue
        elif current is None:
            raise command.wrong("no SECTYPE before it", "SECTYPE, number, type")
        elif command.name.startswith("SECDAT"):
            if current.kind == "SHEL":
                current.layers.append(_layer(command))
            else:
                current.data += [command.real(k, 0.0) for k in range(len(command.words))]
        elif command.name.startswith("SECBLO"):
            if current.kind == "SHEL":
                current.layers += [_layer(line) for line in archive.layers[command.where]]
            else:
                current.shape = "MESH"
        elif command.name.startswith("SECOFF"):
            current.place = command.text(0)
            current.shift = (command.real(1, 0.0), command.real(2, 0.0))
        else:
            current.controls = [command.real(k, 0.0) for k in range(len(command.words))]
    return out


def _layer(command: Command) -> tuple[float, int, float]:
    """Return thickness, material (0: the element's) and angle in degrees of a layer."""
    thickness = command.real(0)
    if not thickness > 0.0:
        raise command.wrong(f"a layer of thickness {thickness:g}", "positive thicknesses")
    return thickness, command.integer(1, 0), command.real(2, 0.0)
