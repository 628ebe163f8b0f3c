"""What the reduction of its bodies costs a run: the spectrum of interface forces times the bound of the error.

The bound comes with the reduced data (``error_up_to``; docs, theory "reduction", eq. (transfer-bound)); the forces are
forces of joints and force elements on the interfaces, in body axes, moments over the size of the body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.results.solution import Solution

__all__ = ["RunError", "run_errors"]

FEW = 8
"""Samples below which a phase has no spectrum."""
MOST = 0.99
"""Share of the spectrum below the frequency that is told."""
UNKNOWN = 0.02
"""Share of the spectrum above the known band that is told; forces that end suddenly with the run have some."""


@dataclass(frozen=True)
class RunError:
    """The error of the elastic motion of a body in a run, by its reduction.

    Parameters
    ----------
    body : str
    share : float
        Bound of the root mean square of the error at the interfaces, over the root mean square of their elastic motion.
    frequency : float, Hz
        Below it lie 99 % of the interface forces, by their squares.
    worst : float, Hz
        Where the spectrum of the error is largest.
    beyond : float
        Share of the squares of the forces above the frequencies for which the error is known.
    limit : float, Hz
        Up to which it is known.
    remedy : str
    """

    body: str
    share: float
    frequency: float
    worst: float
    beyond: float
    limit: float
    remedy: str

    def __str__(self) -> str:
        text = (
            f"Reduction of {self.body}: by the spectrum of its interface forces (99 % below {self.frequency:.3g} Hz) "
            f"the elastic motion has an error of at most {100.0 * self.share:.2g} %, mostly at {self.worst:.3g} Hz"
        )
        if self.beyond > UNKNOWN:
            text += f"; {100.0 * self.beyond:.2g} % of them lie above {self.limit:.3g} Hz, where no error is known"
        return text


def run_errors(solution: Solution, within: float = 0.01) -> list[RunError]:
    """Return the error of every body whose data tell a bound, over the longest phase of a run.

    Parameters
    ----------
    solution : Solution
        With its model.
    within : float
        What the remedy aims at.
    """
    number = int(np.argmax([len(phase.t) for phase in solution.phases]))
    phase = solution.phases[number]
    if phase.model is None or len(phase.t) < FEW or not phase.t[-1] > phase.t[0]:
        return []
    series, found = solution.series(number), []
    for body in phase.model.bodies:
        data = getattr(body, "reduced", None)
        if data is not None and "transfer" in data.quality and data.n_interfaces:
            forces = _interface_forces(series, phase.model, body, data)
            motion = _motion(series.modal_coordinates(body.name), data)
            error = _weighed(body.name, data, *_spectrum(phase.t, forces), motion, within)
            if error is not None:
                found.append(error)
    return found


def _interface_forces(series: Any, model: Any, body: Any, data: Any) -> np.ndarray:
    """Return forces and moments over the size of the body, (nt, 6 k), N, on all interfaces in body axes."""
    names = [f"{body.name}.{name}" for name in data.marker_names[: data.n_interfaces]]
    out = np.zeros((len(series.t), len(names), 6))
    parts = [(joint, series.reaction) for joint in model.joints] + [(force, series.force) for force in model.forces]
    for part, read in parts:
        places = tuple(getattr(part, "markers", None) or (getattr(part, "marker", None),))
        if not any(place in names for place in places):
            continue
        wrench = read(part.name)
        for k, place in enumerate(places):
            if place not in names:
                continue
            on = wrench if k == len(places) - 1 else -wrench
            if k == 0 and len(places) == 2:  # the force acts at the second marker: its lever about the first
                arm = series.marker(places[1]).r - series.marker(place).r
                on = np.hstack([on[:, :3], on[:, 3:] + np.cross(arm, on[:, :3])])
            out[:, names.index(place)] += on
    axes = series.marker(names[0]).R
    size = data.quality["transfer"]["length"]
    turned = np.einsum("tij,tkni->tknj", axes, out.reshape(len(out), len(names), 2, 3))
    turned[:, :, 1] /= size
    return turned.reshape(len(out), -1)


def _motion(eta: np.ndarray, data: Any) -> float:
    """Return the mean square over time of the elastic motion of all interfaces against the mean motion, m2.

    Rotations count at the size of the body. A clamped frame moves against the mean motion: that is taken out.
    """
    inertia, k = data.invariants, data.n_interfaces
    G = np.block([[inertia.vv, inertia.vw0], [inertia.vw0.T, inertia.ww0]])
    rigid = -np.linalg.lstsq(G, np.vstack([inertia.vn, inertia.wn0]), rcond=1e-12)[0]
    arms = data.marker_positions[:k]
    turned = np.cross(rigid[3:].T[None], arms[:, None]).transpose(0, 2, 1)  # (k, 3, m)
    shift = data.marker_translations[:k] + rigid[:3] + turned
    turn = (data.marker_rotations[:k] + rigid[3:]) * data.quality["transfer"]["length"]
    return float(np.mean(np.sum((eta @ np.concatenate([shift, turn]).reshape(6 * k, -1).T) ** 2, axis=1)))


def _spectrum(t: np.ndarray, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies (n,), Hz, and amplitudes of the forces (n, 6 k), N, whose squares sum up to the mean square.

    No window: the body begins undeformed, so the forces of the whole run make its whole motion; nothing comes after
    them (zeros of the same length), so that the error of a response that dies away is in it too.
    """
    even = np.linspace(t[0], t[-1], len(t))
    samples = np.stack([np.interp(even, t, column) for column in forces.T])
    amplitude = np.abs(np.fft.rfft(samples, 2 * len(t)))
    amplitude[:, 1:-1] *= np.sqrt(2.0)
    return np.fft.rfftfreq(2 * len(t), even[1] - even[0]), amplitude.T / (np.sqrt(2.0) * len(t))


def _weighed(name: str, data: Any, frequencies: np.ndarray, forces: np.ndarray, motion: float, within: float):
    """Return the error of a body from the spectrum of its forces and its mean square motion; None at rest."""
    told = data.quality["transfer"]
    power = np.sum(forces**2, axis=1)
    limit, total = told["frequencies"][-1], float(power.sum())
    if total == 0.0 or motion == 0.0:
        return None
    inside = frequencies <= limit
    places = [6 * k + f for k, row in enumerate(data.quality["interfaces"]) for f in row["freedoms"]]
    bounds = np.array(told["by_input"])
    at = [np.interp(frequencies[inside], told["frequencies"], bound) for bound in bounds.T]
    error = np.sum(np.array(at).T * forces[inside][:, places], axis=1) ** 2
    share = float(np.sqrt(error.sum() / motion))
    highest = float(frequencies[np.searchsorted(np.cumsum(power), MOST * total)])
    beyond = float(power[~inside].sum() / total)
    return RunError(
        body=name,
        share=share,
        frequency=highest,
        worst=float(frequencies[inside][int(np.argmax(error))]),
        beyond=beyond,
        limit=limit,
        remedy=_remedy(data.quality, share, highest, limit, within, beyond),
    )


def _remedy(quality: dict[str, Any], share: float, frequency: float, limit: float, within: float, beyond: float) -> str:
    """Return what to do: more modes where the error is too large, a wider band where forces lie beyond it."""
    if beyond > UNKNOWN:
        return f"Reduce again with error_up_to={frequency:.3g}"
    if share <= within:
        return ""
    if quality.get("basis", "CraigBampton()") != "CraigBampton()":
        return f"Reduce again with modes='up to {limit:.3g} Hz within {100.0 * within:.2g} %'"
    # it falls with the fourth power of the first frequency that is left out, and not all modes are of the right kind
    more = int(np.ceil((quality["normal_modes"] + 1) * (share / within) ** 0.5)) + 1
    return f"Reduce again with {more} modes"
