"""Stops and friction in one freedom, in other units of length and time: the same contacts, steps and motion.

Units that are powers of two leave every digit as it is: whatever differs then has been compared with a number of
another unit. Adaptive runs in other units round differently, which friction that sticks makes visible.
"""

import numpy as np
import pytest

import flexmb as fmb

END, SAMPLES = 0.8, 41
POWERS = [(2.0**-17, 1.0), (2.0**10, 1.0), (1.0, 2.0**-13), (2.0**-3, 2.0**13)]


def turning(L=1.0, T=1.0, stop=True) -> fmb.Model:
    """A bar that falls on a stop of its hinge, which rubs; `stop` False: on two one-sided springs."""
    arm = fmb.RigidBody(
        "arm",
        mass=1.0,
        inertia=np.array((0.01, 0.08, 0.08)) * L**2,
        at=(0.5 * L, 0, 0),
        markers={"a": (-0.5 * L, 0, 0)},
    )
    law = {"joint": "joint", "stiffness": 2000.0 * L**2 / T**2, "damping": 3.0 * L**2 / T, "depth": 1e-3}
    stops = [fmb.BiStop("stop", travel=(-0.6, 0.4), **law)]
    if not stop:
        stops = [
            fmb.OneSidedSpring("low", length=0.0, backlash=0.6, exponent=1.0, **law),
            fmb.OneSidedSpring("high", length=0.0, backlash=0.4, exponent=1.0, pulls=True, **law),
        ]
    rub = fmb.JointFriction(
        "rub", joint="joint", moving=0.15, standing=0.25, stribeck=0.05 / T, transition=5e-3 / T, radius=0.04 * L
    )
    return fmb.Model(
        gravity=(0, -9.81 * L / T**2, 0),
        bodies=[fmb.Ground(), arm],
        joints=[fmb.Revolute("joint", markers=("ground.origin", "arm.a"))],
        forces=[*stops, rub],
        sensors=[fmb.Velocity("v", marker="arm.center"), fmb.Reaction("R", joint="joint"), fmb.Energy("E")],
    )


def sliding(L=1.0, T=1.0) -> fmb.Model:
    """A cart with a pendulum between the stops of a rail, which rubs."""
    axis = fmb.Pose.axes((0, 0, 0), z=(1, 0, 0), x=(0, 1, 0))
    moves = {"velocity": (2.0 * L / T, 0, 0)}
    cart = fmb.RigidBody("cart", mass=1.0, inertia=np.full(3, 0.1 * L**2), markers={"c": axis}, **moves)
    rod = fmb.RigidBody(
        "rod",
        mass=0.5,
        inertia=np.array((0.01, 0.04, 0.04)) * L**2,
        at=(0, -0.3 * L, 0),
        markers={"top": (0, 0.3 * L, 0)},
        **moves,
    )
    stop = fmb.BiStop(
        "stop", joint="joint", travel=(-0.2 * L, 0.3 * L), stiffness=5e3 / T**2, damping=5.0 / T, depth=1e-3 * L
    )
    rub = fmb.JointFriction(
        "rub", joint="joint", moving=0.05, standing=0.1, stribeck=0.05 * L / T, transition=5e-3 * L / T
    )
    return fmb.Model(
        gravity=(0, -9.81 * L / T**2, 0),
        bodies=[fmb.Ground(markers={"c": axis}), cart, rod],
        joints=[
            fmb.Prismatic("joint", markers=("ground.c", "cart.c")),
            fmb.Revolute("pin", markers=("cart.center", "rod.top")),
        ],
        forces=[stop, rub],
        sensors=[fmb.Velocity("v", marker="rod.center"), fmb.Reaction("R", joint="joint"), fmb.Energy("E")],
    )


def seen(described, integrator, L=1.0, T=1.0, **how) -> tuple[list[np.ndarray], fmb.Solution]:
    """Return speed, reaction and energy in metres, kilograms and seconds, relative to their largest values."""
    run = fmb.simulate(described(L, T, **how), END * T, samples=SAMPLES, integrator=integrator)
    force = L / T**2
    units = (L / T, np.repeat((force, force * L), 3), force * L)
    return [run[name] / unit for name, unit in zip(("v", "R", "E"), units, strict=True)], run


def apart(one, other) -> float:
    """Return the largest difference of a result, relative to its largest value."""
    return max(np.abs(a - b).max() / np.abs(b).max() for a, b in zip(one, other, strict=True))


@pytest.mark.filterwarnings("ignore::flexmb.ValidityWarning")
@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(rtol=1e-7), fmb.Implicit()], ids=repr)
@pytest.mark.parametrize("described", [turning, sliding])
def test_units_that_keep_all_digits_change_nothing(integrator, described):
    plain, run = seen(described, integrator)
    assert run.statistics["cut at contacts"] > 0
    for L, T in POWERS:
        other, scaled = seen(described, integrator, L, T)
        assert apart(other, plain) < 1e-12
        assert scaled.statistics["cut at contacts"] == run.statistics["cut at contacts"]


@pytest.mark.filterwarnings("ignore::flexmb.ValidityWarning")
@pytest.mark.parametrize(("L", "T"), [(9.7e-6, 1.0), (1e3, 1.0), (1.0, 1e-4)])
@pytest.mark.parametrize("stop", [True, False])
def test_a_hinge_with_stop_and_friction_in_other_units(L, T, stop):
    """Beside `Explicit` in metres and seconds at a tolerance of its own."""
    exact, _ = seen(turning, fmb.Explicit(rtol=1e-9), stop=stop)
    for integrator, within in ((fmb.GeneralizedAlpha(rtol=1e-7), 3e-3), (fmb.Implicit(rtol=1e-7), 1e-3)):
        found, _ = seen(turning, integrator, L, T, stop=stop)
        assert apart(found, exact) < within


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.Implicit()], ids=repr)
def test_a_surface_touches_wherever_it_lies(integrator):
    """A ball bounces beside the origin of its plane, on either side: the same steps, and errors as unknown."""
    told = []
    for x in (0.5, -0.5):
        model = fmb.Model(
            gravity=(0, 0, -9.81),
            bodies=[fmb.Ground(), fmb.RigidBody("b", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(x, 0, 0.12))],
            surfaces=[
                fmb.Surface("floor", marker="ground.origin", shape=fmb.Plane()),
                fmb.Surface("ball", marker="b.center", shape=fmb.Sphere(radius=0.1)),
            ],
            forces=[fmb.SurfaceContact("c", surfaces=("floor", "ball"), law=fmb.Hertz(stiffness=1e6))],
        )
        run = fmb.simulate(model, 0.3, samples=11, integrator=integrator)
        told.append((run.statistics["notes"], run.statistics["steps"], run.statistics["cut at contacts"]))
    assert any("not known where something touches" in note for note in told[0][0])
    assert told[0] == told[1]
