"""Write the decks of this folder: three assemblies for Nastran and one for Abaqus, and flat decks of the same for ccx.

The structures are described once, in SI units; the Nastran decks are written in mm, t, s. `calculix` writes the
same cells for CalculiX, of second order, held where the deck holds them. The bracket stands beside a model of solids
only (`bracket_of_solids`): CalculiX expands beams and shells into solids, and where they share a node its knots
restrain the plate (docs/howto/decks-to-motion.md).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

ALUMINIUM = ("ALU", 70e9, 0.33, 2700.0)
STEEL = ("STEEL", 210e9, 0.3, 7850.0)
HERE = Path(__file__).parent


@dataclass
class Structure:
    """Nodes by number; quads, bars and bricks by property; springs, masses and links by number of the element.

    Bars are rectangles: width along their y-axis, height across it, both m.
    """

    title: str
    nodes: dict[int, tuple[float, float, float]] = field(default_factory=dict)
    quads: dict[int, list[tuple[int, ...]]] = field(default_factory=dict)
    bars: dict[int, list[tuple[int, int]]] = field(default_factory=dict)
    bricks: dict[int, list[tuple[int, ...]]] = field(default_factory=dict)
    plates: dict[int, tuple[float, tuple]] = field(default_factory=dict)
    sections: dict[int, tuple[float, float, tuple[float, float, float], tuple]] = field(default_factory=dict)
    solids: dict[int, tuple] = field(default_factory=dict)
    heights: dict[int, float] = field(default_factory=dict)
    """Distance of a plate's middle over its nodes, by property, m."""
    shifts: dict[int, tuple[float, float, float]] = field(default_factory=dict)
    """From the nodes of bars to their axes, by property, m."""
    bushes: list[tuple[int, int, int, float]] = field(default_factory=list)
    masses: list[tuple[int, int, float]] = field(default_factory=list)
    rigid: list[tuple[int, int, list[int]]] = field(default_factory=list)
    means: list[tuple[int, int, list[int]]] = field(default_factory=list)
    held: list[int] = field(default_factory=list)

    def node(self, place) -> int:
        """Return the node at a place, made where there is none."""
        key = tuple(round(float(x), 9) for x in place)
        known = getattr(self, "_known", None)
        if known is None:
            known = self._known = {}
        if key not in known:
            known[key] = 101 + len(self.nodes)
            self.nodes[known[key]] = key
        return known[key]

    def grid(self, property_number: int, place, nu: int, nv: int) -> None:
        """Add nu x nv quadrilaterals on the surface place(u, v), u and v from 0 to 1."""
        number = [[self.node(place(i / nu, j / nv)) for i in range(nu + 1)] for j in range(nv + 1)]
        self.quads.setdefault(property_number, []).extend(
            (number[j][i], number[j][i + 1], number[j + 1][i + 1], number[j + 1][i])
            for j in range(nv)
            for i in range(nu)
        )

    def plate(self, property_number: int, xs, ys, z: float) -> None:
        """Add quadrilaterals between lines of x and y at a height."""
        number = [[self.node((x, y, z)) for x in xs] for y in ys]
        self.quads.setdefault(property_number, []).extend(
            (number[j][i], number[j][i + 1], number[j + 1][i + 1], number[j + 1][i])
            for j in range(len(ys) - 1)
            for i in range(len(xs) - 1)
        )

    def block(self, property_number: int, xs, ys, zs) -> None:
        """Add bricks between lines of x, y and z."""
        number = np.array([[[self.node((x, y, z)) for z in zs] for y in ys] for x in xs])
        corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
        nx, ny, nz = (count - 1 for count in number.shape)
        cells = [number[a : a + nx, b : b + ny, c : c + nz].ravel() for a, b, c in corners]
        self.bricks.setdefault(property_number, []).extend(zip(*np.array(cells).tolist(), strict=True))

    def line(self, property_number: int, start, end, n: int) -> None:
        """Add n bars from start to end."""
        number = [self.node(np.array(start) + (np.array(end) - start) * k / n) for k in range(n + 1)]
        self.bars.setdefault(property_number, []).extend(pairwise(number))

    def materials(self) -> dict[str, int]:
        """Return the number of every material by its name."""
        used = [m for _, m in self.plates.values()] + [s[3] for s in self.sections.values()] + [*self.solids.values()]
        return {name: k for k, name in enumerate(dict.fromkeys(m[0] for m in used), 1)}


def wing_box() -> Structure:
    """A wing box of 2.4 m with five ribs: two fittings at the root, an actuator under the middle rib, a tip mass."""
    box = Structure("Wing box with RBE2 and RBE3 fittings")
    length, chord, height, nx, ny = 2.4, 0.6, 0.14, 24, 6
    box.plates = {1: (0.006, ALUMINIUM), 2: (0.006, ALUMINIUM), 3: (0.005, ALUMINIUM)}
    for z in (0.0, height):
        box.grid(1, lambda u, v, z=z: (length * u, chord * v, z), nx, ny)
    for y in (0.0, chord):
        box.grid(2, lambda u, v, y=y: (length * u, y, height * v), nx, 3)
    for x in np.linspace(0.0, length, 5):
        box.grid(3, lambda u, v, x=x: (x, chord * u, height * v), ny, 3)
    for number, y in ((1001, 0.0), (1002, chord)):
        lug = [k for k, (px, py, _) in box.nodes.items() if px == 0.0 and abs(py - y) <= 0.2 + 1e-9]
        box.nodes[number] = (-0.05, y, 0.5 * height)
        box.rigid.append((number, number, lug))
    shoe = [k for k, (x, _, z) in box.nodes.items() if abs(x - 0.5 * length) < 1e-9 and z == 0.0]
    shoe += [k for k, (x, _, z) in box.nodes.items() if abs(x - 0.5 * length - length / nx) < 1e-9 and z == 0.0]
    box.nodes[2001] = (0.5 * length, 0.5 * chord, -0.08)
    box.means.append((2001, 2001, sorted(set(shoe))))
    for number, y in ((3001, 0.0), (3002, chord)):
        box.masses.append((number, box.node((length, y, height)), 1.5))
    box.held = [1001, 1002]
    return box


def satellite() -> Structure:
    """A frame of square bars with boxes of equipment, and two panels on hinges (CBUSH) with struts."""
    sat = Structure("Satellite with CBUSH hinges and CONM2 equipment")
    a = 0.5
    sat.sections = {
        11: (0.04, 0.04, (0.31, 0.52, 0.79), ALUMINIUM),
        12: (0.02, 0.02, (0.31, 0.52, 0.79), ALUMINIUM),
    }
    sat.plates = {13: (0.012, ALUMINIUM)}
    corners = [(x, y, z) for x in (-a, a) for y in (-a, a) for z in (0.0, 2 * a)]
    for p in corners:
        for k in range(3):
            q = tuple(a if i == k and i < 2 else 2 * a if i == k else c for i, c in enumerate(p))
            if q != p:
                sat.line(11, p, q, 4)
    for x in (-a, a):
        sat.line(11, (x, -a, 0.0), (x, a, 2 * a), 4)
        sat.line(11, (-a, x, 0.0), (a, x, 2 * a), 4)
    sat.line(11, (-a, -a, 0.0), (a, a, 0.0), 4)
    sat.line(11, (-a, -a, 2 * a), (a, a, 2 * a), 4)
    element = 5001
    for side in (-1.0, 1.0):
        shift = {}
        before = set(sat.nodes)
        sat.grid(13, lambda u, v, s=side: (s * (a + 1.8 * u), a * (2 * v - 1), 2 * a + 1e-3), 6, 4)
        for k in set(sat.nodes) - before:  # the panel has nodes of its own, at the places of those of the frame
            x, y, z = sat.nodes[k]
            shift[k] = sat.nodes[k] = (x, y, z - 1e-3)
        strut = (side * (a + 0.6), 0.0, 2 * a)
        for y in (-a, a):
            end = sat.node((strut[0], strut[1], strut[2]))
            sat.line(12, (side * a, y, 0.0), strut, 4)
        pairs = [((side * a, y, 2 * a)) for y in (-a, 0.0, a)] + [strut]
        for place in pairs:
            panel = next(k for k, at in shift.items() if np.allclose(at, place))
            sat.bushes.append((element, sat.node(place), panel, 4e6))
            element += 1
        assert end
    for k, (place, mass) in enumerate(
        [((0.0, -a, 2 * a), 18.0), ((0.0, a, 0.0), 25.0), ((a, 0.0, 0.0), 12.0), ((-a, 0.0, 2 * a), 9.0)]
    ):
        sat.masses.append((6001 + k, sat.node(place), mass))
    sat.nodes[901] = (0.0, 0.0, -0.1)
    ring = [k for k, p in sat.nodes.items() if p in [c for c in corners if c[2] == 0.0]]
    sat.rigid.append((901, 901, sorted(ring)))
    sat.held = [901]
    return sat


def _lines(*pieces) -> list[float]:
    """Return the numbers from the first start through (end, number of steps) of each piece."""
    places = [pieces[0]]
    for end, n in pieces[1:]:
        places += [round(float(x), 9) for x in np.linspace(places[-1], end, n + 1)[1:]]
    return places


FINE = _lines(0.0, (0.06, 2), (0.08, 1), (0.1, 4), (0.115, 3), (0.15, 3), (0.4, 20))
"""Lines across the plate of the bracket, m; fine at the edge of the block, to which nodes alone join the plate."""


def bracket() -> Structure:
    """A block of bricks, a plate on it that goes on as a console, stiffeners on the plate, a mast at its end."""
    mix = Structure("Beams, shells and solids in one part")
    mix.solids = {21: STEEL}
    mix.plates = {22: (0.006, STEEL)}
    mix.heights = {22: 0.003}
    mix.sections = dict.fromkeys((23, 25), (0.005, 0.012, (0.0, 1.0, 0.0), STEEL))
    mix.sections[24] = (0.016, 0.016, (0.0, 1.0, 0.0), STEEL)
    mix.shifts = {23: (0.0, 0.0025, 0.012), 25: (0.0, -0.0025, 0.012)}
    across = _lines(0.0, (0.1, 4))
    mix.block(21, [x for x in FINE if x <= 0.1], across, across)
    mix.plate(22, FINE, across, 0.1)
    above = [x for x in FINE if x >= 0.06]
    for pid, y in ((23, 0.0), (25, 0.1)):
        for a, b in pairwise(above):
            mix.line(pid, (a, y, 0.1), (b, y, 0.1), 1)
    foot = (0.4, 0.05, 0.106)
    mix.line(24, foot, (0.4, 0.05, 0.256), 6)
    end = sorted(k for k, (x, _, z) in mix.nodes.items() if x == 0.4 and z == 0.1)
    mix.masses += [(7001, mix.node((0.4, 0.0, 0.1)), 1.0), (7002, mix.node((0.4, 0.1, 0.1)), 1.0)]
    mix.nodes[801] = (0.05, 0.05, -0.02)
    mix.rigid.append((801, 801, sorted(k for k, p in mix.nodes.items() if p[2] == 0.0)))
    mix.rigid.append((803, mix.node(foot), end))
    top = sorted(k for k, (x, _, z) in mix.nodes.items() if 0.3 < x < 0.4 and z == 0.1)
    mix.nodes[802] = (0.45, 0.05, 0.1)
    mix.means.append((802, 802, top))
    mix.held = [801]
    return mix


def bracket_of_solids(modes: int = 6) -> str:
    """Return the bracket for CalculiX with C3D20R for its plate, stiffeners and mast too, in SI.

    Block and plate, plate and stiffeners have the nodes between them in common. The end of the plate and the foot of
    the mast are one rigid body, as the RBE2 of the deck makes them.
    """
    body = Structure("Bracket of solids")
    side = _lines(0.0, (0.005, 1), (0.095, 4), (0.1, 1))
    body.block(21, [x for x in FINE if x <= 0.1], side, _lines(0.0, (0.1, 4)))
    body.block(21, FINE, side, [0.1, 0.103, 0.106])
    for ys in (side[:2], side[-2:]):
        body.block(21, [x for x in FINE if x >= 0.06], ys, [0.106, 0.112, 0.118])
    body.solids = {21: STEEL}
    mast = Structure("Mast")
    mast.block(21, _lines(0.392, (0.408, 2)), _lines(0.042, (0.058, 2)), _lines(0.106, (0.256, 10)))
    first = max(body.nodes) + 1 - min(mast.nodes)  # it meets the plate in the rigid body only
    body.nodes.update({k + first: p for k, p in mast.nodes.items()})
    body.bricks[21] += [tuple(k + first for k in cell) for cell in mast.bricks[21]]
    body.masses = [(7001 + k, body.node((0.4, y, 0.1)), 1.0) for k, y in enumerate((0.0, 0.1))]
    body.nodes[90_001] = (0.05, 0.05, -0.02)
    body.rigid, body.held = [(90_001, 90_001, [k for k, p in body.nodes.items() if p[2] == 0.0])], [90_001]
    model, step = calculix(body, modes).split("*STEP")
    rows = [row.split(", ") for row in model.split("*ELEMENT")[0].splitlines()[1:]]
    tied = []
    for number, place in ((int(row[0]), [float(word) for word in row[1:]]) for row in rows):
        x, y, z = place
        end = abs(x - 0.4) < 1e-9 and (z < 0.107 or abs(y - 0.05) > 0.044)
        if end or (abs(z - 0.106) < 1e-9 and abs(x - 0.4) < 0.008 + 1e-9 and abs(y - 0.05) < 0.008 + 1e-9):
            tied.append(f"{number},")
    rigid = ["*NODE", "90003, 0.4, 0.05, 0.106", "90004, 0.4, 0.05, 0.106", "*NSET, NSET=END", *tied]
    return "\n".join(
        [model + "\n".join([*rigid, "*RIGID BODY, NSET=END, REF NODE=90003, ROT NODE=90004"]), "*STEP" + step]
    )


def real(value: float) -> str:
    """Return a number in at most sixteen characters, as the large field of Nastran takes it."""
    return f"{value:.9G}"


def nastran(s: Structure) -> str:
    """Return the deck of a structure in mm, t, s."""
    numbers = s.materials()
    materials = {m[0]: m for m in [ALUMINIUM, STEEL]}
    rows = [f"$ {s.title}; units mm, t, s", "SOL 103", "CEND", "METHOD = 1", "SPC = 1", "BEGIN BULK", "EIGRL,1,,,12"]
    rows += [f"GRID,{k},,{real(1e3 * x)},{real(1e3 * y)},{real(1e3 * z)}" for k, (x, y, z) in sorted(s.nodes.items())]
    element = 1
    for pid, cells in s.quads.items():
        for cell in cells:
            lift = f",,{real(1e3 * s.heights[pid])}" if pid in s.heights else ""
            rows.append(f"CQUAD4,{element},{pid},{','.join(map(str, cell))}{lift}")
            element += 1
    for pid, cells in s.bricks.items():
        for cell in cells:
            rows.append(f"CHEXA,{element},{pid},{','.join(map(str, cell[:6]))},+\n+,{cell[6]},{cell[7]}")
            element += 1
    for pid, lines in s.bars.items():
        x, y, z = s.sections[pid][2]
        for a, b in lines:
            rows.append(f"CBAR,{element},{pid},{a},{b},{real(x)},{real(y)},{real(z)}")
            if pid in s.shifts:
                shift = ",".join(real(1e3 * c) for c in s.shifts[pid])
                rows[-1] += f",,+\n+,,,{shift},{shift}"
            element += 1
    for pid, (thickness, material) in s.plates.items():
        m = numbers[material[0]]
        rows.append(f"PSHELL,{pid},{m},{real(1e3 * thickness)},{m},,{m}")
    for pid, (width, height, _, material) in s.sections.items():
        rows.append(f"PBARL,{pid},{numbers[material[0]]},,BAR,,,,,+\n+,{real(1e3 * height)},{real(1e3 * width)}")
    rows += [f"PSOLID,{pid},{numbers[material[0]]}" for pid, material in s.solids.items()]
    for name, number in numbers.items():
        _, young, poisson, density = materials[name]
        rows.append(f"MAT1,{number},{real(1e-6 * young)},,{poisson},{real(1e-12 * density)}")
    for number, a, b, _ in s.bushes:
        rows.append(f"CBUSH,{number},9,{a},{b},,,,0")
    if s.bushes:
        k = real(1e-3 * s.bushes[0][3])
        rows.append(f"PBUSH,9,K,{k},{k},{k}")
    rows += [f"CONM2,{number},{node},,{real(1e-3 * mass)}" for number, node, mass in s.masses]
    for number, node, others in s.rigid:
        rows.append(_continued([f"RBE2,{number},{node},123456", *map(str, others)], 5))
    for number, node, others in s.means:
        rows.append(_continued([f"RBE3,{number},,{node},123456,1.,123", *map(str, others)], 2))
    rows += [f"SPC1,1,123456,{node}" for node in s.held]
    return "\n".join([*rows, "PARAM,COUPMASS,1", "ENDDATA", ""])


def _continued(words: list[str], first: int) -> str:
    """Return a card of free fields: so many words after the head in the first line, eight in each further one."""
    lines = [",".join(words[: first + 1])]
    rest = words[first + 1 :]
    lines += ["+," + ",".join(rest[k : k + 8]) for k in range(0, len(rest), 8)]
    return ",+\n".join(lines)


def calculix(s: Structure, modes: int = 8) -> str:
    """Return the same structure for CalculiX in SI, with S8R, B32R and C3D20R.

    The links are left out: what hangs on a held reference is held, and an RBE3 alone stiffens nothing.
    """
    held = {node for _, node, _ in s.rigid if node in s.held}
    loose = held | {node for _, node, _ in s.means}
    places = {k: np.array(p) for k, p in s.nodes.items() if k not in loose}
    middles: dict[tuple[int, int], int] = {}

    def mid(a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in middles:
            middles[key] = 100_001 + len(middles)
            places[middles[key]] = 0.5 * (places[a] + places[b])
        return middles[key]

    around = [(k, (k + 1) % 4) for k in range(4)]
    upright = [(k, k + 4) for k in range(4)]
    above = [(a + 4, b + 4) for a, b in around]
    elements, element = [], 1
    for groups, kind, edges in (
        (s.quads, "S8R", around),
        (s.bricks, "C3D20R", around + above + upright),
        (s.bars, "B32R", []),
    ):
        for pid, cells in groups.items():
            elements.append(f"*ELEMENT, TYPE={kind}, ELSET=P{pid}")
            for cell in cells:
                middle = [mid(cell[a], cell[b]) for a, b in edges]
                row = (*cell, *middle) if edges else (cell[0], mid(*cell), cell[1])
                words = [str(n) for n in (element, *row)]
                elements.append(", ".join(words[:11]) + (",\n" + ", ".join(words[11:]) if len(words) > 11 else ""))
                element += 1
    fixed = {k for _, node, others in s.rigid if node in held for k in others}
    fixed |= {m for (a, b), m in middles.items() if a in fixed and b in fixed}
    rows = ["*NODE", *(f"{k}, {x:.12g}, {y:.12g}, {z:.12g}" for k, (x, y, z) in places.items()), *elements]
    for name, young, poisson, density in (ALUMINIUM, STEEL):
        rows.append(f"*MATERIAL, NAME={name}\n*ELASTIC\n{young:g}, {poisson:g}\n*DENSITY\n{density:g}")
    for pid, (thickness, material) in s.plates.items():
        rows.append(f"*SHELL SECTION, ELSET=P{pid}, MATERIAL={material[0]}\n{thickness:g}")
    for pid, (width, height, (x, y, z), material) in s.sections.items():
        rows.append(f"*BEAM SECTION, ELSET=P{pid}, MATERIAL={material[0]}, SECTION=RECT")
        rows.append(f"{width:g}, {height:g}\n{x:g}, {y:g}, {z:g}")
    rows += [f"*SOLID SECTION, ELSET=P{pid}, MATERIAL={material[0]}" for pid, material in s.solids.items()]
    for _, a, b, stiffness in s.bushes:
        for k in (1, 2, 3):
            rows.append(f"*ELEMENT, TYPE=SPRING2, ELSET=K{element}\n{element}, {a}, {b}")
            rows.append(f"*SPRING, ELSET=K{element}\n{k}, {k}\n{stiffness:.1f}, 1.")
            element += 1
    for _, node, mass in s.masses:
        rows.append(f"*ELEMENT, TYPE=MASS, ELSET=M{element}\n{element}, {node}\n*MASS, ELSET=M{element}\n{mass:g}")
        element += 1
    shells = {k for cells in s.quads.values() for cell in cells for k in cell}
    last = 6 if (fixed & shells) or (s.bars and not s.bricks) else 3
    rows += ["*BOUNDARY", *(f"{k}, 1, {last}" for k in sorted(fixed))]
    return "\n".join([*rows, f"*STEP\n*FREQUENCY\n{modes}\n*END STEP", ""])


STRUCTURES = {"wing_box": wing_box, "satellite": satellite, "bracket": bracket}


def main() -> None:
    """Write all decks."""
    for name, make in STRUCTURES.items():
        (HERE / f"{name}.bdf").write_text(nastran(make()))


if __name__ == "__main__":
    main()
