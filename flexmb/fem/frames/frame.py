"""`frame`: beams with six freedoms per node from points or from a line mesh."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.frames.block import FrameBlock
from flexmb.fem.frames.element import FrameElements, section_flexibility, section_mass
from flexmb.fem.frames.section import Section
from flexmb.fem.meshes.cells import kept_cells
from flexmb.fem.nodal_assembly import all_freedoms, rotated, summed
from flexmb.fem.plausibility import warn_about_material, warn_about_size
from flexmb.fem.told import keeping_warnings
from flexmb.model.described import check_kind, finite_array
from flexmb.model.material import Material

__all__ = ["beam_block", "frame"]

PARALLEL = 1e-6
"""Sine of the angle below which an orientation counts as parallel to its beam."""

OF_STEEL = "Write material=flexmb.Material(young=210e9, poisson=0.3, density=7850.0)"

Sections = Section | Sequence[Section]


@keeping_warnings
def frame(
    points=None,
    *,
    mesh=None,
    section: Sections | Mapping[str, Section],
    material: Material,
    orientation=None,
    connectivity=None,
    node_sets: Mapping[str, object] | None = None,
    shear: bool = True,
    rotary_inertia: bool = True,
    lumped: bool = False,
    name: str = "frame",
) -> FEModel:
    """Return an FE model of beams with two nodes and six freedoms per node.

    The stiffness is exact for loads at the nodes: Timoshenko, or Euler-Bernoulli with ``shear=False``
    (docs/theory/frames.md, eq. (frame-stiffness)); the mass is consistent with the same interpolation.

    Parameters
    ----------
    points : (n, 3), m
        Nodes; successive nodes are joined by a beam unless `connectivity` (ne, 2) says which.
    mesh : a mesh with line cells (`read_mesh`), instead of points
    section : Section, or two, or one per node, or mapping of group to Section
        Two taper linearly from the first to the last node, one per node in every beam.
    material : Material
    orientation : (3,) or (ne, 3)
        Vector whose part normal to the beam is the section's y-axis. Default: global z is the section's
        z-axis as nearly as possible (a beam along global z has y along global y).
    node_sets : mapping of name to node numbers
        Besides "start" and "end", the first and the last node of `points`.
    rotary_inertia : bool
        Whether the bending rotations of the sections carry inertia; torsion always does.
    lumped : bool
        Block-diagonal mass (Hinton, Rock & Zienkiewicz) instead of the consistent one.

    Raises
    ------
    MeshError
        No or coinciding nodes, orientation along a beam, unknown groups.

    Examples
    --------
    >>> steel = Material(young=210e9, poisson=0.3, density=7850.0)
    >>> beam = frame([(0, 0, 0), (1, 0, 0)], section=Section.rectangle(0.02, 0.01), material=steel)
    >>> round(float(beam.K[7, 7]), 1)                        # a little below 12 E I / L^3 = 16800: shear
    16779.1
    """
    part = f"Frame '{name}'"
    check_kind(material, Material, f"{part}, material", OF_STEEL, MeshError)
    nodes, lines, groups, sets, numbering = _lines(part, points, mesh, connectivity)
    warn_about_material(part, material.young, material.density)
    axes, lengths = _axes(part, nodes, lines, orientation)
    pairs = _section_pairs(part, section, nodes, lines, lengths, groups)
    block = _block(pairs, material, lines, axes, lengths, len(nodes), shear, rotary_inertia)
    elements = block.elements
    dofs = all_freedoms(len(nodes))
    mass = elements.lumped_mass() if lumped else elements.consistent_mass()
    K, M = (summed(rotated(local, axes), lines, dofs, len(nodes)) for local in (elements.stiffness(), mass))
    warn_about_size(part, nodes, mass=float(M[::6, ::6].sum()))
    named = {key: np.atleast_1d(np.asarray(value, int)) for key, value in (node_sets or {}).items()}
    return FEModel(
        nodes=nodes, dofs=dofs, K=K, M=M, node_sets={**sets, **named}, blocks=(block,), name=name, numbering=numbering
    )


def beam_block(
    part: str,
    nodes: np.ndarray,
    lines: np.ndarray,
    pairs: list[tuple[Section, Section]],
    material: Material,
    orientation: np.ndarray,
    point_masses: str = "",
) -> FrameBlock:
    """Return beams between nodes (n, 3) with the sections of their two ends and y-axes (ne, 3), by themselves.

    Their lumped masses have rotary inertia, or with `point_masses` none of their own ("all"), or that about the beam's
    line alone ("but torsion").
    """
    axes, lengths = _axes(part, nodes, lines, orientation)
    return _block(pairs, material, lines, axes, lengths, len(nodes), True, True, point_masses)


def wagner_row(section: Section) -> np.ndarray:
    """Return the Wagner coefficient ``int sigma_xx (y^2 + z^2) dA`` per section force (6,), about the line
    of nodes.

    The third moments of the area, zero for sections with two axes of symmetry, are left out.
    """
    (y, z), row = section.area_center, np.zeros(6)
    row[0] = (section.inertia_y + section.inertia_z) / section.area - y**2 - z**2
    row[4], row[5] = 2.0 * z, -2.0 * y
    return row


def bending_rows(section: Section) -> np.ndarray:
    """Return (3, 6): ``sigma_xx = (1, y, z) @ rows @ section forces``, all about the line of nodes
    (frames.md)."""
    (y, z), determinant = section.area_center, section.inertia_y * section.inertia_z - section.product_yz**2
    centred = np.zeros((3, 6))
    centred[0, 0] = 1.0 / section.area
    centred[1, 4], centred[1, 5] = -section.product_yz / determinant, -section.inertia_y / determinant
    centred[2, 4], centred[2, 5] = section.inertia_z / determinant, section.product_yz / determinant
    centred[:, 0] += centred[:, 5] * y - centred[:, 4] * z  # moments about the area centre
    centred[0] -= y * centred[1] + z * centred[2]  # coordinates from the line of nodes
    return centred


def _lines(part, points, mesh, connectivity):
    """Return nodes (n, 3), beams (ne, 2), the beams of each group, the node sets, and the numbers in the file."""
    if (points is None) == (mesh is None):
        raise MeshError(
            part,
            found="neither points nor a mesh" if mesh is None else "both points and a mesh",
            expected="one of them",
            remedy="Give points=(n, 3) or mesh=fem.read_mesh(...)",
        )
    if mesh is not None:
        nodes, cells, groups, sets, _, numbering = kept_cells(mesh, ("line",), part)
        return nodes, cells["line"], groups["line"], sets, numbering
    nodes = np.array(points, float)
    if nodes.ndim != 2 or nodes.shape[1] != 3 or len(nodes) < 2:
        raise MeshError(
            part,
            found=f"points have the shape {nodes.shape}",
            expected="(n, 3), n >= 2",
            remedy="Give one row x, y, z per node; planar frames need z = 0",
        )
    if not np.isfinite(nodes).all():
        bad = int(np.flatnonzero(~np.isfinite(nodes).all(axis=1))[0])
        raise MeshError(
            part,
            found=f"point {bad} is at {nodes[bad].tolist()}",
            expected="finite coordinates, m",
            remedy="Check the list of points",
        )
    if connectivity is None:
        connectivity = np.stack([np.arange(len(nodes) - 1), np.arange(1, len(nodes))], axis=1)
    lines = np.atleast_2d(np.asarray(connectivity, int))
    if lines.shape[1] != 2 or lines.min() < 0 or lines.max() >= len(nodes):
        raise MeshError(
            part,
            found=f"connectivity of shape {lines.shape} with node numbers {lines.min()}..{lines.max()}",
            expected=f"(ne, 2) with numbers 0..{len(nodes) - 1}",
            remedy="Node numbers start at 0",
        )
    return nodes, lines, {}, {"start": np.array([0]), "end": np.array([len(nodes) - 1])}, None


def _axes(part, nodes, lines, orientation):
    """Return local axes (ne, 3, 3), rows x, y, z, and the lengths (ne,)."""
    along = nodes[lines[:, 1]] - nodes[lines[:, 0]]
    lengths = np.linalg.norm(along, axis=1)
    span = np.ptp(nodes, axis=0).max()
    if (lengths <= 1e-12 * span).any():
        beam = int(np.argmin(lengths))
        raise MeshError(
            part,
            found=f"beam {beam} between the nodes {lines[beam].tolist()} has the length {lengths[beam]:.3g} m",
            expected="a positive length",
            remedy="Merge coinciding nodes or remove the beam",
        )
    x = along / lengths[:, None]
    if orientation is None:
        y = np.cross([0.0, 0.0, 1.0], x)
        y[np.linalg.norm(y, axis=1) < 1e-3] = (0.0, 1.0, 0.0)
    else:
        across = finite_array(orientation)
        if across.shape not in ((3,), x.shape):
            raise MeshError(
                part,
                found=f"orientation = {orientation!r:.80}",
                expected=f"a vector that gives the section's y-axis, or one for each of {len(x)} beams",
                remedy="Give orientation=(x, y, z) across the beam, or one row per beam",
            )
        y = np.broadcast_to(across, x.shape).copy()
    given = np.linalg.norm(y, axis=1)
    y -= (y * x).sum(axis=1)[:, None] * x
    size = np.linalg.norm(y, axis=1)
    if (size <= PARALLEL * given).any() or (given == 0.0).any():
        beam = int(np.argmin(size / np.where(given > 0.0, given, 1.0)))
        raise MeshError(
            part,
            found=f"the orientation of beam {beam} is zero or parallel to the beam",
            expected="a vector that gives the section's y-axis",
            remedy="Give orientation=(x, y, z) across the beam, or one row per beam",
        )
    y /= size[:, None]
    return np.stack([x, y, np.cross(x, y)], axis=1), lengths


def _block(pairs, material, lines, axes, lengths, count, shear, rotary_inertia, point_masses: str = "") -> FrameBlock:
    polar = point_masses != "all"
    elements = FrameElements(
        lengths,
        _table(pairs, lambda s: section_flexibility(s, material, shear)),
        _table(pairs, lambda s: section_mass(s, material, rotary_inertia)),
        _table(pairs, lambda s: section_mass(s, material, False, polar)) if point_masses else None,
    )
    return FrameBlock(
        connectivity=lines,
        axes=axes,
        elements=elements,
        wagner=_table(pairs, wagner_row),
        bending=_table(pairs, bending_rows),
        number_of_nodes=count,
    )


def _section_pairs(part, section, nodes, lines, lengths, groups) -> list[tuple[Section, Section]]:
    """Return the sections at both ends of every beam."""
    if isinstance(section, Section):
        return [(section, section)] * len(lines)
    if isinstance(section, Mapping):
        pairs: list = [None] * len(lines)
        for group, one in section.items():
            if group not in groups:
                raise MeshError(
                    part,
                    found=f"the group '{group}' does not exist",
                    expected=f"One of: {', '.join(sorted(groups)) or 'none'}",
                    remedy="Name the physical groups of lines in the mesh",
                )
            for beam in groups[group]:
                pairs[beam] = (one, one)
        if None in pairs:
            raise MeshError(
                part,
                found=f"beam {pairs.index(None)} has no section",
                expected="every line in a group that has one",
                remedy="Add its group to section={...}",
            )
        return pairs
    if not isinstance(section, list | tuple):
        section = [section]
    for one in section:
        check_kind(
            one, Section, f"{part}, section", "Write section=fem.Section.tube(diameter=0.05, wall=0.003)", MeshError
        )
    section = list(section)
    if len(section) == 2 and len(nodes) > 2:
        length = np.zeros(len(nodes))
        for beam, (a, b) in enumerate(lines):
            length[b] = length[a] + lengths[beam]
        section = [section[0].between(section[1], float(s / length.max())) for s in length]
    if len(section) != len(nodes):
        raise MeshError(
            part,
            found=f"{len(section)} sections",
            expected=f"1, 2 or one per node ({len(nodes)})",
            remedy="Give one section, two for a taper, or one per node",
        )
    return [(section[a], section[b]) for a, b in lines]


def _table(pairs: list[tuple[Section, Section]], of: Callable[[Section], np.ndarray]):
    """Return the function fraction -> (ne or 1, ...) of a quantity of the sections, each pair evaluated
    once."""
    numbers: dict[tuple[Section, Section], int] = {}
    index = np.array([numbers.setdefault(pair, len(numbers)) for pair in pairs])

    @cache
    def at(fraction: float) -> np.ndarray:
        values = np.stack([of(a.between(b, fraction)) for a, b in numbers])
        return values if len(values) == 1 else values[index]

    return at
