"""Bullets of 1 mm against skins of 1 mm, whose single points they meet, and against one of a crowd: every integrator.

Reference: without friction and damping the energy of the bullet comes back from what does not move, whatever the places
of the points; of plates that bend, a run of IDA with a tolerance of 1e-8, and the energy as a whole.
"""

import itertools
import warnings

import numpy as np
import pytest
from by_turns import every_second, slow
from reduction.solids import block

import flexmb as fmb
from flexmb import reduction
from flexmb.forces import surface_contact

THICK, WIDE, R, MASS, DEEP = 1e-3, 4e-3, 5e-4, 4e-6, 3e-5
METHODS = {
    "alpha": lambda _: fmb.GeneralizedAlpha(follow_errors=False),
    "IDA": lambda _: fmb.IDA(),
    "explicit": lambda _: fmb.Explicit(),
    "implicit": lambda _: fmb.Implicit(follow_errors=False),
    "Moreau-Jean": lambda speed: fmb.MoreauJean(step=0.03 / speed),
}
FIXED = {
    "alpha": lambda span: fmb.GeneralizedAlpha(step=span / 60.0),
    "implicit": lambda span: fmb.Implicit(step=span / 60.0),
}
ENDS, MIDDLE_SPEED = (1.0, 1000.0), 30.0
"""m/s, of the range of speeds; what lies between is a long test."""
WAYS = {"straight": (0.0, 0.0, -1.0), "oblique": (0.02, 0.01, -1.0)}
DAILY = [
    ("alpha", 1.0, "straight"),
    ("alpha", 1000.0, "oblique"),
    ("IDA", 1.0, "oblique"),
    ("explicit", 1000.0, "oblique"),
    ("implicit", 1000.0, "straight"),
    ("Moreau-Jean", 1.0, "straight"),
]
"""Every method, speed and way; what lies between the speeds, and the other combinations, are long tests."""
OTHERS = [case for case in itertools.product(METHODS, ENDS, WAYS) if case not in DAILY]
MIDDLES = [slow(*case) for case in (*OTHERS, *itertools.product(METHODS, [MIDDLE_SPEED], WAYS))]
MIDDLE = (0.5 * WIDE + 1.3e-4, 0.5 * WIDE + 1.7e-4, THICK)


@pytest.fixture(scope="module")
def slab():
    """A block without modes, with the nodes in the middle of its upper and lower faces."""
    fe = block((WIDE, WIDE, THICK), (8, 8, 1))
    data = reduction.reduce(fe, interfaces={"root": np.flatnonzero(fe.nodes[:, 0] < 1e-9)}, modes=0)
    return data, np.flatnonzero(np.abs(fe.nodes[:, :2] - 0.5 * WIDE).max(axis=1) < 1.05e-3)


def bullet(speed, way, before, name="bullet", aside=0.0):
    """Return a bullet that is to go `before` (m, along the normal) until its middle would reach the plate."""
    direction = np.array(WAYS[way])
    at = np.array(MIDDLE) - before * direction + (0.0, aside, 0.0)
    return fmb.RigidBody(name, mass=MASS, inertia=(1e3 * MASS,) * 3, at=tuple(at), velocity=tuple(speed * direction))


def layer(speed):
    return fmb.ElasticFoundation(modulus=4e6 * speed**2, thickness=1e-3)


def against(plate, speed, way, before=0.0531, *, held=False):
    return fmb.Model(
        gravity=(0, 0, 0),
        bodies=[fmb.Ground(markers={"root": (0.0, 0.5 * WIDE, 0.5 * THICK)}), plate, bullet(speed, way, before)],
        joints=[fmb.Fixed("held", markers=("ground.root", "plate.root"))] if held else [],
        surfaces=[
            fmb.SkinSurface("plate", skin="plate.all"),
            fmb.Surface("ball", marker="bullet.center", shape=fmb.Sphere(R)),
        ],
        forces=[fmb.SurfaceContact("hit", surfaces=("ball", "plate"), law=layer(speed))],
        sensors=[fmb.Velocity("v", marker="bullet.center"), fmb.Energy("E")],
    )


def run(model, duration, integrator):
    with warnings.catch_warnings():
        warnings.simplefilter("error", fmb.ValidityWarning)
        return fmb.simulate(model, duration, samples=2, integrator=integrator)


@pytest.mark.parametrize(("method", "speed", "way"), [*DAILY, *MIDDLES])
def test_points_of_a_stiff_skin(slab, method, speed, way):
    """The speed comes back within 0.5 %."""
    data, near = slab
    plate = fmb.FloatingBody("plate", data=data, skins={"all": fmb.Skin(spacing=2e-4, nodes=near)})
    found = run(against(plate, speed, way, held=True), 0.08 / speed, METHODS[method](speed))["v"][-1]
    assert found[2] > 0.9 * speed
    assert np.linalg.norm(found) == pytest.approx(speed * np.linalg.norm(WAYS[way]), rel=5e-3)


@pytest.mark.parametrize(
    ("method", "speed"),
    [
        ("alpha", 1.0),
        slow("alpha", 30.0),
        ("alpha", 1000.0),
        slow("implicit", 1.0),
        slow("implicit", 30.0),
        slow("implicit", 1000.0),
    ],
)
def test_fixed_steps_on_a_stiff_skin(slab, method, speed):
    """A step of a sixtieth of the contact: within 1 %."""
    data, near = slab
    plate = fmb.FloatingBody("plate", data=data, skins={"all": fmb.Skin(spacing=2e-4, nodes=near)})
    model = against(plate, speed, "oblique", R + DEEP, held=True)
    found = run(model, 20.0 * DEEP / speed, FIXED[method](np.pi * DEEP / speed))["v"][-1]
    assert found[2] > 0.9 * speed
    assert np.linalg.norm(found) == pytest.approx(speed * np.linalg.norm(WAYS["oblique"]), rel=1e-2)


def sheet(speed):
    """Return a sheet of plate elements with its lower face on the ground plane of the block."""
    return fmb.AncfPlate.rectangle(
        "plate",
        edges=(WIDE, WIDE),
        corner=(0.0, 0.0, 0.5 * THICK),
        elements=(2, 2),
        thickness=THICK,
        material=fmb.Material(young=1e7 * speed**2, poisson=0.3, density=8000.0),
        skins={"all": fmb.Skin(spacing=2e-4)},
    )


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "way"), [(1.0, "oblique"), (30.0, "straight")])
def test_sheets_of_elements(speed, way):
    """A free sheet that bends under the bullet: the methods that have such bodies agree within 1 %, and keep energy."""
    model, span = against(sheet(speed), speed, way, R + 2.0 * DEEP), 30.0 * DEEP / speed
    closely = run(model, span, fmb.IDA(rtol=1e-8))["v"][-1]
    assert closely[2] > 0.0
    methods = (
        fmb.GeneralizedAlpha(follow_errors=False),
        fmb.GeneralizedAlpha(step=np.pi * DEEP / speed / 100.0),
        fmb.IDA(),
        fmb.MoreauJean(step=span / 3.0),
    )
    for method in methods:
        found = run(model, span, method)
        np.testing.assert_allclose(found["v"][-1], closely, atol=0.01 * speed, err_msg=repr(method))
        np.testing.assert_allclose(found["E"][-1].sum(), found["E"][0].sum(), rtol=0.02, err_msg=repr(method))


@pytest.mark.parametrize(("method", "speed", "law"), every_second(METHODS, [1.0, 1000.0], ["layer", "Hertz"]))
def test_bullets_of_a_crowd(method, speed, law, monkeypatch):
    """Four that strike one after the other: normal speeds come back within 1 %, and along the plate they stay."""
    monkeypatch.setattr(surface_contact, "MOST_PAIRS", 0)
    names = tuple(f"b{k}" for k in range(4))
    model = fmb.Model(
        gravity=(0, 0, 0),
        bodies=[
            fmb.Ground(),
            *(bullet(speed, "oblique", 0.0531 + 0.0011 * k, n, 0.004 * k) for k, n in enumerate(names)),
        ],
        surfaces=[
            fmb.Surface("plate", marker="ground.origin", shape=fmb.Cuboid(size=(0.2, 0.2, 2.0 * THICK))),
            *(fmb.Surface(n, marker=f"{n}.center", shape=fmb.Sphere(R), spacing=R / 2.5) for n in names),
        ],
        forces=[
            fmb.SurfaceContact(
                "hit",
                surfaces=("plate", names),
                law=layer(speed) if law == "layer" else fmb.Hertz(stiffness=1.25 * MASS * speed**2 / DEEP**2.5),
            )
        ],
        sensors=[fmb.Velocity(n, marker=f"{n}.center") for n in names],
    )
    found = run(model, 0.12 / speed, METHODS[method](speed))
    expected = speed * np.array(WAYS["oblique"]) * (1.0, 1.0, -1.0)
    for name in names:
        np.testing.assert_allclose(found[name][-1], expected, rtol=1e-2, atol=1e-4 * speed)
