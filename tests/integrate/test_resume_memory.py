"""What a run remembers is stored with every sample: cut off anywhere, it goes on as the uninterrupted one.

Steps of fixed size, so that the two runs can take the same ones: what differs is rounding, and errors of the method
where it begins anew.
"""

from dataclasses import replace

import numpy as np
import pytest
from by_turns import slow
from faults.bench import SCENES

import flexmb as fmb

X = fmb.JointCoordinate("x", joint="rail")
CONTROL = fmb.formula("-30*x - 3*rate(x)", over={"x": X})
STEP = fmb.GeneralizedAlpha(step=1e-3)
FIELDS = ("t", "q", "u", "a", "lam", "works")


def cart(*forces, effort=0.0, **more) -> fmb.Model:
    """A cart on a rail, falling towards a spring, with what remembers something."""
    spring = fmb.formula("-40*x - 9.81", over={"x": X})
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("cart", mass=1.0, inertia=(1, 1, 1), at=(0, 0, 0.3))],
        joints=[fmb.Prismatic("rail", markers=("ground.origin", "cart.center"))],
        forces=[fmb.Actuator("push", joint="rail", effort=effort), fmb.Actuator("back", joint="rail", effort=spring)]
        + list(forces),
        sensors=[X],
        **more,
    )


MODELS = {
    "relay": lambda: cart(effort=fmb.Relay(X, limits=(-0.1, 0.1), values=(2.0, -2.0))),
    "quantiser": lambda: cart(effort=fmb.formula("-3*y", over={"y": fmb.Quantiser(X, step=0.05, hysteresis=0.3)})),
    "delay": lambda: cart(effort=fmb.Delay(CONTROL, time=0.03)),
    "sampled": lambda: cart(effort=fmb.Sampled(CONTROL, period=0.013)),
    "relay over sampled": lambda: cart(
        effort=fmb.Relay(fmb.Sampled(X, period=0.013), limits=(-0.1, 0.1), values=(2.0, -2.0))
    ),
    "controller in discrete time": lambda: cart(
        effort=fmb.SampledStateSpace(X, A=[[0.9]], B=[[1.0]], C=[[-2.0]], D=[[-1.0]], period=0.013)
    ),
    "rate limit": lambda: cart(effort=fmb.RateLimit(CONTROL, limits=(-20.0, 20.0), time=0.01)),
    "controller with a limited integral": lambda: cart(effort=fmb.Pid(X, kp=-20.0, ki=-10.0, kd=-1.0, limits=(-3, 3))),
    "bristles": lambda: cart(
        fmb.LuGre("rub", joint="rail", stiffness=1e4, damping=100.0, moving=0.5, standing=0.7, stribeck=0.01)
    ),
    "repeating event": lambda: cart(
        events=[fmb.Event("low", sensor="x", below=-0.2, repeats=True, then=[fmb.Change("cart", mass=1.1)])]
    ),
}

CLOSE = {"delay": 1e-6}
"""m: poles of 30 to 150 rad/s in steps of 1 ms, whose error is seen where the method begins anew."""


def cut(solution: fmb.Solution, samples: int) -> fmb.Solution:
    """Return the first samples of a run, as it would have been when it was cut off behind them."""
    phases = []
    for phase in solution.phases:
        if len(phase.t) > samples:
            kept = {name: getattr(phase, name)[:samples] for name in FIELDS}
            phases.append(replace(phase, ended="interrupted", **kept))
            break
        phases.append(phase)
        samples -= len(phase.t)
    return replace(solution, phases=tuple(phases), status=fmb.Status.interrupted(float(phases[-1].t[-1])))


@pytest.mark.parametrize("name", MODELS)
def test_what_is_remembered_goes_on(name):
    """In events, and while relays change, steps end at looks: those of the whole run, also in what is left of it."""
    model = MODELS[name]()
    whole = fmb.simulate(model, 0.6, integrator=STEP, samples=101)
    for samples in (23, 58, 90):
        rest = fmb.resume(cut(whole, samples), 0.6, integrator=STEP, samples=101)
        assert [phase.ended for phase in rest.phases] == [phase.ended for phase in whole.phases]
        np.testing.assert_allclose(rest["x"], whole["x"], rtol=0, atol=CLOSE.get(name, 1e-9))


@pytest.mark.parametrize("samples", [45, slow(160), 310])
def test_compliant_contact_with_a_relay(samples):
    """A box and a ball hit the floor while a relay and a sampled controller act: 2.6e-4 m before, by other steps."""
    make, settings, _ = SCENES["press"]
    whole = fmb.simulate(make(), **settings.keywords())
    keywords = {**settings.keywords(), "integrator": settings.integrator}
    rest = fmb.resume(cut(whole, samples), **keywords)
    for name in ("box", "ball", "place"):
        np.testing.assert_allclose(rest[name], whole[name], rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    "integrator", [STEP, fmb.Explicit(), fmb.Implicit(), fmb.IDA()], ids=lambda i: type(i).__name__
)
def test_a_stepped_run_goes_back_to_what_was_saved(integrator):
    """Without any input between, so that nothing begins anew by itself; IDA begins anew where it is restored."""
    with fmb.stepper(MODELS["relay"](), integrator=integrator, t_end=1.0) as run:
        run.advance(to=0.2)
        moment = run.save()
        ends = []
        for _ in range(2):
            run.restore(moment)
            run.advance(to=0.7)
            ends.append(run["x"])
    assert ends[0] == pytest.approx(ends[1], abs=0.0 if not isinstance(integrator, fmb.IDA) else 1e-5)
