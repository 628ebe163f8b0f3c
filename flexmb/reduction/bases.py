"""Which displacements a flexible body has: descriptions of bases for `reduce`.

Every basis tells its `vectors` (displacements in the frame of the body) and how it grows where an accuracy is asked
for. Craig & Bampton's own comes from `flexmb.reduction.mode_choice`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Protocol

import numpy as np
from scipy.linalg import eigh

from flexmb.errors import ReductionError
from flexmb.model.described import Described, finite_array, is_number
from flexmb.reduction.basis import available_modes, normal_modes
from flexmb.reduction.framed_body import FramedBody
from flexmb.reduction.mode_choice import HIGHEST
from flexmb.reduction.snapshots import Motion
from flexmb.reduction.subspace import orthonormal_blocks
from flexmb.reduction.transfer_error import REFERENCE_DAMPING

__all__ = [
    "Balanced",
    "CharacteristicModes",
    "CraigBampton",
    "Krylov",
    "Pod",
    "Rubin",
    "SpannedBasis",
    "described",
]

MODES = 12
"""Modes where no number is given."""
ROUNDED = 1e-11
"""Elastic part of a snapshot, relative to the whole in mass norms, below which it is what rounding leaves."""


class SpannedBasis(Protocol):
    """A basis that tells its displacements."""

    def vectors(self, framed: FramedBody, modes: int) -> np.ndarray:
        """Return displacements (ndof, p) in the frame; `modes` is what `reduce` was asked for."""

    def grown(self, modes: int, worst: float) -> tuple[SpannedBasis, int] | None:
        """Return a larger basis, given the frequency of the largest error, Hz; None where there is none."""

    def most(self, framed: FramedBody, modes: int) -> int:
        """Return `modes`, or how many there are where these are fewer."""

    def check(self, modes: int | None) -> int:
        """Return the number of modes to begin with; ReductionError where the number means nothing."""


def described(basis: Any) -> str:
    """Return a basis in words: its class and its fields, arrays by their size."""
    shown = [(f.name, getattr(basis, f.name)) for f in fields(basis)]
    words = [f"{name}={value.shape[1]} columns" if isinstance(value, np.ndarray) else f"{name}={value!r}"
             for name, value in shown]  # fmt: skip
    return f"{type(basis).__name__}({', '.join(words)})"


@dataclass(frozen=True)
class CraigBampton(metaclass=Described):
    """Static deformation of each interface freedom, and normal modes with all interfaces held: the default."""


@dataclass(frozen=True)
class Rubin(metaclass=Described):
    """Normal modes of the body in its frame, interfaces free, and the static response to each interface load.

    In the Buckens frame the responses are balanced by rigid inertia (attachment modes of a free body); less what the
    modes hold of them they are the residual flexibility. The coordinates of Rubin and of Craig & Chang are two bases
    of this one space: the reduced body is the same. Interface loads are exact in statics.
    """

    def check(self, modes: int | None) -> int:
        return MODES if modes is None else modes

    def vectors(self, framed: FramedBody, modes: int) -> np.ndarray:
        """Return the modes and the responses, (ndof, modes + inputs)."""
        free = _enough(framed, framed.modes(modes).vectors, modes)
        M, loads = framed.body.fe.M, framed.excitation
        # what modes answer is taken from the loads: a soft mode would hide in its response all that is stiff
        return orthonormal_blocks(M, [free, framed.solve(loads - M @ (free @ (free.T @ loads)))])

    def most(self, framed: FramedBody, modes: int) -> int:
        return len(framed.modes(modes).w2)

    def grown(self, modes: int, worst: float) -> tuple[Rubin, int]:
        return self, modes + max(1, modes // 4)


@dataclass(frozen=True)
class Krylov(metaclass=Described):
    """Responses to the interface loads at chosen frequencies, and their derivatives: moments match there.

    Parameters
    ----------
    frequencies : float or sequence of float, Hz
        Where the response is exact; 0 makes statics exact.
    order : int
        Vectors per load and frequency: the response, and ``order - 1`` derivatives to the squared frequency.
        Between loads and displacements at the same places ``2 order`` moments match.
    two_sided : bool
        Whether the vectors of the stations join: then ``2 order`` moments match to them, too, not ``order``.
    """

    frequencies: Any = (0.0,)
    order: int = 1
    two_sided: bool = False

    def __post_init__(self):
        values = np.atleast_1d(finite_array(self.frequencies))
        sound = values.ndim == 1 and len(values) and 0.0 <= values.min() <= values.max() <= HIGHEST
        if not sound or len(np.unique(values)) < len(values):
            raise _wrong("Krylov", f"frequencies = {self.frequencies!r:.80}",
                         f"different frequencies from 0 Hz upwards, up to {HIGHEST:.0e} Hz",
                         "Write frequencies=(0.0, 120.0)")  # fmt: skip
        if isinstance(self.order, bool) or not isinstance(self.order, int | np.integer) or self.order < 1:
            raise _wrong("Krylov", f"order = {self.order!r}", "a whole number from 1 upwards", "Write order=2")
        object.__setattr__(self, "frequencies", tuple(float(f) for f in values))

    def check(self, modes: int | None) -> int:
        return _no_number(self, modes, "frequencies and order say how many shapes there are")

    def vectors(self, framed: FramedBody, modes: int) -> np.ndarray:
        """Return the block Arnoldi bases of all frequencies, (ndof, p): dependent directions are left out."""
        M = framed.body.fe.M
        loads = np.hstack([framed.excitation, framed.outputs]) if self.two_sided else framed.excitation
        _check_loaded("Krylov", framed, loads)
        chains: list[np.ndarray] = []
        for w2 in (2.0 * np.pi * np.array(self.frequencies)) ** 2:
            chain = orthonormal_blocks(M, [framed.response(loads, w2)])
            block = chain
            for _ in range(self.order - 1):
                longer = orthonormal_blocks(M, [chain, framed.response(M @ block, w2)])
                chain, block = longer, longer[:, chain.shape[1] :]
                if block.shape[1] == 0:
                    break
            chains.append(chain)
        return orthonormal_blocks(M, chains)

    def grown(self, modes: int, worst: float) -> tuple[Krylov, int]:
        """A new frequency where the error is largest, or a higher order where there is one already."""
        near = min(abs(worst - f) for f in self.frequencies)
        if near > 1e-3 * worst:
            return replace(self, frequencies=(*self.frequencies, worst)), modes
        return replace(self, order=self.order + 1), modes

    def most(self, framed: FramedBody, modes: int) -> int:
        return modes


@dataclass(frozen=True, eq=False)
class Pod(metaclass=Described):
    """Principal displacements of snapshots: what a body did in a run (proper orthogonal decomposition).

    Parameters
    ----------
    snapshots : (ndof, k), or `Motion`
        Displacements of the freedoms of the FE model, m and rad; rigid motion in them is taken out.
        `snapshots_of` takes them from a run, and so does `Motion`, which need not know the model.
    energy : float
        Share of the sum of strain energies of all snapshots that the shapes hold.
    statics : bool
        Whether the static responses to interface loads join: without them only loads like the run's are met.
    """

    snapshots: Any
    energy: float = 0.9999
    statics: bool = False

    def __post_init__(self):
        given = finite_array(np.zeros((1, 1)) if isinstance(self.snapshots, Motion) else self.snapshots)
        if given.ndim != 2 or given.shape[1] == 0:
            raise _wrong("Pod", f"snapshots of shape {given.shape}", "finite numbers (ndof, k)",
                         "Give reduction.snapshots_of(solution, body), or one column per displacement")  # fmt: skip
        if not is_number(self.energy) or not 0.0 < self.energy <= 1.0:
            raise _wrong("Pod", f"energy = {self.energy!r}", "a share above 0, up to 1", "Write energy=0.9999")
        if not isinstance(self.snapshots, Motion):
            object.__setattr__(self, "snapshots", given)

    def check(self, modes: int | None) -> int:
        if modes == 0:
            raise _wrong("Pod", "modes = 0", "a number from 1 upwards",
                         "Leave modes out: energy says how many, or take basis='Rubin' for statics alone")  # fmt: skip
        return 0 if modes is None else modes

    def vectors(self, framed: FramedBody, modes: int) -> np.ndarray:
        """Return the principal displacements, by energy, or `modes` of them, with the static responses if asked for."""
        value, principal = framed.once(self, lambda: self._principal(framed))
        if modes > len(value):
            raise _wrong("Pod", f"{modes} modes asked for", f"at most {len(value)}, the displacements that differ in "
                         f"{self._count} snapshots", "Ask for fewer modes, or give more snapshots")  # fmt: skip
        held = np.cumsum(value) / max(value.sum(), 1e-300)
        count = modes or int(np.searchsorted(held, self.energy * (1.0 - 1e-14))) + 1
        static = [framed.solve(framed.excitation)] if self.statics else []
        return orthonormal_blocks(framed.body.fe.M, [principal[:, :count], *static])

    def most(self, framed: FramedBody, modes: int) -> int:
        return min(modes, len(framed.once(self, lambda: self._principal(framed))[0]))

    @property
    def _count(self) -> int:
        return len(self.snapshots.coordinates) if isinstance(self.snapshots, Motion) else self.snapshots.shape[1]

    def _principal(self, framed: FramedBody) -> tuple[np.ndarray, np.ndarray]:
        """Return the principal strain energies (p,), descending, and their displacements (ndof, p)."""
        fe = framed.body.fe
        given = self.snapshots.on(fe) if isinstance(self.snapshots, Motion) else self.snapshots
        if len(given) != fe.ndof:
            raise _wrong("Pod", f"snapshots of {len(given)} freedoms", f"{fe.ndof}, the freedoms of '{fe.name}'",
                         "Take the snapshots from the same FE model")  # fmt: skip
        moved = framed.elastic(_coupled(framed, given))
        whole, rest = (np.einsum("ij,ij->j", one, fe.M @ one) for one in (given, moved))
        moved = moved[:, rest > ROUNDED**2 * whole]
        if not moved.shape[1]:
            raise _wrong("Pod", f"{self._count} snapshots of a body that is not deformed", "elastic displacements",
                         "Take the snapshots from a run in which loads deform the body")  # fmt: skip
        work = moved.T @ (fe.K @ moved)
        value, turn = eigh(0.5 * (work + work.T))
        value, turn = value[::-1], turn[:, ::-1]
        kept = value > 1e-14 * value[0]
        return value[kept], moved @ (turn[:, kept] / np.sqrt(value[kept]))

    def grown(self, modes: int, worst: float) -> tuple[Pod, int] | None:
        return None if modes + 1 > self._count else (self, modes + 1)


@dataclass(frozen=True)
class CharacteristicModes(metaclass=Described):
    """Craig & Bampton's basis with the interfaces reduced, too: for interfaces of many freedoms.

    The lowest modes of the constraint modes by themselves (characteristic constraint modes) replace them. Interfaces
    move as these shapes allow; loads on them are met approximately.

    Parameters
    ----------
    interface_modes : int
        How many, apart from rigid motions.
    """

    interface_modes: int = 20

    def __post_init__(self):
        _check_count("CharacteristicModes", "interface_modes", self.interface_modes)

    def check(self, modes: int | None) -> int:
        return MODES if modes is None else modes

    def vectors(self, framed: FramedBody, modes: int) -> np.ndarray:
        """Return interface shapes and fixed-interface modes, (ndof, interface_modes + modes)."""
        body, M = framed.body, framed.body.fe.M
        body.check_hinges()
        psi = body.constraint_modes
        free = psi @ _admissible(framed)
        K, mass = free.T @ (body.fe.K @ free), free.T @ (M @ free)
        y = eigh(0.5 * (mass + mass.T), 0.5 * (K + K.T))[1]
        shapes = free @ y[:, ::-1][:, : self.interface_modes]
        return orthonormal_blocks(M, [shapes, framed.elastic(normal_modes(body, modes).vectors)])

    def most(self, framed: FramedBody, modes: int) -> int:
        return len(available_modes(framed.body, modes).w2)

    def grown(self, modes: int, worst: float) -> tuple[CharacteristicModes, int]:
        step = max(2, self.interface_modes // 4)
        return replace(self, interface_modes=self.interface_modes + step), modes + max(1, modes // 4)


@dataclass(frozen=True)
class Balanced(metaclass=Described):
    """The directions of modal space that unit impulses at the interfaces fill most: balanced truncation.

    For loads and displacements at the same places and modal damping the position Gramian of the loads is the velocity
    Gramian of the displacements: balancing is an orthogonal change of modal coordinates and keeps the structure of the
    equations. A reference: it holds no static response.

    Parameters
    ----------
    candidates : int
        Modes among which it is balanced.
    damping : float
        Fraction of critical damping of all of them.
    """

    candidates: int = 100
    damping: float = REFERENCE_DAMPING

    def __post_init__(self):
        _check_count("Balanced", "candidates", self.candidates)
        if not is_number(self.damping) or not 0.0 < self.damping < 1.0:
            raise _wrong("Balanced", f"damping = {self.damping!r}", "a fraction of critical damping between 0 and 1",
                         "Write damping=0.01")  # fmt: skip

    def check(self, modes: int | None) -> int:
        return MODES if modes is None else modes

    def vectors(self, framed: FramedBody, modes: int) -> np.ndarray:
        """Return the leading `modes` eigenvectors of the Gramian, (ndof, modes)."""
        _check_loaded("Balanced", framed, framed.excitation)
        known = framed.modes(max(self.candidates, modes))
        w = np.sqrt(known.w2)
        force = known.vectors.T @ framed.excitation
        swing, decay = w * np.sqrt(1.0 - self.damping**2), self.damping * (w[:, None] + w)
        less, more = swing[:, None] - swing, swing[:, None] + swing
        product = 0.5 * (decay / (decay**2 + less**2) - decay / (decay**2 + more**2)) / np.outer(swing, swing)
        gramian = (force @ force.T) * product
        turn = eigh(0.5 * (gramian + gramian.T))[1][:, ::-1]
        return _enough(framed, known.vectors @ turn[:, :modes], modes)

    def grown(self, modes: int, worst: float) -> tuple[Balanced, int] | None:
        larger = modes + max(1, modes // 4)
        return None if larger > self.candidates else (self, larger)

    def most(self, framed: FramedBody, modes: int) -> int:
        return len(framed.modes(modes).w2)


def _check_loaded(kind: str, framed: FramedBody, loads: np.ndarray) -> None:
    """Refuse a basis of responses to loads where there are none."""
    if not loads.any():
        named = framed.inputs.any()
        raise _wrong(kind, "loads none of which joins the basis" if named else "a body that nothing loads",
                     "interfaces, or loads that join the basis",
                     "Write residual_vectors='all', or name interfaces" if named
                     else "Name interfaces, or take Rubin: its modes need no loads")  # fmt: skip


def _admissible(framed: FramedBody) -> np.ndarray:
    """Return interface coordinates (nq, nq - r) that move in the frame: without rigid motions."""
    body = framed.body
    if framed.frame is not None:
        return np.delete(np.eye(body.nq), np.arange(body.nq)[body.slices[framed.frame]], axis=1)
    psi = body.constraint_modes
    mass = psi.T @ (body.fe.M @ psi)
    scale = body.coordinate_scale()[:, None]
    rigid = (mass @ body.rigid_coordinates) / scale
    return np.linalg.qr(rigid, mode="complete")[0][:, rigid.shape[1] :] / scale


def _coupled(framed: FramedBody, vectors: np.ndarray) -> np.ndarray:
    """Return displacements with the nodes of rigid interfaces moved onto the interfaces' own motion."""
    out, q = vectors.copy(), framed.body.coordinates(vectors)
    for coupling, where in zip(framed.body.couplings, framed.body.slices):
        if not coupling.averaging:
            out[coupling.rows] = coupling.matrix @ q[where]
    return out


def _enough(framed: FramedBody, vectors: np.ndarray, count: int) -> np.ndarray:
    if vectors.shape[1] < count:
        raise ReductionError(
            f"FE model '{framed.body.fe.name}'",
            found=f"{count} modes asked for",
            expected=f"at most {vectors.shape[1]}, the elastic modes that have mass",
            remedy="Ask for fewer modes, or refine the mesh",
        )
    return vectors


def _no_number(basis: Any, modes: int | None, why: str) -> int:
    if modes is not None:
        raise _wrong(type(basis).__name__, f"modes = {modes}", f"no number of modes: {why}",
                     "Leave modes out, or write modes='up to 200 Hz within 1 %'")  # fmt: skip
    return 0


def _check_count(kind: str, name: str, value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise _wrong(kind, f"{name} = {value!r}", "a whole number from 1 upwards", f"Write {name}=20")


def _wrong(kind: str, found: str, expected: str, remedy: str) -> ReductionError:
    return ReductionError(f"Basis {kind}", found=found, expected=expected, remedy=remedy)
