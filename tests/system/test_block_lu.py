"""The static-pattern LU against a dense solver, on trees, loops and redundant models; the elimination order."""

from dataclasses import replace

import numpy as np
import pytest
from contracts.random_models import connected
from tolerances import MACHINE
from verification.mechanisms import four_bars

import flexmb as fmb
from flexmb.math.block_lu import eliminate, lu_factor, on_demand_for
from flexmb.math.block_parts import parts_of, solve_part
from flexmb.math.block_pattern import stored
from flexmb.math.block_substitution import lu_solve
from flexmb.math.weights import weigh
from flexmb.system import compile
from flexmb.system.program import evaluate


def chain(n: int) -> fmb.Model:
    """A chain of rods with ball joints."""
    rods = [fmb.RigidBody.rod(f"r{k}", length=1.0, mass=1.0, radius=0.1, at=(k, 0, 0)) for k in range(n)]
    names = ["ground.origin"] + [f"r{k}.end" for k in range(n)]
    joints = [fmb.Spherical(f"j{k}", markers=(names[k], f"r{k}.start")) for k in range(n)]
    return fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), *rods], joints=joints)


def matrix(model):
    """Return the system with its iteration matrix written at the start, weights as in a step of 10 ms."""
    system = compile(model)
    work = system.workspace()
    weigh(work.weights, 1.0, 1e-3, 1e-5, half_step=5e-3)
    regularisation = np.full(system.ng, 1e-6)
    program = system.program._replace(regularisation=regularisation)
    evaluate(program, system.state(), work)
    return system, work


@pytest.mark.parametrize("name", ["chain", "four bars", "random"])
def test_solution_is_that_of_a_dense_solver(name, rng):
    model = {
        "chain": lambda: chain(12),
        "four bars": lambda: four_bars(3),
        "random": lambda: connected("Cylindrical", "rigid-floating", rng),
    }[name]()
    system, work = matrix(model)
    A = stored(work.S, system.program.pattern).toarray()
    b = rng.normal(size=len(A))
    x = b.copy()
    assert lu_factor(work.S, system.program.pattern) == -1
    lu_solve(work.S, system.program.pattern, x)
    np.testing.assert_allclose(A @ x, b, atol=1e4 * MACHINE * max(1.0, np.abs(x).max()))
    np.testing.assert_allclose(x, np.linalg.solve(A, b), rtol=1e-6, atol=1e-6 * np.abs(x).max())


def test_blocks_of_other_sizes_are_eliminated_on_demand():
    """A body on one joint has earlier blocks of six rows only; the three of a ball joint come before the next body."""
    assert on_demand_for(compile(chain(1)).program.pattern) == ()
    assert on_demand_for(compile(chain(2)).program.pattern) == (eliminate,)
    assert eliminate._cell.value is not None  # with the model: steps that are called by address pass no errors on


def test_parts_that_touch_nothing_are_solved_alone(rng):
    """Two chains and a free body, one after another, against a dense solver."""
    both = [chain(3), chain(2)]
    bodies = [replace(b, name=f"{k}{b.name}") for k, m in enumerate(both) for b in m.bodies[1:]]
    joints = [
        replace(
            j,
            name=f"{k}{j.name}",
            markers=tuple(m if m.startswith("ground") else f"{k}{m}" for m in j.markers),
        )
        for k, m in enumerate(both)
        for j in m.joints
    ]
    free = fmb.RigidBody("free", mass=2.0, inertia=(1.0, 2.0, 3.0), at=(5, 5, 5))
    system, work = matrix(fmb.Model(bodies=[fmb.Ground(), *bodies, free], joints=joints))
    pattern = system.program.pattern
    parts = parts_of(pattern)
    assert len(parts.start) == 4
    A = stored(work.S, pattern).toarray()
    b, given = rng.normal(size=len(A)), np.zeros(len(A))
    x = b.copy()
    assert lu_factor(work.S, pattern) == -1
    for part in range(3):
        solve_part(work.S, pattern, parts, part, x, given)
    np.testing.assert_allclose(x, np.linalg.solve(A, b), rtol=1e-6, atol=1e-6 * np.abs(x).max())


def test_a_singular_matrix_reports_its_row(rng):
    system, work = matrix(chain(3))
    work.S[:] = 0.0
    assert lu_factor(work.S, system.program.pattern) == 0


def test_matrices_of_one_pattern_keep_their_own_factors(rng):
    """A second matrix, of other weights, is factorised between the two steps of solving with the first."""
    system, work = matrix(connected("Cylindrical", "rigid-floating", rng))
    pattern, other = system.program.pattern, work.S * rng.uniform(0.5, 2.0, len(work.S))
    b = rng.normal(size=system.nu + system.ng)
    assert lu_factor(work.S, pattern) == -1
    first, again = b.copy(), b.copy()
    lu_solve(work.S, pattern, first)
    lu_factor(other, pattern)
    lu_solve(work.S, pattern, again)
    np.testing.assert_array_equal(again, first)


@pytest.mark.parametrize("n", [10, 20, 40])
def test_storage_of_a_chain_grows_linearly(n):
    """Bodies are eliminated before their multipliers, from both ends: 12 rows of at most 24 entries per link."""
    system = compile(chain(n))
    assert system.program.pattern.row_start[-1] <= 9 * 24 * n
