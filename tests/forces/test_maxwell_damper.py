"""Springs that relax against closed forms: relaxation, complex stiffness, and a linear system's matrix exponential."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.special import gamma

import flexmb as fmb
from flexmb.errors import ModelError

REST, BRANCHES, MASS = 400.0, ((300.0, 0.05), (150.0, 0.4)), 2.0
AXIS = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))


def sled(*parts, x=0.0, markers=False, **fields) -> fmb.Model:
    """Return a mass on a rail along x of W at x, held by the damper, on the rail or between markers."""
    place = {"markers": ("ground.wall", "b.center"), "length": 1.0} if markers else {"joint": "rail", "length": 0.0}
    body = fmb.RigidBody("b", mass=MASS, inertia=(1, 1, 1), at=(x, 0, 0), markers={"x": AXIS})
    return fmb.Model(
        bodies=[fmb.Ground(markers={"x": AXIS, "wall": (-1, 0, 0)}), body],
        joints=[fmb.Prismatic("rail", markers=("ground.x", "b.x")), *parts],
        forces=[fmb.MaxwellDamper("mount", branches=BRANCHES, stiffness=REST, **(place | fields))],
        sensors=[
            fmb.State("z", of="mount", state="damper 2"),
            fmb.JointCoordinate("x", joint="rail"),
            fmb.Energy("energy"),
        ],
    )


@pytest.mark.parametrize("markers", [False, True])
def test_relaxation(markers):
    """Held at an elongation e, the force falls as (k + sum k_j exp(-t/tau_j)) e."""
    e = 0.02
    model = sled(fmb.Drive("hold", joint="rail", displacement=e), x=e, markers=markers)
    model = model.with_parts(sensors=[fmb.Reaction("force", joint="hold")])
    solution = fmb.simulate(model, t_end=1.0, integrator=fmb.Implicit(rtol=1e-9), samples=21)
    exact = REST + sum(k * np.exp(-solution.t / time) for k, time in BRANCHES)
    size = np.linalg.norm(solution["force"][:, :3], axis=1)
    assert size == pytest.approx(exact * e, rel=1e-7)
    assert solution["z"] == pytest.approx(e * (1 - np.exp(-solution.t / BRANCHES[1][1])), abs=1e-9)


def test_complex_stiffness():
    """The receptance of the mass is 1 / (K(w) - m w^2), K = k + sum k_j i w tau_j / (1 + i w tau_j)."""
    frequencies = np.array([0.0, 0.3, 2.0, 3.0, 10.0])
    w = 2 * np.pi * frequencies
    stiffness = REST + sum(k * 1j * w * time / (1 + 1j * w * time) for k, time in BRANCHES)
    found = fmb.linearize(sled()).frequency_response(frequencies, "b.center", "b.center")
    np.testing.assert_allclose(found[:, 0, 0], 1.0 / (stiffness - MASS * w**2), rtol=1e-9)


@pytest.mark.parametrize(
    ("integrator", "error"), [(fmb.GeneralizedAlpha(rtol=1e-8), 1e-6), (fmb.Implicit(rtol=1e-9), 1e-7)]
)
@pytest.mark.parametrize("elongations", [None, (0.01, -0.03)])
def test_free_vibration(integrator, error, elongations):
    """Position and states follow the matrix exponential, and the energies balance."""
    model = sled(x=0.1, elongations=elongations)
    solution = fmb.simulate(model, t_end=2.0, integrator=integrator, samples=41)
    (k1, t1), (k2, t2) = BRANCHES
    A = np.array(
        [
            [0, 1, 0, 0],
            [-(REST + k1 + k2) / MASS, 0, k1 / MASS, k2 / MASS],
            [1 / t1, 0, -1 / t1, 0],
            [1 / t2, 0, 0, -1 / t2],
        ]
    )
    exact = np.array([expm(A * t) @ (0.1, 0.0, *(elongations or (0, 0))) for t in solution.t])
    assert solution["x"] == pytest.approx(exact[:, 0], abs=error)
    assert solution["z"] == pytest.approx(exact[:, 3], abs=error)
    balance = solution["energy"] - solution.phases[0].works @ (1.0, 1.0, -1.0)
    assert balance == pytest.approx(np.full(41, balance[0]), abs=50.0 * error)


def test_equilibrium_is_that_of_the_remaining_spring():
    """In the long run the branches are slack."""
    model = sled().with_parts(forces=[fmb.PointLoad("push", marker="b.center", force=(8.0, 0, 0))])
    final = fmb.statics(model).final
    assert final.q[0] == pytest.approx(8.0 / REST, rel=1e-8)
    held = fmb.statics(model, hold_states=True).final
    assert held.q[0] == pytest.approx(8.0 / (REST + sum(k for k, _ in BRANCHES)), rel=1e-8)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"branches": ()}, "1 to 6 pairs"),
        ({"branches": ((1.0, 2.0),) * 7}, "1 to 6 pairs"),
        ({"branches": (1.0, 2.0)}, "1 to 6 pairs"),
        ({"branches": ((1.0, -2.0),)}, "positive"),
        ({"branches": "soft"}, "branches = 'soft'"),
        ({"elongations": (1.0,)}, "one finite number for each branch, 2"),
        ({"stiffness": -1.0}, "stiffness = -1"),
        ({"length": float("inf")}, "length = inf"),
        ({"markers": ("ground.origin", "b.center")}, "both markers and joint"),
    ],
)
def test_messages(change, words):
    with pytest.raises(ModelError, match=words):
        fmb.MaxwellDamper("mount", **{"joint": "rail", "branches": BRANCHES, **change})


@pytest.mark.parametrize(("order", "off"), [(0.2, 0.05), (0.5, 0.1), (0.8, 0.15)])
def test_a_power_law_relaxes_as_a_derivative_of_fractional_order(order, off):
    """Dynamic stiffness c (i w)^order within the band; after a sudden elongation c t^-order / Gamma(1 - order)."""
    law = fmb.MaxwellDamper.power_law("rubber", modulus=3e3, order=order, band=(0.1, 100.0), joint="slide")
    k, tau = np.array(law.branches).T
    w = 2.0 * np.pi * np.geomspace(0.1, 100.0, 300)
    dynamic = (1j * w[:, None] * tau / (1.0 + 1j * w[:, None] * tau)) @ k
    assert np.abs(dynamic / (3e3 * (1j * w) ** order) - 1.0).max() < 0.05
    t = np.geomspace(0.01, 0.5, 50)
    relaxed = np.exp(-t[:, None] / tau) @ k
    assert relaxed == pytest.approx(3e3 * t**-order / gamma(1.0 - order), rel=off)


def test_bad_power_laws_are_refused():
    with pytest.raises(ModelError, match="an order below 1"):
        fmb.MaxwellDamper.power_law("rubber", modulus=3e3, order=1.5, band=(0.1, 100.0), joint="slide")
    with pytest.raises(ModelError, match="2 branches that miss the power law"):
        fmb.MaxwellDamper.power_law("rubber", modulus=3e3, order=0.5, band=(0.1, 100.0), count=2, joint="slide")
