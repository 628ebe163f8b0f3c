"""A ball of 100 000 triangles rolls over a plate of as many: processor time per step, beside Exudyn and MuJoCo.

Exudyn has a ball, in closed form, on the triangles of the plate; MuJoCo takes the convex hulls of both meshes and finds
at most a few points. Neither has an area: what is compared is the price of a step on the same scene.
"""

from __future__ import annotations

import time

import numpy as np

import flexmb as fmb

RADIUS, MASS, RATE, END = 0.05, 4.0, 20.0, 0.1
SIDE, HIGH = 0.4, 0.02


def ball(n: int = 224):
    """Return vertices and triangles of a globe with n meridians."""
    turn = 2.0 * np.pi * np.arange(n) / n
    rings = [
        RADIUS * np.column_stack([np.sin(t) * np.cos(turn), np.sin(t) * np.sin(turn), np.full(n, np.cos(t))])
        for t in np.linspace(0.0, np.pi, n + 1)[1:-1]
    ]
    vertices = np.concatenate([[(0, 0, RADIUS)], *rings, [(0, 0, -RADIUS)]])
    k, after, last = np.arange(n), (np.arange(n) + 1) % n, len(vertices) - 1
    zero = np.zeros(n, int)
    triangles = [np.column_stack([zero, 1 + k, 1 + after])]
    for i in range(n - 2):
        a, b = 1 + i * n, 1 + (i + 1) * n
        triangles += [np.column_stack([a + k, b + k, b + after]), np.column_stack([a + k, b + after, a + after])]
    a = 1 + (n - 2) * n
    return vertices, np.concatenate([*triangles, np.column_stack([zero + last, a + after, a + k])])


def plate(n: int = 157):
    """Return vertices and triangles of a plate with n by n squares on top and below."""
    line, m = np.linspace(-0.5 * SIDE, 0.5 * SIDE, n + 1), n + 1
    top = np.array([(x, y, 0.0) for x in line for y in line])
    i, j = (entry.ravel() for entry in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a, b, c, d = i * m + j, (i + 1) * m + j, (i + 1) * m + j + 1, i * m + j + 1
    up = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    below = len(top) + up[:, ::-1]
    k = np.arange(n)
    rim = [(k * m, (k + 1) * m), (n * m + k, n * m + k + 1), ((k + 1) * m + n, k * m + n), (k + 1, k)]
    sides = []
    for start, end in rim:
        s, e = start + len(top), end + len(top)
        sides += [np.column_stack([start, s, e]), np.column_stack([start, e, end])]
    return np.concatenate([top, top - (0, 0, HIGH)]), np.concatenate([up, below, *sides])


def ours():
    """Return milliseconds per step, and where the ball ends."""
    inertia = 0.4 * MASS * RADIUS**2
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"top": (0, 0, 0)}),
            fmb.RigidBody(
                "ball",
                mass=MASS,
                inertia=(inertia,) * 3,
                at=(-0.1, 0.003, RADIUS - 5e-5),
                rotation=(0.3, 0.4, 0.5),
                velocity=(RATE * RADIUS, 0, 0),
                angular_velocity=(0, RATE, 0),
            ),
        ],
        surfaces=[
            fmb.Surface("plate", marker="ground.top", shape=fmb.TriangleMesh(*plate())),
            fmb.Surface("skin", marker="ball.center", shape=fmb.TriangleMesh(*ball()), spacing=1.0),
        ],
        forces=[
            fmb.SurfaceContact(
                "touch",
                surfaces=("plate", "skin"),
                law=fmb.ElasticFoundation(modulus=1e9, thickness=0.01, damping=1.0, friction=0.3, transition=1e-2),
            )
        ],
        sensors=[fmb.Position("at", marker="ball.center")],
        gravity=(0, 0, -9.81),
    )
    method = fmb.GeneralizedAlpha(step=1e-4)
    fmb.simulate(model, t_end=2e-4, samples=2, integrator=method)  # compiles
    spent = []
    for end in (2e-4, END):
        begin = time.process_time()
        solution = fmb.simulate(model, t_end=end, samples=2, integrator=method)
        spent.append(time.process_time() - begin)
    return 1e3 * (spent[1] - spent[0]) / (solution.statistics["steps"] - 2), solution["at"][-1, 0]


def of_mujoco():
    """Return milliseconds per step, and where the ball ends."""
    import mujoco

    spec = mujoco.MjSpec()
    for name, (vertices, triangles) in (("plate", plate()), ("ball", ball())):
        spec.add_mesh(name=name, uservert=vertices.ravel(), userface=triangles.ravel())
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="plate")
    body = spec.worldbody.add_body(pos=(-0.1, 0.003, RADIUS - 5e-5))
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="ball", mass=MASS)
    spec.option.timestep = 1e-4
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qvel[0], data.qvel[4] = RATE * RADIUS, RATE
    begin = time.process_time()
    for _ in range(round(END / 1e-4)):
        mujoco.mj_step(model, data)
    return 1e3 * (time.process_time() - begin) / round(END / 1e-4), data.qpos[0]


def of_exudyn():
    """Return milliseconds per step, and where the ball ends: a ball in closed form on the triangles."""
    import exudyn as exu
    from exudyn.utilities import InertiaSphere

    system = exu.SystemContainer()
    mbs = system.AddSystem()
    ground = mbs.CreateGround()
    on_ground = mbs.AddMarker(exu.utilities.MarkerBodyRigid(bodyNumber=ground))
    number = mbs.CreateRigidBody(
        inertia=InertiaSphere(MASS, RADIUS),
        referencePosition=[-0.1, 0.003, RADIUS - 5e-5],
        initialVelocity=[RATE * RADIUS, 0, 0],
        initialAngularVelocity=[0, RATE, 0],
        gravity=[0, 0, -9.81],
    )
    on_ball = mbs.AddMarker(exu.utilities.MarkerBodyRigid(bodyNumber=number))
    contact = mbs.AddGeneralContact()
    contact.SetFrictionPairings(np.array([[0.3]]))
    contact.SetSearchTreeCellSize(numberOfCells=[64, 64, 1])
    law = {"contactStiffness": 1e6, "contactDamping": 100.0, "frictionMaterialIndex": 0}
    contact.AddSphereWithMarker(on_ball, radius=RADIUS, **law)
    vertices, triangles = plate()
    contact.AddTrianglesRigidBodyBased(
        rigidBodyMarkerIndex=on_ground,
        pointList=vertices,
        triangleList=triangles,
        **law,
    )
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(END / 1e-4)
    settings.timeIntegration.endTime = END
    settings.solution.file.write = False
    settings.timeIntegration.verboseMode = 0
    begin = time.process_time()
    mbs.SolveDynamic(settings)
    spent = time.process_time() - begin
    return 1e3 * spent / (END / 1e-4), mbs.GetObjectOutputBody(number, exu.OutputVariableType.Position)[0]


def main():
    """Print milliseconds of processor time per step of 0.1 ms."""
    for name, run in (
        ("flexmb", ours),
        ("MuJoCo (convex hulls)", of_mujoco),
        ("Exudyn (ball on triangles)", of_exudyn),
    ):
        try:
            spent, at = run()
        except ImportError as error:
            print(f"{name:28s} not installed ({error})")
            continue
        print(f"{name:28s} {spent:8.3f} ms per step, the ball ends at x = {at:.5f} m")


if __name__ == "__main__":
    main()
