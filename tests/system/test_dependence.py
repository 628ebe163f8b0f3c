"""The sparse search for dependent equations against dense ranks: how many there are, and which are named."""

import numpy as np
import pytest
from contracts.random_models import connected
from scipy import sparse
from verification import mechanisms

import flexmb as fmb
from flexmb.math.weights import weigh
from flexmb.system import assemble
from flexmb.system.dependence import dependent_rows
from flexmb.system.mobility import (
    DEPENDENT,
    SHARE,
    constraint_matrix,
    indeterminate_equations,
    mass_diagonal,
    mass_metric,
)
from flexmb.system.program import evaluate


def shuffled(model: fmb.Model, rng) -> fmb.Model:
    """Return the model with its joints in another order."""
    joints = [model.joints[k] for k in rng.permutation(len(model.joints))]
    return fmb.Model(gravity=model.gravity, bodies=model.bodies, joints=joints)


def ring(n: int) -> fmb.Model:
    """Return n four-bars, then a bar between the ends that is as long as their distance: one loop around all loops."""
    model = mechanisms.four_bars(n)
    bar = fmb.RigidBody.rod("last", length=float(n), mass=1.0, radius=0.01, at=(0, 1, 0), velocity=(1, 0, 0))
    joints = [
        fmb.Revolute("from", markers=("c0.end", "last.start")),
        fmb.Revolute("to", markers=("last.end", f"c{n}.end")),
    ]
    return fmb.Model(bodies=[*model.bodies, bar], joints=[*joints, *model.joints])


def tree(n: int, rng) -> fmb.Model:
    """Return a random tree of hinges, each with a drive; the drives come last."""
    places = np.vstack([np.zeros(3), rng.normal(size=(n, 3))])  # the ground's and the bodies'
    below = [int(rng.integers(k)) for k in range(1, n + 1)]
    markers = [{f"to {k}": places[k] - places[b] for k in range(1, n + 1) if below[k - 1] == b} for b in range(n + 1)]
    bodies = [
        fmb.RigidBody(f"b{k}", mass=1.0, inertia=(1, 1, 1), at=places[k], markers=markers[k]) for k in range(1, n + 1)
    ]
    names = ["ground", *(body.name for body in bodies)]
    hinges = [fmb.Revolute(f"j{k}", markers=(f"{names[below[k - 1]]}.to {k}", f"b{k}.center")) for k in range(1, n + 1)]
    drives = [fmb.Drive(f"d{k}", joint=f"j{k}", angle=fmb.ramp(rate=1.0, rise=0.1)) for k in range(1, n + 1)]
    return fmb.Model(bodies=[fmb.Ground(markers=markers[0]), *bodies], joints=[*hinges, *drives])


def gradients(model: fmb.Model):
    """Return the system and the gradients of all equations in the metric of the mass matrix, of length one, dense."""
    system, state = assemble(model)
    work = system.workspace()
    weigh(work.weights, 1.0)
    evaluate(system.program._replace(regularisation=np.zeros(system.ng)), state, work)
    M, G = constraint_matrix(system, work)
    A = G.toarray() / np.sqrt(mass_metric(M))
    return system, A / np.linalg.norm(A, axis=1)[:, None]


def latest(A: np.ndarray) -> list[int]:
    """Return the rows that add nothing to the span of those before them, by singular values of all that are kept."""
    kept: list[int] = []
    for k in range(len(A)):
        if np.linalg.svd(A[[*kept, k]], compute_uv=False)[-1] > DEPENDENT and len(kept) < A.shape[1]:
            kept.append(k)
    return sorted(set(range(len(A))) - set(kept))


MECHANISMS = {
    "parallelogram": lambda reference, rng: mechanisms.four_bars(1),
    "six four-bars": lambda reference, rng: mechanisms.four_bars(6),
    "six four-bars, joints in another order": lambda reference, rng: shuffled(mechanisms.four_bars(6), rng),
    "a loop around loops": lambda reference, rng: ring(5),
    "a loop around loops, joints in another order": lambda reference, rng: shuffled(ring(5), rng),
    "Bricard": lambda reference, rng: mechanisms.bricard(reference("RB04")),
    "Bricard, joints in another order": lambda reference, rng: shuffled(mechanisms.bricard(reference("RB04")), rng),
    "door on three hinges": lambda reference, rng: mechanisms.door(reference("RC01"), (0.0, 0.4, 0.9)),
    "tree": lambda reference, rng: tree(12, rng),
    "elastic": lambda reference, rng: connected("Revolute", "floating-floating", rng),
}


@pytest.mark.parametrize("name", MECHANISMS)
def test_the_latest_equations_are_named(name, reference, rng):
    system, A = gradients(MECHANISMS[name](reference, rng))
    assert len(system.redundant) == system.ng - np.linalg.matrix_rank(A, tol=DEPENDENT)
    assert list(system.redundant) == latest(A)


def test_many_loops_are_counted():
    """101 four-bars, 1520 equations: three for each loop, as in the small ones."""
    system, A = gradients(mechanisms.four_bars(101))
    assert len(system.redundant) == system.ng - np.linalg.matrix_rank(A, tol=DEPENDENT) == 303


def test_gradients_of_nothing():
    """Equations that no motion changes are dependent, whether they stand alone, in a loop,
    or beside others of their joint.
    """
    alone = sparse.csr_matrix((3, 4))
    assert list(dependent_rows(alone, np.array([0, 0, 1]), np.zeros(4, int), DEPENDENT)) == [0, 1, 2]
    beside = sparse.csr_matrix([[1.0, 0.0], [0.0, 0.0], [0.6, 0.8]])
    assert list(dependent_rows(beside, np.array([0, 0, 1]), np.zeros(2, int), DEPENDENT)) == [1]
    assert list(dependent_rows(sparse.csr_matrix((0, 4)), np.zeros(0, int), np.zeros(4, int), DEPENDENT)) == []


def test_small_singular_values_without_a_small_pivot(rng):
    """Every row is far from those before it, and yet all but one say everything:
    s = 2^(2 - n) of 1 - (upper triangle).
    """
    n = 30
    A = np.tril(-np.ones((n, n)), -1) + np.eye(n)
    A = A @ np.linalg.qr(rng.normal(size=(n, n)))[0] / np.linalg.norm(A, axis=1)[:, None]
    found = dependent_rows(sparse.csr_matrix(A), np.arange(n), np.zeros(n, int), DEPENDENT)
    assert np.linalg.matrix_rank(A, tol=DEPENDENT) == n - 1
    assert len(found) == 1
    assert np.linalg.matrix_rank(np.delete(A, found, axis=0), tol=DEPENDENT) == n - 1


def test_equations_without_unique_multipliers():
    """41 loops have 123 states of self-stress; those of the null space by singular values reach the same equations."""
    system, A = gradients(mechanisms.four_bars(41))
    states = np.linalg.svd(A.T)[2][np.linalg.matrix_rank(A, tol=DEPENDENT) :]
    expected = np.flatnonzero(np.abs(states).max(axis=0) > SHARE)
    found = indeterminate_equations(sparse.identity(A.shape[1]), sparse.csr_matrix(A), system.redundant)
    assert list(found) == list(expected)


@pytest.mark.parametrize("seed", range(40))
def test_random_rows(seed):
    """Rows of whole numbers on a few bodies, many of them dependent, in any order; the rank is that of numpy."""
    rng = np.random.default_rng(seed)
    bodies, width = rng.integers(2, 12), rng.integers(1, 7)
    A, joints = [], []
    for joint in range(rng.integers(1, 16)):
        block = np.zeros((rng.integers(1, 7), bodies, width))
        on = rng.choice(bodies, size=rng.integers(1, 3), replace=False)
        block[:, on] = np.tensordot(rng.integers(-1, 2, (len(block), 3)), rng.integers(-1, 2, (3, len(on), width)), 1)
        A += list(block.reshape(len(block), -1))
        joints += [joint] * len(block)
    order = rng.permutation(len(A)) if seed % 3 == 0 else np.arange(len(A))
    A, joints = np.array(A)[order], np.array(joints)[order]
    norms = np.linalg.norm(A, axis=1)
    A /= np.where(norms > 0.0, norms, 1.0)[:, None]
    found = dependent_rows(sparse.csr_matrix(A), joints, np.repeat(np.arange(bodies), width), DEPENDENT)
    assert len(found) == len(A) - np.linalg.matrix_rank(A, tol=DEPENDENT)
    assert list(found) == latest(A)


def test_the_diagonal_of_the_mass_matrix_is_that_of_the_bodies(rng):
    """Masses and moments of inertia about the centres of mass, whatever joints and forces couple."""
    masses, moments = rng.uniform(1.0, 2.0, 3), rng.uniform(2.0, 3.0, (3, 3))
    bodies = [
        fmb.RigidBody(f"b{k}", mass=m, inertia=J, at=(k, 0, 0), markers={"end": (1, 0, 0)})
        for k, (m, J) in enumerate(zip(masses, moments))
    ]
    ends = ["ground.origin", "b0.end", "b1.end"]
    joints = [fmb.Revolute(f"j{k}", markers=(end, f"b{k}.center")) for k, end in enumerate(ends)]
    spring = fmb.SpringDamper("s", markers=("ground.origin", "b2.end"), stiffness=10.0, damping=1.0, length=1.0)
    system, state = assemble(fmb.Model(bodies=[fmb.Ground(), *bodies], joints=joints, forces=[spring]))
    work = system.workspace()
    weigh(work.weights, 1.0)
    evaluate(system.program, state, work)
    expected = np.concatenate([[m, m, m, *J] for m, J in zip(masses, moments)])
    assert mass_diagonal(system, work) == pytest.approx(expected, rel=1e-12)
