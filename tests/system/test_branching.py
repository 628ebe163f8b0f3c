"""Singular starts: named by `check`, refused alike by all integrators, and starts beside them run alike.

References: counts by hand (freedoms of planar linkages), agreement of formulations that share no solver.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import CompileError, ModelError

INERTIA = (1e-3, 1e-3, 1e-3)
INTEGRATORS = [
    fmb.GeneralizedAlpha(),
    fmb.IDA(),
    fmb.Implicit(),
    *(fmb.Explicit(formulation=f) for f in (fmb.Augmented(), fmb.NullSpace(), fmb.Recursive())),
]


def linkage(ground, links, joints, **fields) -> fmb.Model:
    """Return planar links between places, {name: (start, end)}, joined by revolutes, {name: (marker, marker)}."""
    bodies = [fmb.Ground(markers=ground)]
    for name, (start, end) in links.items():
        way = (*np.subtract(end, start), 0.0)
        bodies.append(
            fmb.RigidBody(name, mass=1.0, inertia=INERTIA, at=(*start, 0.0), markers={"s": (0, 0, 0), "e": way})
        )
    revolutes = [fmb.Revolute(name, markers=markers) for name, markers in joints.items()]
    return fmb.Model(bodies=bodies, joints=revolutes, gravity=(0, -9.81, 0), **fields)


def toggle(pendulum: bool) -> fmb.Model:
    """Two links stretched between two pins, and perhaps a pendulum beside them."""
    ground = {"A": (0, 0, 0), "B": (2, 0, 0), "C": (0, -1, 0)}
    links = {"left": ((0, 0), (1, 0)), "right": ((1, 0), (2, 0))}
    joints = {"a": ("ground.A", "left.s"), "m": ("left.e", "right.s"), "b": ("right.e", "ground.B")}
    if pendulum:
        links["p"], joints["c"] = ((0, -1), (0.5, -1)), ("ground.C", "p.s")
    return linkage(ground, links, joints)


def parallelogram(degrees: float) -> fmb.Model:
    """Cranks of 0.3 m on a base of 1 m."""
    e = 0.3 * np.array((np.cos(np.radians(degrees)), np.sin(np.radians(degrees))))
    links = {"crank": ((0, 0), e), "rod": (e, e + (1, 0)), "rocker": ((1, 0), e + (1, 0))}
    joints = {
        "A": ("ground.A", "crank.s"),
        "B": ("crank.e", "rod.s"),
        "C": ("rod.e", "rocker.e"),
        "D": ("ground.D", "rocker.s"),
    }
    return linkage({"A": (0, 0, 0), "D": (1, 0, 0)}, links, joints)


def towing_chain(degrees: float) -> fmb.Model:
    """Six links of 0.3048 m, 14.6 kg, hung by both ends from one place, opened by an angle; one end is towed.

    The towed end is a cart of 1 g on a rail (Wang & Huston 1988: the chain starts with both ends together).
    """
    length, mass, a = 0.3048, 14.6, 1.22
    angles = np.radians([-90.0 + degrees] * 3 + [90.0 - degrees] * 3)
    points = np.zeros((7, 3))
    points[1:, :2] = length * np.cumsum(np.column_stack([np.cos(angles), np.sin(angles)]), axis=0)
    bodies = [
        fmb.RigidBody.rod(f"l{k}", length=length, mass=mass, radius=1e-3, at=points[k], rotation=(0, 0, angles[k]))
        for k in range(6)
    ]
    rail = {"rail": fmb.Pose.axes(at=(0, 0, 0), z=(1, 0, 0)), "pin": (0, 0, 0)}
    bodies.append(fmb.RigidBody("cart", mass=1e-3, inertia=(1e-6,) * 3, at=points[6], markers=rail))
    places = ["ground.origin"] + [f"l{k}.end" for k in range(6)]
    joints = [fmb.Revolute(f"j{k}", markers=(places[k], f"l{k}.start")) for k in range(6)]
    joints += [
        fmb.Revolute("tip", markers=("l5.end", "cart.pin")),
        fmb.Prismatic("rail", markers=("ground.rail", "cart.rail")),
        fmb.Drive("tow", joint="rail", displacement=fmb.expression("x + 0.5*a*t**2", x=float(points[6, 0]), a=a)),
    ]
    sensors = [fmb.Position(f"p{k}", marker=f"l{k}.end") for k in range(6)]
    ground = fmb.Ground(markers={"rail": rail["rail"]})
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[ground, *bodies], joints=joints, sensors=sensors)


@pytest.mark.parametrize(
    ("model", "instantaneous", "finite", "joints"),
    [
        (toggle(False), 1, 0, ("a", "m", "b")),
        (toggle(True), 2, 1, ("a", "m", "b")),
        (parallelogram(0.0), 2, 1, ("A", "B", "C", "D")),
        (towing_chain(0.0), 5, 4, ("j0", "j1", "j2", "j3", "j4", "j5", "tip", "rail")),
    ],
    ids=["toggle", "toggle and pendulum", "parallelogram", "chain"],
)
def test_check_names_a_singular_configuration(model, instantaneous, finite, joints):
    report = fmb.check(model)
    assert tuple(report.singular) == (instantaneous, finite, joints)
    assert report.mobility == instantaneous
    assert f"{instantaneous} instantaneous freedoms, {finite} of motions" in str(report)


@pytest.mark.parametrize("model", [parallelogram(0.1), parallelogram(40.0), towing_chain(0.1), towing_chain(30.0)])
def test_nothing_is_singular_beside_it(model):
    assert fmb.check(model).singular is None


def bricard(turn: float) -> fmb.Model:
    """Six links of 1 m whose axes are turned by a right angle, to and fro (trihedral, Bricard 1927); closed for every
    turn of the first hinge: cos a + cos b + cos a cos b = 0.
    """
    other = -np.arccos(-np.cos(turn) / (1 + np.cos(turn)))
    frames = [np.eye(4)]
    for k in range(6):
        c, s, twist = np.cos((turn, other)[k % 2]), np.sin((turn, other)[k % 2]), (1.0, -1.0)[k % 2]
        link = [[c, 0, s * twist, c], [s, 0, -c * twist, s], [0, twist, 0, 0], [0, 0, 0, 1.0]]
        frames.append(frames[-1] @ np.array(link))
    names, bodies = ["ground", *(f"l{k}" for k in range(1, 6))], []
    for k, name in enumerate(names):
        one, two, at = frames[k], frames[k + 1], frames[k][:3, 3]
        ends = {"s": fmb.Pose((0, 0, 0), one[:3, :3]), "e": fmb.Pose(two[:3, 3] - at, two[:3, :3])}
        inertia = {"mass": 1.0, "inertia": (0.1, 0.1, 0.1), "at": at}
        bodies.append(fmb.RigidBody(name, markers=ends, **inertia) if k else fmb.Ground(markers=ends))
    hinges = [fmb.Revolute(f"r{k}", markers=(f"{names[k]}.e", f"{names[(k + 1) % 6]}.s")) for k in range(6)]
    return fmb.Model(bodies=bodies, joints=hinges, gravity=(0, 0, -9.81))


@pytest.mark.parametrize("turn", [0.5 * np.pi, 0.5 * np.pi - 1e-9, 1.0, 2.0 * np.pi / 3.0])
def test_trihedral_linkage_of_bricard_does_not_branch_here(turn):
    """Mobility 1 where Gruebler counts 0, at the symmetric position (all turns alike) too."""
    report = fmb.check(bricard(turn))
    assert (report.mobility, report.gruebler, report.singular) == (1, 0, None)


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.Explicit()])
def test_driven_dead_centre_is_named(integrator):
    """Crank and rod in line: the slider cannot be pushed at a speed."""
    ground = {"A": (0, 0, 0), "rail": fmb.Pose.axes((0, 0, 0), z=(1, 0, 0))}
    links = {"crank": ((0, 0), (0.3, 0)), "rod": ((0.3, 0), (1.3, 0))}
    model = linkage(ground, links, {"a": ("ground.A", "crank.s"), "b": ("crank.e", "rod.s")})
    slider = fmb.RigidBody("slider", mass=1.0, inertia=INERTIA, at=(1.3, 0, 0), markers={"rail": ground["rail"]})
    joints = [
        fmb.Revolute("c", markers=("rod.e", "slider.center")),
        fmb.Prismatic("p", markers=("ground.rail", "slider.rail")),
        fmb.Drive("push", joint="p", displacement=fmb.expression("1.3 - 0.1*t")),
    ]
    driven = fmb.Model(bodies=[*model.bodies, slider], joints=[*model.joints, *joints])
    with pytest.raises(CompileError, match=r"push.*first derivative misses zero.*singular configuration.*dead centre"):
        fmb.simulate(driven, 0.1, integrator=integrator)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("model", [towing_chain(0.0), toggle(False)])
def test_all_integrators_refuse_alike(model, integrator):
    with pytest.raises(CompileError, match=r"singular configuration.*belong to none of the motions.*flexmb\.disturbed"):
        fmb.simulate(model, 0.1, integrator=integrator)


def test_singular_equilibrium_is_told_and_runs():
    """A flat parallelogram without loads stays where it is: nothing asks for a branch."""
    at_rest = fmb.Model(bodies=parallelogram(0.0).bodies, joints=parallelogram(0.0).joints)
    with pytest.warns(fmb.ValidityWarning, match="2 instantaneous freedoms, 1 of motions"):
        run = fmb.simulate(at_rest, 0.1, samples=3)
    np.testing.assert_allclose(run.final.q, run.state(0.0).q, atol=1e-9)


def test_motion_through_a_regular_branch_is_told_and_runs():
    """Turning as a parallelogram through the line: velocity and acceleration belong to that branch (w = 3 rad/s)."""
    model, w = parallelogram(0.0), 3.0
    moving = {"crank": ((0, 0, 0), w), "rod": ((0, 0.3 * w, 0), 0.0), "rocker": ((0, 0, 0), w)}
    bodies = [
        b.replaced(velocity=moving[b.name][0], angular_velocity=(0, 0, moving[b.name][1])) if b.name in moving else b
        for b in model.bodies
    ]
    free = fmb.Model(bodies=bodies, joints=model.joints, sensors=[fmb.Velocity("v", marker="rod.s")])
    with pytest.warns(fmb.ValidityWarning, match="small differences decide"):
        run = fmb.simulate(free, 0.1, samples=6, integrator=fmb.Explicit())
    assert run.status.kind == "finished"


@pytest.mark.parametrize("seed", [0, 1])
def test_disturbed_start_is_beside_and_closed(seed):
    model = fmb.disturbed(parallelogram(0.0), seed=seed)
    report = fmb.check(model)
    assert report.singular is None
    assert (report.mobility, report.assembly_error < 1e-9) == (1, True)
    places = [np.asarray(b.at) - np.asarray(a.at) for a, b in zip(parallelogram(0.0).bodies[1:], model.bodies[1:])]
    assert 1e-4 < np.max(np.abs(places)) < 2e-2


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_disturbed_start_moves_as_its_joints_permit(seed):
    """Ends of links that are pinned together move alike, by their velocities as described: v + w x r."""
    flat = parallelogram(0.0)
    speeds = {"crank": (0.0, 2.0), "rocker": (0.0, 2.0), "rod": (0.6, 0.0)}
    moving = [
        b.replaced(velocity=(0, speeds[b.name][0], 0), angular_velocity=(0, 0, speeds[b.name][1]))
        for b in flat.bodies[1:]
    ]
    model = fmb.disturbed(fmb.Model(bodies=[flat.bodies[0], *moving], joints=flat.joints), size=0.1, seed=seed)
    found = {"ground": {name: np.zeros(3) for name in flat.bodies[0].markers}}
    for body in model.bodies[1:]:
        w, R = np.asarray(body.angular_velocity), np.asarray(body.rotation)
        ends = {"s": np.zeros(3), "e": np.asarray(flat.body(body.name).markers["e"].at, float)}
        found[body.name] = {name: np.asarray(body.velocity) + np.cross(w, R @ r) for name, r in ends.items()}
    assert np.linalg.norm(found["crank"]["e"]) > 0.1
    for joint in model.joints:
        one, two = (found[m.split(".")[0]][m.split(".")[1]] for m in joint.markers)
        np.testing.assert_allclose(one, two, atol=1e-9)


def test_what_cannot_be_disturbed_is_named():
    with pytest.raises(CompileError, match=r"no motion of 0\.01 of its size"):
        fmb.disturbed(toggle(False))
    with pytest.raises(ModelError, match="size = 3"):
        fmb.disturbed(toggle(False), size=3)


@pytest.fixture(scope="module")
def exact():
    return fmb.simulate(
        towing_chain(0.1), 0.2, samples=3, integrator=fmb.Explicit(formulation=fmb.NullSpace(), rtol=1e-10)
    )


@pytest.mark.parametrize(
    "integrator",
    [
        fmb.GeneralizedAlpha(),
        fmb.GeneralizedAlpha(step=1e-4),
        fmb.IDA(),
        fmb.Implicit(),
        fmb.Explicit(),
        fmb.Explicit(formulation=fmb.Recursive()),
        fmb.Explicit(formulation=fmb.UdwadiaPhohomsiri()),
    ],
)
def test_nearly_singular_start_runs_alike(integrator, exact):
    """The chain opened by 0.1 degree; the recursion closes loops by another solver than the null space.

    Equations whose multipliers are unique are not softened: softened like those of the cart of 1 g, the multiplier of
    the opening converged by 15 % in each iteration, and GeneralizedAlpha ended after 0.014 s or was 1.6 m off.
    """
    run = fmb.simulate(towing_chain(0.1), 0.2, samples=3, integrator=integrator)
    for k in range(6):
        np.testing.assert_allclose(run[f"p{k}"], exact[f"p{k}"], atol=1e-4)
