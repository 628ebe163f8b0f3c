"""Accelerations of a spacecraft by Udwadia & Phohomsiri's equation: one evaluation, as matrices in Python and compiled;
what equations cost that are given three times; one simulated orbit.

The spacecraft of examples/spacecraft.py, with two bodies and with three; its rod is given three times. Chains of point
masses on rods are written as equations.
"""

import runpy
import statistics
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


def chain(links, times):
    """Return point masses on rods of 1 m, each length given so many times."""
    bodies, joints, before = [fmb.Ground()], [], "ground.origin"
    for k in range(links):
        bodies.append(fmb.PointMass(f"m{k}", mass=1.0, at=(k + 1.0, 0, 0)))
        over = {"a": fmb.Position("a", marker=before), "b": fmb.Position("b", marker=f"m{k}.center")}
        square = " + ".join(f"(b[{i}] - a[{i}])**2" for i in range(3))
        joints += [fmb.Constraint(f"r{k} {n}", over=over, equation=f"{n}*({square} - 1)") for n in range(1, times + 1)]
        before = f"m{k}.center"
    return fmb.Model(bodies=bodies, joints=joints, gravity=(0, -9.81, 0))


def thrice(links, formulation, span, pairs=5):
    """Return the processor time of an evaluation with every equation once, s, and three times it relative to that."""
    found = {1: [], 3: []}
    for pair in range(pairs + 1):
        for times, into in found.items():
            model, settings = chain(links, times), fmb.Explicit(formulation=formulation)
            clock = time.process_time()
            run = fmb.simulate(model, span, samples=2, integrator=settings)
            if pair > 0:
                into.append((time.process_time() - clock) / run.statistics["evaluations"])
    return statistics.median(found[1]), statistics.median(b / a for a, b in zip(found[1], found[3], strict=True))


def main():
    """Print microseconds of an evaluation, ratios, and seconds of an orbit."""
    for panel, bodies in ((False, 2), (True, 3)):
        for name, formulation in FORMULATIONS.items():
            compiled, python = per_evaluation(formulation, panel), in_python(formulation, panel)
            print(f"{bodies} bodies, {name:20} {1e6 * compiled:7.1f} us in a run, {1e6 * python:7.0f} us as matrices")
    for links, span in ((1, 20.0), (5, 4.0), (20, 2.0)):
        for name, formulation in FORMULATIONS.items():
            once, ratio = thrice(links, formulation, span)
            print(f"{links:2} rods as equations, {name:20} {1e6 * once:7.1f} us, given three times {ratio:5.2f} times")
    for name, settings in (
        ("default", None),
        ("Explicit()", fmb.Explicit()),
        ("GeneralizedAlpha()", fmb.GeneralizedAlpha()),
    ):
        CRAFT["run"](1e-3, samples=2, integrator=settings)
        clock = time.process_time()
        CRAFT["run"](1.0, samples=2, integrator=settings)
        print(f"one orbit of three bodies, {name:20} {time.process_time() - clock:6.2f} s")


if __name__ == "__main__":
    main()
