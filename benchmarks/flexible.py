"""A flexible body from a solid mesh, beside Exudyn's ObjectFFRFreducedOrder with the same modes of the same mesh.

    python benchmarks/flexible.py                       # pendulum, 5k and 50k nodes; slider-crank; modes
    python benchmarks/flexible.py pendulum crank        # some of them
    python benchmarks/flexible.py modes --plot docs/images/flexible_modes.png

- ``pendulum``: a beam of tet10 (4941 and 50179 nodes) that falls about a revolute joint, 16 + 6 modes, 1000 steps;
- ``crank``: a slider-crank with that beam as rod, started from rest by a torque, 1000 steps;
- ``modes``: cost of a step of the pendulum with 8 to 128 modes.

Both programs take the same steps of the generalized-alpha method with the same spectral radius; the tip positions at
the end are printed for comparison (ours without geometric stiffness, which the peer does not have). Our times are given
with and without it. Every time is the median of `REPEATS` runs that take turns, in CPU seconds (both
run in one thread), ours with the preparation of the model.
"""

from __future__ import annotations

import argparse
import time
from functools import cache

import numpy as np

import flexmb as fmb
from flexmb import fem, reduction

LENGTH, SIDE, STEPS, RADIUS, REPEATS = 1.0, 0.03, 1000, 0.8, 3
STEP = 5e-4
SHORT = 100  # steps to choose the peer's solver, and with many modes
CRANK, TORQUE = 0.25, 40.0
CRANK_MASS, CRANK_INERTIA, SLIDER_MASS = 2.0, (0.02, 0.02, 0.03), 1.0
GRIDS = {"5k": (30, 4), "50k": (69, 9)}


@cache
def beam(grid: str):
    """Return the FE model of the beam along x with its ends as node sets."""
    from skfem import MeshTet, MeshTet2

    along, across = GRIDS[grid]
    y = np.linspace(-0.5 * SIDE, 0.5 * SIDE, across + 1)
    mesh = MeshTet2.from_mesh(MeshTet.init_tensor(np.linspace(0, LENGTH, along + 1), y, y))
    points = mesh.doflocs.T.copy()
    cells = np.hstack([mesh.t[:4].T, mesh.nvertices + mesh.t2e.T])
    ends = {"start": np.flatnonzero(points[:, 0] < 1e-9), "end": np.flatnonzero(points[:, 0] > LENGTH - 1e-9)}
    return fem.solid(fem.Mesh(points=points, cells=(("tetra10", cells),), node_sets=ends), fmb.MATERIALS["steel"])


@cache
def reduced(grid: str, modes: int):
    """Return the reduced beam with `modes` shapes: fixed-interface modes and 6 of the two interfaces."""
    return reduction.reduce(
        beam(grid), {"start": "start", "end": "end"}, modes - 6, geometric_stiffness=True, stress=False, compare=0
    )


def run_flexmb(case: str, data, stiffening: bool, steps: int = STEPS):
    """Return seconds and end of the beam (3,)."""
    body = fmb.FloatingBody("beam", data=data, geometric_stiffness=stiffening, at=(CRANK * (case == "crank"), 0, 0))
    tip = fmb.Position("tip", marker="beam.end")
    if case == "pendulum":
        model = fmb.Model(
            bodies=[fmb.Ground(), body],
            gravity=(0, -9.81, 0),
            sensors=[tip],
            joints=[fmb.Revolute("hinge", markers=("ground.origin", "beam.start"))],
        )
    else:
        crank = fmb.RigidBody("crank", mass=CRANK_MASS, inertia=CRANK_INERTIA, markers={"pin": (CRANK, 0, 0)})
        slider = fmb.RigidBody("slider", mass=SLIDER_MASS, inertia=(0.01, 0.01, 0.01), at=(CRANK + LENGTH, 0, 0))
        along = fmb.Pose.axes(z=(1, 0, 0))
        model = fmb.Model(
            bodies=[fmb.Ground(markers={"guide": along}), crank, body, slider.replaced(markers={"guide": along})],
            joints=[
                fmb.Revolute("O", markers=("ground.origin", "crank.center")),
                fmb.Revolute("A", markers=("crank.pin", "beam.start")),
                fmb.Spherical("B", markers=("beam.end", "slider.center")),
                fmb.Prismatic("C", markers=("ground.guide", "slider.guide")),
            ],
            forces=[fmb.PointLoad("torque", marker="crank.center", moment=(0, 0, TORQUE))],
            sensors=[tip],
        )
    begin = time.process_time()
    solution = fmb.simulate(model, steps * STEP, samples=2, integrator=fmb.GeneralizedAlpha(rho_inf=RADIUS, step=STEP))
    return time.process_time() - begin, solution["tip"][-1]


def exudyn_system(case: str, grid: str, data):
    """Return the peer's model, ready to be solved, and its marker at the end of the beam."""
    import exudyn as exu
    from exudyn import itemInterface as items
    from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface

    fe = beam(grid)
    interface = FEMinterface()
    interface.nodes = {"Position": fe.nodes}
    interface.massMatrix, interface.stiffnessMatrix = fe.M, fe.K
    interface.modeBasis = {"matrix": data.shapes.reshape(-1, data.n_modes), "type": "HCBmodes"}
    system = exu.SystemContainer().AddSystem()
    body = ObjectFFRFreducedOrderInterface(interface).AddObjectFFRFreducedOrder(
        system,
        positionRef=[CRANK * (case == "crank"), 0, 0],
        gravity=[0, -9.81, 0] if case == "pendulum" else [0, 0, 0],
    )["oFFRFreducedOrder"]
    markers = []
    for name in ("start", "end"):
        nodes = fe.node_sets[name]
        markers.append(
            system.AddMarker(
                items.MarkerSuperElementRigid(
                    bodyNumber=body, meshNodeNumbers=list(nodes), weightingFactors=[1.0 / len(nodes)] * len(nodes)
                )
            )
        )
    ground = system.AddObject(items.ObjectGround())
    origin = system.AddMarker(items.MarkerBodyRigid(bodyNumber=ground))

    def joint(a, b, axes):
        system.AddObject(items.GenericJoint(markerNumbers=[a, b], constrainedAxes=axes))

    if case == "pendulum":
        joint(origin, markers[0], [1, 1, 1, 1, 1, 0])
    else:

        def rigid(mass, inertia, at):
            number = system.CreateRigidBody(
                inertia=exu.rigidBodyUtilities.RigidBodyInertia(mass=mass, inertiaTensor=np.diag(inertia)),
                referencePosition=at,
            )
            return lambda place: system.AddMarker(items.MarkerBodyRigid(bodyNumber=number, localPosition=place))

        crank, slider = (
            rigid(CRANK_MASS, CRANK_INERTIA, [0, 0, 0]),
            rigid(SLIDER_MASS, (0.01,) * 3, [CRANK + LENGTH, 0, 0]),
        )
        center, sliding = crank([0, 0, 0]), slider([0, 0, 0])
        joint(origin, center, [1, 1, 1, 1, 1, 0])
        joint(crank([CRANK, 0, 0]), markers[0], [1, 1, 1, 1, 1, 0])
        joint(sliding, markers[1], [1, 1, 1, 0, 0, 0])
        joint(origin, sliding, [0, 1, 1, 1, 1, 1])
        system.AddLoad(items.LoadTorqueVector(markerNumber=center, loadVector=[0, 0, TORQUE]))
    system.Assemble()
    return system, markers[1]


def run_exudyn(case: str, grid: str, data, solver: str, steps: int = STEPS):
    """Return seconds of the integration and the end of the beam (3,)."""
    import exudyn as exu

    system, tip = exudyn_system(case, grid, data)
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = steps, steps * STEP
    settings.timeIntegration.generalizedAlpha.spectralRadius = RADIUS
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.linearSolver.solverType = getattr(exu.LinearSolverType, solver)
    begin = time.process_time()
    solved = exu.MainSolverImplicitSecondOrder().SolveSystem(system, settings)
    seconds = time.process_time() - begin
    return seconds, np.array(system.GetMarkerOutput(tip, exu.OutputVariableType.Position)) if solved else np.full(
        3, np.nan
    )


def peer_solver(case: str, grid: str, data) -> str | None:
    """Return the linear solver with which the peer is fastest; None if it is not installed."""
    try:
        seconds = {
            name: run_exudyn(case, grid, data, name, SHORT)[0] for name in ("EigenDense", "EXUdense", "EigenSparse")
        }
    except ImportError:
        return None
    return min(seconds, key=lambda name: seconds[name])


def compare(case: str, grid: str, modes: int = 22, steps: int = STEPS) -> tuple[float, float, float]:
    """Print a line of the table; return the median times of a step, us: ours, ours without geometric stiffness, the
    peer's, which may take fewer steps."""
    data = reduced(grid, modes)
    run_flexmb(case, data, True)
    solver = peer_solver(case, grid, data)
    full, plain, peer = [], [], []
    for _ in range(REPEATS):
        full.append(run_flexmb(case, data, True))
        plain.append(run_flexmb(case, data, False))
        if solver is not None:
            peer.append(run_exudyn(case, grid, data, solver, steps))
    own, linear = (1e6 / STEPS * float(np.median([s for s, _ in runs])) for runs in (full, plain))
    line = f"{case:9s} {grid:>4s} {data.n_modes:6d} {own:12.1f} {linear:12.1f}"
    other = float("nan")
    if peer:
        other = 1e6 / steps * float(np.median([s for s, _ in peer]))
        apart = np.linalg.norm(peer[0][1] - run_flexmb(case, data, False, steps)[1])
        line += f" {other:12.1f} {other / own:7.1f} {other / linear:7.1f}   {apart:.1e}   {solver}"
    print(line, flush=True)
    return own, linear, other


def plot(path: str, counts, times) -> None:
    """Draw the cost of a step over the number of modes."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(6, 3.6), layout="constrained")
    for row, label in zip(np.array(times).T, ("flexmb, with geometric stiffness", "flexmb, without", "Exudyn")):
        axes.loglog(counts, row, "o-", label=label)
    axes.set(xlabel="modes", ylabel="time per step (µs)", xticks=counts, xticklabels=[str(n) for n in counts])
    axes.minorticks_off()
    axes.grid(True, alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=120)


def main() -> None:
    """Print the table of the cases that are named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=["pendulum", "crank", "modes"])
    parser.add_argument("--plot", help="picture of the cost over the number of modes")
    asked = parser.parse_args()
    print("case      mesh  modes  flexmb [us]  no geom. st.  Exudyn [us]   ratio   ratio   ends apart [m]")
    if "pendulum" in asked.cases:
        for grid in GRIDS:
            compare("pendulum", grid)
    if "crank" in asked.cases:
        compare("crank", "5k")
    if "modes" in asked.cases:
        counts = (8, 16, 32, 64, 128)
        times = [compare("pendulum", "5k", count, STEPS if count < 64 else SHORT) for count in counts]
        if asked.plot:
            plot(asked.plot, counts, times)


if __name__ == "__main__":
    main()
