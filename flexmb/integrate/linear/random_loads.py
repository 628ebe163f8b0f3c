"""Answers of a plant to stationary random loads: power spectral densities, and variances."""

from __future__ import annotations

import warnings

import numpy as np
from scipy.linalg import eig, matrix_balance, solve_continuous_lyapunov

from flexmb.errors import ModelError
from flexmb.integrate.linear.plant import Plant
from flexmb.math.definiteness import symmetric
from flexmb.told import tell

__all__ = ["spectral_response", "variances"]

LOST = 0.01
"""Share of its damping by which the rounding of A may move a pole without a warning."""
PARALLEL = 1e7
"""Condition of eigenvectors from which on they do not say what the poles do."""


def spectral_response(plant: Plant, frequencies, densities) -> np.ndarray:
    """Return the power spectral densities of the outputs, G_y = H G_u H*.

    Parameters
    ----------
    plant : Plant
        Stable.
    frequencies : (nf,), Hz
    densities : (nf, m) or (nf, m, m)
        One-sided densities of the inputs, in (unit of the input)^2/Hz, of inputs that do not depend on each other; or
        with the cross spectra, Hermitian.

    Returns
    -------
    (nf, p, p), complex
        On the diagonal the densities of the outputs, beside it their cross spectra.

    Source: Newland 1993, Random vibrations, spectral and wavelet analysis, chapters 6 and 7.
    """
    _require_stable(plant)
    response = plant.frequency_response(frequencies)
    given = np.asarray(densities, complex)
    nf, _, m = response.shape
    if given.shape == (nf, m):
        given = given[:, :, None] * np.eye(m)
    right = given.shape == (nf, m, m) and np.all(np.isfinite(given))
    if not right or not symmetric(given) or np.linalg.eigvalsh(given).min() < -1e-9 * (np.abs(given).max()):
        raise ModelError(
            f"Plant of model '{plant.name}'",
            found=f"densities of the shape {np.shape(densities)}",
            expected=f"({nf}, {m}), not negative, or ({nf}, {m}, {m}), Hermitian and not negative: a row per frequency",
            remedy="Give one-sided densities, in (unit of the input)^2/Hz",
        )
    return response @ given @ response.conj().swapaxes(1, 2)


def variances(plant: Plant, densities) -> np.ndarray:
    """Return the covariances (p, p) of the outputs under white noise, from A P + P A^T + B W B^T = 0.

    Parameters
    ----------
    plant : Plant
        Stable; inputs may not pass to outputs at once, where the variance would be infinite.
    densities : (m,) or (m, m)
        One-sided densities, in (unit of the input)^2/Hz; white noise is seen with half of it at every frequency.
    """
    _require_stable(plant)
    given = np.asarray(densities, float)
    m = plant.B.shape[1]
    whole = np.diag(given) if given.shape == (m,) else given
    if whole.shape != (m, m) or not np.all(np.isfinite(whole)):
        raise ModelError(
            f"Plant of model '{plant.name}'",
            found=f"densities of the shape {given.shape}",
            expected=f"({m},) or ({m}, {m}) finite numbers",
            remedy="Give one density for every input",
        )
    if np.any(plant.D) or np.any(plant.D1) or np.any(plant.D2):
        raise ModelError(
            f"Plant of model '{plant.name}'",
            found="an output that follows an input at once",
            expected="outputs that white noise reaches by way of states: the variance is infinite otherwise",
            remedy="Ask for positions or velocities, or use spectral_response over the band that matters",
        )
    A, (scale, _) = matrix_balance(plant.A, permute=False, separate=True)
    B = plant.B / scale[:, None]
    P = scale[:, None] * _covariances(plant, A, 0.5 * B @ whole @ B.T) * scale
    return plant.C @ P @ plant.C.T


def _covariances(plant: Plant, A: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """Return P of A P + P A^T + Q = 0: by the eigenvectors of A, or by its Schur form (Bartels & Stewart 1972).

    The Schur form rounds everything to the fastest pole: beside a vibration 1e7 times as fast nothing is left of a slow
    one. Eigenvectors keep the digits of each, but where poles meet there are too few of them.
    """
    poles, vectors = eig(A)
    # rows of fast and slow states differ by the ratio of their poles, which costs no digits
    if np.linalg.cond(vectors / np.abs(vectors).max(axis=1, keepdims=True)) < PARALLEL:
        half = np.linalg.solve(vectors, Q.astype(complex))
        weights = np.linalg.solve(vectors, half.conj().T).conj().T
        return (vectors @ (-weights / (poles[:, None] + poles.conj())) @ vectors.conj().T).real
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        P = solve_continuous_lyapunov(A, -Q)
    if told:
        tell(
            f"Plant of model '{plant.name}': its variances are doubtful: its fastest pole, "
            f"{np.abs(poles).max():.3g} 1/s, leaves no digits for its slowest, {np.abs(poles).min():.3g} 1/s, and some "
            "of its poles meet; expected: poles of like size, or none that meet. Change a damping by a thousandth, or "
            "use rigid joints in the place of the stiffest springs"
        )
    return P


def _require_stable(plant: Plant) -> None:
    largest = float(plant.poles.real.max(initial=-np.inf))  # of the linearisation: A has rounded the slow ones
    if not largest < 0.0:
        raise ModelError(
            f"Plant of model '{plant.name}'",
            found=f"a pole with the real part {largest:.3g} 1/s",
            expected="a plant that settles: only its answers to stationary loads are stationary",
            remedy="Add damping, or supports to free motions",
        )
    if len(plant.poles):
        worst = int(np.argmax(plant.lost / -plant.poles.real))
        pole, fastest = abs(plant.poles[worst]), float(np.abs(plant.poles).max())
        share = float(plant.lost[worst] / -plant.poles[worst].real)
        if share >= 1.0:
            raise ModelError(
                f"Plant of model '{plant.name}'",
                found=f"a pole of {pole:.3g} 1/s whose damping is rounded away beside the fastest, {fastest:.3g} 1/s",
                expected="poles of like size",
                remedy="Use rigid joints in the place of the stiffest springs",
            )
        if share > LOST:
            tell(
                f"Plant of model '{plant.name}': the damping of its pole of {pole:.3g} 1/s is rounded by {share:.0%} "
                f"beside its fastest of {fastest:.3g} 1/s, and variances and densities with it; expected: poles of "
                "like size. Use rigid joints in the place of the stiffest springs"
            )
