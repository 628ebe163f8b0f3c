"""`ModalNeutralData`: a reduced elastic body, complete, independent of how it was reduced.

Notation: m flexible coordinates eta (m), body axes B = axes of the mesh, origin = origin of the mesh.
The velocity of a body is u = (v, w, eta'), in body axes; its kinetic energy is T = 1/2 u^T M_b(eta) u.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.data_source import plain
from flexmb.model.described import entries_of, finite_array
from flexmb.model.modal_arrays import ModalArrays
from flexmb.model.modal_neutral_checks import check_shapes, selected_quality

__all__ = ["ModalNeutralData"]


@dataclass(frozen=True, kw_only=True, eq=False)
class ModalNeutralData(ModalArrays):
    """A reduced elastic body.

    Parameters
    ----------
    name : str
        Name of the part.
    nodes : (n, 3), m
        Node positions in body axes.
    cells : tuple of (meshio cell type, (ne, nn) int)
        Elements for drawing and recovery, node numbers into `nodes`.
    shapes : (n, 3, m)
        Translation of every node by each mode.
    rotation_shapes : (n, 3, m) or None
        Rotation of every node by each mode, 1/m, where the FE nodes have rotations (frames, shells).
    marker_names : tuple of str
        Interfaces first (they may carry loads with geometric stiffness), then stations (observed points).
    n_interfaces : int
        How many of the markers are interfaces.
    marker_positions : (k, 3), m
    marker_translations, marker_rotations : (k, 3, m)
        Mode shapes at the markers: translation (-), rotation (1/m).
    stiffness : (m, m), N/m
    damping_ratios : (m,)
        Fraction of critical damping of each mode, as proposed at reduction (zero if none was).
    frequencies : (m,), Hz
        Frequencies of the retained modes (free-free for the Buckens frame).
    invariants : InertiaInvariants
    left_out : LeftOutStiffness or None
        What loads change of the stiffness as joints hold the body: runs say by how much where geometric stiffness was
        left out, and where the body buckles.
    geometric : GeometricStiffness or None
    load_names : tuple of str
    load_shapes : (nl, 6 + m), N, N m, N
        Generalised force (force, moment about the origin, modal force, all in body axes) of each unit
        load shape.
    load_turning : (nl, 6 + m, m) or None
        Change of the generalised force of each unit load shape per flexible coordinate: the load turns with material,
        and its points of application move.
    preload_turning : (6 + m, m) or None
        The same of the preload whose geometric stiffness is ``geometric.preload``.
    stress_modes : (n, 6, m) or None, Pa/m
        Nodal stress xx, yy, zz, xy, yz, zx of each mode.
    frame : str
        "buckens", or the name of the interface at which the body frame is clamped.
    quality : dict
        The quality report: numbers and text that JSON can hold; of a deck its inventory and what was told of it.
    recipe : dict
        What the body was made from, as JSON can hold it: ``part`` (`flexmb.parts.Part`), ``files`` by name with their
        digests, ``release``, and ``parameters`` of the ``model`` (file) that described it; empty if that is not known.
    node_sets : mapping of name to node numbers (k,)
        Named sets of the FE model: where the stress of a region is wanted.
    numbering : Numbering or None
        Numbers of nodes and cells in the file that the FE model comes from.
    """

    def __post_init__(self):
        from flexmb.model.modal_neutral_report import Quality

        check_shapes(self)
        object.__setattr__(self, "quality", Quality(self.quality))

    def __repr__(self):
        first = f", first {self.frequencies[0]:.4g} Hz" if self.n_modes else ""
        more = "".join(f"; {word}: {', '.join(names)}" for word, names in (("loads", self.load_names),) if names)
        return (
            f"ModalNeutralData('{self.name}': {self.mass:.4g} kg, {self.n_modes} flexible coordinates{first}; markers: "
            f"{', '.join(self.marker_names) or 'none'}{more})"
        )

    def nodes_named(self, where: Any, part: str) -> np.ndarray:
        """Return node numbers (k,) of a set name, "node 63241", "element 812", a node number, the place (3,) of a node,
        m, or a sequence of these.

        ModelError of the `part` where one does not exist.
        """
        from flexmb.model.node_places import nodes_named

        return nodes_named(self, where, part)

    def selected(self, modes) -> ModalNeutralData:
        """Return the body with a subset of its modes: a count (the first so many) or int indices."""
        given = finite_array(modes) if modes is not None else np.empty((0, 0))
        whole = given.ndim < 2 and np.all(given == np.round(given)) and np.all(given >= 0.0)
        if given.ndim == 0:
            j = np.arange(min(int(given), self.n_modes + 1)) if whole else np.empty(0, int)
        else:
            j = given.astype(int) if whole else np.empty(0, int)
        if not whole or (given.size == 0 and entries_of(modes) != ()) or (len(j) and j.max() >= self.n_modes):
            raise ModelError(
                f"Modal neutral data '{self.name}'",
                found=f"mode selection {modes!r}",
                expected=f"a whole number of modes up to {self.n_modes}, or their indices from 0 to {self.n_modes - 1}",
                remedy="Select among the modes of data.frequencies",
            )
        return replace(
            self,
            shapes=self.shapes[..., j],
            rotation_shapes=None if self.rotation_shapes is None else self.rotation_shapes[..., j],
            marker_translations=self.marker_translations[..., j],
            marker_rotations=self.marker_rotations[..., j],
            stiffness=self.stiffness[np.ix_(j, j)],
            damping_ratios=self.damping_ratios[j],
            frequencies=self.frequencies[j],
            invariants=self.invariants.selected(j),
            geometric=None if self.geometric is None else self.geometric.selected(j),
            load_shapes=np.hstack([self.load_shapes[:, :6], self.load_shapes[:, 6:][:, j]]),
            load_turning=None if self.load_turning is None else _selected(self.load_turning, j),
            preload_turning=None if self.preload_turning is None else _selected(self.preload_turning, j),
            stress_modes=None if self.stress_modes is None else self.stress_modes[..., j],
            quality=selected_quality(self, j),
        )

    def made_with(self, parameters: Mapping[str, Any], model: str = "") -> ModalNeutralData:
        """Return the data with the parameters (name to number or list) noted that they were made with.

        A model file that has one of them with another value refuses the data; with `model`, only the file of that name
        does.
        """
        return replace(self, recipe={**self.recipe, "parameters": plain(parameters), "model": model})

    def rotated(self, rotation) -> ModalNeutralData:
        """Return the body turned about its origin, x' = R x; R as matrix, rotation vector (3,) or scipy Rotation."""
        from flexmb.model.changed_data import rotated

        return rotated(self, rotation)

    def translated(self, displacement) -> ModalNeutralData:
        """Return the body moved by a displacement (3,), m, x' = x + d, so that its origin is another point of it."""
        from flexmb.model.changed_data import translated

        return translated(self, displacement)

    def mirrored(self, plane, name: str | None = None) -> ModalNeutralData:
        """Return the image in a mirror through the origin, "xy", "yz", "xz" or given by its normal (3,)."""
        from flexmb.model.changed_data import mirrored

        return mirrored(self, plane, name)

    def rescaled(self, length: float = 1.0, mass: float = 1.0, time: float = 1.0) -> ModalNeutralData:
        """Return the data in other units; the factors say how many new units one old unit is (mm to m: 1e-3)."""
        from flexmb.model.changed_data import rescaled

        return rescaled(self, length, mass, time)

    def report(self) -> str:
        """Return the quality report as text: frequencies against the full model, mass, statics, modes, warnings."""
        from flexmb.model.modal_neutral_report import report

        return report(self)

    def save(self, path: str | Path) -> Path:
        """Write the data to an HDF5 file (schema-versioned) and return its path."""
        from flexmb.model.modal_neutral_file import save

        return save(self, path)

    @staticmethod
    def load(path: str | Path) -> ModalNeutralData:
        """Read data written by `save`; DataFileError if the file is damaged or of another schema version."""
        from flexmb.model.modal_neutral_file import load

        return load(path, ModalNeutralData)


def _selected(turning: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Return the rows and columns of some modes of (..., 6 + m, m)."""
    return turning[..., np.concatenate([np.arange(6), 6 + j]), :][..., j]
