"""Linear equations of rolling systems in motion: the benchmark bicycle against table 2 of Meijaard et al. 2007."""

import numpy as np
import pytest
from verification.benchmark_bicycle import EIGENVALUES, bicycle

import flexmb as fmb


def found(linear) -> np.ndarray:
    """Return the eigenvalues that are not zero, by real part."""
    values = linear.eigenvalues[linear.eigenvalues != 0.0]
    return values[np.argsort(values.real)]


@pytest.mark.parametrize("speed", EIGENVALUES)
def test_eigenvalues_at_all_speeds(speed):
    """Castering, capsize and weave to ten digits; all else (place, heading, turns of the wheels, speed) is zero."""
    linear = fmb.linearize(bicycle(speed))
    expected = np.array(EIGENVALUES[speed])
    np.testing.assert_allclose(found(linear), expected[np.argsort(expected.real)], rtol=1e-10)
    assert linear.stable == (speed == 5.0)


@pytest.mark.parametrize(
    "units",
    [
        {"length": 1e-3},
        {"length": 1e3, "mass": 1e-3, "time": 1e-3},
        {"mass": 1e3, "time": 3600.0},
    ],
)
def test_eigenvalues_in_other_units(units):
    linear = fmb.linearize(bicycle(5.0, **units))
    expected = np.array(EIGENVALUES[5.0]) * units.get("time", 1.0)
    np.testing.assert_allclose(found(linear), expected[np.argsort(expected.real)], rtol=1e-9)


def test_it_can_be_anywhere():
    """100 km from the origin, where positions have ten digits."""
    linear = fmb.linearize(bicycle(5.0, offset=(1e5, -1e5, 0.0)))
    expected = np.array(EIGENVALUES[5.0])
    np.testing.assert_allclose(found(linear), expected[np.argsort(expected.real)], rtol=1e-6)


def test_state_space_and_response_belong_together():
    """C (i w - A)^-1 B between markers is the frequency response, and A has the eigenvalues of the paper."""
    linear = fmb.linearize(bicycle(5.0))
    A, B, C, _ = linear.state_space
    values = np.linalg.eigvals(A)
    for expected in EIGENVALUES[5.0]:
        assert np.abs(values - expected).min() < 1e-6
    inputs, outputs = linear.force_on("frame.head"), linear.motion_of("fork.front")
    w = 2.0 * np.pi * 0.7
    response = outputs @ C @ np.linalg.solve(1j * w * np.eye(len(A)) - A, B @ inputs)
    direct = linear.frequency_response([0.7], "frame.head", "fork.front")[0]
    np.testing.assert_allclose(direct, response, rtol=0.0, atol=1e-9 * np.abs(response).max())


def test_lean_and_weave_of_a_simulation():
    """Disturbed by a lean rate of 0.01 rad/s at 5 m/s, the simulated lean is made of the four modes of the paper."""
    disturbed = bicycle(5.0)
    axis = np.array([1e-2, 0.0, 0.0])
    for body in disturbed.bodies[1:]:
        spin = np.array(body.angular_velocity) + axis
        velocity = np.array(body.velocity) + np.cross(axis, body.at)
        disturbed = disturbed.changed(body.name, angular_velocity=tuple(spin), velocity=tuple(velocity))
    disturbed = disturbed.with_parts(sensors=[fmb.Orientation("lean", marker="frame.center")])
    solution = fmb.simulate(disturbed, t_end=2.0, samples=201, integrator=fmb.GeneralizedAlpha(rtol=1e-9))
    lean = 2.0 * solution["lean"][:, 1]
    values = np.array(EIGENVALUES[5.0])
    basis = np.exp(np.outer(solution.t, values))
    columns = np.column_stack([basis[:, 0].real, basis[:, 1].real, basis[:, 2].real, basis[:, 2].imag])
    fit = columns @ np.linalg.lstsq(columns, lean, rcond=None)[0]
    assert np.abs(lean - fit).max() < 1e-3 * np.abs(lean).max()


def test_both_real_eigenvalues_of_an_overdamped_freedom():
    """s^2 + 3 s + 2 = (s + 1)(s + 2); beside it s^2 + 2 s + 5, and a freedom without stiffness, s^2 + 4 s."""
    axis = {"x": (0, 0, 1), "z": (1, 0, 0)}
    bodies, joints, forces = [fmb.Ground(markers={"rail": fmb.Pose.axes((0, 0, 0), **axis)})], [], []
    for name, stiffness, damping in (("a", 2.0, 3.0), ("b", 5.0, 2.0), ("c", 0.0, 4.0)):
        bodies.append(fmb.PointMass(name, mass=1.0, at=(1.0, 0, 0)))
        forces.append(
            fmb.Bushing(
                name + " spring",
                markers=("ground.rail", name + ".center"),
                stiffness=(1e4, 1e4, stiffness, 0, 0, 0),
                damping=(0, 0, damping, 0, 0, 0),
            )
        )
    linear = fmb.linearize(fmb.Model(name="three", bodies=bodies, joints=joints, forces=forces))
    slow = linear.eigenvalues[np.abs(linear.eigenvalues) < 50.0]
    slow = slow[np.lexsort((slow.imag, np.round(slow.real, 6)))]
    np.testing.assert_allclose(slow, [-4.0, -2.0, -1.0, -1.0 + 2.0j, 0.0], rtol=1e-9, atol=1e-12)


def test_free_bodies_have_one_zero_for_every_motion():
    """Six of each of two free bodies; a spring between their centres makes one of them sqrt(k (1 / m + 1 / M))."""
    bodies = [
        fmb.RigidBody("a", mass=2.0, inertia=(1.0, 2.0, 2.5)),
        fmb.RigidBody("b", mass=3.0, inertia=(1e-3, 2e-3, 2e-3), at=(1.0, 2.0, 2.0)),
    ]
    spring = fmb.SpringDamper("s", markers=("a.center", "b.center"), stiffness=1e7, length=3.0)
    linear = fmb.linearize(fmb.Model(name="pair", bodies=[fmb.Ground(), *bodies], forces=[spring]))
    assert np.count_nonzero(linear.eigenvalues == 0.0) == 11
    np.testing.assert_allclose(linear.eigenvalues[11:], [1j * np.sqrt(1e7 * (1 / 2 + 1 / 3))], rtol=1e-10)
