"""What the reduction of its bodies costs a run: the spectrum of interface forces times the error of the response.

The error comes with the reduced data (``error_up_to``; docs, theory "reduction", eq. (transfer-bound)); the forces are
forces of joints, drives and force elements on the interfaces, in body axes, moments over the size of the body.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from flexmb.results.solution import Solution

__all__ = ["RunError", "run_errors"]

FEW = 8
"""Samples below which a phase has no spectrum."""
MOST = 0.99
"""Share of the spectrum below the frequency that is told."""
STATIC = 0.01
"""Static error under interface loads from which joints meet a body that is too stiff, whatever its modes."""
UNKNOWN = 0.02
"""Share of the spectrum above the known band that is told; forces that begin suddenly have some."""
END = 0.05
"""Last part of a run over which forces and motion fade."""
MARGIN = 1.5
"""What is told over what is estimated with phases: damping and sizes of motion are not quite those of the estimate."""
HELD = 1e-3
"""Share of the largest reaction from which a joint is taken to hold a freedom of an interface."""
LARGEST = 10.0
"""Error over the elastic motion that is told at most: what has no motion at all has no number."""
SPIN = 0.005
"""Square of the angular speed over the first frequency of a body from which its centrifugal load is mentioned."""
LINES = 2000
"""Lines of the spectrum, those of the largest errors, at which reactions change: each takes a system of equations."""


@dataclass(frozen=True)
class RunError:
    """The error of the elastic motion of a body in a run, by its reduction.

    Parameters
    ----------
    body : str
    share : float
        Root mean square of the error at the interfaces, over the root mean square of their elastic motion; an estimate
        with a margin, a bound where `by_size`.
    frequency : float, Hz
        Below it lie 99 % of the interface forces, by their squares.
    worst : float, Hz
        Where the spectrum of the error is largest.
    beyond : float
        Share of the squares of the forces above the frequencies for which the error is known.
    limit : float, Hz
        Up to which it is known.
    remedy : str
    by_size : bool
        The shares of the forces are added by size, as if none cancelled another: their phases are not kept with many
        interface freedoms, nor in data of former versions.
    spin : float, rad/s
        Root mean square of the angular speed, where the load of it may count; else 0.
    """

    body: str
    share: float
    frequency: float
    worst: float
    beyond: float
    limit: float
    remedy: str
    by_size: bool = False
    spin: float = 0.0

    def __str__(self) -> str:
        text = (
            f"Reduction of {self.body}: by the spectrum of its interface forces (99 % below {self.frequency:.3g} Hz) "
            f"the elastic motion has an error of {self._size()}, mostly at {self.worst:.3g} Hz"
        )
        if self.by_size:
            text += " (an upper bound that may be far too large: the shares of the forces are added by size)"
        if self.beyond > UNKNOWN:
            text += f"; {100.0 * self.beyond:.2g} % of them lie above {self.limit:.3g} Hz, where no error is known"
        return f"{text}; {self.left_out}" if self.spin else text

    @property
    def left_out(self) -> str:
        """What is not in the error, in words; "" where nothing is known to be missing."""
        words = f"the centrifugal load of {self.spin:.3g} rad/s is not in it: compare with a run of more modes"
        return words if self.spin else ""

    def _size(self) -> str:
        return "more than ten times its size" if self.share >= LARGEST else f"up to {100.0 * self.share:.3g} %"


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
            forces, reactions = _interface_forces(series, body, data)
            fading = _fading(phase.t)[:, None]
            motion = _motion(fading * series.modal_coordinates(body.name), data)
            held = _held(reactions)
            spectrum = _spectrum(phase.t, fading * forces)
            error = _weighed(body.name, data, *spectrum, held, motion, within, _on_ground(phase.model, body, data))
            if error is not None:
                found.append(replace(error, spin=_spin(series.coordinates(body.name)[1], data)))
    return found


def _interface_forces(series: Any, body: Any, data: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return forces and moments over the size of the body, (nt, 6 k), N, on all interfaces in body axes.

    Then those of them that are reactions of joints.
    """
    names = [f"{body.name}.{name}" for name in data.marker_names[: data.n_interfaces]]
    out = np.array(series.wrenches(names)).reshape(2, -1, len(names), 2, 3)
    # the axes of the body: those of its markers may be turned
    axes = Rotation.from_quat(series.coordinates(body.name)[0][:, 3:7], scalar_first=True).as_matrix()
    turned = np.einsum("tij,stkni->stknj", axes, out)
    turned[..., 1, :] /= data.quality["transfer"]["length"]
    every, reactions = turned.reshape(2, len(axes), -1)
    return every, reactions


def _spin(u: np.ndarray, data: Any) -> float:
    """Return the root mean square of the angular speed, rad/s, of velocities (nt, 6 + m) where its load may count."""
    rate = float(np.sqrt(np.mean(np.sum(u[:, 3:6] ** 2, axis=1))))
    softest = 2.0 * np.pi * float(data.frequencies.min(initial=np.inf))
    return rate if rate**2 > SPIN * softest**2 else 0.0


def _on_ground(model: Any, body: Any, data: Any) -> bool:
    """Do all joints on the interfaces of a body hold it to the ground, which does not give way?"""
    names = {f"{body.name}.{name}" for name in data.marker_names[: data.n_interfaces]}
    still = {other.name for other in model.bodies if not other.n_velocities}
    places = [set(joint.resolved_markers(model)) for joint in model.joints]
    return all(place.partition(".")[0] in still for on in places if on & names for place in on - names)


def _held(reactions: np.ndarray) -> np.ndarray:
    """Return which freedoms joints hold (6 k,), as far as their reactions (nt, 6 k) tell."""
    size = np.sqrt(np.mean(reactions**2, axis=0))
    return size > HELD * size.max()


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


def _fading(t: np.ndarray) -> np.ndarray:
    """Return weights (nt,) that go to zero over the end of a run.

    Forces that a run cuts off would strike the body there: at its resonances all of them at once, where those of a
    drive and of the joint that answers it cancel.
    """
    left = np.clip((t[-1] - t) / (END * (t[-1] - t[0])), 0.0, 1.0)
    return 0.5 - 0.5 * np.cos(np.pi * left)


def _spectrum(t: np.ndarray, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies (n,), Hz, and amplitudes (n, 6 k), N, complex, whose squares sum up to the mean square.

    The body begins undeformed, so the forces of the whole run make its whole motion; nothing comes after them (zeros
    of the same length), so that the error of a response that dies away is in it too.
    """
    even = np.linspace(t[0], t[-1], len(t))
    samples = np.stack([np.interp(even, t, column) for column in forces.T])
    amplitude = np.fft.rfft(samples, 2 * len(t))
    amplitude[:, 1:-1] *= np.sqrt(2.0)
    return np.fft.rfftfreq(2 * len(t), even[1] - even[0]), amplitude.T / (np.sqrt(2.0) * len(t))


def _weighed(
    name: str,
    data: Any,
    frequencies: np.ndarray,
    forces: np.ndarray,
    held: np.ndarray,
    motion: float,
    within: float,
    on_ground: bool,
):
    """Return the error of a body from the spectrum of its forces and its mean square motion; None at rest."""
    told = data.quality["transfer"]
    power = np.sum(np.abs(forces) ** 2, axis=1)
    limit, total = told["frequencies"][-1], float(power.sum())
    if total == 0.0:
        return None
    inside = frequencies <= limit
    places = [6 * k + f for k, row in enumerate(data.quality["interfaces"]) for f in row["freedoms"]]
    told_forces = frequencies[inside], forces[inside][:, places], held[places]
    error = _squares(data, *told_forces, 0.5 * frequencies[1], on_ground)
    if not error.any():
        return None
    share = float(np.sqrt(error.sum() / max(motion, error.sum() / LARGEST**2)))
    highest = float(frequencies[np.searchsorted(np.cumsum(power), MOST * total)])
    beyond = float(power[~inside].sum() / total)
    return RunError(
        body=name,
        share=share,
        frequency=highest,
        worst=float(frequencies[inside][int(np.argmax(error))]),
        beyond=beyond,
        limit=limit,
        by_size="matrix" not in told,
        remedy=_remedy(data.quality, share, highest, limit, within, beyond),
    )


def _squares(
    data: Any, frequencies: np.ndarray, forces: np.ndarray, held: np.ndarray, slowest: float, on_ground: bool
) -> np.ndarray:
    """Return the squares of the error (n,), m2, by amplitudes (n, k) of the forces.

    Below `slowest`, Hz, the body is taken to move as there: its rigid motion has no bound at rest.

    With phases, so that forces whose errors cancel do. What joints hold moves no other way with more modes, so that
    reactions change. Other bodies that hang on the joints may also give way, the ground does not: of the two the larger
    is told for those, with a margin.
    """
    told = data.quality["transfer"]
    known = np.array(told["frequencies"])
    if "matrix" not in told:
        at = [np.interp(frequencies, known, bound) for bound in np.array(told["by_input"]).T]
        return np.sum(np.array(at).T * np.abs(forces), axis=1) ** 2
    real, imaginary = np.moveaxis(np.array(told["matrix"]), 1, 0)
    lines = real + 1j * imaginary
    after = np.clip(np.searchsorted(known, frequencies), 1, len(known) - 1)
    shares = (frequencies - known[after - 1]) / (known[after] - known[after - 1])
    response = _elastic_and_rigid(data)
    soft = np.zeros(forces.shape, complex)
    for line in np.unique(after):
        here = after == line
        one, two = (forces[here] @ lines[k].T for k in (line - 1, line))
        soft[here] = one + shares[here, None] * (two - one)
    stiff = soft.copy()
    largest = np.argsort(-np.sum(np.abs(soft) ** 2, axis=1), kind="stable")[: LINES if held.any() else 0]
    for n in largest:
        elastic, rigid = response(max(frequencies[n], slowest))
        elastic = elastic + (1.0 - shares[n]) * lines[after[n] - 1] + shares[n] * lines[after[n]]
        change = np.linalg.lstsq((elastic + rigid)[np.ix_(held, held)], -soft[n, held], rcond=1e-12)[0]
        stiff[n] += elastic[:, held] @ change
    one, two = np.sum(np.abs(soft) ** 2, axis=1), np.sum(np.abs(stiff) ** 2, axis=1)
    return MARGIN**2 * (one if one.sum() > two.sum() and not on_ground else two)


def _elastic_and_rigid(data: Any) -> Callable[[float], tuple[np.ndarray, np.ndarray]]:
    """Return a function of the frequency, Hz: the elastic and the rigid response (k, k), m/N, of the reduced body."""
    loss, inertia = 1.0 + 2j * data.quality["transfer"]["damping"], data.invariants
    mass = np.block(
        [
            [inertia.vv, inertia.vw0, inertia.vn],
            [inertia.vw0.T, inertia.ww0, inertia.wn0],
            [inertia.vn.T, inertia.wn0.T, inertia.nn],
        ]
    )
    stiffness = np.zeros_like(mass)
    stiffness[6:, 6:] = data.stiffness
    w2, modes = eigh(stiffness, mass)  # of the free body: six rigid motions, then elastic ones against the mean motion
    shapes = _freedoms(data) @ modes
    rigid, elastic = shapes[:, :6], shapes[:, 6:]

    def response(hertz: float) -> tuple[np.ndarray, np.ndarray]:
        square = (2.0 * np.pi * hertz) ** 2
        return elastic / (loss * w2[6:] - square) @ elastic.T, rigid @ rigid.T / -square

    return response


def _freedoms(data: Any) -> np.ndarray:
    """Return the motion (k, 6 + m) of interface freedoms by rigid motions and modes; turns by the size of the body."""
    rows = []
    length = data.quality["transfer"]["length"]
    for number, row in enumerate(data.quality["interfaces"]):
        x, y, z = data.marker_positions[number]
        lever = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        move = np.hstack([np.eye(3), lever, data.marker_translations[number]])
        turn = length * np.hstack([np.zeros((3, 3)), np.eye(3), data.marker_rotations[number]])
        rows.append(np.vstack([move, turn])[row["freedoms"]])
    return np.vstack(rows)


def _remedy(quality: dict[str, Any], share: float, frequency: float, limit: float, within: float, beyond: float) -> str:
    """Return what to do: more modes where the error is too large, a wider band where forces lie beyond it.

    More shapes of a basis without the static responses of the interfaces help little where joints hold these.
    """
    if share > within and quality.get("static_error", 0.0) > STATIC:
        return f"Reduce again with basis='CraigBampton': {quality['basis'].partition('(')[0]} lacks static responses"
    if beyond > UNKNOWN:
        return f"Reduce again with error_up_to={frequency:.3g}"
    if share <= within:
        return ""
    if quality.get("basis", "CraigBampton()") != "CraigBampton()" or (share > 1.0 and "matrix" in quality["transfer"]):
        return f"Reduce again with modes='up to {limit:.3g} Hz within {100.0 * within:.2g} %'"
    if "matrix" not in quality["transfer"]:
        return "The shares of its forces are added by size, an upper bound: compare with a run of more modes"
    # it falls with the fourth power of the first frequency that is left out, and not all modes are of the right kind
    own = quality["normal_modes"] - quality.get("joined_shapes", 0)
    more = int(np.ceil((own + 1) * (share / within) ** 0.5)) + 1
    return f"Reduce again with {more} modes"
