"""A beam spun up within 4 s to a multiple of its first bending frequency, as any kind of body, and exactly."""

import numpy as np
from verification.elastica_chain import extrapolated_lag
from verification.rotating_beams import in_rotating_frame, on_hub, slender

import flexmb as fmb
from flexmb import fem, reduction

LENGTH, EA, EI, RHO_A, RISE = 10.0, 2.8e7, 1.4e4, 1.2, 4.0
FIRST = 3.516015268666903 * np.sqrt(EI / RHO_A) / LENGTH**2
TIMES = np.linspace(0.0, 6.0, 121)


def rotation(multiple):
    """Return angle and rate of the hub; `multiple` of the first bending frequency is reached after 4 s."""
    speed = multiple * FIRST

    def angle(t):
        rising = speed / RISE * (t**2 / 2 + (RISE / 2 / np.pi) ** 2 * (np.cos(2 * np.pi * t / RISE) - 1))
        return np.where(t < RISE, rising, speed * (t - RISE / 2))

    def rate(t):
        return np.where(t < RISE, speed / RISE * (t - RISE / 2 / np.pi * np.sin(2 * np.pi * t / RISE)), speed)

    return angle, rate


def exact(multiple):
    """Return the tip's displacement across the hub's direction, (nt,), m: a geometrically exact chain, extrapolated."""
    return extrapolated_lag(LENGTH, EI, RHO_A, *rotation(multiple), TIMES, 24)


def floating(parts):
    """Return bodies, joints between them and the tip's marker of the beam as so many floating bodies."""
    fe = slender(LENGTH, EA, EI, 50.0 * EI, RHO_A, elements=48)
    ends, name = {"root": "start", "tip": "end"}, "beam"
    if parts == 1:
        data = (reduction.reduce(fe, ends, 3, geometric_stiffness=True, stress=False),)
    else:
        data = reduction.split(fem.split(fe, at=LENGTH * np.arange(1, parts) / parts), ends, 3, stress=False)
    bodies = fmb.FloatingBody.split(name, data)
    return bodies, fmb.Fixed.at_cuts(bodies), f"{name}_{parts}.tip"


def ancf(elements=12):
    """Return the same of the beam as an ANCF cable."""
    young = 1e9
    section = fem.Section.values(EA / young, EI / young, EI / young, 2 * EI / young)
    material = fmb.Material(young=young, poisson=0.0, density=RHO_A * young / EA)
    cable = fmb.AncfCable(
        "beam",
        points=((0, 0, 0), (LENGTH, 0, 0)),
        elements=elements,
        section=section,
        material=material,
        markers={"root": 0.0},
    )
    return (cable,), (), "beam.end"


def lag(beam, multiple):
    """Return the tip's displacement across the hub's direction, (nt,), m, of (bodies, joints, marker of the tip)."""
    (first, *others), joints, tip = beam
    text = "where(t < T, W/T*(t**2/2 + (T/2/pi)**2*(cos(2*pi*t/T) - 1)), W*(t - T/2))"
    model = on_hub(
        first,
        fmb.expression(text, W=multiple * FIRST, T=RISE),
        bodies=others,
        joints=joints,
        sensors=[fmb.Position("tip", marker=tip)],
    )
    motion = fmb.simulate(model, TIMES[-1], samples=TIMES, integrator=fmb.GeneralizedAlpha(rtol=1e-6))
    return in_rotating_frame(motion["tip"], rotation(multiple)[0](TIMES), LENGTH)[:, 1]
