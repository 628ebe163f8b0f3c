"""A carriage on a rail that bends and twists: two rollers one behind the other, a third beside the front one.

The rail is a beam or a solid, both reduced, or a beam in absolute nodal coordinates (the third roller not on it).

Reference: a simply supported beam under two forces by Euler and Bernoulli, w(x) = P b x (L^2 - b^2 - x^2)/(6 L EI) for
x up to the place L - b of the force, and by Saint-Venant its twist under a moment at a, T a (L - a)/(L GJ).
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from fem.structured import structured

import flexmb as fmb
from flexmb import fem, reduction

L, HEIGHT, WIDTH = 10.0, 0.1, 0.2
STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
SECTION = fem.Section.rectangle(WIDTH, HEIGHT)
EI = STEEL.young * WIDTH * HEIGHT**3 / 12.0
NO_POISSON = fmb.Material(young=210e9, poisson=0.0, density=7850.0)  # bent solids arch across, beams do not
BASE, FORCE, ASIDE = 1.0, 2e3, 0.15


@cache
def rail() -> fmb.ModalNeutralData:
    x = np.linspace(0.0, L, 21)
    fe = fem.frame(points=np.column_stack([x, 0 * x, 0 * x]), section=SECTION, material=STEEL, orientation=(0, 1, 0))
    stations = {f"p{k}": (float(k), 0, 0) for k in range(11)}
    for k in range(11):
        fe = fem.with_rigid_link(fem.with_node(fe, (k, WIDTH / 2, 0), name=f"e{k}"), 2 * k, f"e{k}")
        stations[f"e{k}"] = [int(fe.node_sets[f"e{k}"][0])]
    twist = {f"twist {k}": reduction.NodalForces({2 * k: (0, 0, 0, 1, 0, 0)}) for k in (2, 5, 7)}
    return reduction.reduce(
        fe,
        interfaces={"left": [0], "right": [20]},
        modes=12,
        stations=stations,
        loads=twist,
        residual_vectors=tuple(twist),
    )


@cache
def solid_rail() -> fmb.ModalNeutralData:
    """Return the same rail of quadratic bricks: rigid ends, the path through nodes of its mean line."""
    block = structured("hexahedron20", (20, 4, 2), (L, WIDTH, HEIGHT))
    points = block.points - (0.0, WIDTH / 2, HEIGHT / 2)
    fe = fem.solid(replace(block, points=points), NO_POISSON)

    def node(x: float, y: float) -> int:
        found = np.flatnonzero(np.linalg.norm(points - (x, y, 0.0), axis=1) < 1e-9)
        assert len(found) == 1
        return int(found[0])

    stations = {f"{name}{k}": [node(k, y)] for k in range(11) for name, y in (("p", 0.0), ("e", WIDTH / 2))}
    twist = {}
    for k in (2, 5, 7):  # a couple of 1 N m over the section: at two nodes it would dent the solid there
        section = np.flatnonzero(np.abs(points[:, 0] - k) < 1e-9)
        about = float(np.sum(points[section, 1:] ** 2))
        twist[f"twist {k}"] = reduction.NodalForces(
            {int(n): (0, -points[n, 2] / about, points[n, 1] / about) for n in section}
        )
    return reduction.reduce(
        fe,
        interfaces={"left": "x0", "right": "x1"},
        modes=12,
        stations=stations,
        loads=twist,
        residual_vectors=tuple(twist),
        stress=False,
        compare=0,
    )


def loaded(at: float, data: fmb.ModalNeutralData) -> fmb.Model:
    """Return a rail, its ends held against twist too; a carriage at x = `at` is pressed down beside it."""
    axis, along = fmb.Pose.axes(z=(0, 1, 0), x=(1, 0, 0)), {"z": (1, 0, 0), "x": (0, 1, 0)}
    wheels = {
        "front": (-BASE / 2, 0, 0),
        "rear": (BASE / 2, 0, 0),
        "edge": (-BASE / 2, WIDTH / 2, 0),
        "load": (0, ASIDE, 0),
    }
    path = {name: [f"rail.{name}{k}" for k in range(11)] for name in "pe"}
    rollers = [
        fmb.PointOnPath(wheel, markers=(path[line][0], f"carriage.{wheel}"), through=path[line][1:], normal=normal)
        for wheel, line, normal in (("front", "p", None), ("rear", "p", None), ("edge", "e", "z"))
    ]
    untwisted = {
        "left": fmb.AxisCosine("c", markers=("ground.l", "rail.left"), axes=("z", "y")),
        "right": fmb.AxisCosine("c", markers=("ground.r", "rail.right"), axes=("x", "y")),
    }
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"l": axis, "r": fmb.Pose.axes((L, 0, 0), **along), "front": (0, 0, 0)}),
            fmb.FloatingBody("rail", data=data, markers={"left": axis, "right": fmb.Pose.axes(**along)}),
            fmb.RigidBody("carriage", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(at, 0, 0), markers=wheels),
        ],
        joints=[
            fmb.Spherical("left", markers=("ground.l", "rail.left")),
            fmb.InLine("right", markers=("ground.r", "rail.right")),
            *(fmb.Constraint(f"no twist {end}", over=[sensor], equation="c = 0") for end, sensor in untwisted.items()),
            *rollers,
            fmb.Constraint("pull", over=[fmb.Position("x", marker="carriage.center")], equation=f"x[0] = {at}"),
        ],
        forces=[fmb.PointLoad("weight", marker="carriage.load", force=(0, 0, -FORCE))],
        sensors=[
            *(fmb.Position(wheel, marker=f"carriage.{wheel}") for wheel in ("front", "rear", "center")),
            fmb.AxisCosine("roll", markers=("ground.front", "carriage.edge"), axes=("z", "y")),
            fmb.AxisCosine("pitch", markers=("ground.front", "carriage.edge"), axes=("z", "x")),
            *(fmb.Reaction(f"{wheel} force", joint=wheel) for wheel in ("front", "rear", "edge")),
        ],
    )


def deflection(x: float, forces: dict[float, float]) -> float:
    total = 0.0
    for place, force in forces.items():
        near, b = (x, L - place) if x <= place else (L - x, place)
        total += force * b * near * (L**2 - b**2 - near**2) / (6.0 * L * EI)
    return total


@pytest.mark.parametrize("data", [rail, solid_rail])
@pytest.mark.parametrize("at", [2.5, 5.5, 7.5])
def test_place_and_direction_of_the_carriage(at, data):
    """The carriage sinks and turns as the bent and twisted rail does; the edge roller takes the moment.

    The front roller is at a knot: twist under a moment has a kink, which the path smooths between its knots.
    """
    solution = fmb.statics(loaded(at, data()))
    edge = FORCE * ASIDE / (WIDTH / 2)
    found = [solution[f"{wheel} force"][-1, 2] for wheel in ("front", "rear", "edge")]
    assert found[2] == pytest.approx(edge, rel=2e-3)
    assert sum(found) == pytest.approx(FORCE, rel=1e-6)
    forces = {at - BASE / 2: found[0] + found[2], at + BASE / 2: found[1]}
    low, high = (deflection(at + side * BASE / 2, forces) for side in (-1, 1))
    assert -solution["front"][-1, 2] == pytest.approx(low, rel=3e-3)
    assert -solution["rear"][-1, 2] == pytest.approx(high, rel=3e-3)
    assert solution["pitch"][-1] == pytest.approx((low - high) / BASE, abs=3e-3 * low / BASE)
    front = at - BASE / 2
    torsion = (STEEL if data is rail else NO_POISSON).shear * SECTION.torsion
    twist = FORCE * ASIDE * front * (L - front) / (L * torsion)
    # a solid is a beam from its own width on: half of it, before and behind the couple, is not in the closed form
    within = 1e-2 * twist if data is rail else FORCE * ASIDE * WIDTH / 2 / torsion
    assert solution["roll"][-1] == pytest.approx(-twist, abs=within)


@pytest.mark.parametrize("at", [2.5, 5.0, 7.3])
def test_a_carriage_on_a_beam_in_absolute_coordinates(at):
    """Two rollers on an `AncfBeam`, also between its nodes: places and direction in closed form."""
    beam = fmb.AncfBeam(
        "rail",
        points=((0, 0, 0), (L, 0, 0)),
        elements=10,
        section=SECTION,
        material=STEEL,
        markers={f"p{k}": k / 20 for k in range(21)},
    )
    axis, wheels = fmb.Pose.axes(z=(0, 1, 0), x=(1, 0, 0)), {"front": (-BASE / 2, 0, 0), "rear": (BASE / 2, 0, 0)}
    through = [f"rail.p{k}" for k in range(1, 21)]
    share = 0.3  # the load is nearer to the front roller
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"l": axis, "r": fmb.Pose.axes((L, 0, 0), z=(1, 0, 0)), "up": (0, 0, 0)}),
            beam,
            fmb.RigidBody(
                "carriage",
                mass=1.0,
                inertia=(0.1, 0.1, 0.1),
                at=(at, 0, 0),
                markers={**wheels, "load": ((share - 0.5) * BASE, 0, 0)},
            ),
        ],
        joints=[
            fmb.Spherical("left", markers=("ground.l", "rail.p0")),
            fmb.InLine("right", markers=("ground.r", "rail.p20")),
            *(fmb.PointOnPath(w, markers=("rail.p0", f"carriage.{w}"), through=through) for w in wheels),
            fmb.Constraint("pull", over=[fmb.Position("x", marker="carriage.center")], equation=f"x[0] = {at}"),
            fmb.Constraint(
                "upright",
                over=[fmb.AxisCosine("c", markers=("ground.up", "carriage.center"), axes=("z", "y"))],
                equation="c = 0",
            ),
        ],
        forces=[fmb.PointLoad("weight", marker="carriage.load", force=(0, 0, -FORCE))],
        sensors=[
            *(fmb.Position(wheel, marker=f"carriage.{wheel}") for wheel in wheels),
            fmb.AxisCosine("pitch", markers=("ground.up", "carriage.center"), axes=("z", "x")),
            *(fmb.Reaction(f"{wheel} force", joint=wheel) for wheel in wheels),
        ],
    )
    solution = fmb.statics(model)
    front, rear = (abs(solution[f"{wheel} force"][-1, 2]) for wheel in wheels)
    assert rear == pytest.approx(share * FORCE, rel=2e-3)
    assert front == pytest.approx((1.0 - share) * FORCE, rel=2e-3)
    forces = {at - BASE / 2: front, at + BASE / 2: rear}
    low, high = (deflection(at + side * BASE / 2, forces) for side in (-1, 1))
    assert -solution["front"][-1, 2] == pytest.approx(low, rel=3e-3)
    assert -solution["rear"][-1, 2] == pytest.approx(high, rel=3e-3)
    assert solution["pitch"][-1] == pytest.approx((low - high) / BASE, abs=3e-3 * low / BASE)


def test_a_carriage_that_jams():
    """On a path through several bodies it stays where it is: 2 m/s for 0.7 s end at 0.4 m + 1.4 m, beside marker c."""
    rail = fmb.RigidBody("rail", mass=5.0, inertia=(1, 1, 1), at=(2, 0, 0), markers={"c": (0, 0, 0), "d": (1, 0, 0)})
    slider = fmb.RigidBody("slider", mass=1.0, inertia=(1, 1, 1), at=(0.4, 0, 0), velocity=(2.0, 0, 0))
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"a": (0, 0, 0), "b": (1, 0, 0), "r": (2, 0, 0)}), rail, slider],
        joints=[
            fmb.Fixed("held", markers=("ground.r", "rail.c")),
            fmb.PointOnPath("p", markers=("ground.a", "slider.center"), through=("ground.b", "rail.c", "rail.d")),
        ],
        sensors=[fmb.Position("r", marker="slider.center"), fmb.Velocity("v", marker="slider.center")],
        events=[fmb.Event("jam", at=0.7, then=fmb.Lock("p"))],
    )
    solution = fmb.simulate(model, 1.5, samples=16)
    assert len(solution.phases) == 2
    np.testing.assert_allclose(solution["r"][-1], (1.8, 0, 0), atol=1e-5)
    np.testing.assert_allclose(solution["v"][-1], 0.0, atol=1e-8)
