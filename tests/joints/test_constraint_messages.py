"""What is said about equations of the user that cannot be satisfied, or that are none."""

import re

import numpy as np
import pytest

import flexmb as fmb
from flexmb.errors import CompileError, IntegrationError, ModelError


def model(*equations: str, **fields) -> fmb.Model:
    over = [fmb.Position("p", marker="q.center")]
    joints = [fmb.Constraint(f"c{k}", over=over, equation=text, **fields) for k, text in enumerate(equations)]
    bodies = [fmb.Ground(), fmb.PointMass("q", mass=1.0, at=(0.5, 0, 0))]
    return fmb.Model(gravity=(0, 0, -9.81), bodies=bodies, joints=joints)


@pytest.mark.parametrize(
    ("equations", "said", "unsaid"),
    [
        (["p[0] = 0.5 + t**0.5"], r"Equation 'c0.*its rate is no finite number at t = 0 s.*begin smoothly", "inertia"),
        (["p[0]**2 = -1"], r"c0.* stays open by 1\b", "contradicts or repeats"),
        (["1/p[1] = 3"], "has no value.*no division by zero", "contradict"),
        (["p[0] = 0.5", "p[0] = 0.7"], "contradict each other.*make their numbers agree", "Spherical"),
    ],
)
def test_what_stays_open_is_named(equations, said, unsaid):
    with pytest.raises(CompileError, match=said) as caught:
        fmb.check(model(*equations))
    assert unsaid not in str(caught.value)


def test_the_residual_of_speeds_is_told():
    """v**2 = 1 at rest: 0 - 1, and no gradient."""
    over = [fmb.Velocity("v", marker="q.center")]
    joint = fmb.Constraint("c", over=over, equation="v[0]**2 + v[1]**2 + v[2]**2 = 1")
    with pytest.raises(CompileError, match=r"no gradient at the start.*residual -1"):
        fmb.check(model().with_parts(joints=[joint]))


def test_inequalities_are_no_equations():
    with pytest.raises(ModelError, match=r"comparison 'p.0. <= 0.5' of a measured quantity.*a force") as caught:
        model("p[0] <= 0.5")
    assert "where(" not in str(caught.value)


def test_forces_on_what_is_not_measured():
    with pytest.raises(ModelError, match=r"'v' is unknown. Measured: p") as caught:
        model("p[0] = 0.5", forces={"v[0]": "-3*p[1]"})
    assert "list" not in str(caught.value)


@pytest.mark.parametrize("equation", ["p[0] = p[1] = 0", "p[0] = (1", "p[0] ="])
def test_equations_that_cannot_be_read_name_their_constraint(equation):
    point = fmb.PointMass("b", mass=1.0)
    own = fmb.Constraint("own", over=[fmb.Position("p", marker="b.center")], equation=equation)
    with pytest.raises(ModelError, match=r"Joint 'own': in .*not arithmetic"):
        fmb.simulate(fmb.Model(bodies=[fmb.Ground(), point], joints=[own]), 0.1)


@pytest.mark.parametrize("integrator", [fmb.Explicit(), fmb.IDA(), fmb.GeneralizedAlpha(step=0.01)], ids=repr)
def test_speeds_that_part_from_positions_on_the_way_are_named(integrator):
    """x = 0.1 t^2 has the speed 0.2 t, and the other equation asks for 0.3 t^3 more; the point falls freely beside."""
    over = [fmb.Position("p", marker="b.center"), fmb.Velocity("v", marker="b.center")]
    joints = [
        fmb.Constraint("place", over=over, equation="p[0] = 0.1*t**2"),
        fmb.Constraint("speed", over=over, equation="v[0] = 0.2*t + c*t**3", parameters={"c": 0.3}),
    ]
    model = fmb.Model(bodies=[fmb.Ground(), fmb.PointMass("b", mass=1.0)], joints=joints, gravity=(0, 0, -9.81))
    with pytest.raises(IntegrationError, match=r"Joint '(place|speed)'.*dependent equations stay open|near Body 'b'"):
        fmb.simulate(model, 1.0, samples=11, integrator=integrator)
    agreed = fmb.Model(
        bodies=model.bodies, joints=[joints[0], joints[1].replaced(parameters={"c": 0.0})], gravity=model.gravity
    )
    assert fmb.simulate(agreed, 1.0, samples=11, integrator=integrator).status.ok


INTEGRATORS = [
    fmb.GeneralizedAlpha(),
    fmb.GeneralizedAlpha(step=1e-3),
    fmb.IDA(),
    fmb.Implicit(),
    fmb.Explicit(),
    fmb.Explicit(formulation=fmb.UdwadiaPhohomsiri()),
    fmb.MoreauJean(step=1e-3),
]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_an_equation_in_time_that_ends_on_the_way_is_named(integrator):
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(model("p[0] = 0.5*sqrt(1 - 2*t)"), 1.0, samples=8, integrator=integrator)
    text = str(caught.value)
    assert "Joint 'c0': its equation 'Formula' with its two rates is [" in text
    assert "from t = 0.5 s on" in text
    assert "Correct its signals" in text
    t = caught.value.solution.t  # on a slow machine with a state behind the last sample, kept when the clock struck
    assert t[:4] == pytest.approx([k / 7 for k in range(4)])
    assert np.all(t[4:] <= 0.5)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_an_equation_that_ends_where_a_point_comes_is_named(integrator):
    """The point falls freely and is a metre down after sqrt(2 / 9.81) s: steps beyond are tried, and taken back."""
    with pytest.raises(IntegrationError) as caught:
        fmb.simulate(model("p[0] = 0.5 + 0*sqrt(p[2] + 1)"), 1.0, samples=8, integrator=integrator)
    text = str(caught.value)
    assert "c0: Formula" in text
    assert "nan" in text
    ended = float(re.search(r"at t = ([0-9.]+) s", text)[1])
    assert ended == pytest.approx((2 / 9.81) ** 0.5, rel=1e-4)


def test_a_stepped_run_names_the_equation_that_ends():
    run = fmb.stepper(model("p[0] = 0.5*sqrt(1 - 2*t)"))
    with pytest.raises(IntegrationError, match=r"Joint 'c0': its equation 'Formula'.*from t = 0\.5 s on"):
        run.advance(by=0.7)
