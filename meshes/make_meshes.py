"""Make the meshes of this folder with Gmsh, and write them as Nastran and Abaqus files as well.

    pip install flexmb[mesh]
    python meshes/make_meshes.py

Gmsh is needed only here; the meshes are part of the repository. Lengths in metres. The geometry of the lever is
that of the drive lever of flap track 2: 0.60 m between the bore axes, root section 0.06 m x 0.14 m, titanium, 24 kg.
"""

from __future__ import annotations

import io
import re
from pathlib import Path

import gmsh
import meshio
import numpy as np

from flexmb import fem
from flexmb.fem.meshes import abaqus_cards
from flexmb.fem.meshes.mesh import DIMENSION

FOLDER = Path(__file__).parent
TITANIUM = 4430.0  # kg/m3
LEVER_MASS = 24.0  # kg


def plate_with_bores(length, thickness, hubs, bores, heights):
    """Build a tapered plate from hub to hub in the x-z plane, thickness along y; return its volume tag.

    hubs: (outer radius, width along y) at both ends; bores: radii; heights: web height at both ends.
    """
    occ = gmsh.model.occ
    h0, h1 = heights[0] / 2, heights[1] / 2
    corners = [(0.0, -h0), (length, -h1), (length, h1), (0.0, h0)]
    points = [occ.addPoint(x, -thickness / 2, z) for x, z in corners]
    lines = [occ.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
    web = occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0.0, thickness, 0.0)
    solids = [entity for entity in web if entity[0] == 3]
    for x, (radius, width) in zip((0.0, length), hubs):
        solids.append((3, occ.addCylinder(x, -width / 2, 0.0, 0.0, width, 0.0, radius)))
    body, _ = occ.fuse(solids[:1], solids[1:])
    tools = [(3, occ.addCylinder(x, -1.0, 0.0, 0.0, 2.0, 0.0, radius)) for x, radius in zip((0.0, length), bores)]
    body, _ = occ.cut(body, tools)
    occ.synchronize()
    assert len(body) == 1
    return body[0][1]


def volume_of_lever(root_hub):
    gmsh.clear()
    body = plate_with_bores(0.60, 0.06, ((root_hub, 0.06), (0.060, 0.06)), (0.045, 0.025), (0.14, 0.09))
    return body, gmsh.model.occ.getMass(3, body)


def surfaces_where(body, inside):
    """Return the boundary surfaces of a volume whose bounding box (6,) satisfies `inside`."""
    faces = gmsh.model.getBoundary([(3, body)], oriented=False)
    return [tag for dim, tag in faces if inside(np.array(gmsh.model.getBoundingBox(dim, tag)))]


def is_bore(x, radius):
    def inside(box):
        extent = box[3:] - box[:3]
        return (
            abs((box[0] + box[3]) / 2 - x) < 1e-4
            and abs(extent[0] - 2 * radius) < 1e-4
            and abs(extent[2] - 2 * radius) < 1e-4
            and extent[1] > 1e-3
        )

    return inside


def finish(name, body, size, groups, mid):
    """Mesh with second-order tetrahedra and write ``name.msh`` with the groups and a node at `mid`."""
    center = gmsh.model.occ.addPoint(*mid)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.embed(0, [center], 3, body)
    gmsh.model.addPhysicalGroup(3, [body], name=name)
    for group, tags in groups.items():
        assert tags, group
        gmsh.model.addPhysicalGroup(2, tags, name=group)
    gmsh.model.addPhysicalGroup(0, [center], name="mid")
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 16)
    gmsh.option.setNumber("Mesh.ElementOrder", 2)
    gmsh.option.setNumber("Mesh.HighOrderOptimize", 1)
    gmsh.model.mesh.generate(3)


def lever():
    """Drive lever: x from the root bore to the tip bore, bores along y, root bore centre at the origin."""
    low, high = 0.075, 0.14
    for _ in range(40):  # the root hub's radius makes the mass
        hub = (low + high) / 2
        volume = volume_of_lever(hub)[1]
        low, high = (hub, high) if TITANIUM * volume < LEVER_MASS else (low, hub)
    body, volume = volume_of_lever(hub)
    print(f"lever: root hub radius {hub:.5f} m, {TITANIUM * volume:.4f} kg")
    finish(
        "lever",
        body,
        0.0195,
        {
            "bore_root": surfaces_where(body, is_bore(0.0, 0.045)),
            "bore_tip": surfaces_where(body, is_bore(0.60, 0.025)),
            "upper_skin": surfaces_where(body, lambda b: b[2] > 0.01 and b[3] - b[0] > 0.3),
            "lower_skin": surfaces_where(body, lambda b: b[5] < -0.01 and b[3] - b[0] > 0.3),
        },
        (0.30, 0.0, 0.0),
    )
    save("lever_arm")


def conrod():
    """Connecting rod: x from bore_a to bore_b, bores along z; upper_skin is the flat side z = +0.008 m."""
    gmsh.clear()
    body = plate_with_bores(0.32, 0.016, ((0.030, 0.016), (0.022, 0.016)), (0.018, 0.012), (0.032, 0.024))
    # Built with the bores along y; a quarter turn about x brings y to z.
    gmsh.model.occ.rotate([(3, body)], 0, 0, 0, 1, 0, 0, np.pi / 2)
    gmsh.model.occ.synchronize()

    def bore(x, radius):
        across = is_bore(x, radius)
        return lambda box: across(box[[0, 2, 1, 3, 5, 4]])

    finish(
        "conrod",
        body,
        0.0085,
        {
            "bore_a": surfaces_where(body, bore(0.0, 0.018)),
            "bore_b": surfaces_where(body, bore(0.32, 0.012)),
            "upper_skin": surfaces_where(body, lambda b: b[2] > 0.0079 and b[5] < 0.0081),
        },
        (0.16, 0.0, 0.0),
    )
    save("conrod")


def bracket(order):
    """Angle bracket of structured hexahedra: foot along x, upright along z, width along y."""
    gmsh.clear()
    t, foot, upright, width = 0.012, 0.100, 0.090, 0.060
    xs, zs = (0.0, t, foot), (0.0, t, upright)
    cuts = {(0, 0): (2, 2), (1, 0): (9, 2), (0, 1): (2, 8)}  # L of three rectangles: elements along x and z
    occ = gmsh.model.occ
    rectangles = []
    for i, k in cuts:
        tag = occ.addRectangle(xs[i], zs[k], 0.0, xs[i + 1] - xs[i], zs[k + 1] - zs[k])
        rectangles.append((2, tag))
    occ.fragment(rectangles, [])
    occ.rotate(occ.getEntities(2), 0, 0, 0, 1, 0, 0, np.pi / 2)  # x, y -> x, z
    occ.synchronize()
    for _, curve in gmsh.model.getEntities(1):
        box = np.array(gmsh.model.getBoundingBox(1, curve))
        dx, dz = box[3] - box[0], box[5] - box[2]
        n = 2 if max(dx, dz) < 2 * t else (9 if dx > dz else 8)
        gmsh.model.mesh.setTransfiniteCurve(curve, n + 1)
    faces = gmsh.model.getEntities(2)
    for _, face in faces:
        gmsh.model.mesh.setTransfiniteSurface(face)
        gmsh.model.mesh.setRecombine(2, face)
    solid = occ.extrude(faces, 0.0, width, 0.0, numElements=[6], recombine=True)
    occ.synchronize()
    volumes = [tag for dim, tag in solid if dim == 3]

    def boundary(inside):
        faces = gmsh.model.getBoundary([(3, v) for v in volumes], combined=True, oriented=False)
        return [tag for dim, tag in faces if inside(np.array(gmsh.model.getBoundingBox(dim, tag)))]

    gmsh.model.addPhysicalGroup(3, volumes, name="bracket")
    gmsh.model.addPhysicalGroup(2, boundary(lambda b: b[5] < 1e-4), name="foot")
    gmsh.model.addPhysicalGroup(2, boundary(lambda b: b[2] > upright - 1e-4), name="load")
    gmsh.model.addPhysicalGroup(2, boundary(lambda b: b[3] < 1e-4), name="back")
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 0)
    gmsh.option.setNumber("Mesh.ElementOrder", order)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
    gmsh.model.mesh.generate(3)
    save(f"bracket_hex{8 if order == 1 else 20}")


def save(name):
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.write(str(FOLDER / f"{name}.msh"))
    mesh = fem.read_mesh(FOLDER / f"{name}.msh")
    write_nastran(mesh, FOLDER / f"{name}.bdf")
    write_abaqus(mesh, FOLDER / f"{name}.inp")
    print(f"{name}: {len(mesh.points)} nodes, " + ", ".join(f"{len(c)} {t}" for t, c in mesh.cells))
    for group in sorted(mesh.node_sets):
        print(f"    {group}: {len(mesh.node_sets[group])} nodes")


def solids_only(mesh):
    return [(t, c) for t, c in mesh.cells if DIMENSION[t] == 3]


def write_nastran(mesh, path):
    """Write grid points, solids and SETs named by $HMSET comments; the volume group becomes property 1."""
    cells = solids_only(mesh)
    text = io.StringIO()
    # Ten digits: meshio's field of 16 characters has no room for the eleventh of a negative number.
    points = np.array([[float(f"{x:.9e}") if abs(x) > 1e-9 else 0.0 for x in row] for row in mesh.points])
    meshio.nastran.write(
        text, meshio.Mesh(points, cells, cell_data={"nastran:ref": [np.ones(len(c), int) for _, c in cells]})
    )
    volume = next(name for name, rows in mesh.cell_sets.items() if len(mesh.node_sets[name]) == len(mesh.points))
    lines = [f'$HMNAME PROP       1"{volume}"']
    for number, (name, nodes) in enumerate(sorted(mesh.node_sets.items()), 1):
        if name == volume:
            continue
        lines.append(f'$HMSET {number:8d}        1 "{name}"')
        lines += wrapped(f"SET {number} = ", [str(n + 1) for n in nodes], ", ", continued=",")
    # meshio calls second-order solids CTETRA_ and CHEXA_; Nastran does not.
    bulk = re.sub("^(CTETRA|CHEXA)_", r"\1 ", text.getvalue(), flags=re.MULTILINE).splitlines()
    path.write_text("\n".join([*lines, *bulk[1:]]) + "\n")


def write_abaqus(mesh, path):
    """Write nodes, solids, NSETs, the ELSET of the volume and SURFACEs of its element faces."""
    fe = fem.solid(mesh, _any())
    lines = ["*HEADING", mesh.name, "*NODE"]
    lines += [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(mesh.points, 1)]
    names = {"tetra10": "C3D10", "hexahedron": "C3D8I", "hexahedron20": "C3D20"}
    volume = next(name for name, rows in mesh.cell_sets.items() if len(mesh.node_sets[name]) == len(mesh.points))
    (block,) = fe.blocks
    lines.append(f"*ELEMENT, TYPE={names[block.cell_type]}, ELSET={volume}")
    for i, row in enumerate(block.connectivity, 1):
        lines += wrapped(f"{i}, ", [str(n + 1) for n in row], ", ", continued=",")
    for name, nodes in sorted(mesh.node_sets.items()):
        if name != volume:
            lines += [f"*NSET, NSET={name}", *wrapped("", [str(n + 1) for n in nodes], ", ", continued=",")]
    family = block.element.family
    owner = {
        frozenset(row[list(corners)]): (e, f)
        for e, row in enumerate(block.connectivity, 1)
        for f, corners in enumerate(abaqus_cards.FACES[family], 1)
    }
    size = {"tetra": 3, "hexahedron": 4}[family]
    for name in sorted(mesh.facet_sets):
        by_face: dict[int, list[int]] = {}
        for facet in fe.facet_sets[name]:
            element, face = owner[frozenset(facet[:size])]
            by_face.setdefault(face, []).append(element)
        surface = [f"*SURFACE, TYPE=ELEMENT, NAME={name}"]
        for face, members in sorted(by_face.items()):
            lines += [f"*ELSET, ELSET=_{name}_S{face}", *wrapped("", list(map(str, sorted(members))), ", ", ",")]
            surface.append(f"_{name}_S{face}, S{face}")
        lines += surface
    path.write_text("\n".join(lines) + "\n")


def wrapped(first, words, glue, continued):
    """Return lines of at most 72 characters."""
    lines, line = [], first
    for i, word in enumerate(words):
        piece = word + (glue if i < len(words) - 1 else "")
        if len(line) + len(piece) > 70:
            lines.append(line.rstrip(glue) + continued)
            line = ""
        line += piece
    return [*lines, line]


def _any():
    from flexmb.model.material import MATERIALS

    return MATERIALS["steel"]


def main():
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    lever()
    conrod()
    bracket(1)
    bracket(2)
    gmsh.finalize()


if __name__ == "__main__":
    main()
