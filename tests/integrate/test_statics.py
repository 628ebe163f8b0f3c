"""Equilibria under loads that are small beside the stiffness of other directions."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import IntegrationError
from flexmb.integrate.equilibria.descent import Descent
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
