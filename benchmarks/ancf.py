"""A falling, very flexible pendulum of 20, 100 and 500 cable elements (case AN05), beside Exudyn's ANCFCable.

Both programs use the same elements (engineering strain, no damping) and the generalized-alpha method with the same
spectral radius. Error is the distance of the tip at the end from that of a run with a sixteenth of the smallest step,
on the same elements; time is CPU time of the integration alone, the median of three runs after one that compiles
kernels. The peer runs with its default tolerances of Newton's method and with a looser one (1e-6 instead of 1e-8) that
costs it no accuracy; both with its sparse solver and its modified Newton iteration, which are its fastest. Run with
``python benchmarks/ancf.py [--plot out.png] [elements ...]``.
"""

from __future__ import annotations

import argparse
import time
import warnings

import numpy as np

import flexmb as fmb
from flexmb import fem
from flexmb.system import assemble

LENGTH, AREA, INERTIA, DENSITY, YOUNG = 1.2, 0.0018, 1.215e-8, 5540.0, 0.7e6
END, RADIUS, REPEATS = 0.5, 0.8, 3
STEPS, TOLERANCES = (250, 500, 1000, 2000), (1e-5, 1e-6, 1e-7)
ERRORS = (5e-4, 2e-4, 5e-5, 2e-5)


class Ours:
    """The pendulum in this package, assembled once."""

    def __init__(self, elements: int):
        rope = fmb.AncfCable(
            "rope",
            points=((0, 0, 0), (LENGTH, 0, 0)),
            elements=elements,
            section=fem.Section.values(AREA, INERTIA, INERTIA, 2 * INERTIA),
            material=fmb.Material(young=YOUNG, poisson=0.3, density=DENSITY),
        )
        model = fmb.Model(
            bodies=(fmb.Ground(), rope),
            gravity=(0, -9.81, 0),
            joints=(fmb.Spherical("pin", markers=("ground.origin", "rope.start")),),
        )
        began = time.process_time()
        self.system, self.start = assemble(model)
        self.preparation = time.process_time() - began
        self.work = self.system.workspace()

    def run(self, repeats: int = REPEATS, **settings) -> tuple[float, np.ndarray, dict]:
        """Return seconds, tip (3,) and statistics."""
        integrator, spent = fmb.GeneralizedAlpha(rho_inf=RADIUS, **settings), []
        for _ in range(repeats):
            start = self.start._replace(**{name: getattr(self.start, name).copy() for name in ("q", "u", "a", "lam")})
            variables = integrator.start(self.system, start, self.work, END)
            began = time.process_time()
            outcome = integrator.run(self.system, self.work, variables, np.array([0.0, END]), 0, 2)
            spent.append(time.process_time() - began)
        return float(np.median(spent)), outcome.rows["q"][-1, -6:-3], integrator.statistics(variables)


class Peer:
    """The pendulum in Exudyn."""

    def __init__(self, elements: int):
        import exudyn as exu
        from exudyn.beams import GenerateStraightLineANCFCable
        from exudyn.itemInterface import Cable

        warnings.simplefilter("ignore", DeprecationWarning)
        self.exu, self.container = exu, exu.SystemContainer()
        self.system = self.container.AddSystem()
        template = Cable(
            physicsMassPerLength=DENSITY * AREA,
            physicsBendingStiffness=YOUNG * INERTIA,
            physicsAxialStiffness=YOUNG * AREA,
        )
        self.nodes = GenerateStraightLineANCFCable(
            self.system,
            [0, 0, 0],
            [LENGTH, 0, 0],
            elements,
            template,
            massProportionalLoad=[0, -9.81, 0],
            fixedConstraintsNode0=[1, 1, 1, 0, 0, 0],
            fixedConstraintsNode1=[0] * 6,
        )[0]
        self.system.Assemble()
        self.initial = self.system.systemData.GetSystemState(exu.ConfigurationType.Initial)

    def run(self, steps: int, tolerance: float | None) -> tuple[float, np.ndarray, dict] | None:
        """Return seconds, tip (3,) and counts; None if it does not converge."""
        exu, settings, spent = self.exu, self.exu.SimulationSettings(), []
        settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = steps, END
        settings.timeIntegration.generalizedAlpha.spectralRadius = RADIUS
        settings.timeIntegration.newton.useModifiedNewton = True
        if tolerance is not None:
            settings.timeIntegration.newton.relativeTolerance = tolerance
        settings.timeIntegration.verboseMode = 0
        settings.solutionSettings.writeSolutionToFile = False
        settings.linearSolverType = exu.LinearSolverType.EigenSparse
        for _ in range(REPEATS):
            self.system.systemData.SetSystemState(self.initial, exu.ConfigurationType.Initial)
            solver = exu.MainSolverImplicitSecondOrder()
            began = time.process_time()
            if not solver.SolveSystem(self.system, settings):
                return None
            spent.append(time.process_time() - began)
        tip = self.system.GetNodeOutput(self.nodes[-1], exu.OutputVariableType.Position)
        counts = {"iterations": solver.it.newtonStepsCount, "factorisations": solver.it.newtonJacobiCount}
        return float(np.median(spent)), np.array(tip), counts


def seconds_at(points: list[tuple[float, float]], error: float) -> float:
    """Return the time for an error, interpolated in a curve of (error, seconds); nan outside of it."""
    x, y = np.log(np.array(sorted(points))).T
    inside = x[0] <= np.log(error) <= x[-1]
    return float(np.exp(np.interp(np.log(error), x, y))) if inside else float("nan")


def compare(elements: int) -> dict:
    """Run both programs and print their errors and times; return them."""
    ours = Ours(elements)
    ours.run(1, step=END / 100)
    reference = ours.run(1, step=END / (16 * STEPS[-1]))[1]
    curves: dict[str, list[tuple[float, float]]] = {}

    def add(name, label, result):
        if result is None:
            print(f"  {name:22s} {label}: does not converge")
            return
        seconds, tip, counts = result
        curves.setdefault(name, []).append((float(np.linalg.norm(tip - reference)), seconds))
        print(
            f"  {name:22s} {label:>8}: {curves[name][-1][0]:.2e} m {1e3 * seconds:8.1f} ms  "
            f"{counts['iterations']} iterations, {counts['factorisations']} matrices",
            flush=True,
        )

    print(f"{elements} elements, prepared in {1e3 * ours.preparation:.0f} ms")
    for steps in STEPS:
        add("ours, fixed step", str(steps), ours.run(step=END / steps))
    for tolerance in TOLERANCES:
        add("ours, adaptive", f"{tolerance:.0e}", ours.run(rtol=tolerance))
    try:
        peer = Peer(elements)
    except ImportError:
        print("  Exudyn is not installed")
        return curves
    for name, tolerance in (("Exudyn, default", None), ("Exudyn, loose", 1e-6)):
        for steps in STEPS:
            add(name, str(steps), peer.run(steps, tolerance))
    for error in ERRORS:
        mine = np.nanmin([seconds_at(curves[name], error) for name in curves if name.startswith("ours")])
        times = [seconds_at(curves[name], error) / mine for name in curves if name.startswith("Exudyn")]
        print(
            f"  {error:.0e} m: {1e3 * mine:.1f} ms, times faster than "
            + ", ".join(
                f"{name} {ratio:.1f}" for name, ratio in zip([n for n in curves if n.startswith("Exudyn")], times)
            ),
            flush=True,
        )
    return curves


def plot(results: dict[int, dict], path: str) -> None:
    """Draw the time for an error of 2e-4 m over the number of elements."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axis = plt.subplots(figsize=(5.0, 3.4), layout="constrained")
    counts = np.array(list(results))
    for name in next(iter(results.values())):
        axis.loglog(counts, [seconds_at(results[n][name], 2e-4) for n in counts], "o-", label=name)
    last = seconds_at(results[int(counts[-1])]["ours, adaptive"], 2e-4)
    axis.loglog(counts, last * counts / counts[-1], ":", color="0.5", label="linear")
    axis.set(xlabel="elements", ylabel="CPU time, s, error 2e-4 m")
    axis.set_xticks(counts, [str(n) for n in counts])
    axis.set_xticks([], minor=True)
    axis.grid(True, which="both", alpha=0.2)
    axis.legend(fontsize=8)
    figure.savefig(path, dpi=120)


def main() -> None:
    """Compare, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("elements", nargs="*", type=int, default=[20, 100, 500])
    parser.add_argument("--plot", help="picture file")
    given = parser.parse_args()
    results = {elements: compare(elements) for elements in given.elements}
    if given.plot:
        plot(results, given.plot)


if __name__ == "__main__":
    main()
