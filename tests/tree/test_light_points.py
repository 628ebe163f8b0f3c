"""Points of little or no mass between joints, in joint coordinates: closed forms and the other formulations."""

import numpy as np
import pytest

import flexmb as fmb

MASSES = [0.0, 1e-12, 1e-7, 1e-4, 1.0]


def hung(mass: float) -> fmb.Model:
    """A rod that hangs by a ball joint on a point, which hangs by a ball joint on the ground; drawn horizontal."""
    return fmb.Model(
        name="rod on a point",
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(),
            fmb.PointMass("point", mass=mass),
            fmb.RigidBody.rod("rod", mass=1.0, length=1.0, radius=1e-3),
        ],
        joints=[
            fmb.Spherical("top", markers=("ground.origin", "point.center")),
            fmb.Spherical("low", markers=("point.center", "rod.start")),
        ],
    )


@pytest.mark.parametrize("mass", MASSES)
def test_a_rod_on_a_point_turns(mass):
    """3 g / 2 l = 14.715 rad/s2 for a thin rod; a quarter of its weight, and the point's, in the joints."""
    model = hung(mass)
    found = fmb.accelerations(model, formulation=fmb.Recursive())
    assert found["rod"][4] == pytest.approx(1.5 * 9.81, rel=1e-5)  # as thin as 1 mm
    assert found.reactions["top"][2] == pytest.approx(9.81 * (0.25 + mass), rel=1e-5)
    exact = fmb.accelerations(model, formulation=fmb.NullSpace())
    np.testing.assert_allclose(found["rod"], exact["rod"], rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("mass", MASSES)
def test_a_point_between_two_rods(mass):
    """The path of a double pendulum whose middle joint is a point, against Udwadia & Phohomsiri's closed form."""
    rod = fmb.RigidBody.rod
    model = fmb.Model(
        name="two rods",
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(),
            rod("first", mass=1.0, length=1.0, radius=0.01),
            fmb.PointMass("point", mass=mass, at=(1, 0, 0)),
            rod("second", mass=2.0, length=1.0, radius=0.01, at=(1, 0, 0)),
        ],
        joints=[
            fmb.Spherical("ground", markers=("ground.origin", "first.start")),
            fmb.Spherical("left", markers=("first.end", "point.center")),
            fmb.Spherical("right", markers=("point.center", "second.start")),
        ],
        sensors=[fmb.Position("tip", marker="second.end")],
    )
    paths = [
        fmb.simulate(model, t_end=0.2, samples=3, integrator=fmb.Explicit(formulation=formulation))["tip"]
        for formulation in (fmb.UdwadiaPhohomsiri(), fmb.Recursive())
    ]
    np.testing.assert_allclose(paths[1], paths[0], rtol=0.0, atol=1e-8)


def chain(masses) -> fmb.Model:
    """Points one below the other on rods of 1 m, each pushed to the side."""
    count = len(masses)
    places = np.cumsum(WAYS[:count], axis=0)
    names = [f"point{k}" for k in range(count)]
    above = ["ground.origin", *(f"{name}.center" for name in names)]
    return fmb.Model(
        bodies=[
            fmb.Ground(),
            *(fmb.PointMass(n, mass=m, at=tuple(p)) for n, m, p in zip(names, masses, places, strict=True)),
        ],
        joints=[fmb.Rod(f"rod{k}", markers=(above[k], above[k + 1])) for k in range(count)],
        forces=[fmb.PointLoad(f"push{k}", marker=above[k + 1], force=tuple(PUSHES[k])) for k in range(count)],
        gravity=(0, 0, -9.81),
    )


WAYS = np.array([(0.6, 0.0, -0.8), (0.8, 0.0, -0.6), (0.0, 0.6, -0.8)])
PUSHES = np.array([(0.0, 0.5, 0.2), (0.3, -1.0, 0.2), (0.6, 0.0, -0.4)])


@pytest.mark.parametrize(
    "masses", [(1.0, 1e-7), (1.0, 1e-10), (1e-8, 1.0), (1.0, 1e-8, 1e-8), (1e-8, 1e-8, 1.0), (1e-6, 1.0, 1e-12)]
)
def test_light_points_swing_on_their_rods(masses):
    """A motion that no rod holds is as free as that of a heavy point: M a = f - G^T lam with G a = 0, by unit masses.

    From 1e-7 of the heaviest mass on, such motions had no force and no weight.
    """
    count = len(masses)
    G = np.zeros((count, 3 * count))
    for k in range(count):
        G[k, 3 * k : 3 * k + 3] = WAYS[k]
        if k:
            G[k, 3 * k - 3 : 3 * k] = -WAYS[k]
    inverse = 1.0 / np.repeat(masses, 3)
    loads = PUSHES[:count].ravel() + np.repeat(masses, 3) * np.tile([0, 0, -9.81], count)
    forces = np.linalg.solve(G * inverse @ G.T, G @ (inverse * loads))
    expected = inverse * (loads - G.T @ forces)
    found = fmb.accelerations(chain(masses), formulation=fmb.Recursive())
    for k in range(count):
        of_point = expected[3 * k : 3 * k + 3]
        np.testing.assert_allclose(found[f"point{k}"][:3], of_point, rtol=0.0, atol=1e-6 * np.abs(of_point).max())
    along = [float(np.dot(found.reactions[f"rod{k}"][:3], -WAYS[k])) for k in range(count)]
    np.testing.assert_allclose(along, forces, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("mass", [5e-4, 1e-4])
def test_a_light_point_in_motion(mass):
    """Along an axis that lies across its rod but for 1e-20 as along any other: the axes of W are no measure."""
    ends = [
        fmb.simulate(chain((1.0, mass)), 0.02, samples=2, integrator=fmb.Explicit(formulation=formulation)).final.q
        for formulation in (fmb.Recursive(), fmb.NullSpace())
    ]
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.0, atol=1e-7)
