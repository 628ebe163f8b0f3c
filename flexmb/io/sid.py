"""SID files (O. Wallrapp: Standard input data of flexible members in multibody systems, 1993): write and read.

A SID body is a Taylor series of the body mass matrix in the modal coordinates, up to first order. Against
`ModalNeutralData`, in the notation of docs/theory/floating-frame.md:

    mdCM = M_vw (as m c),  J = M_ww,  Ct = M_vn^T,  Cr = M_wn^T,  Me = M_nn,
    Gr_k = J1_k - (Cr0_k)~,  Ge = Cr1 - Cr1^T,  Oe = -1/2 dM_ww/dq by pairs of w: xx, yy, zz, xy, yz, zx.

Geometric stiffness goes where Wallrapp put it: unit acceleration into Ct1, angular acceleration into Cr1, pairs of w
into Oe1, nodal forces and moments into phi and psi. Only the markers of the body are written as nodes; meshes, stress
modes and load shapes have no place in the format.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmb.errors import DataFileError
from flexmb.files import write_text
from flexmb.found import no_file_because
from flexmb.io.sid_text import SidText, Taylor, read_sid_text, taylor_text
from flexmb.model.modal_arrays import GeometricStiffness, InertiaInvariants
from flexmb.model.modal_neutral_checks import check_modes, checked
from flexmb.model.modal_neutral_data import ModalNeutralData

__all__ = ["read_sid", "write_sid"]

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))  # of w in Oe
TENSOR = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # of J
_IDENTITY = 1e-6  # relative error up to which a layout of Ge counts as met


def skew(a: np.ndarray) -> np.ndarray:
    """Return the matrices of a x (.), (..., 3, 3), for a (..., 3)."""
    x, y, z = np.moveaxis(np.asarray(a, float), -1, 0)
    o = np.zeros_like(x)
    return np.stack([np.stack([o, -z, y], -1), np.stack([z, o, -x], -1), np.stack([-y, x, o], -1)], -2)


def write_sid(data: ModalNeutralData, path: str | Path) -> Path:
    """Write the data as SID text: order 1, m1 as (row, mode, column), Ge by axis; return the path."""
    path, m = Path(path), data.n_modes
    lines = [
        f"{len(data.marker_names)} {m} : {data.name}, m1(row, mode, column), Ge column = nq * (axis - 1) + mode",
        "part",
        "    new modal",
        "        refmod",
        f"            mass           = {data.mass:.16e}",
        f"            nelastq        = {m}",
        *(
            f"            ielastq ({j + 1:4d}) = Eigen Mode {j + 1:4d} : {f:14.6f} Hz"
            for j, f in enumerate(data.frequencies)
        ),
        "        end refmod",
        "        frame",
    ]
    for number, name in enumerate(data.marker_names):
        lines += [f"            new node = {name}", "                rframe = body ref"]
        for block, (m0, m1) in _node_blocks(data, number).items():
            lines += taylor_text(block, m0, m1, m, 16 * " ")
        lines.append("            end node")
    lines.append("        end frame")
    for block, (m0, m1) in _body_blocks(data).items():
        lines += taylor_text(block, m0, m1, m, 8 * " ")
    text = "\n".join([*lines, "    end modal", "end part", ""])
    return write_text(path, text, encoding="ascii", errors="replace")


def _node_blocks(data: ModalNeutralData, number: int) -> dict:
    translation, rotation = data.marker_translations[number], data.marker_rotations[number]
    stiff: list[np.ndarray | None] = [None, None]
    if data.geometric is not None and number < data.n_interfaces:  # on the side of the forces: minus
        stiff = [-data.geometric.interface[number, s].transpose(2, 0, 1) for s in (slice(0, 3), slice(3, 6))]
    return {
        "origin": (data.marker_positions[number][:, None], translation.T[:, :, None]),
        "phi": (translation, stiff[0]),
        "psi": (rotation, stiff[1]),
        "AP": (np.eye(3), skew(rotation.T)),
    }


def _body_blocks(data: ModalNeutralData) -> dict:
    i, m = data.invariants, data.n_modes
    first = np.array(
        [-i.vw1[:, 1, 2] + i.vw1[:, 2, 1], -i.vw1[:, 2, 0] + i.vw1[:, 0, 2], -i.vw1[:, 0, 1] + i.vw1[:, 1, 0]]
    )
    Cr1 = i.wn1.transpose(0, 2, 1)  # (k, l, axis)
    both = i.ww2 + i.ww2.transpose(1, 0, 2, 3)
    centrifugal = lambda t: np.stack([-(0.5 if a == b else 1.0) * t[..., a, b] for a, b in PAIRS], -1)  # noqa: E731
    Ct1, Oe1, ksigma = None, centrifugal(0.5 * (both + both.swapaxes(2, 3))).transpose(1, 0, 2), None
    by_axis = Cr1.transpose(1, 2, 0)  # rotary inertia of nodes has a symmetric part, which does no gyroscopic work
    Ge = (by_axis - by_axis.transpose(2, 1, 0)).reshape(m, 3 * m)  # column m * axis + mode
    if data.geometric is not None:
        linear, angular, spin = wallrapp_stiffness(data.geometric.inertia)
        Ct1, Cr1, Oe1 = (
            linear.transpose(2, 1, 0),
            Cr1 + angular.transpose(2, 1, 0),
            Oe1 + spin.transpose(2, 1, 0),
        )
        ksigma = data.geometric.preload[:, :, None]
    damping = 2.0 * data.damping_ratios * np.sqrt(np.diag(data.stiffness) * np.diag(i.nn))
    gyroscopic = i.ww1 - skew(i.wn0.T)
    return {
        "mdCM": (data.mass * data.center_of_mass[:, None], -0.5 * first.T[:, :, None]),
        "J": (
            np.array([[i.ww0[a, b]] for a, b in TENSOR]),
            np.stack([i.ww1[:, a, b] for a, b in TENSOR], 1)[:, :, None],
        ),
        "Ct": (i.vn.T, Ct1),
        "Cr": (i.wn0.T, Cr1),
        "Me": (i.nn, None),
        "Gr": (gyroscopic.transpose(1, 0, 2).reshape(3, 3 * m), None),
        "Ge": (Ge, None),
        "Oe": (centrifugal(i.ww1), Oe1),
        "ksigma": (np.zeros((m, 1)), None if ksigma is None else ksigma.transpose(1, 0, 2)),
        "Ke": (data.stiffness, None),
        "De": (np.diag(damping), None),
    }


def wallrapp_stiffness(inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return K0t (3, m, m), K0r (3, m, m), K0w (6, m, m) of the twelve acceleration fields, B = alpha~ + w~ w~."""
    G = inertia[3:].reshape(3, 3, *inertia.shape[1:])
    angular = np.stack([G[(a + 2) % 3, (a + 1) % 3] - G[(a + 1) % 3, (a + 2) % 3] for a in range(3)])
    trace = G[0, 0] + G[1, 1] + G[2, 2]
    spin = np.stack([G[a, a] - trace if a == b else G[a, b] + G[b, a] for a, b in PAIRS])
    return inertia[:3], angular, spin


def acceleration_fields(linear: np.ndarray, angular: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """The inverse of `wallrapp_stiffness`: twelve matrices."""
    G = np.zeros((3, 3, *linear.shape[1:]))
    trace = -0.5 * (spin[0] + spin[1] + spin[2])
    for (a, b), K in zip(PAIRS, spin, strict=True):
        if a == b:
            G[a, a] = K + trace
        else:
            G[a, b] = G[b, a] = 0.5 * K
    for a in range(3):
        G[(a + 2) % 3, (a + 1) % 3] += 0.5 * angular[a]
        G[(a + 1) % 3, (a + 2) % 3] -= 0.5 * angular[a]
    return np.concatenate([linear, G.reshape(9, *linear.shape[1:])])


def read_sid(path: str | Path) -> ModalNeutralData:
    """Read a SID file of any program; the nodes become interfaces of the body.

    Index order and layout of Ge are found by the identities that must hold. Terms of second order in J are not part of
    the format: without geometric stiffness they follow from Oe1, with it they stay together there. So does the
    symmetric part of Cr1, of nodes with rotary inertia: it is read as geometric stiffness of angular acceleration.

    Raises
    ------
    DataFileError
        The file is missing, cut off, lacks blocks, has blocks of shapes that do not fit or numbers that no body has,
        or its Ge agrees with Cr1 in no known layout.
    """
    path = Path(path)
    part = f"SID file '{path}'"
    if (found := no_file_because(path, missing="the file does not exist")) is not None:
        remedy = found.remedy or "Check the path"
        raise DataFileError(part, found=found.what, expected="an ASCII SID file", remedy=remedy)
    sid = read_sid_text(path.read_text(encoding="latin-1"), part)
    missing = [name for name in ("mdCM", "J", "Ct", "Cr", "Me", "Ke") if name not in sid.blocks]
    if missing:
        raise DataFileError(
            part,
            found=f"no block {', '.join(missing)}",
            expected="mdCM, J, Ct, Cr, Me, Ke",
            remedy="Export the file again with all blocks",
        )
    _check_blocks(sid, part)
    stiffness, Me = sid.blocks["Ke"].m0, sid.blocks["Me"].m0
    m = len(stiffness)
    blocks = {
        name: Taylor(t.m0, t.m1 if len(t.m1) or name not in _FIRST_ORDER else np.zeros((m, *t.m0.shape)))
        for name, t in sid.blocks.items()
    }
    check_gyroscopic(blocks, part)
    with np.errstate(over="ignore"):  # extreme numbers: `checked` tells
        w2 = np.diag(stiffness) / np.diag(Me)
    damping = np.diag(sid.blocks["De"].m0) if "De" in sid.blocks else np.zeros(m)
    critical = 2.0 * np.sqrt(w2) * np.diag(Me)
    geometric = _geometric(sid, blocks, m)
    data = ModalNeutralData(
        name=path.stem,
        nodes=np.zeros((0, 3)),
        cells=(),
        shapes=np.zeros((0, 3, m)),
        marker_names=tuple(sid.nodes),
        n_interfaces=len(sid.nodes),
        marker_positions=_stack(sid, "origin", (3, 1)).reshape(-1, 3),
        marker_translations=_stack(sid, "phi", (3, m)),
        marker_rotations=_stack(sid, "psi", (3, m)),
        stiffness=stiffness,
        damping_ratios=np.divide(damping, critical, out=np.zeros(m), where=critical > 0.0),
        frequencies=np.sqrt(w2) / (2.0 * np.pi),
        invariants=_invariants(sid.mass, blocks, geometric is not None),
        geometric=geometric,
        load_shapes=np.zeros((0, 6 + m)),
    )
    return checked(data, part)


_FIRST_ORDER = ("mdCM", "J", "Ct", "Cr", "Oe", "ksigma")
"""Blocks whose terms of first order are used."""


def _check_blocks(sid: SidText, part: str) -> None:
    """Raise DataFileError unless the blocks have the shapes of one body, its mass is positive, its modes vibrate."""
    m = len(sid.blocks["Me"].m0)
    shapes = {"mdCM": [(3, 1)], "J": [(6, 1), (3, 3)], "Ct": [(m, 3)], "Cr": [(m, 3)], "Me": [(m, m)], "Ke": [(m, m)]}
    shapes |= {"De": [(m, m)], "Gr": [(3, 3 * m)], "Ge": [(m, 3 * m)], "Oe": [(m, 6)], "ksigma": [(m, 1)]}
    shapes |= {"origin": [(3, 1)], "phi": [(3, m)], "psi": [(3, m)]}
    for place, blocks in (("", sid.blocks), *((f" of node '{name}'", node) for name, node in sid.nodes.items())):
        for name in [n for n in blocks if n in shapes]:
            t = blocks[name]
            if t.m0.size == 0 and m and name not in ("mdCM", "J", "Ct", "Cr", "Ke"):
                del blocks[name]  # written as empty where it is zero
            elif t.m0.shape not in shapes[name] or len(t.m1) not in (0, m):
                rows, columns = t.m0.shape
                raise DataFileError(
                    part,
                    found=f"the block '{name}'{place} is {rows} x {columns} with {len(t.m1)} modes",
                    expected=f"{' or '.join(f'{r} x {c}' for r, c in shapes[name])} with none or {m}, the rows of Me",
                    remedy="Export the file again, with the same modes in all blocks",
                )
    check_modes(part, np.diag(sid.blocks["Me"].m0), np.diag(sid.blocks["Ke"].m0))


def _stack(sid: SidText, block: str, shape: tuple[int, int]) -> np.ndarray:
    rows = [node[block].m0 if block in node else np.zeros(shape) for node in sid.nodes.values()]
    return np.array(rows).reshape(-1, *shape)


def check_gyroscopic(blocks: dict[str, Taylor], part: str) -> None:
    """Check Ge = 2 Cr1 (its antisymmetric part) in the layout by axis or by mode; refuse the file if neither fits."""
    Cr1 = blocks["Cr"].m1.transpose(1, 2, 0)  # (l, axis, k)
    Ge = blocks["Ge"].m0 if "Ge" in blocks else np.zeros(0)
    m = len(Cr1)
    if not Ge.any():
        return
    expected = Cr1 - Cr1.transpose(2, 1, 0)
    layouts = {"by axis": Ge.reshape(m, 3, m), "by mode": Ge.reshape(m, m, 3).transpose(0, 2, 1)}
    errors = {name: np.abs(found - expected).max() / np.abs(Ge).max() for name, found in layouts.items()}
    if min(errors.values()) > _IDENTITY:
        raise DataFileError(
            part,
            found=f"Ge differs from 2 Cr1 by {min(errors.values()):.1e} in the best layout",
            expected=f"an identity, to {_IDENTITY:g}",
            remedy="The blocks belong to different modes or another definition: "
            "export with the same program settings, or give K and M",
        )


def _invariants(mass: float, blocks: dict[str, Taylor], geometric: bool) -> InertiaInvariants:
    m = len(blocks["Me"].m0)
    J0, J1 = _tensor(blocks["J"].m0), np.array([_tensor(J) for J in blocks["J"].m1]).reshape(m, 3, 3)
    wn1 = blocks["Cr"].m1.transpose(0, 2, 1)  # (k, axis, l)
    ww2 = np.zeros((m, m, 3, 3))
    if geometric:
        wn1 = 0.5 * (wn1 - wn1.transpose(2, 1, 0))
    elif "Oe" in blocks:
        for n, (a, b) in enumerate(PAIRS):
            ww2[:, :, a, b] = ww2[:, :, b, a] = -(1.0 if a == b else 0.5) * blocks["Oe"].m1[:, :, n]
    return InertiaInvariants(
        vv=mass * np.eye(3),
        vw0=-skew(blocks["mdCM"].m0[:, 0]),
        vw1=-skew(blocks["mdCM"].m1[:, :, 0]),
        vn=blocks["Ct"].m0.T,
        ww0=J0,
        ww1=J1,
        ww2=ww2,
        wn0=blocks["Cr"].m0.T,
        wn1=wn1,
        nn=blocks["Me"].m0,
    )


def _tensor(J: np.ndarray) -> np.ndarray:
    """A 3 x 3 tensor from six entries xx, yy, zz, xy, xz, yz, or as it is."""
    if J.shape == (3, 3):
        return J
    out = np.zeros((3, 3))
    for value, (a, b) in zip(J[:, 0], TENSOR, strict=True):
        out[a, b] = out[b, a] = value
    return out


def _geometric(sid: SidText, blocks: dict[str, Taylor], m: int) -> GeometricStiffness | None:
    """Return the geometric stiffness, or None if the file holds none."""
    nodal = [
        np.concatenate(
            [
                -node[b].m1.transpose(1, 2, 0) if len(node.get(b, _NOTHING).m1) else np.zeros((3, m, m))
                for b in ("phi", "psi")
            ]
        )
        for node in sid.nodes.values()
    ]
    interface = np.array(nodal).reshape(-1, 6, m, m)
    linear = blocks["Ct"].m1.transpose(2, 1, 0)
    if not (linear.any() or interface.any()):
        return None
    angular = blocks["Cr"].m1.transpose(2, 1, 0)
    angular = 0.5 * (angular + angular.transpose(0, 2, 1))
    spin = blocks["Oe"].m1.transpose(2, 1, 0) if "Oe" in blocks else np.zeros((6, m, m))
    preload = blocks["ksigma"].m1[:, :, 0].T if "ksigma" in blocks else np.zeros((m, m))
    return GeometricStiffness(
        inertia=acceleration_fields(linear, angular, spin),
        interface=interface,
        loads=np.zeros((0, m, m)),
        preload=preload,
    )


_NOTHING = Taylor(np.zeros((0, 0)), np.zeros((0, 0, 0)))
