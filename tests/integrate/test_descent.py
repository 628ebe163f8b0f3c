"""`statics` from bent states and near buckling: what is found does not depend on where the iteration begins."""

import numpy as np
import pytest
from by_turns import every_second, slow

import flexmb as fmb
from flexmb import fem
from flexmb.integrate.equilibria.descent import Descent
from flexmb.system import assemble

SIDE, LENGTH = 0.02, 1.0
STEEL = fmb.Material(young=210e9, poisson=0.3, density=7850.0)
EULER = np.pi**2 * STEEL.young * SIDE**4 / 12 / (4 * LENGTH**2)


def cantilever(force):
    """Eight beam elements along x, clamped at the start, with a dead force at the end."""
    beam = fmb.AncfBeam(
        "beam",
        points=[(0.0, 0.0, 0.0), (LENGTH, 0.0, 0.0)],
        elements=8,
        section=fem.Section.rectangle(SIDE, SIDE),
        material=STEEL,
    )
    return fmb.Model(
        bodies=[fmb.Ground(markers={"wall": (0.0, 0.0, 0.0)}), beam],
        joints=[fmb.Fixed("clamp", markers=("ground.wall", "beam.start"))],
        forces=[fmb.PointLoad("load", marker="beam.end", force=force)],
        sensors=[fmb.Position("tip", marker="beam.end")],
    )


@pytest.fixture(scope="module")
def bent():
    return fmb.statics(cantilever((0.0, 0.0, -5600.0)))


@pytest.mark.parametrize("load", [slow(5605.6), 5656.0, slow(6000.0), slow(8000.0), 3000.0, slow(0.1), -5600.0])
def test_from_a_bent_state(bent, load):
    """From the equilibrium at 5600 N that of any other load is found, the same as from the straight beam."""
    model = cantilever((0.0, 0.0, -load))
    found, expected = fmb.statics(model, state=bent), fmb.statics(model)
    np.testing.assert_allclose(found["tip"][-1], expected["tip"][-1], atol=1e-7 * LENGTH)
    assert found.statistics["iterations"] <= 60


ELASTICA = {1.063: (0.881, 0.422), 1.152: (0.741, 0.593), 1.518: (0.349, 0.792), 2.541: (-0.107, 0.750)}


@pytest.mark.parametrize(("ratio", "side"), every_second(ELASTICA, [1.0, -10.0]))
def test_a_buckled_column_goes_with_its_side_load(ratio, side):
    """The elastica of a column above Euler's load (Timoshenko & Gere, Theory of Elastic Stability, table 2-4)."""
    along, across = ELASTICA[ratio]
    tip = fmb.statics(cantilever((-ratio * EULER, 0.0, side)))["tip"][-1]
    assert np.sign(tip[2]) == np.sign(side)
    np.testing.assert_allclose([tip[0], abs(tip[2])], [along * LENGTH, across * LENGTH], atol=0.012 * LENGTH)


@pytest.mark.parametrize("ratio", [0.9, 0.99])
def test_a_column_below_its_buckling_load(ratio):
    """Beam column: tip = H / (k P) (tan kL - kL), k^2 = P / EI (Timoshenko & Gere, sec. 1.3)."""
    side, P = 0.02, ratio * EULER
    k = 0.5 * np.pi / LENGTH * np.sqrt(ratio)
    tip = fmb.statics(cantilever((-P, 0.0, side)))["tip"][-1]
    assert tip[2] == pytest.approx(
        side / (k * P) * (np.tan(k * LENGTH) - k * LENGTH), rel=0.15 if ratio > 0.95 else 0.02
    )


@pytest.mark.parametrize("length", [1e-9, 1.0, 1e6])
def test_bounds_of_a_search_follow_the_size_of_the_model(length):
    """A search is lost a million model sizes away from where it began; turns of a counter are no places."""
    tip = fmb.RigidBody(
        "tip", mass=1.0, inertia=np.full(3, length**2), at=(length, 0, 0), markers={"a": (-length, 0, 0)}
    )
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"a": (0, 0, 0)}), tip],
        joints=[fmb.Revolute("hinge", markers=("ground.a", "tip.a"))],
        sensors=[fmb.JointCoordinate("turns", joint="hinge")],
    )
    system, state = assemble(model)
    search = Descent(system, state, system.workspace(), 0.0, state.q.copy(), True, False, True)
    search.unbalanced = 1.0
    search.path = [(state.q.copy(), state.u, state.a, state.lam)]
    at = system.body_slices["tip"][0].start
    size = system.lengths.whole
    for far, lost in ((0.5e6, False), (2e6, True)):
        search.q[at] = state.q[at] + far * size
        assert search.lost() is lost
    search.q[:] = state.q
    search.q[system.program.branches :] += 1e9
    assert not search.lost()
    search.q[at] = np.nan
    assert search.lost()
