"""What integrators tell of the errors of their steps, beside the true errors, over many mechanisms.

    cd tests
    python -m convergence.added_error_campaign              # all, with tolerances 1e-4, 1e-5, 1e-6
    python -m convergence.added_error_campaign pendulum     # those whose names hold a word

Prints a row of a table for every mechanism: told / true by integrator and tolerance, shares of the largest motion.
"""

from __future__ import annotations

import sys
import warnings

import numpy as np
from convergence.added_error_mechanisms import CASES

import flexmb as fmb
from flexmb.integrate.extent import extents
from flexmb.integrate.runs.added_error import ADDED_UP, UNKNOWN
from flexmb.integrate.runs.gap import measure, new_gap

TOLERANCES = (1e-4, 1e-5, 1e-6)
SAMPLES = 101
TIGHT = fmb.Explicit(rtol=1e-10, atol=1e-13)
REFERENCE = {
    "four-bar": fmb.Implicit(rtol=3e-10, atol=1e-13),  # passes its dead centre, where steps of Explicit do not end
    "snapping strip": fmb.GeneralizedAlpha(rtol=1e-8, follow_errors=False),  # too stiff for Explicit
}
"""Of single mechanisms; of the others TIGHT."""
TAKES_NO_LINES = ("rope", "rope, damped", "snapping strip")
"""Bodies that the recursion of Implicit does not take."""


def true_share(run, exact) -> float:
    """Return the largest error of a run at its samples over its largest motion, of places or of turns."""
    mine, right = run.phases[0], exact.phases[0]
    system = mine.system
    state = system.state(float(mine.t[0]), mine.q[0].copy(), mine.u[0].copy())
    extent, gap = extents(system, state, system.workspace())[0], new_gap(system, True)
    for t, own, near in zip(mine.t, mine.q, right.q, strict=True):
        measure(system.program, own, near, extent, gap, mine.q[0], t)
    return float(max(gap[0]["far"] / gap[0]["moved"], gap[0]["wide"] / gap[0]["turned"]))


def told_and_true(name: str) -> dict[str, tuple[float | str, float]]:
    """Return (told, true) of a mechanism by integrator and tolerance."""
    model, seconds = CASES[name]
    kinds = (fmb.GeneralizedAlpha,) if name in TAKES_NO_LINES else (fmb.GeneralizedAlpha, fmb.Implicit)
    found: dict[str, tuple[float | str, float]] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fmb.ValidityWarning)
        exact = fmb.simulate(model, seconds, samples=SAMPLES, integrator=REFERENCE.get(name, TIGHT))
        for kind in kinds:
            for rtol in TOLERANCES:
                run = fmb.simulate(model, seconds, samples=SAMPLES, integrator=kind(rtol=rtol))
                found[f"{kind.__name__} {rtol:g}"] = run.statistics[ADDED_UP], true_share(run, exact)
    return found


def main(words: list[str]) -> None:
    """Print the table."""
    for name in CASES:
        if words and not any(word in name for word in words):
            continue
        row = [
            f"{'-' if told == UNKNOWN else f'{told:.1e}'} / {true:.1e}" for told, true in told_and_true(name).values()
        ]
        print(f"| {name} | {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    main(sys.argv[1:])
