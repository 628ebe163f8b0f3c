"""Bodies in absolute nodal coordinates at random states: far from their initial line, strained, moving."""

from __future__ import annotations

import flexmb as fmb
from flexmb import fem
from flexmb.system import compile

SOFT = fmb.Material(young=3e3, poisson=0.3, density=900.0)
ROUND = fem.Section.solid_circle(0.2)
BENT = ((0, 0, 0), (0.4, 0.2, 0.1), (0.9, 0.3, 0.4), (1.2, 0.1, 0.3))


def cable(**fields) -> fmb.AncfCable:
    """A soft, damped, curved cable of three elements with a marker inside the second."""
    return fmb.AncfCable("b", **{
        "points": BENT, "elements": 3, "section": ROUND, "material": SOFT, "axial_damping": 5.0,
        "bending_damping": 0.4, "initial_strain": 0.03, "markers": {"m": (0.45, (0.3, -0.2, 0.5))}, **fields})


def disturbed(model, rng, size: float = 0.08):
    """Return the compiled system with all coordinates of its bodies without frames disturbed, moving, accelerated."""
    system = compile(model)
    state = system.state(0.2)
    state.u[:], state.a[:] = rng.normal(size=system.nu), rng.normal(size=system.nu)
    state.lam[:] = rng.normal(size=system.ng)
    for iq, _, count, flexible in system.program.vectors:
        if not flexible:
            state.q[iq : iq + count] += size * rng.normal(size=count)
    return system, state
