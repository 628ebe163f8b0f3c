"""What `verify` divides differences by: a small motion far from the origin counts, rounding does not."""

import numpy as np

import flexmb as fmb

MASS, STIFFNESS, AMPLITUDE = 2.0, 800.0, 2e-3  # kg, N/m, m
AT = (0.4, 0.0, -MASS * 9.81 / STIFFNESS)  # the spring hangs beside the origin; its zero length is above


def bobbing(pull: float) -> fmb.Model:
    """A mass on a vertical spring 0.4 m beside the origin, `pull` m below its equilibrium."""
    ground = fmb.Ground(markers={"O": (0.4, 0.0, 1.0)})
    bob = fmb.PointMass("bob", mass=MASS, at=(AT[0], AT[1], AT[2] - pull))
    return fmb.Model(
        name="bobbing",
        gravity=(0, 0, -9.81),
        bodies=[ground, bob],
        forces=[fmb.SpringDamper("spring", markers=("ground.O", "bob.center"), stiffness=STIFFNESS, length=1.0)],
        sensors=[
            fmb.Position("place", marker="bob.center"),
            fmb.Velocity("speed", marker="bob.center"),
            fmb.ForceOf("force", force="spring"),
        ],
    )


def test_a_small_motion_far_from_the_origin_counts():
    """z = z0 - a cos w t: its error is the one of the closed form over 2 a, not over 0.4 m."""
    coarse = fmb.simulate(bobbing(AMPLITUDE), 1.0, samples=51, integrator=fmb.GeneralizedAlpha(rtol=1e-2))
    omega = np.sqrt(STIFFNESS / MASS)
    error = np.abs(coarse["place"][:, 2] - (AT[2] - AMPLITUDE * np.cos(omega * coarse.t))).max()
    assert error / (2.0 * AMPLITUDE) > 0.05
    assert error / 0.4 < 0.01  # as a share of the largest place it would pass
    found = fmb.verify(coarse)
    place = next(answer for answer in found.answers if answer.name == "place")
    assert not place.holds
    np.testing.assert_allclose(place.course["integrator"], error / np.ptp(coarse["place"][:, 2]), rtol=0.05)
    np.testing.assert_allclose(place.scale, np.ptp(coarse["place"][:, 2]), rtol=1e-12)
    assert place.compared_with.endswith("(z)")
    assert place.compared_with in str(found)
    fine = fmb.verify(fmb.simulate(bobbing(AMPLITUDE), 1.0, samples=51, integrator=fmb.GeneralizedAlpha(rtol=1e-8)))
    assert fine.ok, str(fine)


def test_rounding_is_no_answer():
    """x and y vary by rounding only, and at rest all three do: nothing of it is an alarm."""
    at_rest = fmb.simulate(bobbing(0.0), 0.5, samples=51)
    assert np.ptp(at_rest["place"], axis=0).max() < 1e-6
    found = fmb.verify(at_rest)
    assert all(answer.holds for answer in found.answers), str(found)


def test_a_component_that_only_rounding_moves():
    """Turned by an angle, a symmetric motion leaves rounding across it, which differs from run to run."""
    noise = 1e-12 * np.random.default_rng(5).standard_normal((2, 101))
    from flexmb.trust.answers import column_scales

    t = np.linspace(0.0, 1.0, 101)
    run = np.column_stack([0.4 + 0.002 * np.sin(9.0 * t), noise[0], np.full(101, 0.3) + noise[1]])
    scales = column_scales(run, "m")
    np.testing.assert_allclose(scales[0], np.ptp(run[:, 0]), rtol=1e-12)
    assert scales[1] > 1e5 * np.ptp(noise[0])
    assert scales[2] > 1e5 * np.ptp(noise[1])
    # a force of zero mean is compared with its largest value, which is smaller than what it varies by
    np.testing.assert_allclose(column_scales(np.sin(9.0 * t)[:, None], "N"), np.sin(9.0 * t).max(), rtol=1e-12)
