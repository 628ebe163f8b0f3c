"""Joints with clearance: a ball in a socket, a journal in a bore, a slider-crank with play, and the limit of none."""

import numpy as np
import pytest
from contracts.random_models import random_state
from contracts.test_tangents import assert_tangent
from scipy.integrate import solve_ivp

import flexmb as fmb
from flexmb.errors import ModelError

CRANK, ROD, SPEED = 0.153, 0.306, 150.0
"""m, m, rad/s: of the slider-crank of Flores, Leine & Glocker (Multibody System Dynamics 23 (2010) 165-190); masses and
inertias below too. There the guide has the clearance, here the pin of the slider."""
ROD_MASS, ROD_INERTIA, SLIDER = 0.038, 5.9e-4, 0.076
RADIUS, STIFF, DAMPING, FRICTION, TRANSITION = 0.01, 1e8, 0.3, 0.05, 0.05


def slider_crank(clearance, stiffness=STIFF, damping=DAMPING, friction=FRICTION):
    """Return the model, which begins stretched with the journal in the middle of the bore."""
    up = {"markers": {"in": (-ROD / 2, 0, 0), "out": (ROD / 2, 0, 0)}}
    start = -SPEED * CRANK / ROD  # rad/s, of the rod
    guide = fmb.Pose.axes(z=(1, 0, 0), x=(0, 1, 0))
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"axis": (0, 0, 0), "guide": guide}),
            fmb.RigidBody(
                "crank",
                mass=0.038,
                inertia=(1e-6, 7.4e-5, 7.4e-5),
                at=(CRANK / 2, 0, 0),
                velocity=(0, SPEED * CRANK / 2, 0),
                angular_velocity=(0, 0, SPEED),
                markers={"axis": (-CRANK / 2, 0, 0), "pin": (CRANK / 2, 0, 0)},
            ),
            fmb.RigidBody(
                "rod",
                mass=ROD_MASS,
                inertia=(1e-6, ROD_INERTIA, ROD_INERTIA),
                at=(CRANK + ROD / 2, 0, 0),
                velocity=(0, SPEED * CRANK / 2, 0),
                angular_velocity=(0, 0, start),
                **up,
            ),
            fmb.RigidBody(
                "slider",
                mass=SLIDER,
                inertia=(1e-5, 1e-5, 1e-5),
                at=(CRANK + ROD, 0, 0),
                markers={"guide": fmb.Pose.axes(z=(1, 0, 0), x=(0, 1, 0)), "pin": (0, 0, 0)},
            ),
        ],
        joints=[
            fmb.Revolute("axis", markers=("ground.axis", "crank.axis")),
            fmb.Revolute("pin", markers=("crank.pin", "rod.in")),
            fmb.Prismatic("guide", markers=("ground.guide", "slider.guide")),
            fmb.Drive("motor", joint="axis", angle=fmb.expression("w*t", w=SPEED)),
        ],
        forces=[
            fmb.Contact(
                "journal",
                markers=("slider.pin", "rod.out"),
                against="bore",
                radius=RADIUS,
                other_radius=RADIUS + clearance,
                stiffness=stiffness,
                damping=damping,
                friction=friction,
                transition=TRANSITION,
            )
        ],
        sensors=[fmb.Position("slider", marker="slider.pin"), fmb.ForceOf("force", force="journal")],
    )


def independent(clearance, t):
    """Return the place of the slider by SciPy: the angle of the rod and the place of the slider are the unknowns."""

    def rates(time, x):
        phi, slider, phi_dot, slider_dot = x
        theta = SPEED * time
        e, along = np.array([np.cos(phi), np.sin(phi)]), np.array([-np.sin(phi), np.cos(phi)])
        pin = CRANK * np.array([np.cos(theta), np.sin(theta)])
        pin_dot = CRANK * SPEED * np.array([-np.sin(theta), np.cos(theta)])
        d = pin + ROD * e - (slider, 0.0)
        d_dot = pin_dot + ROD * phi_dot * along - (slider_dot, 0.0)
        far, force, torque = np.hypot(*d), np.zeros(2), 0.0
        if far > clearance:
            n = -d / far
            t_dir = np.array([-n[1], n[0]])
            normal = STIFF * (far - clearance) ** 1.5 * max(0.0, 1.0 - DAMPING * (n @ d_dot))
            slip = t_dir @ d_dot - RADIUS * phi_dot
            drag = -FRICTION * normal * slip / np.hypot(slip, TRANSITION)
            force, torque = normal * n + drag * t_dir, -RADIUS * drag
        inertia = ROD_INERTIA + ROD_MASS * ROD**2 / 4.0
        turning = ROD * (along @ force) + torque + ROD_MASS * ROD / 2.0 * SPEED**2 * (along @ pin)
        return [phi_dot, slider_dot, turning / inertia, -force[0] / SLIDER]

    start = [0.0, CRANK + ROD, -SPEED * CRANK / ROD, 0.0]
    found = solve_ivp(rates, (0, t[-1]), start, t_eval=t, method="DOP853", rtol=1e-9, atol=1e-12, max_step=4e-5)
    return found.y[1]


def test_a_slider_crank_with_clearance():
    """Half a turn with a clearance of 1 mm against an independent integration of two coordinates."""
    model = slider_crank(1e-3)
    fine = fmb.GeneralizedAlpha(rtol=1e-8, rho_inf=0.95)
    found = fmb.simulate(model, t_end=np.pi / SPEED, samples=41, integrator=fine)
    force = np.linalg.norm(found["force"][:, :3], axis=1)
    assert force.max() > 100.0
    np.testing.assert_allclose(found["slider"][:, 0], independent(1e-3, found.t), atol=2e-6)


def test_without_clearance_it_is_the_ideal_joint():
    """As clearance falls and stiffness grows the slider follows r cos + sqrt(l^2 - r^2 sin^2)."""
    worst = []
    for clearance, stiffness in ((1e-3, 1e8), (1e-4, 1e10), (1e-5, 1e12)):
        model = slider_crank(clearance, stiffness, damping=20.0, friction=0.0)
        found = fmb.simulate(model, t_end=np.pi / SPEED, samples=61)
        angle = SPEED * found.t
        ideal = CRANK * np.cos(angle) + (ROD**2 - CRANK**2 * np.sin(angle) ** 2) ** 0.5
        worst.append(np.abs(found["slider"][:, 0] - ideal).max())
        force = np.linalg.norm(found["force"][:, :3], axis=1).max()
        # the rod is tilted by 30 degrees at most: the play along the guide is larger by its cosine
        assert worst[-1] < 1.16 * (clearance + (force / stiffness) ** (2.0 / 3.0))
    assert worst[2] < 0.2 * worst[1]
    assert worst[1] < 0.2 * worst[0]


def hanging(against, at, **fields):
    """Return a ball of 2 kg that hangs in a socket or a bore whose axis lies along y."""
    return fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers={"seat": fmb.Pose.axes(z=(0, 1, 0), x=(1, 0, 0))}),
            fmb.RigidBody("ball", mass=2.0, inertia=(1e-3, 1e-3, 1e-3), at=at),
        ],
        forces=[
            fmb.Contact(
                "c", markers=("ground.seat", "ball.center"), against=against, radius=0.02, stiffness=1e6, **fields
            )
        ],
        sensors=[fmb.Position("place", marker="ball.center"), fmb.ForceOf("force", force="c"), fmb.Energy("energy")],
    )


@pytest.mark.parametrize("against", ["socket", "bore"])
def test_at_rest_at_the_bottom(against):
    """Depth = clearance + (m g / k)^(2/3)."""
    deep = 0.001 + (2.0 * 9.81 / 1e6) ** (2.0 / 3.0)
    found = fmb.simulate(hanging(against, (0, 0, -deep), other_radius=0.021), t_end=0.05, samples=6)
    np.testing.assert_allclose(found["place"], [(0, 0, -deep)] * 6, atol=1e-9)
    np.testing.assert_allclose(found["force"][:, 2], 2.0 * 9.81, rtol=1e-5)


def test_swinging_in_a_socket_like_a_pendulum():
    """Without friction a ball slides in a hollow as a pendulum of the length of the clearance; energy stays."""
    clearance, start = 0.2, 0.4
    place = clearance * np.array([np.sin(start), 0.0, -np.cos(start)])
    model = hanging("socket", tuple(place), other_radius=0.22).changed("c", stiffness=1e9)
    found = fmb.simulate(model, t_end=1.0, samples=101, integrator=fmb.Explicit(rtol=1e-9))
    angle = np.arctan2(found["place"][:, 0], -found["place"][:, 2])
    there = solve_ivp(
        lambda _, x: [x[1], -9.81 / clearance * np.sin(x[0])],
        (0, 1),
        [start, 0],
        t_eval=found.t,
        rtol=1e-10,
        atol=1e-12,
    )
    np.testing.assert_allclose(angle, there.y[0], atol=2e-3)  # it lies 0.1 mm deeper
    np.testing.assert_allclose(found["energy"], found["energy"][0], atol=1e-7)


@pytest.mark.parametrize("against", ["socket", "bore"])
def test_tangents(against, rng):
    """Against differences, off the middle, with damping and friction."""
    for _ in range(3):
        bodies = [
            fmb.Ground(),
            fmb.RigidBody("a", mass=1.0, inertia=(1, 1, 1), rotation=rng.normal(size=3)),
            fmb.RigidBody(
                "b",
                mass=1.0,
                inertia=(1, 1, 1),
                at=rng.normal(size=3),
                velocity=rng.normal(size=3),
                angular_velocity=rng.normal(size=3),
            ),
        ]
        law = {"stiffness": 30.0, "damping": 0.05, "friction": 0.3, "transition": 3.0}
        contact = fmb.Contact(
            "c", markers=("a.center", "b.center"), against=against, radius=0.1, other_radius=0.101, **law
        )
        system, state = random_state(fmb.Model(bodies=bodies, forces=[contact]), rng)
        assert_tangent(system, state, blocks=("D",))
        assert_tangent(system, state._replace(u=np.zeros(system.nu)))


def test_bad_input_is_refused_by_name():
    known = {"markers": ("ground.A", "b.A"), "radius": 0.1, "stiffness": 1e6}
    with pytest.raises(ModelError, match="the difference is the clearance"):
        fmb.Contact("c", against="socket", other_radius=0.1, **known)
    with pytest.raises(ModelError, match="for all but a plane"):
        fmb.Contact("c", against="bore", **known)
    with pytest.raises(ModelError, match="fit without clearance"):
        fmb.Contact.hertz_stiffness(0.1, fmb.MATERIALS["steel"], -0.1)
