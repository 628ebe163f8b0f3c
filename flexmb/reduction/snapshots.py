"""What a reduced body did in a run, as displacements of its finite elements: snapshots for `Pod`."""

from __future__ import annotations

from hashlib import sha256

import numpy as np

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.model.modal_neutral_data import ModalNeutralData

__all__ = ["Motion", "snapshots_of"]

CLOSE = 1e-6
"""How far nodes of the same FE model may lie apart, relative to its size: data are stored, meshes read again."""


def snapshots_of(fe: FEModel, data: ModalNeutralData, coordinates: np.ndarray) -> np.ndarray:
    """Return the displacements (ndof, k) of a run for `Pod`.

    Parameters
    ----------
    fe : FEModel
    data : ModalNeutralData
        The same model with a larger basis, which took part in the run.
    coordinates : (k, m)
        Its flexible coordinates at k times, such as ``solution.series().modal_coordinates("rod")``.
    """
    reach = CLOSE * max(float(np.ptp(fe.nodes, axis=0).max()), 1e-300)
    if data.nodes.shape != fe.nodes.shape or np.abs(data.nodes - fe.nodes).max() > reach:
        raise ReductionError(
            "Snapshots",
            found=f"a run of '{data.name}' with {len(data.nodes)} nodes, '{fe.name}' has {len(fe.nodes)}",
            expected="a run of the same finite elements",
            remedy="Run a body that was reduced from them, with a larger basis",
        )
    field = np.zeros((len(fe.nodes), 6, data.n_modes))
    field[:, :3] = data.shapes
    if data.rotation_shapes is not None:
        field[:, 3:] = data.rotation_shapes
    return fe.vectors(field) @ np.atleast_2d(coordinates).T


class Motion:
    """The motion of a reduced body in a run, in the place of `Pod`'s snapshots: ``Pod(Motion(data, coordinates))``.

    In model files ``basis = { kind = "Pod", run = "first.h5#beam" }``.

    Parameters
    ----------
    data, coordinates
        As of `snapshots_of`.
    """

    def __init__(self, data: ModalNeutralData, coordinates: np.ndarray):
        self.data, self.coordinates = data, np.atleast_2d(np.asarray(coordinates, float))
        if self.coordinates.ndim != 2 or self.coordinates.shape[1] != data.n_modes or not len(self.coordinates):
            raise ReductionError(
                "Motion",
                found=f"coordinates of shape {np.shape(coordinates)}",
                expected=f"(k, {data.n_modes}), one row for each time",
                remedy=f"Give solution.series().modal_coordinates({data.name!r})",
            )

    def on(self, fe: FEModel) -> np.ndarray:
        """Return the snapshots (ndof, k)."""
        return snapshots_of(fe, self.data, self.coordinates)

    def __repr__(self) -> str:
        """Names it by its content: descriptions are compared, and kept, by their words."""
        content = (self.coordinates, self.data.nodes, self.data.shapes)
        digest = sha256(b"".join(np.ascontiguousarray(part).tobytes() for part in content)).hexdigest()[:16]
        return f"Motion({self.data.name!r}, {len(self.coordinates)} times, {digest})"
