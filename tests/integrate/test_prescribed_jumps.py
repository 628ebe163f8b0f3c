"""Prescribed positions that jump are refused; prescribed speeds that jump act by impulses, as by hand."""

import warnings

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import IntegrationError, ModelError

INTEGRATORS = [
    fmb.GeneralizedAlpha(),
    fmb.Implicit(),
    fmb.Explicit(),
    fmb.Explicit(formulation=fmb.NullSpace()),
    fmb.Explicit(formulation=fmb.Recursive()),
    fmb.IDA(),
]


def cart(text: str, *, as_constraint=False, rod=False, **more) -> fmb.Model:
    """A cart of 1 kg on a slide along z, driven; with a rod of 2 kg and 1 m along y, hinged on it about x."""
    body = fmb.RigidBody(
        "cart", mass=1.0, inertia=(1, 1, 1), markers={"pin": fmb.Pose((0, 0, 0), ((0, 0, 1), (0, 1, 0), (-1, 0, 0)))}
    )
    bodies, joints = [fmb.Ground(), body], [fmb.Prismatic("A", markers=("ground.origin", "cart.center"))]
    if as_constraint:
        over, signal = [fmb.JointCoordinate("x", joint="A")], {"s": fmb.expression(text)}
        joints.append(fmb.Constraint("D", over=over, equation="x=s", parameters=signal))
    else:
        joints.append(fmb.Drive("D", joint="A", displacement=fmb.expression(text)))
    if rod:
        pin = fmb.Pose((0, -0.5, 0), ((0, 0, 1), (0, 1, 0), (-1, 0, 0)))
        bodies.append(
            fmb.RigidBody("rod", mass=2.0, inertia=(2 / 12, 0.01, 2 / 12), at=(0, 0.5, 0), markers={"end": pin})
        )
        joints.append(fmb.Revolute("B", markers=("cart.pin", "rod.end")))
    return fmb.Model(bodies=bodies, joints=joints, gravity=(0, 0, 0), **more)


@pytest.mark.parametrize("as_constraint", [False, True], ids=["drive", "constraint"])
@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_place_that_jumps_is_refused_before_computing(integrator, as_constraint):
    model = cart("where(t < 0.5, 0, 0.02)", as_constraint=as_constraint)
    with pytest.raises(ModelError, match=r"Joint 'D': .* jumps by 0.02 m at t = 0.5 s.*rise="):
        fmb.simulate(model, 1.0, integrator=integrator)


def test_kinematics_and_the_start_are_looked_at_too():
    with pytest.raises(ModelError, match=r"Joint 'D': .* jumps by 0.3 m at t = 0.5 s"):
        fmb.kinematics(cart("where(t < 0.5, 0, 0.3)"), 1.0)
    with pytest.raises(ModelError, match=r"Joint 'D': .* jumps by 0.3 m at t = 1 s"):
        fmb.kinematics(cart("where(t < 1, 0, 0.3)"), 1.0)
    with pytest.raises(ModelError, match=r"Joint 'D': .* jumps by 0.3 m at t = 0 s"):
        fmb.simulate(cart("where(t > 0, 0.3, 0)"), 1.0)


def test_a_jump_that_only_the_motion_shows_ends_the_run():
    """The signal of a product has no effect at the start, where its factor is zero."""
    ball = fmb.PointMass("b", mass=1.0, velocity=(1, 0, 0))
    rule = fmb.Constraint(
        "c",
        over=[fmb.Position("p", marker="b.center")],
        equation="p[0]*s + p[1] = 0",
        parameters={"s": fmb.expression("where(t < 0.5, 0, 1)")},
    )
    with pytest.raises(IntegrationError, match=r"Joint 'c' at t = 0.5.*jumps by 0.5 m") as caught:
        fmb.simulate(fmb.Model(bodies=[ball], joints=[rule], gravity=(0, 0, 0)), 1.0)
    assert caught.value.solution.t[-1] == pytest.approx(0.5, abs=0.01)


def test_what_an_event_ends_before_may_jump_later():
    model = cart("where(t < 0.5, 0, 0.3)", events=[fmb.Event("off", at=0.4, then=fmb.Stop())])
    assert fmb.simulate(model, 1.0).status.kind == "stopped"


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_speed_that_jumps_acts_by_an_impulse_and_is_told(integrator):
    """The hinge of a rod at rest gets 2 m/s at once: it turns with 3 v / (2 l) from then on, its moment of momentum
    about the hinge being zero."""
    model = cart("where(t < 0.5, 0, 2*(t - 0.5))", rod=True, sensors=[fmb.JointCoordinate("turn", joint="B")])
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        solution = fmb.simulate(model, 1.0, samples=11, integrator=integrator)
    sentences = [str(w.message) for w in told]
    assert [s for s in sentences if "Joint 'D': the speed that it prescribes jumps by 2 m/s at t = 0.5 s" in s]
    assert not [s for s in sentences if "no law explains" in s]
    late = solution.t > 0.55
    np.testing.assert_allclose(np.abs(solution["turn"][late]), 3.0 * (solution.t[late] - 0.5), rtol=2e-4)
    np.testing.assert_allclose(solution.final.q[:3], (0, 0, 1.0), atol=1e-6)


def test_smooth_leads_and_rounded_numbers_are_no_jumps():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        runs = [
            fmb.simulate(cart("where(t < 0.5, t**2, t - 0.25)"), 1.0, samples=5),
            fmb.simulate(cart("where(t < 0.5, sin(t), 0.4794255386 + 0.8775825619*(t - 0.5))"), 1.0, samples=5),
        ]
    assert all(run.status.ok and run.t[-1] == 1.0 for run in runs)


def told_by(analyse, *arguments, **more) -> tuple[fmb.Solution, list[str]]:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        solution = analyse(*arguments, **more)
    return solution, [str(w.message) for w in told]


def test_many_jumps_of_speed_are_one_sentence_with_the_largest():
    """A saw by a table of straight pieces: speeds 1, -2, 4 m/s in turn."""
    saw = fmb.table([0.0, 0.2, 0.4, 0.6, 0.8], [0.0, 0.2, -0.2, 0.6, 0.6], kind="linear")
    model = cart("0").changed("D", displacement=saw)
    for analyse in (fmb.simulate, fmb.kinematics):
        solution, sentences = told_by(analyse, model, 0.8, samples=9)
        mine = [s for s in sentences if "the speed that it prescribes jumps" in s]
        assert len(mine) == 1
        assert "Joint 'D'" in mine[0]
        assert "by 6 m/s at t = 0.4 s" in mine[0]
        assert "jumps, the largest)" in mine[0]
        assert mine[0] in solution.statistics["warnings"]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_speed_that_jumps_at_the_start_acts_on_bodies_at_rest(integrator):
    """As above, from the first instant: the rod turns with 3 v / (2 l), whatever its drawing says."""
    text = "where(t > 0, 2*t, 0)"
    model = cart(text, rod=True, sensors=[fmb.JointCoordinate("turn", joint="B")])
    solution, sentences = told_by(fmb.simulate, model, 0.2, samples=3, integrator=integrator)
    assert [s for s in sentences if "jumps by 2 m/s at t = 0 s" in s or "jumps by 2 m/s at t = 1e-18 s" in s]
    np.testing.assert_allclose(np.abs(solution["turn"][1:]), 3.0 * solution.t[1:], rtol=2e-4)


def test_inverse_dynamics_refuses_a_place_that_jumps():
    model = cart("0").without("D")
    drive = fmb.Drive("D", joint="A", displacement=fmb.step(0.3, at=0.5))
    with pytest.raises(ModelError, match=r"Joint 'D': .* jumps by 0.3 m at t = 0.5 s"):
        fmb.inverse_dynamics(model, [drive], 1.0)


def test_a_jump_after_an_event_ends_the_run_with_what_was_before():
    """The event replaces the signal by one that jumps later."""
    jump = fmb.Event("swap", at=0.3, then=fmb.Change("D", displacement=fmb.expression("where(t < 0.5, 0, 0.3)")))
    with pytest.raises(IntegrationError, match=r"Joint 'D' at t = 0.5.*jumps by 0.3 m") as caught:
        fmb.simulate(cart("0", events=[jump]), 1.0, samples=11)
    assert caught.value.solution.t[-1] == 0.4


def test_a_run_that_is_moved_on_from_outside_sees_jumps_too():
    with fmb.stepper(cart("where(t < 0.5, 0, 0.3)"), t_end=1.0) as run:
        run.advance(by=0.4)
        with pytest.raises((ModelError, IntegrationError), match=r"Joint 'D'.* jumps by 0.3 m at t = 0.5"):
            run.advance(by=0.4)


@pytest.mark.parametrize("begin", [0.0, 5e4])
def test_fast_motion_at_a_late_time_is_no_jump(begin):
    """A wheel at 3000 rpm in the tenth orbit, and a shaker, both beside the times of another signal: between the two
    numbers next to such a time they move."""
    wheel = fmb.RigidBody("wheel", mass=1.0, inertia=(1, 1, 1))
    cart = fmb.RigidBody("cart", mass=1.0, inertia=(1, 1, 1))
    slide = fmb.RigidBody("slide", mass=1.0, inertia=(1, 1, 1))
    joints = [
        fmb.Revolute("hinge", markers=("ground.origin", "wheel.center")),
        fmb.Prismatic("one", markers=("ground.origin", "cart.center")),
        fmb.Prismatic("other", markers=("ground.origin", "slide.center")),
        fmb.Drive("spin", joint="hinge", angle=fmb.expression("314.159*t")),
        fmb.Drive("shake", joint="one", displacement=fmb.expression("0.01*sin(600*t)")),
        fmb.Drive("lead", joint="other", displacement=fmb.step(0.1, at=begin + 0.01, rise=0.005)),
    ]
    model = fmb.Model(bodies=[fmb.Ground(), wheel, cart, slide], joints=joints)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = fmb.simulate(model, begin + 0.02, t_start=begin, samples=3, integrator=fmb.Explicit())
    assert run.t[-1] == begin + 0.02


@pytest.mark.parametrize("text", ["pi*t", "where(t < 1, pi*t, pi*(2*t - 1) - pi*(t - 1))", "-pi*t"])
def test_half_a_turn_is_no_jump(text):
    """Half a turn from the start the angle of a joint at rest passes from one sense to the other."""
    wheel = fmb.RigidBody("wheel", mass=1.0, inertia=(1, 1, 1))
    hinge = fmb.Revolute("hinge", markers=("ground.origin", "wheel.center"))
    drive = fmb.Drive("spin", joint="hinge", angle=fmb.expression(text))
    load = fmb.PointLoad("load", marker="wheel.center", force=(0, 0, fmb.step(0.1, at=1.0)))
    model = fmb.Model(bodies=[fmb.Ground(), wheel], joints=[hinge, drive], forces=[load])
    run = fmb.simulate(model, 1.2, samples=3, integrator=fmb.Explicit())
    angle = 2.0 * np.arctan2(run.final.q[6], run.final.q[3]) if run.final.q[3] else np.pi
    assert np.cos(angle) == pytest.approx(np.cos(1.2 * np.pi), abs=1e-6)
