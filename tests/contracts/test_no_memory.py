"""What is evaluated follows from the state alone: nothing is left in tables, in patterns or in scratch arrays by what
was evaluated, factorised or solved before. Proved by exact equality of numbers."""

import numpy as np
import pytest
from contracts.random_models import FORCES, connected, random_state, randomise

from flexmb import joints
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_substitution import lu_solve
from flexmb.math.tables import State
from flexmb.math.weights import weigh
from flexmb.system.program import evaluate

SCRATCH = {"pattern.scratch"}
"""Of a program: written anew by each call that reads it."""


def arrays(structure, before: str = ""):
    """Yield (name, array) of a structure and of those within it."""
    for name, value in zip(structure._fields, structure, strict=True):
        if isinstance(value, np.ndarray):
            yield before + name, value
        elif hasattr(value, "_fields"):
            yield from arrays(value, f"{before}{name}.")


def results(system, work, state: State) -> dict[str, np.ndarray]:
    """Return what an evaluation with all weights gives, and the solution with its matrix."""
    weigh(work.weights, 1.0, 1e-3, 1e-5, half_step=5e-3)
    evaluate(system.program, state, work)
    found = {"residual": work.residual.copy(), "S": work.S.copy(), "energy": work.energy.copy()}
    right = np.linspace(-1.0, 1.0, system.nu + system.ng)
    if lu_factor(work.S, system.program.pattern) < 0:
        lu_solve(work.S, system.program.pattern, right)
        found["solution"] = right
    return found


@pytest.mark.parametrize("kind", [*joints.KINDS, *FORCES])
def test_of_joints_and_forces(kind, rng):
    """A state is evaluated, then others by the same and by another workspace, then the first once more."""
    system, state = random_state(connected(kind, "rigid-floating", rng), rng)
    kept = {name: array.tobytes() for name, array in arrays(system.program) if name not in SCRATCH}
    work = system.workspace()
    first = results(system, work, state)
    for other in (work, system.workspace()):
        results(system, other, randomise(system, system.state(), rng))
    again = results(system, work, state)
    assert first.keys() == again.keys()
    for name in first:
        assert again[name].tobytes() == first[name].tobytes(), name
    changed = [name for name, array in arrays(system.program) if name in kept and kept[name] != array.tobytes()]
    assert changed == []
