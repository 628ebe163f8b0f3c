"""A flexible beam that is drawn over rollers which stand still: the path moves, the points do not.

References: a beam on two supports with an overhang at either end under its own weight (Roark's Formulas for Stress and
Strain, table 8.1, by superposition); a beam on three supports by the equation of three moments (Clapeyron). In motion,
the reduced beam beside the one in absolute nodal coordinates, which shares nothing with it but the joint.
"""

from functools import cache

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

L, HEIGHT, WIDTH, G = 6.0, 0.06, 0.10, 9.81
STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
SECTION = fem.Section.rectangle(WIDTH, HEIGHT)
EI = STEEL.young * WIDTH * HEIGHT**3 / 12.0
WEIGHT = STEEL.density * WIDTH * HEIGHT * G
"""Per length, N/m."""
KNOTS = 24


@cache
def reduced() -> fmb.ModalNeutralData:
    x = np.linspace(0.0, L, KNOTS + 1)
    fe = fem.frame(
        points=np.column_stack([x, 0 * x, 0 * x]),
        section=SECTION,
        material=STEEL,
        orientation=(0, 1, 0),
        shear=False,
        rotary_inertia=False,
    )
    return reduction.reduce(
        fe,
        interfaces={"tail": [0], "tip": [KNOTS]},
        modes=14,
        stations={f"p{k}": [k] for k in range(1, KNOTS)},
        geometric_stiffness=True,
    )


def beam(kind: str, behind: float):
    """Return the beam, its tail at x = -behind, and the names of its knots from tail to tip."""
    if kind == "reduced":
        own = fmb.FloatingBody("beam", data=reduced(), at=(-behind, 0, 0), geometric_stiffness=True)
        return own, ["beam.tail", *(f"beam.p{k}" for k in range(1, KNOTS)), "beam.tip"]
    own = fmb.AncfBeam(
        "beam",
        points=((-behind, 0, 0), (L - behind, 0, 0)),
        elements=KNOTS // 2,
        section=SECTION,
        material=STEEL,
        markers={f"p{k}": k / KNOTS for k in range(KNOTS + 1)},
    )
    return own, [f"beam.p{k}" for k in range(KNOTS + 1)]


def drawn(kind: str, behind: float, rollers, travel: str = "0*t") -> fmb.Model:
    """Return the beam on rollers at x = `rollers`; its tail is at x = travel - behind."""
    own, path = beam(kind, behind)
    places = {f"r{k}": (x, 0, 0) for k, x in enumerate(rollers)}
    joints = [fmb.PointOnPath(r, markers=(path[0], f"ground.{r}"), through=path[1:]) for r in places]
    joints.append(
        fmb.Constraint("drive", over=[fmb.Position("x", marker=path[0])], equation=f"x[0] = {travel} - {behind}")
    )
    if kind == "reduced":  # nothing else holds it against rolling about its length
        roll = fmb.AxisCosine("c", markers=("ground.origin", path[0]), axes=("z", "y"))
        joints.append(fmb.Constraint("upright", over=[roll], equation="c = 0"))
    return fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(markers=places), own],
        joints=joints,
        sensors=[
            fmb.Position("tip", marker=path[-1]),
            fmb.Position("tail", marker=path[0]),
            *(fmb.Reaction(r, joint=r) for r in places),
        ],
    )


def overhanging(behind: float, span: float) -> tuple[float, float, float]:
    """Return how far the tip sinks, m, and the forces of the rear and the front roller, N."""
    ahead = L - behind - span
    back, front = WEIGHT * behind**2 / 2.0, WEIGHT * ahead**2 / 2.0
    slope = (-WEIGHT * span**3 / 24.0 + front * span / 3.0 + back * span / 6.0) / EI
    moment = WEIGHT * L * (L / 2.0 - behind)
    force = moment / span
    return slope * ahead + WEIGHT * ahead**4 / (8.0 * EI), WEIGHT * L - force, force


@pytest.mark.parametrize("kind", ["reduced", "ancf"])
@pytest.mark.parametrize("behind", [2.0, 1.37, 0.6])
def test_a_beam_on_two_rollers(kind, behind):
    """At knots of the path and between them."""
    span = 2.1
    solution = fmb.statics(drawn(kind, behind, (0.0, span)))
    sinks, rear, front = overhanging(behind, span)
    found = [abs(solution[f"r{k}"][-1, 2]) for k in (0, 1)]
    np.testing.assert_allclose(found, (abs(rear), front), rtol=2e-3, atol=2e-3 * WEIGHT * L)
    assert -solution["tip"][-1, 2] == pytest.approx(sinks, rel=5e-3)


@pytest.mark.parametrize("kind", ["reduced", "ancf"])
def test_a_beam_on_three_rollers(kind):
    """Statically indeterminate: the moment over the middle roller by the equation of three moments."""
    behind, one, two = 0.7, 1.9, 2.2
    ahead = L - behind - one - two
    back, front = WEIGHT * behind**2 / 2.0, WEIGHT * ahead**2 / 2.0
    middle = (WEIGHT * (one**3 + two**3) / 4.0 - back * one - front * two) / (2.0 * (one + two))  # hogging
    first = WEIGHT * behind + WEIGHT * one / 2.0 + (back - middle) / one
    last = WEIGHT * ahead + WEIGHT * two / 2.0 + (front - middle) / two
    solution = fmb.statics(drawn(kind, behind, (0.0, one, one + two)))
    found = [abs(solution[f"r{k}"][-1, 2]) for k in range(3)]
    np.testing.assert_allclose(found, (first, WEIGHT * L - first - last, last), rtol=5e-3)


@pytest.mark.slow
def test_a_beam_that_is_drawn_over_rollers():
    """In 0.35 s by 1.2 m, from rest to rest: both kinds of beams tell the same motion of the tip and the same forces.

    The drive pulls and pushes along the beam, which stiffens and softens it: without geometric stiffness the reduced
    beam is 2.8 % off already when the same way takes 0.6 s.
    """
    behind, span, time, way = 2.0, 2.1, 0.35, 1.2
    travel = f"{way}*(t/{time} - sin(2*pi*t/{time})/(2*pi))"
    found = {}
    for kind in ("reduced", "ancf"):
        model = drawn(kind, behind, (0.0, span), travel)
        found[kind] = fmb.simulate(model, time, samples=61, start="equilibrium")
        assert found[kind]["tail"][-1, 0] == pytest.approx(way - behind, abs=1e-6)
    one, two = found["reduced"], found["ancf"]
    tip = two["tip"][:, 2]
    largest = np.abs(tip).max()
    slow = np.array([-overhanging(-x, span)[0] for x in two["tail"][:, 0]])
    assert np.abs(tip - slow).max() > 0.1 * largest  # it swings: statics would not do
    np.testing.assert_allclose(one["tip"][:, 2], tip, atol=5e-3 * largest)
    for roller in ("r0", "r1"):
        np.testing.assert_allclose(one[roller][1:, 2], two[roller][1:, 2], atol=2e-2 * np.abs(two[roller][:, 2]).max())
