"""Sections of a report that say what was simulated and how: model, mobility, modes, solver."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from flexmb.errors import duration
from flexmb.io.web_page import percent, table, vector
from flexmb.model.mode_table import mode_table
from flexmb.results.reduction_error import run_errors
from flexmb.view.quantities import number
from flexmb.view.report_results import Run

__all__ = ["counted", "differences", "mobility", "model", "modes", "notices", "parameters", "solver"]

MODES = 12
WARNINGS = ("share of validity", "warnings")  # statistics that are no plain numbers


def notices(runs: Sequence[Run], checks: Mapping[str, Any]) -> str:
    """What needs attention: runs that did not reach their end, warnings, dependent equations, events."""
    found = []
    for run in runs:
        solution, name = run.solution, f"{run.name}: " if len(runs) > 1 else ""
        if not solution.status.ok:
            found.append(name + str(solution.status))
        found += [name + text for text in solution.statistics.get("warnings", ())]
        found += [name + text for text in _of_reductions(solution.model)]
        found += [f"{name}{error}. {error.remedy}" for error in run_errors(solution) if error.remedy]
        report = checks.get(run.name)
        if report is not None and report.redundant:
            shared = ", ".join(f"'{joint}'" for joint in solution.shared_reactions)
            unique = f"the reactions of {shared} are not unique" if shared else "all reactions are unique"
            found.append(f"{name}{len(report.redundant)} dependent equations; {unique}")
    events = [
        f"{run.name + ': ' if len(runs) > 1 else ''}event '{phase.ended}' at t = {phase.t[-1]:.6g} s"
        for run in runs
        for phase in run.solution.phases[:-1]
    ]
    boxes = [f'<div class="warning">{escape(text)}</div>' for text in found]
    boxes += [f'<div class="event">{escape(text)}</div>' for text in events]
    return "".join(boxes) or '<div class="fine">Reached its end without a warning.</div>'


def _of_reductions(described) -> list[str]:
    """Return the warnings of the quality reports of all reduced bodies; equal bodies are named together."""
    found: dict[str, list[str]] = {}
    for body in described.bodies if described is not None else ():
        data = getattr(body, "reduced", None)
        for text in data.quality.get("warnings", ()) if data is not None else ():
            found.setdefault(text, []).append(body.name)
    return [f"Reduction of {', '.join(names)}: {text}" for text, names in found.items()]


def model(described) -> str:
    """Bodies, joints and forces."""
    bodies = [[escape(b.name), type(b).__name__, *_mass(b)] for b in described.bodies]
    titles = [("body", True), ("kind", True), ("mass kg", False), ("flexible coordinates", False), ("nodes", False)]
    parts = ["<h2>Model</h2>", table(titles, bodies)]
    joints = [[escape(j.name), type(j).__name__, escape(_between(j))] for j in described.joints]
    parts.append(_folded(counted(len(joints), "joint"), [("joint", True), ("kind", True), ("between", True)], joints))
    forces = [[escape(f.name), type(f).__name__, escape(_between(f))] for f in described.forces]
    parts.append(_folded(counted(len(forces), "force"), [("force", True), ("kind", True), ("acts on", True)], forces))
    gravity = f"Gravity {vector(described.gravity)} m/s2." if any(described.gravity) else "No gravity."
    parts.append(f'<p class="note">{gravity}</p>')
    return "".join(parts)


def _mass(body) -> list[str]:
    data = getattr(body, "reduced", None)
    if data is not None:
        return [number(data.mass), str(data.n_modes), str(len(data.nodes))]
    mass = getattr(body, "mass", None)
    return ["" if mass is None else number(float(mass)), "", ""]


def _between(part) -> str:
    places = getattr(part, "markers", None) or getattr(part, "through", None) or (getattr(part, "marker", None),)
    if isinstance(places, Sequence) and not isinstance(places, str) and any(places):
        return ", ".join(str(place) for place in places if place)
    others = getattr(part, "joints", None) or (getattr(part, "joint", None) or getattr(part, "body", None),)
    return ", ".join(str(other) for other in others if other)


def _folded(summary: str, titles, rows) -> str:
    if not rows:
        return ""
    return f"<details><summary>{escape(summary)}</summary>{table(titles, rows)}</details>"


def counted(n: int, what: str) -> str:
    return f"{n} {what}" if n == 1 else f"{n} {what}s"


def parameters(described) -> str:
    """The parameters of the model file."""
    rows = [[escape(name), escape(_value(value))] for name, value in described.parameters.items()]
    return _folded(counted(len(rows), "parameter"), [("parameter", True), ("value", True)], rows)


def _value(value: Any) -> str:
    if isinstance(value, tuple | list):
        text = ", ".join(_value(entry) for entry in value[:6])
        return f"[{text}{', ...' if len(value) > 6 else ''}]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def differences(runs: Sequence[Run]) -> str:
    """The parameters in which the runs differ."""
    known = [dict(run.solution.model.parameters) if run.solution.model else {} for run in runs]
    names = dict.fromkeys(name for own in known for name in own)
    rows = [
        [escape(name), *(escape(_value(own[name])) if name in own else "" for own in known)]
        for name in names
        if len({repr(own.get(name)) for own in known}) > 1
    ]
    if not rows:
        return '<h2>Differences</h2><p class="note">All parameters are equal.</p>'
    titles = [("parameter", True), *((run.name, False) for run in runs)]
    return "<h2>Differences</h2>" + table(titles, rows)


def mobility(runs: Sequence[Run], checks: Mapping[str, Any]) -> str:
    """Degrees of freedom, and the names of dependent equations."""
    known = [(run, checks[run.name]) for run in runs if run.name in checks]
    if not known:
        return ""
    titles = [("run", True), ("velocities", False), ("equations", False), ("mobility", False)]
    titles += [("Grübler-Kutzbach", False), ("dependent", False), ("assembly error", False)]
    rows = [
        [
            escape(run.name),
            str(r.velocities),
            str(r.equations),
            str(r.mobility),
            str(r.gruebler),
            str(len(r.redundant)),
            f"{r.assembly_error:.1e}",
        ]
        for run, r in known
    ]
    more = [
        _folded(f"{run.name}: dependent equations", [("equation", True)], [[escape(name)] for name in r.redundant])
        for run, r in known
    ]
    note = (
        '<p class="note">Mobility: true degrees of freedom at the start, flexible bodies included. Dependent '
        "equations: reactions of least norm are given.</p>"
    )
    return "<h2>Mobility</h2>" + table(titles, rows) + note + "".join(more)


def _damping_shares(body) -> np.ndarray:
    """Return the fraction of critical damping of every coordinate alone, (m,): D_jj / (2 sqrt(k_jj m_jj)).

    What counts is the body in its model: the damping proposed at reduction and the body's own.
    """
    data = body.reduced
    critical = 2.0 * np.sqrt(np.maximum(np.diag(data.stiffness), 0.0) * np.diag(data.invariants.nn))
    own = np.diag(body.damping_matrix())
    return np.divide(own, critical, out=np.zeros(len(own)), where=critical > 0.0)


def modes(described) -> str:
    """The lowest flexible coordinates of every reduced body."""
    parts = []
    for body in described.bodies:
        data = getattr(body, "reduced", None)
        if data is None or not data.n_modes:
            continue
        rows = []
        for row, damping in zip(mode_table(data)[:MODES], _damping_shares(body)):
            moves = sorted(row["effective_mass"].items(), key=lambda item: -item[1])
            masses = ", ".join(f"{escape(name)} {percent(share)}" for name, share in moves[:2] if share >= 0.001)
            rows.append(
                [
                    str(row["number"]),
                    f"{row['frequency']:.5g}",
                    escape(row["kind"]),
                    escape(row["interface"]),
                    percent(float(damping), 2),
                    percent(row["compliance"]),
                    masses,
                ]
            )
        titles = [("no.", False), ("frequency Hz", False), ("kind", True), ("interface", True), ("damping", False)]
        titles += [("compliance", False), ("effective mass", True)]
        more = f", the first {MODES} of {data.n_modes}" if data.n_modes > MODES else ""
        parts.append(f"<h3>{escape(body.name)}{more}</h3>" + table(titles, rows))
    if not parts:
        return ""
    return (
        '<h2>Modes of flexible bodies</h2><p class="note">Free body. Compliance: share of the static deflection of the '
        "interfaces under unit loads.</p>" + "".join(parts)
    )


def solver(runs: Sequence[Run]) -> str:
    """Statistics of the integrators, and how exactly the constraints are held."""
    kept = dict.fromkeys(name for run in runs for name in run.solution.statistics if name not in (*WARNINGS, "seconds"))
    by_part = [name for name in kept if any(isinstance(run.solution.statistics.get(name), dict) for run in runs)]
    names = [name for name in kept if name not in by_part]
    titles = [("", True), *((run.name, False) for run in runs)]
    rows = [
        ["samples", *(str(len(run.solution.t)) for run in runs)],
        ["last sample, s", *(f"{run.solution.t[-1]:.6g}" for run in runs)],
        *([escape(name), *(escape(_value(run.solution.statistics.get(name, ""))) for run in runs)] for name in names),
        ["largest residual of the constraints", *(f"{_residual(run.solution):.1e}" for run in runs)],
        ["computing time", *(_seconds(run.solution) for run in runs)],
    ]
    shares = [
        [escape(run.name), escape(title), ", ".join(f"{escape(name)} {_share(x)}" for name, x in measures.items())]
        for run in runs
        for title, measures in run.solution.statistics.get("share of validity", {}).items()
    ]
    held = table([("run", True), ("body", True), ("share of its limits", True)], shares) if shares else ""
    states = "".join(f'<p class="note">{escape(run.name)}: {escape(str(run.solution.status))}</p>' for run in runs)
    return "<h2>Solver</h2>" + table(titles, rows) + "".join(_of_parts(runs, name) for name in by_part) + states + held


def _of_parts(runs: Sequence[Run], name: str) -> str:
    """Return a statistic that has a share for each of several parts, a line for each."""
    found = [given if isinstance(given := run.solution.statistics.get(name), dict) else {} for run in runs]
    parts = dict.fromkeys(part for of_run in found for part in of_run)
    rows = [
        [escape(str(part)), *(_share(of_run[part]) if part in of_run else "" for of_run in found)] for part in parts
    ]
    return table([(name, True), *((run.name, False) for run in runs)], rows)


def _share(x: Any) -> str:
    """Return a share in percent; what a file has instead of a number, as text."""
    return percent(x) if isinstance(x, int | float) else escape(str(x))


def _residual(solution) -> float:
    known = [k for k, phase in enumerate(solution.phases) if phase.model is not None]
    return max((float(np.max(solution.series(k).constraint_error[:, 0], initial=0.0)) for k in known), default=np.nan)


def _seconds(solution) -> str:
    seconds = solution.statistics.get("seconds")
    return duration(float(seconds)) if isinstance(seconds, int | float) else escape(str(seconds or ""))
