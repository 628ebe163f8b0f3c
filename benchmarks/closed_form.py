"""Accelerations of a spacecraft by Udwadia & Phohomsiri's equation: one evaluation, as matrices in Python and compiled.

The spacecraft of examples/spacecraft.py, with two bodies and with three; its rod is given three times.
"""

import runpy
import time
from pathlib import Path

import flexmb as fmb
from flexmb.integrate.matrices import equations_at
from flexmb.system import assemble

CRAFT = runpy.run_path(str(Path(__file__).parents[1] / "examples" / "spacecraft.py"))
FORMULATIONS = {
    "Udwadia & Phohomsiri": fmb.UdwadiaPhohomsiri(),
    "null space": fmb.NullSpace(),
    "sparse factors": fmb.Augmented(),
}


def per_evaluation(formulation, panel, part=0.1):
    """Return the processor time of an evaluation inside a run, s: steps, projections and samples counted in."""
    settings = fmb.Explicit(formulation=formulation)
    CRAFT["run"](1e-3, samples=2, integrator=settings, panel=panel)
    clock = time.process_time()
    motion, _ = CRAFT["run"](1e-3, samples=2, integrator=settings, panel=panel)
    start = time.process_time() - clock
    clock = time.process_time()
    longer, _ = CRAFT["run"](part, samples=2, integrator=settings, panel=panel)
    more = longer.statistics["evaluations"] - motion.statistics["evaluations"]
    return (time.process_time() - clock - start) / more


def in_python(formulation, panel, times=200):
    """Return the processor time of one solution with its matrices, s."""
    system, state = assemble(CRAFT["spacecraft"](panel))
    work = system.workspace()
    clock = time.process_time()
    for _ in range(times):
        formulation.solve(equations_at(system, state, work))
    return (time.process_time() - clock) / times


def main():
    """Print microseconds of an evaluation."""
    for panel, bodies in ((False, 2), (True, 3)):
        for name, formulation in FORMULATIONS.items():
            compiled, python = per_evaluation(formulation, panel), in_python(formulation, panel)
            print(f"{bodies} bodies, {name:20} {1e6 * compiled:7.1f} us in a run, {1e6 * python:7.0f} us as matrices")


if __name__ == "__main__":
    main()
