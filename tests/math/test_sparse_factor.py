"""The sparse factorisation on every kind of FE matrix, against SuperLU and dense algebra; and what it refuses."""

import builtins

import numpy as np
import pytest
from fem.beams import plate
from reduction.solids import STEEL, block
from scipy import sparse
from scipy.sparse.linalg import splu
from tolerances import MACHINE

from flexmb import fem
from flexmb.errors import ReductionError
from flexmb.math import factor as door
from flexmb.math.factor import NotPositiveDefinite, SuperLU, factor
from flexmb.math.foreign_factor import Cholmod, Pardiso
from flexmb.math.multifrontal import Multifrontal
from flexmb.math.nested_dissection import dissect, front_tree, node_graph, pseudo_coordinates


def held_solid():
    fe = block((0.4, 0.2, 0.2), (8, 4, 4))
    free = np.flatnonzero(~np.isin(fe.dofs[:, 0], fe.node_set("left")))
    return fe.K[free][:, free], fe.nodes[fe.dofs[free, 0]]


def held_grid():
    """A grid of beams with six freedoms per node; the first node is held."""
    n = 14
    number = np.arange(n * n).reshape(n, n)
    lines = np.vstack(
        [
            np.column_stack([number[:, :-1].ravel(), number[:, 1:].ravel()]),
            np.column_stack([number[:-1].ravel(), number[1:].ravel()]),
        ]
    )
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), 0.1 * x.ravel() * y.ravel()])
    fe = fem.frame(points, connectivity=lines, section=fem.Section.rectangle(0.05, 0.04), material=STEEL)
    return fe.K[6:, 6:], fe.nodes[fe.dofs[6:, 0]]


def mixed_freedoms():
    """Some freedoms of the grid taken out at random: one to six freedoms per node."""
    K, x = held_grid()
    keep = np.sort(np.random.default_rng(3).permutation(K.shape[0])[: 2 * K.shape[0] // 3])
    return K[keep][:, keep], x[keep]


def linked_panel():
    """Shells, a stringer, a rigid link, an averaging link and a mass:
    six freedoms per node, dense rows at the links.
    """
    n = 18
    sheet = plate(n, 4, 2.0, 0.4, "quad")
    skin = fem.shell(sheet, STEEL, 0.002)
    stringer = fem.frame(
        np.linspace((0, 0.2, 0), (2, 0.2, 0), n + 1), section=fem.Section.tube(0.03, 0.002), material=STEEL
    )
    fe = fem.joined(skin, stringer)
    x = fe.nodes[:, 0]
    fe = fem.with_rigid_link(fe, (2.2, 0.2, 0.1), np.flatnonzero(x > 2.0 - 1e-9), "hub")
    fe = fem.with_averaging_link(fe, (1.0, 0.2, 0.2), np.flatnonzero(np.abs(x - 1.0) < 0.3), name="load")
    fe = fem.with_mass(fe, "load", 2.0)
    free = np.flatnonzero(fe.nodes[fe.dofs[:, 0], 0] > 1e-9)
    return fe.K[free][:, free], fe.nodes[fe.dofs[free, 0]]


def laplacian():
    """Not from FE: a 3-D grid, one freedom per node."""
    n = 12
    D = sparse.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(n, n))
    eye = sparse.eye(n)
    K = (
        sparse.kron(sparse.kron(D, eye), eye)
        + sparse.kron(sparse.kron(eye, D), eye)
        + sparse.kron(sparse.kron(eye, eye), D)
    )
    return K.tocsr(), np.stack(np.meshgrid(*3 * [np.arange(float(n))], indexing="ij"), axis=-1).reshape(-1, 3)


MODELS = [held_solid, held_grid, mixed_freedoms, linked_panel, laplacian]


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("coordinates", [True, False])
def test_solution_equals_superlu(model, coordinates, rng):
    K, x = model()
    B = rng.standard_normal((K.shape[0], 5))
    f = Multifrontal()(K, x if coordinates else None)
    X = f.solve(B)
    residual = np.abs(K @ X - B).max() / (abs(K) @ np.abs(X)).max()
    assert residual < MACHINE
    expected = splu(K.tocsc()).solve(B)
    np.testing.assert_allclose(X, expected, atol=1e-8 * np.abs(expected).max())
    np.testing.assert_allclose(f.solve(B[:, 0]), X[:, 0], rtol=0, atol=1e-9 * np.abs(X).max())
    assert f.n == K.shape[0]
    assert 0.0 < f.weakest_pivot <= 1.0


def test_factor_is_the_cholesky_factor_of_the_permuted_matrix():
    """det K = prod L_ii^2, against the dense logarithm of the determinant."""
    K, x = mixed_freedoms()
    f = Multifrontal()(K, x)
    mine = 2.0 * sum(np.log(np.diagonal(panel.own)).sum() for panel in f._panels)
    np.testing.assert_allclose(mine, np.linalg.slogdet(K.toarray())[1], rtol=1e-12)


def test_a_stored_zero_in_one_triangle_does_no_harm(rng):
    """The pattern that products such as T^T K T leave: single entries cancel and are dropped in one triangle only."""
    K, x = held_solid()
    half = sparse.triu(K, 1).tocoo()
    value = half.data.copy()
    value[rng.random(len(value)) < 0.3] = 0.0
    upper = sparse.coo_matrix((value, (half.row, half.col)), K.shape).tocsr()  # with stored zeros
    lower = upper.T.tocsr()
    lower.eliminate_zeros()
    shift = sparse.diags(K.diagonal() + np.asarray(abs(upper + upper.T).sum(axis=1)).ravel())
    A = sparse.csr_matrix(sparse.coo_matrix(upper) + sparse.coo_matrix(lower) + shift)
    b = rng.standard_normal(A.shape[0])
    assert np.abs(A @ Multifrontal()(A, x).solve(b) - b).max() < 1e-10


def test_dissection_gives_a_complete_order_and_a_tree():
    K, x = laplacian()
    start, neighbours = node_graph(K, np.arange(len(x)), len(x))
    order, ends = dissect(start, neighbours, x, 20)
    assert np.array_equal(np.sort(order), np.arange(len(x)))
    assert ends[-1] == len(x)
    rows_start, rows, parent = front_tree(start, neighbours, order, ends)
    owner = np.searchsorted(ends, rows, side="right")
    front = np.repeat(np.arange(len(ends)), np.diff(rows_start))
    assert np.all(owner > front)  # boundaries are eliminated later
    assert np.sum(parent < 0) == 1
    last = ends[-1] - ends[-2]
    assert last <= 12 * 12  # the first separator of a 12^3 grid is a plane at most


def test_fill_of_nested_dissection_is_below_minimum_degree():
    K, x = held_solid()
    assert Multifrontal()(K, x).nnz < 2.0 * SuperLU()(K).nnz  # dense fronts count their zeros too


def test_pseudo_coordinates_tell_nodes_apart():
    K, x = laplacian()
    start, neighbours = node_graph(K, np.arange(len(x)), len(x))
    y = pseudo_coordinates(start, neighbours)
    assert np.linalg.matrix_rank(y - y.mean(axis=0)) >= 2
    assert np.all(np.abs(np.diff(y[neighbours[start[0] : start[1]]], axis=0)) <= 2)


@pytest.mark.parametrize("backend", [SuperLU(), Multifrontal()])
@pytest.mark.parametrize("change", ["singular", "indefinite"])
def test_not_positive_definite(backend, change):
    K, x = held_solid()
    K = K.tolil()
    freedom = 37
    if change == "singular":
        K[freedom, :] = 0.0
        K[:, freedom] = 0.0
    else:
        K[freedom, freedom] = -abs(K[freedom, freedom])
    with pytest.raises(
        NotPositiveDefinite, match=r"Sparse factorisation: .*a symmetric positive definite matrix.*mechanism"
    ):
        factor(K.tocsr(), x, backend=backend)


def test_broken_freedom_is_the_one_without_stiffness():
    K, x = held_solid()
    K = K.tolil()
    K[37, :] = 0.0
    K[:, 37] = 0.0
    with pytest.raises(NotPositiveDefinite) as caught:
        factor(K.tocsr(), x, backend=Multifrontal())
    assert caught.value.freedom == 37


def test_first_solve_is_checked():
    K, x = held_solid()
    unsymmetric = K + sparse.coo_matrix(([0.1 * K[5, 5]], ([5], [8])), K.shape)
    with pytest.raises(
        ReductionError, match=r"relative residual .* of the first solve\. Expected: at most 1e-08.*unsymmetric"
    ):
        factor(unsymmetric.tocsr(), x, backend=Multifrontal()).solve(np.ones(K.shape[0]))


def test_small_matrices_go_to_superlu_and_empty_ones_to_nothing():
    K, x = held_solid()
    assert isinstance(factor(K[:300, :300], x[:300])._inner, door._SuperLUFactor)
    empty = factor(sparse.csr_matrix((0, 0)))
    assert empty.solve(np.zeros((0, 3))).shape == (0, 3)


@pytest.mark.parametrize(("backend", "package"), [(Pardiso(), "pypardiso"), (Cholmod(), "sksparse")])
def test_missing_package_is_named(backend, package, monkeypatch):
    real = builtins.__import__
    monkeypatch.setattr(
        "importlib.import_module",
        lambda name: (_ for _ in ()).throw(ImportError(name)) if package in name else real(name),
    )
    K, x = laplacian()
    with pytest.raises(
        ReductionError, match=rf"package '{package}' is not installed.*[Ii]nstall.* or leave the choice"
    ):
        factor(K, x, backend=backend)


@pytest.mark.parametrize(("backend", "package"), [(Pardiso(), "pypardiso"), (Cholmod(), "sksparse")])
def test_foreign_code_gives_the_same_solution(backend, package, rng):
    pytest.importorskip(package, reason=f"{package} is an optional back-end")
    K, x = held_solid()
    B = rng.standard_normal((K.shape[0], 3))
    expected = factor(K, x).solve(B)
    np.testing.assert_allclose(factor(K, x, backend=backend).solve(B), expected, atol=1e-9 * np.abs(expected).max())
