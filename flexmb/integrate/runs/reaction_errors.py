"""How well the steps resolve reactions: by how much those of the motion without known local errors differ.

A vibration that is small in the motion may be most of a reaction: what errors add up to in its phase is then little of
the one and much of the other.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import inner_kernel
from flexmb.system.complaints import equations_of_forces

__all__ = ["OF_REACTIONS", "add_difference", "new_comparison", "shares_of_reactions", "smaller", "unresolved"]

ERROR, SIZE = 0, 1
"""Columns: sums over samples of the sizes of differences and of multipliers, N or N m, then of their squares."""
OF_REACTIONS = "errors of reactions"
"""Name in the statistics: by joint, the share of its reaction."""
SHARE = 0.1
"""Of a reaction, on an average, from which on a note is made."""
ENDED = -1.0
"""In the table where nothing is compared any more."""
LEAST = 0.01
"""Of the largest force of all joints, or moment over the model's size: joints that carry less are measured by it."""


def smaller(integrator) -> str:
    """Return what to give an integrator whose steps are too long."""
    return "a smaller step" if integrator.step is not None else f"a smaller rtol than {integrator.rtol:g}"


def unresolved(shares: dict[str, float]) -> list[str]:
    """Return the note about reactions of which the steps miss too much."""
    wrong = sorted(((share, title) for title, share in shares.items() if share > SHARE), reverse=True)
    if not wrong:
        return []
    share, title = wrong[0]
    others = f"; {len(wrong) - 1} more joints likewise" if len(wrong) > 1 else ""
    much = f"{100.0 * share:.2g} % of the reaction" if share < 1.0 else "all of the reaction"
    return [
        f"the reaction of {title} is not resolved, though the motion is: vibrations in it have lost their phase, on an "
        f"average by {much}{others}. Where single values of it matter, give a smaller rtol or step, or damping to what "
        f"rings; '{OF_REACTIONS}' in the statistics has every joint"
    ]


def new_comparison(system) -> np.ndarray:
    """Return the table (ng, 4) of a run that begins."""
    return np.zeros((system.ng, 4))


@inner_kernel
def add_difference(lam, near, table):
    """Add the multipliers (ng,) that both motions have at a sample."""
    for i in range(len(lam)):
        if table[i, SIZE] == ENDED:
            return
        error, size = abs(lam[i] - near[i]), abs(lam[i])
        table[i, ERROR] += error
        table[i, SIZE] += size
        table[i, 2 + ERROR] += error * error
        table[i, 2 + SIZE] += size * size


def shares_of_reactions(system, work, table: np.ndarray) -> dict[str, float]:
    """Return by joint the error of its reaction, relative to the reaction: in the mean, or its square, what is less.

    Forces and moments are compared by themselves; the larger share counts. `work` holds an evaluation. At a singular
    position reactions have no limit: one sample near it is most of the squares. Where a vibration has died away, what
    is left of it is most of the samples.
    """
    if not system.ng or np.any(table == ENDED) or not np.all(np.isfinite(table)):
        return {}
    of_forces, length, shares = equations_of_forces(system, work), float(system.lengths.whole), {}
    kinds = {True: 1.0, False: length}  # m: what makes forces moments of the same weight
    sums: dict[tuple[str, bool], np.ndarray] = {}
    for name, span in system.joint_equations.items():
        for force in kinds:
            found = table[span][of_forces[span] == force].sum(axis=0)
            sums[name, force] = np.concatenate([found[:2], np.sqrt(found[2:])])
    largest = {column: max(found[column] / kinds[force] for (_, force), found in sums.items()) for column in (1, 3)}
    if not largest[1] > 0.0:  # nothing carries anything that an error could be a share of
        return {}
    for (name, force), found in sums.items():
        if found[ERROR] > 0.0:
            least = {column: LEAST * size * kinds[force] for column, size in largest.items()}
            share = min(float(found[column - 1] / max(found[column], least[column])) for column in (1, 3))
            title = system.model.joint(name, "").title
            shares[title] = max(share, shares.get(title, 0.0))
    return shares
