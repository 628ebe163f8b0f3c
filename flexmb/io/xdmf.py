"""XDMF file: shows the frames of VTKHDF files to readers that know XDMF but not VTKHDF."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from flexmb.files import write_text
from flexmb.io.vtkhdf import TOPOLOGY

__all__ = ["write_xdmf"]


def write_xdmf(path: Path, times, parts) -> None:
    """Write the XDMF file: a series of collections, one grid per part.

    Parameters
    ----------
    path : Path
    times : (nt,), s
    parts : sequence of (name, file, n_points, n_cells, length of the topology, fields, numbers)
        The file is named relative to the path. `fields` maps name to number of components; `numbers` are the names of
        integers of points and of cells that are stored once.
    """
    lines = [
        '<?xml version="1.0"?>',
        '<Xdmf Version="2.0">',
        "<Domain>",
        '<Grid Name="motion" GridType="Collection" CollectionType="Temporal">',
    ]
    nt = len(times)
    for k, t in enumerate(times):
        lines += [
            '<Grid Name="mechanism" GridType="Collection" CollectionType="Spatial">',
            f'<Time Value="{t!r}"/>',
        ]
        for name, file, n, n_cells, length, fields, (of_points, of_cells) in parts:
            # the cells are referred to as a slab as well: a plain reference makes VTK's reader look for a cached mesh
            # under the text of the geometry's first item, which a slab does not have, and complain at every frame
            cells = _slab(f"{file}:/{TOPOLOGY}", 'NumberType="Int" Precision="8"', 0, length, 1, length)
            points = _slab(f"{file}:/VTKHDF/Points", FLOAT, k * n, n, 3, nt * n)
            lines += [
                f'<Grid Name={quoteattr(name)} GridType="Uniform">',
                f'<Topology TopologyType="Mixed" NumberOfElements="{n_cells}">{cells}</Topology>',
                f'<Geometry GeometryType="XYZ">{points}</Geometry>',
            ]
            for field, components in fields.items():
                kind = "Vector" if components == 3 else "Scalar"
                values = _slab(f"{file}:/VTKHDF/PointData/{field}", FLOAT, k * n, n, components, nt * n)
                lines.append(f'<Attribute Name="{field}" AttributeType="{kind}" Center="Node">{values}</Attribute>')
            for place, center, count, names in (("Point", "Node", n, of_points), ("Cell", "Cell", n_cells, of_cells)):
                for field in names:
                    source = f"{file}:/VTKHDF/{place}Data/{field}"
                    values = _slab(source, 'NumberType="Int" Precision="8"', 0, count, 1, count)
                    head = f'<Attribute Name="{field}" AttributeType="Scalar" Center="{center}">'
                    lines.append(f"{head}{values}</Attribute>")
            lines.append("</Grid>")
        lines.append("</Grid>")
    lines += ["</Grid>", "</Domain>", "</Xdmf>", ""]
    write_text(path, "\n".join(lines))


FLOAT = 'NumberType="Float" Precision="4"'


def _slab(source: str, number: str, start: int, count: int, components: int, total: int) -> str:
    """Return a reference to rows start..start + count of a dataset with `total` rows."""
    if components > 1:
        select, shape, whole = (
            f"{start} 0 1 1 {count} {components}",
            f"{count} {components}",
            f"{total} {components}",
        )
        rank = "3 2"
    else:
        select, shape, whole, rank = f"{start} 1 {count}", f"{count}", f"{total}", "3 1"
    return (
        f'<DataItem ItemType="HyperSlab" Dimensions="{shape}">'
        f'<DataItem Format="XML" Dimensions="{rank}">{select}</DataItem>'
        f'<DataItem Format="HDF" {number} Dimensions="{whole}">{escape(source)}</DataItem></DataItem>'
    )
