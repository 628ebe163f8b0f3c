"""A parallelogram and a door with too many hinges: mobility, dependent equations by joint, reactions that are not
unique.

References: the parallelogram moves like its closed equation of one freedom (RB02); its forces in the plane are unique
and equal those of the same linkage with joints that forbid less; a door with a locked wing has one equation too many
per extra hinge.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from verification.mechanisms import andrews, bricard, door, four_bars

import flexmb as fmb

CROSSWISE = ["Coincident[z]", "Perpendicular z x", "Perpendicular z y"]


def parallelogram(free: bool) -> fmb.Model:
    """One four-bar of RB02; with `free`, two of its hinges forbid less and nothing is redundant."""
    model = four_bars(1)
    joints = list(model.joints)
    if free:
        by_name = {joint.name: k for k, joint in enumerate(joints)}
        for name, kind in (("l0", fmb.Spherical), ("r0", fmb.Cylindrical)):
            joints[by_name[name]] = kind(name, markers=joints[by_name[name]].markers)
    sensors = [*model.sensors, *(fmb.Reaction(f"force {name}", joint=name) for name in ("g0", "l0", "r0", "g1"))]
    return fmb.Model(gravity=model.gravity, bodies=model.bodies, joints=joints, sensors=sensors)


def test_what_is_said_about_a_parallelogram():
    report = fmb.check(parallelogram(free=False))
    assert (report.mobility, report.gruebler, len(report.redundant)) == (1, -2, 3)
    assert {name.split(":")[0] for name in report.redundant} == {"r0"}
    assert report.shared_reactions == dict.fromkeys(("g0", "g1", "l0", "r0"), CROSSWISE)
    text = str(report)
    assert "not unique" in text
    assert "l0: force along z of W, moment about y, moment about x" in text
    free = fmb.check(parallelogram(free=True))
    assert (free.mobility, free.gruebler, free.redundant, free.indeterminate) == (1, 1, (), ())


def test_colons_in_names_of_joints_are_kept():
    """In the report of `check` and in that of a run."""
    plain = parallelogram(free=False)
    names = {joint.name: f"left: {joint.name}" for joint in plain.joints}
    joints = [replace(joint, name=names[joint.name]) for joint in plain.joints]
    model = replace(plain, joints=joints, sensors=())
    wanted = dict.fromkeys((names[name] for name in ("g0", "g1", "l0", "r0")), CROSSWISE)
    report = fmb.check(model)
    assert report.shared_reactions == wanted
    assert "left: l0: force along z of W, moment about y, moment about x" in str(report)
    assert fmb.simulate(model, 1e-3, samples=2).shared_reactions == wanted


@pytest.mark.parametrize(
    ("integrator", "tolerance"),
    [(fmb.GeneralizedAlpha(step=1e-3), 5e-6), (fmb.IDA(rtol=1e-9, atol=1e-10), 1e-6), (fmb.Explicit(), 1e-8)],
    ids=["alpha", "IDA", "explicit"],
)
def test_the_parallelogram_moves_like_its_closed_equation(integrator, tolerance):
    """J a = S sin(a); reached: 1.4e-6, 6e-9 and 1e-10 m. Forces in the plane are unique: equal without redundancy."""
    J, S = 2 * (1 / 3 + 0.01**2 / 4) + 1, 9.81 * 2
    motion = solve_ivp(
        lambda t, y: (y[1], S / J * np.sin(y[0])),
        (0, 0.5),
        (0.0, 1.0),
        rtol=1e-12,
        atol=1e-12,
        method="DOP853",
        t_eval=[0.25, 0.5],
    )
    runs = [fmb.simulate(parallelogram(free), 0.5, samples=3, integrator=integrator) for free in (False, True)]
    for run in runs:
        expected = np.column_stack([np.sin(motion.y[0]), np.cos(motion.y[0])])
        np.testing.assert_allclose(run["B0"][1:, :2], expected, atol=tolerance)
    for name in ("g0", "l0", "r0", "g1"):
        one, other = (run[f"force {name}"][:, :2] for run in runs)
        np.testing.assert_allclose(one, other, atol=2e-3)
        assert np.abs(runs[0][f"force {name}"][:, 2:5]).max() < 1e-6  # least norm: nothing across the plane


def test_a_door_on_three_hinges_shares_everything(reference):
    """Each hinge but one is dependent; of all of them no reaction is unique."""
    report = fmb.check(door(reference("RC01"), (-0.5, 0.0, 0.5)))
    assert len(report.redundant) == 10
    assert set(report.shared_reactions) == {"h0", "h1", "h2"}
    assert all(len(kinds) == 5 for kinds in report.shared_reactions.values())


def test_a_prop_is_one_too_many_only_for_a_door_that_is_fixed(reference):
    """On a ball joint the prop takes a freedom; beside a fixed hinge it and the hinge share the weight in no
    unique way.
    """
    model = door(reference("RC01"), (-0.5, 0.5))
    width = reference("RC01")["model"]["width"]
    ground = fmb.Ground(markers={**model.bodies[0].markers, "low": (width, 0.0, -1.0)})
    plate = model.bodies[1].replaced(markers={**model.bodies[1].markers, "edge": (width, 0.0, 0.0)})
    prop = fmb.Rod("prop", markers=("ground.low", "door.edge"))

    def report(kind):
        joints = [kind("wall", markers=("ground.h0", "door.h0")), prop]
        return fmb.check(fmb.Model(gravity=(0, 0, -9.81), bodies=[ground, plate], joints=joints))

    free, fixed = report(fmb.Spherical), report(fmb.Fixed)
    assert (free.mobility, free.redundant, free.indeterminate) == (2, (), ())
    assert (fixed.mobility, fixed.gruebler) == (0, -1)
    assert [name.split(":")[0] for name in fixed.redundant] == ["prop"]
    # the prop pushes up at (0.9, 0.5) m from the hinge: it shares the vertical force and the moments about x and y of W
    assert fixed.shared_reactions["wall"] == ["Coincident[z]", "Perpendicular x y", "Perpendicular z x"]


def test_bricard_and_andrews(reference):
    """In Bricard's loop one state of self-stress goes through every joint; in Andrews' plane only what is across it."""
    shared = fmb.check(bricard(reference("RB04"))).shared_reactions
    assert set(shared) == {f"j{k}" for k in range(6)}
    across = fmb.check(andrews(reference("RB03"))).shared_reactions
    assert all(kinds == CROSSWISE for kinds in across.values())
