"""VTU files: one unstructured grid, binary, appended, compressed by blocks.

The format is written here and not by VTK because the cells of a series never change: they are compressed once, and
each frame costs its own points and fields only. Source: VTK file formats, "XML file formats", appended data.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from flexmb.files import replacing, write_text
from flexmb.io.cell_types import flat_cells

__all__ = ["VtuSeries", "write_collection"]

BLOCK = 1 << 18
TYPE_NAMES = {"f4": "Float32", "f8": "Float64", "i4": "Int32", "i8": "Int64", "u1": "UInt8"}


def _packed(array) -> bytes:
    """Return an array as VTK's compressed block data: sizes (UInt64), then zlib streams."""
    raw = np.ascontiguousarray(array).tobytes()
    blocks = [zlib.compress(raw[k : k + BLOCK], 1) for k in range(0, len(raw), BLOCK)]
    head = (len(blocks), BLOCK, len(raw) % BLOCK, *(len(block) for block in blocks)) if blocks else (0, 0, 0)
    return struct.pack(f"<{len(head)}Q", *head) + b"".join(blocks)


class VtuSeries:
    """Files with the same cells.

    Parameters
    ----------
    cells : sequence of (meshio cell type, (ne, nn) int)
    points, of_cells : mapping of name to (n,) and (ne,) int
        Numbers of points and cells that are the same in every file.
    """

    def __init__(self, cells, points: Mapping[str, np.ndarray] | None = None, of_cells=None):
        connectivity, offsets, types = flat_cells(cells)
        self._n_cells = len(types)
        self._cells = [
            (name, array.dtype, _packed(array))
            for name, array in (
                ("connectivity", connectivity.astype(np.int32)),
                ("offsets", offsets.astype(np.int32)),
                ("types", types),
            )
        ]
        self._points, self._of_cells = (
            [
                (name, np.dtype(np.int64), _packed(np.asarray(values, np.int64)))
                for name, values in (given or {}).items()
            ]
            for given in (points, of_cells)
        )

    def write(self, path: Path, t: float, points: np.ndarray, fields: Mapping[str, np.ndarray]) -> None:
        """Write one frame: time (s), points (n, 3) and fields (n,) or (n, 3)."""
        data: list[bytes] = []

        def entry(name, dtype, components, packed):
            position = sum(len(block) for block in data)
            data.append(packed)
            return (
                f'<DataArray type="{TYPE_NAMES[dtype.str[1:]]}" Name="{name}" NumberOfComponents="{components}" '
                f'format="appended" offset="{position}"/>\n'
            )

        own = [
            entry(name, values.dtype, values.shape[1] if values.ndim == 2 else 1, _packed(values))
            for name, values in fields.items()
        ]
        own += [entry(name, dtype, 1, packed) for name, dtype, packed in self._points]
        numbers = [entry(name, dtype, 1, packed) for name, dtype, packed in self._of_cells]
        place = entry("Points", points.dtype, 3, _packed(points))
        cells = [entry(name, dtype, 1, packed) for name, dtype, packed in self._cells]
        coloured = next((f' Scalars="{name}"' for name, values in fields.items() if values.ndim == 1), "")
        head = (
            '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
            'header_type="UInt64" compressor="vtkZLibDataCompressor">\n<UnstructuredGrid>\n<FieldData>'
            f'<DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{t!r}</DataArray>'
            f'</FieldData>\n<Piece NumberOfPoints="{len(points)}" NumberOfCells="{self._n_cells}">\n'
            f"<PointData{coloured}>\n{''.join(own)}</PointData>\n<CellData>\n{''.join(numbers)}</CellData>\n<Points>\n{place}</Points>\n"
            f"<Cells>\n{''.join(cells)}</Cells>\n</Piece>\n</UnstructuredGrid>\n"
            '<AppendedData encoding="raw">\n_'
        )
        with replacing(path) as part, part.open("wb") as file:
            file.write(head.encode())
            for packed in data:
                file.write(packed)
            file.write(b"\n</AppendedData>\n</VTKFile>\n")


def write_collection(path: Path, entries) -> None:
    """Write the PVD file: entries (time in s, part number, part name, relative file name)."""
    from xml.sax.saxutils import quoteattr  # loads what fetches pages of the web

    lines = [
        f'<DataSet timestep="{t!r}" group="" part="{part}" name={quoteattr(name)} file={quoteattr(file)}/>'
        for t, part, name, file in entries
    ]
    write_text(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">\n'
        "<Collection>\n" + "\n".join(lines) + "\n</Collection>\n</VTKFile>\n",
    )
