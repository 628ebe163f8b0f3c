"""Slider-crank and four-bar with Simeon's rod, reduced and as the full FE model, for comparison."""

from functools import cache
from typing import NamedTuple

import numpy as np
from verification.full_rod import FullRod
from verification.simeon_crank import CRANK, OMEGA, ROD, SIDE, SLIDER, YOUNG, slider_crank

import flexmb as fmb
from flexmb import fem, reduction

DAMPING = 2e-5
"""Stiffness-proportional, s: half critical for the rod's first axial mode, 1 % for its first bending mode."""
END, STEPS, EVERY = 0.02, 1000, 5
DENSITY = 7870.0
ELEMENTS = 8
ROCKER, PIVOT, ROCKER_INERTIA = 0.25, np.array([0.35, 0.0]), 1.5e-3


class Motion(NamedTuple):
    """Deflection of mid-rod from the chord (nt,), m; forces of the pins on the rod (nt, 2), N; stress of its upper
    fibre in the middle (nt,), Pa."""

    bow: np.ndarray
    pin_a: np.ndarray
    pin_b: np.ndarray
    stress: np.ndarray


def rod():
    """Return the FE model of the rod."""
    return fem.frame(
        np.linspace([0, 0, 0], [ROD, 0, 0], ELEMENTS + 1),
        section=fem.Section.rectangle(SIDE, SIDE),
        shear=False,
        material=fmb.Material(young=YOUNG, poisson=0.3, density=DENSITY),
    )


def crank_pin(t):
    return CRANK * np.array([np.cos(OMEGA * t), np.sin(OMEGA * t)])


def on_the_line(t):
    """Rigid place of the slider-crank's rod."""
    x = crank_pin(t)
    return x, -np.arcsin(x[1] / ROD)


def on_the_circle(t):
    """Rigid place of the four-bar's coupler: the triangle of crank pin, rocker pin and pivot."""
    x = crank_pin(t)
    to_pivot = PIVOT - x
    distance = np.linalg.norm(to_pivot)
    inner = np.arccos((ROD**2 + distance**2 - ROCKER**2) / (2 * ROD * distance))
    return x, np.arctan2(to_pivot[1], to_pivot[0]) + inner


def line(x):
    return x[1], np.array([0.0, 1.0]), np.zeros((2, 2))


def circle(x):
    arm = x - PIVOT
    return (arm @ arm - ROCKER**2) / (2 * ROCKER), arm / ROCKER, np.eye(2) / ROCKER


def bow(a, mid, b):
    """Return the distance (nt,) of the middle from the chord of the ends, positive to its left."""
    chord, arm = b - a, mid - a
    return (chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0]) / np.linalg.norm(chord, axis=1)


def middle_stress(fe, field):
    """Return the axial stress (nt,), Pa, of the upper fibre in the middle of the rod."""
    return fe.blocks[0].fibre_stress(field, (SIDE / 2, 0.0))[ELEMENTS // 2 - 1, 1]


def full(case: str) -> Motion:
    """Return the motion with all FE freedoms."""
    fe = rod()
    place, curve, mass = {
        "slider-crank": (on_the_line, line, SLIDER),
        "four-bar": (on_the_circle, circle, ROCKER_INERTIA / ROCKER**2),
    }[case]
    model = FullRod(fe, DENSITY * SIDE**2, mass, place, curve, DAMPING)
    _, u, pin_a, pin_b = model.run(END, STEPS)
    u = u[::EVERY]
    field = model.field(u.T)
    a, mid, b = (fe.nodes[n, :2] + field[n, :2].T for n in (0, ELEMENTS // 2, ELEMENTS))
    return Motion(bow(a, mid, b), pin_a[::EVERY], pin_b[::EVERY], middle_stress(fe, field))


def four_bar(body, sensors):
    """Return the four-bar: driven crank, flexible coupler, rocker."""
    x, phi = on_the_circle(0.0)
    end = x + ROD * np.array([np.cos(phi), np.sin(phi)])
    angle = np.arctan2(*(end - PIVOT)[::-1])
    crank = fmb.RigidBody("crank", mass=0.36, inertia=(1e-3, 2.727e-3, 2.727e-3), markers={"pin": (CRANK, 0, 0)})
    rocker = fmb.RigidBody(
        "rocker",
        mass=0.2,
        inertia=(1e-3, ROCKER_INERTIA, ROCKER_INERTIA),
        at=(*PIVOT, 0),
        rotation=(0, 0, angle),
        markers={"pin": (ROCKER, 0, 0)},
    )
    return fmb.Model(
        bodies=[fmb.Ground(markers={"D": (*PIVOT, 0)}), crank, body, rocker],
        joints=[
            fmb.Revolute("O", markers=("ground.origin", "crank.center")),
            fmb.Revolute("A", markers=("crank.pin", "rod.crank")),
            fmb.Spherical("B", markers=("rod.slider", "rocker.pin")),
            fmb.Revolute("D", markers=("ground.D", "rocker.center")),
            fmb.Drive("motor", joint="O", angle=fmb.expression("rate * t", rate=OMEGA)),
        ],
        sensors=sensors,
    )


@cache
def reduced(case: str, modes: int) -> Motion:
    """Return the motion with `modes` fixed-interface modes beside the constraint modes."""
    fe = rod()
    data = reduction.reduce(
        fe, {"crank": "start", "slider": "end"}, modes, stations={"mid": (ROD / 2, 0, 0)}, stress=False
    )
    place = {"slider-crank": on_the_line, "four-bar": on_the_circle}[case]
    (x0, p0), (x1, p1), (x2, p2) = (place(k * 1e-6) for k in (-1, 0, 1))
    body = fmb.FloatingBody(
        "rod",
        data=data,
        at=(*x1, 0),
        rotation=(0, 0, p1),
        velocity=(*(x2 - x0) / 2e-6, 0),
        angular_velocity=(0, 0, (p2 - p0) / 2e-6),
        damping=DAMPING * data.stiffness,
    )
    sensors = [
        fmb.Reaction("A", joint="A"),
        fmb.Reaction("B", joint="B"),
        *(fmb.Position(name, marker=f"rod.{name}") for name in ("crank", "mid", "slider")),
    ]
    model = slider_crank(body, sensors=sensors) if case == "slider-crank" else four_bar(body, sensors)
    motion = fmb.simulate(
        model, END, samples=1 + STEPS // EVERY, integrator=fmb.GeneralizedAlpha(rho_inf=0.9, step=END / STEPS)
    )
    (span, _) = motion.phases[0].system.body_slices["rod"]
    eta = motion.phases[0].q[:, span][:, 7:]
    field = np.concatenate([data.shapes, data.rotation_shapes], axis=1) @ eta.T
    return Motion(
        bow(*(motion[name][:, :2] for name in ("crank", "mid", "slider"))),
        motion["A"][:, :2],
        -motion["B"][:, :2],
        middle_stress(fe, field),
    )


def errors(found: Motion, expected: Motion) -> np.ndarray:
    """Return the largest differences relative to the largest value, (4,), once the shock of the start has decayed."""
    late = slice(len(expected.bow) // 5, None)
    return np.array([np.abs(a - b)[late].max() / np.abs(b[late]).max() for a, b in zip(found, expected)])
