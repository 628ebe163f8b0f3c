"""Two elastic rods of one section strike each other (St. Venant 1867; Goldsmith, Impact, ch. 2).

Waves of the speed c = sqrt(E / rho) run through both. The force is rho c A v / 2 until the wave in the longer one, of
length L, is back after 2 L / c. Then the shorter one, of length l, is at rest, and the centre of the longer one moves
with l / L of the speed: a restitution of l / L without any loss.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction

YOUNG, DENSITY, WIDTH, SPEED = 210e9, 7850.0, 0.02, 1.0
WAVE = (YOUNG / DENSITY) ** 0.5
LENGTHS = {"short": 0.5, "long": 1.0}


def rod(length: float, elements: int) -> fmb.ModalNeutralData:
    """Return a rod along x with all its modes."""
    points = np.column_stack([np.linspace(0.0, length, elements + 1), np.zeros((elements + 1, 2))])
    steel = fmb.Material(young=YOUNG, poisson=0.3, density=DENSITY)
    fe = fem.frame(points=points, section=fem.Section.rectangle(WIDTH, WIDTH), material=steel)
    ends = {"tail": [0], "tip": [elements]}
    return reduction.reduce(fe, interfaces=ends, modes=6 * (elements + 1) - 12, stress=False, compare=0)


def collision(elements: int, law) -> fmb.Model:
    """Return the rods, with small balls on the ends that meet."""
    short, long = rod(LENGTHS["short"], elements // 2), rod(LENGTHS["long"], elements)
    return fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.FloatingBody("short", data=short, at=(-0.51, 0, 0), velocity=(SPEED, 0, 0)),
            fmb.FloatingBody("long", data=long, at=(0.01, 0, 0)),
        ],
        surfaces=[
            fmb.Surface("s", marker="short.tip", shape=fmb.Sphere(0.01)),
            fmb.Surface("l", marker="long.tail", shape=fmb.Sphere(0.01)),
        ],
        forces=[fmb.SurfaceContact("strike", surfaces=("s", "l"), law=law)],
        sensors=[fmb.ForceOf("F", force="strike")],
    )


@pytest.mark.parametrize(("elements", "within"), [(20, 0.03), pytest.param(40, 0.015, marks=pytest.mark.slow)])
def test_waves_and_restitution_of_st_venant(elements, within):
    """By impulses without restitution, half an element's wave time a step: the nodes that meet stick, and the waves
    part the rods. The nodes have a mass, so both errors halve with the elements."""
    step = 0.5 * LENGTHS["long"] / elements / WAVE
    there_and_back = 2.0 * LENGTHS["long"] / WAVE
    model = collision(elements, fmb.Rigid())
    solution = fmb.simulate(model, 1.5 * there_and_back, integrator=fmb.MoreauJean(step=step), samples=401)
    force = np.abs(np.asarray(solution["F"])[:, 0])
    pressed = force > 1e-3 * force.max()
    plateau = 0.5 * DENSITY * WAVE * WIDTH**2 * SPEED
    assert np.median(force[pressed]) == pytest.approx(plateau, rel=within)
    assert np.ptp(solution.t[pressed]) == pytest.approx(there_and_back, rel=2.5 * within)
    series = solution.series()
    mean = {}
    for name, length in LENGTHS.items():
        momentum = series.model.body(name, "test").momentum(*series.coordinates(name))[-1, 0]
        mean[name] = momentum / (DENSITY * WIDTH**2 * length)
    assert mean["short"] == pytest.approx(0.0, abs=within * SPEED)
    assert mean["long"] == pytest.approx(0.5 * SPEED, abs=within * SPEED)
