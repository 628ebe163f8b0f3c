"""The decks of CalculiX's test suite, read whole: displacements and natural frequencies beside its reference answers.

The suite is Debian's package calculix-ccx-test (apt-get install calculix-ccx-test). Of every deck that `fem.read_deck`
reads, the first step is computed here if it is linear and static, or one of frequencies: supports and loads of the step
on the stiffness that the deck became. The answer is compared with the `.dat.ref` beside it and, where solids of reduced
integration (C3D20R, C3D8, C3D8R) or others that flexmb does not have stand in the deck, with a run of CalculiX in which
they are fully integrated (C3D20, C3D8I). Static: largest difference of a displacement over the largest displacement.

Run: python benchmarks/calculix_decks.py [folder]
"""

import gzip
import re
import shutil
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

from flexmb import fem
from flexmb.errors import FlexmbError
from flexmb.fem.deck.abaqus import _frames, _model_data, read_abaqus_deck
from flexmb.fem.deck.abaqus_model import flattened_deck
from flexmb.fem.deck.abaqus_surfaces import face_nodes, shape_of
from flexmb.fem.deck.abaqus_text import read_blocks
from flexmb.fem.meshes.abaqus_surfaces import FACES
from flexmb.fem.surface_load import pressure_field

SUITE = Path("/usr/share/doc/calculix-ccx-test/examples/test")
NUMBER = r"[-+]?\d\.\d+E[-+]\d+"


def plain(folder: Path, into: Path) -> list[Path]:
    """Unpack the suite and return its decks."""
    for file in folder.iterdir():
        packed = file.suffix == ".gz"
        data = gzip.decompress(file.read_bytes()) if packed else file.read_bytes()
        (into / (file.stem if packed else file.name)).write_bytes(data)
    return sorted(into.glob("*.inp"))


def step_of(path: Path):
    """Return the flat deck, its frames and the keywords of its first step."""
    flat = flattened_deck(read_blocks(path), str(path))
    deck = read_abaqus_deck(path)
    first = _model_data(flat, deck)
    return flat, _frames(flat, deck), first


def first_line(path: Path) -> str:
    """Return the line of the first *STEP in capitals."""
    lines = [line.upper() for line in path.read_text(errors="replace").splitlines()]
    return next((line for line in lines if line.startswith("*STEP")), "")


def printed(path: Path, what: str) -> dict[int, np.ndarray]:
    """Return the first displacements or forces (3,) that a .dat.ref prints of every node."""
    out: dict[int, np.ndarray] = {}
    inside = False
    for line in path.read_text(errors="replace").splitlines():
        if re.search(r"(displacements|stresses|forces|strains|energy|volume)", line):
            inside = line.strip().startswith(what)
            continue
        row = re.match(rf"^\s+(\d+)\s+({NUMBER})\s+({NUMBER})\s+({NUMBER})\s*$", line)
        if inside and row:
            out.setdefault(int(row[1]), np.array([float(row[k]) for k in (2, 3, 4)]))
    return out


def frequencies(path: Path) -> np.ndarray:
    """Return the natural frequencies, Hz, of the first table of a .dat.ref."""
    text = path.read_text(errors="replace")
    if "E I G E N V A L U E" not in text:
        return np.zeros(0)
    text = text.split("E I G E N V A L U E   O U T P U T")[1].split("P A R T I C I P A T I O N")[0]
    rows = re.findall(rf"^\s+\d+\s+{NUMBER}\s+{NUMBER}\s+({NUMBER})\s+{NUMBER}\s*$", text, re.MULTILINE)
    return np.array([float(row) for row in rows])


def pressed(flat, element, side: int) -> list[int]:
    """Return the nodes of a face of a solid, corners in a ring that sees outward, then the midsides along the ring."""
    cell = shape_of(element.kind)[1].rstrip("0123456789")
    corners = [element.nodes[k] for k in FACES[cell][side - 1]]
    points = np.array(flat.points)
    normal = np.cross(points[corners[1]] - points[corners[0]], points[corners[2]] - points[corners[0]])
    if normal @ (points[corners].mean(axis=0) - points[element.nodes].mean(axis=0)) < 0.0:
        corners = corners[::-1]
    middles = [n for n in face_nodes(element, f"S{side}") if n not in corners]
    ring = []
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        at = 0.5 * (points[a] + points[b])
        ring += [min(middles, key=lambda n: float(np.linalg.norm(points[n] - at)))] if middles else []
    return corners + ring


def loads(flat, frames, first, fe) -> np.ndarray:
    """Return the nodal forces (n, 6, 1) of *CLOAD and *DLOAD of a step; ValueError names what is not known."""
    field = np.zeros((len(fe.nodes), 6, 1))
    for block, scope in first:
        if block.name == "CLOAD":
            for row in block.rows():
                for node in flat.nodes_of(row[0], scope, block):
                    k, value = int(row[1]) - 1, block.reals(row[2:3])[0]
                    force = np.zeros(6)
                    force[k] = value
                    if node in frames:
                        force = np.concatenate([frames[node].T @ force[:3], frames[node].T @ force[3:]])
                    field[node, :, 0] += force
        elif block.name == "DLOAD":
            for row in block.rows():
                chosen = [flat.elements[k] for k in flat.elements_of(row[0], scope, block)]
                field += distributed(flat, chosen, row, block, fe)
        elif block.name in ("DSLOAD", "TEMPERATURE", "DFLUX"):
            raise ValueError(f"*{block.name}")
    return field


def distributed(flat, chosen, row, block, fe) -> np.ndarray:
    label, values = row[1].upper(), block.reals([w for w in row[2:] if w])
    if re.fullmatch(r"P[1-6]", label) and all(shape_of(e.kind)[0] == "solid" for e in chosen):
        rings = [pressed(flat, element, int(label[1])) for element in chosen]
        facets = np.full((len(rings), 9), -1)
        for k, ring in enumerate(rings):
            facets[k, : len(ring)] = ring
        return pressure_field(fe, facets, values[0])
    if label == "P" and all(shape_of(e.kind)[0] == "shell" for e in chosen):
        nodes = [e.nodes for e in chosen]
        facets = np.full((len(nodes), 9), -1)
        for k, ring in enumerate(nodes):
            facets[k, : len(ring)] = ring
        return pressure_field(fe, facets, -values[0])  # along the normal
    if label in ("GRAV", "CENTRIF"):
        return body_force(chosen, label, values, fe)
    raise ValueError(f"*DLOAD {label} on {chosen[0].kind}")


def body_force(chosen, label, values, fe) -> np.ndarray:
    """Return the forces of gravity or rotation: the mass matrix on the field of acceleration, which is linear."""
    used = {n for e in chosen for n in e.nodes}
    if set(fe.dofs[:, 0]) - used:
        raise ValueError(f"*DLOAD {label} on a part of the deck")
    if label == "GRAV":
        field = np.zeros((len(fe.nodes), 6, 1))
        field[:, :3, 0] = values[0] * np.array(values[1:4])
    else:
        axis = np.array(values[4:7]) / np.linalg.norm(values[4:7])
        arm = fe.nodes - np.array(values[1:4])
        field = np.zeros((len(fe.nodes), 6, 1))
        field[:, :3, 0] = values[0] * (arm - np.outer(arm @ axis, axis))
    force = (fe.M @ fe.vectors(field))[:, 0]
    out = np.zeros((len(fe.nodes), 6, 1))
    out[fe.dofs[:, 0], fe.dofs[:, 1], 0] = force
    return out


def held(flat, first, fe) -> np.ndarray:
    """Return the prescribed displacements (ndof,) of the step and its model, nan where free."""
    if "boundary" in fe.slanted:
        raise ValueError("supports across the axes")
    value = np.full(fe.ndof, np.nan)
    value[fem.fixed_freedoms(fe, "boundary") if "boundary" in fe.supports else np.zeros(fe.ndof, bool)] = 0.0
    row_of = {(int(n), int(d)): k for k, (n, d) in enumerate(fe.dofs)}
    for block, scope in [*flat.blocks, *first]:
        if block.name != "BOUNDARY":
            continue
        for row in block.rows():
            if len(row) > 3 and row[3] and block.reals(row[3:4])[0]:
                for node in flat.nodes_of(row[0], scope, block):
                    for k in range(int(row[1]) - 1, int(row[2] or row[1])):
                        if (node, k) not in row_of:
                            raise ValueError("a prescribed freedom that follows others")
                        value[row_of[node, k]] = block.reals(row[3:4])[0]
    return value


def static(path: Path, reference: dict[int, np.ndarray], what: str = "displacements") -> float:
    """Return the largest difference of a displacement, or of a nodal force K u, over the largest of the reference."""
    flat, frames, first = step_of(path)
    fe = fem.read_deck(path, show=False)
    value = held(flat, first, fe)
    load = fe.forces(loads(flat, frames, first, fe))[:, 0]
    u = np.where(np.isnan(value), 0.0, value)
    u += fem.static(fe, load - fe.K @ u, ~np.isnan(value)) * np.isnan(value)
    if what == "forces":
        found = np.zeros((len(fe.nodes), 6))
        found[fe.dofs[:, 0], fe.dofs[:, 1]] = fe.K @ u
        found = found[:, :3]
    else:
        found = fe.field(u[:, None])[:, :3, 0]
    nodes = {int(label): k for k, label in enumerate(fe.labels) if label}
    everywhere = any(b.name == "NODE PRINT" and b.parameters.get("GLOBAL", "").upper() == "YES" for b, _ in first)
    ours, theirs = [], []
    for label, shift in reference.items():
        if label in nodes:
            node = nodes[label]
            ours.append((np.eye(3) if everywhere else frames.get(node, np.eye(3))) @ found[node])
            theirs.append(shift)
    return float(np.abs(np.array(ours) - theirs).max() / np.abs(theirs).max())


def vibration(path: Path, reference: np.ndarray) -> float:
    """Return the largest relative difference of a natural frequency, those of rigid motions left out."""
    fe = fem.read_deck(path, show=False)
    count = min(len(reference), max(fe.ndof // 3, 1))
    modes = fem.eigenmodes(fe, "boundary" if "boundary" in fe.supports else None, n=count)
    theirs = reference[:count]
    elastic = theirs > 1e-3 * theirs.max()
    return float(np.abs(modes.frequencies[elastic] / theirs[elastic] - 1.0).max())


def full(path: Path) -> Path | None:
    """Run CalculiX on the deck with fully integrated solids; None if it has no others, or CalculiX is not installed."""
    text = path.read_text(errors="replace")
    whole = re.sub(r"(?i)C3D20R[BPI]*", "C3D20", text)
    whole = re.sub(r"(?i)(?<!\w)C3D8R?(?=\s*[,\n\r])", "C3D8I", whole)
    if whole == text or shutil.which("ccx") is None:
        return None
    other = path.with_name(f"{path.stem}_full.inp")
    other.write_text(whole)
    try:
        subprocess.run(["ccx", other.stem], cwd=path.parent, capture_output=True, timeout=60)
    except subprocess.TimeoutExpired:
        return None
    return other.with_suffix(".dat") if other.with_suffix(".dat").is_file() else None


def judged(path: Path, reference: Path, kind: str) -> str:
    """Return the difference from a file of results."""
    if kind == "frequency":
        answer = frequencies(reference)
        return f"{vibration(path, answer):.1e}" if len(answer) else ""
    shifts, forces = (printed(reference, what) for what in ("displacements", "forces"))
    result = f"{static(path, shifts):.1e}" if shifts else ""
    if forces and result:
        result += f"   forces {static(path, forces, 'forces'):.1e}"
    return result


def compared(path: Path) -> tuple[str, str]:
    """Return the kind of comparison and its result."""
    reference = path.with_suffix(".dat.ref")
    try:
        flat, _, first = step_of(path)
        words = {block.name for block, _ in flat.blocks} | {block.name for block, _ in first}
        if not reference.is_file():
            return "no answer", ""
        if words & {"PLASTIC", "CONTACT PAIR", "GAP", "TEMPERATURE", "HYPERELASTIC", "CYCLIC SYMMETRY MODEL", "CREEP"}:
            return "not linear", ""
        kind = "frequency" if "FREQUENCY" in words else "static" if "STATIC" in words else ""
        if not kind or "NLGEOM" in first_line(path):
            return "another step", ""
        result = judged(path, reference, kind)
        if not result:
            return "no answer", ""
        if float(result.split()[0]) > 1e-4 and (other := full(path)) is not None:
            result += f"   fully integrated {judged(path, other, kind)}"
        return kind, result
    except FlexmbError as error:
        return "refused", str(error)[:140].replace("\n", " ")
    except ValueError as error:
        return "loads", str(error)[:140]


def main(folder: Path = SUITE) -> None:
    """Print a line per deck."""
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as into:
        for path in plain(folder, Path(into)):
            kind, result = compared(path)
            print(f"{path.stem:<24} {kind:<12} {result}", flush=True)


if __name__ == "__main__":
    main(*(Path(word) for word in sys.argv[1:2]))
