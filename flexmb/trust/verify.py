"""`verify`: a second opinion about a solution."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError, ModelError
from flexmb.integrate import NullSpace, accelerations
from flexmb.integrate.impulsive import rigid_contacts
from flexmb.math.weights import weigh_mass
from flexmb.model.described import is_number
from flexmb.results import Solution
from flexmb.results.reduction_error import run_errors
from flexmb.system.mobility import constraint_matrix, mass_metric
from flexmb.system.program import evaluate
from flexmb.tree import Recursive
from flexmb.trust.answers import Difference, differences, quantities, turned_over
from flexmb.trust.checks import constraint_check, of_equations, of_impulses
from flexmb.trust.levels import constraint_levels
from flexmb.trust.reruns import Rerun, reruns, whole_window
from flexmb.trust.settings import of_solution
from flexmb.trust.verification import Answer, Check, Verification

__all__ = ["verify"]

SAMPLES = 7
"""Samples of every phase at which equations are looked at."""
REST = 1e-9
"""Accelerations, relative to those that the loads would give to free bodies, that are rounding of a model at rest."""
STILL = 1e-12
"""The same of energies, relative to what is stored and to the work of the loads along the length of the model."""
DENSE = 200
"""Unknowns up to which accelerations are compared by a null space, beyond by recursion."""


def verify(
    solution: Solution,
    *,
    within: float = 0.01,
    integrator: Any = None,
    window: tuple[float, float] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Verification:
    """Return how far a solution can be trusted, found by ways that its integrator has not gone.

    Of the solution itself, at samples: equations of motion of every body from its energies, accelerations by another
    formulation, constraints at three levels by differences along the motion, the balance of energy. Of its
    answers (the sensors): what changes with a tenth of the tolerance, by another integrator, with other modes of
    reduced bodies, with twice the elements of cables and beams. So it costs about ten times the run. With rigid
    contacts the equations are looked at in the middle of steps, and laws of contact instead of accelerations; no other
    integrator repeats the run.

    Parameters
    ----------
    solution : Solution
        With its model, in memory or from a run folder.
    within : float
        Tolerance of an answer, as a share of what it varies by, or of its largest value where that is smaller; also
        the limit for unexplained forces and energy.
        Constraints must hold within a hundredth of it.
    integrator : integrator, optional
        By which the solution was made; one of `simulate` knows it.
    window : (float, float), s, optional
        Where another integrator repeats the run; default: all of it, of a run with more than 20 000 steps a tenth
        about its fastest motion.
    progress : callable (text), optional
        Called with a text for each stage.

    Raises
    ------
    ModelError
        The model is not known, or an argument is wrong.
    """
    _require(solution, within, window)
    told = progress or (lambda text: None)
    told("the equations at samples")
    used = of_solution(solution, integrator)
    checks, notes = _of_itself(solution, within, used)
    if not solution.status.ok:
        notes.append(f"the run ended early ({solution.status}); the computed part is checked")
    if used is None:
        notes.append(
            "no other runs: the solution does not say by which integrator it was made (an equilibrium and a prescribed "
            "motion have none); give integrator=..."
        )
        return _finished(solution, within, checks, [], notes)
    found = []
    told("a tenth of the tolerance")
    for rerun in reruns(solution, used, whole_window(solution, window)):
        found.append(rerun)
        told(f"{rerun.what}: done")
    return _finished(solution, within, checks, found, notes)


def _require(solution: Any, within: Any, window: Any) -> None:
    if not isinstance(solution, Solution):
        raise ModelError(
            "verify",
            found=f"an object of the class {type(solution).__name__}",
            expected="a Solution",
            remedy='Give what simulate returned, or flexmb.Solution.load("run/solution.h5", ...)',
        )
    if any(phase.model is None for phase in solution.phases):
        raise ModelError(
            "verify",
            found="the model of the solution is not known",
            expected="a solution with its model",
            remedy="Load it with Solution.load(path, read_model=flexmb.read_model_text)",
        )
    if not is_number(within) or not 0.0 < within < 1.0:
        raise ModelError(
            "verify",
            found=f"within = {within!r}",
            expected="a share between 0 and 1",
            remedy="Write within=0.01 for one percent",
        )
    if "points" in solution.statistics:
        raise ModelError(
            "verify",
            found="the solution is a path of equilibria under growing loads",
            expected="a simulation, or an equilibrium under the whole load",
            remedy="Look at the path with other load steps, and at its last point by statics",
        )
    if any(phase.inputs is not None and phase.inputs.size for phase in solution.phases):
        raise ModelError(
            "verify",
            found="a run with inputs that were set from outside, which no other run repeats",
            expected="a run that depends on its model and its start alone",
            remedy="Repeat the steps with a tighter integrator and compare, or verify a simulation in which tables "
            "stand for the inputs",
        )
    first, last = solution.t[0], solution.t[-1]
    if window is not None and not (
        len(np.atleast_1d(window)) == 2 and all(map(is_number, window)) and first <= window[0] < window[1] <= last
    ):
        raise ModelError(
            "verify",
            found=f"window = {window!r}",
            expected=f"two times from {first:g} to {last:g} s",
            remedy="Write window=(0.2, 0.4)",
        )


def _rests(phase) -> bool:
    """Are its samples equilibria, or the iterations that led to one?"""
    return not np.any(phase.u) and not np.any(phase.a)


def _samples(phase) -> list[int]:
    """Return some samples of a phase; its ends, where loads may jump, are left out if there are others.

    Of an equilibrium the last: those before are the iterations that led there.
    """
    last = len(phase.t) - 1
    if _rests(phase):
        return [last]
    inner = range(1, last) if last > 1 else range(last + 1)
    places = np.linspace(inner[0], inner[-1], min(SAMPLES, len(inner)))
    return sorted({round(x) for x in places})


def _of_itself(solution: Solution, within: float, used: Any) -> tuple[list[Check], list[str]]:
    """Return the checks of the solution itself: of every kind the worst over all phases; and what was left out."""
    found: list[Check] = []
    notes: list[str] = []
    for number, phase in enumerate(solution.phases):
        system, samples = solution.series(number).system, _samples(phase)
        if rigid_contacts(phase.model):
            checks, left_out = of_impulses(solution, number, samples, used, within)
            found += checks
            notes += left_out
        else:
            found += of_equations(phase, system, samples, within, notes)
            found += [constraint_check(r, within) for r in constraint_levels(phase, system, samples)]
            found += _by_formulation(phase, system, samples, within, notes)
        found += _energy(solution, number, within)
    found += _reductions(solution, within)
    worst: dict[str, Check] = {}
    for check in found:
        if check.name not in worst or check.share > worst[check.name].share:
            worst[check.name] = check
    return list(worst.values()), list(dict.fromkeys(notes))


def _reductions(solution: Solution, within: float) -> list[Check]:
    """Return what the reduction of each body costs, where its data tell the error of the response."""
    return [
        Check(
            name=f"reduction of {error.body}",
            share=error.share,
            limit=within,
            worst=". ".join(filter(None, (f"mostly at {error.worst:.3g} Hz", error.remedy, error.left_out))),
        )
        for error in run_errors(solution, within)
    ]


def _by_formulation(phase, system, samples, within, notes) -> list[Check]:
    """Compare accelerations with another formulation, relative to the largest of all samples and freedoms."""
    formulation = NullSpace() if system.nu + system.ng <= DENSE else Recursive()
    free, _ = _of_loads(phase, system, samples)
    # in an equilibrium, what is left of the loads; in a motion that is none, rounding
    largest = max(float(np.abs(phase.a[samples]).max(initial=0.0)), free if _rests(phase) else REST * free)
    apart, body, at = 0.0, "", 0.0
    try:
        for k in samples:
            other = accelerations(phase.model, state=phase.instant(k), formulation=formulation)
            left = np.abs(other.a - phase.a[k])
            if left.max(initial=0.0) > apart:
                apart, at = float(left.max()), float(phase.t[k])
                body = system.owner(int(np.argmax(left)))
    except FlexmbError as error:
        notes.append(f"no accelerations by {type(formulation).__name__}: {error}")
        return []
    share = apart / largest if largest > 0.0 else 0.0
    where = f"{body} at {at:.6g} s, by {type(formulation).__name__}" if body else type(formulation).__name__
    return [Check(name="accelerations", share=share, limit=within, worst=where)]


def _of_loads(phase, system, samples) -> tuple[float, float]:
    """Return the largest acceleration that the loads would give to free bodies (m/s2, rad/s2), and their work along the
    length of the model or a radian (J).
    """
    work, free, energy = system.workspace(), 0.0, 0.0
    lengths = 1.0 / np.where(system.units > 0.0, system.units, 1.0)
    for k in samples:
        state = system.state(phase.t[k], phase.q[k], phase.u[k])
        weigh_mass(work.weights)
        evaluate(system.program, state, work)
        loads = np.abs(work.residual)
        free = max(free, float(np.max(loads / mass_metric(constraint_matrix(system, work)[0]), initial=0.0)))
        energy = max(energy, float(np.sum(loads * lengths)))
    return free, energy


def _energy(solution: Solution, number: int, within: float) -> list[Check]:
    """Compare the change of energy in a phase with the works, relative to all that was turned over in it."""
    series = solution.series(number)
    energy, works = series.energy, series.works
    if len(energy) < 2 or _rests(solution.phases[number]):
        return []
    total = energy.sum(axis=1)
    gained = works[:, 0] + works[:, 1] - works[:, 2]
    left = np.abs((total - total[0]) - (gained - gained[0]))
    phase = solution.phases[number]
    standing = float(np.abs(energy).max()) + _of_loads(phase, series.system, _samples(phase))[1]
    turned = max(turned_over(solution, number), STILL * standing)
    if turned <= 0.0:
        return []
    k = int(np.argmax(left))
    where = f"{left[k]:.3g} J of {turned:.3g} J turned over at {series.t[k]:.6g} s"
    return [Check(name="energy that nothing explains", share=float(left[k] / turned), limit=within, worst=where)]


def _finished(solution, within, checks, found: list[Rerun], notes) -> Verification:
    course: dict[tuple[str, str], dict[str, float]] = {}
    peak: dict[tuple[str, str], dict[str, float]] = {}
    worst: dict[tuple[str, str], Difference] = {}
    for rerun in found:
        if rerun.solution is None:
            notes.append(f"no comparison: {rerun.what}: {rerun.failure}")
            continue
        for key, apart in differences(solution, rerun.solution).items():
            course.setdefault(key, {})[rerun.name] = apart.course
            peak.setdefault(key, {})[rerun.name] = apart.peak
            worst[key] = max(worst.get(key, apart), apart)
    known = {rerun.name for rerun in found}
    flexible = [b.name for b in solution.model.bodies if b.reduced is not None and b.reduced.n_modes]
    if found and flexible:
        notes.append(f"meshes behind the reduced data of {', '.join(flexible)} are not known here: reduce a finer one")
    grids = [
        b.name for b in solution.model.bodies if getattr(b, "elements", None) is not None or hasattr(b, "thickness")
    ]
    if found and grids and "mesh" not in known:
        notes.append(f"the mesh of {', '.join(grids)} was not varied: simulate with twice the elements")
    answers = [
        Answer(
            name=q.name,
            unit=q.unit,
            largest=q.largest,
            course=course.get((q.name, q.unit), {}),
            peak=peak.get((q.name, q.unit), {}),
            within=within,
            component=worst[q.name, q.unit].title if (q.name, q.unit) in worst else "",
            scale=worst[q.name, q.unit].scale if (q.name, q.unit) in worst else 0.0,
        )
        for q in quantities(solution)
    ]
    runs = tuple(rerun.what for rerun in found if rerun.solution is not None)
    return Verification(
        model=solution.model.name,
        within=float(within),
        checks=tuple(checks),
        answers=tuple(answers) if found else (),
        runs=runs,
        notes=tuple(notes),
    )
