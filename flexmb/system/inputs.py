"""Where the inputs of a model stand among the numbers of its compiled signals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmb.errors import CompileError
from flexmb.model.expression import SignalProgram, joined_inputs

__all__ = ["places_of_inputs"]


def places_of_inputs(
    programs: Sequence[SignalProgram], titles: Sequence[str], prescribing: slice
) -> dict[str, np.ndarray]:
    """Return the places of every input in the arguments of all signals.

    Raises
    ------
    CompileError
        An input prescribes a motion, which must not jump, or has different values at the beginning.
    """
    for number in range(len(programs))[prescribing]:
        if programs[number].inputs:
            name = programs[number].inputs[0][1]
            raise CompileError(
                titles[number],
                found=f"input '{name}' in a prescribed motion, which would jump whenever it is set",
                expected="inputs in loads: efforts, forces, moments, pressures",
                remedy="Let the input act through a force: an Actuator or a Motor with a controller of the motion",
            )
    values, places = {}, {}
    numbers = np.concatenate([np.empty(0), *(program.args for program in programs)])
    for place, name in joined_inputs(programs):
        value = numbers[place]
        if values.setdefault(name, value) != value:
            raise CompileError(
                f"Input '{name}'",
                found=f"the values {values[name]:g} and {value:g} before it is set",
                expected="one value for one input",
                remedy="Give the same value wherever the input is named, or use two inputs",
            )
        places.setdefault(name, []).append(place)
    return {name: np.array(found) for name, found in places.items()}
