"""Section forces and strains of cables and beams against equilibrium and closed forms."""

import numpy as np
import pytest
from tolerances import SOLVER

import flexmb as fmb
from flexmb import fem
from flexmb.errors import ModelError
from flexmb.results import recover

LENGTH, EI, GJ = 2.0, 50.0, 80.0
KINDS = {"cable": fmb.AncfCable, "beam": fmb.AncfBeam}
PLACES = (0.0, 0.21, 0.5, 0.83, 1.0)


def cantilever(kind, *, force=(0, 0, 0), moment=(0, 0, 0), places=PLACES, elements=16):
    """A slender cantilever along x under loads at its tip, with sensors at places."""
    young, poisson = 1e9, 0.25
    area, inertia = 1e5 * EI / LENGTH**2 / young, EI / young
    body = KINDS[kind](
        "b",
        points=((0, 0, 0), (LENGTH, 0, 0)),
        elements=elements,
        section=fem.Section.values(area, inertia, inertia, GJ * 2 * (1 + poisson) / young),
        material=fmb.Material(young=young, poisson=poisson, density=1000.0),
    )
    sensors = [
        sensor(f"{prefix} {100 * at:.0f}", body="b", at=at)
        for at in places
        for prefix, sensor in (("F", fmb.SectionForces), ("E", fmb.SectionStrains))
    ]
    return fmb.Model(
        bodies=(fmb.Ground(), body),
        gravity=(0, 0, 0),
        sensors=(*sensors, fmb.Position("tip", marker="b.end")),
        joints=(fmb.Fixed("clamp", markers=("ground.origin", "b.start")),),
        forces=(fmb.PointLoad("P", marker="b.end", force=force, moment=moment),),
    )


@pytest.mark.parametrize("kind", KINDS)
def test_elastica(kind):
    """P L^2 / EI = 4: at every place N = P sin, Q = P cos of the slope, M = P times the lever to the tip."""
    P = 4.0 * EI / LENGTH**2
    solution = fmb.statics(cantilever(kind, force=(0, 0, P)))
    body, q = solution.model.body("b"), solution.final.q
    line = body.line(q, PLACES)
    r, t = (line[5], line[0]) if kind == "beam" else (line[0], line[1])
    t = t / np.linalg.norm(t, axis=1)[:, None]
    lever = solution["tip"][-1, 0] - r[:, 0]
    for k, at in enumerate(PLACES):
        found, strains = solution[f"F {100 * at:.0f}"][-1], solution[f"E {100 * at:.0f}"][-1]
        expected = [P * t[k, 2], P * t[k, 0], P * lever[k]]
        axial, shear, moment = found if kind == "cable" else (found[0], found[2], -found[4])
        np.testing.assert_allclose([axial, shear, moment / LENGTH], np.array(expected) / [1, 1, LENGTH], atol=0.01 * P)
        assert strains[-1 if kind == "cable" else 4] == pytest.approx(
            (1 if kind == "cable" else -1) * moment / EI, abs=SOLVER
        )


def test_torsion():
    """A torque about the line: Mx is the torque everywhere, the twist the torque over GJ."""
    solution = fmb.statics(cantilever("beam", moment=(3.0, 0, 0), elements=4))
    np.testing.assert_allclose([solution[f"F {100 * at:.0f}"][-1, 3] for at in PLACES], 3.0, rtol=SOLVER)
    np.testing.assert_allclose([solution[f"E {100 * at:.0f}"][-1, 3] for at in PLACES], 3.0 / GJ, rtol=SOLVER)


def test_recovery_at_many_places_and_times():
    """recover gives for all samples what the sensors give one by one."""
    solution = fmb.statics(cantilever("beam", force=(1.0, 2.0, 3.0)))
    body, q = solution.model.body("b"), solution.series().coordinates("b")[0]
    forces, strains = recover.line_forces(body, q, PLACES), recover.line_strains(body, q, PLACES)
    assert forces.shape == strains.shape == (len(solution.t), len(PLACES), 6)
    for k, at in enumerate(PLACES):
        np.testing.assert_array_equal(forces[:, k], solution[f"F {100 * at:.0f}"])
        np.testing.assert_array_equal(strains[:, k], solution[f"E {100 * at:.0f}"])
    assert solution.column_titles("F 0")[4] == "My [N m]"


def test_hanging_rope_carries_what_is_below():
    """Tension at x: weight below it, N = m g (1 - x)."""
    rope = fmb.AncfCable(
        "b",
        points=((0, 0, 0), (0, 0, -3.0)),
        elements=6,
        section=fem.Section.solid_circle(0.01),
        material=fmb.MATERIALS["steel"],
    )
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(), rope),
            gravity=(0, 0, -9.81),
            joints=(fmb.Spherical("top", markers=("ground.origin", "b.start")),),
            sensors=[fmb.SectionForces(f"F {100 * at:.0f}", body="b", at=at) for at in PLACES],
        )
    )
    for at in PLACES:
        np.testing.assert_allclose(
            solution[f"F {100 * at:.0f}"][-1], [rope.mass * 9.81 * (1.0 - at), 0.0, 0.0], atol=1e-6 * rope.mass * 9.81
        )


def test_messages():
    with pytest.raises(ModelError, match=r"at = 1\.5.*a fraction of the length"):
        fmb.SectionForces("F", body="b", at=1.5)
    with pytest.raises(ModelError, match=r"body 'ground' is a Ground.*AncfCable or AncfBeam"):
        cantilever("cable").with_parts(sensors=(fmb.SectionStrains("E", body="ground"),))
    with pytest.raises(ModelError, match=r"Ground is not a line.*AncfCable or AncfBeam"):
        recover.line_forces(fmb.Ground(), np.zeros((1, 3)), 0.5)
