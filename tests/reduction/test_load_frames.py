"""Loads and preload act in the material, whatever the body frame: columns, strings, struts and closed surfaces."""

from dataclasses import replace

import numpy as np
import pytest
from contracts.random_models import random_state
from contracts.test_tangents import assert_tangent
from reduction.solids import STEEL, block

import flexmb as fmb
from flexmb import fem, reduction
from flexmb.errors import ReductionError
from flexmb.fem.surface_load import pressure_change, pressure_field

FRAMES = ["buckens", "a", "b"]
SIDE, LENGTH, ELEMENTS = 0.02, 2.0, 20
EI = STEEL.young * SIDE**4 / 12
ALONG = fmb.Pose.axes((LENGTH, 0.0, 0.0), z=(1.0, 0.0, 0.0))


def beam():
    points = np.linspace((0.0, 0.0, 0.0), (LENGTH, 0.0, 0.0), ELEMENTS + 1)
    section = fem.Section.rectangle(SIDE, SIDE)
    return fem.frame(points, section=section, material=STEEL, shear=False, rotary_inertia=False)


def reduced(frame, modes=10, **options):
    ends = {"a": "start", "b": "end"}
    return reduction.reduce(beam(), ends, modes=modes, frame=frame, geometric_stiffness=True, compare=0, **options)


def column(frame, turns_with):
    """A column under a line load of 1 N/m towards its foot."""
    load = reduction.LineLoad(list(range(ELEMENTS + 1)), (-1.0, 0.0, 0.0), turns_with=turns_with)
    return reduced(frame, loads={"weight": load})


def lowest(data, amount):
    """Square of the lowest eigenvalue of the column, clamped at its foot, in equilibrium with the load, N/m."""
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"foot": (0.0, 0.0, 0.0)}), fmb.FloatingBody("column", data=data)],
        joints=[fmb.Fixed("foot", markers=("ground.foot", "column.a"))],
        forces=[fmb.Pressure("weight", load="column.weight", amount=amount)],
    )
    values = np.asarray(fmb.linearize(model, about=fmb.statics(model).final).eigenvalues)
    return values[np.argsort(np.abs(values))[0]] ** 2, np.abs(values.real).max()


@pytest.mark.parametrize("frame", FRAMES)
def test_a_dead_line_load_buckles_the_column(frame):
    """q L^3 / EI = 7.837 (Greenhill's column under its own weight; Timoshenko & Gere, sec. 2.12)."""
    data, q = column(frame, None), EI / LENGTH**3
    below, above = (lowest(data, f * 7.837 * q)[0].real for f in (0.98, 1.02))
    assert below < 0.0 < above
    critical = 0.98 + 0.04 * below / (below - above)
    assert critical == pytest.approx(1.0, abs=1.5e-3)


@pytest.mark.parametrize("frame", FRAMES)
def test_a_follower_line_load_makes_the_column_flutter(frame):
    """q L^3 / EI = 40.05, without buckling before (Leipholz's column; Leipholz, Stability of Elastic Systems, 1980)."""
    data, q = column(frame, "material"), EI / LENGTH**3
    for factor in (8.0, 39.6):
        square, growth = lowest(data, factor * q)
        assert square.real < 0.0
        assert growth < 1e-2
    assert lowest(data, 40.6 * q)[1] > 1.0


def hinged(data, **parts):
    return fmb.Model(
        bodies=[fmb.Ground(markers={"A": (0.0, 0.0, 0.0), "B": ALONG}), fmb.FloatingBody("strut", data=data)],
        joints=[
            fmb.Spherical("A", markers=("ground.A", "strut.a")),
            fmb.InLine("B", markers=("ground.B", "strut.b")),
        ],
        **parts,
    )


def tension_frequencies(tension):
    """w2 = (EI k4 + T k2) / mu of a string with bending stiffness on hinges."""
    k = np.pi / LENGTH * np.arange(1, 4)
    return np.sqrt((EI * k**4 + tension * k**2) / (STEEL.density * SIDE**2))


def frequencies(model, about=None):
    values = np.asarray(fmb.linearize(model, about=about).eigenvalues)
    assert np.abs(values.real).max() < 1e-2
    found = np.sort(np.abs(values.imag)[np.abs(values.imag) > 1.0])
    return found[np.append(True, np.diff(found) > 1e-4 * found[1:])]  # each once


PRELOADS = {
    "both ends": {0: (-1.0, 0.0, 0.0), ELEMENTS: (1.0, 0.0, 0.0)},
    "one end": {ELEMENTS: (1.0, 0.0, 0.0)},  # what holds it reacts
}


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("ends", PRELOADS)
@pytest.mark.parametrize("tension", [4e4, -2e3])
def test_a_preloaded_string(frame, ends, tension):
    data = reduced(frame, loads={"pull": reduction.NodalForces(PRELOADS[ends])}, preload={"pull": tension})
    np.testing.assert_allclose(frequencies(hinged(data))[:3], tension_frequencies(tension), rtol=3e-4)


@pytest.mark.parametrize("frame", FRAMES)
def test_a_strut_at_a_hinge_under_tension(frame):
    """17 MPa and 16 modes: the frame of the hinge has no mass to speak of, and its acceleration is not the body's."""
    tension = 17e6 * SIDE**2
    data = reduced(frame, modes=16)
    model = hinged(data, forces=[fmb.PointLoad("pull", marker="strut.b", force=(tension, 0.0, 0.0))])
    found = frequencies(model, fmb.statics(model).final)
    np.testing.assert_allclose(found[:3], tension_frequencies(tension), rtol=3e-4)
    free = frequencies(hinged(data))
    assert found[-1] == pytest.approx(free[-1], rel=0.05)


@pytest.mark.parametrize("frame", FRAMES)
def test_loads_of_all_frames_deflect_alike(frame):
    """A column near half its buckling load, a side load and a moment at its tip: the same statics across the line."""
    tip = np.array([-800.0, 6.0, 3.0, 0.5, -1.0, 2.0])
    responses = []
    for each in ("a", frame):
        data = reduced(each, loads={"tip": reduction.NodalForces({ELEMENTS: tip})})
        model = fmb.Model(
            bodies=[fmb.Ground(markers={"foot": (0.0, 0.0, 0.0)}), fmb.FloatingBody("column", data=data)],
            joints=[fmb.Fixed("foot", markers=("ground.foot", "column.a"))],
            forces=[fmb.Pressure("load", load="column.tip", amount=1.0)],
            sensors=[fmb.Position("tip", marker="column.b")],
        )
        responses.append(fmb.statics(model)["tip"][-1, 1:])
    assert np.linalg.norm(responses[0]) > 0.01
    np.testing.assert_allclose(responses[1], responses[0], atol=4e-3 * np.linalg.norm(responses[0]))


@pytest.mark.parametrize("frame", FRAMES)
def test_tangent_with_loads_and_preload(frame, rng):
    """The iteration matrix holds how loads turn and that inertia loads follow the mean motion."""
    loads = {
        "dead": reduction.LineLoad(list(range(ELEMENTS + 1)), (0.3, -1.0, 0.5)),
        "follower": reduction.NodalForces({3: (1.0, 2.0, -1.0, 0.2, 0.1, 0.3)}, turns_with="material"),
    }
    data = reduced(frame, modes=3, loads=loads, preload={"dead": 40.0, "follower": -30.0})
    model = fmb.Model(
        bodies=[
            fmb.FloatingBody(
                "b",
                data=data,
                rotation=rng.normal(size=3),
                velocity=(1.0, 2.0, -1.0),
                angular_velocity=(3.0, -2.0, 1.0),
            )
        ],
        forces=[
            fmb.Pressure(name, load=f"b.{name}", amount=amount) for name, amount in (("dead", 30.0), ("follower", 9.0))
        ],
    )
    assert_tangent(*random_state(model, rng))


def test_pressure_on_a_closed_surface_never_pushes():
    """Gas around a body has neither resultant nor moment, however the body is deformed."""
    data = reduction.reduce(block(), {"a": "left", "b": "right"}, modes=3, loads={"gas": "skin"}, compare=0)
    size = np.abs(data.load_turning).max()
    assert size > 0.0
    np.testing.assert_allclose(data.load_shapes[0, :6], 0.0, atol=1e-12)
    np.testing.assert_allclose(data.load_turning[0, :6], 0.0, atol=1e-9 * size)


def test_pressure_follows_its_surface(rng):
    """The change of the forces is their derivative by the positions of the nodes."""
    fe = block()
    facets, field, h = np.asarray(fe.facet_sets["top"], int), rng.standard_normal((len(fe.nodes), 6, 2)), 1e-4
    found = pressure_change(fe, facets, 2.0, field)
    for j in range(2):
        ahead, behind = (
            pressure_field(replace(fe, nodes=fe.nodes + sign * h * field[:, :3, j]), facets, 2.0)[:, :, 0]
            for sign in (1, -1)
        )
        np.testing.assert_allclose(found[:, :, j], (ahead - behind) / (2.0 * h), atol=1e-8 * np.abs(found).max())


def test_refused_turns():
    with pytest.raises(ReductionError, match=r"Load 'q': turns_with = 'bb'.*'material', or one of.*a, b.*mean 'b'"):
        reduced("a", loads={"q": reduction.LineLoad([0, 1], (0, 0, 1), turns_with="bb")})
    fe, pull = beam(), reduction.NodalForces({3: (1.0, 0.0, 0.0)})
    with pytest.raises(ReductionError, match=r"Preload of .*: the resultant .*Expected: forces in equilibrium, or an"):
        reduction.reduce(fe, {}, modes=4, geometric_stiffness=True, loads={"p": pull}, preload={"p": 2.0}, compare=0)
