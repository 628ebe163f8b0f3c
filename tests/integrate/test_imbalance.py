"""`linearize` about what is no equilibrium says so, with the body and its acceleration."""

import warnings

import numpy as np
import pytest

import flexmb as fmb

LENGTH, MASS, G = 0.8, 2.0, 9.81


def pendulum(angle, **rod):
    """Return a slender rod on a hinge about y, `angle` away from hanging."""
    direction = (np.sin(angle), 0.0, -np.cos(angle))
    pose = fmb.Pose.axes((0, 0, 0), x=direction, y=(0, 1, 0))
    body = fmb.RigidBody.rod("rod", length=LENGTH, mass=MASS, rotation=pose.rotation, **rod)
    hinge = fmb.Pose.axes((0, 0, 0), z=(0, 1, 0))
    body = body.replaced(markers={**body.markers, "hinge": fmb.Pose.axes((0, 0, 0), x=(1, 0, 0), z=(0, 1, 0))})
    return fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(markers={"hinge": hinge}), body],
        joints=[fmb.Revolute("A", markers=("ground.hinge", "rod.hinge"))],
    )


def test_a_rod_held_aside_is_told():
    """3 g / (2 L) sin(angle) about the hinge; root mean square over the rod: L / sqrt(3) of it."""
    expected = 1.5 * G / LENGTH * np.sin(1.0) * LENGTH / np.sqrt(3.0)
    with pytest.warns(fmb.ValidityWarning, match=rf"Body 'rod' accelerates with {expected:.3g} m/s2.*statics"):
        fmb.linearize(pendulum(1.0))


def steady(model, about=None):
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.ValidityWarning)
        return fmb.linearize(model, about)


def test_equilibria_and_steady_motions_are_not():
    """Hanging; found by statics; a sleeping top and one that precesses; a spinning body that flies or falls."""
    rate = np.sqrt(1.5 * G / LENGTH) / (2.0 * np.pi)
    np.testing.assert_allclose(steady(pendulum(0.0)).frequencies, [rate], rtol=1e-9)
    model = pendulum(0.3)
    np.testing.assert_allclose(steady(model, fmb.statics(model)).frequencies, [rate], rtol=1e-6)
    for tilt in (0.0, 0.5):  # upright, and with the slow regular precession of a heavy top
        steady(top(tilt))
    flying = fmb.RigidBody("disc", mass=1.0, inertia=(1, 1, 2), angular_velocity=(0, 0, 30), velocity=(1, 2, 0))
    for gravity in ((0, 0, 0), (0, 0, -G)):
        steady(fmb.Model(bodies=[fmb.Ground(), flying], gravity=gravity))


def top(tilt, spin=200.0):
    """Return a symmetric top (A, A, C) on its tip, precessing regularly: C s O - A O2 cos(tilt) = m g l at spin s."""
    A, C, m, length = 0.03, 0.01, 1.0, 0.1
    total = A + m * length**2
    roots = np.roots([(C - total) * np.cos(tilt), C * spin, -m * G * length])
    O = float(np.min(np.abs(roots)))
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    w = spin * axis + (O * np.array([0, 0, 1.0]) if tilt else 0.0)
    at = length * axis
    body = fmb.RigidBody(
        "top",
        mass=m,
        inertia=(A, A, C),
        at=tuple(at),
        rotation=(0, tilt, 0),
        velocity=tuple(np.cross(w, at)),
        angular_velocity=tuple(w),
        markers={"tip": (0, 0, -length)},
    )
    return fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(), body],
        joints=[fmb.Spherical("S", markers=("ground.origin", "top.tip"))],
    )


def test_outputs_of_an_equilibrium_leave_out_a_drive_that_is_about_to_start():
    """A bob (m, I) hangs l below a carriage that begins to rise with 8 m/s2: w2 = m g l / (I + m l2), and the bob's
    acceleration follows a push by l2 s2 / (I + m l2) / (s2 + w2); neither knows the 8 m/s2.
    """
    m, inertia, length = 2.0, 0.1, 0.5
    pin = {"x": (1, 0, 0), "z": (0, 1, 0)}
    carriage = fmb.RigidBody("carriage", mass=1.0, inertia=(1, 1, 1), markers={"pin": fmb.Pose.axes((0, 0, 0), **pin)})
    bob = fmb.RigidBody(
        "bob",
        mass=m,
        inertia=(inertia,) * 3,
        at=(0, 0, -length),
        markers={"pin": fmb.Pose.axes((0, 0, length), **pin)},
    )
    guide = fmb.Prismatic("guide", markers=("ground.origin", "carriage.center"))
    hinge = fmb.Revolute("hinge", markers=("carriage.pin", "bob.pin"))
    lift = fmb.Drive("lift", joint="guide", displacement=fmb.expression("4*t**2"))
    model = fmb.Model(
        gravity=(0, 0, -G),
        bodies=[fmb.Ground(), carriage, bob],
        joints=[guide, hinge, lift],
        forces=[fmb.PointLoad("push", marker="bob.center", force=(0, 0, 0))],
        sensors=[fmb.Acceleration("acceleration", marker="bob.center")],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.ValidityWarning)
        plant = fmb.linearize(model, fmb.statics(model), inputs=["push.force.x"], outputs=["acceleration ax"])
    total = inertia + m * length**2
    w2 = m * G * length / total
    np.testing.assert_allclose(np.sort(plant.poles.imag), [-np.sqrt(w2), np.sqrt(w2)], rtol=1e-9)
    frequency = 0.3
    s2 = -((2.0 * np.pi * frequency) ** 2)
    expected = length**2 / total * s2 / (s2 + w2)
    np.testing.assert_allclose(plant.frequency_response([frequency])[0, 0, 0], expected, rtol=1e-6)


def test_what_falls_on_a_rope_is_not_steady():
    """A point on a rod that lies level has the acceleration of a free fall at that instant, but no steady motion."""
    bob = fmb.PointMass("bob", mass=1.0, at=(2, 0, 0))
    rope = fmb.Rod("rope", markers=("ground.origin", "bob.center"))
    with pytest.warns(fmb.ValidityWarning, match=r"Body 'bob' accelerates with 9.81 m/s2"):
        fmb.linearize(fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), bob], joints=[rope]))


def test_two_points_on_a_spring_may_fall_together():
    points = [fmb.PointMass(name, mass=1.0, at=(x, 0, 0)) for name, x in (("a", 0.0), ("b", 1.0))]
    spring = fmb.SpringDamper("spring", markers=("a.center", "b.center"), stiffness=8.0, length=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        linear = fmb.linearize(fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), *points], forces=[spring]))
    assert 2.0 * np.pi * linear.frequencies.max() == pytest.approx(4.0, rel=1e-9)
