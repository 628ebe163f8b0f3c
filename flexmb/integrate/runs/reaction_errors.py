"""How well the steps resolve reactions: by how much those of the motion without known local errors differ.

A vibration that is small in the motion may be most of a reaction: what errors add up to in its phase is then little of
the one and much of the other.
"""

from __future__ import annotations

import numpy as np

from flexmb.math.kernel import kernel
from flexmb.system.complaints import equations_of_forces

__all__ = ["OF_REACTIONS", "add_difference", "new_comparison", "shares_of_reactions", "smaller", "unresolved"]

ERROR, SIZE = 0, 1
"""Columns: sums over samples of the sizes of differences and of multipliers, N or N m, then of their squares."""
OF_REACTIONS = "errors of reactions"
"""Name in the statistics: by joint, the share of its reaction."""
SHARE = 0.1
"""Of a reaction, on an average, from which on a run warns."""
LEAST = 0.01
"""Of the largest force or moment of all joints, to which the errors of those that carry less are compared."""


def smaller(integrator) -> str:
    """Return what to give an integrator whose steps are too long."""
    return "a smaller step" if integrator.step is not None else f"a smaller rtol than {integrator.rtol:g}"


def unresolved(shares: dict[str, float], integrator) -> list[str]:
    """Return the warning about reactions of which the steps miss too much."""
    wrong = sorted(((share, title) for title, share in shares.items() if share > SHARE), reverse=True)
    if not wrong:
        return []
    share, title = wrong[0]
    others = f"; {len(wrong) - 1} more joints likewise" if len(wrong) > 1 else ""
    much = f"{100.0 * share:.2g} % of the reaction" if share < 1.0 else "all of the reaction"
    return [
        f"{type(integrator).__name__}: the reaction of {title} is not resolved, though the motion is: vibrations in it "
        f"have lost their phase, on an average by {much}{others}; expected: less than {100.0 * SHARE:g} %. Give "
        f"{smaller(integrator)}, or damping to what rings; single values of it mean nothing."
    ]


def new_comparison(system) -> np.ndarray:
    """Return the table (ng, 4) of a run that begins."""
    return np.zeros((system.ng, 4))


@kernel
def add_difference(lam, near, table):
    """Add the multipliers (ng,) that both motions have at a sample."""
    for i in range(len(lam)):
        error, size = abs(lam[i] - near[i]), abs(lam[i])
        table[i, ERROR] += error
        table[i, SIZE] += size
        table[i, 2 + ERROR] += error * error
        table[i, 2 + SIZE] += size * size


def shares_of_reactions(system, work, table: np.ndarray) -> dict[str, float]:
    """Return by joint the error of its reaction, relative to the reaction: in the mean, or its square, what is less.

    Forces are compared with forces and moments with moments; the larger share counts. `work` holds an evaluation. At a
    singular position reactions have no limit: one sample near it is most of the squares. Where a vibration has died
    away, what is left of it is most of the samples.
    """
    if not system.ng or not np.all(np.isfinite(table)):
        return {}
    forces, shares = equations_of_forces(system, work), {}
    for kind in (forces, ~forces):
        means = {name: table[span, :2][kind[span]].sum(axis=0) for name, span in system.joint_equations.items()}
        roots = {
            name: np.sqrt(table[span, 2:][kind[span]].sum(axis=0)) for name, span in system.joint_equations.items()
        }
        least = [LEAST * max((found[name][SIZE] for name in found), default=0.0) for found in (means, roots)]
        for name in means:
            if least[0] > 0.0 and means[name][ERROR] > 0.0:
                both = zip((means[name], roots[name]), least, strict=True)
                share = min(float(found[ERROR] / max(found[SIZE], floor)) for found, floor in both)
                title = system.model.joint(name, "").title
                shares[title] = max(share, shares.get(title, 0.0))
    return shares
