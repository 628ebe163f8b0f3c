"""MBDyn ``.fem`` files (data of its ``modal`` joint, record groups 1 to 19): write and read.

Source: MBDyn manual, appendix "FEM file format"; signs as its element uses them (mbdyn/struct/modal.cc, modalad.cc),
checked against the deformed inertia. Against `ModalNeutralData`, in the notation of docs/theory/floating-frame.md::

    I1 m,  I2 m c,  I3 = M_vn,  I4 = wn0,  I5(:, j, k) = wn1[j](:, k),  I6 = M_nn,  I7 = ww0,
    I8_j = (ww1[j] - wn0_j~) / 2,  I9_jk = -ww2[j, k]           J(q) = I7 + sum (I8_j + I8_j^T) q_j - sum I9_jk q_j q_k

(the manual adds the last sum, the program subtracts it). Group 19 holds the geometric stiffness: 1-6 pairs of w
(xx, yy, zz, xy, yz, zx), 7-9 angular acceleration, 10-12 acceleration minus gravity, then force and moment on the body
at each interface, all in body axes. MBDyn counts interfaces in the order of the joint's input, so name them there in
the order of this file. A constant preload is part of the stiffness in group 10. Meshes, stress
modes and load shapes have no place in the format.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb.errors import DataFileError
from flexmb.files import write_text
from flexmb.io.mbdyn_text import Record, group_text, read_groups
from flexmb.io.sid import acceleration_fields, skew, wallrapp_stiffness
from flexmb.model.modal_arrays import GeometricStiffness, InertiaInvariants
from flexmb.model.modal_neutral_checks import check_modes, checked
from flexmb.model.modal_neutral_data import ModalNeutralData

__all__ = ["read_mbdyn_fem", "write_mbdyn_fem"]

_SPIN, _ANGULAR, _LINEAR, _FIRST_NODE = 6, 9, 12, 12


def write_mbdyn_fem(data: ModalNeutralData, path: str | Path, *, legacy: bool = False, lumped_mass=None) -> Path:
    """Write the data for MBDyn and return the path; the markers become its FEM nodes, interfaces first.

    Parameters
    ----------
    data : ModalNeutralData
    path : path
    legacy : bool
        Leave out groups 14 to 19, which MBDyn of 2021 and before does not know. Modes then meet neither centrifugal nor
        gyroscopic forces; apart from these, modes and rigid motion do not couple in the Buckens frame.
    lumped_mass : (n,), kg, or (n, 6), kg and kg m2, optional, with ``legacy``
        Masses of the mesh nodes: the nodes are written too, with group 11, of which MBDyn makes the couplings itself.

    Raises
    ------
    DataFileError
        Two markers would have the same label, or masses are given in the wrong number or without ``legacy``.
    """
    path = Path(path)
    labels, positions, shapes = _nodes(data, path)
    groups = {}
    if lumped_mass is not None:
        masses = _masses(data, path, lumped_mass, legacy)
        groups[11] = np.vstack([np.zeros((len(labels), 6)), masses])
        labels = labels + [f"node_{k}" for k in range(len(data.nodes))]
        positions = np.vstack([positions, data.nodes])
        rotations = np.zeros_like(data.shapes) if data.rotation_shapes is None else data.rotation_shapes
        shapes = np.concatenate([shapes, np.concatenate([data.shapes, rotations], axis=1)])
    m, i = data.n_modes, data.invariants
    damping = np.diag(2.0 * data.damping_ratios * np.sqrt(np.diag(data.stiffness) * np.diag(i.nn)))
    groups |= {
        3: np.zeros(m),
        4: np.zeros(m),
        5: positions[:, 0],
        6: positions[:, 1],
        7: positions[:, 2],
        8: shapes,
    }
    preload = 0.0 if data.geometric is None else data.geometric.preload
    groups |= {9: i.nn, 10: data.stiffness + preload, 13: damping}
    groups[12] = np.concatenate([[data.mass], data.center_of_mass, data.inertia.ravel()])
    if not legacy:
        groups |= _couplings(i)
        if data.geometric is not None:
            groups[19] = _stress_stiffness(data.geometric)
    text = group_text(data.name, labels, data.frequencies, groups)
    return write_text(path, text, encoding="ascii", errors="replace")


def _nodes(data: ModalNeutralData, path: Path) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Return labels, positions (k, 3) and shapes (k, 6, m) of the markers."""
    labels = ["_".join(name.split()) for name in data.marker_names]
    twice = sorted({label for label in labels if labels.count(label) > 1})
    if twice:
        raise DataFileError(
            f"MBDyn file '{path}'",
            found=f"two markers with the label '{twice[0]}'",
            expected="labels that differ without their blanks",
            remedy="Rename one of the interfaces or stations",
        )
    return (
        labels,
        data.marker_positions,
        np.concatenate([data.marker_translations, data.marker_rotations], axis=1),
    )


def _masses(data: ModalNeutralData, path: Path, lumped_mass, legacy: bool) -> np.ndarray:
    given = np.asarray(lumped_mass, float)
    n = len(data.nodes)
    if not legacy or given.shape not in ((n,), (n, 6)):
        raise DataFileError(
            f"MBDyn file '{path}'",
            found=f"lumped_mass of shape {given.shape}" + ("" if legacy else " without legacy=True"),
            expected=f"({n},) or ({n}, 6), and only where groups 14 to 18 are left out: MBDyn would add both",
            remedy="Leave lumped_mass out, or write a legacy file with one mass per node",
        )
    if given.ndim == 1:
        given = np.column_stack([given, given, given, np.zeros((n, 3))])
    return given


def _couplings(i: InertiaInvariants) -> dict[int, np.ndarray]:
    """Return the invariants I3, I4, I8, I5, I9 in the order in which their numbers stand in the file."""
    I8 = 0.5 * (i.ww1 - skew(i.wn0.T))
    return {
        14: i.vn,
        15: i.wn0,
        16: I8.transpose(1, 0, 2).reshape(3, -1),  # (row, mode, column)
        17: i.wn1.transpose(1, 0, 2).reshape(3, -1),  # (row, j, k)
        18: -i.ww2.transpose(2, 0, 1, 3).reshape(3, -1),  # (row, j, k, column)
    }


def _stress_stiffness(g: GeometricStiffness) -> np.ndarray:
    """Return all matrices of group 19 in the order of their indices, (12 + 6 ni, m, m)."""
    linear, angular, spin = wallrapp_stiffness(g.inertia)
    return np.concatenate([spin, angular, linear, g.interface.reshape(-1, *g.inertia.shape[1:])])


def read_mbdyn_fem(path: str | Path) -> ModalNeutralData:
    """Read a file written by this or another program; every FEM node becomes a marker.

    All nodes count as interfaces unless group 19 tells how many carry loads. Group 11 gives the inertia of files
    without groups 14 to 18; a damping matrix is kept on its diagonal.

    Raises
    ------
    DataFileError
        The file is missing, cut off, lacks groups, or holds no inertia.
    """
    path = Path(path)
    part = f"MBDyn file '{path}'"
    record = read_groups(path, part)
    g, m = record.groups, record.n_modes
    translation, rotation = record.shapes[:, :3], record.shapes[:, 3:]
    check_modes(part, np.diag(g[9].reshape(m, m)), np.diag(g[10].reshape(m, m)))
    w2 = np.diag(g[10].reshape(m, m)) / np.where(np.diag(g[9].reshape(m, m)) > 0.0, np.diag(g[9].reshape(m, m)), np.nan)
    C = np.diag(g[13].reshape(m, m)) if 13 in g else np.zeros(m)
    critical = 2.0 * np.sqrt(np.diag(g[10].reshape(m, m)) * np.diag(g[9].reshape(m, m)))
    geometric, n_interfaces = _geometric(record, part)
    data = ModalNeutralData(
        name=path.stem,
        nodes=np.zeros((0, 3)),
        cells=(),
        shapes=np.zeros((0, 3, m)),
        marker_names=record.labels,
        n_interfaces=n_interfaces,
        marker_positions=record.positions,
        marker_translations=translation,
        marker_rotations=rotation,
        stiffness=g[10].reshape(m, m),
        damping_ratios=np.divide(C, critical, out=np.zeros(m), where=critical > 0.0),
        frequencies=np.sqrt(np.nan_to_num(w2, nan=np.inf)) / (2.0 * np.pi),
        invariants=_invariants(record, part),
        geometric=geometric,
        load_shapes=np.zeros((0, 6 + m)),
    )
    return checked(data, part)


def _geometric(record: Record, part: str) -> tuple[GeometricStiffness | None, int]:
    m = record.n_modes
    if not record.stress_stiffness:
        return None, len(record.labels)
    count = max(0, max(record.stress_stiffness) - _FIRST_NODE + 5) // 6
    if min(record.stress_stiffness) < 1 or count > len(record.labels):
        raise DataFileError(
            part,
            found=f"index {max(record.stress_stiffness)} in record group 19",
            expected=f"1 to {_FIRST_NODE + 6 * len(record.labels)}",
            remedy="Six matrices per interface node follow the first twelve",
        )
    all_ = np.zeros((_FIRST_NODE + 6 * count, m, m))
    for index, matrix in record.stress_stiffness.items():
        all_[index - 1] = matrix
    spin, angular, linear, nodal = np.split(all_, (_SPIN, _ANGULAR, _LINEAR))
    stiffness = GeometricStiffness(
        inertia=acceleration_fields(linear, angular, spin),
        interface=nodal.reshape(count, 6, m, m),
        loads=np.zeros((0, m, m)),
        preload=np.zeros((m, m)),
    )
    return stiffness, count if count else len(record.labels)


def _invariants(record: Record, part: str) -> InertiaInvariants:
    g, m = record.groups, record.n_modes
    lumped = _lumped(record) if 11 in g else None
    if 12 in g:
        mass, c, J = g[12][0], g[12][1:4], g[12][4:].reshape(3, 3)
        rigid = (mass * np.eye(3), -mass * skew(c), J + mass * (c @ c * np.eye(3) - np.outer(c, c)))
    elif lumped is not None:
        rigid = (lumped.vv, lumped.vw0, lumped.ww0)
    else:
        raise DataFileError(
            part,
            found="neither record group 11 nor 12",
            expected="lumped masses or global inertia",
            remedy="Write the file with the inertia of the body; a clamped element cannot move",
        )
    zero = {14: (3, m), 15: (3, m), 16: (3, m, 3), 17: (3, m, m), 18: (3, m, m, 3)}
    I3, I4, I8, I5, I9 = (g[n].reshape(size) if n in g else np.zeros(size) for n, size in zero.items())
    if lumped is None or set(zero) & set(g):
        I8 = I8.transpose(1, 0, 2)
        lumped = InertiaInvariants(
            vv=rigid[0],
            vw0=rigid[1],
            vw1=-skew(I3.T),
            vn=I3,
            ww0=rigid[2],
            ww1=I8 + I8.transpose(0, 2, 1),
            ww2=-I9.transpose(1, 2, 0, 3),
            wn0=I4,
            wn1=I5.transpose(1, 0, 2),
            nn=g[9].reshape(m, m),
        )
    values = {**vars(lumped), "vv": rigid[0], "vw0": rigid[1], "ww0": rigid[2]}
    return InertiaInvariants(**values)


def _lumped(record: Record) -> InertiaInvariants:
    """Return the invariants of nodal masses: sums over nodes with mass mu, inertia J, at f, shapes U and V."""
    masses, f, m = record.groups[11].reshape(-1, 6), record.positions, record.n_modes
    mu, J = masses[:, 0], masses[:, 3:]
    U, V = record.shapes[:, :3], record.shapes[:, 3:]
    fx, Ux = skew(f), skew(U.transpose(0, 2, 1))  # (n, 3, 3), (n, m, 3, 3)
    first = np.einsum("n,nab,njcb->jac", mu, fx, Ux)  # I8_j = -mu f~ U_j~ = mu f~ U_j~^T
    return InertiaInvariants(
        vv=mu.sum() * np.eye(3),
        vw0=-skew(mu @ f),
        vw1=-skew(np.einsum("n,naj->ja", mu, U)),
        vn=np.einsum("n,naj->aj", mu, U),
        ww0=np.einsum("n,nab,ncb->ac", mu, fx, fx) + np.diag(J.sum(axis=0)),
        ww1=first + first.transpose(0, 2, 1),
        ww2=np.einsum("n,njba,nkbc->jkac", mu, Ux, Ux, optimize=True),
        wn0=np.einsum("n,nab,nbj->aj", mu, fx, U) + np.einsum("na,naj->aj", J, V),
        wn1=np.einsum("n,njab,nbk->jak", mu, Ux, U, optimize=True),
        nn=record.groups[9].reshape(m, m),
    )
