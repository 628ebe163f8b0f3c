"""Chains of rigid bodies on revolute joints: time per acceleration and body, beside two peers; flexible trees.

    python benchmarks/tree.py                                       # 10 to 10 000 bodies, ours only
    python benchmarks/tree.py --pinocchio /path/to/its/python       # pip install pin, in an environment of its own
    python benchmarks/tree.py --exudyn --flexible 160 --plot tree.png
    python benchmarks/tree.py --products 10 100 1000 5000 10000     # M v, M^-1 f, bias, torques, and preparation

Ours are an evaluation of `simulate(..., formulation=Recursive())`, for chains on hinges, on balls, and on hinges with
springs; and `Recursive.accelerate` (kinematics, forces, accelerations and all reactions of any tree). Pinocchio's is
`aba` from Python; its data need so much memory that it runs to 300 bodies, on balls to 100. Exudyn's is a step of its
explicit Euler method with one ObjectKinematicTree (to 100). Median of CPU time, one thread. With --plot the table is
drawn as well. --products takes chains of rods, and of reduced beams with six modes and geometric stiffness, on hinges:
CPU time of `JointTree(model)` and of the first product, then the least of an evaluation, all per link.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import time

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402 (one thread: set before it is loaded)

import flexmb as fmb  # noqa: E402
from flexmb.math.kernel import kernel  # noqa: E402
from flexmb.system import assemble, compile  # noqa: E402
from flexmb.tree.rigid.motion import link_rates  # noqa: E402

PINOCCHIO = """
import sys, time
import numpy as np
import pinocchio as pin
for n in map(int, sys.argv[1:]):
    for joint in (pin.JointModelRZ, pin.JointModelSpherical)[: 2 if n <= 100 else 1]:
        model = pin.Model()
        parent = 0
        for k in range(n):
            at = pin.SE3(np.eye(3), np.array([1.0 if k else 0.0, 0, 0]))
            parent = model.addJoint(parent, joint(), at, f"j{k}")
            rod = pin.Inertia(1.0, np.array([0.5, 0, 0]), np.diag([1e-3, 1 / 12, 1 / 12]))
            model.appendBodyToJoint(parent, rod, pin.SE3.Identity())
        data, q, v, tau = model.createData(), pin.neutral(model), 0.2 * np.ones(model.nv), np.zeros(model.nv)
        spent = []
        for _ in range(max(7, 20000 // n)):
            clock = time.process_time()
            pin.aba(model, data, q, v, tau)
            spent.append(time.process_time() - clock)
        print(n, np.median(spent) / n * 1e6)
"""


def median_time(call, count: int) -> float:
    """Return the median CPU time of a call, s."""
    call()
    return sorted(spent(call) for _ in range(count))[count // 2]


def chain(n: int, kind: str = "hinges"):
    """Return a chain of n rods on revolute joints ("hinges"), with springs ("springs"), or on ball joints ("balls")."""
    rods = [fmb.RigidBody.rod(f"b{k}", length=1.0, mass=1.0, radius=0.05, at=(k, 0, 0)) for k in range(n)]
    ends = ["ground.origin"] + [f"b{k}.end" for k in range(n)]
    joint = fmb.Spherical if kind == "balls" else fmb.Revolute
    joints = [joint(f"j{k}", markers=(ends[k], f"b{k}.start")) for k in range(n)]
    springs = [fmb.TorsionSpring(f"s{k}", joint=f"j{k}", stiffness=1.0) for k in range(n)] if kind == "springs" else []
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[fmb.Ground(), *rods], joints=joints, forces=springs)


def beams(n: int):
    """Return a chain of n reduced beams with six modes and all geometric stiffness on revolute joints."""
    from flexmb import fem, reduction

    points = np.column_stack([np.linspace(0.0, 1.0, 11), np.zeros(11), np.zeros(11)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.02, 0.03), material=fmb.MATERIALS["aluminium"])
    data = reduction.reduce(fe, interfaces={"root": [0], "tip": [10]}, modes=6, geometric_stiffness=True)
    bodies = [fmb.FloatingBody(f"b{k}", data=data, at=(k, 0, 0)) for k in range(n)]
    ends = ["ground.origin", *(f"b{k}.tip" for k in range(n))]
    joints = [fmb.Revolute(f"j{k}", markers=(ends[k], f"b{k}.root")) for k in range(n)]
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[fmb.Ground(), *bodies], joints=joints)


def spent(call) -> float:
    """Return the CPU time of a call, s."""
    clock = time.process_time()
    call()
    return time.process_time() - clock


def products(numbers: list[int]) -> None:
    """Print what products, bias and torques of chains cost, and what comes before, per link."""
    for kind, make in (("rods", chain), ("beams", beams)):
        warm = fmb.JointTree(make(2))  # kernels
        warm.mass_product(warm.start.q, warm.start.v)
        for n in numbers:
            model = make(n)
            trees: list[fmb.JointTree] = []
            drawn = spent(lambda model=model, trees=trees: trees.append(fmb.JointTree(model)))
            tree = trees[0]
            q, a = tree.start.q, np.cos(np.arange(len(tree.rate_names)))
            calls = {
                "M v": lambda tree=tree, q=q, a=a: tree.mass_product(q, a),
                "M^-1 f": lambda tree=tree, q=q, a=a: tree.mass_solution(q, a),
                "bias": lambda tree=tree, q=q, a=a: tree.bias(q, a),
                "torques": lambda tree=tree, q=q, a=a: tree.torques(q, a, a),
            }
            first = spent(calls["M v"])
            least = {name: min(spent(call) for _ in range(max(5, 2000 // n))) for name, call in calls.items()}
            costs = ", ".join(f"{name} {1e6 * x / n:.2f}" for name, x in least.items())
            print(f"{n:6d} {kind}, us per link: JointTree {1e6 * drawn / n:.0f}, first {1e6 * first / n:.0f}; {costs}")


def flexible_tree(n: int, ribs: int = 16):
    """Return n reduced beams as ribs on a hub, in the manner of the wrap-rib antenna of Banerjee 1993."""
    from flexmb import fem, reduction

    points = np.column_stack([np.linspace(0.0, 1.0, 11), np.zeros(11), np.zeros(11)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.02, 0.03), material=fmb.MATERIALS["aluminium"])
    data = reduction.reduce(fe, interfaces={"root": [0], "tip": [10]}, modes=3, geometric_stiffness=True)
    angles = 2 * np.pi * np.arange(ribs) / ribs
    hub = fmb.RigidBody(
        "hub",
        mass=100.0,
        inertia=(50, 50, 100),
        markers={f"m{k}": fmb.Pose((0, 0, 0), (0, 0, a)) for k, a in enumerate(angles)},
    )
    bodies, joints = [fmb.Ground(), hub], []
    for k, a in enumerate(angles):
        end = f"hub.m{k}"
        for i in range(n // ribs):
            at = (i * np.cos(a), i * np.sin(a), 0)
            bodies.append(fmb.FloatingBody(f"r{k}_{i}", data=data, at=at, rotation=(0, 0, a)))
            joints.append(fmb.Revolute(f"j{k}_{i}", markers=(end, f"r{k}_{i}.root")))
            end = f"r{k}_{i}.tip"
    return fmb.Model(bodies=bodies, joints=joints)


def ours(model, formulation, count: int) -> float:
    """Return the CPU time of one acceleration, s."""
    system = compile(model)
    state, work = system.state(), system.workspace()
    return median_time(lambda: formulation.accelerate(system, state, work), count)


@kernel
def repeat(links, work, t, x, v, count):
    """Find the second rates of joint coordinates so many times, as the compiled steps do."""
    for _ in range(count):
        link_rates(links, work, t, x, v)


def integrated(model, count: int) -> float:
    """Return the CPU time of an evaluation of an explicit run in joint coordinates, s."""
    system, start = assemble(model)
    work = system.workspace()
    unknowns = fmb.Recursive().unknowns(system, start, work)
    x, v, _ = unknowns.of(start)
    return median_time(lambda: repeat(unknowns.links, work, 0.0, x, v, count), 5) / count


def plot(path: str, rows: list[tuple]) -> None:
    """Draw time per body over the number of bodies."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.4, 4.0))
    names = (
        "Recursive.accelerate: with reactions",
        "Recursive as integrated: hinges",
        "as integrated: balls",
        "as integrated: hinges with springs",
        "Pinocchio aba: hinges",
        "Pinocchio aba: balls",
        "Exudyn: kinematic tree",
    )
    for k, (name, mark) in enumerate(zip(names, "os*Dv<^", strict=True), 1):
        points = [(row[0], row[k]) for row in rows if row[k] is not None]
        if points:
            axes.loglog(*zip(*points, strict=True), marker=mark, label=name)
    axes.set(xlabel="bodies", ylabel="time per acceleration and body [us]")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))
    figure.savefig(path, dpi=120, bbox_inches="tight")


def dense(system, state, work):
    """Solve the augmented equations with dense coupling."""
    from flexmb.integrate.matrices import equations_at

    e = equations_at(system, state, work)
    M, L, G = e.M.toarray(), e.L.toarray(), e.G.toarray()
    return np.linalg.solve(np.block([[M, -L], [G, np.zeros((len(G), len(G)))]]), np.concatenate([e.f, e.b]))


def exudyn_step(n: int) -> float:
    """Return the CPU time of one explicit step of a kinematic tree of n links, s."""
    import exudyn as exu
    import exudyn.itemInterface as items

    container = exu.SystemContainer()
    system = container.AddSystem()
    node = system.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0.1] * n,
            initialCoordinates=[0.0] * n,
            initialCoordinates_t=[0.2] * n,
            numberOfODE2Coordinates=n,
        )
    )
    offsets, inertias = exu.Vector3DList(), exu.Matrix3DList()
    turns, coms = exu.Matrix3DList(), exu.Vector3DList()
    for k in range(n):
        offsets.Append([1.0 if k else 0.0, 0, 0])
        inertias.Append(np.diag([1e-3, 1 / 12, 1 / 12]))
        turns.Append(np.eye(3))
        coms.Append([0.5, 0, 0])
    system.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[exu.JointType.RevoluteZ] * n,
            linkParents=list(range(-1, n - 1)),
            jointTransformations=turns,
            jointOffsets=offsets,
            linkInertiasCOM=inertias,
            linkCOMs=coms,
            linkMasses=[1.0] * n,
            gravity=[0, -9.81, 0],
        )
    )
    system.Assemble()
    steps, settings = 4, exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = steps, 1e-6 * steps
    settings.solutionSettings.writeSolutionToFile = False
    settings.timeIntegration.verboseMode = 0
    clock = time.process_time()
    system.SolveDynamic(settings, solverType=exu.DynamicSolverType.ExplicitEuler)
    return (time.process_time() - clock) / steps


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bodies", type=int, nargs="+", default=[10, 100, 300, 1000, 3000, 10000])
    parser.add_argument("--pinocchio", help="Python interpreter that has Pinocchio")
    parser.add_argument("--exudyn", action="store_true")
    parser.add_argument("--plot", help="picture file")
    parser.add_argument("--flexible", type=int, help="number of flexible segments")
    parser.add_argument("--products", type=int, nargs="+", help="numbers of links for products in joint coordinates")
    options = parser.parse_args()
    if options.products:
        products(options.products)
        return
    peers: dict[int, list[float]] = {}
    if options.pinocchio:
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        text = subprocess.run(
            [options.pinocchio, "-c", PINOCCHIO, *(str(n) for n in options.bodies if n <= 300)],
            check=True,
            text=True,
            capture_output=True,
            env=environment,
        ).stdout
        for n, micro in (line.split() for line in text.splitlines()):
            peers.setdefault(int(n), []).append(float(micro))
    rows = []
    for n in options.bodies:
        mine = ours(chain(n), fmb.Recursive(), max(7, 20000 // n)) / n * 1e6
        hinges, balls, springs = (
            integrated(chain(n, kind), max(100, 20000 // n)) / n * 1e6 for kind in ("hinges", "balls", "springs")
        )
        other = exudyn_step(n) / n * 1e6 if options.exudyn and n <= 100 else None
        aba = [*peers.get(n, []), None, None][:2]
        rows.append((n, mine, hinges, balls, springs, *aba, other))
        line = (
            f"{n:6d} bodies, us per body: hinges {hinges:.3f}, balls {balls:.3f}, hinges with springs {springs:.3f}, "
            f"with reactions {mine:.3f}"
        )
        for kind, time_of_ours, time_of_peer in zip(("hinges", "balls"), (hinges, balls), aba, strict=True):
            if time_of_peer:
                line += f"; Pinocchio {kind} {time_of_peer:.3f}, ratio {time_of_ours / time_of_peer:.2f}"
        if other:
            line += f"; Exudyn {other:.1f}, ratio {hinges / other:.4f}"
        print(line, flush=True)
    if options.plot:
        plot(options.plot, rows)
    if options.flexible:
        model = flexible_tree(options.flexible)
        system = compile(model)
        state, work = system.state(), system.workspace()
        recursive = ours(model, fmb.Recursive(), 15)
        sparse = ours(model, fmb.Augmented(), 15)
        full = median_time(lambda: dense(system, state, work), 1)
        print(
            f"{options.flexible} flexible segments: recursive {recursive * 1e3:.2f} ms, augmented sparse "
            f"{sparse * 1e3:.2f} ms ({sparse / recursive:.1f} x), augmented dense {full * 1e3:.0f} ms "
            f"({full / recursive:.0f} x)"
        )


if __name__ == "__main__":
    main()
