"""Balanced and interpolating bases beside pyMOR's: the same cantilever, the same error in the H-infinity norm."""

import numpy as np
import pytest
from reduction.beams import planar_beam
from scipy.linalg import eigh

from flexmb import reduction
from flexmb.reduction.framed_body import FramedBody
from flexmb.reduction.interfaces import resolve
from flexmb.reduction.markers import interface_motions
from flexmb.reduction.statics import HeldBody

ZETA = 0.01


@pytest.fixture(scope="module")
def cantilever():
    """Held beam, its modes, the share of a tip force in them, and pyMOR's model with modal damping."""
    iosys = pytest.importorskip("pymor.models.iosys")
    fe = planar_beam(20)
    force = np.zeros((fe.ndof, 1))
    force[-2] = 1.0
    couplings = resolve(fe, {"a": "left"})
    held = FramedBody(HeldBody(fe, couplings), 0, interface_motions(fe, couplings), force)
    w2, modes = eigh(fe.K.toarray()[2:, 2:], fe.M.toarray()[2:, 2:])
    share = modes.T @ force[2:]
    model = iosys.SecondOrderModel.from_matrices(
        np.eye(len(w2)), np.diag(2.0 * ZETA * np.sqrt(w2)), np.diag(w2), share, share.T
    )
    return fe, held, w2, modes, share, model


def lines(w2):
    """Angular frequencies over the band of all modes, 1/s, and the response of the full model there."""
    own = np.sqrt(w2)
    return np.unique(np.concatenate([own, own * 0.99, own * 1.01, np.linspace(1.0, own[-1], 400)]))


def relative(full, small):
    return np.abs(full - small).max() / np.abs(full).max()


def of_basis(w2, share, basis, w):
    """Response of a basis in modal coordinates (Galerkin)."""
    Q = np.linalg.qr(basis)[0]
    K, D, F = Q.T @ (w2[:, None] * Q), Q.T @ (2.0 * ZETA * np.sqrt(w2)[:, None] * Q), Q.T @ share
    return np.array([(F.T @ np.linalg.solve(K - s * s * np.eye(len(K)) + 1j * s * D, F))[0, 0] for s in w])


@pytest.mark.peer
@pytest.mark.parametrize("order", [3, 5, 8])
def test_balanced_truncation_of_second_order(cantilever, order):
    sobt = pytest.importorskip("pymor.reductors.sobt")
    fe, held, w2, modes, share, model = cantilever
    w = lines(w2)
    full = np.array([(share[:, 0] ** 2 / (w2 - s * s + 2j * ZETA * np.sqrt(w2) * s)).sum() for s in w])
    theirs = sobt.SOBTpvReductor(model).reduce(order, projection="bfsr").transfer_function
    other = np.array([theirs.eval_tf(1j * s)[0, 0] for s in w])
    own = reduction.Balanced(40, damping=ZETA).vectors(held, order)
    ours = of_basis(w2, share, modes.T @ (fe.M.toarray()[2:, 2:] @ own[2:]), w)
    assert relative(full, ours) == pytest.approx(relative(full, other), rel=1e-3)


@pytest.mark.peer
def test_interpolation_spans_the_same_space(cantilever):
    """Krylov vectors at a frequency without damping are those of pyMOR's Hermite interpolation at i omega."""
    interpolation = pytest.importorskip("pymor.reductors.interpolation")
    iosys = pytest.importorskip("pymor.models.iosys")
    fe, held, w2, modes, share, _ = cantilever
    undamped = iosys.SecondOrderModel.from_matrices(
        np.eye(len(w2)), np.zeros((len(w2), len(w2))), np.diag(w2), share, share.T
    )
    points = np.array([1j * 2 * np.pi * 30.0, -1j * 2 * np.pi * 30.0])
    reductor = interpolation.SOBHIReductor(undamped)
    reductor.reduce(points, np.ones((2, 1)), np.ones((2, 1)))
    theirs = reductor.V.to_numpy().reshape(len(w2), -1)
    ours = reduction.Krylov((30.0,)).vectors(held, 0)
    tip = modes.T @ (fe.M.toarray()[2:, 2:] @ ours[2:])
    left = theirs - tip @ np.linalg.lstsq(tip, theirs, rcond=None)[0]
    assert np.linalg.norm(left) < 1e-6 * np.linalg.norm(theirs)
