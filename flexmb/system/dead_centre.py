"""Dead centres: places of a mechanism where more of its equations depend on each other than where it was put together.

There its joints allow more motions than one mechanism has, and reactions and accelerations have no unique solution; all
bars of a parallelogram in one line are the simplest.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from flexmb.math.weights import weigh_mass
from flexmb.system.mobility import constraint_matrix, equation_scale, mass_metric
from flexmb.system.program import evaluate
from flexmb.system.system import System

__all__ = ["joints_at_dead_centre"]

NEAR = 1e-3
"""Part of the least singular value of the independent equations at the start that is left at a dead centre."""
MOST = 1500
"""Equations up to which dead centres are looked for: the decomposition takes a second or two."""
SHARE = 0.1
"""Joints with a smaller share, of the largest, in the dependence take no part in it."""


def joints_at_dead_centre(system: System, state, work) -> list[str]:
    """Return the joints whose equations depend on each other at a state, but not at the start; none elsewhere.

    work : overwritten
    """
    independent = system.ng - len(system.redundant)
    if independent == 0 or system.ng > MOST or not all(np.all(np.isfinite(x)) for x in (state.q, state.u)):
        return []
    start = system.state(state.t, system.q0, system.u0)
    there = np.linalg.svd(_gradients(system, start, work), compute_uv=False)
    U, here, _ = np.linalg.svd(_gradients(system, state, work), full_matrices=False)
    last = independent - 1
    if len(here) <= last or not here[last] < NEAR * there[last]:
        return []
    shares = {name: float(np.linalg.norm(U[span, last])) for name, span in system.joint_equations.items()}
    return [name for name, share in shares.items() if share > SHARE * max(shares.values())]


def _gradients(system: System, state, work) -> np.ndarray:
    """Return the gradients (ng, nu) in the metric of the masses, each of length one or, without gradient, zero."""
    bare = system.program._replace(regularisation=np.zeros(system.ng), floor=np.zeros(len(system.program.floor)))
    weigh_mass(work.weights)
    evaluate(bare, state, work)
    M, G = constraint_matrix(system, work)
    sized = sparse.diags(equation_scale(M, G, np.zeros(system.nu)) ** -0.5) @ G @ sparse.diags(mass_metric(M) ** -0.5)
    return sized.toarray()
