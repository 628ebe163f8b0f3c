"""Reduced bodies in other axes or units: moved, mirrored, rescaled, without a new reduction.

With new axes x' = Q (x - p), det Q = s (s = -1 for a mirror), the velocities of the body change by a constant matrix,
u = H u' with H = [[Q^T, p~ s Q^T, 0], [0, s Q^T, 0], [0, 0, I]], and every coefficient of the body mass matrix becomes
H^T (.) H.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np
from scipy.linalg import block_diag

from flexmb.errors import ReductionError
from flexmb.model.effective_mass import effective_mass_table
from flexmb.model.mirrored_cells import mirrored_cells
from flexmb.model.modal_arrays import GeometricStiffness, InertiaInvariants, LeftOutStiffness, ModalArrays

__all__ = ["mirrored", "moved", "rescaled", "rotated", "translated"]

Data = TypeVar("Data", bound=ModalArrays)

PLANES = {"yz": (1.0, 0.0, 0.0), "xz": (0.0, 1.0, 0.0), "xy": (0.0, 0.0, 1.0)}
"""Normals of the coordinate planes."""

_TENSOR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])  # of stress xx, yy, zz, xy, yz, zx


def moved(data: Data, rotation: Any = None, origin: Any = (0.0, 0.0, 0.0)) -> Data:
    """Return the data in other body axes.

    Parameters
    ----------
    rotation : (3, 3), rotation vector (3,), scipy Rotation, or None
        Orientation of the new axes in the old ones.
    origin : (3,), m
        Origin of the new axes in the old ones.
    """
    return _in_axes(data, _matrix(data, rotation).T, _vector(data, "origin", origin))


def rotated(data: Data, rotation: Any) -> Data:
    """Return the body turned about its origin, x' = R x."""
    return _in_axes(data, _matrix(data, rotation), np.zeros(3))


def translated(data: Data, displacement: Any) -> Data:
    """Return the body moved, x' = x + d."""
    return _in_axes(data, np.eye(3), -_vector(data, "displacement", displacement))


def _vector(data: ModalArrays, name: str, value: Any) -> np.ndarray:
    vector = np.asarray(value, float)
    if vector.shape != (3,) or not np.all(np.isfinite(vector)):
        raise ReductionError(
            f"Modal neutral data '{data.name}'",
            found=f"{name} {value!r}",
            expected="three numbers, m",
            remedy="Write (x, y, z) in body axes",
        )
    return vector


def _matrix(data: ModalArrays, rotation: Any) -> np.ndarray:
    """Return a rotation given as a matrix, a rotation vector, a scipy Rotation or None as (3, 3)."""
    from scipy.spatial.transform import Rotation

    if rotation is None:
        return np.eye(3)
    if isinstance(rotation, Rotation):
        return rotation.as_matrix()
    given = np.asarray(rotation, float)
    axes = Rotation.from_rotvec(given).as_matrix() if given.shape == (3,) else given
    if axes.shape != (3, 3) or np.abs(axes.T @ axes - np.eye(3)).max() > 1e-9 or np.linalg.det(axes) < 0.0:
        raise ReductionError(
            f"Modal neutral data '{data.name}'",
            found=f"a rotation {np.array2string(axes, precision=4)}",
            expected="a proper orthogonal matrix (3, 3), a rotation vector (3,) or a scipy Rotation",
            remedy="Use data.mirrored for reflections",
        )
    return axes


def mirrored(data: Data, plane: Any, name: str | None = None) -> Data:
    """Return the mirror image at a plane through the origin: the part of the other side.

    Parameters
    ----------
    plane : "xy", "yz", "xz" or (3,)
        A coordinate plane of the body axes, or the normal of any plane.
    name : str, optional
        Name of the image.
    """
    n = np.asarray(PLANES.get(plane, (0.0, 0.0, 0.0)) if isinstance(plane, str) else plane, float)
    if n.shape != (3,) or not np.linalg.norm(n) > 0.0:
        raise ReductionError(
            f"Modal neutral data '{data.name}'",
            found=f"the plane {plane!r}",
            expected="'xy', 'yz', 'xz', or a normal: three numbers, not all zero",
            remedy="Give the plane of symmetry in body axes, e.g. 'xz' or (0, 1, 0)",
        )
    n = n / np.linalg.norm(n)
    image = _in_axes(data, np.eye(3) - 2.0 * np.outer(n, n), np.zeros(3))
    return replace(image, name=name or data.name)


def rescaled(data: Data, length: float = 1.0, mass: float = 1.0, time: float = 1.0) -> Data:
    """Return the data in other units: how many new units one old unit of length, mass and time is.

    From tonnes, millimetres, seconds to SI: ``rescaled(data, length=1e-3, mass=1e3)``. Load shapes keep the unit in
    which their intensity is counted.
    """
    if not min(length, mass, time) > 0.0:
        raise ReductionError(
            f"Modal neutral data '{data.name}'",
            found=f"unit factors {length!r}, {mass!r}, {time!r}",
            expected="positive numbers",
            remedy="A millimetre is 1e-3 of a metre: length=1e-3",
        )
    L, m, t = length, mass, time
    power = {"vv": 0, "vw0": 1, "vw1": 0, "vn": 0, "ww0": 2, "ww1": 1, "ww2": 0, "wn0": 1, "wn1": 0, "nn": 0}
    invariants = InertiaInvariants(**{key: getattr(data.invariants, key) * m * L**p for key, p in power.items()})
    geometric = data.geometric
    if geometric is not None:
        factors = np.where(np.arange(12) < 3, m / L, m)[:, None, None]
        loads = np.where(np.arange(6) < 3, 1.0 / L, 1.0 / L**2)[:, None, None]
        geometric = GeometricStiffness(
            inertia=geometric.inertia * factors,
            interface=geometric.interface * loads,
            loads=geometric.loads * m / t**2,
            preload=geometric.preload * m / t**2,
        )
    force = m * L / t**2 * np.where((np.arange(6 + data.n_modes) >= 3) & (np.arange(6 + data.n_modes) < 6), L, 1.0)
    changed = _with_quality(
        replace(
            data,
            nodes=data.nodes * L,
            marker_positions=data.marker_positions * L,
            rotation_shapes=None if data.rotation_shapes is None else data.rotation_shapes / L,
            marker_rotations=data.marker_rotations / L,
            stiffness=data.stiffness * m / t**2,
            frequencies=data.frequencies / t,
            invariants=invariants,
            geometric=geometric,
            left_out=None if data.left_out is None else _left_out_in_units(data.left_out, L, m, t),
            load_shapes=data.load_shapes * force,
            load_turning=None if data.load_turning is None else data.load_turning * force[:, None] / L,
            preload_turning=None if data.preload_turning is None else data.preload_turning * force[:, None] / L,
            stress_modes=None if data.stress_modes is None else data.stress_modes * m / (L * t) ** 2,
        ),
        L,
    )
    lengths = np.where(np.arange(6) < 3, 1.0, L)
    return _with_effective_mass(changed, np.sqrt(m) * np.diag(lengths))


def _in_axes(data: Data, Q: np.ndarray, p: np.ndarray) -> Data:
    s = float(np.sign(np.linalg.det(Q)))
    turn = lambda shapes, sign=1.0: sign * np.einsum("ab,nbj->naj", Q, shapes)  # noqa: E731
    changed = _with_quality(
        replace(
            data,
            nodes=(data.nodes - p) @ Q.T,
            cells=data.cells if s > 0.0 else mirrored_cells(data.cells),
            shapes=turn(data.shapes),
            rotation_shapes=None if data.rotation_shapes is None else turn(data.rotation_shapes, s),
            marker_positions=(data.marker_positions - p) @ Q.T,
            marker_translations=turn(data.marker_translations),
            marker_rotations=turn(data.marker_rotations, s),
            invariants=_invariants(data.invariants, Q, p, s),
            geometric=None if data.geometric is None else _geometric(data.geometric, Q, p, s),
            left_out=None if data.left_out is None else _left_out_in_axes(data.left_out, Q, p, s),
            load_shapes=_forces(data.load_shapes[:, :, None], Q, p, s)[:, :, 0],
            load_turning=None if data.load_turning is None else _forces(data.load_turning, Q, p, s),
            preload_turning=None if data.preload_turning is None else _forces(data.preload_turning[None], Q, p, s)[0],
            stress_modes=None if data.stress_modes is None else _stress(data.stress_modes, Q),
        )
    )
    turn6 = np.zeros((6, 6))
    turn6[:3, :3], turn6[3:, 3:] = Q, s * Q
    return _with_turned_bound(_with_effective_mass(changed, turn6), Q, s)


def _with_turned_bound(data: Data, Q: np.ndarray, s: float) -> Data:
    """Bound the error of the response to loads along the new axes: at most the sum of those along the old ones.

    With phases it is the same error, by forces in the new axes. Without all three directions of an interface there is
    no such sum: the bound is left out.
    """
    if "transfer" not in data.quality:
        return data
    freedoms = [row["freedoms"] for row in data.quality["interfaces"]]
    quality = {name: value for name, value in data.quality.items() if name != "transfer"}
    if all(own in ([0, 1, 2], [0, 1, 2, 3, 4, 5]) for own in freedoms):
        turn = block_diag(*(s**f * Q for own in freedoms for f in range(len(own) // 3)))  # of forces, of moments
        quality["transfer"] = _turned_lines(data.quality["transfer"], Q, turn)
    return replace(data, quality=quality)


def _turned_lines(lines: dict, Q: np.ndarray, turn: np.ndarray) -> dict:
    """Return errors at lines, also above the band, in axes turned by Q; `turn` turns the interface freedoms (k, k)."""
    columns = np.array(lines["by_input"]).reshape(len(lines["frequencies"]), -1, 3)
    turned = {**lines, "by_input": (columns @ np.abs(Q).T).reshape(len(columns), -1).tolist()}
    if "matrix" in lines:
        turned["matrix"] = (turn @ np.array(lines["matrix"]) @ turn.T).tolist()
    if "loads" in lines:
        turned["loads"] = (turn @ np.array(lines["loads"])).tolist()
    if "spin" in lines:
        turned["spin"] = (turn @ np.array(lines["spin"]) @ _field_components(Q)).tolist()
    for inner in ("beyond", "rest"):
        if inner in lines:
            turned[inner] = _turned_lines(lines[inner], Q, turn)
    return turned


def _field_components(Q: np.ndarray) -> np.ndarray:
    """Return the components (6, 6) xx, yy, zz, xy, yz, zx of Q^T A Q by those of a symmetric A in the new axes."""
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
    columns = []
    for i, j in places:
        unit = np.zeros((3, 3))
        unit[i, j] = unit[j, i] = 1.0
        old = Q.T @ unit @ Q
        columns.append([old[k, l] for k, l in places])
    return np.array(columns).T


def _forces(forces: np.ndarray, Q: np.ndarray, p: np.ndarray, s: float) -> np.ndarray:
    """Return generalised forces (n, 6 + m, k) in the new axes: f' = Q f, moment s Q (m - p x f)."""
    changed = forces.copy()
    changed[:, :3] = Q @ forces[:, :3]
    changed[:, 3:6] = s * Q @ (forces[:, 3:6] - np.cross(p[None, :, None], forces[:, :3], axis=1))
    return changed


def _invariants(i: InertiaInvariants, Q: np.ndarray, p: np.ndarray, s: float) -> InertiaInvariants:
    m = len(i.nn)
    zero = np.zeros((3, m))
    H = np.eye(6 + m)
    H[:3, :3], H[3:6, 3:6] = Q.T, s * Q.T
    H[:3, 3:6] = s * np.column_stack([np.cross(p, axis) for axis in np.eye(3)]) @ Q.T
    constant = np.block([[i.vv, i.vw0, i.vn], [i.vw0.T, i.ww0, i.wn0], [i.vn.T, i.wn0.T, i.nn]])
    constant = H.T @ constant @ H
    first = [
        np.block([[np.zeros((3, 3)), vw, zero], [vw.T, ww, wn], [zero.T, wn.T, np.zeros((m, m))]])
        for vw, ww, wn in zip(i.vw1, i.ww1, i.wn1, strict=True)
    ]
    linear = H.T @ np.array(first).reshape(m, 6 + m, 6 + m) @ H
    v, w, n = slice(0, 3), slice(3, 6), slice(6, None)
    return InertiaInvariants(
        vv=constant[v, v],
        vw0=constant[v, w],
        vn=constant[v, n],
        ww0=constant[w, w],
        wn0=constant[w, n],
        nn=constant[n, n],
        vw1=linear[:, v, w],
        ww1=linear[:, w, w],
        wn1=linear[:, w, n],
        ww2=Q @ i.ww2 @ Q.T,
    )


def _geometric(g: GeometricStiffness, Q: np.ndarray, p: np.ndarray, s: float) -> GeometricStiffness:
    """Loads of the old axes from the new ones: A = Q^T A' - B p, B = Q^T B' Q, f = Q^T f', moment s Q^T m'."""
    uniform, gradient = g.inertia[:3], g.inertia[3:].reshape(3, 3, *g.inertia.shape[1:])
    gradient = gradient - np.einsum("kab,l->klab", uniform, p)
    inertia = np.concatenate(
        [
            np.einsum("ik,kab->iab", Q, uniform),
            np.einsum("ik,jl,klab->ijab", Q, Q, gradient).reshape(9, *g.inertia.shape[1:]),
        ]
    )
    interface = np.concatenate(
        [
            np.einsum("ik,nkab->niab", Q, g.interface[:, :3]),
            s * np.einsum("ik,nkab->niab", Q, g.interface[:, 3:]),
        ],
        axis=1,
    )
    return GeometricStiffness(inertia=inertia, interface=interface, loads=g.loads, preload=g.preload)


def _stress(modes: np.ndarray, Q: np.ndarray) -> np.ndarray:
    tensor = np.einsum("ia,jb,nabk->nijk", Q, Q, modes[:, _TENSOR])
    rows = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]
    return np.stack([tensor[:, a, b] for a, b in rows], axis=1)


def _with_quality(data: Data, length: float = 1.0) -> Data:
    """Bring the numbers of the report that depend on axes and units up to date."""
    if not data.quality:
        return data
    mass = {
        "mass": data.mass,
        "center_of_mass": data.center_of_mass.tolist(),
        "inertia": data.inertia.tolist(),
    }
    factor = data.frequencies[0] / data.quality["modes"][0]["frequency"] if data.n_modes else 1.0
    scale = lambda rows, keys: [{**row, **{key: row[key] * factor for key in keys}} for row in rows]  # noqa: E731
    interfaces = [
        {**row, "position": position.tolist()}
        for row, position in zip(data.quality["interfaces"], data.marker_positions)
    ]
    return replace(
        data,
        quality={
            **data.quality,
            "mass": mass,
            "interfaces": interfaces,
            "fixed_interface_frequencies": [f * factor for f in data.quality["fixed_interface_frequencies"]],
            "modes": scale(data.quality["modes"], ["frequency"]),
            "frequencies": scale(data.quality["frequencies"], ["full", "reduced"]),
            **({"tracks": _along(data.quality["tracks"], length)} if "tracks" in data.quality else {}),
            **({"transfer": _with_units(data, factor, length)} if "transfer" in data.quality else {}),
        },
    )


def _along(tracks: dict, length: float) -> dict:
    """Return tracks with the places of their nodes in another unit of length."""
    return {name: {**track, "places": [s * length for s in track["places"]]} for name, track in tracks.items()}


def _with_units(data: Data, factor: float, length: float) -> dict:
    """Return the bound of the response's error in other units: frequencies times a factor, compliances (s2/kg)."""
    transfer = data.quality["transfer"]
    softness = data.quality["mass"]["mass"] / (factor**2 * data.mass)
    return {
        **_lines_with_units(transfer, factor, softness, length),
        "error": [e * softness for e in transfer["error"]],
        "response": [e * softness for e in transfer["response"]],
        **{name: transfer[name] * factor for name in ("worst", "by_parts_at") if name in transfer},
        "length": transfer["length"] * length,
    }


def _lines_with_units(lines: dict, factor: float, softness: float, length: float) -> dict:
    """Return errors at lines, also above the band, in other units: by forces, by loads of the same intensity, by
    fields of spin (1/s2).
    """
    units = {"matrix": softness, "by_input": softness, "loads": length, "spin": length / factor**2}
    changed = {name: (np.array(lines[name]) * unit).tolist() for name, unit in units.items() if name in lines}
    changed["frequencies"] = [f * factor for f in lines["frequencies"]]
    if lines.get("ahead") is not None:
        changed["ahead"] = lines["ahead"] * factor
    for inner in ("beyond", "rest"):
        if inner in lines:
            changed[inner] = _lines_with_units(lines[inner], factor, softness, length)
    return {**lines, **changed}


def _left_out_in_units(known: LeftOutStiffness, length: float, mass: float, time: float) -> LeftOutStiffness:
    """Return changes of stiffness by unit loads in other units; load shapes keep the unit of their intensity."""
    force = mass * length / time**2
    factors = np.where(np.arange(12) < 3, time**2 / length, time**2)[:, None, None]
    loads = np.where(np.arange(6) < 3, 1.0 / force, 1.0 / (force * length))[:, None, None]
    unit = np.tile(np.where(np.arange(6) < 3, length, 1.0), len(known.turns))
    return replace(
        known,
        inertia=known.inertia * factors,
        interface=known.interface * loads,
        translations=known.translations * length,
        compliance=known.compliance * np.outer(unit, unit),
    )


def _left_out_in_axes(known: LeftOutStiffness, Q: np.ndarray, p: np.ndarray, s: float) -> LeftOutStiffness:
    """Return changes of stiffness by the loads of the new axes, on the turns about them."""
    moved = _geometric(known, Q, p, s)
    soft = len(known.preload) - 3
    H = np.eye(soft + 3)
    H[soft:, soft:] = s * Q
    parts = {f.name: H @ getattr(moved, f.name) @ H.T for f in fields(moved)}
    axes = np.kron(np.eye(2 * len(known.turns)), Q)
    axes[np.arange(len(axes)) % 6 >= 3] *= s  # turns
    return LeftOutStiffness(
        **parts,
        translations=Q @ known.translations,
        turns=s * Q @ known.turns,
        compliance=axes @ known.compliance @ axes.T,
    )


def _with_effective_mass(data: Data, G: np.ndarray) -> Data:
    """Change the participation factors (vectors about the centroid) by G (6, 6) and make their shares anew."""
    table = data.quality.get("effective_mass", {})
    if "participation" not in table:
        return data
    participation = np.array(table["participation"]).reshape(-1, 6) @ G.T
    changed = effective_mass_table(participation, G @ np.array(table["rigid_mass"]) @ G.T)
    return replace(data, quality={**data.quality, "effective_mass": changed})
