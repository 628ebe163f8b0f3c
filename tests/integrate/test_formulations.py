"""Formulations as objects: every one has `.accelerate`, `simulate` takes one, and says when it cannot use it."""

from dataclasses import replace

import numpy as np
import pytest
from metamorphic.analyses import analysed, worst_difference
from metamorphic.flexible_trees import flexible_tree
from metamorphic.seen import Seen
from verification import mechanisms

import flexmb as fmb
from flexmb import fem
from flexmb.integrate.matrices import equations_at
from flexmb.system import assemble

FORMULATIONS = (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Recursive())


def pendulum(**fields):
    rod = fmb.RigidBody.rod("rod", length=1.0, mass=1.0)
    joint = fmb.Revolute("pin", markers=("ground.origin", "rod.start"))
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[fmb.Ground(), rod], joints=[joint], **fields)


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=repr)
def test_a_pendulum_falls(formulation):
    """Uniform rod from the horizontal: 3 g / (2 L)."""
    found = fmb.accelerations(pendulum(), formulation=formulation)["rod"]
    np.testing.assert_allclose(found, (0, 0, 0, 0, 0, -1.5 * 9.81), atol=1e-9)


@pytest.mark.parametrize("formulation", FORMULATIONS, ids=repr)
def test_simulate_takes_a_formulation(formulation):
    model = pendulum(sensors=[fmb.JointCoordinate("angle", joint="pin")])
    expected = fmb.simulate(model, 0.5, integrator=fmb.Explicit(), samples=3)["angle"]
    found = fmb.simulate(model, 0.5, formulation=formulation, samples=3)["angle"]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_a_formulation_beside_an_integrator_is_refused():
    with pytest.raises(fmb.ModelError, match=r"both an integrator.*integrator=Explicit"):
        fmb.simulate(pendulum(), 1.0, integrator=fmb.GeneralizedAlpha(), formulation=fmb.Recursive())


def test_what_is_no_formulation_is_refused():
    with pytest.raises(fmb.ModelError, match=r"formulation = 'recursive'.*Recursive\(\)"):
        fmb.Explicit(formulation="recursive")


def test_baumgarte_pulls_back_a_drifted_state():
    """g'' = -2 alpha g' - beta^2 g, Baumgarte 1972."""
    system, start = assemble(pendulum())
    q, u = start.q.copy(), start.u.copy()
    q[:3] += (0.01, 0.02, 0.0)
    u[:3] += (0.3, -0.1, 0.2)
    state, work = system.state(0.0, q, u), system.workspace()
    alpha, beta = 3.0, 7.0
    a, _ = fmb.Baumgarte(fmb.NullSpace(), alpha=alpha, beta=beta).accelerate(system, state, work)
    from flexmb.integrate.matrices import equations_at

    e = equations_at(system, state, work)
    np.testing.assert_allclose(e.G @ a - e.b, -2 * alpha * e.velocity - beta**2 * e.position, atol=1e-10)


def test_a_large_model_in_a_singular_position():
    """Twelve four-bars with all bars in one line, 335 unknowns:
    Augmented softens what depends, and agrees with the others.
    """
    model = mechanisms.four_bars(12)
    bars = [
        b.replaced(rotation=(0, 0, 0))
        if b.name[0] == "c"
        else b.replaced(at=(int(b.name[1:]) + 1, 0, 0), velocity=(0, -1, 0))
        for b in model.bodies[1:]
    ]
    system, start = assemble(replace(model, bodies=(model.bodies[0], *bars)))
    equations = equations_at(system, start, system.workspace())
    assert len(system.redundant) == 48  # twelve more than in other positions
    a, lam = fmb.Augmented().solve(equations)
    for formulation in (fmb.UdwadiaPhohomsiri(), fmb.NullSpace()):
        expected, multipliers = formulation.solve(equations)
        np.testing.assert_allclose(a, expected, atol=1e-9)
        np.testing.assert_allclose(lam, multipliers, atol=1e-6)


@pytest.mark.parametrize("formulation", [fmb.NullSpace(), fmb.UdwadiaPhohomsiri()], ids=repr)
@pytest.mark.parametrize("length", [1.0, 1e-3])
def test_an_equation_of_rounding_moves_nothing(formulation, length):
    """The twist of a clamped cable about its tangent: its gradient is 1e-16 in skew axes, and that has no direction."""
    along = length * np.array([1.0, 2.0, 3.0]) / 14**0.5
    rope = fmb.AncfCable(
        "rope",
        points=[(0, 0, 0), tuple(along)],
        elements=4,
        section=fem.Section.solid_circle(0.01 * length),
        material=fmb.Material(young=1e9, poisson=0.3, density=1000.0),
    )
    bodies = [fmb.Ground(), rope]
    free, start = assemble(fmb.Model(bodies=bodies))
    work = free.workspace()
    equations_at(free, start, work)
    R = work.markers[free.marker_index["rope.start"]]["R"]
    clamp = fmb.Ground(markers={"clamp": fmb.Pose.axes(x=tuple(R[:, 0]), z=tuple(R[:, 2]))})
    joint = fmb.Fixed("clamp", markers=("ground.clamp", "rope.start"))
    system, start = assemble(fmb.Model(bodies=[clamp, rope], joints=[joint], gravity=(0, 0, -9.81)))
    whole = equations_at(system, start, system.workspace())
    (idle,) = np.flatnonzero(np.abs(whole.G).max(axis=1).toarray().ravel() < 1e-12)
    expected, multipliers = formulation.solve(replace(whole, dependent=np.array([idle])))
    unknown = replace(whole, dependent=np.zeros(0, int), b=np.where(np.arange(system.ng) == idle, 1e-14, whole.b))
    a, lam = formulation.solve(unknown)
    np.testing.assert_allclose(a, expected, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(lam, multipliers, atol=1e-6 * np.abs(multipliers).max())


def shelf(sides: int) -> fmb.Model:
    """A plate of 7.645 kg on so many equal pins in a row along y, which hold it in all directions."""
    at = np.column_stack([np.zeros(sides), np.linspace(-0.3, 0.3, sides), np.zeros(sides)])
    markers = {f"p{k}": tuple(x) for k, x in enumerate(at)}
    return fmb.Model(
        name="shelf",
        gravity=(0, 0, -9.81),
        bodies=[
            fmb.Ground(markers=markers),
            fmb.RigidBody("plate", mass=75.0 / 9.81, inertia=(0.3, 0.2, 0.5), markers=markers),
        ],
        joints=[fmb.Fixed(f"pin {k}", markers=(f"ground.p{k}", f"plate.p{k}")) for k in range(sides)],
        sensors=[fmb.Reaction(f"force {k}", joint=f"pin {k}") for k in range(sides)],
    )


@pytest.mark.parametrize("sides", [2, 3])
def test_equal_supports_share_a_load_to_all_digits(sides):
    """75 N on two pins: 37.5 N each, in statics, in every formulation and in a run."""
    model = shelf(sides)
    share = 75.0 / sides
    still = fmb.statics(model)
    run = fmb.simulate(model, t_end=0.1, samples=3)
    for k in range(sides):
        assert still[f"force {k}"][-1, 2] == pytest.approx(share, rel=1e-12)
        np.testing.assert_allclose(run[f"force {k}"][:, 2], share, rtol=1e-12)
    for formulation in (fmb.Augmented(), fmb.NullSpace(), fmb.UdwadiaPhohomsiri(), fmb.Recursive()):
        reactions = fmb.accelerations(model, formulation=formulation).reactions
        found = [reactions[f"pin {k}"][2] for k in range(sides)]
        np.testing.assert_allclose(found, share, rtol=1e-12, err_msg=repr(formulation))


@pytest.mark.parametrize("formulation", [fmb.NullSpace(), fmb.UdwadiaPhohomsiri()], ids=repr)
@pytest.mark.parametrize(("length", "mass"), [(1.0, 1.0), (1.0, 1e-6), (1e-5, 1e-6), (1e5, 1e6)])
def test_closed_forms_in_other_units(formulation, length, mass):
    """Split beams of milligrams in a row: equations between rotations are larger than those between places by far."""
    seen = Seen(length=length, mass=mass)
    model = flexible_tree(60007, seen)
    expected, found = (analysed(model, how, seen) for how in ("Augmented", type(formulation).__name__))
    share, where = worst_difference(expected, found)
    assert share < 1e-9, where
