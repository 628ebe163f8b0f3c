"""Events that remove what a controller measures: the event is named, and results are kept."""

import pytest

import flexmb as fmb


def chain(measured, then=()) -> fmb.Model:
    """Two rods; a controller at the first hinge follows the angle of the second, which breaks."""

    def y(z):
        return fmb.Pose.axes((0, 0, z), z=(0, 1, 0))

    rods = [
        fmb.RigidBody(
            f"rod{k}", mass=2.0, inertia=(0.2, 0.2, 0.01), at=(0, 0, -0.5 - k), markers={"top": y(0.5), "tip": y(-0.5)}
        )
        for k in range(2)
    ]
    effort = fmb.Pid(0.3 - fmb.measured(measured), kp=2.0, kd=0.1, filter=0.01)
    return fmb.Model(
        bodies=[fmb.Ground(markers={"y": y(0.0)}), *rods],
        joints=[
            fmb.Revolute("first", markers=("ground.y", "rod0.top")),
            fmb.Revolute("second", markers=("rod0.tip", "rod1.top")),
        ],
        forces=[fmb.Actuator("motor", joint="first", effort=effort)],
        sensors=[fmb.JointCoordinate(f"{name} angle", joint=name) for name in ("first", "second")],
        events=[fmb.Event("break", at=0.02, then=[fmb.Release("second"), *then])],
    )


OF_JOINT = fmb.JointCoordinate("own", joint="second")


@pytest.mark.parametrize("measured", ["second angle", OF_JOINT], ids=["sensor of the model", "sensor given"])
def test_a_run_names_the_event_and_keeps_what_was_computed(measured):
    with pytest.raises(fmb.IntegrationError, match=r"after Event 'break', which has removed Joint 'second'") as failed:
        fmb.simulate(chain(measured), 0.05, samples=11)
    run = failed.value.solution
    assert run.t[-1] == pytest.approx(0.02)
    assert "Stop" in run.status.remedy
    assert run["first angle"][-1] != 0.0


def test_a_stepper_names_it_too_and_can_go_back():
    with fmb.stepper(chain("second angle")) as run:
        run.advance(to=0.01)
        moment = run.save()
        with pytest.raises(fmb.ModelError, match=r"Force 'motor': after Event 'break'.*has removed.*'second angle'"):
            run.advance(to=0.03)
        assert run.t == pytest.approx(0.02)
        assert str(run.status).count("Stop") == 1
        run.restore(moment)
        assert run.advance(to=0.015)


def test_another_mistake_keeps_its_remedy():
    """What the event changes is wrong by itself: what to do about that does not give way to words about the event."""
    with pytest.raises(fmb.FlexmbError, match="frist") as failed:
        fmb.simulate(chain("first angle", then=[fmb.Change("motor", joint="frist")]), 0.05, samples=11)
    assert "Let the same event release" not in str(failed.value)


def test_an_event_that_also_releases_what_measures_goes_on():
    run = fmb.simulate(chain("second angle", then=[fmb.Release("motor")]), 0.05, samples=11)
    assert run.t[-1] == pytest.approx(0.05)


def test_a_run_that_ended_there_names_the_event_again_when_it_is_resumed():
    with pytest.raises(fmb.IntegrationError) as failed:
        fmb.simulate(chain("second angle"), 0.05, samples=6)
    with pytest.raises(fmb.ModelError, match=r"after Event 'break', which has removed Joint 'second'"):
        fmb.resume(failed.value.solution, 0.05)
