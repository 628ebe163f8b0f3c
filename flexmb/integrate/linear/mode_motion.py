"""`mode_motion`: one mode of the whole mechanism over a period, as a solution that can be drawn."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.integrate.linear.linearize import linearize
from flexmb.model.described import is_number
from flexmb.model.model import Model
from flexmb.results import Phase, Solution, Status, recover
from flexmb.system import assemble, assemble_as_drawn
from flexmb.system.given_state import given_state
from flexmb.system.holds import refuse_holds
from flexmb.system.program import advance

__all__ = ["mode_motion"]


def mode_motion(model: Model, about: Any = None, *, mode: int = 0, frames: int = 25, amplitude: float = 0.1):
    """Return one mode over a period of its frequency, without its growth or decay, for `write_vtk` and `view.render`.

    The configuration follows the straight mode shape, Re(shape exp(i w t)), from an end of the motion on: joints open
    with the square of the amplitude. Velocities and reactions mean nothing here; read no sensors of it.

    Parameters
    ----------
    model : Model
    about : Solution or Instant, optional
        As in `linearize`.
    mode : int
        Column of `Linearization.modes`; one that oscillates.
    frames : int
        The last one is the first again.
    amplitude : float
        Largest displacement in lengths of the mechanism, or turn in rad.

    Returns
    -------
    Solution

    Raises
    ------
    ModelError
        There is no such mode, or it does not oscillate.
    """
    linear = linearize(model, about)
    _require(linear, mode, frames, amplitude)
    system, state = (assemble_as_drawn if about is None else assemble)(model)
    refuse_holds(system, "mode_motion")
    if about is not None:
        state = given_state(about, system, "mode_motion")
    shape = linear.modes[:, mode]
    sizes = shape * system.units
    start = np.exp(-0.5j * np.angle(np.sum(sizes * sizes)))  # an eigenvector has any phase: begin at an end
    shape = shape * (start * amplitude / _size(system, shape))
    q = np.tile(state.q, (frames, 1))
    phases = np.linspace(0.0, 2.0 * np.pi, frames)
    for row, angle in zip(q, phases, strict=True):
        advance(system.program, state.q, (shape * np.exp(1j * angle)).real, 1.0, row)
    still = np.zeros((frames, system.nu))
    t = phases / (2.0 * np.pi * linear.frequencies[mode])
    phase = Phase(
        model=model,
        system=system,
        t=t,
        q=q,
        u=still,
        a=still,
        lam=np.zeros((frames, system.ng)),
        works=np.zeros((frames, 3)),
    )
    return Solution(phases=(phase,), status=Status.finished(float(t[-1])), statistics={"frames": frames})


def _require(linear, mode, frames, amplitude) -> None:
    known = [k for k, f in enumerate(linear.frequencies) if f > 0.0]
    if not isinstance(mode, int | np.integer) or mode not in known:
        raise ModelError(
            "mode_motion",
            found=f"mode = {mode!r}",
            expected=f"one that oscillates: {', '.join(map(str, known)) or 'none of this model does'}",
            remedy="Choose among linear.frequencies",
        )
    whole = isinstance(frames, int | np.integer) and frames >= 2
    if not whole or not is_number(amplitude) or amplitude <= 0.0:
        raise ModelError(
            "mode_motion",
            found=f"frames = {frames!r}, amplitude = {amplitude!r}",
            expected="at least 2 frames and a positive amplitude",
            remedy="Leave them out",
        )


def _size(system, shape: np.ndarray) -> float:
    """Return the largest displacement in lengths of the mechanism, or turn, of a mode shape."""
    largest = 0.0
    for body in system.model.bodies:
        _, iu = system.body_slices.get(body.name, (None, slice(0, 0)))
        own, data = np.abs(shape[iu] * system.units[iu]), getattr(body, "data", None)
        if data is not None and body.has_frame:
            moved = np.einsum("nim,m->ni", recover.modal_data(body).shapes, shape[iu][6:])
            bent = np.linalg.norm(moved, axis=1).max(initial=0.0) * system.units[iu][0]
            own = np.append(own[:6], bent)
        largest = max(largest, float(own.max(initial=0.0)))
    return largest or 1.0
