"""What comes before a run of a tree costs as many calls as there are links: counted, not timed."""

import cProfile
import pstats

import numpy as np
import pytest
from tree.models import chain, flexible_chain

import flexmb as fmb
from flexmb import fem, reduction


def star(n: int) -> fmb.Model:
    """Return a hub with n arms."""
    places = {f"m{k}": (np.cos(k), np.sin(k), 0.01 * k) for k in range(n)}
    hub = fmb.RigidBody("hub", mass=10.0, inertia=(5, 5, 6), markers=places)
    arms = [
        fmb.RigidBody.rod(f"b{k}", length=1.0, mass=1.0, radius=0.05, at=at) for k, at in enumerate(places.values())
    ]
    joints = [fmb.Revolute(f"j{k}", markers=(f"hub.m{k}", f"b{k}.start")) for k in range(n)]
    return fmb.Model(bodies=[fmb.Ground(), hub, *arms], joints=joints)


def fed_back(n: int) -> fmb.Model:
    """Return a chain whose every hinge has a spring, a sensor, and a motor that follows the sensor."""
    springs = [fmb.TorsionSpring(f"s{k}", joint=f"j{k}", stiffness=1.0) for k in range(n)]
    motors = [fmb.Actuator(f"m{k}", joint=f"j{k}", effort=-1.0 * fmb.measured(f"q{k}")) for k in range(n)]
    sensors = [fmb.JointCoordinate(f"q{k}", joint=f"j{k}") for k in range(n)]
    return chain(n, forces=[*springs, *motors], sensors=sensors)


def driven(n: int) -> fmb.Model:
    """Return a chain with a drive on every hinge, read by sensors."""
    drives = [fmb.Drive(f"d{k}", joint=f"j{k}", angle=fmb.ramp(rate=0.1)) for k in range(n)]
    sensors = [fmb.JointCoordinate(f"q{k}", joint=f"j{k}") for k in range(n)]
    return chain(n, sensors=sensors).with_parts(joints=drives)


def calls(of, model: fmb.Model) -> int:
    """Return how many calls a function of a model takes."""
    counted = cProfile.Profile()
    counted.enable()
    of(model)
    counted.disable()
    return pstats.Stats(counted).total_calls


def described(model: fmb.Model) -> None:
    """Describe a model in joint coordinates, with all tables and a product."""
    tree = fmb.JointTree(model)
    tree.bias(tree.start.q, tree.start.v)


def begun(model: fmb.Model) -> None:
    """Begin a run, with what watches over it."""
    fmb.simulate(model, 1e-9, samples=2, formulation=fmb.Recursive())


@pytest.mark.parametrize("make", [chain, flexible_chain, star, fed_back, driven], ids=lambda make: make.__name__)
def test_four_times_the_links_take_four_times_the_calls(make):
    calls(described, make(2))
    few, more = calls(described, make(60)), calls(described, make(240))
    assert more / few < 4.1


def left_out(n: int) -> fmb.Model:
    """Return a chain of beams whose loads are compared with those that would change their stiffness."""
    points = np.column_stack([np.linspace(0.0, 1.0, 3), np.zeros((3, 2))])
    fe = fem.frame(points, section=fem.Section.rectangle(0.02, 0.03), material=fmb.MATERIALS["steel"])
    data = reduction.reduce(fe, {"root": [0], "tip": [2]}, 1, compare=0)
    bodies = [fmb.FloatingBody(f"b{k}", data=data, at=(k, 0, 0)) for k in range(n)]
    ends = ["ground.origin", *(f"b{k}.tip" for k in range(n))]
    joints = [fmb.Revolute(f"j{k}", markers=(ends[k], f"b{k}.root")) for k in range(n)]
    return fmb.Model(bodies=[fmb.Ground(), *bodies], joints=joints)


@pytest.mark.parametrize("make", [chain, left_out], ids=lambda make: make.__name__)
def test_runs_of_four_times_the_links_begin_with_four_times_the_calls(make):
    calls(begun, make(2))
    few, more = calls(begun, make(30)), calls(begun, make(120))
    assert more / few < 4.1


def test_alike_flexible_bodies_share_their_constants():
    """A chain of equal beams keeps the numbers of one; damping of its own makes a body another one."""
    tree = fmb.JointTree(flexible_chain(5))
    one = fmb.JointTree(flexible_chain(1))
    flexible = tree.invertible_links.flexible
    assert len(flexible.constants) == len(one.invertible_links.flexible.constants)
    model = flexible_chain(2)
    other = model.changed("f1", damping=0.5)
    here, there = (fmb.JointTree(m) for m in (model, other))
    v = np.ones(len(here.rate_names)) * np.array([1e-2 * (".mode_" in name) for name in here.rate_names])
    last = np.array([name.startswith("f1.") for name in here.rate_names])
    difference = there.bias(there.start.q, v) - here.bias(here.start.q, v)
    D = [m.body("f1").damping_matrix() for m in (model, other)]
    np.testing.assert_allclose(difference[last], ((D[1] - D[0]) @ v[last]), rtol=1e-9)
