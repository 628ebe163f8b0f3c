"""Steps that are short because a time must be met: what one alone tells of rates is rounding divided by its size, what
many over a pulse tell is the pulse.
"""

import numpy as np
import pytest

import flexmb as fmb

SAMPLE = 0.5


def four_bar(kink):
    """A four-bar linkage whose crank is pushed by a torque with a corner at `kink`, s."""

    def bar(name, a, b):
        a, b = np.array(a), np.array(b)
        middle = 0.5 * (a + b)
        markers = {"a": hinged(a - middle), "b": hinged(b - middle)}
        return fmb.RigidBody(name, mass=1.0, inertia=(0.01, 0.01, 0.01), at=tuple(middle), markers=markers)

    def hinged(at):
        return fmb.Pose.axes(tuple(at), z=(0, 1, 0))

    places = [(0.0, 0.0, 0.0), (0.2, 0.0, 0.3), (1.0, 0.0, 0.5), (1.1, 0.0, 0.0)]
    ground = fmb.Ground(markers={"o": hinged(places[0]), "d": hinged(places[3])})
    ends = (("ground.o", "x.a"), ("x.b", "y.a"), ("y.b", "z.a"), ("ground.d", "z.b"))
    kinds = (fmb.Revolute, fmb.Spherical, fmb.Cylindrical, fmb.Revolute)
    torque = fmb.table([0.0, kink, 1.0], [0.0, 4.0, -2.0], kind="linear")
    return fmb.Model(
        bodies=[ground, *(bar(n, a, b) for n, a, b in zip("xyz", places[:-1], places[1:], strict=True))],
        joints=[kind(f"j{k}", markers=pair) for k, (kind, pair) in enumerate(zip(kinds, ends, strict=True))],
        forces=[fmb.Actuator("m", joint="j0", effort=torque)],
        sensors=[fmb.JointCoordinate("angle", joint="j0"), fmb.Reaction("pull", joint="j1")],
    )


@pytest.mark.parametrize(
    ("integrator", "turned", "pulled"),
    [(fmb.GeneralizedAlpha(step=2e-3), 2e-3, 0.6), (fmb.GeneralizedAlpha(), 2e-3, 0.6)],
    ids=repr,
)
@pytest.mark.parametrize("before", [1e-12, 3e-10, 1e-7])
def test_a_corner_just_before_a_sample(integrator, turned, pulled, before):
    """A step of 0.3 ns between two of 2 ms: the run ended at infinity."""
    reference = fmb.simulate(four_bar(SAMPLE), 1.0, samples=21, integrator=fmb.Explicit(rtol=1e-10))
    solution = fmb.simulate(four_bar(SAMPLE - before), 1.0, samples=21, integrator=integrator)
    assert solution["angle"] == pytest.approx(reference["angle"], abs=turned)
    assert solution["pull"] == pytest.approx(reference["pull"], abs=pulled)


@pytest.mark.parametrize("width", [1e-2, 1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize(
    ("integrator", "within"),
    [
        (fmb.GeneralizedAlpha(), 1e-3),
        (fmb.GeneralizedAlpha(step=1e-2), 1e-3),
        (fmb.Implicit(), 2e-5),
        (fmb.IDA(), 2e-5),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_bell_of_force(integrator, within, width):
    """Its impulse is sqrt(pi) Ns, however short it is and wherever its times lie between the samples."""
    force = fmb.expression(f"{1.0 / width}*exp(-((t - 4.9973)/{width})**2)")
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.PointMass("p", mass=1.0)],
        forces=[fmb.PointLoad("f", marker="p.center", force=(force, 0, 0))],
        sensors=[fmb.Velocity("v", marker="p.center")],
    )
    run = fmb.simulate(model, 10.0, samples=11, integrator=integrator)
    assert run["v"][-1, 0] == pytest.approx(np.sqrt(np.pi), rel=within)
