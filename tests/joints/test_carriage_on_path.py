"""A carriage on a rail that bends and twists: two rollers one behind the other, a third beside the front one.

Reference: a simply supported beam under two forces by Euler and Bernoulli, w(x) = P b x (L^2 - b^2 - x^2)/(6 L EI) for
x up to the place L - b of the force, and by Saint-Venant its twist under a moment at a, T a (L - a)/(L GJ).
"""

from functools import cache

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

L, HEIGHT, WIDTH = 10.0, 0.1, 0.2
STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
SECTION = fem.Section.rectangle(WIDTH, HEIGHT)
EI = STEEL.young * WIDTH * HEIGHT**3 / 12.0
GJ = STEEL.young / 2.6 * SECTION.torsion
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


def loaded(at: float) -> fmb.Model:
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
            fmb.FloatingBody("rail", data=rail(), markers={"left": axis, "right": fmb.Pose.axes(**along)}),
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


@pytest.mark.parametrize("at", [2.5, 5.5, 7.5])
def test_place_and_direction_of_the_carriage(at):
    """The carriage sinks and turns as the bent and twisted rail does; the edge roller takes the moment.

    The front roller is at a knot: twist under a moment has a kink, which the path smooths between its knots.
    """
    solution = fmb.statics(loaded(at))
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
    twist = FORCE * ASIDE * front * (L - front) / (L * GJ)
    assert solution["roll"][-1] == pytest.approx(-twist, rel=1e-2)


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
