"""Contacts of many surfaces, of which those near each other are looked for: beside the same ones taken pair by pair."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.forces import surface_contact
from flexmb.system import compile
from flexmb.system.program import evaluate

LAW = fmb.Hertz(stiffness=1e6, damping=0.2, friction=0.3, transition=0.01)


def balls(places, radii, law=LAW, spacing=None, **motion) -> fmb.Model:
    """Return balls of 1 kg over a floor, all of which may touch."""
    names = tuple(f"b{k}" for k in range(len(places)))
    moved = [{field: tuple(values[k]) for field, values in motion.items()} for k in range(len(places))]
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(),
            *(
                fmb.RigidBody(n, mass=1.0, inertia=(0.4 * r * r,) * 3, at=tuple(p), **m)
                for n, p, r, m in zip(names, places, radii, moved, strict=True)
            ),
        ],
        surfaces=[
            fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
            *(
                fmb.Surface(n, marker=f"{n}.center", shape=fmb.Sphere(r), spacing=spacing)
                for n, r in zip(names, radii, strict=True)
            ),
        ],
        forces=[fmb.SurfaceContact("heap", surfaces=(("floor", *names), names), law=law)],
        sensors=[fmb.ContactState("state", force="heap"), fmb.Energy("E")],
    )


def loads(model):
    """Return the wrenches on all markers at the start, and the energies and powers of contacts."""
    system = compile(model)
    work = system.workspace()
    evaluate(system.program, system.state(), work)
    energy = work.energy[0]
    return work.markers["wrench"].copy(), (energy.potential, energy.dissipation)


def thrown(rng, n=40):
    """Return places, radii and motions of balls that overlap here and there."""
    places = rng.uniform((-0.3, -0.3, 0.0), (0.3, 0.3, 0.4), (n, 3))
    motion = {"velocity": rng.normal(size=(n, 3)), "angular_velocity": rng.normal(size=(n, 3))}
    return places, rng.uniform(0.02, 0.09, n), motion


@pytest.mark.parametrize("law", [LAW, fmb.ElasticFoundation(modulus=1e7, thickness=0.01, friction=0.2)])
def test_forces_of_a_crowd_are_those_of_all_pairs(law, rng, monkeypatch):
    places, radii, motion = thrown(rng)
    model = balls(places, radii, law, None if law is LAW else 0.03, **motion)
    wrenches, energies = loads(model)
    assert np.count_nonzero(np.abs(wrenches[:, :3]).sum(axis=1)) > 20
    monkeypatch.setattr(surface_contact, "MOST_PAIRS", 0)
    found, others = loads(model)
    np.testing.assert_allclose(found, wrenches, atol=1e-10 * np.abs(wrenches).max())
    np.testing.assert_allclose(others, energies, rtol=1e-10)


def column(n: int, deep: float) -> fmb.Model:
    """Return n columns of two balls of 0.1 m, pressed into each other and into the floor by `deep`."""
    side = int(np.ceil(n**0.5))
    at = [(0.5 * (k % side), 0.5 * (k // side), 0.1 - deep) for k in range(n)]
    at += [(x, y, z + 0.2 - deep) for x, y, z in at]
    return balls(np.array(at), np.full(2 * n, 0.1), fmb.Hertz(stiffness=1e6))


def test_only_pairs_that_exist_make_a_crowd(monkeypatch):
    """Balls among each other and a floor are n (n + 1) / 2 pairs, about half of what both groups have as a table."""
    places = [(0.3 * k, 0.0, 0.2) for k in range(8)]
    model = balls(places, [0.1] * 8)
    contact = model.forces[0]
    assert len(contact.pairs(model)) == 36
    monkeypatch.setattr(surface_contact, "MOST_PAIRS", 36)
    assert not contact.crowded(model)
    fmb.linearize(model)
    monkeypatch.setattr(surface_contact, "MOST_PAIRS", 35)
    assert contact.crowded(model)
    with pytest.raises(ModelError, match="a crowd of surfaces"):
        fmb.linearize(model)


def test_more_pairs_than_the_matrix_has_places_for():
    """100 columns of two balls, 20 000 pairs: k d^1.5 at each contact (Hertz)."""
    model = column(100, 1e-3)
    wrenches, (potential, _) = loads(model)
    force = 1e6 * 1e-3**1.5
    system = compile(model)
    low = [system.marker_index[f"b{k}.center"] for k in range(100)]
    high = [system.marker_index[f"b{100 + k}.center"] for k in range(100)]
    np.testing.assert_allclose(wrenches[high, 2], force, rtol=1e-9)
    np.testing.assert_allclose(wrenches[low, 2], 0.0, atol=1e-9 * force)
    assert potential == pytest.approx(200 * 1e6 * 1e-3**2.5 / 2.5, rel=1e-9)


@pytest.mark.parametrize(
    "integrator",
    [fmb.GeneralizedAlpha(rtol=1e-8), fmb.Implicit(rtol=1e-8), fmb.IDA(rtol=1e-7), fmb.Explicit(rtol=1e-9)],
    ids=lambda method: type(method).__name__,
)
def test_motion_of_a_crowd_is_that_of_all_pairs(integrator, monkeypatch):
    """Balls in a row strike each other and the floor; the iteration matrix of the crowd is not complete, the equations
    are."""
    at = np.array([(0.0, 0.0, 0.11), (0.205, 0.01, 0.12), (0.1, 0.17, 0.13), (0.1, 0.06, 0.28)])
    law = fmb.Hertz(stiffness=1e5, damping=0.3, friction=0.2, transition=0.05)
    model = balls(at, np.full(4, 0.1), law)
    closely = fmb.simulate(model, 0.3, samples=4, integrator=fmb.Explicit(rtol=1e-11, atol=1e-12))
    monkeypatch.setattr(surface_contact, "MOST_PAIRS", 0)
    crowd = fmb.simulate(model, 0.3, samples=4, integrator=integrator)
    np.testing.assert_allclose(crowd.final.q, closely.final.q, atol=5e-5)
    np.testing.assert_allclose(crowd["state"][:, 0], closely["state"][:, 0], rtol=1e-2, atol=1e-2)


def test_a_bullet_meets_one_of_a_crowd(monkeypatch):
    """1 mm at 1000 m/s: no step passes the ball in its way."""
    monkeypatch.setattr(surface_contact, "MOST_PAIRS", 0)
    at = np.array([(0.0, 0.0, 1.0), (0.5, 0.0, 1.0), (0.9, 0.3, 1.0)])
    motion = {"velocity": [(1000.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)]}
    model = balls(at, np.array([5e-4, 1e-3, 0.1]), fmb.Hertz(stiffness=1e16), **motion)
    solution = fmb.simulate(model, 1e-3, samples=2, integrator=fmb.GeneralizedAlpha())
    # equal masses in a row exchange their velocities
    system = solution.phases[0].system
    speed = [solution.final.u[system.body_slices[name][1]][0] for name in ("b0", "b1")]
    assert speed[1] == pytest.approx(1000.0, rel=1e-2)
    assert abs(speed[0]) < 10.0


def test_what_a_crowd_says(monkeypatch):
    model = column(1, 0.02)
    monkeypatch.setattr(surface_contact, "MOST_PAIRS", 0)
    told = " ".join(fmb.check(model).warnings)
    assert "'floor' and 'b0' by 0.02 m" in told
    with pytest.raises(ModelError, match="a crowd of surfaces"):
        fmb.linearize(model)
