"""Rigid bodies that meet where edges cross and no corner does: hulls, meshes, boxes and capsules beside each other.

References: impacts and balances by hand, and the motion of boxes, whose edges `test_boxes.py` looks at.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.results.series import Series

G = 9.81
ON_EDGE = Rotation.from_rotvec((0.25 * np.pi, 0, 0)).as_matrix()
ACROSS = Rotation.from_rotvec((0, 0, 0.5 * np.pi)).as_matrix()


def solid(kind, size):
    """Return a box as a `Cuboid`, its hull, its mesh, or with a dent in an end, which is not convex."""
    if kind == "cuboid":
        return fmb.Cuboid(size=size)
    vertices, triangles = fmb.Cuboid(size=size).drawing()
    if kind == "hull":
        return fmb.Hull(points=vertices)
    if kind == "mesh":
        return fmb.TriangleMesh(vertices, triangles)
    end = np.flatnonzero(np.all(vertices[triangles][:, :, 0] > 0.0, axis=1))
    rim = [(0, 1), (1, 2), (2, 0)]
    sides = {(triangles[k][i], triangles[k][j]) for k in end for i, j in rim}
    sides = [side for side in sides if side[::-1] not in sides]
    vertices = np.vstack([vertices, (0.5 * size[0] - 0.2 * min(size), 0, 0)])
    fan = [(a, b, len(vertices) - 1) for a, b in sides]
    return fmb.TriangleMesh(vertices, np.vstack([np.delete(triangles, end, axis=0), fan]))


def body(name, size, place, rotation=None, mass=1.0, **motion):
    squares = np.square(size)
    inertia = tuple(mass / 12.0 * (squares.sum() - squares))
    return fmb.RigidBody(
        name, mass=mass, inertia=inertia, at=place, rotation=np.eye(3) if rotation is None else rotation, **motion
    )


def scene(bodies, shapes, law, gravity=(0, 0, -G), floor=False, fixed=()):
    """Return bodies with a shape each, all of which touch; `fixed`: (shape, place, rotation) of the ground."""
    poses = {f"p{k}": fmb.Pose(place, rotation=rotation) for k, (_, place, rotation) in enumerate(fixed)}
    surfaces = [fmb.Surface(f"fixed {k}", marker=f"ground.p{k}", shape=given[0]) for k, given in enumerate(fixed)]
    if floor:
        surfaces.append(fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()))
    own = [fmb.Surface(b.name, marker=f"{b.name}.center", shape=s) for b, s in zip(bodies, shapes, strict=True)]
    names = tuple(s.name for s in own)
    group = (*(s.name for s in surfaces), *names)
    sensors = [
        sensor(f"{short} {b.name}", marker=f"{b.name}.center")
        for b in bodies
        for short, sensor in (("p", fmb.Position), ("v", fmb.Velocity), ("w", fmb.AngularVelocity))
    ]
    return fmb.Model(
        gravity=gravity,
        bodies=[fmb.Ground(markers=poses), *bodies],
        surfaces=[*surfaces, *own],
        forces=[fmb.SurfaceContact("touch", surfaces=(group, names), law=law)],
        sensors=sensors,
    )


def run(model, t_end, step, samples=3):
    return fmb.simulate(model, t_end, integrator=fmb.MoreauJean(step=step), samples=samples)


KINDS = ["hull", "mesh", "dented"]


@pytest.mark.parametrize("kinds", [*((kind, kind) for kind in KINDS), ("cuboid", "hull"), ("dented", "cuboid")])
def test_crossed_bars_move_as_boxes(kinds):
    """A bar on edge falls across another one that lies on the floor, strikes edge on edge and comes to lie on it."""
    law = fmb.Rigid(friction=0.4, restitution=0.3)
    turn = Rotation.from_rotvec((0, 0, 1.2)).as_matrix() @ ON_EDGE
    sizes = (0.8, 0.1, 0.1), (0.8, 0.05, 0.05)

    def moved(kinds):
        bodies = [body("a", sizes[0], (0, 0, 0.05)), body("b", sizes[1], (0.1, 0.06, 0.2), turn)]
        model = scene(bodies, [solid(k, s) for k, s in zip(kinds, sizes, strict=True)], law, floor=True)
        found = run(model, 0.25, 2e-3, 6)
        return np.hstack([found["p b"], found["w b"]])

    boxes = moved(("cuboid", "cuboid"))
    assert np.abs(boxes[-1, 3:]).max() > 0.3  # the impact turns it
    assert moved(kinds) == pytest.approx(boxes, abs=1e-7)


@pytest.mark.parametrize("angle", [0.0, 0.01, 0.3, np.pi / 4])
@pytest.mark.parametrize("kind", KINDS)
def test_cubes_askew_stand_on_each_other(kind, angle):
    """No corner of either lies over the other's face: only edges that cross hold the upper one."""
    size, turn = (0.2, 0.2, 0.2), Rotation.from_rotvec((0, 0, angle)).as_matrix()
    bodies = [body("a", size, (0, 0, 0.1)), body("b", size, (0, 0, 0.3), turn)]
    found = run(scene(bodies, [solid(kind, size)] * 2, fmb.Rigid(friction=0.5), floor=True), 0.2, 5e-3)
    assert np.abs(found["p b"] - (0, 0, 0.3)).max() < 1e-9


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("pile", ["column", "overhang", "bond"])
def test_flush_solids_stand(kind, pile):
    """Corners lie on two faces of the solid below: they rest on the upper one, each of them once."""
    size, high, over = (0.2, 0.1, 0.05), 0.05, {"column": 0.0, "overhang": 0.099, "bond": 0.1}[pile]
    bodies = [body("a", size, (0, 0, 0.5 * high), mass=1e3), body("b", size, (over, 0, 1.5 * high))]
    if pile == "bond":
        bodies.insert(1, body("c", size, (0.2, 0, 0.5 * high)))
    found = run(scene(bodies, [solid(kind, size)] * len(bodies), fmb.Rigid(friction=0.5), floor=True), 0.1, 2e-3)
    assert np.abs(found["p b"] - found["p b"][0]).max() < 1e-8
    assert found.statistics["most contacts"] <= {"column": 8, "overhang": 8, "bond": 24}[pile]


@pytest.mark.parametrize("kind", ["cuboid", "hull", "dented"])
@pytest.mark.parametrize("share", [0.97, 1.03])
def test_two_cards_lean_on_each_other(kind, share):
    """A card has its weight and N = m g at its foot, and the push of the other one at the top, mu m g at most: with the
    distances of foot and middle from the top they stand if mu h > x_foot - x_middle.
    """
    size, lean = (2e-3, 0.06, 0.1), 0.3
    bodies, needed = [], 0.0
    for name, side in (("left", -1.0), ("right", 1.0)):
        turn = Rotation.from_rotvec((0, -side * lean, 0)).as_matrix()
        rims = np.array([(x * 1e-3, 0, z * 0.05) for x in (-1, 1) for z in (-1, 1)]) @ turn.T
        top, foot = rims[np.argmin(side * rims[:, 0])], rims[np.argmin(rims[:, 2])]
        needed = (abs(foot[0] - top[0]) - abs(top[0])) / (top[2] - foot[2])
        bodies.append(body(name, size, (-top[0], 0, -foot[2]), turn, mass=2e-3))
    law = fmb.Rigid(friction=share * needed)
    found = run(scene(bodies, [solid(kind, size)] * 2, law, floor=True), 0.1, 2e-3)
    far = np.abs(found["p left"] - found["p left"][0]).max()
    assert 0.1 < needed < 0.2
    assert far < 1e-8 if share > 1.0 else far > 1e-4


@pytest.mark.parametrize("wide", [0.06, 0.12])
@pytest.mark.parametrize("swapped", [False, True])
def test_a_knife_edge_stands_in_a_shorter_groove(wide, swapped):
    """Its edge runs along the bottom of the groove and beyond both ends of it, where no corner of it is: it stays."""
    outline = np.array([(-0.3, -0.1), (0.3, -0.1), (0.3, 0.2), (0.25, 0.2), (0, 0), (-0.25, 0.2), (-0.3, 0.2)])
    vertices = np.vstack([np.insert(outline, 1, y, axis=1) for y in (0.2, -0.2)])
    cap = np.array([(0, 1, 4), (1, 2, 3), (1, 3, 4), (0, 4, 5), (0, 5, 6)])
    sides = [t for k in range(7) for m in [(k + 1) % 7] for t in ((k, m, m + 7), (k, m + 7, k + 7))]
    block = fmb.TriangleMesh(vertices, np.vstack([cap[:, ::-1], cap + 7, sides]))
    knife = np.array([(x, y, z) for y in (-0.25, 0.25) for x, z in ((0, -0.1), (wide, 0.05), (-wide, 0.05))])
    bodies = [body("knife", (0.1, 0.5, 0.1), (0, 0, 0.1005))]
    model = scene(bodies, [fmb.Hull(points=knife)], fmb.Rigid(friction=0.5), fixed=[(block, (0, 0, 0), np.eye(3))])
    if swapped:
        force = model.forces[0]
        model = replace(model, forces=[replace(force, surfaces=force.surfaces[::-1])])
    found = run(model, 0.1, 1e-3)
    assert np.abs(found["p knife"][-1] - (0, 0, 0.1)).max() < 1e-5  # it stands on an edge, and tips


def tetrahedra(offset, speed, turn, swapped):
    """Return two regular tetrahedra of 1 and 2 kg without weight, an edge of each across that of the other one, by
    `offset` (2,) m off the middles; the upper one comes down.
    """
    edge = 0.2
    up = (
        edge
        / 8**0.5
        * np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
        @ Rotation.from_rotvec((0, 0, np.pi / 4)).as_matrix()
    )
    height = 2 * up[:, 2].max() + 0.01
    place = np.array([*offset, height])
    bodies = []
    for name, mass, at, v in (("low", 1.0, np.zeros(3), 0.0), ("high", 2.0, place, -speed)):
        inertia = (mass * edge**2 / 20.0,) * 3
        bodies.append(
            fmb.RigidBody(
                name, mass=mass, inertia=inertia, at=tuple(turn @ at), rotation=turn, velocity=tuple(turn @ (0, 0, v))
            )
        )
    law = fmb.Rigid(restitution=0.6)
    model = scene(bodies[:: -1 if swapped else 1], [fmb.Hull(points=up)] * 2, law, gravity=(0, 0, 0))
    return model, up, height


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("rotation", [(0, 0, 0), (0.4, -1.1, 2.0)])
@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.03, 0.02)])
def test_tetrahedra_strike_edge_on_edge(offset, rotation, swapped):
    """P = (1 + e) v / (1/m + 1/M + (r x n).(r x n) / J + ...), along the normal of both edges."""
    turn, speed = Rotation.from_rotvec(rotation).as_matrix(), 2.0
    model, up, height = tetrahedra(offset, speed, turn, swapped)
    found = run(model, 0.02, 1e-4)
    upper = up[up[:, 2] > 0]
    assert np.ptp(upper[:, 0]) < 1e-12 or np.ptp(upper[:, 1]) < 1e-12  # the edges run along x and y
    # the upper edge of the lower one passes through its middle along one axis, the lower edge of the upper one across
    along = 0 if np.ptp(upper[:, 1]) < 1e-12 else 1
    at = np.zeros(2)
    at[along], at[1 - along] = offset[along], 0.0
    levers = np.array([*at, 0.5 * (height - 0.01)]), np.array([*(at - offset), -0.5 * (height - 0.01)])
    n = np.array([0, 0, 1.0])
    masses, inertias = (1.0, 2.0), (1.0 * 0.2**2 / 20, 2.0 * 0.2**2 / 20)
    turned = [np.cross(r, n) for r in levers]
    D = sum(1 / m + t @ t / J for m, J, t in zip(masses, inertias, turned, strict=True))
    P = 1.6 * speed / D
    assert found["v low"][-1] == pytest.approx(turn @ (-P * n), abs=1e-9)
    assert found["v high"][-1] == pytest.approx(turn @ ((P / 2.0 - speed) * n), abs=1e-9)
    assert found["w low"][-1] == pytest.approx(turn @ (-P * turned[0] / inertias[0]), abs=1e-8)
    assert found["w high"][-1] == pytest.approx(turn @ (P * turned[1] / inertias[1]), abs=1e-8)


PRISM = np.array([(x, y, z) for y in (-0.25, 0.25) for x, z in ((-0.1, -0.1), (0.1, -0.1), (0.0, 0.0))])
LENGTH, WIDTH, THICK, HIGH = 1.0, 0.05, 0.02, 0.2


def see_saw(kind, beyond):
    """Return a bar that lies across the edge of a prism that is wider than it, its middle `beyond` the edge."""
    size = (LENGTH, WIDTH, THICK)
    bar = body("bar", size, (beyond, 0, HIGH + 0.5 * THICK))
    hull = fmb.Hull(points=PRISM)
    return scene(
        [bar], [solid(kind, size)], fmb.Rigid(friction=2.0), floor=True, fixed=[(hull, (0, 0, HIGH), np.eye(3))]
    )


@pytest.mark.parametrize("kind", ["hull", "dented"])
def test_see_saw(kind):
    """It turns about the edge, I w^2 / 2 = m g (c sin a + h/2 (1 - cos a)), until its end strikes the floor at
    sin a = H / (c + L/2). It keeps its moment of momentum about this end, lifts off the edge, and has w+ / w =
    (k^2 + h^2/4 - c L/2) / (k^2 + h^2/4 + L^2/4).
    """
    c, step = 0.1, 2e-3
    found = run(see_saw(kind, c), 0.3, step, 151)
    w, z = found["w bar"][:, 1], found["p bar"][:, 2] - HIGH
    angle = np.arctan2(-z, c)
    for _ in range(20):  # height of the middle above the edge: h/2 cos a - c sin a
        slope = 0.5 * THICK * np.sin(angle) + c * np.cos(angle)
        angle += (0.5 * THICK * np.cos(angle) - c * np.sin(angle) - z) / slope
    last, hit = np.arcsin(HIGH / (c + 0.5 * LENGTH)), int(np.argmax(w))
    turning = (LENGTH**2 + THICK**2) / 12.0 + 0.25 * THICK**2
    fallen = c * np.sin(angle) + 0.5 * THICK * (1.0 - np.cos(angle))
    expected = np.sqrt(2.0 * G * np.maximum(fallen, 0.0) / (turning + c**2))
    assert hit > 100
    assert w[1 : hit + 1] == pytest.approx(expected[1 : hit + 1], rel=1e-3, abs=2e-4)
    assert angle[hit] == pytest.approx(last, abs=1.5 * step * w[hit])
    after = w[hit] * (turning - 0.5 * c * LENGTH) / (turning + 0.25 * LENGTH**2)
    slowed = G * (0.5 * LENGTH * np.cos(last) - 0.5 * THICK * np.sin(last)) / (turning + 0.25 * LENGTH**2)
    # one step closes the gap, the next one ends the approach: up to two steps of gravity are between
    assert w[hit + 2] == pytest.approx(after - slowed * step, abs=1.01 * slowed * step)


@pytest.mark.parametrize("kind", ["cuboid", "hull", "dented"])
def test_see_saw_in_balance(kind):
    found = run(see_saw(kind, 0.0), 0.2, 2e-3)
    assert np.abs(found["p bar"] - found["p bar"][0]).max() < 1e-9


@pytest.mark.parametrize("share", [0.97, 1.03])
@pytest.mark.parametrize("shape", ["hull", "dented", "capsule"])
def test_friction_where_edges_cross(shape, share):
    """A sledge with two edges as runners, on two edges across as rails: a = g (sin - mu cos) where mu < tan."""
    slope, size = 0.4, (0.6, 0.04, 0.04)
    mu, reach = share * np.tan(slope), 0.02 * 2**0.5
    down = Rotation.from_rotvec((0, slope, 0)).as_matrix()
    runner = fmb.Capsule(radius=reach, length=0.6) if shape == "capsule" else solid(shape, size)
    own = Rotation.from_rotvec((0, 0.5 * np.pi, 0)).as_matrix() if shape == "capsule" else ON_EDGE
    rails = [
        (solid("hull" if shape == "capsule" else shape, size), down @ (x, 0, -reach), down @ ACROSS @ ON_EDGE)
        for x in (-0.1, 0.1)
    ]
    markers = {f"m{k}": fmb.Pose((0, y, 0), rotation=own) for k, y in enumerate((-0.1, 0.1))}
    sledge = fmb.RigidBody(
        "sledge", mass=2.0, inertia=(0.02, 0.06, 0.07), at=tuple(down @ (0, 0, reach)), rotation=down, markers=markers
    )
    surfaces = [fmb.Surface(f"rail {k}", marker=f"ground.p{k}", shape=s) for k, (s, _, _) in enumerate(rails)]
    surfaces += [fmb.Surface(f"runner {k}", marker=f"sledge.m{k}", shape=runner) for k in range(2)]
    touch = fmb.SurfaceContact(
        "touch", surfaces=(("rail 0", "rail 1"), ("runner 0", "runner 1")), law=fmb.Rigid(friction=mu)
    )
    poses = {f"p{k}": fmb.Pose(tuple(at), rotation=R) for k, (_, at, R) in enumerate(rails)}
    model = fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(markers=poses), sledge],
        surfaces=surfaces,
        forces=[touch],
        sensors=[fmb.Velocity("v", marker="sledge.center"), fmb.Position("p", marker="sledge.center")],
    )
    found = run(model, 0.2, 2e-3)
    a = max(0.0, G * (np.sin(slope) - mu * np.cos(slope)))
    assert found["v"][-1] == pytest.approx(0.2 * a * down[:, 0], abs=1e-8)
    assert np.linalg.norm(found["p"][-1] - found["p"][0]) == pytest.approx(0.02 * a, abs=1e-9)


@pytest.mark.parametrize("shape", ["hull", "dented", "capsule"])
@pytest.mark.parametrize("speed", [1.0, 30.0, 1000.0])
def test_no_step_passes_an_edge(shape, speed):
    """A slender rod strikes a fixed edge across its middle, in steps of 1 ms: it stays above."""
    size = (0.5, 4e-3, 4e-3)
    rod, turn = solid(shape, size), ON_EDGE
    if shape == "capsule":
        rod = fmb.Capsule(radius=2e-3, length=0.5)
        size, turn = size[::-1], Rotation.from_rotvec((0, 0.5 * np.pi, 0)).as_matrix()
    bodies = [body("rod", size, (0, 0, 0.1), turn, velocity=(0, 0, -speed))]
    fixed = [(fmb.Hull(points=PRISM * (0.1, 1, 0.1)), (0, 0, 0), np.eye(3))]
    found = run(scene(bodies, [rod], fmb.Rigid(restitution=0.5), gravity=(0, 0, 0), fixed=fixed), 0.2 / speed, 1e-3)
    assert found["v rod"][-1] == pytest.approx((0, 0, 0.5 * speed), rel=1e-6, abs=1e-6 * speed)


def test_capsules_strike_across():
    """Two rods, at right angles, one a quarter of its length off the middle of the other: P = (1 + e) v / D by hand."""
    length, radius, off, speed = 0.4, 0.02, 0.1, 3.0
    size = (2 * radius, 2 * radius, length)
    lying = Rotation.from_rotvec((0, 0.5 * np.pi, 0)).as_matrix()
    bodies = [
        body("low", size, (0, 0, 0), lying),
        body("high", size, (off, 0, 2 * radius + 0.005), ACROSS @ lying, velocity=(0, 0, -speed)),
    ]
    rod = fmb.Capsule(radius=radius, length=length)
    found = run(scene(bodies, [rod, rod], fmb.Rigid(restitution=0.8), gravity=(0, 0, 0)), 0.01, 1e-4)
    J = (length**2 + (2 * radius) ** 2) / 12.0
    P = 1.8 * speed / (2.0 + off**2 / J)
    assert found["v high"][-1] == pytest.approx((0, 0, P - speed), abs=1e-9)
    assert found["v low"][-1] == pytest.approx((0, 0, -P), abs=1e-9)
    assert found["w low"][-1] == pytest.approx((0, P * off / J, 0), abs=1e-9)


def bracket(a, b, thick, width):
    """Return an L of legs a and b long as a mesh, and its two boxes (size, middle)."""
    outline = np.array([(0, 0), (a, 0), (a, thick), (thick, thick), (thick, b), (0, b)])
    vertices = np.vstack([np.column_stack([outline, np.full(6, z)]) for z in (-0.5 * width, 0.5 * width)])
    cap = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])
    sides = [t for k in range(6) for m in [(k + 1) % 6] for t in ((k, m, m + 6), (k, m + 6, k + 6))]
    place = np.array([0.3 * a, 0.3 * b, 0.0])
    parts = ((a, thick, width), (0.5 * a, 0.5 * thick, 0)), ((thick, b, width), (0.5 * thick, 0.5 * b, 0))
    boxes = [(size, np.array(middle) - place) for size, middle in parts]
    return fmb.TriangleMesh(vertices - place, np.vstack([cap[:, ::-1], cap + 6, sides])), boxes


@pytest.mark.parametrize("kinds", ["hulls", "brackets"])
def test_elastic_impacts_keep_energy_and_momentum(kinds, rng):
    """Two bodies that tumble into each other and strike with corners, edges and faces: no friction, e = 1."""
    struck = 0
    for _ in range(4):
        if kinds == "hulls":
            shapes = [fmb.Hull(points=rng.normal(size=(10, 3)) * rng.uniform(0.02, 0.1, 3)) for _ in range(2)]
        else:
            shapes = [bracket(0.18, 0.15, 0.045, 0.08)[0]] * 2
        inertia, bodies = np.array([2e-3, 3e-3, 2.5e-3]), []
        for name, z, v in (("a", 0.0, 1.0), ("b", 0.3, -1.0)):
            turn, spin = Rotation.from_rotvec(rng.normal(size=3)).as_matrix(), tuple(rng.normal(size=3) * 5.0)
            velocity = (*(0.2 * rng.normal(size=2)), v)
            bodies.append(
                fmb.RigidBody(
                    name,
                    mass=1.0,
                    inertia=inertia,
                    at=(0, 0, z),
                    rotation=turn,
                    velocity=velocity,
                    angular_velocity=spin,
                )
            )
        found = run(scene(bodies, shapes, fmb.Rigid(restitution=1.0), gravity=(0, 0, 0)), 0.3, 1e-3, 31)
        energy, momentum = 0.0, 0.0
        for motion in (Series(found.phases[0]).marker(f"{b.name}.center") for b in bodies):
            own = np.einsum("kji,kj->ki", motion.R, motion.w)
            energy = energy + 0.5 * np.sum(motion.v**2, axis=1) + 0.5 * own**2 @ inertia
            momentum = momentum + motion.v
        struck += np.abs(found["v a"][-1] - found["v a"][0]).max() > 0.1
        assert energy == pytest.approx(energy[0], rel=2e-3)
        assert momentum == pytest.approx(momentum[:1].repeat(31, axis=0), abs=1e-10)
    assert struck >= 2


@pytest.mark.slow
def test_brackets_do_not_pass_through_each_other(rng):
    """Twelve brackets fly together and fall into a heap. The boxes that they consist of overlap, by coal, by no more
    than a fraction of a step's way, and at rest not at all; with corners alone eighteen of them came to lie 80 mm deep.
    """
    coal = pytest.importorskip("coal")
    shape, parts = bracket(0.18, 0.15, 0.045, 0.08)
    names = tuple(f"bracket {k}" for k in range(12))
    bodies = []
    for k, name in enumerate(names):
        x, y, z = k % 2 - 0.5, (k // 2) % 2 - 0.5, k // 4
        turn = Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
        place, fly = (0.4 * x, 0.4 * y, 0.3 + 0.3 * z), (-3.0 * x, -3.0 * y, 0)
        bodies.append(fmb.RigidBody(name, mass=1.0, inertia=(2e-3, 3e-3, 3e-3), at=place, rotation=turn, velocity=fly))
    model = scene(bodies, [shape] * len(bodies), fmb.Rigid(friction=0.4), floor=True)
    method = fmb.MoreauJean(step=2e-3, tolerance=1e-3)
    found = fmb.simulate(model, 1.0, integrator=method, samples=26)
    series = Series(found.phases[0])
    motions = [series.marker(f"{name}.center") for name in names]
    deepest = np.zeros(26)
    for k in range(26):
        placed = [
            (coal.Box(*size), coal.Transform3s(np.ascontiguousarray(m.R[k]), m.r[k] + m.R[k] @ middle), n)
            for n, m in enumerate(motions)
            for size, middle in parts
        ]
        for i, (first, at, own) in enumerate(placed):
            for second, there, other in placed[:i]:
                if own != other:
                    gap = coal.distance(first, at, second, there, coal.DistanceRequest(), coal.DistanceResult())
                    deepest[k] = max(deepest[k], -gap)
    assert deepest.max() < 1e-3
    assert np.median(deepest) < 1e-6
