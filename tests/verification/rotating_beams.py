"""Beams and plates on a hub that turns about the global z-axis: spin-up motions and frequencies at steady speed."""

import numpy as np

import flexmb as fmb
from flexmb import fem, reduction

FULL_SPEED, RISE = 6.0, 15.0
DRIVE = "where(t < 15, 0.4*(t**2/2 + (7.5/pi)**2*(cos(pi*t/7.5) - 1)), 6*t - 45)"
"""Angle, rad, of the spin-up to 6 rad/s in 15 s of Kane, Ryan & Banerjee and of Simo & Vu-Quoc."""


def angle(t):
    """Return the angle of `DRIVE`."""
    rising = 0.4 * (t**2 / 2 + (7.5 / np.pi) ** 2 * (np.cos(np.pi * t / 7.5) - 1))
    return np.where(t < RISE, rising, FULL_SPEED * t - 45.0)


def slender(length, EA, EI_chord, EI_flap, rhoA, elements=40):
    """Return the FE model of a straight beam along x without shear and rotary inertia: chord in x-y, flap in x-z."""
    young = 1e9
    area = EA / young
    section = fem.Section.values(
        area=area, inertia_y=EI_flap / young, inertia_z=EI_chord / young, torsion=100.0 * max(EI_flap, EI_chord) / young
    )
    material = fmb.Material(young=young, poisson=0.0, density=rhoA / area)
    points = np.linspace([0, 0, 0], [length, 0, 0], elements + 1)
    return fem.frame(points, section=section, material=material, shear=False, rotary_inertia=False)


def spin_up_beam(length, EA, EI, rhoA, modes=6, **options):
    """Return the data of a beam that bends in the x-y plane; out of it, and in torsion, it is nearly rigid."""
    fe = slender(length, EA, EI, 50.0 * EI, rhoA)
    return reduction.reduce(
        fe, {"root": "start", "tip": "end"}, modes, geometric_stiffness=True, stress=False, **options
    )


def on_hub(body, angle, radius=0.0, bodies=(), joints=(), **options):
    """Return the model of a body held at its marker "root", `radius` from the axis, by a hub that turns by `angle`."""
    body = body.replaced(at=tuple(np.add(body.at, (radius, 0, 0))))
    hub = fmb.RigidBody("hub", mass=1.0, inertia=(1.0, 1.0, 1.0), markers={"rim": (radius, 0, 0)})
    return fmb.Model(
        bodies=[fmb.Ground(), hub, body, *bodies],
        joints=[
            fmb.Revolute("axis", markers=("ground.origin", "hub.center")),
            fmb.Fixed("clamp", markers=("hub.rim", f"{body.name}.root")),
            *joints,
            fmb.Drive("spin", joint="axis", angle=angle),
        ],
        **options,
    )


def spin_up(data, length, t_end=20.0, samples=401, geometric_stiffness=True, rtol=1e-6):
    """Return times (nt,) and the tip's displacement (nt, 2), m, along and across in the frame that turns with the hub.

    A run that breaks down ends early.
    """
    body = fmb.FloatingBody("beam", data=data, geometric_stiffness=geometric_stiffness)
    model = on_hub(body, fmb.expression(DRIVE), sensors=[fmb.Position("tip", marker="beam.tip")])
    try:
        solution = fmb.simulate(model, t_end, integrator=fmb.GeneralizedAlpha(rtol=rtol), samples=samples)
    except fmb.IntegrationError as error:
        solution = error.solution
    return solution.t, in_rotating_frame(solution["tip"], angle(solution.t), length)


def in_rotating_frame(tip, angle, length):
    """Return the displacement (nt, 2) of the tip in the frame that turns with the hub: along and across."""
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * tip[:, 0] + s * tip[:, 1] - length, c * tip[:, 1] - s * tip[:, 0]])


def angular_frequencies(body, speed, **options):
    """Return the frequencies, rad/s, about the steady rotation with `speed`, rad/s."""
    model = on_hub(body, fmb.expression("speed * t", speed=float(speed)), **options)
    return 2.0 * np.pi * fmb.linearize(model, fmb.statics(model)).frequencies
