"""Accelerations by one evaluation, refined by the matrix itself, where equations are given several times.

Reference: Udwadia & Phohomsiri's formula as printed, by pseudo-inverses of `fmb.equations`; a dense product.
"""

from dataclasses import replace

import numpy as np
import pytest
from contracts.random_models import connected
from integrate.test_random_constraints import random_model
from verification.mechanisms import four_bars

import flexmb as fmb
from flexmb.math.block_pattern import stored
from flexmb.math.block_substitution import subtract_product
from flexmb.math.weights import weigh
from flexmb.system import assemble
from flexmb.system.accelerations import linear_accelerations
from flexmb.system.program import evaluate


def massless() -> fmb.Model:
    """A mass between two springs beside a weightless carriage, which an equation, given twice, leads."""
    spring = {"stiffness": 40.0, "length": 0.5, "damping": 0.3}
    bodies = [
        fmb.Ground(),
        fmb.PointMass("carriage", mass=0.0, at=(0.6, 0.1, 0)),
        fmb.PointMass("bob", mass=1.3, at=(1.3, 0, 0.2), velocity=(0.2, 0, 1.0)),
    ]
    over = [fmb.Position("c", marker="carriage.center"), fmb.Position("b", marker="bob.center")]
    led = [f"{k}*(b[0] - c[0]) = {k}*0.7" for k in (1.0, 2.0)] + ["c[1] - b[1] = 0.1", "c[2] = 0"]
    return fmb.Model(
        bodies=bodies,
        forces=[
            fmb.SpringDamper("s", markers=("ground.origin", "carriage.center"), **spring),
            fmb.SpringDamper("r", markers=("carriage.center", "bob.center"), **spring),
        ],
        joints=[fmb.Constraint(f"e{k}", over=over, equation=text) for k, text in enumerate(led)],
        gravity=(0, -9.81, 0),
    )


MODELS = {
    "one constraint and its double": lambda: random_model(np.random.default_rng(71), 1),
    "four constraints, a double, elastic": lambda: random_model(np.random.default_rng(72), 4, True),
    "planar loops": lambda: replace(four_bars(3), gravity=(0.3, -9.81, 0.2)),
    "weightless": massless,
}


@pytest.mark.parametrize("name", MODELS)
def test_accelerations_are_those_of_pseudo_inverses(name):
    model = MODELS[name]()
    system, state = assemble(model)
    assert len(system.redundant) > 0
    e = fmb.equations(model)
    diagonal = np.diag(e.M)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    M, A, Q = scale[:, None] * e.M * scale, e.A * scale, scale * e.Q
    inverse = np.linalg.pinv(A, rcond=1e-9)
    project = np.eye(len(M)) - inverse @ A
    expected = scale * (np.linalg.pinv(np.vstack([project @ M, A]), rcond=1e-9) @ np.concatenate([project @ Q, e.b]))
    right = np.zeros(system.nu + system.ng)
    assert linear_accelerations(system.program, state, system.workspace(), right) == -1
    np.testing.assert_allclose(state.a, expected, atol=1e-10 * np.abs(expected).max())
    force = e.M @ expected - e.Q
    np.testing.assert_allclose(e.A.T @ state.lam, force, atol=1e-9 * np.abs(force).max())


@pytest.mark.parametrize("name", ["four bars", "random"])
def test_product_is_that_of_the_dense_matrix(name, rng):
    model = four_bars(3) if name == "four bars" else connected("Cylindrical", "rigid-floating", rng)
    system, state = assemble(model)
    work = system.workspace()
    weigh(work.weights, 1.0, 1e-3, 1e-5, half_step=5e-3)
    evaluate(system.program, state, work)
    A, x = stored(work.S, system.program.pattern).toarray(), rng.normal(size=len(state.u) + len(state.lam))
    b = rng.normal(size=len(x))
    left = b.copy()
    subtract_product(work.S, system.program.pattern, x, left)
    np.testing.assert_allclose(left, b - A @ x, atol=1e-13 * np.abs(A).max() * len(x))
