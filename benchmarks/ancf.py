"""A falling, very flexible pendulum of 20, 100 and 500 cable elements, beside Exudyn's ANCFCable.

Both programs take the same steps of the generalized-alpha method with the same spectral radius on the same elements
(case AN05: engineering strain, no damping), so they make the same error; the tips are printed for comparison. The time
is the best of three runs after one that compiles kernels; ours contains the preparation of the model (some ten
milliseconds), the peer's does not. Run with ``python benchmarks/ancf.py [elements ...]``.
"""

from __future__ import annotations

import sys
import time

import numpy as np

import flexmb as fmb
from flexmb import fem

LENGTH, AREA, INERTIA, DENSITY, YOUNG = 1.2, 0.0018, 1.215e-8, 5540.0, 0.7e6
END, STEPS, RADIUS = 0.5, 500, 0.8


def run_flexmb(elements: int):
    """Return seconds, tip (3,) and Newton iterations."""
    rope = fmb.AncfCable("rope", points=((0, 0, 0), (LENGTH, 0, 0)), elements=elements,
                         section=fem.Section.values(AREA, INERTIA, INERTIA, 2 * INERTIA),
                         material=fmb.Material(young=YOUNG, poisson=0.3, density=DENSITY))
    model = fmb.Model(bodies=(fmb.Ground(), rope), gravity=(0, -9.81, 0),
                      joints=(fmb.Spherical("pin", markers=("ground.origin", "rope.start")),),
                      sensors=(fmb.Position("tip", marker="rope.end"),))
    begin = time.perf_counter()
    solution = fmb.simulate(model, t_end=END, samples=2,
                            integrator=fmb.GeneralizedAlpha(rho_inf=RADIUS, step=END / STEPS))
    return time.perf_counter() - begin, solution["tip"][-1], solution.statistics["iterations"]


def run_exudyn(elements: int):
    """Return seconds, tip (3,) and Newton iterations."""
    import exudyn as exu
    from exudyn.beams import GenerateStraightLineANCFCable
    from exudyn.itemInterface import Cable

    container = exu.SystemContainer()
    system = container.AddSystem()
    template = Cable(physicsMassPerLength=DENSITY * AREA, physicsBendingStiffness=YOUNG * INERTIA,
                         physicsAxialStiffness=YOUNG * AREA)
    nodes = GenerateStraightLineANCFCable(
        system, [0, 0, 0], [LENGTH, 0, 0], elements, template, massProportionalLoad=[0, -9.81, 0],
        fixedConstraintsNode0=[1, 1, 1, 0, 0, 0], fixedConstraintsNode1=[0] * 6)[0]
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = STEPS, END
    settings.timeIntegration.generalizedAlpha.spectralRadius = RADIUS
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolverType = exu.LinearSolverType.EigenSparse
    begin = time.perf_counter()
    solver = exu.MainSolverImplicitSecondOrder()
    if not solver.SolveSystem(system, settings):
        return float("nan"), np.full(3, np.nan), 0
    seconds = time.perf_counter() - begin
    tip = system.GetNodeOutput(nodes[-1], exu.OutputVariableType.Position)
    return seconds, np.array(tip), solver.it.newtonStepsCount


def main(counts) -> None:
    """Print a table: elements, seconds of both, ratio, distance of the tips."""
    run_flexmb(4)
    print("elements   flexmb [s]   us/element/iteration   Exudyn [s]   ratio   tips apart [m]")
    for elements in counts:
        own = min((run_flexmb(elements) for _ in range(3)), key=lambda r: r[0])
        line = f"{elements:8d}   {own[0]:10.3f}   {1e6 * own[0] / own[2] / elements:20.2f}"
        try:
            peer = min((run_exudyn(elements) for _ in range(3)), key=lambda r: r[0])
            line += f"   {peer[0]:10.3f}   {peer[0] / own[0]:5.1f}   {np.linalg.norm(peer[1] - own[1]):.2e}"
        except ImportError:
            line += "   Exudyn is not installed"
        print(line)


if __name__ == "__main__":
    main([int(a) for a in sys.argv[1:]] or [20, 100, 500])
