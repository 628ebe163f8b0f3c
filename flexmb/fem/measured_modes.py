"""Modes of a test beside computed ones: dataset 55 of universal files, and the modal assurance criterion.

R. J. Allemang, The modal assurance criterion: twenty years of use and abuse, Sound and Vibration 37(8) (2003) 14-23.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flexmb.errors import MeshError
from flexmb.fem.fe_model import FEModel
from flexmb.fem.foreign_files import require_file
from flexmb.fem.meshes.universal_datasets import damaged, datasets
from flexmb.fem.solve import Modes

__all__ = ["MeasuredModes", "modal_assurance", "read_measured_modes"]

NORMAL, COMPLEX = (2,), (3, 7)
"""Analysis types of dataset 55: normal modes; complex eigenvalues of first and of second order."""
UNSEEN = 1e-6
"""A computed mode that moves less than this share of its largest motion where the test measured is not seen there."""
WIDTH = 13
"""Characters of a real number."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredModes:
    """Modes of a test.

    Parameters
    ----------
    frequencies, damping : (n,), Hz, -
        Undamped natural frequencies and ratios of critical damping, in the order of the file.
    labels : (p,) int
        Numbers of the points of measurement.
    shapes : (n, p, 3)
        Translations x, y, z of every point in every mode, real or complex, in any scale.
    name : str
        Of the file.
    """

    frequencies: np.ndarray
    damping: np.ndarray
    labels: np.ndarray
    shapes: np.ndarray
    name: str


def read_measured_modes(path: str | Path) -> MeasuredModes:
    """Return the modes in the datasets 55 of a universal file (.unv, .uff).

    Rotations are passed over. Every mode must have the same points.

    Raises
    ------
    MeshError
        No file, no modes in it, or data that are damaged or of another kind.
    """
    path = Path(path)
    part = f"Universal file '{path}'"
    require_file(part, path, "an existing file", "Check its name", (".unv", ".uff"))
    modes, others = [], set()
    for number, lines in datasets(path, part):
        mode = _mode(part, lines) if number == 55 else None
        if mode is None:
            others.add(number)
        else:
            modes.append(mode)
    if not modes:
        raise MeshError(
            part,
            found=f"no modes; its datasets are {', '.join(map(str, sorted(others))) or 'none'}",
            expected="datasets 55 of normal or complex modes",
            remedy="Write the modes of the test as dataset 55; fem.read_measured_responses reads 58",
        )
    labels = np.array(sorted(modes[0][2]), np.int64)
    for k, (_, _, shape) in enumerate(modes):
        if sorted(shape) != labels.tolist():
            missing = sorted(set(labels.tolist()) ^ set(shape))
            raise MeshError(
                part,
                found=f"mode {k + 1} has other points than mode 1, the first is {missing[0]}",
                expected="the same points in every mode",
                remedy="Write the modes of one test to a file",
            )
    shapes = np.array([[shape[label] for label in labels.tolist()] for _, _, shape in modes])
    frequencies, damping = (np.array([mode[k] for mode in modes], float) for k in range(2))
    return MeasuredModes(
        frequencies=frequencies,
        damping=damping,
        labels=labels,
        shapes=shapes if np.iscomplexobj(shapes) and np.any(shapes.imag) else shapes.real,
        name=path.name,
    )


def _mode(part: str, lines: list[str]) -> tuple[float, float, dict[int, np.ndarray]] | None:
    """Return frequency, damping and shape of a dataset 55; None if it holds no mode of points."""
    head = _numbers(part, lines[5] if len(lines) > 5 else "", 6)
    analysis, data_type, per_node = int(head[1]), int(head[4]), int(head[5])
    if analysis not in (*NORMAL, *COMPLEX):
        return None
    if data_type not in (2, 5) or per_node not in (3, 6):
        raise MeshError(
            part,
            found=f"a mode of data type {data_type} with {per_node} numbers a point",
            expected="real (2) or complex (5) modes of 3 or 6 directions",
            remedy="Write the modes again",
        )
    values = _numbers(part, lines[7] if len(lines) > 7 else "", 6 if analysis in COMPLEX else 4)
    if analysis in NORMAL:
        frequency, damping = float(values[0]), float(values[2]) or 0.5 * float(values[3])
    else:
        size = float(np.hypot(values[0], values[1]))
        frequency, damping = size / (2.0 * np.pi), -float(values[0]) / size if size > 0.0 else 0.0
    count = per_node * (2 if data_type == 5 else 1)
    step = 1 + -(-count // 6)
    shape: dict[int, np.ndarray] = {}
    for k in range(8, len(lines), step):
        if not lines[k].strip():
            continue
        label = int(_numbers(part, lines[k], 1)[0])
        row = np.concatenate(
            [_numbers(part, line, min(6, count - 6 * i)) for i, line in enumerate(lines[k + 1 : k + step])]
            or [np.zeros(0)]
        )
        if len(row) < count:
            raise damaged(part, f"point {label} with {len(row)} numbers in dataset 55", f"{count} numbers")
        shape[label] = (row[0::2] + 1j * row[1::2])[:3] if data_type == 5 else row[:3]
    return frequency, damping, shape


def _numbers(part: str, line: str, count: int) -> np.ndarray:
    """Return the first numbers of a line, split at blanks, or by width where fields touch."""
    words = line.split()
    if len(words) < count:
        words = [line[k : k + WIDTH].strip() for k in range(0, WIDTH * count, WIDTH)]
    try:
        found = np.array([float(word.upper().replace("D", "E")) for word in words[:count]])
    except ValueError:
        found = np.zeros(0)
    if len(found) < count or not np.isfinite(found).all():
        raise damaged(part, f"the line '{line.strip()[:90]}' in dataset 55", f"{count} numbers")
    return found


def modal_assurance(
    fe: FEModel, modes: Modes, measured: MeasuredModes, nodes: Mapping[int, int | str] | None = None
) -> np.ndarray:
    """Return the modal assurance criterion of each measured with each computed mode, (n measured, n computed).

    ``MAC = |a^H b|^2 / ((a^H a) (b^H b))`` over the measured directions: 1 for shapes that are alike, 0 for orthogonal
    ones (Allemang 2003, eq. 1). A direction that is zero at a point in all measured modes was not measured; a computed
    mode that stands still in all that were measured has 0.

    Parameters
    ----------
    fe : FEModel
    modes : Modes
        Of `fem.eigenmodes`.
    measured : MeasuredModes
        Translations in the axes of the model.
    nodes : mapping of point to node, optional
        For every point its node: a row of ``fe.nodes``, or a name as "node 63241" or a set of one node. Default: points
        have the numbers of the deck's nodes. Points that the mapping leaves out are not compared.

    Raises
    ------
    MeshError
        Points without a node, or nothing to compare.
    """
    part = f"FE model '{fe.name}'"
    if nodes is None:
        nodes = {label: f"node {label}" for label in measured.labels.tolist()}
    rows, chosen = [], []
    for at, label in enumerate(measured.labels.tolist()):
        if label not in nodes:
            continue
        place = nodes[label]
        found = fe.node_set(place) if isinstance(place, str) else np.array([place])
        if len(found) != 1 or not 0 <= found[0] < len(fe.nodes):
            raise MeshError(
                part,
                found=f"point {label} of '{measured.name}' at {place!r}, which is {len(found)} nodes of the model",
                expected="one node for every point",
                remedy='Give nodes={12: "node 63241", ...} for the points of the test',
            )
        rows.append(int(found[0]))
        chosen.append(at)
    a = measured.shapes[:, chosen].reshape(len(measured.shapes), -1) if chosen else np.zeros((len(measured.shapes), 0))
    used = np.abs(a).max(axis=0, initial=0.0) > 0.0
    if not used.any():
        raise MeshError(
            part,
            found=f"no measured direction of '{measured.name}' at the points that are compared",
            expected="points of the test with a node each",
            remedy="Name the nodes of the points: nodes={1: 'node 101', ...}",
        )
    field = fe.field(modes.shapes)[:, :3]
    b = field[rows].reshape(-1, modes.shapes.shape[1])[used]
    b = np.where(np.abs(b).max(axis=0) > UNSEEN * np.abs(field).max(axis=(0, 1)), b, 0.0)
    a = a[:, used]
    sizes = np.outer((np.abs(a) ** 2).sum(axis=1), (np.abs(b) ** 2).sum(axis=0))
    products = np.abs(a.conj() @ b) ** 2
    return np.divide(products, sizes, out=np.zeros_like(products), where=sizes > 0.0)
