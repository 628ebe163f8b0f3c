"""How far the reduced body answers differently from the full one: a bound over a band of frequencies.

``H = F^T D^-1 F`` with ``D = (1 + 2 i zeta) K - w2 M`` and its projection differ by ``R^T D^-1 R``, R the residual of
the projected response. The known modes answer to R exactly, and what is left no more than its static energy times the
amplification of the first mode that is not known (docs, theory "reduction", eq. (transfer-bound)).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import eigh

from flexmb.errors import ReductionError
from flexmb.reduction.error_lines import ErrorLines
from flexmb.reduction.framed_body import FramedBody
from flexmb.reduction.part_errors import errors_of_parts

__all__ = ["REFERENCE_DAMPING", "TransferError", "transfer_error"]

REFERENCE_DAMPING = 0.01
"""Fraction of critical damping at which responses are compared where a reduction proposes none."""
BEYOND = 2.0
"""Modes are known up to this many times the band: the others are amplified by less than 1 / (1 - 1/4) = 1.33."""
MOST_FREEDOMS = 24
"""Interface freedoms up to which errors are kept with their phases: their number grows with the square."""
_SLOWEST = 1e-4  # share of the band: at rest the rigid motion has no bound
_CALM = 2.0
"""Dynamic over static response, or over that of a free mass, up to which it counts as no resonance."""
MOST_LOADS = 48
"""Load shapes up to which errors by them are kept."""
_LINES = 100  # frequencies over a band, besides the resonances
_FINER, _PEAKS = 3, 4  # times that lines are put beside the largest peaks of the error, and how many peaks
_ABOVE, _FURTHEST, _RESONANCES = 24, 100.0, 40  # lines above the band, up to so many times it, and resonances there


@dataclass(frozen=True, eq=False)
class TransferError:
    """Bound of the error of the response to the loads of a body.

    Parameters
    ----------
    frequencies : (n,), Hz
    error, response : (n,), m/N
        Upper bound of the largest singular value of the error, lower bound of the full elastic response's.
    by_input : (n, k), m/N
        Bound of the norm of the error of the response to each interface freedom by itself.
    kept : ErrorLines or None
        Estimate of the error at the interface freedoms by whatever acts; None without interfaces.
    beyond : ErrorLines or None
        The same above the band, by the modes that are known.
    rest : ErrorLines or None
        What these leave above the band, as if it moved at rest: other modes may amplify it.
    ahead : float, Hz
        From which on these modes lie.
    by_parts : (n,), m/N, or None
        What the bases of parts add in an assembly, an estimate; None where it is not known. `kept` has it.
    damping : float
        Fraction of critical damping of all resonances, as hysteresis.
    length : float, m
        Size of the body: moments count as forces there.
    """

    frequencies: np.ndarray
    error: np.ndarray
    response: np.ndarray
    by_input: np.ndarray
    kept: ErrorLines | None
    beyond: ErrorLines | None
    rest: ErrorLines | None
    ahead: float
    by_parts: np.ndarray | None
    damping: float
    length: float

    @property
    def relative(self) -> float:
        """Largest error over the largest response in the band (H-infinity norm)."""
        return float(self.error.max() / self.response.max()) if self.response.max(initial=0.0) > 0.0 else 0.0

    @property
    def worst(self) -> float:
        """Frequency of the largest error, Hz."""
        return float(self.frequencies[int(np.argmax(self.error))])

    def numbers(self) -> dict[str, Any]:
        """Return the bound as JSON can hold it."""
        return {
            **({} if self.kept is None else self.kept.numbers()),
            **({} if self.beyond is None or self.rest is None else self._above_the_band(self.beyond, self.rest)),
            "frequencies": self.frequencies.tolist(),
            "error": self.error.tolist(),
            "response": self.response.tolist(),
            "by_input": self.by_input.tolist(),
            "relative": self.relative,
            **self._of_parts(),
            "worst": self.worst,
            "damping": self.damping,
            "length": self.length,
        }

    def _of_parts(self) -> dict[str, Any]:
        if self.by_parts is None:
            return {}
        largest = int(np.argmax(self.by_parts))
        share = float(self.by_parts[largest] / self.response.max()) if self.response.max(initial=0.0) > 0.0 else 0.0
        return {"by_parts": share, "by_parts_at": float(self.frequencies[largest])}

    def _above_the_band(self, beyond: ErrorLines, rest: ErrorLines) -> dict[str, Any]:
        """Return what is kept above the band; JSON has no infinite numbers: None stands for no modes ahead."""
        ahead = self.ahead if np.isfinite(self.ahead) else None
        return {"beyond": {**beyond.numbers(), "ahead": ahead, "rest": rest.numbers()}}


def transfer_error(framed: FramedBody, shapes: np.ndarray, limit: float, damping: float | None = None) -> TransferError:
    """Return the bound up to the frequency `limit`, Hz, for shapes (ndof, m) of the frame and its rigid motions.

    The bound holds at each frequency that is looked at: lines over the band, all resonances in it, and more lines where
    it is largest. ReductionError where nothing loads the body.
    """
    fe, zeta = framed.body.fe, REFERENCE_DAMPING if damping is None else max(damping, 1e-4)
    if not framed.inputs.any():
        raise ReductionError(
            f"FE model '{fe.name}'",
            found="neither interfaces nor loads",
            expected="loads to which the response is compared",
            remedy="Name interfaces or loads, or leave out error_up_to and give a number of modes or an accuracy "
            "'of the frequencies'",
        )
    bound = _bound(framed, shapes, limit, 1.0 + 2j * zeta)
    own_w2 = bound.own[0]
    frequencies = _lines(limit, zeta, np.concatenate([bound.known_w2, own_w2]))
    lines = {f: bound.at(f) for f in frequencies.tolist()}
    for _ in range(_FINER):
        frequencies = np.array(sorted(lines))
        between = _between_largest(frequencies, np.array([lines[f].error for f in frequencies.tolist()]))
        lines |= {f: bound.at(f) for f in between}
    ordered = [lines[f] for f in sorted(lines)]
    by_parts = _by_parts(framed, shapes, bound, np.array(sorted(lines)))
    kept = _kept(framed, np.array(sorted(lines)), ordered)
    if by_parts is not None and kept is not None and kept.matrix is not None:
        kept = replace(kept, matrix=kept.matrix + by_parts)
    above = _lines_above(limit, zeta, bound, own_w2)
    beyond = [bound.above(f) for f in above.tolist()]
    return TransferError(
        np.array(sorted(lines)),
        np.array([line.error for line in ordered]),
        np.array([line.response for line in ordered]),
        np.array([line.alone[: framed.at_interfaces] for line in ordered]),
        kept,
        _kept(framed, above, beyond),
        _kept(framed, above, [replace(line, estimate=line.rest) for line in beyond]),
        float(np.sqrt(bound.ahead) / (2.0 * np.pi)),
        None if by_parts is None else np.linalg.norm(by_parts, 2, axis=(1, 2)),
        zeta,
        framed.body.length,
    )


def _by_parts(framed: FramedBody, shapes: np.ndarray, bound: _Bound, frequencies: np.ndarray) -> np.ndarray | None:
    """Return what the bases of parts add to the response to forces on interfaces, (n, k, k); None if it is not known.

    The body moves with its rigid inertia as well, whose forces parts pass on to each other.
    """
    body, k = framed.body, framed.at_interfaces
    fe = body.fe
    if fe.condensed is None or not k or not fe.condensed.errors or None in fe.condensed.errors:
        return None
    parts = [(part, part.places(fe.dofs)) for part in fe.condensed.errors]
    load = framed.inputs[:, :k]
    rigid = body.rigid @ np.linalg.solve(body.rigid_mass, body.rigid.T @ load)
    found = []
    for hertz in frequencies.tolist():
        w2 = (2.0 * np.pi * max(hertz, _SLOWEST * frequencies[-1])) ** 2
        answer = np.linalg.solve(bound.loss * bound.K - w2 * bound.M, bound.F[:, :k].astype(complex))
        motion = shapes @ answer - rigid / w2
        found.append(errors_of_parts(parts, motion, np.sqrt(w2) / (2.0 * np.pi), bound.loss))
    return np.array(found)


def _kept(framed: FramedBody, frequencies: np.ndarray, lines: list[_Line]) -> ErrorLines | None:
    """Return the estimates of lines at the interface freedoms, by forces on them, by loads of one unit, and by spin."""
    k, load_sizes = framed.at_interfaces, framed.load_sizes
    if not k:
        return None
    alone = np.array([line.alone[:k] for line in lines])
    if k > MOST_FREEDOMS:
        return ErrorLines(frequencies, alone, None, None, None)
    estimate = np.array([line.estimate[:k] for line in lines])
    by_loads = estimate[:, :, k : k + len(load_sizes)] * load_sizes
    few = len(load_sizes) <= MOST_LOADS
    return ErrorLines(
        frequencies, alone, estimate[:, :, :k], by_loads if few else None, estimate[:, :, k + len(load_sizes) :]
    )


def _between_largest(frequencies: np.ndarray, error: np.ndarray) -> list[float]:
    """Return the middles on both sides of the largest peaks of the error over the frequencies."""
    beside = np.concatenate([[-np.inf], error, [-np.inf]])
    peaks = np.flatnonzero((error >= beside[:-2]) & (error >= beside[2:]))
    peaks = peaks[np.argsort(-error[peaks], kind="stable")][:_PEAKS]
    middles = 0.5 * (frequencies[1:] + frequencies[:-1])
    places = {place for peak in peaks for place in (peak - 1, peak) if 0 <= place < len(middles)}
    return [float(middles[place]) for place in sorted(places)]


@dataclass(frozen=True)
class _Line:
    """The bound at one frequency, see `TransferError`; `rest` is what the known modes leave, as it moves at rest."""

    error: float
    response: float
    alone: np.ndarray
    estimate: np.ndarray
    rest: np.ndarray


@dataclass(frozen=True, eq=False)
class _Bound:
    """What the bound is made of at any frequency, with the loss factor ``1 + 2 i zeta``.

    K, M, F : of the reduced body
    count : how many of the loads the error is bounded for; those of spin come behind them
    energy : products of the static responses to loads, K Phi and M Phi
    known_w2, excited, shared : the modes that are known: their squared frequencies, shares of the loads and of M Phi
    ahead : squared frequency from which on the others lie
    """

    loss: complex
    K: np.ndarray
    M: np.ndarray
    F: np.ndarray
    count: int
    energy: np.ndarray
    known_w2: np.ndarray
    excited: np.ndarray
    shared: np.ndarray
    ahead: float

    def at(self, hertz: float) -> _Line:
        """Return the bound at a frequency, Hz."""
        w2, F, n = (2.0 * np.pi * hertz) ** 2, self.F, self.count
        answer = np.linalg.solve(self.loss * self.K - w2 * self.M, F.astype(complex))
        middle, width = self._amplified(w2)
        known, left = self._of_residual(answer, w2)
        estimate = known + middle * left
        made, amplitude = self._residual(answer[:, :n], w2, np.eye(F.shape[1], n))
        rest = made.conj().T @ (self.energy @ made) - amplitude.conj().T @ (amplitude / self.known_w2[:, None])
        size = max(np.linalg.eigvalsh(rest)[-1], 0.0)
        own = np.sqrt(size * np.maximum(np.diag(rest).real, 0.0))
        inner = estimate[:n, :n]
        return _Line(
            np.linalg.norm(inner, 2) + width * size,
            max(np.linalg.norm(F[:, :n].T @ answer[:, :n] + inner, 2) - width * size, 0.0),
            np.linalg.norm(inner, axis=0) + width * own,
            estimate,
            left,
        )

    def above(self, hertz: float) -> _Line:
        """Return the bound at a frequency above the band, Hz, with what a mode that is not known may amplify in `rest`.

        At a resonance of the reduced body most of the residual is that resonance. No unknown mode amplifies that once
        more: the resonance of the full body is near it, and the error at most that of both.
        """
        w2, F, line = (2.0 * np.pi * hertz) ** 2, self.F, self.at(hertz)
        own_w2, own = self.own
        gain = 1.0 / (self.loss * own_w2 - w2)
        calm = gain * np.minimum(1.0, _CALM / (np.maximum(own_w2, w2) * np.abs(gain)))
        answer, swing = (own @ (part[:, None] * (own.T @ F)) for part in (calm, gain - calm))
        middle, width = self._amplified(w2)
        known, _ = self._of_residual(answer + swing, w2)
        _, rest = self._of_residual(answer, w2)
        both, amplified = 2.0 * (F.T @ swing), (abs(middle) + width) * (line.rest - rest)
        n = self.count
        less = both if np.linalg.norm(both[:n, :n]) < np.linalg.norm(amplified[:n, :n]) else amplified
        return replace(line, estimate=known + less, rest=rest)

    def _residual(self, answer: np.ndarray, w2: float, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual of responses (m, n) to loads, combinations (nf, n) of all, as a combination of what
        `energy` belongs to, and in the known modes.
        """
        made = np.vstack([load, -self.loss * answer, w2 * answer])
        return made, self.excited @ load - (self.loss * self.known_w2[:, None] - w2) * (self.shared @ answer)

    def _of_residual(self, answer: np.ndarray, w2: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the error (nf, nf) by known modes, and what is left of the residual as it moves at rest."""
        made, amplitude = self._residual(answer, w2, np.eye(self.F.shape[1]))
        known = amplitude.T @ (amplitude / (self.loss * self.known_w2 - w2)[:, None])
        return known, made.T @ (self.energy @ made) - amplitude.T @ (amplitude / self.known_w2[:, None])

    @cached_property
    def own(self) -> tuple[np.ndarray, np.ndarray]:
        """Squared frequencies and shapes, of unit mass, of the reduced body."""
        return eigh(self.K, self.M)

    def _amplified(self, w2: float) -> tuple[complex, float]:
        """Return the middle and the radius of a circle in which dynamic over static responses of unknown modes lie.

        They lie on the circle of the diameter 1 / (2 zeta) that touches the imaginary axis at zero: below the first of
        these modes on the arc up to its ratio, which is less than half of the circle, above it anywhere.
        """
        if w2 < self.ahead:
            least, most = 1.0 / self.loss, 1.0 / (self.loss - w2 / self.ahead)
            return 0.5 * (least + most), 0.5 * abs(most - least)
        radius = 0.5 / self.loss.imag
        return -1j * radius, radius


def _bound(framed: FramedBody, shapes: np.ndarray, limit: float, loss: complex) -> _Bound:
    """Solve what the bound is made of: static responses once, modes up to a multiple of the band."""
    fe, load = framed.body.fe, np.hstack([framed.inputs, framed.spin])
    beyond = (BEYOND * 2.0 * np.pi * limit) ** 2
    known, mass = framed.modes_beyond(beyond), fe.M @ shapes
    answers = np.hstack([framed.solve(load), shapes, framed.solve(mass)])  # K^-1 of what residuals are made of
    energy = answers.T @ (fe.K @ answers)
    K, M = shapes.T @ (fe.K @ shapes), shapes.T @ mass
    all_known = not len(known.w2) or known.w2[-1] <= beyond  # others have no mass
    return _Bound(
        loss,
        0.5 * (K + K.T),
        0.5 * (M + M.T),
        shapes.T @ load,
        framed.inputs.shape[1],
        0.5 * (energy + energy.T),
        known.w2,
        known.vectors.T @ load,
        known.vectors.T @ mass,
        np.inf if all_known else float(known.w2[-1]),
    )


def _lines(limit: float, zeta: float, w2: np.ndarray) -> np.ndarray:
    """Return frequencies over the band, Hz: even lines, and at and beside each resonance."""
    resonances = np.sqrt(w2[(w2 > 0.0)]) / (2.0 * np.pi)
    beside = (resonances[:, None] * np.array([1.0 - zeta, 1.0, 1.0 + zeta])).ravel()
    return np.unique(np.concatenate([np.linspace(0.0, limit, _LINES + 1), beside[beside <= limit]]))


def _lines_above(limit: float, zeta: float, bound: _Bound, own_w2: np.ndarray) -> np.ndarray:
    """Return frequencies above the band, Hz: wider and wider lines, and at and beside the first resonances."""
    both = np.concatenate([bound.known_w2, own_w2])
    resonances = np.sort(np.sqrt(both[both > 0.0]) / (2.0 * np.pi))
    resonances = resonances[resonances > limit][:_RESONANCES]
    beside = (resonances[:, None] * np.array([1.0 - 2.0 * zeta, 1.0, 1.0 + 2.0 * zeta])).ravel()
    furthest = _FURTHEST * limit
    even = np.geomspace(limit, furthest, _ABOVE + 1)
    if np.isfinite(bound.ahead):  # there resonances begin that are not known
        first = np.sqrt(bound.ahead) / (2.0 * np.pi)
        even = np.concatenate([even, [first * (1.0 - 2.0 * zeta), first]])
    found = np.concatenate([even, beside])
    return np.unique(found[(found >= limit) & (found <= furthest)])
