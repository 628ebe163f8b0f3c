"""Every sensor, and events of every kind, with joint coordinates as with the coordinates of the bodies."""

from dataclasses import replace

import numpy as np
import pytest
from by_turns import slow
from tree.models import branched, chain, loops

import flexmb as fmb

REFERENCE = fmb.Explicit(rtol=1e-11, atol=1e-13)
JOINTS = [fmb.Explicit(formulation=fmb.Recursive(), rtol=1e-11, atol=1e-13), fmb.Implicit(rtol=1e-10)]


def watched(model):
    """Return the model with a sensor of every kind on all that it has."""
    markers = [name for name in model.marker_names() if not name.startswith("ground")]
    kinds = (fmb.Position, fmb.Velocity, fmb.Acceleration, fmb.Orientation)
    sensors = [kind(f"{kind.__name__} {k}", marker=marker) for kind in kinds for k, marker in enumerate(markers)]
    sensors += [fmb.Reaction(f"R {joint.name}", joint=joint.name) for joint in model.joints]
    sensors += [fmb.ForceOf(f"F {force.name}", force=force.name) for force in model.forces]
    return replace(model, sensors=(*sensors, fmb.Energy("energy", kind="kinetic"), fmb.Momentum("momentum")))


@pytest.mark.parametrize(
    ("make", "t_end"),
    [slow(branched, 0.01), (lambda: chain(3, fmb.Spherical), 0.4), (loops, 0.005)],
    ids=["branched", "balls", "flexible loops"],
)
def test_every_sensor(make, t_end):
    """To 1e-7 of the largest value of its kind; to 1e-3 with the implicit method, which damps the fastest modes."""
    model = watched(make())
    expected = fmb.simulate(model, t_end, samples=5, integrator=REFERENCE)
    scale: dict[type, float] = {}
    for sensor in model.sensors:
        scale[type(sensor)] = max(scale.get(type(sensor), 1e-6), np.abs(expected[sensor.name]).max())
    for integrator, tolerance in zip(JOINTS, (1e-7, 1e-3), strict=True):
        found = fmb.simulate(model, t_end, samples=5, integrator=integrator)
        for sensor in model.sensors:
            np.testing.assert_allclose(
                found[sensor.name],
                expected[sensor.name],
                atol=tolerance * scale[type(sensor)],
                rtol=0,
                err_msg=sensor.name,
            )


EVENTS = {
    "lock": fmb.Event("event", sensor="q0", below=-0.8, then=fmb.Lock("j1")),
    "release": fmb.Event("event", sensor="q0", below=-0.8, then=fmb.Release("j2")),
    "change": fmb.Event("event", at=0.3, then=fmb.Change("k", stiffness=50.0)),
    "stop": fmb.Event("event", sensor="q0", below=-1.0, then=fmb.Stop()),
}


@pytest.mark.parametrize("integrator", JOINTS, ids=["explicit", "implicit"])
@pytest.mark.parametrize("event", EVENTS)
def test_every_event(event, integrator):
    """Three rods that fall, the last on a spring: the same moment of the event, and the same motion after it."""
    sensors = [fmb.JointCoordinate("q0", joint="j0"), fmb.Position("tip", marker="b2.end")]
    model = chain(3).with_parts(forces=[fmb.TorsionSpring("k", joint="j2", stiffness=5.0)])
    model = replace(model, sensors=tuple(sensors), events=(EVENTS[event],))
    expected = fmb.simulate(model, 0.8, samples=9, integrator=REFERENCE)
    found = fmb.simulate(model, 0.8, samples=9, integrator=integrator)
    assert [phase.ended for phase in found.phases] == [phase.ended for phase in expected.phases]
    assert found.phases[0].ended == "event"
    np.testing.assert_allclose(found.phases[0].t[-1], expected.phases[0].t[-1], atol=1e-8)
    np.testing.assert_allclose(found["tip"], expected["tip"], atol=1e-7)
