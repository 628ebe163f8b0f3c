"""What assembly changes of a drawing: joints that it closes over a distance, velocities that joints do not allow."""

from __future__ import annotations

import numpy as np

from flexmb.system.complaints import gaps
from flexmb.system.program import constraint_velocity, evaluate
from flexmb.system.system import System

__all__ = ["openings"]

OPEN = 0.01
"""Gap of a joint as drawn, relative to the model's size (lengths) or in turns (angles), from which on it is told."""
WRONG = 0.1
"""The same from which on the drawing is hardly what was meant."""
CHANGED = 0.01
"""Change of a described velocity, relative to it, from which on it is told."""


def openings(system: System, state, size: float) -> list[str]:
    """Return sentences about joints that are drawn open, and about velocities that contradict joints.

    Parameters
    ----------
    state : State
        After assembly, at the time of the start.
    size : float, m
        Of the model.
    """
    work = system.workspace()
    drawn = system.state(state.t)
    work.coefficients[:] = 0.0
    evaluate(system.program, drawn, work)
    if not np.all(np.isfinite(work.equations["g"])):
        return []
    found = []
    for name, (metres, radians) in gaps(system, work).items():
        joint = system.model.joint(name)
        share = max(metres / size, radians / (2.0 * np.pi))
        if joint.prescribes or share <= OPEN:  # a drive says where its joint begins
            continue
        by = " and ".join(f"{x:.3g} {unit}" for x, unit in ((metres, "m"), (radians, "rad")) if x > 0.0)
        sure = "This is far more than a drawing leaves open: check" if share > WRONG else "Check"
        found.append(
            f"{joint.title}: as described it is open by {by}, and the bodies were moved to close it; expected: markers "
            f"{' and '.join(repr(m) for m in joint.resolved_markers(system.model))} that meet, within {OPEN:g} of the "
            f"model's size ({size:.3g} m). {sure} the places of its bodies and markers."
        )
    return found + _velocities(system, drawn, state, work)


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
            listed = [", ".join(f"{x:.4g}" for x in v) for v in (was, now)]
            kind = "velocity" if first == 0 else "angular velocity"
            found.append(
                f"{body.title}: its {kind} as described, ({listed[0]}) {unit} in its own axes, contradicts "
                f"{joint.title}, and became ({listed[1]}) {unit}; expected: velocities of all bodies that the joints "
                "allow together. Give the other bodies theirs too, or leave out what the joint does not allow."
            )
    return found
