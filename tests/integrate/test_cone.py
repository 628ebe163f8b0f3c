"""The impulse of one contact, and what refuses rigid contacts."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.integrate.nonsmooth.cone import disc_moment, solve_cone


def missed(D, q, mu, P):
    """Return by how much the laws of Signorini and Coulomb are missed, m/s, written out without projections."""
    xi = D @ P + q
    slip, push = np.hypot(xi[1], xi[2]), np.hypot(P[1], P[2])
    size = np.trace(D)
    found = [max(0.0, -P[0]) * size, max(0.0, -xi[0]), min(abs(P[0]) * size, abs(xi[0])), (push - mu * P[0]) * size]
    opposed = slip * push + xi[1] * P[1] + xi[2] * P[2]  # 0 where the slip is against the friction
    free = (mu * P[0] - push) * size  # friction that is not used up belongs to no slip
    return max(*found, min(slip, free), opposed / max(push, 1e-12))


@pytest.mark.parametrize("kind", ["full", "diagonal", "nearly singular"])
def test_every_contact_has_an_impulse(kind):
    rng = np.random.default_rng(7)
    for _ in range(700):
        A = rng.normal(size=(3, 3))
        D = A @ A.T + (1e-3 if kind == "full" else 1e-6) * np.eye(3)
        D = np.diag(rng.uniform(0.1, 2.0, 3)) if kind == "diagonal" else D
        q, mu, P = rng.normal(size=3), rng.uniform(0.0, 2.0), np.zeros(3)
        assert solve_cone(D, q, mu, P, 0.0)
        assert missed(D, q, mu, P) < 1e-7 * np.abs(q).max()


def test_least_impulse_of_an_expansion():
    """With a least normal impulse the contact parts, and friction is that of the impulse."""
    D, q, P = np.eye(3), np.array([1.0, 3.0, 0.0]), np.zeros(3)
    assert solve_cone(D, q, 0.5, P, 2.0)
    assert P == pytest.approx((2.0, -1.0, 0.0))


def test_moment_in_a_disc():
    """On the edge it is the minimum of 1/2 X.A X + x.X, found here by trying all directions."""
    A, x = np.array([[2.0, 0.3], [0.3, 1.0]]), np.array([1.0, -2.0])
    found = np.array(disc_moment(A[0, 0], A[0, 1], A[1, 0], A[1, 1], *x, 0.7))
    angle = np.linspace(0.0, 2.0 * np.pi, 200001)
    X = 0.7 * np.column_stack([np.cos(angle), np.sin(angle)])
    best = X[np.argmin(0.5 * np.einsum("ki,ij,kj->k", X, A, X) + X @ x)]
    assert found == pytest.approx(best, abs=1e-4)


def model(law, height=0.1, mass=1.0):
    ball = fmb.RigidBody("ball", mass=mass, inertia=(4e-3,) * 3, at=(0, 0, height))
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), ball],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            fmb.Surface("skin", marker="ball.center", shape=fmb.Sphere(radius=0.1)),
        ],
        forces=[fmb.SurfaceContact("touch", surfaces=("floor", "skin"), law=law)],
        sensors=[fmb.Position("p", marker="ball.center"), fmb.ForceOf("f", force="touch")],
    )


@pytest.mark.parametrize(
    "wrong", [{"friction": -0.1}, {"restitution": 1.1}, {"restitution": np.nan}, {"rolling": -1.0}, {"drilling": "a"}]
)
def test_wrong_laws(wrong):
    with pytest.raises(ModelError, match=next(iter(wrong))):
        fmb.Rigid(**wrong)


@pytest.mark.parametrize("wrong", [{"step": 0.0}, {"step": None}, {"tolerance": -1.0}, {"sweeps": 2.5}])
def test_wrong_settings(wrong):
    with pytest.raises(ModelError, match=next(iter(wrong))):
        fmb.MoreauJean(**{"step": 1e-3, **wrong})


def test_overlap_at_the_start_is_named():
    with pytest.raises(ModelError, match=r"'floor' and 'skin' overlap by 0\.01 m"):
        fmb.simulate(model(fmb.Rigid(), 0.09), 0.1, integrator=fmb.MoreauJean(step=1e-3))


@pytest.mark.parametrize(
    "integrator",
    [None, fmb.GeneralizedAlpha(), fmb.IDA(), fmb.Explicit(), fmb.Implicit()],
    ids=lambda x: type(x).__name__,
)
def test_other_integrators_refuse_rigid_contact(integrator):
    with pytest.raises(ModelError, match="MoreauJean"):
        fmb.simulate(model(fmb.Rigid()), 0.1, integrator=integrator)


@pytest.mark.parametrize(
    "analysis",
    [
        fmb.statics,
        fmb.linearize,
        fmb.first_frequencies,
        fmb.accelerations,
        fmb.equations,
        lambda m: fmb.kinematics(m, 1.0),
        lambda m: fmb.stepper(m, integrator=fmb.MoreauJean(step=1e-3)),
    ],
)
def test_analyses_refuse_rigid_contact(analysis):
    with pytest.raises(ModelError, match="rigid law"):
        analysis(model(fmb.Rigid()))


def test_compliant_contact_by_impulses():
    """The other way round works: MoreauJean takes compliant contact as any force, here against GeneralizedAlpha."""
    hertz = model(fmb.Hertz(stiffness=1e6), 0.101)
    found = fmb.simulate(hertz, 0.04, integrator=fmb.MoreauJean(step=1e-4), samples=13)["p"]
    expected = fmb.simulate(hertz, 0.04, integrator=fmb.GeneralizedAlpha(rtol=1e-8), samples=13)["p"]
    assert expected[:, 2].min() < 0.0999  # sunk in, and thrown back
    assert expected[-1, 2] > 0.1003
    assert found == pytest.approx(expected, abs=2e-6)


def test_files_and_continued_runs(tmp_path):
    """A run that is kept, read and continued goes on as one that was not stopped."""
    whole = fmb.simulate(model(fmb.Rigid(restitution=0.5), 0.2), 0.4, integrator=fmb.MoreauJean(step=1e-3), samples=41)
    half = fmb.simulate(model(fmb.Rigid(restitution=0.5), 0.2), 0.2, integrator=fmb.MoreauJean(step=1e-3), samples=21)
    longer = fmb.resume(half, 0.4, integrator=fmb.MoreauJean(step=1e-3), samples=41)
    assert longer["p"] == pytest.approx(whole["p"], abs=1e-9)
    assert longer["f"][-1] == pytest.approx(whole["f"][-1], abs=1e-6)
    whole.save(tmp_path / "run.h5")
    read = fmb.Solution.load(tmp_path / "run.h5", read_model=fmb.read_model_text)
    assert read["f"][-1] == pytest.approx(whole["f"][-1])
