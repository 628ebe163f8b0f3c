"""Integration in joint coordinates: the same motions as in absolute coordinates, joints that cannot open, order, stiff
modes.

The references are the explicit method of order eight on the absolute coordinates and the augmented equations, which
shares neither unknowns nor linear algebra with what is tested, and closed forms.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from contracts.random_models import beam
from scipy.special import ellipj, ellipk
from tolerances import MACHINE
from tree.models import branched, chain, flexible_chain, loops
from tree.test_loops_over_time import levels
from tree.test_stiff import stiff_chain
from verification.mechanisms import bricard, four_bars

import flexmb as fmb
from flexmb.integrate.implicit.stages import STAGES, THIRD, WEIGHTS
from flexmb.system import assemble

VALIDATION = Path(__file__).parents[1] / "data" / "validation"


def floating_chain():
    """Return three flexible bodies on a slide and a ball that float and are pulled at one end."""
    return replace(flexible_chain(3), joints=flexible_chain(3).joints[1:])


def driven_arm():
    """Return an arm of four links on crossed hinges and a slide, the first and the slide driven, with their works."""
    links = [
        fmb.StandardLink(a=0.4, d=0.0, alpha=alpha, mass=2.0, inertia=(0.02, 0.05, 0.04), slides=slides)
        for alpha, slides in ((np.pi / 2, False), (0.3, False), (-np.pi / 2, True), (0.0, False))
    ]
    arm = fmb.serial_arm(links, gravity=(1.0, 2.0, -9.81), name="arm")
    drives = [
        fmb.Drive("turn", joint="joint_1", angle=fmb.expression("0.3 * t + t**2")),
        fmb.Drive("reach", joint="joint_3", displacement=fmb.expression("0.2 * t**2")),
    ]
    return arm.with_parts(joints=drives, sensors=[fmb.Energy("energy")])


MOTIONS = {
    "chain": (lambda: chain(4), 0.5),
    "driven arm": (driven_arm, 0.5),
    "balls": (lambda: chain(3, fmb.Spherical), 0.5),
    "floating flexible chain": (floating_chain, 0.01),
    "branches, a drive and a point": (branched, 0.005),
    "four-bars": (lambda: four_bars(2), 0.5),
    "flexible loops": (loops, 0.01),
    "Bricard": (lambda: bricard(json.loads((VALIDATION / "RB04.json").read_text())), 1.0),
}
TIGHT = 1e-8
"""Of positions, m or rad: some ten times what the tolerances of both methods leave."""


@pytest.mark.parametrize("name", MOTIONS)
def test_motion_as_in_absolute_coordinates(name):
    make, t_end = MOTIONS[name]
    model = make()
    closely = fmb.Explicit(rtol=1e-11, atol=1e-13, drift=1e-12)
    reference = fmb.simulate(model, t_end, samples=3, integrator=closely)
    explicit = fmb.simulate(model, t_end, samples=3, formulation=fmb.Recursive())
    implicit = fmb.simulate(model, t_end, samples=3, integrator=fmb.Implicit(rtol=1e-7))
    unit = np.abs(reference.final.u).max()
    for solution, position, velocity in ((explicit, TIGHT, 1e-6), (implicit, 2e-6, 1e-3)):
        np.testing.assert_allclose(solution.final.q, reference.final.q, atol=position)
        np.testing.assert_allclose(solution.final.u, reference.final.u, atol=velocity * unit)
        np.testing.assert_allclose(solution.phases[0].works[-1], reference.phases[0].works[-1], atol=10.0 * position)
        assert levels(solution).max() < 1e-9


def test_rigid_links_take_the_passes_in_link_axes():
    """Driven or not, in the position of the start: the accelerations are those of the recursion over blocks."""
    for model in (chain(4), driven_arm()):
        system, state = assemble(model)
        unknowns = fmb.Recursive().unknowns(system, state, system.workspace())
        x, v, a = unknowns.of(state)
        _, found, _ = unknowns.rates(0.0, x, v, None)  # without the solution that other models need
        np.testing.assert_allclose(found, a, atol=1e-9 * np.abs(a).max())


@pytest.mark.parametrize("integrator", [fmb.Explicit(formulation=fmb.Recursive()), fmb.Implicit(rtol=1e-5)])
def test_joints_of_a_tree_cannot_open(integrator):
    """Twenty turns of a rotor with a ball and a slide on it: the joints hold to rounding, and nothing is projected."""
    rotor = fmb.RigidBody.rod("rotor", length=1.0, mass=1.0, radius=0.05, angular_velocity=(0, 0, 40.0))
    bob = fmb.RigidBody.rod("bob", length=0.5, mass=0.3, radius=0.02, at=(1, 0, 0), velocity=(0, 40.0, 0))
    bead = fmb.RigidBody.sphere(
        "bead", radius=0.02, density=3000.0, at=(0.5, 0, 0), velocity=(0, 20.0, 0), angular_velocity=(0, 0, 40.0)
    )
    along = {"middle": fmb.Pose.axes((0.5, 0, 0), x=(0, 1, 0), z=(1, 0, 0))}
    rotor = replace(rotor, markers={**rotor.markers, **along})
    bead = replace(bead, markers={"hole": fmb.Pose.axes((0, 0, 0), x=(0, 1, 0), z=(1, 0, 0))})
    joints = [
        fmb.Revolute("A", markers=("ground.origin", "rotor.start")),
        fmb.Spherical("B", markers=("rotor.end", "bob.start")),
        fmb.Prismatic("C", markers=("rotor.middle", "bead.hole")),
    ]
    spring = fmb.SpringDamper("s", markers=("rotor.middle", "bead.hole"), stiffness=2e3, damping=0.1, length=0.0)
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(), rotor, bob, bead],
        joints=joints,
        forces=[spring],
        sensors=[fmb.JointCoordinate("turns", joint="A")],
    )
    solution = fmb.simulate(model, 3.0, samples=4, integrator=integrator)
    assert solution["turns"][-1] > 40.0
    assert levels(solution).max() < MACHINE
    assert solution.statistics["projections"] == 0


@pytest.mark.parametrize(
    "formulation", [fmb.Augmented(), fmb.Recursive(), None], ids=["absolute", "joints", "implicit"]
)
def test_turns_are_counted(formulation):
    """A torsion spring that is wound up by several turns: from x = 0 with the speed w, x = w / n sin(n t)."""
    rod = fmb.RigidBody("rod", mass=1.0, inertia=(1.0, 1.0, 1.0), angular_velocity=(0, 0, 10.0))
    spring = fmb.TorsionSpring("k", joint="A", stiffness=0.2)
    model = fmb.Model(
        bodies=[fmb.Ground(), rod],
        joints=[fmb.Revolute("A", markers=("ground.origin", "rod.center"))],
        forces=[spring],
        sensors=[fmb.JointCoordinate("x", joint="A"), fmb.ForceOf("M", force="k")],
    )
    integrator = fmb.Implicit(rtol=1e-8) if formulation is None else fmb.Explicit(formulation=formulation)
    solution = fmb.simulate(model, 6.0, samples=61, integrator=integrator)
    n = np.sqrt(0.2)
    expected = 10.0 / n * np.sin(n * solution.t)
    np.testing.assert_allclose(solution["x"], expected, atol=1e-5)
    np.testing.assert_allclose(np.asarray(solution["M"])[:, 5], -0.2 * expected, atol=1e-5)


def swing(start):
    """Return a pendulum of 1 m that is let go at an angle, with the sensor "x" from the x-axis,
    and x as function of time.
    """
    bob = fmb.RigidBody(
        "bob",
        mass=1.0,
        inertia=(0, 0, 0),
        center_of_mass=(1, 0, 0),
        rotation=(0, 0, start - np.pi / 2),
        markers={"pin": (0, 0, 0)},
    )
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), bob],
        joints=[fmb.Revolute("A", markers=("ground.origin", "bob.pin"))],
        sensors=[fmb.JointCoordinate("x", joint="A")],
    )
    k, w = np.sin(start / 2) ** 2, np.sqrt(9.81)
    return model, lambda t: 2.0 * np.arcsin(np.sqrt(k) * ellipj(ellipk(k) + w * t, k)[0]) - np.pi / 2


@pytest.mark.parametrize("cut", ["screw", "slide"])
def test_a_screw_goes_on_after_full_turns(cut):
    """A nut that a spindle has moved by three turns, and the spindle's motor then by three more: pitch times turns."""
    along = fmb.Pose((0, 0, 0), (0, np.pi / 2, 0))
    bodies = [
        fmb.RigidBody(name, mass=1.0, inertia=(0.1, 0.1, 0.1), markers={"m": along}) for name in ("spindle", "nut")
    ]
    hinge = fmb.Revolute("hinge", markers=("ground.m", "spindle.m"))
    screw = fmb.Screw("screw", markers=("spindle.m", "nut.m"), pitch=0.05)
    slide = fmb.Prismatic("slide", markers=("ground.m", "nut.m"))
    motor = fmb.Drive("motor", joint="hinge", angle=fmb.expression("-20*t"))
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"m": along}), *bodies],
        joints=[hinge, screw, slide, motor],
        sensors=[fmb.Position("place", marker="nut.m"), fmb.JointCoordinate("turn", joint="screw")],
    )
    explicit = fmb.Explicit(formulation=fmb.Recursive(cut=(cut,)))
    first = fmb.simulate(model, 1.0, samples=3, integrator=explicit)
    solution = fmb.resume(first, 2.0, samples=[0.0, 2.0], integrator=explicit)
    np.testing.assert_allclose(np.ravel(solution["turn"])[-1], 40.0, atol=MACHINE)
    np.testing.assert_allclose(solution["place"][-1], [0.05 * 40.0 / (2.0 * np.pi), 0.0, 0.0], atol=1e-10)


def test_pendulum_with_high_amplitude():
    """Two periods of a pendulum that swings by 120 degrees, by elliptic functions."""
    model, angle = swing(np.radians(120.0))
    times = np.linspace(0.0, 8.0 * ellipk(np.sin(np.pi / 3) ** 2) / np.sqrt(9.81), 9)
    for integrator in (fmb.Explicit(formulation=fmb.Recursive()), fmb.Implicit(rtol=1e-9)):
        solution = fmb.simulate(model, times[-1], samples=times, integrator=integrator)
        np.testing.assert_allclose(solution["x"], angle(times), atol=2e-6)


def test_weights_of_the_implicit_method():
    """Order conditions to order four, and to order three of the embedded method; L-stability; stage order two."""
    A, b = WEIGHTS, WEIGHTS[-1]
    c, one = A.sum(axis=1), np.ones(STAGES)
    for w, order in ((b, 4), (THIRD, 3)):
        found = [w @ one, w @ c, w @ c**2, w @ A @ c, w @ c**3, w @ (c * (A @ c)), w @ A @ c**2, w @ A @ A @ c]
        expected = [1, 1 / 2, 1 / 3, 1 / 6, 1 / 4, 1 / 8, 1 / 12, 1 / 24]
        count = 8 if order == 4 else 4
        np.testing.assert_allclose(found[:count], expected[:count], atol=1e-15)
    np.testing.assert_allclose(A @ c, c**2 / 2, atol=1e-15)
    z = -1e9
    assert abs(1.0 + z * b @ np.linalg.solve(np.eye(STAGES) - z * A, one)) < 1e-7


@pytest.mark.parametrize(
    ("make", "t_end", "drift"),
    [(lambda: chain(2), 1.0, 1e-10), (lambda: chain(3, fmb.Spherical), 0.4, 1e-10), (lambda: four_bars(1), 0.4, 1e-12)],
    ids=["double pendulum", "balls", "loop"],
)
def test_order_four_of_fixed_steps(make, t_end, drift):
    """From some 10 ms to below 1 ms half the step means a sixteenth of the error, of velocities too,
    whatever rtol is.
    """
    model = make()
    reference = fmb.simulate(model, t_end, samples=2, integrator=fmb.Explicit(rtol=1e-12, atol=1e-13)).final
    errors = []
    counts = [int(t_end / 0.4 * n) for n in (32, 64, 128, 256, 512)]
    for steps in counts:
        solution = fmb.simulate(model, t_end, samples=2, integrator=fmb.Implicit(step=t_end / steps, drift=drift))
        assert solution.statistics["steps"] == steps
        errors.append(
            [np.abs(x - y).max() for x, y in ((solution.final.q, reference.q), (solution.final.u, reference.u))]
        )
    errors = np.array(errors)
    falls = errors[:-1] / errors[1:]
    assert falls[errors[1:] > 1e-11].min() > 13.0  # below, rounding and the reference show
    assert errors[-1, 0] < 1e-10


def test_order_four_against_elliptic_functions():
    """A pendulum that swings by 120 degrees for 2 s: the error falls with h^4 from 80 ms to 2.5 ms at the
    default rtol.
    """
    model, angle = swing(np.radians(120.0))
    errors = [
        abs(fmb.simulate(model, 2.0, samples=2, integrator=fmb.Implicit(step=2.0 / n))["x"][-1] - angle(2.0))
        for n in (25, 50, 100, 200, 400, 800)
    ]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 4.0, atol=0.15)


def test_steps_far_above_the_period_of_stiff_modes():
    """Two steel beams that fall on hinges: implicit steps resolve the motion, not modes of some 3 kHz."""
    model = stiff_chain(2)
    highest = 1.0 / fmb.linearize(model).frequencies.max()
    step = 5e-3
    assert step > 15.0 * highest
    reference = fmb.simulate(model, 0.05, samples=2, formulation=fmb.Recursive())
    solution = fmb.simulate(model, 0.05, samples=2, integrator=fmb.Implicit(step=step))
    tree = fmb.JointTree(model)
    np.testing.assert_allclose(tree.relative(solution.final).q, tree.relative(reference.final).q, atol=2e-5)
    assert solution.statistics["steps"] == 10
    assert solution.statistics["steps"] * 15 < reference.statistics["steps"]
    assert solution.statistics["factorisations"] <= 11


def test_events_and_works_with_the_implicit_method(tmp_path):
    """A hinge breaks at an angle; the file holds what memory holds; energy and works balance."""
    model = four_bars(1)
    angle = fmb.JointCoordinate("crank", joint="g0")
    drag = fmb.SpringDamper("drag", markers=("ground.A1", "c0.end"), stiffness=5.0, damping=2.0, length=1.0)
    event = fmb.Event("breaks", sensor="crank", below=1.3, then=fmb.Release("r0"))
    model = replace(model, sensors=(*model.sensors, angle), forces=(drag,), events=(event,))
    one = fmb.simulate(model, 0.4, samples=9, integrator=fmb.Implicit(rtol=1e-7), output=tmp_path / "run.h5")
    other = fmb.simulate(model, 0.4, samples=9, formulation=fmb.Augmented())
    assert len(one.phases) == len(other.phases) == 2
    np.testing.assert_allclose(one.phases[0].t[-1], other.phases[0].t[-1], atol=1e-6)
    np.testing.assert_allclose(one["crank"], other["crank"], atol=1e-5)
    np.testing.assert_allclose(one.phases[-1].works[-1], other.phases[-1].works[-1], atol=1e-6)
    np.testing.assert_allclose(fmb.Solution.load(tmp_path / "run.h5")["crank"], one["crank"])


@pytest.mark.parametrize(
    "integrator",
    [fmb.Explicit(), fmb.Explicit(formulation=fmb.Recursive()), fmb.Implicit(rtol=1e-10)],
    ids=["absolute", "joints", "implicit"],
)
def test_energy_is_the_work_of_drives_and_loads(integrator):
    """A driven crank with a pendulum that is pulled and damped:
    the energy grows by what goes in, less what is dissipated.
    """
    crank = fmb.RigidBody.rod("crank", length=0.4, mass=1.0, radius=0.02, angular_velocity=(0, 0, 2.0))
    bob = fmb.RigidBody.rod("bob", length=0.6, mass=0.5, radius=0.02, at=(0.4, 0, 0), velocity=(0, 0.8, 0))
    joints = [
        fmb.Revolute("A", markers=("ground.origin", "crank.start")),
        fmb.Spherical("B", markers=("crank.end", "bob.start")),
        fmb.Drive("motor", joint="A", angle=fmb.expression("2*t + 0.5*t**2")),
    ]
    forces = [
        fmb.PointLoad("pull", marker="bob.end", force=(1.0, -2.0, 3.0)),
        fmb.SpringDamper("s", markers=("ground.origin", "bob.end"), stiffness=20.0, damping=0.5, length=0.5),
    ]
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), crank, bob],
        joints=joints,
        forces=forces,
        sensors=[fmb.Energy("energy")],
    )
    solution = fmb.simulate(model, 1.0, samples=3, integrator=integrator)
    loads, drives, dissipated = solution.phases[0].works[-1]
    assert min(abs(loads), abs(drives), abs(dissipated)) > 0.1
    assert solution["energy"][-1] - solution["energy"][0] == pytest.approx(loads + drives - dissipated, abs=2e-6)


@pytest.mark.parametrize("step", [None, 0.01])
def test_uniform_motion_without_accelerations(step):
    """A free body and one on a slide, no loads: nothing to iterate, and places to rounding."""
    free = fmb.RigidBody("free", mass=1.0, inertia=(1, 2, 3), velocity=(1, 2, 3))
    held = fmb.RigidBody("held", mass=1.0, inertia=(1, 2, 3), velocity=(0, 0, 2))
    model = fmb.Model(
        bodies=[fmb.Ground(), free, held],
        joints=[fmb.Prismatic("A", markers=("ground.origin", "held.center"))],
        gravity=(0, 0, 0),
        sensors=[fmb.Position(name, marker=f"{name}.center") for name in ("free", "held")],
    )
    solution = fmb.simulate(model, 1.0, samples=3, integrator=fmb.Implicit(step=step))
    np.testing.assert_allclose(solution["free"], solution.t[:, None] * (1, 2, 3), atol=100.0 * MACHINE)
    np.testing.assert_allclose(solution["held"], solution.t[:, None] * (0, 0, 2), atol=100.0 * MACHINE)
    assert solution.statistics["iterations"] == 5 * solution.statistics["steps"]


def test_what_the_implicit_method_refuses():
    with pytest.raises(
        fmb.ModelError, match=r"formulation = Augmented\(\).*Recursive\(...\).*GeneralizedAlpha and IDA"
    ):
        fmb.Implicit(formulation=fmb.Augmented())
    with pytest.raises(fmb.ModelError, match=r"rtol = -1.*a positive number"):
        fmb.Implicit(rtol=-1)
    with pytest.raises(fmb.ModelError, match=r"both an integrator, Implicit"):
        fmb.simulate(chain(1), 1.0, integrator=fmb.Implicit(), formulation=fmb.Recursive())


def test_dependent_equations_do_not_shorten_steps():
    """Bricard's mechanism, within a step off its constraints, whose dependent equations then contradict each other."""
    model = MOTIONS["Bricard"][0]()
    reference = fmb.simulate(model, 1.0, samples=2, integrator=fmb.Explicit(rtol=1e-11, atol=1e-12))
    for rtol in (1e-8, 1e-10):
        solution = fmb.simulate(model, 1.0, samples=2, integrator=fmb.Implicit(rtol=rtol))
        assert solution.statistics["rejected by iteration"] == 0
        assert solution.statistics["factorisations"] < 2 * solution.statistics["steps"]
        np.testing.assert_allclose(solution.final.q, reference.final.q, atol=100.0 * rtol)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("flexible", [False, True], ids=["rigid", "flexible"])
@pytest.mark.parametrize(
    "how", [fmb.Explicit(formulation=fmb.Recursive()), fmb.Implicit()], ids=["explicit", "implicit"]
)
def test_a_screw_whose_slide_is_driven(how, flexible, order):
    """It turns by 2 pi slide / pitch, many times about, beyond a phase too: the tree has the turn for a coordinate."""
    pitch, far = 0.05, 0.4
    pose = {"at": (0.1, 0.2, 0.3), "rotation": (0.3, -0.2, 0.5)}
    if flexible:
        body, own, change = fmb.FloatingBody("body", data=beam(), damping=0.02, **pose), "body.root", {"damping": 0.03}
    else:
        body = fmb.RigidBody("body", mass=1.0, inertia=(0.1, 0.2, 0.3), **pose)
        own, change = "body.center", {"mass": 2.0}
    model = fmb.Model(
        gravity=(1.0, 2.0, -9.81),
        bodies=[fmb.Ground(markers={"bearing": fmb.Pose(*pose.values())}), body],
        joints=[
            fmb.Screw("screw", markers=("ground.bearing", own)[::order], pitch=pitch),
            fmb.Drive("feed", joint="screw", displacement=fmb.expression(f"{far}*(3*t**2 - 2*t**3)")),
        ],
        sensors=[fmb.JointCoordinate(name, joint="screw", freedom=name) for name in ("slide", "turn")],
        events=[fmb.Event("later", at=0.5, then=fmb.Change("body", **change))],
    )
    motion = fmb.simulate(model, 1.0, samples=41, integrator=how)
    expected = far * motion.t**2 * (3.0 - 2.0 * motion.t)
    np.testing.assert_allclose(motion["slide"], expected, atol=1e-9)
    np.testing.assert_allclose(motion["turn"], 2.0 * np.pi * expected / pitch, atol=1e-7)
