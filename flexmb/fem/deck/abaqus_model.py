"""The mesh and the sets of an Abaqus deck: parts placed as instances, everything flattened into one numbering."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from flexmb.errors import MeshError, did_you_mean
from flexmb.fem.deck.abaqus_text import Block, is_number
from flexmb.fem.ranges import MANY

__all__ = ["Element", "Flat", "Scope", "flattened_deck", "instance_pose", "members"]

NOT_STRUCTURAL = frozenset(("D", "F3D4", "F3D6", "F3D8", "DC3D4", "DC3D6", "DC3D8", "DC3D10", "DC3D15", "DC3D20"))
"""Elements of fluid networks, fluids and heat."""


@dataclass(slots=True, eq=False)
class Element:
    """One element: its type in capitals, node numbers 0 .. n-1, its number in the file and its scope."""

    kind: str
    nodes: list[int]
    label: int
    scope: str


@dataclass(eq=False)
class Scope:
    """Names of a part instance, or of a flat deck or the assembly (name "").

    name is in small letters, title as in the file.
    """

    name: str
    title: str = ""
    nodes: dict[int, int] = field(default_factory=dict)
    elements: dict[int, int] = field(default_factory=dict)
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @property
    def shown(self) -> str:
        """What names of its sets begin with, as the file spells it."""
        return f"{self.title}." if self.title else ""


@dataclass(eq=False)
class Flat:
    """A deck without hierarchy: points, elements, sets and surfaces by full name in small letters."""

    points: list[np.ndarray] = field(default_factory=list)
    labels: list[int] = field(default_factory=list)
    elements: list[Element] = field(default_factory=list)
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    surfaces: dict[str, list[tuple[str, str, str]]] = field(default_factory=dict)
    surface_kinds: dict[str, str] = field(default_factory=dict)
    surface_blocks: dict[str, Block] = field(default_factory=dict)
    scopes: dict[str, Scope] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    skipped: Counter[str] = field(default_factory=Counter)
    """Elements that are no structure, and numbers in sets that do not exist, by words."""
    given: dict[tuple[str, int], Block] = field(default_factory=dict)
    """Which *MASS, *SPRING .. an element has."""
    blocks: list[tuple[Block, str]] = field(default_factory=list)
    """Keywords beyond the mesh, each with its scope; keywords of a part once per instance."""

    def nodes_of(self, word: str, scope: str, block: Block) -> list[int]:
        """Return the nodes of a number or of a set, seen from a scope."""
        if is_number(word.lstrip("+-")):
            return [self.node(int(word), scope, block)]
        head, dot, tail = word.partition(".")
        if dot and is_number(tail) and head.lower() in self.scopes:
            return [self.node(int(tail), head.lower(), block)]
        return self.named(self.node_sets, word, scope, block, "node set")

    def node(self, label: int, scope: str, block: Block) -> int:
        """Return the number of a node by its number in the file."""
        found = self.scopes[scope].nodes.get(label)
        if found is None and scope:
            found = self.scopes[""].nodes.get(label)
        if found is None:
            raise block.wrong(f"node {label}, which does not exist", "a node of *NODE")
        return found

    def elements_of(self, word: str, scope: str, block: Block) -> list[int]:
        """Return the elements of a number or of a set."""
        if is_number(word):
            found = self.scopes[scope].elements.get(int(word))
            if found is None:
                raise block.wrong(f"element {word}, which does not exist", "an element of *ELEMENT")
            return [found]
        return self.named(self.element_sets, word, scope, block, "element set")

    def full(self, table: Iterable[str], word: str, scope: str) -> str | None:
        """Return the full name of a set that a scope calls `word`; None if there is none."""
        name = word.lower()
        for candidate in (f"{scope}.{name}" if scope else name, name):
            if candidate in table:
                return candidate
        return None

    def named(self, table: dict, word: str, scope: str, block: Block, what: str):
        """Return a named set; MeshError with suggestions."""
        name = self.full(table, word, scope)
        if name is None:
            known = sorted(table)
            raise block.wrong(
                f"the {what} '{word}', which does not exist",
                f"One of: {', '.join(known[:12]) or 'none'}",
                did_you_mean(word.lower(), known) or "Add it, or correct the name",
            )
        return table[name]


def flattened_deck(blocks: list[Block], part: str) -> Flat:
    """Return the flat deck: instances placed, sets resolved, everything else with its scope."""
    flat = Flat(scopes={"": Scope("")})
    parts: dict[str, list[Block]] = {}
    own: list[Block] = []
    inside: str | None = None
    instance: tuple[Block, list[Block]] | None = None
    for block in blocks:
        if block.name == "PART":
            inside = block.need("NAME").lower()
            if inside in parts:
                raise block.wrong(f"part '{inside}' a second time", "one *PART per name")
            parts[inside] = []
        elif block.name == "END PART":
            inside = None
        elif inside is not None:
            parts[inside].append(block)
        elif block.name == "INSTANCE":
            instance = (block, [])
        elif block.name == "END INSTANCE":
            if instance is not None:
                _place(flat, instance[0], instance[1], parts)
            instance = None
        elif instance is not None:
            instance[1].append(block)
        elif block.name not in ("ASSEMBLY", "END ASSEMBLY"):
            own.append(block)
    _fill(flat, own, flat.scopes[""])
    if not flat.points:
        raise MeshError(
            part, found="no nodes", expected="*NODE, or parts placed by *INSTANCE", remedy="Give the main deck"
        )
    return flat


def _place(flat: Flat, head: Block, extra: list[Block], parts: dict[str, list[Block]]) -> None:
    name = head.need("NAME").lower()
    source = head.parameters.get("PART", "").lower()
    if source not in parts:
        raise head.wrong(
            f"PART={source}, which does not exist",
            f"One of: {', '.join(sorted(parts)) or 'none'}",
            did_you_mean(source, parts) or "Add the *PART",
        )
    if name in flat.scopes:
        raise head.wrong(f"instance '{name}' a second time", "one *INSTANCE per name")
    rotation, origin = instance_pose(head)
    scope = Scope(name, title=head.need("NAME"), rotation=rotation, origin=origin)
    flat.scopes[name] = scope
    _fill(flat, [*parts[source], *extra], scope)


def instance_pose(head: Block) -> tuple[np.ndarray, np.ndarray]:
    """Return rotation (3, 3) and shift (3,) of an instance: a translation, then a turn about an axis by two points."""
    rotation, origin = np.eye(3), np.zeros(3)
    rows = head.rows()
    if rows:
        origin = np.array(head.reals(rows[0], 3, 0.0))
    if len(rows) > 1:
        from scipy.spatial.transform import Rotation

        values = head.reals(rows[1], 7, 0.0)
        a, b, angle = np.array(values[:3]), np.array(values[3:6]), np.radians(values[6])
        axis = b - a
        if not np.linalg.norm(axis) > 0.0:
            raise head.wrong("an axis of rotation without length", "two different points")
        rotation = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
        origin = rotation @ (origin - a) + a
    return rotation, origin


def _fill(flat: Flat, blocks: list[Block], scope: Scope) -> None:
    """Add nodes, elements, sets and surfaces of a scope; keep the other keywords."""
    prefix = f"{scope.name}." if scope.name else ""
    for block in blocks:
        if block.name == "NODE":
            _nodes(flat, block, scope, prefix)
    for block in blocks:
        if block.name == "ELEMENT":
            _elements(flat, block, scope, prefix)
    for block in blocks:
        if block.name in ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"):
            raise block.wrong("a mesh made by the keyword", "nodes and elements in the file", "Write the deck expanded")
        if block.name == "NSET":
            _set(flat, block, scope, flat.node_sets, "NSET")
        elif block.name == "ELSET":
            _set(flat, block, scope, flat.element_sets, "ELSET")
        elif block.name == "SURFACE":
            name = prefix + block.need("NAME").lower()
            kind = block.parameters.get("TYPE", "ELEMENT").upper()
            rows = [(row[0], row[1].upper() if len(row) > 1 else "", scope.name) for row in block.rows() if row[0]]
            flat.surfaces[name] = rows
            flat.surface_kinds[name] = kind
            flat.surface_blocks[name] = block
            flat.names.setdefault(name, scope.shown + block.parameters["NAME"])
        elif block.name not in ("NODE", "ELEMENT"):
            flat.blocks.append((block, scope.name))


def _nodes(flat: Flat, block: Block, scope: Scope, prefix: str) -> None:
    if block.parameters.get("SYSTEM", "R").upper() != "R":
        raise block.wrong("SYSTEM= cylindrical or spherical", "rectangular coordinates", "Write the deck expanded")
    made = []
    for row in block.rows():
        label = block.integers(row[:1])
        if not label:
            raise block.wrong(f"'{','.join(row)[:60]}'", "a node number and coordinates")
        point = scope.rotation @ np.array(block.reals(row[1:4], 3, 0.0)) + scope.origin
        if any(row[4:7]) and any(block.reals(row[4:7], 3, 0.0)):
            flat.skipped["*NODE: normals of shells and beams, fields 5 to 7"] += 1
        known = scope.nodes.get(label[0])
        if known is not None:
            if not np.array_equal(flat.points[known], point):
                flat.skipped[f"*NODE: first places of nodes that have a second one ({block.where})"] += 1
            flat.points[known] = point  # the last definition holds, as in the programs
            made.append(known)
            continue
        scope.nodes[label[0]] = len(flat.points)
        made.append(len(flat.points))
        flat.points.append(point)
        flat.labels.append(label[0])
    if "NSET" in block.parameters:
        name = prefix + block.parameters["NSET"].lower()
        flat.node_sets.setdefault(name, []).extend(made)
        flat.names.setdefault(name, scope.shown + block.parameters["NSET"])


def _elements(flat: Flat, block: Block, scope: Scope, prefix: str) -> None:
    kind = block.need("TYPE").upper()
    if kind in NOT_STRUCTURAL:
        flat.skipped[kind] += sum(1 for row in block.rows() if row[0])
        return
    rows = _joined([[word for word in row if word] for row in block.rows()], _count(kind))
    made = []
    for row in rows:
        numbers = [word.rpartition(".") for word in row[1:]]
        label = block.integers(row[:1], 1)[0]
        nodes = []
        for head, _, tail in numbers:
            if not is_number(tail):
                raise block.wrong(f"element {label} with the node '{tail}'", "node numbers")
            if head and head.lower() not in flat.scopes:
                raise block.wrong(
                    f"element {label} with the node '{head}.{tail}'", "the name of an *INSTANCE before it"
                )
            nodes.append(flat.node(int(tail), head.lower() if head else scope.name, block))
        if label in scope.elements:
            if flat.elements[scope.elements[label]].nodes == nodes:
                made.append(scope.elements[label])
                continue
            raise block.wrong(f"element {label} a second time", "each number once")
        scope.elements[label] = len(flat.elements)
        made.append(len(flat.elements))
        flat.elements.append(Element(kind, nodes, label, scope.name))
    if "ELSET" in block.parameters:
        name = prefix + block.parameters["ELSET"].lower()
        flat.element_sets.setdefault(name, []).extend(made)
        flat.names.setdefault(name, scope.shown + block.parameters["ELSET"])


def _count(kind: str) -> int:
    """Return the number of nodes of elements that may need more than one line of a file, else 0."""
    for text, count in (("C3D20", 20), ("C3D15", 15), ("C3D27", 27), ("C3D10", 10), ("C3D8", 8)):
        if text in kind:
            return count
    return 0


def _joined(rows: list[list[str]], count: int) -> list[list[str]]:
    """Return one row per element where a long one is broken over lines."""
    if not count:
        return [row for row in rows if row]
    out: list[list[str]] = []
    for row in rows:
        if out and len(out[-1]) < count + 1:
            out[-1] = out[-1] + row
        elif row:
            out.append(list(row))
    return out


def _set(flat: Flat, block: Block, scope: Scope, table: dict[str, list[int]], key: str) -> None:
    """Add a set; sets of sets are resolved at once, as the programs want them defined before."""
    inside = block.parameters.get("INSTANCE", "").lower() or scope.name
    if inside not in flat.scopes:
        raise block.wrong(f"INSTANCE={inside}, which does not exist", f"One of: {', '.join(flat.scopes)}")
    prefix = f"{scope.name}." if scope.name else ""
    name = prefix + block.need(key).lower()
    flat.names.setdefault(name, scope.shown + block.parameters[key])
    found: list[int] = []
    numbers = flat.scopes[inside].nodes if key == "NSET" else flat.scopes[inside].elements
    if key == "NSET" and "ELSET" in block.parameters:
        for element in flat.named(flat.element_sets, block.parameters["ELSET"], inside, block, "element set"):
            found += flat.elements[element].nodes
    if "GENERATE" in block.parameters:
        found += _generated(block, numbers)
    else:
        _add_named(found, flat, block, inside, numbers, f"*{key} '{flat.names[name]}'")
    table.setdefault(name, []).extend(found)


def _generated(block: Block, numbers: dict[int, int]) -> list[int]:
    """Return what the lines first, last, increment of a set select; numbers of the deck may have gaps."""
    found: list[int] = []
    for row in block.rows():
        values = block.integers(row)
        if not values:
            continue
        first, last, step = (values + [1])[:3] if len(values) > 1 else (values[0], values[0], 1)
        if step <= 0 or last < first or (last - first) // step > MANY:
            raise block.wrong(f"GENERATE {', '.join(row)}", "first, last and a positive increment")
        span = range(first, last + 1, step)
        among = (n for n in sorted(numbers) if n in span) if len(span) > 4 * len(numbers) else span
        found += [numbers[n] for n in among if n in numbers]
    return found


def _add_named(found: list[int], flat: Flat, block: Block, inside: str, numbers: dict[int, int], title: str) -> None:
    """Add what the numbers and names of sets in a block select."""
    for word in block.words():
        if not word:
            continue
        if is_number(word):
            if int(word) in numbers:
                found.append(numbers[int(word)])
            else:  # the programs pass over numbers that do not exist
                flat.skipped[f"{title}: numbers that do not exist"] += 1
        elif title.startswith("*NSET"):
            found += flat.nodes_of(word, inside, block)
        else:
            found += flat.elements_of(word, inside, block)
        if len(found) > MANY:
            raise block.wrong(f"more than {MANY} numbers", "a set of the numbers in the deck", "Name each set once")


def members(flat: Flat, elements: Iterable[int]) -> list[Element]:
    """Return elements by number."""
    return [flat.elements[k] for k in elements]
