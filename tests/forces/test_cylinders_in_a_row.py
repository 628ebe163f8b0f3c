"""Ways over cylinders that follow each other: against closed forms of belts, and stationary ways by a search."""

import numpy as np
import pytest
from by_turns import slow
from contracts.test_tangents import assert_tangent
from forces.described_markers import Described
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import flexmb as fmb
from flexmb.errors import ModelError
from flexmb.forces.path_fields import described_length
from flexmb.io.scene import Scene
from flexmb.system import compile
from flexmb.system.program import evaluate


def over(P, S, cylinders, **more) -> fmb.Model:
    """Return a muscle from the ground over cylinders (place, rotation, radius), each a body, to a last body."""
    given = {"tendon": 0.5, "fibre": 1.0, "tendon_strain": 0.5, "strength": 40.0, "excitation": 0.6} | more
    around = [
        fmb.RigidBody(f"c{k}", mass=1.0, inertia=(1, 1, 1), at=at, markers={"z": fmb.Pose((0, 0, 0), turned)})
        for k, (at, turned, _) in enumerate(cylinders)
    ]
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={"o": P}),
            *around,
            fmb.RigidBody("s", mass=1.0, inertia=(1, 1, 1), at=S, markers={"m": (0, 0, 0)}),
        ],
        forces=[
            fmb.Muscle(
                "m",
                through=("ground.o", *(f"{body.name}.z" for body in around), "s.m"),
                radii=(0, *(radius for *_, radius in cylinders), 0),
                **given,
            )
        ],
    )


def length_of(model) -> float:
    return described_length(model.forces[0], Described(model))


def slopes(f, y):
    """Return the gradient by central differences of fourth order."""
    e = 1e-3 * np.eye(len(y))
    return np.array([(8 * (f(y + d) - f(y - d)) - (f(y + 2 * d) - f(y - 2 * d))) / 12e-3 for d in e])


def stationary(P, S, cylinders, angles):
    """Return the stationary length of lines and helices from P to S, by a search that begins with contact angles."""

    def whole(y):
        total, last = 0.0, np.array(P)
        for (at, turned, radius), (a, b, h, k) in zip(cylinders, y.reshape(-1, 4)):
            R, r = Rotation.from_rotvec(turned).as_matrix(), abs(radius)
            one, two = (at + R @ (r * np.cos(x), r * np.sin(x), z) for x, z in ((a, h), (b, k)))
            total += np.linalg.norm(one - last) + np.hypot(r * (b - a), k - h)
            last = two
        return total + np.linalg.norm(S - last)

    start = np.column_stack([angles, np.zeros((len(angles), 2))]).ravel()
    y = least_squares(lambda y: slopes(whole, y), start, xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    assert np.abs(slopes(whole, y)).max() < 1e-8
    return whole(y)


SKEW = {
    "two": (
        (-1.0, -0.3, 0.1),
        (2.5, -0.4, 0.3),
        [((0.0, 0, 0), (0.1, 0.2, 0.0), -0.3), ((1.5, 0.2, 0.1), (-0.2, 0.3, 0.4), -0.25)],
        [(2.2, 1.4), (1.7, 0.9)],
    ),
    "there and back": (
        (-1.0, -0.3, 0.1),
        (2.5, 0.9, 0.3),
        [((0.0, 0, 0), (0.1, 0.2, 0.0), -0.3), ((1.5, 0.2, 0.1), (-0.2, 0.3, 0.4), 0.25)],
        [(2.2, 0.8), (-2.6, -1.3)],
    ),
    "three": (
        (-1.0, -0.3, 0.1),
        (3.5, -0.9, 0.3),
        [
            ((0.0, 0, 0), (0.3, 0.2, 0.0), -0.3),
            ((1.2, 0.3, 0.1), (-0.4, 0.3, 0.4), -0.25),
            ((2.4, 0.2, 0.1), (0.5, -0.3, 0.1), -0.35),
        ],
        [(2.2, 1.7), (1.7, 1.2), (1.6, 0.9)],
    ),
}
MORE = {
    "the first alone": ((-1.0, -0.3, 0.1), (2.5, 1.2, 0.3), SKEW["two"][2]),
    "the last alone": ((-1.0, 1.5, 0.1), (2.5, -0.9, 0.3), SKEW["two"][2]),
    "none": ((-1.0, 0.9, 0.1), (2.5, 0.9, 0.3), SKEW["two"][2]),
}


@pytest.mark.parametrize("name", [slow(name) if name == "three" else name for name in SKEW])
def test_the_way_is_stationary(name):
    P, S, cylinders, angles = SKEW[name]
    assert length_of(over(P, S, cylinders)) == pytest.approx(stationary(P, S, cylinders, angles), rel=1e-9)


def test_what_does_not_touch_does_not_count():
    """Beside one cylinder the way is that over the other alone; beside both it is straight."""
    for name, k in (("the first alone", 0), ("the last alone", 1)):
        P, S, cylinders = MORE[name]
        alone = length_of(over(P, S, [cylinders[k]]))
        assert length_of(over(P, S, cylinders)) == pytest.approx(alone, rel=1e-12)
        assert alone > np.linalg.norm(np.subtract(S, P)) * 1.001
    P, S, cylinders = MORE["none"]
    assert length_of(over(P, S, cylinders)) == pytest.approx(np.linalg.norm(np.subtract(S, P)), rel=1e-12)


@pytest.mark.parametrize(("R", "r", "crossed"), [(0.3, 0.3, False), (0.4, 0.2, False), (0.3, 0.2, True)])
def test_belts_over_parallel_pulleys(R, r, crossed):
    """From below one pulley over both, to below the other: two quarter turns, more or less by the slope of the line.

    Textbook: with the distance d the line between the pulleys is sqrt(d^2 - (R -+ r)^2) long and leans by
    asin((R -+ r)/d), which one pulley gains and the other loses, or both gain where the belt is crossed.
    """
    d, depth = 1.5, 0.8
    cylinders = [((0.0, 0.0, 0.0), (0, 0, 0), -R), ((d, 0.0, 0.0), (0, 0, 0), r if crossed else -r)]
    P, S = (-R, -depth, 0.0), (d + r, depth if crossed else -depth, 0.0)
    lean = np.arcsin((R + r) / d) if crossed else np.arcsin((R - r) / d)
    one = 0.5 * np.pi + lean
    two = 0.5 * np.pi + (lean if crossed else -lean)
    expected = 2 * depth + R * one + r * two + np.sqrt(d * d - ((R + r) if crossed else (R - r)) ** 2)
    assert length_of(over(P, S, cylinders)) == pytest.approx(expected, rel=1e-12)


SCENES = {name: case[:3] for name, case in (SKEW | MORE).items()}


@pytest.mark.parametrize("name", SCENES)
def test_tangent_and_action_are_exact(name):
    """The iteration matrix is the derivative of the residual; forces and moments on all markers add up to nothing."""
    system = compile(over(*SCENES[name], fibre_length=1.3, activation=0.4))
    assert_tangent(system, system.state())
    state, work = system.state(), system.workspace()
    evaluate(system.program, state, work)
    count = len(system.marker_index)  # the markers of states follow
    wrench, r = (work.markers[:count][x] for x in ("wrench", "r"))
    assert np.abs(wrench[:, :3]).max() > 1.0
    np.testing.assert_allclose(wrench[:, :3].sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose((wrench[:, 3:] + np.cross(r, wrench[:, :3])).sum(axis=0), 0.0, atol=1e-12)


def finger(swing: bool) -> fmb.Model:
    """Return two links on skew hinges, with a tendon over a cylinder at each, which they touch and leave."""
    one, two = (fmb.Pose.axes(x, z=z) for x, z in (((0, 0, 0), (0, 0.1, 1)), ((0.2, 0, 0), (0.1, -0.2, 1))))
    back = fmb.Pose.axes((-0.15, 0, 0), z=(0.1, -0.2, 1))
    inertia = {"mass": 1.5, "inertia": (0.01, 0.01, 0.01)}
    forces = [
        fmb.Muscle(
            "m",
            through=("ground.o", "ground.one", "far.two", "far.end"),
            radii=(0, -0.025, -0.02, 0),
            excitation=0.03,
            strength=300.0,
            fibre=0.1,
            tendon=0.31,
        )
    ]
    return fmb.Model(
        gravity=(0, -9.81 if swing else 0.0, 0),
        bodies=[
            fmb.Ground(markers={"one": one, "o": (-0.03, 0.2, 0.0)}),
            fmb.RigidBody("near", at=(0, 0, 0), markers={"one": one, "two": two}, **inertia),
            fmb.RigidBody("far", at=(0.35, 0, 0), markers={"two": back, "end": (-0.08, 0.0, 0.01)}, **inertia),
        ],
        joints=[
            fmb.Revolute("first", markers=("ground.one", "near.one")),
            fmb.Revolute("second", markers=("near.two", "far.two")),
        ],
        forces=forces,
        sensors=[
            fmb.Energy("energy"),
            fmb.JointCoordinate("a", joint="first"),
            fmb.JointCoordinate("b", joint="second"),
        ],
    )


def test_energy_balances_where_the_way_leaves_its_cylinders():
    solution = fmb.simulate(finger(True), t_end=0.6, integrator=fmb.Implicit(rtol=1e-9), samples=61)
    balance = solution["energy"] - solution.phases[0].works @ (1.0, 1.0, -1.0)
    np.testing.assert_allclose(balance, balance[0], atol=1e-6 * np.ptp(solution["energy"]))
    assert min(np.ptp(solution["a"]), np.ptp(solution["b"])) > 0.5
    alike = fmb.simulate(finger(True), t_end=0.6, integrator=fmb.Explicit(rtol=1e-9), samples=61)
    np.testing.assert_allclose(alike["b"], solution["b"], atol=1e-5)


def test_what_is_drawn_is_as_long_as_the_way():
    P, S, cylinders = SKEW["three"][:3]
    model = over(P, S, cylinders)
    scene = Scene(fmb.simulate(model, 1e-3, samples=2))
    phase, k = scene.samples[0]
    maps = [scene._map(carrier, phase) for carrier in scene.part("springs").carriers if carrier[0] == "way"]
    starts, along = np.array([m[0][k] for m in maps]), np.array([m[1][k][:, 2] for m in maps])
    np.testing.assert_allclose(starts[1:], (starts + along)[:-1], atol=1e-12)
    np.testing.assert_allclose((starts[0], (starts + along)[-1]), (P, S), atol=1e-12)
    assert 0.0 < length_of(model) - np.linalg.norm(along, axis=1).sum() < 1e-2


@pytest.mark.parametrize(
    ("cylinders", "told"),
    [
        ([((0.0, 0, 0), (0, 0, 0), -0.3), ((0.5, 0, 0), (0, 0, 0), 0.3)], "cylinders apart from each other"),
        ([((0.0, 0, 0), (0, 0, 0), -0.7), ((1.5, 0, 0), (0, 0, 0), 0.9)], "cylinders apart from each other"),
        ([((1.5, 0, 0), (0, 0, 0), -0.3), ((0.0, 0, 0), (0, 0, 0), -0.3)], "passes in this order"),
    ],
    ids=["one in the other", "both overlap", "backwards"],
)
def test_what_cannot_be_is_named(cylinders, told):
    with pytest.raises(ModelError, match=f"'c0.z', 'c1.z'.*{told}"):
        compile(over((-1.0, -0.1, 0.0), (2.5, -0.1, 0.0), cylinders))
