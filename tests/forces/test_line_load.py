"""Loads per length on cables and beams against closed forms and the elastica."""

import numpy as np
import pytest
from contracts.random_models import derivative, moved
from scipy.integrate import solve_bvp, solve_ivp
from tolerances import SOLVER

import flexmb as fmb
from flexmb import fem
from flexmb.errors import ModelError
from flexmb.integrate.matrices import tangent_at
from flexmb.system import compile
from flexmb.system.program import evaluate

LENGTH, EI = 2.0, 50.0
KINDS = {"cable": fmb.AncfCable, "beam": fmb.AncfBeam}


def cantilever(kind, *, elements=8, stretch=(0.0, 1.0), body=None, **load):
    """A slender cantilever along x, stiff against stretch and shear, with a load per length."""
    young = 1e9
    area, inertia = 1e4 * EI / LENGTH**2 / young, EI / young
    line = KINDS[kind](
        "b",
        points=((0, 0, 0), (LENGTH, 0, 0)),
        elements=elements,
        stretches={"s": stretch},
        section=fem.Section.values(area, inertia, inertia, 2 * inertia),
        material=fmb.Material(young=young, poisson=0.0, density=1000.0),
        **(body or {}),
    )
    return fmb.Model(
        bodies=(fmb.Ground(), line),
        gravity=(0, 0, 0),
        joints=(fmb.Fixed("clamp", markers=("ground.origin", "b.start")),),
        forces=(fmb.LineLoad("q", stretch="b.s", **load),),
        sensors=(fmb.Position("tip", marker="b.end"), fmb.Reaction("root", joint="clamp")),
    )


@pytest.mark.parametrize("kind", KINDS)
def test_small_deflection(kind):
    """q L^4 / 8 EI at the tip; the clamp holds q L and q L^2 / 2."""
    q = 0.01
    solution = fmb.statics(cantilever(kind, force=(0, 0, fmb.expression("0.005 + t"))), t=0.005)
    assert solution["tip"][-1, 2] == pytest.approx(q * LENGTH**4 / (8 * EI), rel=2e-3)
    np.testing.assert_allclose(solution["root"][-1], [0, 0, -q * LENGTH, 0, 0.5 * q * LENGTH**2, 0], atol=1e-5 * q)


@pytest.mark.parametrize("kind", KINDS)
def test_stretch_that_ends_inside_elements(kind):
    """Resultant q (b - a) L at the middle of the stretch: what the clamp holds."""
    a, b, q = 0.2, 0.67, 0.02
    root = fmb.statics(cantilever(kind, stretch=(a, b), force=(0, q, 0)))["root"][-1]
    total = q * (b - a) * LENGTH
    np.testing.assert_allclose(root[[1, 5]], [-total, -total * 0.5 * (a + b) * LENGTH], rtol=1e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_dead_load_far_from_straight(kind):
    """EI angle'' = -q (L - s) cos(angle), q L^3 / EI = 8, solved as a boundary value problem."""
    q = 8.0 * EI / LENGTH**3
    s = np.linspace(0.0, LENGTH, 41)
    line = solve_bvp(
        lambda s, y: np.array([y[1], -q * (LENGTH - s) * np.cos(y[0]) / EI, np.cos(y[0]), np.sin(y[0])]),
        lambda a, b: np.array([a[0], b[1], a[2], a[3]]),
        s,
        np.zeros((4, len(s))),
        tol=1e-9,
    )
    solution = fmb.statics(cantilever(kind, elements=16, force=(0, 0, q)))
    np.testing.assert_allclose(solution["tip"][-1, [0, 2]], line.y[2:, -1], atol=2e-3 * LENGTH)


@pytest.mark.parametrize("kind", KINDS)
def test_pressure_that_turns_with_the_section(kind):
    """N' = k Q, Q' = -k N - q, M' = -Q with k = M / EI, from the free tip;
    the tip is the integral of the directions.
    """
    q = 6.0 * EI / LENGTH**3

    def forces(s, y):
        N, Q, M = y
        return -M / EI * Q, M / EI * N + q, Q  # s runs from the tip

    found = solve_ivp(forces, (0.0, LENGTH), np.zeros(3), rtol=1e-10, atol=1e-12, dense_output=True)
    line = solve_ivp(
        lambda s, y: (found.sol(LENGTH - s)[2] / EI, np.cos(y[0]), np.sin(y[0])),
        (0.0, LENGTH),
        np.zeros(3),
        rtol=1e-10,
        atol=1e-12,
    )
    solution = fmb.statics(cantilever(kind, elements=16, force=(0, 0, q), section_axes=True))
    tip = solution["tip"][-1]
    np.testing.assert_allclose([tip[0], abs(tip[2])], [line.y[1, -1], abs(line.y[2, -1])], atol=2e-3 * LENGTH)
    assert solution["root"][-1, 4] == pytest.approx(found.y[2, -1], rel=2e-3)


def test_torque_per_length():
    """m L^2 / 2 GJ turns the free end; GJ = EI here."""
    model = cantilever("beam", moment=(0.5, 0, 0), body={"markers": {"side": 1.0}})
    body = model.bodies[1]
    axes = body.section_axes(fmb.statics(model).final.q, 1.0)[1][0]
    assert np.arctan2(axes[2, 1], axes[1, 1]) == pytest.approx(0.5 * LENGTH**2 / (2 * EI), rel=1e-4)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("turning", [False, True])
def test_tangent_and_power(kind, turning, rng):
    """The stiffness is the derivative of the residual; the power reported is that of the forces."""
    load = {"force": (3.0, -1.0, 2.0), "moment": (0.8, 0.5, -0.6), "section_axes": turning, "stretch": (0.1, 0.8)}
    model = cantilever(kind, elements=2, **load)
    system = compile(fmb.Model(bodies=model.bodies, forces=model.forces))
    bare = compile(fmb.Model(bodies=model.bodies))
    state = system.state(0.3)
    state.q[:] += 0.05 * rng.normal(size=system.nq)
    state.u[:] = rng.normal(size=system.nu)
    work, without = system.workspace(), bare.workspace()

    def residual(x, d):
        later = moved(system, state, d, x)
        for one, scratch in ((system, work), (bare, without)):
            scratch.weights[0].wanted = 0
            evaluate(one.program, later, scratch)
        return work.residual - without.residual

    force = -residual(0.0, state.u)
    assert work.energy[0].load_power == pytest.approx(force @ state.u, rel=SOLVER)
    expected = np.array([derivative(lambda x, d=d: residual(x, d), 1e-3) for d in np.eye(system.nu)]).T
    found = (tangent_at(system, state, work).K - tangent_at(bare, state, without).K).toarray()
    np.testing.assert_allclose(found, expected, atol=SOLVER * np.abs(expected).max())


def test_messages():
    model = cantilever("cable")

    def with_load(**fields):
        return fmb.Model(bodies=model.bodies, forces=(fmb.LineLoad("q", **fields),))

    with pytest.raises(ModelError, match=r"body 'b' has no stretch 'z'.*One of: s"):
        with_load(stretch="b.z")
    with pytest.raises(ModelError, match=r"body 'ground' has no stretch.*AncfCable or AncfBeam"):
        with_load(stretch="ground.s")
    with pytest.raises(ModelError, match=r"stretch = 'b'.*'body\.stretch'"):
        with_load(stretch="b")
    with pytest.raises(ModelError, match=r"force = 3\.0.*three numbers or signals"):
        with_load(stretch="b.s", force=3.0)
    with pytest.raises(ModelError, match=r"section_axes = 'b\.end'.*True or False"):
        with_load(stretch="b.s", section_axes="b.end")
    with pytest.raises(ModelError, match=r"stretch s = \(0\.5, 0\.2\).*from < to"):
        cantilever("cable", stretch=(0.5, 0.2))
