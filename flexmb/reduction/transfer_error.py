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

    The bound holds at each frequency that is looked at: lines over the band and all resonances in it. ReductionError
    where nothing loads the body.
    """
    fe, zeta = framed.body.fe, REFERENCE_DAMPING if damping is None else max(damping, 1e-4)
    loss, load = 1.0 + 2j * zeta, framed.inputs
    if not load.any():
        raise ReductionError(
            f"FE model '{fe.name}'",
            found="neither interfaces nor loads",
            expected="loads to which the response is compared",
            remedy="Name interfaces or loads, or leave out error_up_to and give a number of modes or an accuracy "
            "'of the frequencies'",
        )
    known = framed.modes_beyond((BEYOND * 2.0 * np.pi * limit) ** 2)
    nb = load.shape[1]
    mass = fe.M @ shapes
    answers = np.hstack([framed.solve(load), shapes, framed.solve(mass)])  # K^-1 of what residuals are made of
    energy = answers.T @ (fe.K @ answers)
    energy = 0.5 * (energy + energy.T)
    K, M, F = shapes.T @ (fe.K @ shapes), shapes.T @ mass, shapes.T @ load
    excited, shared = known.vectors.T @ load, known.vectors.T @ mass
    ahead = known.w2[-1] if len(known.w2) else np.inf  # the last one is beyond the band
    own_w2 = eigh(0.5 * (K + K.T), 0.5 * (M + M.T), eigvals_only=True)
    frequencies = _lines(limit, zeta, np.concatenate([known.w2, own_w2]))
    error, response = np.zeros(len(frequencies)), np.zeros(len(frequencies))
    alone, k = np.zeros((len(frequencies), nb)), framed.at_interfaces
    matrix = np.zeros((len(frequencies), k, k), complex) if 0 < k <= MOST_FREEDOMS else None
    for number, w2 in enumerate((2.0 * np.pi * frequencies) ** 2):
        answer = np.linalg.solve(loss * K - w2 * M, F.astype(complex))
        made = np.vstack([np.eye(nb), -loss * answer, w2 * answer])
        amplitude = excited - (loss * known.w2[:, None] - w2) * (shared @ answer)
        over = amplitude / known.w2[:, None]
        least, most = 1.0 / loss, 1.0 / (loss - w2 / ahead)  # dynamic over static response of modes that are not known
        estimate = amplitude.T @ (amplitude / (loss * known.w2 - w2)[:, None])
        estimate += 0.5 * (least + most) * (made.T @ (energy @ made) - amplitude.T @ over)
        rest = made.conj().T @ (energy @ made) - amplitude.conj().T @ over
        width, size = 0.5 * abs(most - least), max(np.linalg.eigvalsh(rest)[-1], 0.0)
        own = np.sqrt(size * np.maximum(np.diag(rest).real, 0.0))
        error[number] = np.linalg.norm(estimate, 2) + width * size
        alone[number] = np.linalg.norm(estimate, axis=0) + width * own
        if matrix is not None:
            matrix[number] = estimate[:k, :k]
        response[number] = max(np.linalg.norm(F.T @ answer + estimate, 2) - width * size, 0.0)
    return TransferError(frequencies, error, response, alone[:, :k], matrix, zeta, framed.body.length)


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
