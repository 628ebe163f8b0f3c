"""Materials and orientations of an Abaqus deck."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.fem.deck.abaqus_model import Flat
from flexmb.fem.deck.abaqus_text import Block
from flexmb.fem.deck.contents import Deck
from flexmb.fem.deck.nastran_materials import INCOMPRESSIBLE
from flexmb.math.definiteness import definite

__all__ = ["Elastic", "Materials"]


@dataclass(eq=False)
class Elastic:
    """A material: elasticity (6, 6) in its own axes, plane stress (3, 3), density, E and nu where isotropic."""

    name: str
    density: float
    solid: np.ndarray | None
    plane: np.ndarray
    young: float
    poisson: float
    across: tuple[float, float]
    isotropic: bool


class Materials:
    """The materials and orientations of a deck by name."""

    def __init__(self, flat: Flat, deck: Deck):
        self.blocks: dict[str, list[Block]] = {}
        self.heads: dict[str, Block] = {}
        self.orientations: dict[str, tuple[Block, str]] = {}
        self.made: dict[str, Elastic] = {}
        self.inventory = deck.inventory
        current = None
        for block, scope in flat.blocks:
            if block.name == "MATERIAL":
                current = block.need("NAME").lower()
                if (other := self.heads.get(current, block)).where != block.where:
                    raise block.wrong(f"the material '{current}' a second time (first at {other.where})", "each once")
                self.blocks.setdefault(current, [])
                self.heads[current] = block
            elif block.name in ("ELASTIC", "DENSITY", "DAMPING", "PLASTIC", "HYPERELASTIC") and current is not None:
                self.blocks[current].append(block)
            elif block.name == "ORIENTATION":
                prefix = f"{scope}." if scope else ""
                self.orientations[prefix + block.need("NAME").lower()] = (block, scope)
        deck.inventory.read["*MATERIAL"] = len(self.heads)

    def get(self, block: Block, name: str | None = None) -> Elastic:
        """Return the material of a section."""
        wanted = (name or block.need("MATERIAL")).lower()
        if wanted not in self.made:
            if wanted not in self.heads:
                known = ", ".join(sorted(self.heads)) or "none"
                raise block.wrong(f"the material '{wanted}', which does not exist", f"One of: {known}")
            self.made[wanted] = _elastic(wanted, self.heads[wanted], self.blocks[wanted])
            own = self.heads[wanted].need("NAME")
            if any(_tabled(block) for block in self.blocks[wanted]):
                self.inventory.approximated[f"{own}: constants of the first temperature"] += 1
            if self.made[wanted].density == 0.0:
                self.inventory.weightless.add(own)
            if self.made[wanted].poisson == INCOMPRESSIBLE:
                self.inventory.approximated[f"{own}: Poisson's ratio near 0.5, taken as {INCOMPRESSIBLE:g}"] += 1
        return self.made[wanted]

    def axes(self, word: str, scope: str, block: Block, flat: Flat, points: np.ndarray) -> np.ndarray:
        """Return the axes (n, 3, 3), rows 1, 2, 3, of an orientation at points (n, 3)."""
        name = flat.full(self.orientations, word, scope)
        if name is None:
            known = ", ".join(sorted(self.orientations)) or "none"
            raise block.wrong(f"the orientation '{word}', which does not exist", f"One of: {known}")
        given, own = self.orientations[name]
        return _orientation(given, flat.scopes[own].rotation, flat.scopes[own].origin, points)


LINES = {"ENG": 2, "ORT": 2, "ANI": 3}
"""Lines of one set of constants by the beginning of TYPE; one otherwise."""


def _tabled(block: Block) -> bool:
    """Whether *ELASTIC or *DENSITY has more than one set of constants."""
    count = LINES.get(block.parameters.get("TYPE", "").upper()[:3], 1) if block.name == "ELASTIC" else 1
    return block.name in ("ELASTIC", "DENSITY") and sum(any(row) for row in block.rows()) > count


def _elastic(name: str, head: Block, blocks: list[Block]) -> Elastic:
    density, elastic = 0.0, None
    for block in blocks:
        if block.name == "DENSITY" and block.rows():
            density = block.reals(block.rows()[0][:1], 1)[0]
        elif block.name == "ELASTIC":
            elastic = block
        elif block.name == "HYPERELASTIC":
            raise block.wrong(f"the hyperelastic material '{name}'", "*ELASTIC", "Give its modulus for small strains")
    if elastic is None or not elastic.rows():
        raise head.wrong(f"the material '{name}' without *ELASTIC", "*ELASTIC with its constants")
    if density < 0.0:
        raise head.wrong(f"a density of {density:g}", "a density >= 0")
    word = elastic.parameters.get("TYPE", "ISOTROPIC").upper()
    known = ("ISOTROPIC", "ENGINEERING CONSTANTS", "ORTHOTROPIC", "ANISOTROPIC", "LAMINA")
    kind = next((name for name in known if word[:3] == name[:3]), word)
    values = [x for row in elastic.rows()[:3] for x in elastic.reals([w for w in row if w])]
    if kind == "ISOTROPIC":
        return _isotropic(name, density, elastic)
    needs = {"ENGINEERING CONSTANTS": 9, "ORTHOTROPIC": 9, "ANISOTROPIC": 21, "LAMINA": 6}
    if kind not in needs:
        raise elastic.wrong(f"TYPE={kind}", f"ISOTROPIC, {', '.join(needs)}")
    if len(values) < needs[kind]:
        raise elastic.wrong(f"{len(values)} constants", f"{needs[kind]} for TYPE={kind}")
    if kind == "LAMINA":
        return _lamina(name, density, values[:6], elastic)
    full = _stiffness(kind, values, elastic)
    compliance = np.linalg.inv(full)
    flat = np.linalg.inv(compliance[np.ix_([0, 1, 3], [0, 1, 3])])
    return Elastic(name, density, full, flat, 0.0, 0.3, (full[5, 5], full[4, 4]), False)


def _isotropic(name: str, density: float, block: Block) -> Elastic:
    e, nu = (*block.reals([w for w in block.rows()[0][:2] if w]), 0.0)[:2]
    if not e > 0.0:
        raise block.wrong(f"Young's modulus E = {e:g}", "E > 0")
    if not -1.0 < nu <= 0.5:
        raise block.wrong(f"Poisson's ratio nu = {nu:g}", "-1 < nu < 0.5")
    nu = min(nu, INCOMPRESSIBLE)
    g = e / (2.0 * (1.0 + nu))
    solid = np.diag([2.0 * g] * 3 + [g] * 3)
    solid[:3, :3] += e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    plane = e / (1.0 - nu**2) * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, (1.0 - nu) / 2.0]])
    return Elastic(name, density, solid, plane, e, nu, (g, g), True)


def _lamina(name: str, density: float, constants: list[float], block: Block) -> Elastic:
    e1, e2, nu12, g12, g13, g23 = constants
    rest = 1.0 - nu12**2 * e2 / e1 if e1 > 0.0 else 0.0
    if not (e1 > 0.0 and e2 > 0.0 and rest > 0.0):
        raise block.wrong(f"E1 = {e1:g}, E2 = {e2:g}, nu12 = {nu12:g}", "moduli > 0, nu12^2 < E1 / E2")
    plane = np.array([[e1, nu12 * e2, 0.0], [nu12 * e2, e2, 0.0], [0.0, 0.0, g12 * rest]]) / rest
    return Elastic(name, density, None, plane, 0.0, nu12, (g13 or np.inf, g23 or np.inf), False)


def _stiffness(kind: str, v: list[float], block: Block) -> np.ndarray:
    """Return (6, 6) in the order xx, yy, zz, xy, yz, zx; Abaqus writes 11, 22, 33, 12, 13, 23."""
    solid: np.ndarray = np.zeros((6, 6))
    if kind == "ENGINEERING CONSTANTS":
        e1, e2, e3, nu12, nu13, nu23, g12, g13, g23 = v[:9]
        if min(e1, e2, e3, g12, g13, g23) <= 0.0:
            raise block.wrong("moduli that are not positive", "nine engineering constants, moduli > 0")
        compliance = np.zeros((6, 6))
        compliance[:3, :3] = [
            [1 / e1, -nu12 / e1, -nu13 / e1],
            [-nu12 / e1, 1 / e2, -nu23 / e2],
            [-nu13 / e1, -nu23 / e2, 1 / e3],
        ]
        compliance[3, 3], compliance[4, 4], compliance[5, 5] = 1 / g12, 1 / g23, 1 / g13
        solid = np.linalg.inv(compliance) if definite(compliance) else solid
    elif kind == "ORTHOTROPIC":
        d1111, d1122, d2222, d1133, d2233, d3333, d1212, d1313, d2323 = v[:9]
        solid[:3, :3] = [[d1111, d1122, d1133], [d1122, d2222, d2233], [d1133, d2233, d3333]]
        solid[3, 3], solid[4, 4], solid[5, 5] = d1212, d2323, d1313
    else:
        place = [0, 1, 2, 3, 5, 4]  # 11, 22, 33, 12, 13, 23
        at = 0
        for j in range(6):
            for i in range(j + 1):
                solid[place[i], place[j]] = solid[place[j], place[i]] = v[at]
                at += 1
    if not definite(solid):
        raise block.wrong("an elasticity that is not positive", "constants of a stable material")
    return solid


def _orientation(block: Block, rotation: np.ndarray, origin: np.ndarray, points: np.ndarray) -> np.ndarray:
    rows = block.rows()
    if not rows:
        raise block.wrong("no data line", "two points")
    if not (word := block.parameters.get("DEFINITION", "COORDINATES")).upper().startswith("COO"):
        raise block.wrong(f"DEFINITION={word}", "COORDINATES: points a, b and c", "Write the points themselves")
    system = block.parameters.get("SYSTEM", "RECTANGULAR").upper()
    values = np.array(block.reals(rows[0], 9, 0.0))
    a, b = values[:3], values[3:6]
    if system.startswith("RECT"):
        x = a - values[6:9]
        z = np.cross(x, b - values[6:9])
        if not np.linalg.norm(z) > 0.0:
            raise block.wrong("directions on one line", "two different directions")
        frame = np.stack(
            [x / np.linalg.norm(x), np.cross(z, x) / np.linalg.norm(np.cross(z, x)), z / np.linalg.norm(z)]
        )
        axes = np.broadcast_to(frame @ rotation.T, (len(points), 3, 3)).copy()
    elif system.startswith("CYL"):
        line = rotation @ (b - a)
        line = line / (np.linalg.norm(line) or 1.0)
        radial = points - (rotation @ a + origin)
        radial = radial - np.outer(radial @ line, line)
        size = np.linalg.norm(radial, axis=1)
        if (size <= 0.0).any():
            raise block.wrong("an element on the axis of a cylindrical orientation", "elements off the axis")
        radial /= size[:, None]
        axes = np.stack([radial, np.cross(line, radial), np.broadcast_to(line, radial.shape)], axis=1)
    else:
        raise block.wrong(f"SYSTEM={system}", "RECTANGULAR or CYLINDRICAL")
    if len(rows) > 1:
        axis, angle = block.reals(rows[1], 2, 0.0)
        if axis not in (0.0, 1.0, 2.0, 3.0):
            raise block.wrong(f"the axis {axis:g} of the additional rotation", "1, 2 or 3")
        k = int(axis or 1) - 1
        i, j = [(1, 2), (2, 0), (0, 1)][k]
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        axes[:, i], axes[:, j] = c * axes[:, i] + s * axes[:, j], c * axes[:, j] - s * axes[:, i]
    return axes
