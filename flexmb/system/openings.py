"""What assembly changes of a drawing: joints that it closes over a distance, velocities that joints do not allow."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmb.errors import CompileError
from flexmb.math.rotations import euler_to_matrix
from flexmb.math.tables import State
from flexmb.math.weights import no_matrix
from flexmb.system.assembly import assemble
from flexmb.system.complaints import gaps
from flexmb.system.fit import misfits, require_fit
from flexmb.system.program import constraint_velocity, evaluate
from flexmb.system.system import System
from flexmb.told import tell as say

__all__ = ["assemble_as_drawn", "openings"]

OPEN = 0.01
"""Gap of a joint as drawn, above which a warning is given: relative to the size (lengths) or in turns (angles)."""
WRONG = 0.1
"""Gap from which on the drawing is hardly what was meant, relative to the size: nothing is computed with it."""
WRONG_TURN = 0.2
"""Angle, rad, from which on the same holds: a body as long as the model that turns about its middle by so much moves
its ends by the gap that is wrong. Axes that are mistaken for each other differ by far more."""
ROUNDED = 1e-12
"""Of the size, or rad: a gap that is not worth a number."""
CHANGED = 0.01
"""Relative change of a described velocity from which on a warning is given."""


def _warn(sentences: list[str]) -> None:
    for sentence in sentences:
        say(sentence)


def assemble_as_drawn(
    model, *, t: float = 0.0, tell: Callable[[list[str]], None] = _warn, stuck: list[CompileError] | None = None
) -> tuple[System, State]:
    """Assemble a model from its description, and return its system and consistent start.

    Parameters
    ----------
    model : Model
    t : float, s
        Time of the start.
    tell : callable (sentences), optional
        Takes what is worth knowing about the drawing; without it, that is warned of.
    stuck : list, optional
        See `assemble`.

    Raises
    ------
    CompileError
        If an elastic body does not fit the markers that joints put its interfaces to, or if a joint is described open
        by more than a tenth of the model's size, or by more than 0.2 rad. Assembly would move the bodies all the
        same, and every number that follows would look sound. As `assemble` besides.
    """
    require_fit(model)
    system, state = assemble(model, t=t, stuck=stuck)
    size = system.lengths.whole
    work = system.workspace()
    for name, metres, radians in sorted(_drawn_open(system, work, t), key=lambda found: max(found[1:]), reverse=True):
        if metres > WRONG * size or radians > WRONG_TURN:
            raise _wrongly_drawn(system, work, name, metres, radians)
    tell(misfits(model) + openings(system, state))
    return system, state


def _wrongly_drawn(system: System, work, name: str, metres: float, radians: float) -> CompileError:
    """Return the error about a joint that is drawn so far open that its parts cannot be meant to be there."""
    joint, size, own = system.model.joint(name), system.lengths.whole, _own_equation(system, work, name)
    markers = dict.fromkeys(joint.resolved_markers(system.model))
    if metres > WRONG * size:
        places = ", ".join([*filter(None, [own]), *(f"'{m}' at {_place(system, m)}" for m in markers)])
        return CompileError(
            joint.title,
            found=f"as described it is open by {metres:.3g} m: {places}; the model is {size:.3g} m in size",
            expected=f"less than {WRONG:g} of that: bodies are moved to close what a drawing leaves open, not to put "
            "parts in their places",
            remedy="Correct at= and rotation= of its bodies, or the places of these markers",
        )
    axes = ", ".join(
        [*filter(None, [own]), *(f"'{m}' with its z-axis along {_axis(system, work, m)}" for m in markers)]
    )
    return CompileError(
        joint.title,
        found=f"as described it is open by {_turn(system, work, name, radians):.3g} rad: {axes}",
        expected=f"less than {WRONG_TURN:g} rad: bodies are turned to close what a drawing leaves open, not to find "
        "their directions",
        remedy="Correct rotation= of its bodies, or the axes of these markers, whose z-axis is the axis of a joint; of "
        f"reduced bodies too: markers={{'{list(markers)[-1].partition('.')[2]}': Pose.axes(z=...)}}",
    )


def openings(system: System, state) -> list[str]:
    """Return sentences about joints that are drawn open, and about velocities that contradict joints.

    Parameters
    ----------
    state : State
        After assembly, at the time of the start.
    """
    work, size = system.workspace(), system.lengths.whole
    found = []
    for name, metres, radians in _drawn_open(system, work, state.t):
        if max(metres / size, radians / (2.0 * np.pi)) <= OPEN:
            continue
        joint, own = system.model.joint(name), _own_equation(system, work, name)
        turn = _turn(system, work, name, radians)
        markers = " and ".join(repr(m) for m in joint.resolved_markers(system.model))
        wanted = "bodies where the equation is satisfied" if own else f"markers {markers} that meet"
        found.append(
            f"{joint.title}: as described it is open by {_distance(metres, turn, size)}{': ' * bool(own)}{own}, and "
            f"assembly has closed it; expected: {wanted}, within {OPEN:g} of the model's size ({size:.3g} m). "
            "Check the places of its bodies and markers."
        )
    return found + _velocities(system, system.state(state.t), state, work)


def _drawn_open(system: System, work, t: float) -> list[tuple[str, float, float]]:
    """Return joint, m and rad of every joint as drawn, drives excepted."""
    no_matrix(work.weights)
    evaluate(system.program, system.state(t), work)
    work.equations["g"][system.program.equation_level != 0] = 0.0  # velocities are no gaps
    found = []
    for name, (metres, radians) in gaps(system, work).items():
        # a drive says where its joint begins, and assembly reports a point beyond the end of its curve
        if not system.model.joint(name).prescribes and np.isfinite(metres + radians):
            found.append((name, metres, radians))
    return found


def _own_equation(system: System, work, name: str) -> str:
    """Return the equation of the user and its residual as drawn, or an empty text for joints of the library."""
    k = system.joint_equations[name].start
    if not system.equation_names[k].endswith(": Formula"):
        return ""
    text = getattr(system.model.joint(name), "equation", None)
    what = f"its equation '{text}'" if text else "its function"
    return f"{what} has the residual {work.equations['g'][k]:.3g}"


def _distance(metres: float, radians: float, size: float) -> str:
    """Return what a joint is open by, without what is rounding."""
    told = ((metres, "m", ROUNDED * size), (radians, "rad", ROUNDED))
    return " and ".join(f"{x:.3g} {unit}" for x, unit, least in told if x > least)


def _place(system: System, marker: str) -> str:
    """Return where a marker is described, in W."""
    r = system.tables["markers"]["r"][system.marker_index[marker]]
    return f"({', '.join(f'{x:.4g}' for x in r)}) m"


def _axis(system: System, work, marker: str) -> str:
    """Return the z-axis of a marker as evaluated last, in W."""
    z = work.markers["R"][system.marker_index[marker]][:, 2]
    return f"({', '.join(f'{x:.3g}' for x in z)})"


def _turn(system: System, work, name: str, radians: float) -> float:
    """Return the angle of a joint with the residual `radians`; for perpendicular axes the residual is its sine."""
    span = system.joint_equations[name]
    sines = [
        abs(float(work.equations["g"][k]))
        for k in range(span.start, span.stop)
        if "Perpendicular" in system.equation_names[k]
    ]
    return float(np.arcsin(min(1.0, radians))) if radians in sines else radians


def _velocities(system: System, drawn, state, work) -> list[str]:
    """Return sentences about described velocities that the joints have changed; with the joint that objects most."""
    found = []
    evaluate(system.program, system.state(state.t, state.q, drawn.u), work)
    left = np.zeros(system.ng)
    constraint_velocity(work, drawn.u, left)
    owners = {name: float(np.abs(left[span]).max(initial=0.0)) for name, span in system.joint_equations.items()}
    for body in system.model.bodies:
        span = system.body_slices[body.name][1]
        if not body.has_frame and body.n_velocities != 3:
            continue
        for first, unit in ((0, "m/s"), (3, "rad/s")):
            own = slice(span.start + first, span.start + first + 3)
            was, now = drawn.u[own], state.u[own]
            if len(was) < 3 or own.stop > span.stop or not np.any(was):
                continue
            change = float(np.linalg.norm(now - was))
            if change <= CHANGED * float(np.linalg.norm(was)):
                continue
            mine = [
                joint
                for joint in system.model.joints
                if any(m.partition(".")[0] == body.name for m in joint.resolved_markers(system.model))
            ]
            if not mine:
                continue
            joint = max(mine, key=lambda j: owners.get(j.name, 0.0))
            listed = [_in_world(system, body, at, own) for at in (drawn, state)]
            kind = "velocity" if first == 0 else "angular velocity"
            found.append(
                f"{body.title}: its {kind} as described, ({listed[0]}) {unit}, contradicts "
                f"{joint.title}, and became ({listed[1]}) {unit}; expected: velocities of all bodies that the joints "
                "allow together. Give the other bodies theirs too, or leave out what the joint does not allow."
            )
    return found


def _in_world(system: System, body, state, own: slice) -> str:
    """Return a velocity (3,) as it is described, in world axes; digits that are rounding are zero."""
    velocity = state.u[own]
    if body.has_frame:
        at = system.body_slices[body.name][0].start
        euler_to_matrix(state.q[at + 3 : at + 7], R := np.empty((3, 3)))
        velocity = R @ velocity
    rounding = 1e-9 * float(np.linalg.norm(velocity))
    return ", ".join(f"{0.0 if abs(x) <= rounding else x:.4g}" for x in velocity)
