"""Blocks of states that are factorised together: the same matrix and solution, in fewer blocks."""

from __future__ import annotations

import numpy as np
import pytest
from tolerances import MACHINE

import flexmb as fmb
from flexmb.math.block_lu import lu_factor
from flexmb.math.block_parts import parts_of
from flexmb.math.block_pattern import stored
from flexmb.math.block_substitution import lu_solve
from flexmb.math.weights import weigh
from flexmb.system import compile
from flexmb.system.pattern import joined_blocks
from flexmb.system.program import evaluate

ALONG_X = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))


def carts(n: int, lags: int) -> fmb.Model:
    """Return carts on rails, each pushed by a chain of lags behind its place."""
    bodies = [fmb.RigidBody(f"cart{k}", mass=1.0, inertia=(1, 1, 1), markers={"x": ALONG_X}) for k in range(n)]
    forces = []
    for k in range(n):
        late = fmb.measured(f"x{k}")
        for number in range(lags):
            late = fmb.Lag(late, time=0.1 + 0.05 * number)
        forces.append(fmb.Actuator(f"motor{k}", joint=f"rail{k}", effort=-3.0 * late + 1.0))
    return fmb.Model(
        bodies=[fmb.Ground(markers={"x": ALONG_X}), *bodies],
        joints=[fmb.Prismatic(f"rail{k}", markers=("ground.x", f"cart{k}.x")) for k in range(n)],
        forces=forces,
        sensors=[fmb.JointCoordinate(f"x{k}", joint=f"rail{k}") for k in range(n)],
    )


@pytest.mark.parametrize(("n", "lags"), [(1, 1), (1, 7), (3, 4), (2, 30)])
def test_solution_is_that_of_a_dense_solver(n, lags, rng):
    system = compile(carts(n, lags))
    work = system.workspace()
    weigh(work.weights, 1.0, 1e-2, 1e-4)
    evaluate(system.program, system.state(), work)
    pattern = system.program.pattern
    A, b = stored(work.S, pattern).toarray(), rng.normal(size=system.nu + system.ng)
    x = b.copy()
    assert lu_factor(work.S, pattern) == -1
    lu_solve(work.S, pattern, x)
    np.testing.assert_allclose(A @ x, b, atol=1e4 * MACHINE * max(1.0, np.abs(x).max()))
    rows = np.diff(pattern.block_start)
    assert rows.sum() == len(A)
    assert len(rows) < n * (lags + 2) or lags == 1
    assert len(parts_of(pattern).start) - 1 == n  # carts that nothing couples stay apart


def test_what_shares_no_column_is_not_joined():
    """Two states that only their own bodies couple."""
    sizes, order, after = [6, 6, 1, 1], [2, 3, 0, 1], [[0], [1], [], []]
    groups, later = joined_blocks(sizes, order, after, range(2, 4))
    assert groups == [[2], [3], [0], [1]]
    assert later == [[2], [3], [], []]


def test_what_is_left_behind_knows_each_other():
    """A state of one body and one of another that follow each other: joined, both bodies are coupled."""
    sizes, order, after = [6, 6, 1, 1], [2, 3, 0, 1], [[3, 0], [0, 1], [1], []]
    groups, later = joined_blocks(sizes, order, after, range(2, 4))
    assert groups == [[2, 3], [0], [1]]
    assert later == [[1, 2], [2], []]


def test_large_blocks_are_not_joined():
    """Two state spaces of forty states at the same body, which do not know each other."""
    sizes, order, after = [6, 40, 40], [1, 2, 0], [[0], [0], []]
    assert joined_blocks(sizes, order, after, range(1, 3))[0] == [[1], [2], [0]]
