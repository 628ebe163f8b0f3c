"""What is said about mechanisms that do not fit together: which body or joint, by how much, what to give instead."""

from __future__ import annotations

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.weights import weigh_mass
from flexmb.system.lengths import OFF, from_own_axes
from flexmb.system.mobility import constraint_matrix, mass_diagonal
from flexmb.system.observe import observe
from flexmb.system.program import constraint_acceleration, constraint_velocity, evaluate
from flexmb.system.system import System

__all__ = [
    "begins_elsewhere",
    "equations_of_forces",
    "flat_equation",
    "gaps",
    "idle_equation",
    "open_joint",
    "singular",
    "without_inertia",
    "without_value",
    "worst_equations",
]

ZERO = 1e-12
"""Relative to the largest: a smaller inertia counts as zero, a smaller gradient moves nothing."""
FLAT = 1e-9
"""A gradient of an equation of the user below this, 1 or m, is none."""
ELSEWHERE = 0.1
"""From here on a drive begins elsewhere than the drawing: relative to the model, or rad."""
CURVES = "OnCurve", "OnTrace", "OnPath", "OnStrip"
"""Equations that end: beyond the last point there is no residual."""
KNOWN = 1e-8
"""Distance to the place where an equation is satisfied, relative to the model, at which it is known."""


def worst_equations(system: System, work, count: int = 3) -> str:
    """Return the names and residuals of the equations that are satisfied worst."""
    g = work.equations["g"]
    return ", ".join(
        f"{system.equation_names[k]} = {g[k]:.3g}"
        if np.isfinite(g[k]) or np.all(np.isnan(g))
        else f"{system.equation_names[k]} has no value{_why_no_value(system, k)}"
        for k in _worst(work, count)
    )


def _worst(work, count: int = 1) -> np.ndarray:
    g = work.equations["g"]
    return np.argsort(-np.where(np.isfinite(g), np.abs(g), np.inf), kind="stable")[:count]


def _why_no_value(system: System, k: int) -> str:
    follows = any(f": {kind}" in system.equation_names[k] for kind in CURVES)
    return ", the point is beyond the end of the curve" if follows else ""


def without_value(system: System, work, *state: np.ndarray) -> str:
    """Return what of the latest evaluation is no finite number: " because of ...", or "".

    `state` are the arrays that it was evaluated at: where they are no numbers themselves, nothing can be told. An
    equation comes first, with its residual and its rate by time; then the body whose equation of motion is spoilt.
    """
    if not all(np.all(np.isfinite(x)) for x in state):
        return ""
    rows, legs = work.equations, work.legs
    sound = np.isfinite(rows["g"]) & np.isfinite(rows["rate"]) & np.isfinite(rows["drift"])
    sound[legs["equation"][~np.isfinite(legs["gradient"]).all(axis=1)]] = False
    for k in np.flatnonzero(~sound):
        numbers = f"residual {rows['g'][k]:.3g}, rate by time {rows['rate'][k]:.3g}"
        return f" because of equation '{system.equation_names[k]}', which has no value there ({numbers})"
    lost = np.flatnonzero(~np.isfinite(work.residual))
    return f" near {system.owner(int(lost[0]))}" if len(lost) else ""


def equations_of_forces(system: System, work) -> np.ndarray:
    """Return which equations have forces as multipliers, (ng,): those whose gradients have translations."""
    forces = np.zeros(system.ng, bool)
    forces[work.legs["equation"][np.any(work.legs["gradient"][:, :3], axis=1)]] = True
    return forces


def gaps(system: System, work) -> dict[str, tuple[float, float]]:
    """Return the residuals by joint: the largest of its distances, m, and of its angles, rad."""
    g = np.where(np.isfinite(work.equations["g"]), np.abs(work.equations["g"]), np.inf)
    for k, name in enumerate(system.equation_names):
        if name.endswith(": Formula"):  # its residual is no length: what Newton's method would close
            own = np.max(np.abs(work.legs["gradient"][work.legs["equation"] == k]), initial=0.0)
            g[k] = 0.0 if system.program.equation_level[k] == 1 else g[k] / (own if own > FLAT else 1.0)
    lengths = equations_of_forces(system, work)

    def widest(span: slice, of: np.ndarray) -> float:
        return float(np.max(g[span][of[span]], initial=0.0))

    return {name: (widest(span, lengths), widest(span, ~lengths)) for name, span in system.joint_equations.items()}


def open_joint(system: System, work, t: float) -> CompileError:
    """Return the error that names the joint that stays open most, and a drive that begins elsewhere than it is drawn.

    t : time of the start, s.
    """
    name, (metres, radians) = max(gaps(system, work).items(), key=lambda item: max(item[1]))
    turned = f" and {radians:.3g} rad" if radians > 0.0 else ""
    is_open = f"stays open by {metres:.3g} m{turned}"
    if not np.isfinite(metres + radians):
        failed = _failed_function(system)
        if failed is not None:
            return failed
        formula = "Formula" in system.equation_names[system.joint_equations[name].start]
        is_open = "has no value (nan)" if formula else "has its point beyond the end of its curve"
    redundant = f"; {len(system.redundant)} equations depend on others" if system.redundant else ""
    allowed = f", those that depend on others to {system.gaps.max():.2g} m or rad" if system.redundant else ""
    told = any(system.equation_names[k].endswith(": Formula") for k in _worst(work))  # no markers that could be moved
    worst, asked = worst_equations(system, work), begins_elsewhere(system, t)
    remedy = (
        "A drive prescribes the coordinate of its joint, not a way from the drawing: add to its signal what the joint "
        "has as drawn, or draw the parts where the drive begins"
        if asked
        else "Bring the markers of this loop into one plane or line, or replace one of its joints by one that forbids "
        "less (Spherical, Cylindrical, Universal)"
        if system.redundant and not told
        else "Start where the equation has a value: no division by zero, no root or logarithm of what is not positive"
        if told and not np.isfinite(metres + radians)
        else "These equations contradict each other, or one of them cannot be satisfied alone: remove one, or make "
        "their numbers agree"
        if system.redundant
        else "Check lengths and marker positions of these joints, or move the parts nearer to their places"
    )
    return CompileError(
        f"Model '{system.model.name}'",
        found=f"the mechanism cannot be assembled: joint '{name}' {is_open}{redundant}; "
        f"worst equations: {worst}{'; ' * bool(asked)}{asked}",
        expected=f"positions near the described ones that satisfy all joints{allowed}",
        remedy=remedy,
    )


def begins_elsewhere(system: System, t: float) -> str:
    """Return words about the drive whose place at the time t, s, is farthest from the drawing; none if it is near."""
    work = system.workspace()
    evaluate(system.program, system.state(t), work)
    apart = {name: gap for name, gap in gaps(system, work).items() if system.model.joint(name).prescribes}
    far = {name: max(metres / system.lengths.whole, radians) for name, (metres, radians) in apart.items()}
    name = max(far, key=lambda one: far[one], default="")
    if not name or not ELSEWHERE < far[name] < np.inf:
        return ""
    metres, radians = apart[name]
    distance = f"{metres:.3g} m" if metres > 0.0 else f"{radians:.3g} rad"
    return f"{system.model.joint(name).title} begins at t = {t:g} s {distance} away from the drawing"


def _failed_function(system: System) -> CompileError | None:
    """Return the error about a function of the user that failed, if one did: no mechanism is to blame then."""
    for joint in system.model.joints:
        why = getattr(joint, "complaint", str)()
        if why:
            return CompileError(
                joint.title,
                found=f"the function of joint '{joint.name}' has no value: {why}",
                expected="a finite number with derivatives at every place that the motion may reach",
                remedy="Correct the function, or its Jacobian",
            )
    return None


def flat_equation(system: System, state, work) -> CompileError | None:
    """Return the error about an equation of the user whose gradient vanishes where it is satisfied, if there is one.

    The square of a length that should be zero: it has one direction beside the place, and none at it. Newton's method
    then creeps, and ends where the residual is small but not yet the distance to the place, residual over gradient.
    """
    speeds = np.zeros(system.ng)
    constraint_velocity(work, state.u, speeds)
    for k, name in enumerate(system.equation_names):
        if not name.endswith(": Formula"):
            continue
        legs = work.legs["equation"] == k
        own = np.max(np.abs(work.legs["gradient"][legs]), initial=0.0)
        left = abs(work.equations["g"][k]) if system.program.equation_level[k] == 0 else 0.0
        if own <= FLAT or left > KNOWN * system.lengths.whole * own:
            left = work.equations["g"][k] if system.program.equation_level[k] == 0 else speeds[k]
            return CompileError(
                f"Equation '{name}'",
                found=f"it has no gradient at the start (largest entry {own:.2g}, residual {left:.2g}): it restricts "
                "nothing there, and more beside it",
                expected="an equation whose gradient is about 1 where it is satisfied",
                remedy="Write x = 0 for x**2 = 0, two equations for x**2 + y**2 = 0; start away from such a place; "
                "multiply an equation of very small numbers",
            )
    return None


def idle_equation(system: System, state, work) -> CompileError | None:
    """Return the error about an equation that is not satisfied and that no small motion changes, if there is one.

    Two axes should be perpendicular and are drawn parallel: no direction is better than another.
    """
    work.weights[0].wanted = 0
    evaluate(system.program, state, work)
    for k in np.flatnonzero(np.abs(work.equations["g"]) >= 0.5):
        gradients = work.legs["gradient"][work.legs["equation"] == k]
        if np.max(np.abs(gradients), initial=0.0) > 1e-6:
            continue
        joint = system.model.joints[system.equation_owners[k][0]]
        told = system.equation_owners[k][1].idle(*joint.resolved_markers(system.model)[:2])
        if told is not None:
            found, expected, remedy = told
            return CompileError(joint.title, found=found, expected=expected, remedy=remedy)
    return None


def singular(system: System, state, work, place: int) -> CompileError:
    """Return the error that names the force that is not finite, or else the body or equation without pivot."""
    unknown_force = _without_number(system, state)
    if unknown_force is not None:
        return unknown_force
    endless = _without_rate(system, state, work)
    if endless is not None:
        return endless
    unknown = int(system.program.pattern.order[max(place, 0)])
    if unknown >= system.nu:
        formula = _idle_formula(system, state, work, unknown - system.nu)
        if formula is not None:
            return formula
        return CompileError(
            system.owner(unknown),
            found="the equations of motion are singular: it contradicts or repeats others",
            expected="equations that are independent of the other joints here",
            remedy="Replace this joint by one that forbids less, or remove a drive of the same loop",
        )
    return without_inertia(system, state, work, unknown)


def _idle_formula(system: System, state, work, k: int) -> CompileError | None:
    """Return the error about an equation of the user that stays open where no motion changes it, if `k` is one."""
    name = system.equation_names[k]
    if not name.endswith(": Formula"):
        return None
    weigh_mass(work.weights)
    evaluate(system.program, state, work)
    left = float(work.equations["g"][k])
    own = float(np.max(np.abs(work.legs["gradient"][work.legs["equation"] == k]), initial=0.0))
    if not abs(left) > KNOWN * max(system.lengths.whole * own, FLAT):
        return None
    return CompileError(
        f"Equation '{name}'",
        found=f"its residual stays open by {left:.3g} where the search ends (largest entry of its gradient {own:.2g})",
        expected="an equation that the bodies can satisfy near their described places",
        remedy="Correct the equation and its numbers (p**2 = -1 has no solution), or start nearer to where it holds",
    )


def _without_rate(system: System, state, work) -> CompileError | None:
    """Return the error about an equation whose first or second rate is no finite number, if there is one."""
    weigh_mass(work.weights)
    evaluate(system.program, state, work)
    first, second = np.zeros((2, system.ng))
    constraint_velocity(work, state.u, first)
    constraint_acceleration(work, np.zeros(system.nu), second)
    for rates, which in ((first, "rate"), (second, "second rate")):
        endless = np.flatnonzero(~np.isfinite(rates) & np.isfinite(work.equations["g"]))
        if len(endless):
            return CompileError(
                f"Equation '{system.equation_names[endless[0]]}'",
                found=f"its {which} is no finite number at t = {state.t:.6g} s",
                expected="an equation, and signals in it, with two finite rates by time",
                remedy="Use signals that begin smoothly: t**0.5 has an infinite rate at t = 0, smooth(t/T) has none; "
                "start away from places such as sqrt(0)",
            )
    return None


def _without_number(system: System, state) -> CompileError | None:
    """Return the error that names a force whose value at the state is no finite number, if there is one."""
    still = [np.zeros((1, n)) for n in (system.nu, system.ng)]
    force = observe(system, [state.t], state.q[None], state.u[None], *still).force[0]
    for part in system.model.forces:
        wrench = force[system.force_index[part.name]]
        if not np.all(np.isfinite(wrench)):
            text = np.array2string(wrench, precision=4)
            return CompileError(
                part.title,
                found=part.complaint() or f"its force and moment are {text} at t = {state.t:.6g} s",
                expected="finite numbers, N and N m",
                remedy="Correct its signals, its function or its table",
            )
    return None


def _heavy_by_itself(system: System, state, work, span: slice) -> bool:
    """Has a body inertia in all of its velocities if no force follows accelerations?"""
    program = system.program._replace(forces=system.program.forces[:0])
    weigh_mass(work.weights)
    evaluate(program, state, work)
    own = constraint_matrix(system, work)[0].toarray()[span, span]
    diagonal = np.diag(own)
    if not np.all(diagonal > 0.0):
        return False
    return bool(np.linalg.svd(own / np.sqrt(np.outer(diagonal, diagonal)), compute_uv=False)[-1] > ZERO)


def without_inertia(system: System, state, work, unknown: int) -> CompileError:
    """Return the error that names the body that has no inertia in one of its velocities, which no joint holds."""
    weigh_mass(work.weights)
    evaluate(system.program, state, work)
    inertia = np.abs(mass_diagonal(system, work))
    spans = {body: system.body_slices[body.name][1] for body in system.model.bodies}
    of_bodies = [(b, span.start) for b, span in spans.items() if span.start <= unknown < span.stop]
    if not of_bodies:
        return CompileError(
            system.owner(unknown),
            found=f"the rate of its state is no finite number at t = {state.t:.6g} s",
            expected="states with finite rates",
            remedy="Correct its numbers and signals",
        )
    body, first = of_bodies[0]
    own = slice(first, first + (6 if body.has_frame else body.n_velocities))
    if system.implicit and _heavy_by_itself(system, state, work, own):
        return CompileError(
            body.title,
            found="the equations of motion are singular: forces that follow accelerations take its inertia away",
            expected="a regular mass matrix: a force -k a on a mass m makes it m + k, and F = m a leaves no equation "
            "for the acceleration",
            remedy="Lower the gain of the acceleration, or sample it (Sampled)",
        )
    if not body.has_frame or unknown - first >= 6:
        return CompileError(
            body.title,
            found=f"the equations of motion are singular: its coordinate {unknown - first} has no inertia",
            expected="mass in every coordinate, or joints that hold it",
            remedy="Give it mass, or check the mass matrix of its data, or its density",
        )
    if not inertia[first : first + 3].any() and unknown - first < 3:
        return CompileError(
            body.title,
            found="the equations of motion are singular: no mass",
            expected="mass > 0 kg, or joints that hold the body in all directions",
            remedy=f"Give {body.title} a mass, or fix it to its neighbour",
        )
    about = [
        f"its {axis}-axis"
        for axis, m in zip("xyz", inertia[first + 3 : first + 6], strict=True)
        if m <= ZERO * inertia[first + 3 : first + 6].max()
    ]
    if not about:
        about = [f"its {'xyz'[(unknown - first) % 3]}-axis"]
    away, size = from_own_axes(body)
    if away > OFF * size:
        return CompileError(
            body.title,
            found=f"the equations of motion are singular: it is {away:.3g} m from its own axes, {away / size:.2g} "
            f"times its size, and the digits of its inertia about {' and '.join(about)} are lost",
            expected="axes near the body",
            remedy="Move its data, data.translated(...), and the body back to its place, at=...",
        )
    return CompileError(
        body.title,
        found=f"the equations of motion are singular: no inertia about {' and '.join(about)}",
        expected="moments of inertia > 0 about all three axes, or joints that forbid these turns",
        remedy=f"Give {body.title} inertia=(Jxx, Jyy, Jzz) in kg m2, or make it by RigidBody.rod(radius=...), .box, "
        ".cylinder; a mass without size is a PointMass",
    )
