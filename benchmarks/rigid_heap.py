"""Balls that fall into a box and settle: time of a step by the number of contacts, beside MuJoCo and Exudyn in the run.

    python benchmarks/rigid_heap.py 125 1000 10000

The same balls, walls and friction for all. The methods differ: MuJoCo's contact is soft and its solver stops after so
many iterations, whatever is left (its Newton's method up to FULL balls, above them its conjugate gradients, since the
factors of Newton's grow faster than the contacts); Exudyn's contact is a spring and needs explicit steps, twenty in one
of the others; here laws are rigid and a step that misses its tolerance ends the run.
A number with a minus sign is done without the others.
"""

from __future__ import annotations

import resource
import sys
import time

import numpy as np

import flexmb as fmb

RADIUS, STEP, STEPS, FEW, FRICTION = 0.05, 2e-3, 150, 2, 0.3
FULL = 500
SPRING, FINE = 1e5, 20
"""N/m of Exudyn's contacts, and its steps in one of the others."""


def places(count: int) -> tuple[np.ndarray, float]:
    """Return places (n, 3), m, of balls above the floor of a box, and half its width."""
    side = round(count ** (1.0 / 3.0))
    spacing = 2.1 * RADIUS
    grid = spacing * (np.arange(side) - 0.5 * (side - 1))
    x, y, z = np.meshgrid(grid, grid, spacing * (0.5 + np.arange(side)) + 0.2 * RADIUS, indexing="ij")
    jitter = np.random.default_rng(1).uniform(-0.04 * RADIUS, 0.04 * RADIUS, (side**3, 3))
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()]) + jitter, 0.5 * spacing * side + 0.2 * RADIUS


def with_flexmb(at: np.ndarray, half: float, tolerance: float) -> tuple[float, int]:
    """Return seconds per step, and the most contacts."""
    names = tuple(f"ball {k}" for k in range(len(at)))
    walls = {
        f"wall {k}": fmb.Pose.axes(tuple(-half * np.array(n, float)), z=n, x=(n[1], n[0], 0))
        for k, n in enumerate([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
    }
    inertia = (0.4 * RADIUS**2,) * 3
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers=walls),
            *[fmb.RigidBody(n, mass=1.0, inertia=inertia, at=tuple(p)) for n, p in zip(names, at, strict=True)],
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            *[fmb.Surface(w, marker=f"ground.{w}", shape=fmb.Plane()) for w in walls],
            *[fmb.Surface(n, marker=f"{n}.center", shape=fmb.Sphere(radius=RADIUS)) for n in names],
        ],
        forces=[
            fmb.SurfaceContact("heap", surfaces=(("floor", *walls, *names), names), law=fmb.Rigid(friction=FRICTION))
        ],
    )
    method = fmb.MoreauJean(step=STEP, tolerance=tolerance)
    spent = []
    for steps in (FEW, FEW, STEPS):  # kernels are compiled in the first; assembly is in both others
        begin = time.process_time()
        solution = fmb.simulate(model, steps * STEP, integrator=method, samples=2)
        spent.append(time.process_time() - begin)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    told = {k: v for k, v in solution.statistics.items() if k in ("steps", "sweeps", "most contacts")}
    print({**told, "s to begin": round(spent[1], 2), "MB at most": round(memory)}, flush=True)
    return (spent[2] - spent[1]) / (STEPS - FEW), solution.statistics["most contacts"]


def with_mujoco(at: np.ndarray, half: float) -> tuple[float, int]:
    """Return seconds per step, and the contacts at the end."""
    import mujoco

    sides = [("1 0 0", f"{-half} 0 0"), ("-1 0 0", f"{half} 0 0"), ("0 1 0", f"0 {-half} 0"), ("0 -1 0", f"0 {half} 0")]
    walls = "".join(f'<geom type="plane" size="9 9 1" pos="{p}" zaxis="{z}" friction="{FRICTION}"/>' for z, p in sides)
    balls = "".join(
        f'<body pos="{x} {y} {z}"><freejoint/><geom type="sphere" size="{RADIUS}" mass="1" condim="3" '
        f'friction="{FRICTION}"/></body>'
        for x, y, z in at
    )
    text = (
        f'<mujoco><option timestep="{STEP}" cone="elliptic" solver="{"Newton" if len(at) <= FULL else "CG"}"/>'
        f'<size memory="4G"/><worldbody>'
        f'<geom type="plane" size="9 9 1" friction="{FRICTION}"/>{walls}{balls}</worldbody></mujoco>'
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    begin = time.process_time()
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    return (time.process_time() - begin) / STEPS, int(data.ncon)


def with_exudyn(at: np.ndarray, half: float) -> float:
    """Return seconds per STEP; contacts are not counted there."""
    import exudyn as exu
    from exudyn.utilities import InertiaSphere, MarkerBodyRigid

    container = exu.SystemContainer()
    mbs = container.AddSystem()
    on_ground = mbs.AddMarker(MarkerBodyRigid(bodyNumber=mbs.CreateGround()))
    contact = mbs.AddGeneralContact()
    contact.SetFrictionPairings(np.array([[FRICTION]]))
    contact.SetSearchTreeCellSize(numberOfCells=[round(len(at) ** (1.0 / 3.0))] * 3)
    law = {"contactStiffness": SPRING, "contactDamping": 0.1 * SPRING**0.5, "frictionMaterialIndex": 0}
    for place in at:
        ball = mbs.CreateRigidBody(
            inertia=InertiaSphere(1.0, RADIUS),
            referencePosition=list(place),
            gravity=[0, 0, -9.81],
            nodeType=exu.NodeType.RotationRotationVector,
        )
        contact.AddSphereWithMarker(mbs.AddMarker(MarkerBodyRigid(bodyNumber=ball)), radius=RADIUS, **law)
    high = 2.0 * half + 1.0
    corners = np.array([(x, y, z) for x in (-half, half) for y in (-half, half) for z in (0.0, high)])
    sides = [(0, 4, 6, 2), (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3)]
    triangles = []
    for a, b, c, d in sides:
        normal = np.cross(corners[b] - corners[a], corners[c] - corners[a])
        inward = (0.0, 0.0, 0.5 * high) - corners[[a, b, c, d]].mean(axis=0)
        e, f = (b, d) if normal @ inward > 0.0 else (d, b)
        triangles += [(a, e, c), (a, c, f)]
    contact.AddTrianglesRigidBodyBased(
        rigidBodyMarkerIndex=on_ground, pointList=corners, triangleList=np.array(triangles), **law
    )
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = STEPS * FINE, STEPS * STEP
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.explicit.useLieGroupIntegration = True
    settings.timeIntegration.explicit.computeMassMatrixInversePerBody = True
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    settings.parallel.numberOfThreads = 1
    begin = time.process_time()
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.ExplicitEuler)
    return (time.process_time() - begin) / STEPS


def main() -> None:
    """Print our time and that of others for every number of balls, each as soon as it is known."""
    tolerance = 1e-2
    for count in [int(x) for x in sys.argv[1:]] or [125, 1000]:
        at, half = places(abs(count))
        ours, contacts = with_flexmb(at, half, tolerance)
        print(
            f"{len(at)} balls: {1e3 * ours:.2f} ms per step with at most {contacts} contacts, tolerance {tolerance:g}",
            flush=True,
        )
        if count < 0:
            continue
        theirs, others = with_mujoco(at, half)
        print(f"  MuJoCo: {1e3 * theirs:.2f} ms with {others}; ratio {ours / theirs:.2f}", flush=True)
        theirs = with_exudyn(at, half)
        print(f"  Exudyn: {1e3 * theirs:.2f} ms in {FINE} steps; ratio {ours / theirs:.2f}", flush=True)


if __name__ == "__main__":
    main()
