"""How far the reduced body answers differently from the full one: a bound over a band of frequencies.

``H = F^T D^-1 F`` with ``D = (1 + 2 i zeta) K - w2 M`` and its projection differ by ``R^T D^-1 R``, R the residual of
the projected response. The known modes answer to R exactly, and what is left no more than its static energy times the
amplification of the first mode that is not known (docs, theory "reduction", eq. (transfer-bound)).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh

from flexmb.errors import ReductionError
from flexmb.reduction.framed_body import FramedBody

__all__ = ["REFERENCE_DAMPING", "TransferError", "transfer_error"]

REFERENCE_DAMPING = 0.01
"""Fraction of critical damping at which responses are compared where a reduction proposes none."""
BEYOND = 2.0
"""Modes are known up to this many times the band: the others are amplified by less than 1 / (1 - 1/4) = 1.33."""
MOST_FREEDOMS = 24
"""Interface freedoms up to which errors are kept with their phases: their number grows with the square."""
_LINES = 100  # frequencies over a band, besides the resonances
_FINER, _PEAKS = 3, 4  # times that lines are put beside the largest peaks of the error, and how many peaks
_DIGITS = 7  # of a kept matrix: shares of forces cancel to a hundredth or so, not to 1e-7


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
    matrix : (n, k, k) complex, m/N, or None
        Estimate of the error at the interface freedoms by forces on them; None where these are too many.
    damping : float
        Fraction of critical damping of all resonances, as hysteresis.
    length : float, m
        Size of the body: moments count as forces there.
    """

    frequencies: np.ndarray
    error: np.ndarray
    response: np.ndarray
    by_input: np.ndarray
    matrix: np.ndarray | None
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
        """Return the bound as JSON can hold it; ``matrix`` has real and imaginary parts, (n, 2, k, k)."""
        E = self.matrix
        return {
            **({} if E is None else {"matrix": _rounded(np.stack([E.real, E.imag], axis=1)).tolist()}),
            "frequencies": self.frequencies.tolist(),
            "error": self.error.tolist(),
            "response": self.response.tolist(),
            "by_input": self.by_input.tolist(),
            "relative": self.relative,
            "worst": self.worst,
            "damping": self.damping,
            "length": self.length,
        }


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
    own_w2 = eigh(bound.K, bound.M, eigvals_only=True)
    frequencies = _lines(limit, zeta, np.concatenate([bound.known_w2, own_w2]))
    lines = {f: bound.at(f) for f in frequencies.tolist()}
    for _ in range(_FINER):
        frequencies = np.array(sorted(lines))
        between = _between_largest(frequencies, np.array([lines[f].error for f in frequencies.tolist()]))
        lines |= {f: bound.at(f) for f in between}
    ordered = [lines[f] for f in sorted(lines)]
    k = framed.at_interfaces
    return TransferError(
        np.array(sorted(lines)),
        np.array([line.error for line in ordered]),
        np.array([line.response for line in ordered]),
        np.array([line.alone[:k] for line in ordered]),
        np.array([line.estimate[:k, :k] for line in ordered]) if 0 < k <= MOST_FREEDOMS else None,
        zeta,
        framed.body.length,
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
    """The bound at one frequency, see `TransferError`."""

    error: float
    response: float
    alone: np.ndarray
    estimate: np.ndarray


@dataclass(frozen=True, eq=False)
class _Bound:
    """What the bound is made of at any frequency, with the loss factor ``1 + 2 i zeta``.

    K, M, F : of the reduced body
    energy : products of the static responses to loads, K Phi and M Phi
    known_w2, excited, shared : the modes that are known: their squared frequencies, shares of the loads and of M Phi
    ahead : squared frequency from which on the others lie
    """

    loss: complex
    K: np.ndarray
    M: np.ndarray
    F: np.ndarray
    energy: np.ndarray
    known_w2: np.ndarray
    excited: np.ndarray
    shared: np.ndarray
    ahead: float

    def at(self, hertz: float) -> _Line:
        """Return the bound at a frequency, Hz."""
        w2, loss, known_w2, energy, F = (2.0 * np.pi * hertz) ** 2, self.loss, self.known_w2, self.energy, self.F
        answer = np.linalg.solve(loss * self.K - w2 * self.M, F.astype(complex))
        made = np.vstack([np.eye(F.shape[1]), -loss * answer, w2 * answer])
        amplitude = self.excited - (loss * known_w2[:, None] - w2) * (self.shared @ answer)
        over = amplitude / known_w2[:, None]
        least, most = 1.0 / loss, 1.0 / (loss - w2 / self.ahead)  # dynamic over static response of unknown modes
        estimate = amplitude.T @ (amplitude / (loss * known_w2 - w2)[:, None])
        estimate += 0.5 * (least + most) * (made.T @ (energy @ made) - amplitude.T @ over)
        rest = made.conj().T @ (energy @ made) - amplitude.conj().T @ over
        width, size = 0.5 * abs(most - least), max(np.linalg.eigvalsh(rest)[-1], 0.0)
        own = np.sqrt(size * np.maximum(np.diag(rest).real, 0.0))
        return _Line(
            np.linalg.norm(estimate, 2) + width * size,
            max(np.linalg.norm(F.T @ answer + estimate, 2) - width * size, 0.0),
            np.linalg.norm(estimate, axis=0) + width * own,
            estimate,
        )


def _bound(framed: FramedBody, shapes: np.ndarray, limit: float, loss: complex) -> _Bound:
    """Solve what the bound is made of: static responses once, modes up to a multiple of the band."""
    fe, load = framed.body.fe, framed.inputs
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
        0.5 * (energy + energy.T),
        known.w2,
        known.vectors.T @ load,
        known.vectors.T @ mass,
        np.inf if all_known else float(known.w2[-1]),
    )


def _rounded(numbers: np.ndarray) -> np.ndarray:
    """Return numbers to a few digits of the largest at each frequency, (n, ...): short in a file."""
    size = np.abs(numbers).max(axis=tuple(range(1, numbers.ndim)))
    places = _DIGITS - np.floor(np.log10(np.where(size > 0.0, size, 1.0))).astype(int)
    return np.stack([np.round(own, place) for own, place in zip(numbers, places, strict=True)])


def _lines(limit: float, zeta: float, w2: np.ndarray) -> np.ndarray:
    """Return frequencies over the band, Hz: even lines, and at and beside each resonance."""
    resonances = np.sqrt(w2[(w2 > 0.0)]) / (2.0 * np.pi)
    beside = (resonances[:, None] * np.array([1.0 - zeta, 1.0, 1.0 + zeta])).ravel()
    return np.unique(np.concatenate([np.linspace(0.0, limit, _LINES + 1), beside[beside <= limit]]))
