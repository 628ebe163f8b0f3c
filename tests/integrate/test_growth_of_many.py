"""What grows among many velocities, by sparse factors: beside all eigenvalues, closed forms, and in runs."""

from __future__ import annotations

import signal
from types import SimpleNamespace

import numpy as np
import pytest
from integrate.test_outgrown import ALONG_X, MASS, X, cart, fed_back
from scipy import linalg, sparse

import flexmb as fmb
from flexmb.integrate.runs import growth_of_many, interruption, outgrown
from flexmb.integrate.runs.growth_of_many import fastest_of_many

BARS = 60


def growing(rng, n: int, m: int, rate: complex):
    """Return M, D, K, G of a chain whose motions swing, but for one that grows at a rate, and that growth's shape."""
    spring = sparse.diags([2.0 * np.ones(n), -np.ones(n - 1), -np.ones(n - 1)], [0, 1, -1]).toarray()
    G = np.zeros((m, n))
    G[np.arange(m), rng.permutation(n)[:m]] = 1.0
    N = linalg.null_space(G)
    M, D, K = np.eye(n), np.zeros((n, n)), 1e4 * spring
    # s^2 + d s + k = 0 along one direction: d = -2 Re s, k = |s|^2
    inner = N.T @ K @ N
    values, shapes = np.linalg.eigh(inner)
    k = len(values) // 2
    way = N @ shapes[:, k]
    D -= 2.0 * rate.real * np.outer(way, way)
    K += (abs(rate) ** 2 - values[k]) * np.outer(way, way)
    return (*(sparse.csr_matrix(part) for part in (M, D, K, G)), way)


@pytest.mark.parametrize("rate", [3.0 + 0.0j, 4e6 + 0.0j, 50.0 + 60.0j, 2e3 + 8e3j])
@pytest.mark.parametrize("doubled", [False, True])
def test_the_growth_that_was_put_in(rate, doubled, rng):
    """A chain of undamped springs; `doubled`: every constraint is there twice."""
    if rate.imag == 0.0:  # two real roots, at the rate and at minus a tenth of it
        M, D, K, G, way = growing(rng, 400, 40, 1.0 + 0.0j)
        spread = np.outer(way, way)
        D = D + sparse.csr_matrix((2.0 - 0.9 * rate.real) * spread)
        K = K + sparse.csr_matrix((-1.0 - 0.1 * rate.real**2) * spread)
    else:
        M, D, K, G, way = growing(rng, 400, 40, rate)
    G = sparse.vstack([G, G]).tocsr() if doubled else G
    found = fastest_of_many(M, D, K, G, 1.0)
    assert found is not None
    assert found.value.real == pytest.approx(rate.real, rel=1e-5)
    assert abs(found.value.imag) == pytest.approx(rate.imag, rel=1e-5, abs=1e-5 * rate.real)
    shape = found.shape / np.linalg.norm(found.shape)
    assert abs(shape @ way) == pytest.approx(1.0, abs=1e-4)
    left = found.left / np.linalg.norm(found.left)
    assert abs(left @ way) == pytest.approx(1.0, abs=1e-4)


def test_what_swings_or_decays_does_not_grow(rng):
    M, _, K, G, way = growing(rng, 400, 40, 0.0 + 7.0j)
    for d in (0.0, 1e-6, 3.0):
        D = sparse.csr_matrix(d * np.eye(400))
        assert fastest_of_many(M, D, K, G, 1.0) is None
    assert fastest_of_many(M, sparse.csr_matrix(np.outer(way, way) * 5.0), K, G, 1.0) is None


def among_many(effort) -> fmb.Model:
    """Return the cart of a controller beside a chain of bars that swings: 366 velocities."""
    own = cart(effort)
    y, left, right = (fmb.Pose.axes((x, 0, 0), z=(0, 1, 0)) for x in (0.0, -0.1, 0.1))
    bars = [
        fmb.RigidBody(
            f"bar{k}", mass=1.0, inertia=(0.01, 0.01, 0.01), at=(0.2 * k, 0, 0), markers={"a": left, "b": right}
        )
        for k in range(BARS)
    ]
    pin = fmb.Pose.axes((-0.1, 0, 0), z=(0, 1, 0))
    names = ["ground.pin", *(f"bar{k}.b" for k in range(BARS))]
    hinges = [fmb.Revolute(f"hinge{k}", markers=(names[k], f"bar{k}.a")) for k in range(BARS)]
    ground = fmb.Ground(markers={"x": ALONG_X, "y": y, "pin": pin})
    return fmb.Model(
        bodies=[ground, own.bodies[1], *bars],
        joints=[*own.joints, *hinges],
        forces=own.forces,
        sensors=own.sensors,
        gravity=(0, 0, -9.81),
    )


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.Implicit()])
@pytest.mark.filterwarnings("ignore::flexmb.errors.ValidityWarning")
def test_a_gain_far_too_high_in_a_large_model(integrator):
    """The rate of the cart alone is d / m, whatever the bars do."""
    with pytest.raises(fmb.IntegrationError, match=r"Body 'cart'.*by e every 2e-09 s.*Force 'motor'.*passed over it"):
        fmb.simulate(among_many(fed_back(0.0, 1e9)), t_end=0.05, samples=6, integrator=integrator)


@pytest.mark.filterwarnings("ignore::flexmb.errors.ValidityWarning")
def test_a_growth_that_swings_in_a_large_model():
    k, lag = 1e15, 1e-3
    rate = np.roots([MASS * lag, MASS, 0.0, k]).real.max()
    pushed = fmb.formula("1 - k*y", over={"y": fmb.Lag(X, time=lag)}, k=k)
    with pytest.raises(fmb.IntegrationError, match=rf"by e every {1.0 / rate:.3g} s.*Force 'motor'"):
        fmb.simulate(among_many(pushed), t_end=0.05, samples=6, integrator=fmb.GeneralizedAlpha())


def test_feedback_of_the_right_sign_in_a_large_model_runs():
    solution = fmb.simulate(among_many(fed_back(-1e9, -1e5)), t_end=0.05, samples=6)
    assert solution.status.ok
    assert solution["x"][-1] == pytest.approx(1e-9, rel=1e-3)


@pytest.mark.parametrize("how", ["Ctrl-C", "limit"])
@pytest.mark.filterwarnings("ignore::flexmb.errors.ValidityWarning")
def test_the_look_at_the_end_can_be_cut_short(how, monkeypatch):
    """It may take minutes; all samples are there before it begins."""
    now, solved = [0.0], []
    monkeypatch.setattr(interruption, "time", SimpleNamespace(monotonic=lambda: now[0]))

    def struck(*given):
        if how == "Ctrl-C":
            signal.raise_signal(signal.SIGINT)
        else:
            now[0] = 1e6
        return tangent_at(*given)

    def counted(self, *given, **how):
        solved.append(1)
        return solve(self, *given, **how)

    tangent_at, solve = outgrown.tangent_at, growth_of_many._Bordered.solve
    monkeypatch.setattr(outgrown, "tangent_at", struck)
    monkeypatch.setattr(growth_of_many._Bordered, "solve", counted)
    solution = fmb.simulate(
        among_many(fed_back(0.0, 1e9)), t_end=0.05, samples=6, integrator=fmb.Implicit(), time_limit=1e3
    )
    assert solution.status.kind == "finished"
    assert len(solution.t) == 6
    assert len(solved) <= 2
    assert any("cut short by Ctrl-C" in note for note in solution.statistics["notes"])
