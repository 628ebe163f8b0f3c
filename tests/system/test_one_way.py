"""States that read bodies and other states, which do not read them: order, fill, and the solution of a dense solver."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import butter, tf2ss
from system.test_joined_states import ALONG_X, carts
from tolerances import MACHINE

import flexmb as fmb
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_parts import parts_of, solve_part
from flexmb.math.block_pattern import elimination, stored
from flexmb.math.block_substitution import lu_solve
from flexmb.math.weights import weigh
from flexmb.system import compile
from flexmb.system.one_way import both_ways, filled, states_first
from flexmb.system.pattern import block_pattern
from flexmb.system.program import evaluate


def matrix(model):
    """Return system, its stored numbers and the matrix of a step."""
    system = compile(model)
    work = system.workspace()
    weigh(work.weights, 1.0, 1e-2, 1e-4)
    evaluate(system.program, system.state(), work)
    return system, work.S, stored(work.S, system.program.pattern).toarray()


def test_states_go_from_the_last_of_a_chain_to_the_first():
    """Body 0 moves 1, 1 moves 2, 2 moves 3, and 3 the body: only 3 is read by a body."""
    reads = [{3}, {0}, {1}, {2}]
    order, later, readers = states_first([6, 1, 1, 1], range(1, 4), reads)
    assert order == [2, 1]
    assert later == [{1}, {0}]
    assert readers == [{3}, {3}]
    assert reads[3] == {0}
    assert both_ways(reads, order) == [{3}, set(), set(), {0}]
    earlier, after = filled([[2], [1], [3], [0]], [{3}, {0}, {1}, {2}])
    assert earlier == [[], [], [0, 1], [2]]
    assert after == [[1], [3], [3], []]


@pytest.mark.parametrize("seed", range(12))
def test_fill_is_that_of_a_dense_elimination(seed):
    """Random rows that read others: whatever a dense elimination makes other than zero has a place, and is solved."""
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 4, 14).tolist()
    ends = np.cumsum([0, *sizes])
    unknowns = [list(range(a, b)) for a, b in pairwise(ends)]
    states = range(5, 14)
    near = [{k - 1, k + 1} & set(range(5)) for k in range(5)] + [set() for _ in states]
    ways = [(int(i), int(j)) for i, j in rng.integers(0, 14, (22, 2)) if i != j and max(i, j) >= 5]
    pattern, place = block_pattern(unknowns, 14, [set(some) for some in near], set(), states, ways)
    S, A = np.zeros(pattern.row_start[-1]), np.zeros((ends[-1], ends[-1]))
    pairs = [(i, j) for i in range(14) for j in near[i]] + ways + [(i, i) for i in range(14)]
    for i, j in pairs:
        block = rng.normal(size=(sizes[i], sizes[j])) + (20.0 * np.eye(sizes[i]) if i == j else 0.0)
        for row, at in enumerate(place(i, j)):
            S[at : at + sizes[j]] = block[row]
        A[ends[i] : ends[i + 1], ends[j] : ends[j + 1]] = block
    np.testing.assert_array_equal(stored(S, pattern).toarray(), A)
    b = rng.normal(size=len(A))
    x = b.copy()
    assert lu_factor(S, pattern) == -1
    lu_solve(S, pattern, x)
    np.testing.assert_allclose(x, np.linalg.solve(A, b), rtol=0, atol=1e3 * MACHINE)
    parts = parts_of(pattern)
    for part in range(len(parts.start) - 1):
        own = parts.unknowns[parts.start[part] : parts.start[part + 1]]
        assert not A[np.ix_(own, np.setdiff1d(np.arange(len(A)), own))].any()
        x, given = np.where(np.isin(np.arange(len(A)), own), b, 0.0), np.zeros(len(A))
        solve_part(S, pattern, parts, part, x, given)
        np.testing.assert_allclose(x[own], np.linalg.solve(A, b)[own], rtol=0, atol=1e3 * MACHINE)


@pytest.mark.parametrize("lags", [2, 7])
def test_what_a_controller_measures_does_not_read_its_states(lags):
    """A cart pushed by the last of a chain of lags: no row but those of states changes by the first ones."""
    system, _, A = matrix(carts(1, lags))
    first = system.nu - lags
    pattern = system.program.pattern
    places = stored(np.ones(pattern.row_start[-1]), pattern).toarray() != 0.0
    read = A[:first, first : system.nu].any(axis=0)
    assert read.sum() == 1
    assert not places[:first, first : system.nu][:, ~read].any()


def test_multiplications_are_those_of_the_elimination():
    """Counted by hand over the places of a dense elimination that keeps to the pattern."""
    system, _, _ = matrix(carts(2, 3))
    pattern = system.program.pattern
    places = stored(np.ones(pattern.row_start[-1]), pattern).toarray()[np.ix_(pattern.order, pattern.order)] != 0.0
    count = sum(places[k + 1 :, k].sum() * (1 + places[k, k + 1 :].sum()) for k in range(len(places)))
    told = float(elimination(pattern).split()[-2])
    # the formula leaves out what is less than the squares of the sizes
    assert count == pytest.approx(told, rel=0.35)


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(rtol=1e-9), fmb.Implicit(rtol=1e-9), fmb.IDA(rtol=1e-9)])
def test_many_states_of_one_block_are_found_by_every_integrator(integrator):
    """A filter of eight states, more than a marker has, between place and motor of a cart: by scipy's exponential."""
    A, B, C, D = tf2ss(*butter(8, 6.0, analog=True))
    filtered = fmb.StateSpace([fmb.measured("x0")], A=A, B=B, C=C, D=D)
    model = fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": ALONG_X}),
            fmb.RigidBody("cart", mass=2.0, inertia=(1, 1, 1), markers={"x": ALONG_X}),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("motor", joint="rail", effort=-5.0 * filtered + 1.0)],
        sensors=[fmb.JointCoordinate("x0", joint="rail")],
    )
    end = 1.5
    whole = np.zeros((11, 11))  # x, v, states, and 1
    whole[0, 1] = 1.0
    whole[1, 2:10], whole[1, 0], whole[1, 10] = -2.5 * C[0], -2.5 * D[0, 0], 0.5
    whole[2:10, 2:10], whole[2:10, 0] = A, B[:, 0]
    expected = (expm(end * whole) @ np.eye(11)[10])[0]
    run = fmb.simulate(model, end, samples=3, integrator=integrator)
    assert run["x0"][-1] == pytest.approx(expected, rel=3e-6)
