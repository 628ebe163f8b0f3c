"""Modal damping proposals: per mode, by frequency bands, or Rayleigh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ReductionError
from flexmb.fem.fe_model import FEModel
from flexmb.model.described import Described, is_number
from flexmb.model.plausibility import damping_doubts
from flexmb.told import tell

__all__ = ["Bands", "Rayleigh", "by_dampers", "damping_ratios", "one_ratio"]

LOWEST = 6
"""Modes that are looked at for what dampers couple them to."""
COUPLED = 0.1
"""Coupling by dampers above which modes by themselves answer otherwise, by about that share."""
ALIKE = 1e-3
"""Relative distance of squared frequencies below which modes count as a pair."""


@dataclass(frozen=True)
class Rayleigh(metaclass=Described):
    """D = mass M + stiffness K, so the ratio is mass / (2 w) + stiffness w / 2.

    Parameters
    ----------
    mass : float, 1/s
    stiffness : float, s
    """

    mass: float = 0.0
    stiffness: float = 0.0


@dataclass(frozen=True)
class Bands(metaclass=Described):
    """Constant ratio in frequency bands.

    Parameters
    ----------
    bands : sequence of (float, float), Hz and -
        Pairs of upper frequency and ratio; the last ratio holds above too.
    """

    bands: tuple[tuple[float, float], ...]


def damping_ratios(damping: Any, w2: np.ndarray, dampers: np.ndarray | None = None) -> np.ndarray:
    """Return the fraction of critical damping of each mode, (m,), for angular frequencies squared w2 (m,), 1/s2.

    `damping` is None, a number for all modes, one number per mode, `Rayleigh` or `Bands`. With None it comes from the
    discrete dampers, ``phi^T C phi / (2 w)`` of each mode by itself, `dampers` (m,) being ``phi^T C phi``; else zero.
    """
    w = np.sqrt(w2)
    if damping is None:
        ratios = np.zeros(len(w)) if dampers is None else np.maximum(dampers, 0.0) / (2.0 * w)
    elif isinstance(damping, Rayleigh | Bands):
        ratios = _by_frequency(damping, w)
    else:
        try:
            ratios = np.atleast_1d(np.asarray(damping, float))
        except (TypeError, ValueError, OverflowError):
            raise _unreadable(damping) from None
        if ratios.shape not in ((1,), (len(w),)):
            raise ReductionError(
                "Damping",
                found=f"{ratios.size} ratios",
                expected=f"one, or one per mode ({len(w)})",
                remedy="Use reduction.Bands or reduction.Rayleigh if the number of modes is not known",
            )
        ratios = np.broadcast_to(ratios, w.shape).copy()
    if np.any(ratios < 0.0) or not np.all(np.isfinite(ratios)):
        raise ReductionError(
            "Damping",
            found=f"a ratio of {ratios.min():.3g}",
            expected="numbers from 0 upwards",
            remedy="Give fractions of critical damping: 0.01 is one percent",
        )
    if not isinstance(damping, Rayleigh | None):  # these two are no numbers that somebody wrote as ratios
        for doubt in damping_doubts(ratios):
            tell(f"Damping: {doubt}.")
    return ratios


def one_ratio(damping: Any, w2: np.ndarray) -> float | None:
    """Return the fraction of critical damping at which responses are compared; None for the usual.

    `w2` (k,), 1/s2, are the squared frequencies of the full body in the band. The smallest ratio counts: there
    resonances are highest, and errors largest.
    """
    if is_number(damping):
        return float(damping) if damping >= 0.0 else None
    if isinstance(damping, Rayleigh | Bands):
        return float(_by_frequency(damping, np.sqrt(w2)).min()) if len(w2) else None
    try:
        ratios = np.zeros(0) if damping is None else np.asarray(damping, float)
    except (TypeError, ValueError, OverflowError):
        return None  # refused where the modes are known
    return float(ratios.min()) if ratios.ndim == 1 and ratios.size and np.all(ratios >= 0.0) else None


def by_dampers(fe: FEModel, shapes: np.ndarray, w2: np.ndarray, damping: Any) -> tuple[np.ndarray | None, str]:
    """Return the damping (m,), 1/s, of the shapes by discrete dampers, and a warning where it is not all of theirs.

    None without any, and where `damping` is given: that takes their place.
    """
    if fe.C is None:
        return None, ""
    if damping is not None:
        return None, (
            f"Discrete dampers of the FE model are not in the reduced body: damping={damping!r:.60} takes their place. "
            "Leave it out for theirs, or make their ends interfaces and put a SpringDamper between them."
        )
    own = shapes.T @ (fe.C @ shapes)
    return np.diag(own).copy(), _coupled(own, w2)


def _coupled(damping: np.ndarray, w2: np.ndarray) -> str:
    """Return a warning where discrete dampers couple modes, whose damping is of each by itself; "" where they do not.

    The coupling of modes i and j is ``|D_ij| w / |w_i2 - w_j2|`` (Hasselman 1976), D being ``phi^T C phi``, (m, m).
    """
    few = min(LOWEST, len(w2))
    higher = np.maximum(w2[:few, None], w2)
    apart = np.abs(w2[:few, None] - w2) + ALIKE * higher
    coupling = np.abs(damping[:few]) * np.sqrt(higher) / np.where(apart > 0.0, apart, 1.0)
    coupling[np.arange(few), np.arange(few)] = 0.0
    if coupling.max(initial=0.0) <= COUPLED:
        return ""
    i, j = sorted(int(n) + 1 for n in np.unravel_index(int(coupling.argmax()), coupling.shape))
    return (
        f"Discrete dampers of the FE model couple modes {i} and {j} by {coupling.max():.2g}, but damp each mode by "
        "itself in the reduced body: near the dampers the motion is wrong by some such share. Take them out of the FE "
        "model, make their ends interfaces, and put a SpringDamper between them."
    )


def _by_frequency(damping: Rayleigh | Bands, w: np.ndarray) -> np.ndarray:
    """Return the ratios (m,) at angular frequencies (m,), 1/s."""
    if isinstance(damping, Rayleigh):
        return damping.mass / (2.0 * w) + damping.stiffness * w / 2.0
    try:
        upper, values = (np.array(column, float) for column in zip(*damping.bands, strict=True))
    except (TypeError, ValueError, OverflowError):
        raise _unreadable(damping.bands) from None
    if np.any(np.diff(upper) <= 0.0):
        raise ReductionError(
            "Damping",
            found=f"bands up to {list(upper)} Hz",
            expected="rising upper frequencies",
            remedy="Order the bands by frequency",
        )
    return values[np.minimum(np.searchsorted(upper, w / (2.0 * np.pi)), len(upper) - 1)]


def _unreadable(damping: Any) -> ReductionError:
    return ReductionError(
        "Damping",
        found=repr(damping),
        expected="a fraction of critical damping, one per mode, reduction.Rayleigh or reduction.Bands",
        remedy="Write damping=0.01 for one percent, or reduction.Bands(((100.0, 0.01), (500.0, 0.02)))",
    )
