"""What the data of a reduced body tell of the error of its response, line by line, and which loads it is told for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["KnownErrors", "Lines", "acting_loads", "fields_of_spin", "known_errors", "left_out"]

SPIN = 0.005
"""Square of the angular speed over the first frequency of a body from which a centrifugal load whose error is not told
is mentioned."""
TURNING = 0.1
"""Square of the angular speed over the lowest frequency of a body as it is held, from which that is mentioned: spin
takes so much of its stiffness."""
MOST_PLACES, TONES = 600, 20
"""Frequencies at which a mode that is not known is looked for, and how many of them are those of the largest errors."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Errors of the motion of k interface freedoms at n frequencies, as `flexmb.reduction.error_lines` writes them.

    Parameters
    ----------
    frequencies : (n,), Hz
    matrix : (n, k, k) complex, m/N
    others : (n, k, l) complex
        By unit amounts of the load shapes, and by the six fields of spin, as far as they are told.
    """

    frequencies: np.ndarray
    matrix: np.ndarray
    others: np.ndarray

    def errors(self, frequencies: np.ndarray, forces: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return the error (n, k), m, by amplitudes (n, k) of forces and (n, l) of other loads at frequencies, Hz."""
        found = np.zeros(forces.shape, complex)
        after, shares = self._between(frequencies)
        for line in np.unique(after):
            here = after == line
            one, two = (forces[here] @ self.matrix[k].T + others[here] @ self.others[k].T for k in (line - 1, line))
            found[here] = one + shares[here, None] * (two - one)
        return found

    def matrix_at(self, hertz: float) -> np.ndarray:
        """Return the matrix (k, k) at a frequency, Hz."""
        (after,), (share,) = self._between(np.array([hertz]))
        return np.asarray((1.0 - share) * self.matrix[after - 1] + share * self.matrix[after])

    def _between(self, frequencies: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the numbers of the lines above frequencies, and how far these lie from the line below to that one."""
        known = self.frequencies
        after = np.clip(np.searchsorted(known, frequencies), 1, len(known) - 1)
        return after, np.clip((frequencies - known[after - 1]) / (known[after] - known[after - 1]), 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class KnownErrors:
    """What is told of the errors of the response of a body.

    Parameters
    ----------
    limit : float, Hz
        Up to which they are known.
    above : bool
        Is there anything told above it?
    by_input : (n, k), m/N, and its frequencies (n,), Hz
        Bounds of the shares of forces.
    band : Lines or None
        With phases; None where these are not kept.
    beyond, rest : Lines or None
        Above `limit`: by modes that are known, and what these leave as if it moved at rest.
    ahead : float, Hz
        From which on the modes lie that may amplify what is left.
    damping : float
    loads, spin : bool
        Are errors told by load shapes and by spin?
    """

    limit: float
    above: bool
    frequencies: np.ndarray
    by_input: np.ndarray
    band: Lines | None
    beyond: Lines | None
    rest: Lines | None
    ahead: float
    damping: float
    loads: bool
    spin: bool

    def amplified(self, frequencies: np.ndarray, squares: np.ndarray) -> np.ndarray:
        """Return squares (n,) of what is left above the band times the squares of the amplification by a mode there.

        Where it lies is not known: at the frequency at which most would come of it. Forces at one frequency find their
        resonance; of those that spread over many, one mode answers to few.
        """
        if not np.isfinite(self.ahead) or not np.any(squares):
            return squares
        last = max(float(frequencies[-1]), self.ahead)
        count = int(np.clip(np.log(last / self.ahead) / self.damping, 1, MOST_PLACES)) + 1
        largest = frequencies[np.argsort(-squares, kind="stable")[:TONES]]
        places = np.concatenate([np.geomspace(self.ahead, last, count), largest[largest > self.ahead]])
        sums = [float(squares @ self._amplification(frequencies, place)) for place in places.tolist()]
        return squares * self._amplification(frequencies, float(places[int(np.argmax(sums))]))

    def _amplification(self, frequencies: np.ndarray, place: float) -> np.ndarray:
        return 1.0 / ((1.0 - (frequencies / place) ** 2) ** 2 + 4.0 * self.damping**2)


def known_errors(told: dict[str, Any]) -> KnownErrors:
    """Return what a quality report tells; former versions tell nothing above the band nor of other loads."""
    parts = [told, told["beyond"]] if "beyond" in told else [told]
    loads, spin = ("loads" in told), ("spin" in told)
    band, beyond, rest = (None if part is None else _lines(part) for part in (told, *_above(told)))
    ahead = told["beyond"]["ahead"] if len(parts) > 1 else None
    return KnownErrors(
        limit=float(told["frequencies"][-1]),
        above=len(parts) > 1,
        frequencies=np.concatenate([part["frequencies"] for part in parts]),
        by_input=np.concatenate([part["by_input"] for part in parts]),
        band=band,
        beyond=beyond,
        rest=rest,
        ahead=np.inf if ahead is None else float(ahead),
        damping=float(told["damping"]),
        loads=loads,
        spin=spin,
    )


def _above(told: dict[str, Any]) -> tuple[Any, Any]:
    return (told["beyond"], told["beyond"]["rest"]) if "beyond" in told else (None, None)


def _lines(part: dict[str, Any]) -> Lines | None:
    """Return lines with phases; None where these are not kept."""
    if "matrix" not in part:
        return None
    matrix = _complex(part["matrix"])
    others = [_complex(part[name]) for name in ("loads", "spin") if name in part]
    return Lines(np.array(part["frequencies"], float), matrix, np.concatenate([matrix[:, :, :0], *others], axis=2))


def _complex(numbers: Any) -> np.ndarray:
    """Return a matrix (n, k, l) from its real and imaginary parts."""
    real, imaginary = np.moveaxis(np.array(numbers, float), 1, 0)
    return np.asarray(real + 1j * imaginary)


def acting_loads(known: KnownErrors, loads: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Return what acts beside the forces on interfaces, (nt, l), as the columns of `Lines.others` count it.

    Parameters
    ----------
    known : KnownErrors
    loads : (nt, nl)
        Amounts of the load shapes.
    w : (nt, 3), rad/s
        Angular velocity in body axes.
    """
    fields = fields_of_spin(w)
    return np.hstack([loads[:, : loads.shape[1] if known.loads else 0], fields[:, : 6 if known.spin else 0]])


def fields_of_spin(w: np.ndarray) -> np.ndarray:
    """Return the components xx, yy, zz, xy, yz, zx of A = w w^T - w^2 I, (nt, 6), of an angular velocity (nt, 3)."""
    x, y, z = w.T
    square = x**2 + y**2 + z**2
    return np.column_stack([x**2 - square, y**2 - square, z**2 - square, x * y, y * z, z * x])


def left_out(known: KnownErrors, data: Any, loads: np.ndarray, w: np.ndarray, turning: float) -> str:
    """Return in words what acts on a body and is not in its error; "" where that is nothing.

    turning : square of its angular speed over its lowest frequency as it is held
    """
    found = []
    if not known.loads and np.any(loads):
        names = [name for name, amount in zip(data.load_names, loads.T) if np.any(amount)]
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        found.append(f"the load '{names[0]}'{more}")
    if data.quality["model"].get("parts") and "by_parts" not in data.quality["transfer"]:
        found.append("what the bases of its parts leave out")
    rate = float(np.sqrt(np.mean(np.sum(w**2, axis=1))))
    softest = 2.0 * np.pi * float(data.frequencies.min(initial=np.inf))
    if not known.spin and rate**2 > SPIN * softest**2:
        found.append(f"the centrifugal load of {rate:.3g} rad/s")
    if not found and turning > TURNING:
        return (
            f"spin of {rate:.3g} rad/s changes its stiffness by some {100.0 * turning:.2g} %, which is in it as a "
            "margin only: compare with a run of more modes"
        )
    if not found:
        return ""
    return f"{' and '.join(found)} {'is' if len(found) == 1 else 'are'} not in it: compare with a run of more modes"
