"""Equilibria under loads that are small beside the stiffness of other directions."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import IntegrationError
from flexmb.integrate.equilibria import descent
from flexmb.integrate.equilibria.descent import Descent
from flexmb.integrate.equilibria.path import EquilibriumPath, Point
from flexmb.integrate.linear.steady import saddle, steady_motion
from flexmb.integrate.matrices import tangent_at
from flexmb.system import assemble_as_drawn

SIDE, THICKNESS = 1.0, 0.005
STEEL = fmb.MATERIALS["steel"]


def pinned_plate(load, **fields):
    """A square plate on pins at the nodes of all edges."""
    plate = fmb.AncfPlate.rectangle(
        "p",
        edges=(SIDE, SIDE),
        elements=(2, 2),
        thickness=THICKNESS,
        material=STEEL,
        markers={"mid": (0.5, 0.5)},
        **fields,
    )
    nodes = [(s, t) for s in (0.0, 0.5, 1.0) for t in (0.0, 0.5, 1.0) if (s, t) != (0.5, 0.5)]
    pins = {f"pin_{k}": place for k, place in enumerate(nodes)}
    ground = fmb.Ground(markers={name: (SIDE * s, SIDE * t, 0.0) for name, (s, t) in pins.items()})
    joints = [fmb.Spherical(name, markers=(f"ground.{name}", f"p.{name}")) for name in pins]
    return fmb.Model(
        bodies=[ground, plate.replaced(markers={**plate.markers, **pins})],
        joints=joints,
        forces=[fmb.Pressure("load", load="p.load_z", amount=load)],
        sensors=[fmb.Position("mid", marker="p.mid"), *(fmb.Reaction(j.name, joint=j.name) for j in joints)],
    )


@pytest.mark.parametrize("shear", [False, True])
def test_light_loads_on_a_thin_plate(shear):
    """The reactions carry the load, however small it is, and the deflection is in proportion.

    The last digits of the coordinates in the plane make larger forces than the load across it.
    """
    deflections = []
    for load in (1.0, 1e-3, 1e-6):
        solution = fmb.statics(pinned_plate(load, shear=shear))
        carried = -sum(solution[f"pin_{k}"][-1, 2] for k in range(8))
        assert carried == pytest.approx(load * SIDE**2, rel=1e-8)
        deflections.append(solution["mid"][-1, 2] / load)
    assert deflections == pytest.approx([deflections[0]] * 3, rel=1e-6)


def test_equilibrium_without_load_stays_where_it_is():
    """A mass on a prestressed spring that hangs in balance, free to turn: rounding is no reason to move it."""
    mass, stiffness, g = 0.3, 7e6, 9.81
    hung = fmb.RigidBody("b", mass=mass, inertia=(0.1, 0.1, 0.1), at=(1 / 3, 0.0, -0.7 - mass * g / stiffness))
    model = fmb.Model(
        gravity=(0, 0, -g),
        bodies=[fmb.Ground(markers={"A": (1 / 3, 0.0, 0.0)}), hung],
        forces=[fmb.SpringDamper("s", markers=("ground.A", "b.center"), stiffness=stiffness, length=0.7)],
        sensors=[fmb.Position("x", marker="b.center"), fmb.Orientation("p", marker="b.center")],
    )
    solution = fmb.statics(model)
    np.testing.assert_allclose(solution["x"][-1], hung.at, atol=1e-12)
    np.testing.assert_allclose(solution["p"][-1], (1, 0, 0, 0), atol=1e-12)


def test_a_mechanism_that_nothing_holds_is_named():
    """A wheel on a hinge with a constant moment, beside a rod that a spring holds: only the wheel turns away."""
    wheel = fmb.RigidBody("wheel", mass=1.0, inertia=(0.1, 0.1, 0.1))
    block = fmb.PointMass("block", mass=1.0, at=(0.5, 0, 0))
    model = fmb.Model(
        name="open",
        bodies=[fmb.Ground(), wheel, block],
        joints=[fmb.Revolute("axle", markers=("ground.origin", "wheel.center"))],
        forces=[
            fmb.PointLoad("turn", marker="wheel.center", moment=(0, 0, 5.0)),
            fmb.SpringDamper("s", markers=("ground.origin", "block.center"), stiffness=100.0, length=0.5),
        ],
        gravity=(0, 0, 0),
    )
    with pytest.raises(
        fmb.IntegrationError, match=r"had moved Body 'wheel', rotation about its z-axis, by .* rad: perh"
    ):
        fmb.statics(model)


@pytest.mark.parametrize("lowest", [0.1, 0.5])
def test_equations_that_end_on_the_way_to_equilibrium(lowest):
    """1 kg on 20 N/m comes to rest 0.4905 m down: before that a root of what is negative, or just not."""
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"up": (0.5, 0, 0.5)}), fmb.PointMass("q", mass=1.0, at=(0.5, 0, 0))],
        joints=[
            fmb.Constraint(
                f"c{k}",
                over=[fmb.Position("p", marker="q.center")],
                equation=f"p[{k}] = {0.5 - 0.5 * k} + 0*sqrt(p[2] + {lowest})",
            )
            for k in (0, 1)
        ],
        forces=[fmb.SpringDamper("s", markers=("ground.up", "q.center"), stiffness=20.0, length=0.5)],
        sensors=[fmb.Position("place", marker="q.center")],
    )
    if lowest > 0.4905:
        assert fmb.statics(model)["place"][-1, 2] == pytest.approx(-0.4905, abs=1e-6)
        return
    with pytest.raises(IntegrationError, match=r"numbers end because of equation 'c0: Formula'.*residual nan"):
        fmb.statics(model)


def test_a_search_that_is_lost():
    """It is where a place is a million sizes away, or a force has no value."""
    slider = fmb.RigidBody("slider", mass=1.0, inertia=(1.0, 1.0, 1.0), at=(0.3, 0.0, 0.0))
    model = fmb.Model(
        bodies=[fmb.Ground(), slider], forces=[fmb.PointLoad("push", marker="slider.center", force=(1.0, 0.0, 0.0))]
    )
    system, start = assemble_as_drawn(model)
    search = Descent(system, start, system.workspace(), 0.0, start.q.copy(), at_rest=False, wary=False, smooth=True)
    search.balanced(1e-9)
    assert not search.lost()
    search.q[0] = 1.1e6
    assert search.lost()
    search.q[0] = 0.3
    assert not search.lost()
    search.unbalanced = np.nan
    assert search.lost()


@pytest.mark.parametrize("stiffness", [1e3, 1e6, 1e9])
@pytest.mark.parametrize("stretched", [0.0, 0.1])
def test_a_stretched_stiff_spring_at_the_start(stiffness, stretched):
    """Beside its force any other is small; when it has gone, the weight still hangs at m g / k below."""
    body = fmb.RigidBody("b", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(stretched, 0.3, -0.2), rotation=(0.3, 0.2, 0.1))
    bushing = fmb.Bushing(
        "s",
        markers=("ground.origin", "b.center"),
        stiffness=(stiffness, 10.0, 10.0, 0.5, 0.5, 0.5),
        damping=np.zeros(6),
    )
    place = fmb.Position("place", marker="b.center")
    model = fmb.Model(gravity=(0, 0, -9.81), bodies=[fmb.Ground(), body], forces=[bushing], sensors=[place])
    np.testing.assert_allclose(fmb.statics(model)["place"][-1], (0.0, 0.0, -0.981), rtol=0.0, atol=1e-9)


def hanging_bar():
    """A bar on a hinge, beside its equilibrium."""
    bar = fmb.RigidBody("bar", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(0.3, 0.0, 0.0), markers={"a": (-0.3, 0.0, 0.0)})
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), bar],
        joints=[fmb.Revolute("h", markers=("ground.origin", "bar.a"))],
    )
    return assemble_as_drawn(model)


def test_reactions_of_a_move_that_led_nowhere_balance_nothing():
    """Forces are compared with those at the same place, not with the largest of the search."""
    system, start = hanging_bar()
    search = Descent(system, start, system.workspace(), 0.0, start.q.copy(), at_rest=False, wary=False, smooth=True)
    assert not search.balanced(1e-9)
    search.lam = np.full(system.ng, 1e20)
    assert not search.balanced(1e-9)
    search.lam = np.zeros(system.ng)
    assert not search.balanced(1e-9)


def test_corrections_of_a_path_that_led_nowhere_balance_nothing():
    """Likewise on a path: the hinge carries the weight at the point that is found."""
    system, start = hanging_bar()
    path = EquilibriumPath(system, start, 1.0, 1e-9)
    up = np.zeros(system.nu + system.ng + 1)
    up[-1] = 1.0
    path._linearised(start.q, np.full(system.ng, 1e20), 0.0, up)
    down = start.q.copy()
    down[:7] = 0.0, -0.3, 0.0, np.sqrt(0.5), 0.0, 0.0, -np.sqrt(0.5)
    point = path.solve(Point(down, np.zeros(system.ng), 0.0, up, 0.0), 0.0)
    assert np.linalg.norm(point.lam[:3]) == pytest.approx(9.81, rel=1e-6)


def test_a_search_in_which_numbers_end_is_lost(monkeypatch):
    """It ends by name, whatever cannot be solved on the way."""
    calls = []

    def ends(*given, **known):
        calls.append(given)
        if len(calls) > 1:
            raise RuntimeError("Factor is exactly singular")
        return steady_motion(*given, **known)

    monkeypatch.setattr(descent, "steady_motion", ends)
    system, _ = hanging_bar()
    with pytest.raises(IntegrationError, match="the search has left all bounds"):
        fmb.statics(system.model)


def test_how_soft_dependent_equations_are_in_any_unit_of_length():
    """Lengths per force and angles per moment, of a hinge: a mass and an inertia count, not what a length is called."""
    found = []
    for length in (1.0, 1e-6, 1e6):
        bar = fmb.RigidBody(
            "bar",
            mass=1.0,
            inertia=np.full(3, 0.1 * length**2),
            at=(0.3 * length, 0, 0),
            markers={"a": (-0.3 * length, 0, 0)},
        )
        hinge = fmb.Revolute("h", markers=("ground.origin", "bar.a"))
        system, start = assemble_as_drawn(fmb.Model(bodies=[fmb.Ground(), bar], joints=[hinge]))
        tangent, are_lengths = tangent_at(system, start, system.workspace()), system.lengths.are_lengths
        soft = -saddle(tangent.M, tangent.L, tangent.G, 1e-12, are_lengths).diagonal()[system.nu :]
        found.append(soft * np.where(are_lengths, 1.0, length**2))
    assert np.count_nonzero(are_lengths) == 3
    np.testing.assert_allclose(found[1:], [found[0]] * 2, rtol=1e-9)


@pytest.mark.parametrize("length", [1.0, 1e-6, 1e6])
def test_an_arm_that_stretches_a_bar_in_any_unit_of_length(length):
    """It turns at 0.1 rad/s with the end of a bar whose other end is held: nothing rigid satisfies all joints."""
    ends = fmb.Ground(markers={"a": (0, 0, 0), "b": (0.4 * length, 0.4 * length, 0)})
    tip = {"m": (0, 0.4 * length, 0)}
    arm = fmb.RigidBody("arm", mass=1.0, inertia=np.full(3, 0.1 * length**2), markers={"o": (0, 0, 0), **tip})
    bar = fmb.FloatingBody("bar", data=steel_bar().rescaled(length=length), at=tip["m"])
    model = fmb.Model(
        bodies=[ends, arm, bar],
        joints=[
            fmb.Revolute("hinge", markers=("ground.a", "arm.o")),
            fmb.Drive("drive", joint="hinge", angle=fmb.expression("0.1*sin(t)")),
            fmb.Revolute("tip", markers=("arm.m", "bar.a")),
            fmb.Spherical("end", markers=("ground.b", "bar.b")),
        ],
    )
    system, start = assemble_as_drawn(model)
    work = system.workspace()
    u = steady_motion(system, start, work).u
    tangent = tangent_at(system, start, work)
    left = (tangent.G @ u + work.equations["rate"]) / system.lengths.equations
    assert np.abs(left).max() < 1e-6


def steel_bar():
    """A slender bar between its ends."""
    fe = fem.frame(
        points=np.column_stack([np.linspace(0.0, 0.4, 7), np.zeros((7, 2))]),
        section=fem.Section.rectangle(0.02, 0.01),
        material=STEEL,
    )
    return reduction.reduce(fe, interfaces={"a": [0], "b": [6]}, modes=3)
