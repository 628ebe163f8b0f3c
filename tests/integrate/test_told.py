"""What a run does beyond its laws is told: energy that the steps made, divided steps, bodies that assembly moved."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.cli.command_line import main
from flexmb.integrate.runs.energy_watch import EnergyWatch
from flexmb.system import assemble


def spinner(stiffness):
    """Return a rotor about z on a bushing, which is given 8 rad/s."""
    return fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("rotor", mass=1.0, inertia=(1, 1, 1), angular_velocity=(0, 0, 8.0))],
        joints=[fmb.Revolute("A", markers=("ground.origin", "rotor.center"))],
        forces=[fmb.Bushing("ring", markers=("ground.origin", "rotor.center"), stiffness=stiffness)],
        gravity=(0, 0, 0),
        sensors=[fmb.JointCoordinate("angle", joint="A")],
    )


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(), fmb.Implicit(), fmb.Explicit(), fmb.IDA()], ids=repr)
def test_a_bushing_does_not_turn_past_half_a_turn(integrator):
    """With 1 N m/rad and 8 rad/s it turns as far as 8 rad, were its moment to grow all the way."""
    with pytest.raises(fmb.IntegrationError, match=r"Force 'ring'.*half a turn") as failed:
        fmb.simulate(spinner((0, 0, 0, 0, 0, 1.0)), 2.0, samples=201, integrator=integrator)
    assert failed.value.solution["angle"].max() < np.pi + 0.1
    solution = fmb.simulate(spinner((1e3, 1e3, 1e3, 0, 0, 0)), 2.0, integrator=integrator)  # no stiffness: it may
    assert solution["angle"][-1] == pytest.approx(16.0, rel=1e-4)


def drawn_beside(gap, **options):
    """Return a rod of 1 m that is drawn beside its hinge."""
    rod = fmb.RigidBody("rod", mass=1.0, inertia=(1, 1, 1), at=(1.0 + gap, 0, 0), markers={"end": (-1, 0, 0)})
    hinge = fmb.Revolute("hinge", markers=("ground.origin", "rod.end"))
    return fmb.Model(bodies=[fmb.Ground(), rod], joints=[hinge], **options)


ANALYSES = [
    fmb.check,
    fmb.statics,
    fmb.linearize,
    fmb.accelerations,
    fmb.first_frequencies,
    lambda model: fmb.simulate(model, 0.1, samples=3),
    lambda model: fmb.simulate(model, 0.1, samples=3, integrator=fmb.Explicit(formulation=fmb.Recursive())),
]


@pytest.mark.parametrize("gap", [0.3, 0.7, 5.0])
@pytest.mark.parametrize("analysis", ANALYSES)
def test_a_joint_that_is_drawn_far_apart_is_an_error(analysis, gap):
    """No analysis puts a part where it belongs by itself, silently: neither of a third of its length, nor of 5 m."""
    with pytest.raises(fmb.CompileError, match=rf"Joint 'hinge': as described it is open by {gap:g} m: .*'rod.end' at"):
        analysis(drawn_beside(gap))


def test_an_open_joint_of_the_drawing_is_told():
    """A rod is drawn 5 cm beside its hinge: assembly moves it, and says so; a gap of 1 mm is nothing."""
    with pytest.warns(fmb.ValidityWarning, match=r"Joint 'hinge': as described it is open by 0.05 m"):
        solution = fmb.simulate(drawn_beside(0.05), 0.1)
    assert "Joint 'hinge'" in solution.statistics["warnings"][0]
    assert "warnings" not in fmb.simulate(drawn_beside(1e-3), 0.1).statistics
    with pytest.warns(fmb.ValidityWarning, match=r"Joint 'hinge': as described it is open by 0.05 m"):
        fmb.statics(drawn_beside(0.05, gravity=(9.81, 0, 0)))


def test_check_and_run_tell_of_the_drawing(tmp_path, capsys):
    """Gap, velocity, a body that nothing holds and missing gravity, from Python and on the command line."""
    model = drawn_beside(0.05)
    moving = model.body("rod").replaced(velocity=(0, 5, 3))
    dust = fmb.PointMass("dust", mass=1.0, at=(0, 0, 2))
    model = fmb.Model(bodies=[fmb.Ground(), moving, dust], joints=model.joints)
    text = str(fmb.check(model))
    fmb.save_model(model, tmp_path / "m.toml", fmb.Simulation(t_end=0.1, samples=3))
    assert main(["run", str(tmp_path / "m.toml"), "--out", str(tmp_path / "run")]) == 0
    printed = capsys.readouterr()
    for told in (text.lower(), (printed.err + printed.out).lower()):
        assert "warning: joint 'hinge': as described it is open by 0.05 m" in told
        assert "warning: body 'rod': its velocity as described, (0, 5, 3) m/s" in told
        assert "note: nothing holds 'dust'" in told
        assert "note: there is no gravity" in told


def test_a_velocity_that_contradicts_a_joint_is_told():
    """A rod of 1 m, hinged at its end: its centre cannot move along the hinge's axis, nor without turning."""

    def model(velocity, turning):
        rod = fmb.RigidBody(
            "rod",
            mass=1.0,
            inertia=(0.1, 0.1, 0.1),
            at=(0.5, 0, 0),
            velocity=velocity,
            angular_velocity=turning,
            markers={"end": fmb.Pose.axes((-0.5, 0, 0), z=(0, 1, 0))},
        )
        hinge = fmb.Pose.axes((0, 0, 0), z=(0, 1, 0))
        return fmb.Model(
            bodies=[fmb.Ground(markers={"hinge": hinge}), rod],
            joints=[fmb.Revolute("hinge", markers=("ground.hinge", "rod.end"))],
        )

    with pytest.warns(fmb.ValidityWarning, match=r"Body 'rod': its velocity as described, \(0, 5, 3\) m/s.*'hinge'"):
        fmb.simulate(model((0, 5, 3), (0, 0, 0)), 0.01, samples=3)
    solution = fmb.simulate(model((0, 0, 3), (0, -6, 0)), 0.01, samples=3)  # a turn about the hinge
    assert "warnings" not in solution.statistics


def test_energy_that_the_steps_take_away_is_told():
    """A stiff ring on a soft one in steps that damp it: its energy is gone, and the body named; fine steps keep it."""

    def run(step):
        bodies = [fmb.Ground(), fmb.RigidBody("ring", mass=1.0, inertia=(1, 1, 1), velocity=(0, 0, 1.0))]
        model = fmb.Model(
            bodies=bodies,
            forces=[fmb.Bushing("k", markers=("ground.origin", "ring.center"), stiffness=(1e4,) * 3 + (0,) * 3)],
            gravity=(0, 0, 0),
            sensors=[fmb.Energy("energy")],
        )
        return fmb.simulate(model, 1.0, integrator=fmb.GeneralizedAlpha(rho_inf=0.5, step=step))

    with pytest.warns(fmb.ValidityWarning, match=r"Body 'ring': until t = .* the integration has removed 0\.\d+ J"):
        solution = run(0.01)
    left = solution["energy"][-1] / 0.5
    assert f"{100 * (1 - left):.2g} %" in solution.statistics["warnings"][0]  # as the sensor has it
    assert "warnings" not in run(0.0005).statistics


def test_energy_of_a_contact_is_told_with_the_contact():
    """An elastic ball, in steps too long for its contact."""
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("ball", mass=1.0, inertia=(4e-3,) * 3, at=(0, 0, 1.1))],
        gravity=(0, 0, -9.81),
        forces=[fmb.Contact("floor", markers=("ground.origin", "ball.center"), radius=0.1, stiffness=1e6)],
    )
    with pytest.warns(fmb.ValidityWarning, match=r"Force 'floor': until t = .* J that no law explains"):
        fmb.simulate(model, 2.0, integrator=fmb.GeneralizedAlpha(step=0.005))


@pytest.mark.parametrize(
    ("left", "said"), [(0.0567, "5.7 %"), (0.9999, "100 %"), (1.2345, "123 %"), (1e3, "over 10 000 %")]
)
def test_share_of_the_energy_is_a_plain_number(left, said):
    """Percent without a power of ten."""
    watch = EnergyWatch(None, None)
    watch.worst, watch.moving, watch.rest, watch.blame = (left, 0.5), 1.0, 0.0, {"Body 'b'": left}
    watch.fastest, watch.reached = 1.0, 1.0
    assert f" {said} of the largest energy" in watch.sentences(0)[0]


def test_a_loaded_and_damped_mechanism_balances():
    """Load, drive, friction and damper account for all energy."""
    rod = fmb.RigidBody("rod", mass=1.0, inertia=(0.1,) * 3, at=(0.5, 0, 0), markers={"end": (-0.5, 0, 0)})
    model = fmb.Model(
        bodies=[fmb.Ground(), rod],
        joints=[fmb.Revolute("A", markers=("ground.origin", "rod.end"))],
        forces=[
            fmb.TorsionSpring("k", joint="A", stiffness=5.0, damping=0.2),
            fmb.JointFriction("rub", joint="A", moving=0.2, radius=0.02),
            fmb.PointLoad("M", marker="rod.center", moment=(0, 0, fmb.harmonic(2.0, 0.7))),
        ],
    )
    assert "warnings" not in fmb.simulate(model, 5.0).statistics


def test_a_fixed_step_that_is_divided_is_told():
    """A mass between stops at 10 m/s, in steps of 10 ms: a stop that would be passed unseen divides the step."""
    model = fmb.Model(
        bodies=[
            fmb.Ground(),
            fmb.RigidBody("a", mass=1.0, inertia=(1e-4,) * 3, at=(1.013, 0, 0)),
            fmb.RigidBody("b", mass=1.0, inertia=(1e-4,) * 3, velocity=(30, 0, 0)),
        ],
        gravity=(0, 0, 0),
        forces=[
            fmb.Contact(
                "hit",
                markers=("a.center", "b.center"),
                radius=0.01,
                against="sphere",
                other_radius=0.01,
                stiffness=1e7,
            )
        ],
    )
    with pytest.warns(fmb.ValidityWarning, match=r"steps of the given size, 0.01 s, were divided"):
        fmb.simulate(model, 0.1, samples=3, integrator=fmb.GeneralizedAlpha(step=0.01))


def test_laws_that_steps_do_not_see_are_noted():
    """A function that jumps: the run and the check say that steps do not end there, naming all such forces."""
    bodies = [fmb.Ground(), fmb.PointMass("m", mass=1.0, velocity=(1, 0, 0))]
    pair = ("ground.origin", "m.center")
    jumps = [
        fmb.UserForce(name, markers=pair, function=lambda t, d, v, R, w: ((-float(d[0] > 0.5), 0, 0), (0, 0, 0)))
        for name in ("one", "two")
    ]
    model = fmb.Model(bodies=bodies, forces=jumps, gravity=(0, 0, -9.81))
    (note,) = fmb.check(model).notes
    assert note.startswith("Force 'one', Force 'two': steps do not end where a Python function jumps")
    assert fmb.simulate(model, 0.01, samples=2).statistics["notes"] == [note]
    spring = fmb.SpringDamper("k", markers=("ground.origin", "m.center"), stiffness=1.0, length=0.0)
    assert not fmb.check(fmb.Model(bodies=bodies, forces=[spring], gravity=(0, 0, -9.81))).notes


def test_a_mechanism_that_gravity_cannot_move_has_no_energy_to_explain():
    """The axis of the hinge is that of gravity: what moves is rounding, and no share of it is worth a warning."""
    arm = fmb.RigidBody("arm", mass=1.0, inertia=(0.1,) * 3, at=(1, 0, 0), markers={"hinge": (-1, 0, 0)})
    hinge = fmb.Revolute("hinge", markers=("ground.origin", "arm.hinge"))
    place = fmb.Position("place", marker="arm.center")
    model = fmb.Model(bodies=[fmb.Ground(), arm], joints=[hinge], gravity=(0, 0, -9.81), sensors=[place])
    solution = fmb.simulate(model, 1.0, samples=11)
    assert "warnings" not in solution.statistics
    np.testing.assert_allclose(solution["place"][-1], (1, 0, 0), atol=1e-12)


def turned_in_its_hinge(angle: float) -> fmb.Model:
    """Return a rod in a hinge about z that is drawn turned about x by an angle (rad)."""
    rod = fmb.RigidBody(
        "rod", mass=1.0, inertia=(1, 1, 1), at=(1, 0, 0), rotation=(angle, 0, 0), markers={"end": (-1, 0, 0)}
    )
    hinge = fmb.Revolute("hinge", markers=("ground.origin", "rod.end"))
    return fmb.Model(bodies=[fmb.Ground(), rod], joints=[hinge])


NOT_STARTED = [
    fmb.JointTree,
    fmb.equations,
    fmb.disturbed,
    lambda model: fmb.kinematics(model.with_parts(joints=[fmb.Drive("d", joint="hinge", angle=0.0)]), 0.1),
]


@pytest.mark.parametrize("analysis", [*ANALYSES, *NOT_STARTED])
@pytest.mark.parametrize("angle", [0.25, 0.8, 1.3])
def test_a_joint_whose_axes_are_drawn_far_apart_is_an_error(analysis, angle):
    """The angle is that of the drawing, not its sine."""
    with pytest.raises(
        fmb.CompileError, match=rf"Joint 'hinge': as described it is open by {angle:.3g} rad: .*'rod.end'.*markers="
    ):
        analysis(turned_in_its_hinge(angle))


@pytest.mark.parametrize("analysis", NOT_STARTED)
def test_what_assembles_without_a_run_goes_by_the_same_rule(analysis):
    with pytest.raises(fmb.CompileError, match=r"Joint 'hinge': as described it is open by 0.3 m"):
        analysis(drawn_beside(0.3))
    with pytest.warns(fmb.ValidityWarning, match=r"Joint 'hinge': as described it is open by 0.05 m"):
        analysis(drawn_beside(0.05))


def test_a_small_angle_of_the_drawing_is_told():
    with pytest.warns(fmb.ValidityWarning, match=r"Joint 'hinge': as described it is open by 0.15 rad, and"):
        fmb.simulate(turned_in_its_hinge(0.15), 0.1, samples=3)
    assert "warnings" not in fmb.simulate(turned_in_its_hinge(0.01), 0.1, samples=3).statistics


def test_a_joint_that_is_drawn_turned_by_half_a_turn_is_closed():
    """Axes against each other satisfy a hinge: nothing moves."""
    tree = fmb.JointTree(turned_in_its_hinge(np.pi))
    np.testing.assert_allclose(tree.pose("rod.center", tree.start.q)[0], (1, 0, 0), atol=1e-12)


@pytest.mark.parametrize(("force", "kinks"), [("-where(v[0] > 0, 2, -2)", 1), ("-2*tanh(v[0]/0.01)", 0)])
def test_kinks_in_the_forces_of_a_constraint_are_known(force, kinks):
    """Steps end there: there is nothing to be noted."""
    bead = fmb.PointMass("bead", mass=1.0, velocity=(1, 0, 0))
    over = [fmb.Position("p", marker="bead.center"), fmb.Velocity("v", marker="bead.center")]
    wire = fmb.Constraint("wire", over=over, equation="p[2] = 0", forces={"v[0]": force})
    model = fmb.Model(bodies=[fmb.Ground(), bead], joints=[wire], gravity=(0, 0, -9.81))
    assert not [note for note in fmb.check(model).notes if "steps do not end" in note]
    assert assemble(model)[0].switch_owners == ("Joint 'wire'",) * kinks
