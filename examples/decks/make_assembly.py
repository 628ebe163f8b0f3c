"""Write the Abaqus deck of this folder: a block with two instances of an arm, tied to it, and couplings at the tips.

`flat` writes the same without parts and instances, as CalculiX reads it. Units mm, t, s.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n*DENSITY\n7.85e-9"
FACES = {"z-": "S1", "z+": "S2", "y-": "S3", "x+": "S4", "y+": "S5", "x-": "S6"}


class Box:
    """A block of bricks from a corner: nodes (n, 3) and elements (ne, 8) numbered from 1, and faces by their normal."""

    def __init__(self, corner, size, cells):
        steps = [np.linspace(0.0, length, n + 1) + at for at, length, n in zip(corner, size, cells, strict=True)]
        nx, ny, nz = cells
        self.points = np.array([(x, y, z) for z in steps[2] for y in steps[1] for x in steps[0]])
        number = np.arange(1, len(self.points) + 1).reshape(nz + 1, ny + 1, nx + 1)
        corners = ((0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0))
        cut = [number[c : c + nz, b : b + ny, a : a + nx].ravel() for c, b, a in corners]
        self.elements = np.stack(cut, axis=1)
        place = np.arange(1, len(self.elements) + 1).reshape(nz, ny, nx)
        self.faces = {"x-": place[:, :, 0], "x+": place[:, :, -1], "z-": place[0], "z+": place[-1]}

    def nodes_at(self, axis: int, value: float) -> np.ndarray:
        """Return the numbers of the nodes in a plane."""
        return 1 + np.flatnonzero(np.abs(self.points[:, axis] - value) < 1e-9)


ARM = Box((0.0, -15.0, 0.0), (200.0, 30.0, 20.0), (12, 2, 2))
BLOCK = Box((-40.0, -30.0, -30.0), (80.0, 60.0, 60.0), (4, 3, 3))
PLACES = {"Left": (40.0, 0.0), "Right": (-40.0, 180.0)}
"""Where the arms begin along x, and by how many degrees they are turned about z."""
TIPS = {"Left": (9001, (250.0, 0.0, 10.0)), "Right": (9002, (-250.0, 0.0, 10.0))}


def _rows(numbers, width: int = 12) -> list[str]:
    words = [str(int(n)) for n in np.ravel(numbers)]
    return [", ".join(words[k : k + width]) for k in range(0, len(words), width)]


def _mesh(points, elements, name: str, first_node: int = 0, first_element: int = 0) -> list[str]:
    rows = ["*NODE"]
    rows += [f"{first_node + k}, {x:.9g}, {y:.9g}, {z:.9g}" for k, (x, y, z) in enumerate(points, 1)]
    rows.append(f"*ELEMENT, TYPE=C3D8I, ELSET={name}")
    rows += [f"{first_element + k}, {', '.join(str(first_node + n) for n in row)}" for k, row in enumerate(elements, 1)]
    return rows


def _surface(name: str, elements, face: str) -> list[str]:
    return [f"*ELSET, ELSET=E{name}", *_rows(elements), f"*SURFACE, NAME={name}", f"E{name}, {FACES[face]}"]


def assembly() -> str:
    """Return the deck with parts and instances."""
    arm = _mesh(ARM.points, ARM.elements, "all")
    arm += _surface("foot", ARM.faces["x-"], "x-") + _surface("tip", ARM.faces["x+"], "x+")
    block = _mesh(BLOCK.points, BLOCK.elements, "all")
    block += _surface("left", BLOCK.faces["x+"], "x+") + _surface("right", BLOCK.faces["x-"], "x-")
    block += ["*NSET, NSET=base", *_rows(BLOCK.nodes_at(2, -30.0))]
    section = "*SOLID SECTION, ELSET=all, MATERIAL=STEEL"
    rows = ["** A block with two arms: mm, t, s", "*PART, NAME=Arm", *arm, section, "*END PART"]
    rows += ["*PART, NAME=Block", *block, section, "*END PART", "*ASSEMBLY, NAME=Assembly"]
    rows += ["*INSTANCE, NAME=Block-1, PART=Block", "*END INSTANCE"]
    for name, (at, angle) in PLACES.items():
        rows += [f"*INSTANCE, NAME={name}, PART=Arm", f"{at}, 0., 0."]
        rows += [f"{at}, 0., 0., {at}, 0., 1., {angle}"] if angle else []
        rows.append("*END INSTANCE")
    rows += ["*NODE"] + [f"{number}, {x}, {y}, {z}" for number, (x, y, z) in TIPS.values()]
    for name, (number, _) in TIPS.items():
        kind = "*KINEMATIC\n1, 6" if name == "Left" else "*DISTRIBUTING\n1, 6"
        rows += [f"*TIE, NAME=T{name}, POSITION TOLERANCE=1.", f"{name}.foot, Block-1.{name.lower()}"]
        rows += [f"*COUPLING, CONSTRAINT NAME={name}_tip, REF NODE={number}, SURFACE={name}.tip", kind]
    rows += ["*END ASSEMBLY", STEEL, "*BOUNDARY", "Block-1.base, 1, 3"]
    return "\n".join([*rows, "*STEP\n*FREQUENCY\n8\n*END STEP", ""])


def flat() -> str:
    """Return the deck for CalculiX: one numbering, the rigid tip, no mean at the other."""
    rows, first_node, first_element, surfaces = [], 0, 0, []
    rows += _mesh(BLOCK.points, BLOCK.elements, "EBLOCK")
    surfaces += _surface("BLEFT", BLOCK.faces["x+"], "x+") + _surface("BRIGHT", BLOCK.faces["x-"], "x-")
    first_node, first_element = len(BLOCK.points), len(BLOCK.elements)
    tips = {}
    for name, (at, angle) in PLACES.items():
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        points = ARM.points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + (at, 0.0, 0.0)
        rows += _mesh(points, ARM.elements, f"E{name.upper()}", first_node, first_element)
        surfaces += _surface(f"A{name.upper()}", first_element + ARM.faces["x-"], "x-")
        tips[name] = first_node + ARM.nodes_at(0, 200.0)
        first_node, first_element = first_node + len(points), first_element + len(ARM.elements)
    number, (x, y, z) = TIPS["Left"]
    rows += [f"*NODE\n{number}, {x}, {y}, {z}\n{number + 10}, {x}, {y}, {z}", "*NSET, NSET=TIP", *_rows(tips["Left"])]
    rows += [*surfaces, STEEL, *(f"*SOLID SECTION, ELSET={e}, MATERIAL=STEEL" for e in ("EBLOCK", "ELEFT", "ERIGHT"))]
    rows.append(f"*RIGID BODY, NSET=TIP, REF NODE={number}, ROT NODE={number + 10}")
    for name in ("LEFT", "RIGHT"):
        rows.append(f"*TIE, NAME=T{name}, POSITION TOLERANCE=1.\nA{name}, B{name}")
    rows += ["*NSET, NSET=BASE", *_rows(BLOCK.nodes_at(2, -30.0)), "*BOUNDARY", "BASE, 1, 3"]
    return "\n".join([*rows, "*STEP\n*FREQUENCY\n8\n*END STEP", ""])


def main() -> None:
    """Write the deck."""
    (HERE / "arms.inp").write_text(assembly())


if __name__ == "__main__":
    main()
