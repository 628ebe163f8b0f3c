"""Random loads and root loci against closed forms of one and two masses."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import ModelError

M, K, C = 2.0, 80.0, 3.0
ALONG_X = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))


def cart(damping: float = C, lag: float | None = None, gain: float = 0.0) -> fmb.Model:
    """Return a mass on a spring with a damper, and a controller behind a lag that pushes with gain times the speed."""
    x = fmb.JointCoordinate("x", joint="rail")
    force = fmb.formula("u - k*x - c*rate(x)", over={"x": x, "u": fmb.input("push")}, k=K, c=damping)
    if lag is not None:
        force = force + gain * fmb.Lag(fmb.measured(x), time=lag)
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"x": ALONG_X}),
            fmb.RigidBody("cart", mass=M, inertia=(1, 1, 1), markers={"x": ALONG_X}),
        ],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "cart.x"))],
        forces=[fmb.Actuator("motor", joint="rail", effort=force)],
        sensors=[x, fmb.Velocity("v", marker="cart.x")],
    )


def test_white_noise_on_an_oscillator():
    """One-sided G: variances G / (4 c k) of the place and G / (4 c m) of the speed (Newland 1993, sec. 7)."""
    plant = fmb.linearize(cart(), inputs="push", outputs=["x", "v"])
    found = np.diag(fmb.variances(plant, [5.0]))
    assert found[:2] == pytest.approx([5.0 / (4 * C * K), 5.0 / (4 * C * M)], rel=1e-9)
    f = np.linspace(0.0, 60.0, 60001)
    spectra = fmb.spectral_response(plant, f, np.full((len(f), 1), 5.0)).real
    assert np.trapezoid(spectra[:, 0, 0], f) == pytest.approx(found[0], rel=1e-4)
    s = 2j * np.pi * f
    assert spectra[:, 0, 0] == pytest.approx(5.0 / np.abs(M * s**2 + C * s + K) ** 2, rel=1e-8)


def topped(stiffness: float) -> fmb.Model:
    """Return the cart with a mass of 1 kg on a stiff spring on it, damped by a hundredth of the critical."""
    top = fmb.RigidBody("top", mass=1.0, inertia=(1, 1, 1), markers={"x": ALONG_X})
    y = fmb.JointCoordinate("y", joint="spring")
    force = fmb.formula("-k*y - c*rate(y)", over={"y": y}, k=stiffness, c=0.02 * np.sqrt(stiffness))
    model = cart()
    return fmb.Model(
        bodies=[*model.bodies, top],
        joints=[*model.joints, fmb.Prismatic("spring", markers=("cart.x", "top.x"))],
        forces=[*model.forces, fmb.Actuator("stiff", joint="spring", effort=force)],
        sensors=model.sensors,
    )


@pytest.mark.parametrize(("stiffness", "digits"), [(1e8, 1e-6), (1e12, 1e-5), (1e14, 1e-3)])
def test_a_slow_vibration_beside_a_fast_one_keeps_its_variance(stiffness, digits):
    """The place moves as one mass does, G / (4 c k) whatever the mass: the fast vibration is nothing beside it.

    Frequencies of 1e4 to 1e7 rad/s beside 5; before, 1.3e-3 was lost at the last, and SciPy warned of its own matrix.
    """
    plant = fmb.linearize(topped(stiffness), inputs="push", outputs="x")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = fmb.variances(plant, [5.0])
    assert found[0, 0] == pytest.approx(5.0 / (4 * C * K), rel=digits)


def test_poles_that_meet_have_variances():
    """Critical damping, where A has one eigenvector for two poles."""
    plant = fmb.linearize(cart(damping=2.0 * np.sqrt(K * M)), inputs="push", outputs="x")
    assert fmb.variances(plant, [5.0])[0, 0] == pytest.approx(5.0 / (8.0 * K * np.sqrt(K * M)), rel=1e-7)


def test_bad_random_loads_are_refused():
    plant = fmb.linearize(cart(), inputs="push", outputs="x")
    with pytest.raises(ModelError, match="densities of the shape"):
        fmb.spectral_response(plant, [1.0, 2.0], [[1.0]])
    with pytest.raises(ModelError, match="densities"):
        fmb.spectral_response(plant, [1.0], [[-1.0]])
    free = fmb.linearize(cart(damping=0.0), inputs="push", outputs="x")
    with pytest.raises(ModelError, match="a plant that settles"):
        fmb.variances(free, [1.0])


def test_the_limit_of_a_gain_is_that_of_hurwitz():
    """(m s^2 + c s + k)(T s + 1) = g: unstable from g < k - (m + cT)(c + kT) / (mT) on, and from g > k (Hurwitz)."""
    T = 0.2
    low = K - (M + C * T) * (C + K * T) / (M * T)
    locus = fmb.root_locus(lambda g: cart(lag=T, gain=g), np.linspace(low - 20.0, K + 20.0, 12))
    assert locus.limits() == pytest.approx([low, K], rel=1e-8)
    for value, poles in zip(locus.values, locus.poles):
        wanted = np.roots([M * T, M + C * T, C + K * T, K - value])
        assert np.sort_complex(poles) == pytest.approx(np.sort_complex(wanted), rel=1e-8)
    assert list(locus.stable) == [low < value < K for value in locus.values]
    with pytest.raises(ModelError, match="two values or more"):
        fmb.root_locus(cart, [1.0])


@pytest.mark.parametrize("values", [(-1.0, -0.3, 0.4, 1.1), (-1.0, 0.0, 1.0), (1.0, 0.25, -0.5)])
def test_the_limit_beside_freedoms_that_nothing_holds(values):
    """m s^2 + c s + k = 0: c < 0 excites it, at sqrt(k / m) where c = 0; a point beside it is free."""
    free = fmb.PointMass("free", mass=1.0)
    ((value, pole),) = fmb.root_locus(lambda c: cart(damping=c).with_parts(bodies=[free]), values).crossings()
    assert value == pytest.approx(0.0, abs=1e-9)
    assert pole == pytest.approx(1j * np.sqrt(K / M), abs=1e-9)


def test_poles_that_the_matrix_has_lost_are_told():
    """A whose slow pole is off by half, or twice, the damping of the plant's; 2 % of its size in a response."""
    plant = fmb.linearize(topped(1e12), inputs="push", outputs="x")
    slow = np.abs(plant.poles) < 10.0
    damping = -plant.poles[slow].real.max()
    with pytest.warns(fmb.ValidityWarning, match="damping of its pole of .* is rounded by 50%"):
        fmb.variances(replace(plant, poles=plant.poles + 0.5j * damping * slow), [5.0])
    with pytest.raises(ModelError, match="whose damping is rounded away"):
        fmb.variances(replace(plant, poles=plant.poles + 2j * damping * slow), [5.0])
    with pytest.warns(fmb.ValidityWarning, match="its response there is doubtful"):
        replace(plant, poles=plant.poles * (1.0 + 0.02 * slow)).frequency_response(1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plant.frequency_response(1.0)


def test_equal_poles_in_a_chain_are_no_lost_ones():
    """Eight equal lags: eigenvalues of the matrix, which is exact, miss their pole by a tenth and more."""
    n, rate = 8, 10.0
    A = rate * (np.eye(n, k=-1) - np.eye(n))
    B, C = np.eye(n)[:, :1] * rate, np.eye(n)[-1:]
    zero = np.zeros((1, 1))
    chain = replace(
        fmb.linearize(cart(), inputs="push", outputs="x"), A=A, B=B, C=C, D=zero, poles=np.full(n, -rate, complex)
    )
    turn = np.linalg.qr(np.random.default_rng(1).standard_normal((n, n)))[0]
    turned = replace(chain, A=turn @ A @ turn.T, B=turn @ B, C=C @ turn.T)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = turned.frequency_response([1.0])[0, 0, 0]
    assert found == pytest.approx((rate / (rate + 2j * np.pi)) ** n, rel=1e-9)
