"""Gears: contact ratio, directions of forces, mesh stiffness, tangents, energy, an independent integration."""

from functools import cache

import numpy as np
import pytest
from contracts.random_models import random_state
from contracts.test_tangents import assert_tangent
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.system import compile
from flexmb.system.program import evaluate

M, Z, WIDTH, ALPHA = 0.002, (20, 40), 0.02, np.radians(20.0)
FORWARD, BACK = 1.0, -1.0


def inv(angle):
    return np.tan(angle) - angle


def wheels(distance=None, inside=False, free=False, **fields):
    """Return two gears, the second at `distance` along x."""
    z1, z2 = fields.get("teeth", Z)
    beta = fields.get("helix", 0.0)
    if distance is None:
        distance = 0.5 * M / np.cos(beta) * abs(z1 + (-z2 if inside else z2))
    held = fmb.Gears(
        "mesh", markers=("a.center", "b.center"), **{"module": M, "teeth": Z, "width": WIDTH, **fields}, inside=inside
    )
    inertia = (1e-4, 1e-4, 2e-4)
    bodies = [
        fmb.Ground(markers={"a": (0, 0, 0), "b": (distance, 0, 0)}),
        fmb.RigidBody("a", mass=0.5, inertia=inertia),
        fmb.RigidBody("b", mass=1.0, inertia=inertia, at=(distance, 0, 0)),
    ]
    joints = [fmb.Revolute(n, markers=(f"ground.{n}", f"{n}.center")) for n in "ab"] if free else []
    return fmb.Model(bodies=bodies, joints=joints, forces=[held])


@cache
def compiled(**fields):
    return compile(wheels(**fields))


def wrench(turns, move=(0, 0, 0), tilt=(0, 0, 0), **fields):
    """Return the wrench on b (6,), the potential energy and the wrench on a, with wheels turned and b moved."""
    system = compiled(**fields)
    state = system.state()
    q = state.q.copy()
    ia, ib = (system.body_slices[n][0].start for n in "ab")
    q[ib : ib + 3] += move
    for i, rotation in (
        (ia, Rotation.from_rotvec((0, 0, turns[0]))),
        (ib, Rotation.from_rotvec(tilt) * Rotation.from_rotvec((0, 0, turns[1]))),
    ):
        x, y, z, w = rotation.as_quat()
        q[i + 3 : i + 7] = w, x, y, z
    work = system.workspace()
    evaluate(system.program, state._replace(q=q), work)
    k = system.marker_index["b.center"]
    return (
        work.markers[k]["wrench"].copy(),
        float(work.energy[0].potential),
        work.markers[system.marker_index["a.center"]]["wrench"].copy(),
    )


def paths(z1, z2, alpha, addendum=1.0):
    """Return the path of contact and its length over the base pitch by the textbook, without shifts, module M."""
    r1, r2 = 0.5 * M * z1, 0.5 * M * z2
    b1, b2 = r1 * np.cos(ALPHA), r2 * np.cos(ALPHA)
    last = ((r1 + addendum * M) ** 2 - b1**2) ** 0.5
    first = (b1 + b2) * np.tan(alpha) - ((r2 + addendum * M) ** 2 - b2**2) ** 0.5
    return first, last, (last - first) / (np.pi * M * np.cos(ALPHA))


def test_contact_ratio_and_play():
    """20 and 40 teeth of 20 degrees: eps = 1.635 (Dudley). A distance larger by j / (2 tan alpha) has the play j."""
    gears = wheels().forces[0]
    geometry = gears.geometry(0.06)
    assert geometry.contact_ratio == pytest.approx(paths(*Z, ALPHA)[2], rel=1e-12)
    assert geometry.contact_ratio == pytest.approx(1.635, abs=1e-3)
    assert geometry.play == pytest.approx(0.0, abs=1e-15)
    assert gears.geometry(0.06 + 1e-6).play == pytest.approx(2e-6 * np.sin(ALPHA), rel=1e-3)
    shifted = gears.replaced(shifts=(0.4, 0.2))
    working = shifted.geometry(0.0612).tight_distance  # inv alpha_w = inv alpha + 2 (x1 + x2) / (z1 + z2) tan alpha
    angle = np.arccos(0.06 * np.cos(ALPHA) / working)
    assert inv(angle) == pytest.approx(inv(ALPHA) + 2.0 * 0.6 / 60.0 * np.tan(ALPHA), rel=1e-9)
    thinner = gears.replaced(backlash=1e-4)
    assert thinner.geometry(0.06).play == pytest.approx(1e-4 * np.cos(ALPHA), rel=1e-9)


@pytest.mark.parametrize("inside", [False, True], ids=["outer", "ring"])
@pytest.mark.parametrize("sense", [FORWARD, BACK])
def test_directions_and_transmission(inside, sense):
    """Torques are as the teeth, the radial force is tan(alpha) of the tangential one, at whatever angle they mesh."""
    z2 = -40 if inside else 40
    r1, r2 = 0.5 * M * 20, 0.5 * M * z2
    for angle in (0.0, 0.13, 2.9, 40.0):
        press = sense * 1e-6 / r1  # of gear a, held by b
        turns = angle + press, -angle * 20 / z2
        on_b, _, on_a = wrench(turns, inside=inside)
        force, torque = on_b[:3], on_b[5]
        assert on_a[5] * r2 == pytest.approx(torque * r1, rel=2e-3)
        assert sense * force[1] * (-1 if inside else 1) > 0.0  # the teeth of a ring are on the other side of a
        assert abs(force[0] / force[1]) == pytest.approx(np.tan(ALPHA), rel=3e-3)
        assert (force[0] < 0.0) == inside  # wheels are pressed apart, a ring over its wheel
        assert torque == pytest.approx(-force[1] * abs(r2), rel=2e-3)
        # turned on by a whole pitch nothing changes
        pitch = 2 * np.pi / 20
        onwards = turns[0] + pitch, turns[1] - pitch * 20 / z2
        np.testing.assert_allclose(wrench(onwards, inside=inside)[0], on_b, rtol=1e-7, atol=1e-7)


def test_no_force_within_the_backlash():
    play = 1e-4
    for part, touches in ((0.49, False), (0.51, True), (-0.49, False), (-0.51, True)):
        angle = 0.7 + part * play / (0.5 * M * 20)
        on_b, *_ = wrench((angle, -0.7 / 2.0), backlash=play)
        assert (np.abs(on_b).max() > 0.0) == touches


def test_mesh_stiffness_over_a_pitch():
    """c' by hand: q' = 0.04723 + 0.15551/20 + 0.25791/40 = 0.06145 mm um/N, c' = 0.8/q' = 13.018 N/(mm um) with a
    dedendum of 1.2; the mean over a pitch is c' (0.75 eps + 0.25), ISO 6336-1, eq. 89.
    """
    gears = wheels(dedendum=1.2).forces[0]
    c = gears.single_stiffness(0.06)
    assert c == pytest.approx(13.018e9, rel=1e-4)
    overlap, base = 1e-7, 0.5 * M * 20 * np.cos(ALPHA)
    forces = []
    for k in range(200):
        angle = k / 200 * 2 * np.pi / 20
        on_b, *_ = wrench((angle + overlap / base, -angle / 2.0), dedendum=1.2)
        forces.append(np.hypot(on_b[0], on_b[1]))
    mean = np.mean(forces) / overlap / WIDTH
    eps = paths(*Z, ALPHA)[2]
    assert mean == pytest.approx(c * (0.75 * eps + 0.25), rel=2e-3)
    # one pair in the middle, two at the ends
    assert np.max(forces) / np.min(forces) == pytest.approx(2.0, rel=0.15)


def test_transmission_error_under_load():
    """How far b lags under a torque on a, against a sum over the teeth written for the test."""
    first, last, eps = paths(*Z, ALPHA)
    base, pitch, torque = 0.5 * M * 20 * np.cos(ALPHA), np.pi * M * np.cos(ALPHA), 20.0
    c = wheels().forces[0].single_stiffness(0.06)
    half_tooth = 0.25 * np.pi * M / (0.5 * M * 20) + inv(ALPHA)
    errors = []
    for angle in np.linspace(0.0, 2 * np.pi / 20, 15):
        low, high = 0.0, 1e-4
        for _ in range(40):
            press = 0.5 * (low + high)
            on_a = wrench((angle + press / base, -angle / 2.0))[2]
            low, high = (press, high) if abs(on_a[5]) < torque else (low, press)
        errors.append(press)
        # gear a presses forwards: the flank whose string unwinds against its turn
        place = base * (ALPHA + half_tooth) + base * (angle + press / base)
        s = (place - first) % pitch + first + np.array([-pitch, 0.0, pitch])
        xi = (s - 0.5 * (first + last)) / (0.5 * (last - first))
        near = np.minimum(np.abs(s - first), np.abs(s - last)).min() < 0.05 * pitch
        sum_c = c * np.sum(np.where(np.abs(xi) <= 1, 1 - 0.75 * (1 - 1 / eps) * xi**2, 0.0))
        if not near:  # where no pair is about to come or to go
            assert press == pytest.approx(torque / base / WIDTH / sum_c, rel=3e-3)
    assert np.ptp(errors) > 0.2 * np.mean(errors)


def test_a_helix_pushes_along_the_axis():
    """F_a = F_t tan(beta); the hand of the helix and the flank decide the sense."""
    beta = np.radians(15.0)
    r1 = 0.5 * M / np.cos(beta) * 20
    for hand in (1.0, -1.0):
        for sense in (1.0, -1.0):
            on_b, *_ = wrench((0.3 + sense * 1e-6 / r1, -0.15), helix=hand * beta, slices=21)
            assert abs(on_b[2] / on_b[1]) == pytest.approx(np.tan(beta), rel=5e-3)
            # the normal of a right-handed driver's tooth points to smaller z where it pushes forwards
            assert np.sign(on_b[2]) == -hand * sense
            alpha_t = np.arctan(np.tan(ALPHA) / np.cos(beta))
            assert on_b[0] / abs(on_b[1]) == pytest.approx(np.tan(alpha_t), rel=5e-3)


def test_a_tilt_moves_the_load_to_one_end():
    """About the line of action's direction no change; in its plane the ends differ by tilt times width."""
    press, tilt = 2e-6, 1e-4
    straight, *_ = wrench((press / 0.02, 0.0), slices=41)
    tilted, *_ = wrench((press / 0.02, 0.0), tilt=(tilt, 0, 0), slices=41)
    # overlap grows by tilt z cos(alpha) along the width: moment = c b^3/12 tilt cos(alpha)^2 where all slices touch
    stiffness = straight[1] / np.cos(ALPHA) / (press * np.cos(ALPHA)) / WIDTH
    moment = stiffness * WIDTH**3 / 12.0 * tilt * np.cos(ALPHA) ** 2
    assert abs(tilted[3] - straight[3]) == pytest.approx(moment, rel=0.02)


@pytest.mark.parametrize("inside", [False, True], ids=["outer", "ring"])
def test_tangents(inside, rng):
    """Against differences, tilted and displaced, with a helix, on every side and where pairs come and go."""
    fields = {
        "module": 0.4,
        "width": 2.0,
        "helix": 0.2,
        "slices": 3,
        "stiffness": 300.0,
        "damping": 0.1,
        "inside": inside,
    }
    z1, z2 = 20, (-40 if inside else 40)
    distance = abs(0.5 * 0.4 / np.cos(0.2) * (z1 + z2))
    for turn in (0.05, -0.05):
        bodies = [
            fmb.Ground(),
            fmb.RigidBody("a", mass=1.0, inertia=(1, 1, 1), rotation=(0.1, 0.2, 0.3)),
            fmb.RigidBody(
                "b",
                mass=1.0,
                inertia=(1, 1, 1),
                at=Rotation.from_rotvec((0.1, 0.2, 0.3)).apply((distance, 0, 0)),
                rotation=(0.1, 0.2, 0.3),
                velocity=rng.normal(size=3),
                angular_velocity=rng.normal(size=3),
            ),
        ]
        model = fmb.Model(
            bodies=bodies, forces=[fmb.Gears("mesh", markers=("a.center", "b.center"), teeth=(20, 40), **fields)]
        )
        system, state = random_state(model, rng)
        q = state.q.copy()
        i = system.body_slices["b"][0].start
        frame = Rotation.from_rotvec((0.1, 0.2, 0.3))
        x, y, z, w = (frame * Rotation.from_rotvec((0.01, -0.02, turn / 4.0))).as_quat()
        q[i : i + 3] += (0.01, 0.02, 0.03)
        q[i + 3 : i + 7] = w, x, y, z
        state = state._replace(q=q)
        work = system.workspace()
        evaluate(system.program, state, work)
        assert np.abs(work.markers["wrench"]).max() > 1.0
        assert_tangent(system, state, blocks=("D",))
        assert_tangent(system, state._replace(u=np.zeros(system.nu)))


def rattle(t_end, **settings):
    model = wheels(free=True, backlash=4e-5)
    spinning = [b.replaced(angular_velocity=(0, 0, w)) for b, w in zip(model.bodies[1:], (30.0, 5.0))]
    model = fmb.Model(
        bodies=[model.bodies[0], *spinning],
        joints=model.joints,
        forces=model.forces,
        sensors=[
            fmb.JointCoordinate("phi a", joint="a"),
            fmb.JointCoordinate("phi b", joint="b"),
            fmb.Energy("energy"),
        ],
    )
    return fmb.simulate(model, t_end=t_end, samples=41, **settings)


def test_rattling_against_an_independent_integration():
    """Two wheels strike with both flanks in turn; energy stays, and SciPy on two angles finds the same motion."""
    t_end = 0.002
    found = rattle(t_end, integrator=fmb.GeneralizedAlpha(rtol=1e-8, rho_inf=0.95))
    first, last, eps = paths(*Z, ALPHA)
    b1, b2, pitch = 0.02 * np.cos(ALPHA), 0.04 * np.cos(ALPHA), np.pi * M * np.cos(ALPHA)
    c, fall, ramp, play = (
        wheels().forces[0].single_stiffness(0.06),
        0.75 * (1 - 1 / eps),
        0.05 * pitch,
        4e-5 * np.cos(ALPHA),
    )
    half = (0.25 * np.pi * M - 1e-5) / 0.02 + inv(ALPHA)

    def stiffness(place):
        total = 0.0
        for s in place - pitch * np.floor((place - first + ramp / 2) / pitch) + pitch * np.arange(3):
            t = np.clip([(s - first) / ramp + 0.5, (last - s) / ramp + 0.5], 0, 1)
            xi = (2 * s - first - last) / (last - first)
            total += c * (1 - fall * xi**2) * np.prod(t**3 * (10 + t * (6 * t - 15)))
        return total

    def potential(x, y):
        total = 0.0
        for sigma in (1.0, -1.0):
            # seen from the axes of a the line of centres turns by -x
            overlap = sigma * (-(b1 + b2) * x - b2 * (y - x)) - 0.5 * play
            if overlap > 0.0:
                total += 0.5 * WIDTH * stiffness(b1 * (-sigma * x + ALPHA + half)) * overlap**2
        return total

    def rates(_, x):
        h = 1e-9
        force = [
            -(potential(x[0] + h, x[1]) - potential(x[0] - h, x[1])) / (2 * h),
            -(potential(x[0], x[1] + h) - potential(x[0], x[1] - h)) / (2 * h),
        ]
        return [x[2], x[3], force[0] / 2e-4, force[1] / 2e-4]

    there = solve_ivp(rates, (0, t_end), [0, 0, 30.0, 5.0], t_eval=found.t, rtol=1e-9, atol=1e-12, max_step=1e-5)
    np.testing.assert_allclose(found["phi a"], there.y[0], atol=3e-6)
    np.testing.assert_allclose(found["phi b"], there.y[1], atol=3e-6)
    np.testing.assert_allclose(found["energy"], found["energy"][0], rtol=1e-4)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"teeth": (20.5, 40)}, "two whole numbers"),
        ({"teeth": (3, 40)}, "two whole numbers"),
        ({"teeth": (40, 20), "inside": True}, "a ring with more teeth"),
        ({"pressure_angle": 20.0}, "in radians"),
        ({"helix": 15.0}, "in radians"),
        ({"shifts": 0.3}, "two numbers"),
        ({"slices": 0}, "from 1 to 200"),
        ({"module": -1.0}, "module = -1.0"),
        ({"backlash": -1e-5}, "backlash = -1e-05"),
        ({"stiffness": 0.0}, "stiffness = 0.0"),
    ],
)
def test_bad_input_is_refused_by_name(fields, words):
    with pytest.raises(ModelError, match=words):
        fmb.Gears("mesh", markers=("a.m", "b.m"), **{"module": M, "teeth": Z, "width": WIDTH, **fields})


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"distance": 0.0599}, "0.06 m, where they have no play"),
        ({"distance": 0.0}, "where the teeth overlap"),
        ({"distance": 0.0645}, "contact ratio"),
        ({"shifts": (0.0, 0.4), "distance": 0.0615}, "range of ISO 6336-1"),
        ({"teeth": (6, 60)}, "above its base circle"),
    ],
)
def test_pairs_that_do_not_fit_are_refused_by_name(fields, words):
    with pytest.raises(ModelError, match=words):
        compile(wheels(**fields))
