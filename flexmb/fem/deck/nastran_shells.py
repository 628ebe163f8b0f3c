"""Shells and solids of a Nastran deck with their properties: PSHELL, PCOMP, PCOMPG, PSHEAR, PSOLID, PLSOLID refused."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmb.fem.deck.cells import SolidCells, first_order_shells, some
from flexmb.fem.deck.contents import Deck, Shells, Solids
from flexmb.fem.deck.nastran_materials import MaterialCard, Materials
from flexmb.fem.deck.nastran_systems import Systems
from flexmb.fem.deck.nastran_text import Bulk, Card, FieldTable
from flexmb.fem.shells.laminate_block import laminate, shear_stiffness, turned_plane

__all__ = ["add_shells", "add_solids"]

NODES = {"CTRIA3": 3, "CTRIAR": 3, "CQUAD4": 4, "CQUADR": 4, "CTRIA6": 6, "CQUAD8": 8}
SOLIDS = {
    "CTETRA": ("tetra", "tetra10", 4, 10),
    "CPENTA": ("wedge", "wedge15", 6, 15),
    "CHEXA": ("hexahedron", "hexahedron20", 8, 20),
    "CPYRAM": ("pyramid", "pyramid13", 5, 13),
}
ORDER = {
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
}
"""Nastran numbers the vertical edges before the edges of the upper face, meshio after."""


TURNLESS = ("CQUAD4", "CTRIA3")
"""Shells whose nodes do not turn in the plane: PARAM, K6ROT holds that rotation by a weak spring."""
K6ROT = 100.0
"""Where the deck does not say; the spring is 1e-6 K6ROT of the shear stiffness in the plane."""


@dataclass(frozen=True, eq=False)
class Layup:
    """A, B, D about the reference plane, thickness, mass per area, faces and depths of a shell property."""

    membrane: np.ndarray
    coupling: np.ndarray
    bending: np.ndarray
    thickness: float
    density: float
    nonstructural: float
    faces: np.ndarray
    depths: np.ndarray
    poisson: float
    shear: float = float("inf")


def add_shells(bulk: Bulk, deck: Deck, materials: Materials, systems: Systems) -> None:
    """Add triangles and quadrilaterals; second order becomes first order on all nodes."""
    properties = {card.integer(1): card for card in bulk.of("PSHELL", "PCOMP", "PCOMPG", "PSHEAR", "PLPLANE")}
    made: dict[int, Layup] = {}
    spring = _spring(bulk)
    for name, count in NODES.items():
        table = bulk.tables.get(name)
        if table is None or not len(table):
            continue
        deck.inventory.read[name] += len(table)
        ids = table.integers(1)
        pids = np.where(table.blank(2), ids, table.integers(2))
        for pid in np.unique(pids):
            rows = np.flatnonzero(pids == pid)
            if int(pid) not in made:
                if int(pid) not in properties:
                    raise table.card(int(rows[0])).refused(
                        f"the property {pid}, which does not exist", "a PSHELL, PCOMP or PCOMPG card"
                    )
                made[int(pid)] = _layup(properties[int(pid)], materials, deck)
            own = spring if name in TURNLESS else None
            _add_group(table.chosen(rows), count, made[int(pid)], deck, systems, f"pid_{pid}", own)
    cards = bulk.of("CSHEAR")
    if cards:
        _add_panels(cards, properties, deck, materials)


def _spring(bulk: Bulk) -> float:
    """Return the share of the shear stiffness by which PARAM, K6ROT holds the rotation in the plane of shells.

    Without any (K6ROT = 0) Nastran leaves the rotation to AUTOSPC; here a millionth keeps the matrix regular.
    """
    given = [card for card in bulk.of("PARAM") if card.text(1).upper() == "K6ROT"]
    return 1e-6 * max(given[-1].real(2, K6ROT) if given else K6ROT, 1.0)


def _add_group(
    table: FieldTable, count: int, layup: Layup, deck: Deck, systems: Systems, group: str, spring: float | None
) -> None:
    """Add the elements of one card and property."""
    corners = 3 if count in (3, 6) else 4
    what = f"{table.where(0)}, {table.name}"
    labels = table.integers(1)
    given = np.stack([table.integers(3 + k) for k in range(count)], axis=1)
    if (given[:, :corners] < 1).any():
        row, corner = np.argwhere(given[:, :corners] < 1)[0]
        raise table.card(int(row)).wrong(3 + int(corner), "the number of a grid point")
    # theta or MCID, ZOFFS and T1.. stand in other places by card
    at = {"CTRIA3": (6, 7, 11), "CTRIAR": (6, 7, 11), "CQUAD4": (7, 8, 11), "CQUADR": (7, 8, 11)}.get(
        table.name, (9, 10, 11) if table.name == "CTRIA6" else (15, 16, 11)
    )
    thickness_at = {"CTRIA6": 11, "CQUAD8": 11}.get(table.name, at[2])
    stretch = _stretch(table, [thickness_at + k for k in range(corners)], layup, deck)
    offset = table.reals(at[1], 0.0)
    nodes = np.where(given > 0, deck.numbers(np.where(given > 0, given, given[:, :1]), what), -1)
    material_x = _material_axes(table, at[0], nodes, deck, systems)
    cells, rows = first_order_shells(nodes, deck.inventory, table.name)
    mass = layup.density * stretch + layup.nonstructural
    for connectivity, own in zip(cells, rows, strict=True):
        if len(connectivity):
            deck.shells.append(
                Shells(
                    nodes=connectivity,
                    labels=labels[own],
                    membrane=layup.membrane,
                    coupling=layup.coupling,
                    bending=layup.bending,
                    material_x=material_x[own],
                    offset=offset[own],
                    thickness=layup.thickness * stretch[own],
                    mass=mass[own],
                    faces=layup.faces,
                    depths=layup.depths,
                    stretch=stretch[own],
                    poisson=layup.poisson,
                    shear=layup.shear,
                    group=group,
                    spring=spring,
                    point_masses=True,
                )
            )


def _stretch(table: FieldTable, at: list[int], layup: Layup, deck: Deck) -> np.ndarray:
    """Return the thickness of each element over its property's, from thicknesses at the corners: zero is one, blank
    is the property's.
    """
    given = np.stack([~table.blank(k) for k in at], axis=1)
    own = given.any(axis=1)
    if not own.any():
        return np.ones(len(table))
    corners = np.stack([table.reals(k, 0.0) for k in at], axis=1)
    if (wrong := (corners < 0.0).any(axis=1) | (given.all(axis=1) & ~corners.any(axis=1))).any():
        row = int(wrong.argmax())
        values = ", ".join(f"{x:g}" for x in corners[row])
        raise table.card(row).refused(f"thicknesses {values} at the corners", "none below zero, one above")
    flag_at = {"CTRIA6": 14, "CQUAD8": 17}.get(table.name, 10)
    relative = table.integers(flag_at, 0) == 1  # TFLAG: fractions of the property's thickness
    full = np.where(given, corners, np.where(relative[:, None], 1.0, layup.thickness))
    if (np.ptp(full[own], axis=1) > 1e-6 * full[own].max()).any():
        deck.inventory.approximated[f"{table.name} with thicknesses that differ at the corners, their mean"] += int(
            own.sum()
        )
    mean = full.mean(axis=1)
    return np.where(own, np.where(relative, mean, mean / layup.thickness), 1.0)


def _material_axes(table: FieldTable, at: int, nodes: np.ndarray, deck: Deck, systems: Systems) -> np.ndarray:
    """Return the direction (ne, 3) of the first material axis: the side 1-2 turned by THETA, or the x of MCID."""
    points = deck.points[nodes[:, :3]]
    side = points[:, 1] - points[:, 0]
    normal = np.cross(side, deck.points[nodes[:, 3 if nodes.shape[1] in (4, 8) else 2]] - points[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    words = table.column(at)
    integral = (
        np.array([word.isdigit() and len(word) < 10 for word in words])
        if (words != b"").any()
        else np.zeros(len(words), bool)
    )
    angle = np.radians(table.reals(at, 0.0))
    angle[integral] = 0.0
    direction = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * np.cross(normal, side)
    if integral.any():
        systems_of = np.where(integral, np.where(integral, words, b"0").astype(np.int64), 0)
        for number in np.unique(systems_of[integral]):
            rows = np.flatnonzero(integral & (systems_of == number))
            centres = deck.points[nodes[rows, :3]].mean(axis=1)
            direction[rows] = systems.system(int(number), table.where(int(rows[0]))).directions(centres)[:, 0]
    return direction


def _layup(card: Card, materials: Materials, deck: Deck) -> Layup:
    deck.inventory.read[card.name] += 1
    if card.name == "PSHELL":
        return _pshell(card, materials, deck)
    if card.name in ("PCOMP", "PCOMPG"):
        return _pcomp(card, materials, deck)
    raise card.refused(f"a property {card.name}", "PSHELL, PCOMP or PCOMPG", "Give these shells a structural property")


def _pshell(card: Card, materials: Materials, deck: Deck) -> Layup:
    who = f"{card.where}, card PSHELL {card.text(1)}"
    t = card.real(3, 0.0)
    if not t > 0.0:
        raise card.refused(f"T = {t:g}", "a positive thickness")
    heavy = "m" if card.text(2) else "b"  # MID1 gives the mass; MID2 does where it is alone
    used = {
        k: materials.get(card.integer(i), who, weighs=k == heavy)
        for k, i in (("m", 2), ("b", 4), ("s", 6))
        if card.text(i)
    }
    if card.text(4) and card.integer(4) == -1:
        used.pop("b", None)
    if "m" not in used and "b" not in used:
        raise card.refused("neither MID1 nor MID2", "a membrane or a bending material")
    for key in ("m", "b"):
        if key in used and used[key].plane is None:
            raise card.refused(f"the material {used[key].name}", "MAT1, MAT2 or MAT8 for shells")
    zero = np.zeros((3, 3))
    ratio = card.real(5, 1.0)
    q_m = used["m"].plane if "m" in used else zero
    q_b = used["b"].plane if "b" in used else zero
    assert q_m is not None
    assert q_b is not None
    coupling = zero
    if card.text(11) and card.integer(11):
        coupled = materials.get(card.integer(11), who, weighs=False).plane
        coupling = zero if coupled is None else coupled * t**2
    shear = float("inf")
    if "s" in used and "b" in used:
        shear = card.real(7, 5.0 / 6.0) * t * _across(used["s"])
    if "b" not in used:
        deck.inventory.approximated[f"PSHELL {card.text(1)}: membrane only, rotations held"] += 1
    lead = used.get("m", used.get("b"))
    assert lead is not None
    z1, z2 = card.real(9, -t / 2.0), card.real(10, t / 2.0)
    faces = np.stack([q_m if "m" in used else q_b] * 2)
    return Layup(
        q_m * t,
        coupling,
        q_b * ratio * t**3 / 12.0,
        t,
        lead.density * t,
        card.real(8, 0.0),
        faces,
        np.array([min(z1, z2), max(z1, z2)]) if min(z1, z2) < max(z1, z2) else np.array([-t / 2, t / 2]),
        lead.poisson if lead.young > 0.0 else 0.3,
        shear,
    )


def _across(material: MaterialCard) -> float:
    """Return the mean transverse shear modulus of a material, inf where it is not given."""
    g1, g2 = material.across
    return 0.5 * (g1 + g2)


def _pcomp(card: Card, materials: Materials, deck: Deck) -> Layup:
    who = f"{card.where}, card {card.name} {card.text(1)}"
    option = card.text(8).upper()
    width, first = (4, 9) if card.name == "PCOMP" else (8, 9)
    shift = 0 if card.name == "PCOMP" else 1  # PCOMPG begins each ply with its global number
    plies: list[tuple[np.ndarray, float, float]] = []
    across: list[tuple[float, float]] = []
    density, last_mid, last_t = 0.0, None, None
    for at in range(first, len(card.fields), width):
        words = card.fields[at : at + width]
        if not any(words):
            continue
        mid = card.integer(at + shift, last_mid)
        t = card.real(at + shift + 1, last_t)
        last_mid, last_t = mid, t
        material = materials.get(mid, who)
        if material.plane is None:
            raise card.refused(f"the material {material.name}", "MAT1, MAT2 or MAT8 for plies")
        if not t > 0.0:
            raise card.refused(f"a ply of thickness {t:g}", "positive thicknesses")
        plies.append((material.plane, t, np.radians(card.real(at + shift + 2, 0.0))))
        across.append(material.across)
        density += material.density * t
    if not plies:
        raise card.refused("no plies", "at least one ply")
    if option.startswith("SYM"):
        plies += plies[::-1]
        across += across[::-1]
        density *= 2.0
    total = sum(t for _, t, _ in plies)
    z0 = card.real(2, -total / 2.0)
    a, b, d = laminate(plies, z0)
    if option in ("MEM", "SYMEM"):
        b, d = 0.0 * b, 0.0 * d
    elif option == "BEND":
        a, b = 0.0 * a, 0.0 * b
    elif option == "SMEAR":
        b, d = 0.0 * b, a * total**2 / 12.0
    if np.abs(b).max() < 1e-9 * np.abs(a).max() * total:
        b = 0.0 * b
    faces = np.stack([turned_plane(plies[k][0], plies[k][2]) for k in (0, -1)])
    shear = shear_stiffness(plies, across) if d.any() else float("inf")
    return Layup(a, b, d, total, density, card.real(3, 0.0), faces, np.array([z0, z0 + total]), 0.3, shear)


def _add_panels(cards: list[Card], properties: dict[int, Card], deck: Deck, materials: Materials) -> None:
    """Add CSHEAR panels as membranes that resist shear only, and their effective edge areas not at all."""
    for card in cards:
        pid = card.integer(2, card.integer(1))
        if pid not in properties or properties[pid].name != "PSHEAR":
            raise card.refused(f"the property {pid}", "a PSHEAR card")
        source = properties[pid]
        material = materials.get(source.integer(2), source.where)
        t = source.real(3)
        nodes = deck.numbers([card.integer(3 + k) for k in range(4)], f"{card.where}, CSHEAR")[None, :]
        membrane = np.diag([0.0, 0.0, material.shear * t])
        side = deck.points[nodes[:, 1]] - deck.points[nodes[:, 0]]
        one, none = np.ones(1), np.zeros((3, 3))
        deck.shells.append(
            Shells(
                nodes=nodes,
                labels=np.array([card.integer(1)]),
                membrane=membrane,
                coupling=none,
                bending=none,
                material_x=side,
                offset=0.0 * one,
                thickness=t * one,
                mass=(material.density * t + source.real(4, 0.0)) * one,
                faces=np.stack([membrane / t] * 2),
                depths=np.array([-t / 2, t / 2]),
                stretch=one,
                poisson=0.3,
                shear=float("inf"),
                group=f"pid_{pid}",
                point_masses=True,
            )
        )
        deck.inventory.read["CSHEAR"] += 1
        deck.inventory.approximated["CSHEAR panels, as membranes that resist shear only"] += 1


def add_solids(bulk: Bulk, deck: Deck, materials: Materials, systems: Systems) -> None:
    """Add tetrahedra, wedges, hexahedra and pyramids of both orders, with midside nodes left out or not."""
    properties = {card.integer(1): card for card in bulk.of("PSOLID", "PLSOLID", "PCOMPS", "PCOMPLS", "PMIC")}
    for name, (low, high, corners, count) in SOLIDS.items():
        table = bulk.tables.get(name)
        if table is None or not len(table):
            continue
        deck.inventory.read[name] += len(table)
        labels = table.integers(1)
        pids = np.where(table.blank(2), labels, table.integers(2))
        last = max((k for k in range(count) if not table.blank(3 + k).all()), default=0)
        used = count if last >= corners else corners  # a table of first order has no columns of midside nodes
        given = np.empty((len(table), used), np.int64)
        for k in range(used):
            given[:, k] = table.integers(3 + k)
        if (given[:, :corners] < 1).any():
            row = int(np.flatnonzero((given[:, :corners] < 1).any(axis=1))[0])
            raise table.card(row).refused(
                f"{int((given[row] > 0).sum())} nodes", f"{corners} corner nodes at least", "Complete the card"
            )
        empty = given < 1
        np.copyto(given, given[:, :1], where=empty)
        nodes = deck.numbers(given, f"{name} cards", out=given)
        nodes[empty] = -1
        del given, empty
        if high in ORDER and used == count:
            nodes = nodes[:, ORDER[high]]
        for pid in np.unique(pids):
            rows = np.flatnonzero(pids == pid)
            if int(pid) not in properties:
                raise table.card(int(rows[0])).refused(f"the property {pid}, which does not exist", "a PSOLID card")
            card = properties[int(pid)]
            if card.name != "PSOLID":
                raise card.refused(f"a property {card.name}", "PSOLID", "Give these solids a linear property")
            if card.text(7).upper() in ("FFLUID", "PFLUID") or card.text(3).upper() == "FLUID":
                raise card.refused("a fluid (FCTN)", "structural solids", "Remove the fluid")
            material = materials.get(card.integer(2), card.where)
            if material.solid is None:
                raise card.refused(f"the material {material.name}", "MAT1 or MAT9 for solids")
            cells = SolidCells(low, high, corners, some(nodes, rows), labels[rows])
            for cell_type, connectivity, own in cells.parts(deck):
                for elasticity, chosen in _oriented(card, material.solid, connectivity, deck, systems):
                    deck.solids.append(
                        Solids(
                            cell_type=cell_type,
                            nodes=some(connectivity, chosen),
                            labels=own[chosen],
                            elasticity=elasticity,
                            density=material.density,
                            group=f"pid_{pid}",
                        )
                    )
    for card in properties.values():
        deck.inventory.read[card.name] += 1


def _oriented(card: Card, solid: np.ndarray, nodes: np.ndarray, deck: Deck, systems: Systems):
    """Yield (elasticity in basic axes, element numbers): one for all, or one per direction of a curved system."""
    everything = np.arange(len(nodes))
    isotropic = np.allclose(solid, turned_solid(solid, _any_rotation()), rtol=1e-9, atol=1e-9 * np.abs(solid).max())
    if isotropic:
        yield solid, everything
        return
    number = card.integer(3, 0)
    if number == -1:
        raise card.refused(
            "CORDM = -1 (axes of each element) with an anisotropic material",
            "a coordinate system",
            "Give CORDM the number of a system",
        )
    system = systems.system(number, card.where)
    axes = system.directions(deck.points[nodes].mean(axis=1))
    groups, which = np.unique(np.round(axes.reshape(len(axes), 9), 9), axis=0, return_inverse=True)
    for k in range(len(groups)):
        chosen = np.flatnonzero(which.ravel() == k)
        yield turned_solid(solid, axes[chosen[0]].T), chosen


def _any_rotation() -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()


def turned_solid(elasticity: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return an elasticity (6, 6), xx yy zz xy yz zx, in the axes in which the material axes are `columns` (3, 3)."""
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
    stress = np.array(
        [
            [columns[i, k] * columns[j, m] + (columns[i, m] * columns[j, k] if k != m else 0.0) for k, m in pairs]
            for i, j in pairs
        ]
    )
    return stress @ elasticity @ stress.T
