"""Functions of the user that remember calls, or draw at random, are found out: a sum over calls is no integral."""

import numpy as np
import pytest

import flexmb as fmb


class Summing:
    """A PI controller as it stands in the program of a computer: one call a sample, and a sum over calls."""

    def __init__(self, begins: float = 0.0):
        self.sum, self.begins = 0.0, begins

    def __call__(self, t, x):
        self.sum += 0.01 * x[0] if np.real(t) >= self.begins else 0.0
        return -3.0 * x[0] - 2.0 * self.sum


def cart(effort=None, forces=()) -> fmb.Model:
    axis = fmb.Pose.axes(z=(1.0, 0.0, 0.0))
    ground = fmb.Ground(markers={"rail": axis})
    body = fmb.RigidBody.box("cart", size=(0.1, 0.1, 0.1), density=1e3, at=(0.2, 0.0, 0.0), markers={"rail": axis})
    motors = [] if effort is None else [fmb.Actuator("motor", joint="rail", effort=effort)]
    return fmb.Model(
        bodies=[ground, body],
        joints=[fmb.Prismatic("rail", markers=("ground.rail", "cart.rail"))],
        forces=[*motors, *forces],
        sensors=[fmb.JointCoordinate("x", joint="rail")],
    )


@pytest.mark.parametrize("begins", [0.0, 0.3])
@pytest.mark.parametrize("sampled", [False, True])
def test_a_sum_over_calls_is_refused(sampled, begins):
    law = fmb.Function([fmb.measured("x")], function=Summing(begins))
    model = cart(fmb.Sampled(law, period=0.01) if sampled else law)
    with pytest.raises(fmb.FlexmbError, match=r"with the same arguments it returned .*, then .*SampledStateSpace"):
        fmb.simulate(model, t_end=1.0, samples=11)


def test_noise_is_refused():
    noise = np.random.default_rng(1)
    law = fmb.Function([fmb.measured("x")], function=lambda t, x: -x[0] * (1.0 + 0.1 * noise.random()))
    with pytest.raises(fmb.FlexmbError, match="draw at random"):
        fmb.simulate(cart(law), t_end=1.0, samples=11)


def test_a_force_that_counts_its_calls_is_refused():
    calls = []

    def law(t, d, v, R, w):
        calls.append(t)
        return (-1e-3 * len(calls), 0.0, 0.0), (0.0, 0.0, 0.0)

    force = fmb.UserForce("law", markers=("ground.rail", "cart.rail"), function=law)
    with pytest.raises(fmb.FlexmbError, match=r"Force 'law': .*with the same arguments it returned"):
        fmb.simulate(cart(forces=[force]), t_end=1.0, samples=11)


def test_functions_of_their_arguments_may_keep_notes():
    """A list of what it was asked is no memory that matters; the cart swings with sqrt(k/m), m = 1 kg."""
    asked = []

    def law(t, x):
        asked.append(t)
        return -4.0 * x[0]

    solution = fmb.simulate(cart(fmb.Function([fmb.measured("x")], function=law)), t_end=1.0, samples=11)
    assert asked
    assert solution["x"] == pytest.approx(0.2 * np.cos(2.0 * solution.t), abs=1e-4)


def test_functions_may_write_to_their_arguments():
    def law(t, x):
        x *= -4.0
        return x[0]

    function = fmb.Function([fmb.measured("x")], function=law, jacobian=lambda t, x: [-4.0])
    solution = fmb.simulate(cart(function), t_end=1.0, samples=11)
    assert solution["x"] == pytest.approx(0.2 * np.cos(2.0 * solution.t), abs=1e-4)


def test_the_last_digits_of_an_iteration_are_no_memory():
    """A law that iterates from where the last call has ended, to eleven digits."""
    known = [0.0]

    def law(t, d, v, R, w):
        while True:
            step = 0.7 * (-4.0 * d[2] - known[0])
            known[0] += step
            if abs(step) <= 1e-11:
                return (0.0, 0.0, known[0]), (0.0, 0.0, 0.0)

    force = fmb.UserForce("law", markers=("ground.rail", "cart.rail"), function=law)
    solution = fmb.simulate(cart(forces=[force]), t_end=0.5, samples=11)
    assert solution["x"] == pytest.approx(0.2 * np.cos(2.0 * solution.t), abs=1e-4)
