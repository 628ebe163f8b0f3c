"""Lumped masses with hardly any moment of inertia, and flywheels with hardly any mass: joints stay what they are."""

import warnings

import numpy as np
import pytest
from scipy import linalg, optimize
from scipy.spatial.transform import Rotation

import flexmb as fmb

ACROSS = (np.pi / 2, 0.0, 0.0)


def two_links(inertia: float, length: float = 1.0) -> fmb.Model:
    """Ziegler's column: masses 2 and 1 kg at the ends of two links, springs at both hinges, a follower load of 1 N m
    over the length."""
    one, two = (
        fmb.RigidBody(
            name,
            mass=mass,
            inertia=(inertia,) * 3,
            at=(k * length, 0, 0),
            markers={"inner": fmb.Pose((-length, 0, 0), ACROSS), "outer": fmb.Pose((0, 0, 0), ACROSS)},
        )
        for k, (name, mass) in enumerate((("one", 2.0), ("two", 1.0)), 1)
    )
    pins = (("ground.hinge", "one.inner"), ("one.outer", "two.inner"))
    return fmb.Model(
        bodies=[fmb.Ground(markers={"hinge": fmb.Pose((0, 0, 0), ACROSS)}), one, two],
        joints=[fmb.Revolute(f"pin{k}", markers=pair) for k, pair in enumerate(pins)],
        forces=[
            *(fmb.TorsionSpring(f"spring{k}", joint=f"pin{k}", stiffness=1.0) for k in range(2)),
            fmb.PointLoad("load", marker="two.outer", force=(-1.0 / length, 0, 0), axes="two.outer"),
        ],
        sensors=[fmb.Reaction("reaction", joint="pin0")],
    )


@pytest.mark.parametrize("length", [1.0, 1e-3, 1e3])
@pytest.mark.parametrize("share", [1e-9, 1e-11, 1e-12, 2e-13])
def test_frequencies_of_lumped_masses(share, length):
    """Two freedoms, and the frequencies of Ziegler's column (Bolotin, Nonconservative problems, 1963) in its plane."""
    model = two_links(share * length**2, length)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert fmb.check(model).mobility == 2
        found = fmb.linearize(model).frequencies
    stiffness, mass = np.array([[1.0, 0.0], [-1.0, 1.0]]), np.array([[3.0, 1.0], [1.0, 1.0]]) * length**2
    expected = np.sort(np.sqrt(linalg.eigvals(stiffness, mass).real)) / (2.0 * np.pi)
    np.testing.assert_allclose(found, expected, rtol=1e-7)


@pytest.mark.parametrize("integrator", [fmb.GeneralizedAlpha(rtol=1e-7), fmb.Implicit(rtol=1e-7), fmb.IDA(rtol=1e-8)])
def test_motion_of_lumped_masses(integrator):
    """As of links without any moment of inertia."""
    runs = []
    for inertia in (1e-12, 0.0):
        model = two_links(inertia)
        falling = fmb.Model(bodies=model.bodies, joints=model.joints, sensors=model.sensors, gravity=(0, 0, -9.81))
        runs.append(fmb.simulate(falling, 0.3, samples=4, integrator=integrator)["reaction"])
    np.testing.assert_allclose(runs[0], runs[1], rtol=0, atol=1e-4)


@pytest.mark.parametrize("mass", [1e-6, 1e-12, 1e-14])
def test_a_flywheel_without_mass_turns_on_two_balls(mass):
    """1 kg m2 on a line through two balls, 0.3 m from its centre: one freedom, a = F r / (J + m r^2)."""
    balls = {"low": (0, 0, 0), "high": (0, 0, 1)}
    wheel = fmb.RigidBody(
        "wheel",
        mass=mass,
        inertia=(1.0, 1.0, 1.0),
        at=(0.3, 0, 0.5),
        markers={"low": (-0.3, 0, -0.5), "high": (-0.3, 0, 0.5), "centre": (0, 0, 0)},
    )
    model = fmb.Model(
        bodies=[fmb.Ground(markers=balls), wheel],
        joints=[fmb.Spherical(name, markers=(f"ground.{name}", f"wheel.{name}")) for name in balls],
        forces=[fmb.PointLoad("push", marker="wheel.centre", force=(0, 1, 0))],
    )
    assert fmb.check(model).mobility == 1
    np.testing.assert_allclose(
        fmb.accelerations(model)["wheel"], (0, 0.09 / (1 + 0.09 * mass), 0, 0, 0, 0.3 / (1 + 0.09 * mass)), atol=1e-9
    )


def test_a_moment_of_inertia_without_digits_is_told():
    with pytest.warns(fmb.ValidityWarning, match=r"Body 'one' has a moment of inertia of 1e-15.*arm of joint 'pin0'"):
        fmb.check(two_links(1e-15))


@pytest.mark.parametrize("turned", [(0.0, 0.0, 0.0), (0.3, -0.5, 0.7), (1.1, 0.4, -0.2), (-0.6, 0.9, 0.5)])
def test_a_body_thin_as_a_line_has_no_moment_to_tell_of(turned):
    """Written in axes that are oblique to the line, its moment of inertia about it is rounding of zero."""
    R = Rotation.from_rotvec(turned).as_matrix()
    line, hinge = R @ (1.0, 0, 0), tuple(R @ (0.3, 0.2, 0.1))
    thin = fmb.RigidBody(
        "thin",
        mass=1.0,
        inertia=0.1 * (np.eye(3) - np.outer(line, line)),
        center_of_mass=tuple(0.5 * line),
        markers={"hinge": hinge},
    )
    joint = fmb.Revolute("hinge", markers=("ground.hinge", "thin.hinge"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert fmb.check(fmb.Model(bodies=[fmb.Ground(markers={"hinge": hinge}), thin], joints=[joint])).mobility == 1


BEGIN, CRANK, ROCKER, END = (np.array(p) for p in ((0, 0, 0.0), (0.1, 0, 0.3), (0.9, 0, 0.5), (0.8, 0, 0.0)))
PINS = {"crank": (BEGIN, CRANK), "coupler": (CRANK, ROCKER), "rocker": (ROCKER, END)}
LUMPED, MIDDLE = {"crank": 1.0, "coupler": 0.5, "rocker": 1.0}, dict.fromkeys(PINS, 0.5)
"""Where on the way from pin to pin the centre of mass of a link is."""


def four_bar(masses, inertia: float, centres, ball: bool = False, tilt: float = 0.0) -> fmb.Model:
    """Three links with moments of inertia of a share of their masses, times 1 m2; axes of pins tilted by some rad."""
    axes = [(ACROSS[0], tilt * (-1) ** n, tilt * n) for n in range(4)]
    links = []
    for k, (mass, (name, (first, last))) in enumerate(zip(masses, PINS.items(), strict=True)):
        centre = first + centres[name] * (last - first)
        ends = {"in": fmb.Pose(tuple(first - centre), axes[k]), "out": fmb.Pose(tuple(last - centre), axes[k + 1])}
        links.append(fmb.RigidBody(name, mass=mass, inertia=(mass * inertia,) * 3, at=tuple(centre), markers=ends))
    joints = {
        "A": ("ground.A", "crank.in"),
        "B": ("crank.out", "coupler.in"),
        "C": ("coupler.out", "rocker.in"),
        "D": ("rocker.out", "ground.D"),
    }
    return fmb.Model(
        bodies=[fmb.Ground(markers={"A": fmb.Pose(tuple(BEGIN), axes[0]), "D": fmb.Pose(tuple(END), axes[3])}), *links],
        joints=[(fmb.Spherical if ball and n == "C" else fmb.Revolute)(n, markers=p) for n, p in joints.items()],
        gravity=(0, 0, -9.81),
        sensors=[fmb.Position("place", marker="coupler.out"), fmb.Reaction("reaction", joint="A")],
    )


def places(angle: float, centres) -> np.ndarray:
    """Return x, z and tilt (3, 3) of the links: the coupler's end is on circles about the crank's pin and the hinge."""
    arm, coupler, rocker = (np.linalg.norm(last - first) for first, last in PINS.values())
    pin = arm * np.array([np.cos(angle), np.sin(angle)])
    across = END[[0, 2]] - pin
    d = np.linalg.norm(across)
    along = (coupler**2 - rocker**2 + d**2) / (2 * d)
    up = np.array([-across[1], across[0]]) / d
    end = pin + along * across / d + np.sqrt(coupler**2 - along**2) * up
    ways = zip(centres.values(), (np.zeros(2), pin, end), (pin, end, END[[0, 2]]), strict=True)
    return np.array([(*(a + share * (b - a)), np.arctan2(*(b - a)[::-1])) for share, a, b in ways])


def lagrange(angle: float, masses, inertia: float, centres) -> tuple[float, float]:
    """Return the moment of gravity about the crank's angle, N m, and the inertia of all links for it, kg m2."""
    h = 1e-5
    speeds = (places(angle + h, centres) - places(angle - h, centres)) / (2 * h)
    squares = speeds[:, 0] ** 2 + speeds[:, 1] ** 2 + inertia * speeds[:, 2] ** 2
    return -9.81 * float(masses @ speeds[:, 1]), float(masses @ squares)


DRAWN = float(np.arctan2(CRANK[2], CRANK[0]))
LINKS = [
    *(((mass,) * 3, share, LUMPED) for share in (1e-8, 1e-11, 1e-13, 0.0) for mass in (1.0, 1e-9)),
    *(
        (masses, 0.02, MIDDLE)
        for light in (1e-7, 1e-9, 1e-12)
        for masses in ((light, 1, 1), (1, light, 1), (1, 1, light))
    ),
    ((1.0, 1e-9, 1e-9), 0.02, MIDDLE),
]


@pytest.mark.parametrize("ball", [False, True])
@pytest.mark.parametrize(("masses", "share", "centres"), LINKS)
def test_loops_of_lumped_masses_and_dummy_parts(masses, share, centres, ball):
    """A rocker with its mass at its hinge, or of 1e-9 of the others' mass, hardly resists, and the loop closes."""
    model = four_bar(masses, share, centres, ball)
    assert fmb.check(model).mobility == 1
    moment, whole = lagrange(DRAWN, np.array(masses), share, centres)
    for formulation in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Recursive()):
        found = fmb.accelerations(model, formulation=formulation)
        np.testing.assert_allclose(-found["crank"][4], moment / whole, rtol=1e-5, err_msg=str(formulation))


@pytest.mark.parametrize("mass", [1e-8, 1e-10, 1e-11])
@pytest.mark.parametrize("place", range(3))
def test_a_dummy_part_between_axes_of_a_mesh_file(mass, place):
    """Axes that are parallel to seven digits are parallel beside a part without weight as well.

    Least squares of all equations at once have the square of what their gradients differ by: they lost the crank.
    """
    masses = np.where(np.arange(3) == place, mass, 1.0)
    model = four_bar(masses, 0.02, MIDDLE, tilt=1e-7)
    assert fmb.check(model).mobility == 1
    moment, whole = lagrange(DRAWN, masses, 0.02, MIDDLE)
    recursive = (fmb.Recursive(),) if mass > 1e-9 else ()  # beyond, it tells that no digit is left
    for formulation in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), *recursive):
        found = fmb.accelerations(model, formulation=formulation)
        np.testing.assert_allclose(-found["crank"][4], moment / whole, rtol=1e-5, err_msg=str(formulation))


INTEGRATORS = (
    fmb.GeneralizedAlpha(rtol=1e-8),
    fmb.IDA(rtol=1e-8),
    fmb.Implicit(rtol=1e-8),
    fmb.Explicit(rtol=1e-8, formulation=fmb.Recursive()),
)
STEADY = fmb.Explicit(rtol=1e-10, formulation=fmb.NullSpace())


@pytest.mark.parametrize("mass", [1.0, 1e-9])
def test_loops_of_lumped_masses_in_motion(mass):
    """One motion and one reaction by all integrators, also for masses that no other body gives a size."""
    exact = fmb.simulate(four_bar((1.0,) * 3, 0.0, LUMPED), 0.3, samples=4, integrator=STEADY)
    for share in (1e-9, 1e-12, 0.0):
        for integrator in INTEGRATORS:
            run = fmb.simulate(four_bar((mass,) * 3, share, LUMPED), 0.3, samples=4, integrator=integrator)
            what = f"{share}, {integrator}"
            np.testing.assert_allclose(run["place"], exact["place"], atol=2e-6, err_msg=what)
            np.testing.assert_allclose(run["reaction"] / mass, exact["reaction"], atol=5e-3, err_msg=what)


@pytest.mark.parametrize("ball", [False, True])
@pytest.mark.parametrize("masses", [(1.0, 1e-9, 1.0), (1.0, 1.0, 1e-9), (1e-9, 1.0, 1.0)])
def test_loops_with_dummy_parts_in_motion(masses, ball):
    """A part of 1e-9 of the others' mass changes nothing: one motion and one reaction by all integrators."""
    exact = fmb.simulate(four_bar(masses, 0.02, MIDDLE), 0.3, samples=4, integrator=STEADY)
    for integrator in INTEGRATORS:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            run = fmb.simulate(four_bar(masses, 0.02, MIDDLE, ball), 0.3, samples=4, integrator=integrator)
        np.testing.assert_allclose(run["place"], exact["place"], atol=2e-6, err_msg=str(integrator))
        np.testing.assert_allclose(run["reaction"][:, :3], exact["reaction"][:, :3], atol=5e-3, err_msg=str(integrator))


@pytest.mark.parametrize("masses", [(1.0, 1e-9, 1.0), (1.0, 1.0, 1e-9), (1e-9, 1.0, 1.0), (1.0, 1e-12, 1.0)])
def test_equilibrium_and_frequency_with_dummy_parts(masses):
    """A spring at the crank: the angle at which it holds the links, and how they swing, by Lagrange's equation."""
    stiffness, m = 50.0, np.array(masses)
    model = four_bar(masses, 0.02, MIDDLE)
    held = fmb.Model(
        bodies=model.bodies,
        joints=model.joints,
        forces=[fmb.TorsionSpring("spring", joint="A", stiffness=stiffness)],
        gravity=model.gravity,
        sensors=model.sensors,
    )

    def unbalanced(angle: float) -> float:
        return lagrange(angle, m, 0.02, MIDDLE)[0] - stiffness * (angle - DRAWN)

    angle = optimize.brentq(unbalanced, DRAWN - 0.3, DRAWN + 0.3, xtol=1e-12)
    slope = (unbalanced(angle + 1e-4) - unbalanced(angle - 1e-4)) / 2e-4
    expected = np.sqrt(-slope / lagrange(angle, m, 0.02, MIDDLE)[1]) / (2.0 * np.pi)
    rest = fmb.statics(held)
    pin = places(angle, {**MIDDLE, "coupler": 1.0})[1, :2]
    np.testing.assert_allclose(rest["place"][-1][[0, 2]], pin, atol=1e-8)
    np.testing.assert_allclose(fmb.linearize(held, about=rest).frequencies, [expected], rtol=1e-5)
    # the dummy part a thousand times heavier weighs nothing still
    grown = four_bar([max(x, 1e-6) for x in masses], 0.02, MIDDLE)
    beside = fmb.statics(
        fmb.Model(
            bodies=grown.bodies, joints=grown.joints, forces=held.forces, gravity=held.gravity, sensors=held.sensors
        )
    )
    np.testing.assert_allclose(rest["reaction"][-1], beside["reaction"][-1], atol=1e-4)


def held_crank(mass: float) -> fmb.Model:
    """A crank of 1 kg and 1 m that a rod between two balls holds level; the rod's mass lies beside its axis."""
    turned = (0.3, -0.5, 0.7)
    R = Rotation.from_rotvec(turned).as_matrix()
    along = (R.T @ np.array([0.96, 0.0, 0.28])).tolist()
    crank = fmb.RigidBody(
        "crank",
        mass=1.0,
        inertia=(0.01, 0.1, 0.1),
        center_of_mass=(0.5, 0, 0),
        markers={"hinge": fmb.Pose((0, 0, 0), ACROSS), "end": (1, 0, 0)},
    )
    rod = fmb.RigidBody(
        "rod",
        mass=mass,
        inertia=tuple(mass * x for x in (0.003, 0.005, 0.004)),
        center_of_mass=tuple(0.5 * np.array(along) + (0.02, 0.01, 0.0)),
        at=(1, 0, 0),
        rotation=turned,
        markers={"low": (0, 0, 0), "high": tuple(along)},
    )
    return fmb.Model(
        bodies=[fmb.Ground(markers={"hinge": fmb.Pose((0, 0, 0), ACROSS), "high": (1.96, 0, 0.28)}), crank, rod],
        joints=[
            fmb.Revolute("hinge", markers=("ground.hinge", "crank.hinge")),
            fmb.Spherical("low", markers=("crank.end", "rod.low")),
            fmb.Spherical("high", markers=("rod.high", "ground.high")),
        ],
        gravity=(0, 0, -9.81),
    )


@pytest.mark.parametrize("mass", [1e-6, 1e-9, 1e-10])
def test_a_light_rod_that_may_spin_holds_a_heavy_crank(mass):
    """The crank rests, and the ball above carries half its weight, upright, with what goes along the rod.

    The last digit of that force spins the rod much. Such solutions were refused, and what was tried next let it fall.
    """
    model = held_crank(mass)
    for formulation in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Recursive()):
        found = fmb.accelerations(model, formulation=formulation)
        assert np.abs(found["crank"]).max() < 1e-7, formulation
        np.testing.assert_allclose(np.abs(found.reactions["high"][2]), 0.5 * 9.81, rtol=1e-5, err_msg=str(formulation))


@pytest.mark.parametrize("mass", [1.0, 1e-7, 1e-9])
@pytest.mark.parametrize("length", [1.0, 1e-6, 1e3])
def test_reactions_of_a_light_part_in_any_unit(mass, length):
    """A telescope between two balls, 2 m apart in units of a length: they carry its heavy tube by the lever rule.

    In micrometres, with a rod of 1e-9 kg, two formulations had found no reactions at all.
    """
    slide = Rotation.align_vectors([(1.0, 0.4, 0.3)], [(0.0, 0.0, 1.0)])[0].as_matrix()
    rod = fmb.RigidBody(
        "rod",
        mass=mass,
        inertia=(0.1 * mass * length**2,) * 3,
        markers={"ball": (0, 0, 0), "slide": fmb.Pose((0.8 * length, 0, 0), slide)},
    )
    tube = fmb.RigidBody(
        "tube",
        mass=1.0,
        inertia=(0.1 * length**2,) * 3,
        at=(1.5 * length, 0, 0),
        markers={"slide": fmb.Pose((-0.7 * length, 0, 0), slide), "ball": (0.5 * length, 0, 0)},
    )
    joints = {"A": ("ground.A", "rod.ball"), "B": ("tube.ball", "ground.B")}
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"A": (0, 0, 0), "B": (2 * length, 0, 0)}), rod, tube],
        joints=[
            fmb.Prismatic("slide", markers=("rod.slide", "tube.slide")),
            *(fmb.Spherical(name, markers=pair) for name, pair in joints.items()),
        ],
        gravity=(0, 0, -9.81),
    )
    for formulation in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Recursive()):
        found = fmb.accelerations(model, formulation=formulation)
        upright = [np.abs(found.reactions[name][2]) for name in joints]
        np.testing.assert_allclose(upright, [9.81 * (0.25 + mass), 9.81 * 0.75], rtol=1e-5, err_msg=str(formulation))


def two_parallelograms(ship: float) -> fmb.Model:
    """Three cranks and two couplers, which pass a line within a second, and a heavy body that floats elsewhere."""
    pins = [np.array([float(k), 0.0, 0.0]) for k in range(3)]
    arm = 0.5 * np.array([np.cos(0.9), 0.0, np.sin(0.9)])
    ends = {f"crank{k}": (pins[k], pins[k] + arm) for k in range(3)}
    ends |= {f"coupler{k}": (pins[k] + arm, pins[k + 1] + arm) for k in range(2)}
    bodies = []
    for name, (first, last) in ends.items():
        half = 0.5 * (last - first)
        places = {"in": fmb.Pose(tuple(-half), ACROSS), "out": fmb.Pose(tuple(half), ACROSS)}
        bodies.append(fmb.RigidBody(name, mass=1.0, inertia=(0.02,) * 3, at=tuple(first + half), markers=places))
    joints = {f"A{k}": (f"ground.{k}", f"crank{k}.in") for k in range(3)}
    for k in range(2):
        joints |= {f"B{k}": (f"crank{k}.out", f"coupler{k}.in"), f"C{k}": (f"coupler{k}.out", f"crank{k + 1}.out")}
    return fmb.Model(
        bodies=[
            fmb.Ground(markers={str(k): fmb.Pose(tuple(pin), ACROSS) for k, pin in enumerate(pins)}),
            *bodies,
            fmb.RigidBody("ship", mass=ship, inertia=(ship,) * 3, at=(0, 50, 0)),
        ],
        joints=[fmb.Revolute(name, markers=pair) for name, pair in joints.items()],
        gravity=(0, 0, -9.81),
        sensors=[fmb.Position("place", marker="coupler1.out")],
    )


@pytest.mark.parametrize("integrator", [fmb.Explicit(formulation=fmb.Recursive()), fmb.Implicit()])
def test_a_heavy_body_that_no_joint_joins_is_no_measure(integrator):
    """Near a line of links, thresholds decide which equations hold: 1e9 kg elsewhere do not change them."""
    runs = [fmb.simulate(two_parallelograms(ship), 2.0, samples=21, integrator=integrator) for ship in (1e3, 1e9)]
    np.testing.assert_allclose(runs[0]["place"], runs[1]["place"], atol=1e-9)
