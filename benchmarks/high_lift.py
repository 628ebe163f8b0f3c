"""One second of extension of the trailing edge, rigid and with elastic flaps and tracks; goal: elastic within 30 s.

Processor time of the second of two runs, after one that compiles kernels; it contains the search for the equilibrium at
the start. There is no peer: the accuracy is that of the model files, rtol 1e-6 rigid and 1e-5 elastic. Run with
``python benchmarks/high_lift.py``.
"""

from __future__ import annotations

import time
from pathlib import Path

import flexmb as fmb

MODEL = Path(__file__).parents[1] / "examples" / "highlift" / "operation.toml"


def run(rigid: bool) -> tuple[float, fmb.Solution]:
    """Return the processor time, s, and the solution."""
    model = fmb.load_model(MODEL, {"rigid": rigid})
    settings = fmb.load_simulation(MODEL, {"rigid": rigid}).keywords()
    begin = time.process_time()
    solution = fmb.simulate(model, **settings)
    return time.process_time() - begin, solution


if __name__ == "__main__":
    for rigid in (True, False):
        run(rigid)
        seconds, solution = run(rigid)
        report = fmb.check(solution.model)
        steps, iterations = (solution.statistics[name] for name in ("steps", "iterations"))
        print(
            f"{'rigid' if rigid else 'elastic'}: {seconds:.2f} s of processor time, {steps} steps, "
            f"{iterations} iterations"
        )
        print(
            f"  {len(solution.model.bodies)} bodies, mobility {report.mobility}, loop closure "
            f"{solution['loop closure'].max():.1e}"
        )
