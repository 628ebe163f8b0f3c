"""What the reduction of its bodies costs a run: the spectrum of interface forces times the error of the response.

The error comes with the reduced data (``error_up_to``; docs, theory "reduction", eq. (transfer-bound)); the forces are
forces of joints, drives and force elements on the interfaces, in body axes, moments over the size of the body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from flexmb.results.body_response import elastic_and_rigid, held_frequency, motion_by_forces
from flexmb.results.known_errors import KnownErrors, acting_loads, fields_of_spin, known_errors, left_out
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
SMALL = 0.5
"""Share of the accuracy that forces above a band may cost, when a band is proposed."""
END = 0.05
"""Last part of a run over which forces and motion fade."""
MARGIN = 1.5
"""What is told over what is estimated with phases: damping and sizes of motion are not quite those of the estimate."""
HELD = 1e-3
"""Share of the largest reaction from which a joint is taken to hold a freedom of an interface."""
STIFFER = 3.0
"""Margin per square of the angular speed over the lowest frequency of a body as it is held, beside 1: the estimate is
that of a body at rest, whose stiffness spin changes; squared where the body has geometric stiffness."""
EXPLAINED = (1.0 / 3.0, 2.0)
"""Elastic motion that the forces at the samples make, over that of the run: beyond, they are not those that made it."""
LARGEST = 10.0
"""Error over the elastic motion that is told at most: what has no motion at all has no number."""
LINES = 2000
"""Lines of the spectrum, those of the largest errors in the band and above it, at which reactions change: each takes a
system of equations."""


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
    above : float
        Part of `share` by forces above the known band, as if all that is not known was at resonance there; not a number
        where the data do not tell it.
    left_out : str
        What is not in the error, in words; "" where nothing is known to be missing.
    """

    body: str
    share: float
    frequency: float
    worst: float
    beyond: float
    limit: float
    remedy: str
    by_size: bool = False
    above: float = 0.0
    left_out: str = ""

    def __str__(self) -> str:
        text = (
            f"Reduction of {self.body}: by the spectrum of its interface forces (99 % below {self.frequency:.3g} Hz) "
            f"the elastic motion has an error of {self._size()}, mostly at {self.worst:.3g} Hz"
        )
        if self.by_size:
            text += " (an upper bound that may be far too large: the shares of the forces are added by size)"
        if self.above > 0.5 * self.share:
            text += f"; that is by loads above {self.limit:.3g} Hz, as if all that is not known was at resonance there"
        if self.beyond > UNKNOWN:
            text += f"; {100.0 * self.beyond:.2g} % of them lie above {self.limit:.3g} Hz, where no error is known"
        return f"{text}; {self.left_out}" if self.left_out else text

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
            error = _of_body(phase, series, body, data, within)
            if error is not None:
                found.append(error)
    return found


def _of_body(phase: Any, series: Any, body: Any, data: Any, within: float) -> RunError | None:
    """Return the error of one body in a phase; None at rest."""
    forces, reactions, loads = _interface_forces(series, body, data)
    spin = series.coordinates(body.name)[1][:, 3:6]
    fading = _fading(phase.t)[:, None]
    motion = _motion(fading * series.modal_coordinates(body.name), data)
    known = known_errors(data.quality["transfer"])
    others = acting_loads(known, loads, spin)
    places = [6 * k + f for k, row in enumerate(data.quality["interfaces"]) for f in row["freedoms"]]
    frequencies, every = _spectrum(phase.t, fading * np.hstack([forces, others, loads, fields_of_spin(spin)]))
    forces, others, loading, fields = np.split(
        every, np.cumsum([forces.shape[1], others.shape[1], loads.shape[1]]).tolist(), axis=1
    )
    spectra = frequencies, forces[:, places], others
    explained = float(np.sqrt(motion_by_forces(data, *spectra[:2], loading, fields) / motion)) if motion > 0.0 else 1.0
    held, power = _held(reactions)[places], 2 if getattr(body, "stiffening_groups", ()) else 1
    turning = float(np.mean(np.sum(spin**2, axis=1))) / held_frequency(data, held) ** 2
    return _weighed(
        body.name,
        data,
        known,
        spectra,
        held,
        motion,
        within,
        (_on_ground(phase.model, body, data), max(MARGIN, (1.0 + STIFFER * turning) ** power), explained),
        _unexplained(explained) or left_out(known, data, loads, spin, turning),
    )


def _unexplained(explained: float) -> str:
    """Return in words that the forces at the samples are not those that made the motion; "" where they may be."""
    if EXPLAINED[0] <= explained <= EXPLAINED[1]:
        return ""
    size = f"{100.0 * explained:.2g} %" if explained < 1.0 else f"{explained:.3g} times"
    return (
        f"the forces at the samples make {size} of the elastic motion: they change between samples, or the body began "
        "deformed; take more samples"
    )


def _interface_forces(series: Any, body: Any, data: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return forces and moments over the size of the body, (nt, 6 k), N, on all interfaces in body axes.

    Then those of them that are reactions of joints, and the amounts of the load shapes of the body, (nt, nl).
    """
    names = [f"{body.name}.{name}" for name in data.marker_names[: data.n_interfaces]]
    *both, loads = series.wrenches(names)
    out = np.array(both).reshape(2, -1, len(names), 2, 3)
    # the axes of the body: those of its markers may be turned
    axes = Rotation.from_quat(series.coordinates(body.name)[0][:, 3:7], scalar_first=True).as_matrix()
    turned = np.einsum("tij,stkni->stknj", axes, out)
    turned[..., 1, :] /= data.quality["transfer"]["length"]
    every, reactions = turned.reshape(2, len(axes), -1)
    return every, reactions, loads[:, [series.system.load_index[body.name, name] for name in data.load_names]]


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
    known: KnownErrors,
    spectra: tuple[np.ndarray, np.ndarray, np.ndarray],
    held: np.ndarray,
    motion: float,
    within: float,
    told: tuple[bool, float, float],
    missing: str,
):
    """Return the error of a body from the spectra of its forces and other loads and its mean square motion.

    told : whether all joints hold it to the ground; the margin; how much of the motion the forces explain
    """
    frequencies, forces, _ = spectra
    power = np.sum(np.abs(forces) ** 2, axis=1)
    limit, total = known.limit, float(power.sum())
    inside = frequencies <= limit
    error = _squares(data, known, spectra, held, 0.5 * frequencies[1], told[0])
    error *= 1.0 if known.band is None else told[1] ** 2
    if not known.above:
        error[~inside] = 0.0
    if not error.any():
        return None
    unknown = max(0.0, 1.0 - told[2]) if told[2] < EXPLAINED[0] else 0.0
    motion = max(motion, error.sum() / LARGEST**2)
    share, beyond, highest = float(np.sqrt(error.sum() / motion)), 0.0, 0.0
    if total > 0.0:
        highest = float(frequencies[np.searchsorted(np.cumsum(power), MOST * total)])
        beyond = float(power[~inside].sum() / total)
    above = float(np.sqrt(error[~inside].sum() / motion))
    if not known.above:  # nothing is known of what these do: as if they did not move the body at all
        above = float(np.sqrt(beyond))
        share = max(share, above)
    share = max(share, unknown)
    tail = np.sqrt(np.maximum(error.sum() - np.cumsum(error), 0.0) / motion)
    enough = float(frequencies[int(np.argmax(tail <= SMALL * within))])
    return RunError(
        body=name,
        share=share,
        frequency=highest,
        worst=float(frequencies[int(np.argmax(error))]),
        beyond=beyond,
        limit=limit,
        by_size=known.band is None,
        above=above,
        left_out=missing,
        remedy=_remedy(data.quality, share, (highest, enough), limit, within, beyond, above),
    )


def _squares(
    data: Any,
    known: KnownErrors,
    spectra: tuple[np.ndarray, np.ndarray, np.ndarray],
    held: np.ndarray,
    slowest: float,
    on_ground: bool,
) -> np.ndarray:
    """Return the squares of the error (n,), m2, by amplitudes (n, k) of the forces and (n, l) of other loads.

    Below `slowest`, Hz, the body is taken to move as there: its rigid motion has no bound at rest.

    With phases, so that forces whose errors cancel do. What joints hold moves no other way with more modes, so that
    reactions change. Other bodies that hang on the joints may also give way, the ground does not: of the two the larger
    is told for those.
    """
    frequencies, forces, others = spectra
    if known.band is None:
        at = [np.interp(frequencies, known.frequencies, bound) for bound in known.by_input.T]
        return np.sum(np.array(at).T * np.abs(forces), axis=1) ** 2
    inside = frequencies <= known.limit
    soft, rest = np.zeros((2, *forces.shape), complex)
    parts = [(known.band, inside, soft)]
    if known.beyond is not None and known.rest is not None:
        parts += [(known.beyond, ~inside, soft), (known.rest, ~inside, rest)]
    for lines, here, out in parts:
        out[here] = lines.errors(frequencies[here], forces[here], others[here])
    stiff, stiff_rest, response = soft.copy(), rest.copy(), elastic_and_rigid(data)
    order = np.argsort(-np.sum(np.abs(soft) ** 2 + np.abs(rest) ** 2, axis=1), kind="stable")
    for n in (*order[inside[order]][:LINES], *order[~inside[order]][:LINES]) if held.any() else ():
        elastic, rigid = response(max(frequencies[n], slowest))
        for lines, here, _ in parts:
            elastic = elastic + lines.matrix_at(frequencies[n]) if here[n] else elastic
        wanted = -np.column_stack([soft[n, held], rest[n, held]])
        change = elastic[:, held] @ np.linalg.lstsq((elastic + rigid)[np.ix_(held, held)], wanted, rcond=1e-12)[0]
        stiff[n] += change[:, 0]
        stiff_rest[n] += change[:, 1]
    open_rest = np.sum(np.abs(rest) ** 2, axis=1)
    amplified = known.amplified(frequencies, open_rest)
    one = np.sum(np.abs(soft) ** 2, axis=1) + amplified
    # not both: a mode that is not known at a resonance of the held body would be that resonance once more
    two = np.sum(np.abs(stiff) ** 2 + np.abs(stiff_rest) ** 2, axis=1) + (amplified - open_rest)
    return one if one.sum() > two.sum() and not on_ground else two


def _remedy(
    quality: dict[str, Any],
    share: float,
    enough: tuple[float, float],
    limit: float,
    within: float,
    beyond: float,
    above: float,
) -> str:
    """Return what to do: more modes where the error is too large, a wider band where forces lie beyond it.

    More shapes of a basis without the static responses of the interfaces help little where joints hold these.

    Parameters
    ----------
    enough : (float, float), Hz
        Below the first lie most of the forces, below the second all of the error but a small part of the accuracy.
    """
    if share > within and quality.get("static_error", 0.0) > STATIC:
        return f"Reduce again with basis='CraigBampton': {quality['basis'].partition('(')[0]} lacks static responses"
    if beyond > UNKNOWN:
        return f"Reduce again with error_up_to={enough[0]:.3g}"
    if above > SMALL * share > SMALL * within:
        return f"Reduce again with error_up_to={max(enough):.3g}"
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
