"""What it costs to look where contacts, friction and stops switch: the same steps with and without.

    python benchmarks/switches.py                 # some minutes
    python benchmarks/switches.py --bodies 50

Balls that slide on a plane with friction, and arms on hinges with friction and stops, by `GeneralizedAlpha` with
a fixed step: the steps are then the same, and only reading and comparing the switches differs. CPU time of one thread
per step, the least of some runs, kernels compiled.
"""

from __future__ import annotations

import argparse
import os
import time
from unittest import mock

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402 (one thread: set before it is loaded)

import flexmb as fmb  # noqa: E402
from flexmb.integrate.alpha import generalized_alpha  # noqa: E402

STEP = 1e-3


def sliding(n: int) -> fmb.Model:
    """Return n balls of 5 cm that slide and rub on one plane, a little apart."""
    balls = [
        fmb.PointMass(f"b{k}", mass=0.5, at=(0.2 * k, 0, 0.0499), velocity=(0.5 + 0.01 * k, 0.2, 0)) for k in range(n)
    ]
    contacts = [
        fmb.Contact(
            f"c{k}",
            markers=("ground.origin", f"b{k}.center"),
            radius=0.05,
            stiffness=1e6,
            damping=0.3,
            friction=0.2,
            transition=1e-2,
        )
        for k in range(n)
    ]
    return fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), *balls], forces=contacts)


def stopped(n: int) -> fmb.Model:
    """Return n arms on hinges with friction, each between two stops."""
    arms = [
        fmb.RigidBody(
            f"a{k}", mass=1.0, inertia=(1e-3, 0.1, 0.1), at=(0.5, k, 0), markers={"pin": fmb.Pose((-0.5, 0, 0))}
        )
        for k in range(n)
    ]
    ground = fmb.Ground(markers={f"p{k}": (0, k, 0) for k in range(n)})
    hinges = [fmb.Revolute(f"h{k}", markers=(f"ground.p{k}", f"a{k}.pin")) for k in range(n)]
    laws = [fmb.JointFriction(f"f{k}", joint=f"h{k}", moving=0.1, radius=0.02, transition=1e-2) for k in range(n)]
    stops = [fmb.BiStop(f"s{k}", joint=f"h{k}", travel=(-0.1, 0.1), stiffness=1e3, damping=5.0) for k in range(n)]
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[ground, *arms], joints=hinges, forces=[*laws, *stops])


def per_step(model: fmb.Model, t_end: float, runs: int) -> float:
    """Return the least CPU time per step, s."""
    best = np.inf
    for _ in range(runs):
        begun = time.process_time()
        solution = fmb.simulate(model, t_end, samples=3, integrator=fmb.GeneralizedAlpha(step=STEP))
        best = min(best, (time.process_time() - begun) / solution.statistics["steps"])
    return best


def without_switches(system, state, work, **limits):
    """Return switches of which there are none."""
    found = _made(system, state, work, **limits)
    return found._replace(kinds=found.kinds[:0], now=found.now[:0], then=found.then[:0], touched=found.touched[:0])


_made = generalized_alpha.new_switching


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bodies", type=int, default=200)
    parser.add_argument("--runs", type=int, default=3)
    given = parser.parse_args()
    print("| model | us a step without | with | more |\n|---|---|---|---|")
    for name, model in (("sliding balls", sliding(given.bodies)), ("hinges with stops", stopped(given.bodies))):
        fmb.simulate(model, 3 * STEP, samples=2, integrator=fmb.GeneralizedAlpha(step=STEP))  # compiles
        times = []
        for t_end in (0.1, 0.3):  # the difference is without what a run costs before its first step
            looked = per_step(model, t_end, given.runs)
            with mock.patch.object(generalized_alpha, "new_switching", without_switches):
                times.append((per_step(model, t_end, given.runs), looked))
        without, looked = ((3.0 * late - early) / 2.0 for early, late in zip(*times))
        print(f"| {given.bodies} {name} | {1e6 * without:.0f} | {1e6 * looked:.0f} | {looked / without - 1.0:.0%} |")


if __name__ == "__main__":
    main()
