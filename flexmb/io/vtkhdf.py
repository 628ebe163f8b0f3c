"""VTKHDF files: one temporal unstructured grid per part.

Version 2.0 of the format, the most widely read. Cells are stored once, points and fields are appended frame by frame;
the offsets of the cells repeat, the offsets of points and fields advance. Source: VTK documentation, "VTKHDF file
format".
"""

from __future__ import annotations

import numpy as np

from flexmb.io.cell_types import flat_cells, mixed_topology

__all__ = ["TOPOLOGY", "VtkHdfSeries"]

TOPOLOGY = "XDMF/Topology"
"""Place of the cells in the form that XDMF wants; VTKHDF readers do not look there."""


class VtkHdfSeries:
    """Appends frames to an open HDF5 file.

    Parameters
    ----------
    file : h5py.File
    cells : sequence of (meshio cell type, (ne, nn) int)
    n_points : int
    fields : mapping of name to number of components
    points, of_cells : mapping of name to (n,) and (ne,) int
        Numbers of points and cells, stored once for all steps.
    """

    def __init__(self, file, cells, n_points: int, fields, points=None, of_cells=None):
        self.n_points, self.times = n_points, []
        connectivity, ends, types = flat_cells(cells)
        self.root = root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], np.int64)
        root.attrs["Type"] = np.bytes_("UnstructuredGrid")  # the reader wants exactly this length
        for name, number in (
            ("NumberOfPoints", n_points),
            ("NumberOfCells", len(types)),
            ("NumberOfConnectivityIds", len(connectivity)),
        ):
            root.create_dataset(name, data=np.array([number], np.int64))
        root.create_dataset("Connectivity", data=connectivity)
        root.create_dataset("Offsets", data=np.concatenate([[0], ends]).astype(np.int64))
        root.create_dataset("Types", data=types)
        file.create_dataset(TOPOLOGY, data=mixed_topology(cells))
        self.arrays = {"Points": self._growing(root, "Points", 3)}
        data = root.create_group("PointData")
        for name, components in fields.items():
            self.arrays[name] = self._growing(data, name, components)
        self.numbers = {"PointData": dict(points or {}), "CellData": dict(of_cells or {})}
        for place, given in self.numbers.items():
            for name, values in given.items():
                root.require_group(place).create_dataset(
                    name, data=np.asarray(values, np.int64), compression="gzip", compression_opts=1, shuffle=True
                )

    def _growing(self, group, name, components):
        width = (components,) if components > 1 else ()
        return group.create_dataset(
            name,
            shape=(0, *width),
            maxshape=(None, *width),
            dtype=np.float32,
            chunks=(min(self.n_points, 16384), *width),
            compression="gzip",
            compression_opts=1,
            shuffle=True,
        )

    def append(self, t: float, points: np.ndarray, fields) -> None:
        """Add a frame: time (s), points (n, 3) and fields (n,) or (n, 3)."""
        start = len(self.times) * self.n_points
        for name, values in (("Points", points), *fields.items()):
            self.arrays[name].resize(start + self.n_points, axis=0)
            self.arrays[name][start:] = values
        self.times.append(float(t))

    def finish(self) -> None:
        """Write the table of steps."""
        nt = len(self.times)
        steps = self.root.create_group("Steps")
        steps.attrs["NSteps"] = nt
        advance = self.n_points * np.arange(nt, dtype=np.int64)
        zero = np.zeros(nt, np.int64)
        steps.create_dataset("Values", data=np.array(self.times))
        steps.create_dataset("PartOffsets", data=zero)
        steps.create_dataset("NumberOfParts", data=zero + 1)
        steps.create_dataset("PointOffsets", data=advance)
        steps.create_dataset("CellOffsets", data=zero[:, None])
        steps.create_dataset("ConnectivityIdOffsets", data=zero[:, None])
        offsets = steps.create_group("PointDataOffsets")
        for name in self.arrays:
            if name != "Points":
                offsets.create_dataset(name, data=advance)
        for place, given in self.numbers.items():
            for name in given:
                steps.require_group(f"{place}Offsets").create_dataset(name, data=zero)
