"""Units for model exchange: in the system against scipy, beside the model with events against closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fmb

pytest.importorskip("fmpy")
from fmi.exchange_units import HAS_COMPILER, build

pytestmark = pytest.mark.skipif(not HAS_COMPILER, reason="units are compiled with cc")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return a function that builds a unit once."""
    known = {}

    def unit(name, version=3, derivatives=True):
        key = name, version, derivatives
        if key not in known:
            known[key] = build(tmp_path_factory.mktemp(name), *key)
        return known[key]

    return unit


def slider(force, *sensors) -> fmb.Model:
    """A mass on a spring that is pushed along x."""
    return fmb.Model(
        bodies=[fmb.Ground(markers={"wall": (-1, 0, 0)}), fmb.PointMass("mass", mass=2.0, at=(0.3, 0, 0))],
        forces=[
            fmb.PointLoad("push", marker="mass.center", force=(force, 0, 0)),
            fmb.SpringDamper("spring", markers=("ground.wall", "mass.center"), stiffness=8.0, length=1.0),
        ],
        sensors=[fmb.Position("place", marker="mass.center"), *sensors],
    )


def coupled(made, version, derivatives):
    """Return an oscillator that the place of a mass drives, and that pushes the mass by its output."""
    place = fmb.Position("place", marker="mass.center")
    unit = fmb.fmi.ModelExchange(made("oscillator", version, derivatives), inputs={"u": place}, parameters={"p": 0.5})
    states = [fmb.State(name, of="oscillator", state=name) for name in ("x0", "x1")]
    return slider(unit["y"], *states), unit


def rates(t, z):
    x, v, a, b = z
    return [v, (a * b - 8.0 * x) / 2.0, b, 0.5 * (1 - a * a) * b - a + x]


@pytest.mark.parametrize(
    ("version", "derivatives", "integrator", "error"),
    [
        (2, True, fmb.Explicit(), 1e-8),
        (3, False, fmb.Explicit(), 1e-8),
        (3, True, fmb.Implicit(rtol=1e-7), 1e-5),
        (2, False, fmb.GeneralizedAlpha(rtol=1e-6), 2e-3),
    ],
)
def test_states_in_the_system(made, version, derivatives, integrator, error):
    """Mass and unit follow the equations of both, integrated by scipy."""
    model, _ = coupled(made, version, derivatives)
    run = fmb.simulate(model, t_end=1.0, integrator=integrator, samples=6)
    exact = solve_ivp(rates, (0, 1), (0.3, 0, 2, 0), "DOP853", run.t, rtol=1e-12, atol=1e-12).y
    for name, row in (("x0", 2), ("x1", 3)):
        np.testing.assert_allclose(run[name], exact[row], atol=error)
    np.testing.assert_allclose(run["place"][:, 0], exact[0], atol=error)


@pytest.mark.parametrize("derivatives", [True, False])
def test_statics_and_linear_model(made, derivatives):
    """At rest all is zero; there the matrix of both has these eigenvalues."""
    model, _ = coupled(made, 3, derivatives)
    rest = fmb.statics(model)
    assert rest["x0"][-1] == pytest.approx(0.0, abs=1e-8)
    A = np.array([[0, 1, 0, 0], [-4, 0, 0, 0], [0, 0, 0, 1], [1, 0, -1, 0.5]])
    found = fmb.linearize(model, about=rest).eigenvalues
    for value in np.linalg.eigvals(A):
        assert min(np.abs(found - value).min(), np.abs(found.conj() - value).min()) < 1e-6


def test_van_der_pol_after_20_s(made):
    """The oscillator alone, mu = 1: scipy's 2.0081498 and -0.0425089."""
    unit = fmb.fmi.ModelExchange(made("oscillator"), name="vdp")
    model = slider(unit["x0"], fmb.State("a", of="vdp", state="x0"), fmb.State("b", of="vdp", state="x1"))
    run = fmb.simulate(model, t_end=20.0, integrator=fmb.Explicit(), samples=2)
    exact = solve_ivp(lambda t, x: [x[1], (1 - x[0] ** 2) * x[1] - x[0]], (0, 20), (2, 0), "DOP853", rtol=1e-12).y
    assert exact[:, -1] == pytest.approx((2.0081498, -0.0425089), abs=1e-6)
    assert (run["a"][-1], run["b"][-1]) == pytest.approx(tuple(exact[:, -1]), abs=1e-6)


@pytest.mark.parametrize("version", [2, 3])
def test_a_ball_bounces_at_the_times_of_the_closed_form(made, version):
    """Beside the model: heights over five bounces, with an event in the middle of communication steps."""
    from flexmb.fmi.exchange_steps import SteppedExchange

    unit = SteppedExchange(fmb.fmi.Fmu(made("ball", version), kind="model exchange"), str(made("ball").parent), 0, 2)
    times = np.linspace(0.0, 2.0, 41)
    try:
        seen = [unit.get_all(("y",))[0]]
        for t, following in pairwise(times):
            assert unit.step(t, following - t)
            seen.append(unit.get_all(("y",))[0])
    finally:
        unit.close()
    fall, heights = np.sqrt(2.0 / 9.81), []
    for t in times:
        begin, speed = fall, 0.7 * 9.81 * fall
        while t > begin + 2 * speed / 9.81:
            begin, speed = begin + 2 * speed / 9.81, 0.7 * speed
        late = t - begin
        heights.append(1.0 - 4.905 * t * t if t < fall else speed * late - 4.905 * late * late)
    np.testing.assert_allclose(seen, heights, atol=1e-7)


@pytest.mark.parametrize("version", [2, 3])
def test_events_of_time_come_where_the_unit_plans_them(made, version):
    """A rate that grows by one every 0.3 s; the output pushes a mass that is free."""
    clock = fmb.fmi.Fmu(made("clock", version), outputs={"force": "y"}, kind="model exchange")
    model = slider(fmb.input("force"), fmb.SignalValue("pushed", of=fmb.input("force"))).without("spring")
    run = fmb.fmi.cosimulate(model, clock, 1.0, step=0.05)
    # a sample at a communication time reads the input that was held up to it
    passed = np.array([sum(max(t - 0.3 * k, 0.0) for k in range(4)) for t in run.t])
    np.testing.assert_allclose(run["pushed"][1:], passed[:-1], atol=1e-9)


def test_beside_the_model_the_error_is_of_the_communication(made):
    """The same coupling with inputs held: the error falls with the step."""
    exact = solve_ivp(rates, (0, 2), (0.3, 0, 2, 0), "DOP853", rtol=1e-12, atol=1e-12).y[0, -1]
    unit = fmb.fmi.Fmu(
        made("oscillator"),
        inputs={"u": "place x"},
        outputs={"force": "y"},
        parameters={"p": 0.5},
        kind="model exchange",
    )
    errors = []
    for step in (0.02, 0.01):
        run = fmb.fmi.cosimulate(slider(fmb.input("force")), unit, 2.0, step=step, integrator=fmb.Explicit())
        errors.append(abs(run["place"][-1, 0] - exact))
    assert errors[1] < 5e-3
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.2)


def test_what_does_not_fit_is_said(made, tmp_path):
    with pytest.raises(fmb.ModelError, match=r"1 event indicators.*cosimulate"):
        fmb.fmi.ModelExchange(made("ball"))
    with pytest.raises(fmb.ModelError, match=r"event planned for t = 0\.3 s"):
        fmb.fmi.ModelExchange(made("clock"))
    with pytest.raises(fmb.ModelError, match="no input 'v'"):
        fmb.fmi.ModelExchange(made("oscillator"), inputs={"v": 1.0})
    with pytest.raises(fmb.ModelError, match="no output 'w'"):
        fmb.fmi.ModelExchange(made("oscillator"))["w"]
    with pytest.raises(fmb.ModelError, match="parameter p = 'a'"):
        fmb.fmi.ModelExchange(made("oscillator"), parameters={"p": "a"})
    with pytest.raises(fmb.ModelError, match="kind = 'exchange'"):
        fmb.fmi.Fmu(made("oscillator"), kind="exchange")
    with pytest.raises(fmb.ModelError, match="without co-simulation"):
        fmb.fmi.cosimulate(slider(0.0), fmb.fmi.Fmu(made("oscillator")), 1.0, step=0.1)
    with pytest.raises(fmb.DataFileError, match="no such file"):
        fmb.fmi.ModelExchange(tmp_path / "none.fmu")


def test_a_unit_that_fails_is_named_and_results_are_kept(made):
    unit = fmb.fmi.ModelExchange(made("oscillator"), inputs={"u": fmb.expression("60*t")})
    with pytest.raises(fmb.IntegrationError, match=r"oscillator|push") as raised:
        fmb.simulate(slider(unit["y"]), t_end=3.0, integrator=fmb.Explicit())
    assert raised.value.solution.t[-1] > 0.5


def test_a_unit_that_failed_for_good_is_not_called_any_more(made, monkeypatch):
    """FMI 3.0.1, 2.2.2: after "fatal" nothing may be called; Newton's steps and shorter steps would ask again."""
    unit = fmb.fmi.ModelExchange(made("oscillator"), inputs={"u": fmb.expression("t")})
    loaded, calls = unit._unit.loaded, []
    place, rates = loaded.place, loaded.rates

    def placed(t, *given):
        calls.append(t)
        place(t, *given)

    def failing():
        if calls[-1] > 0.3:
            calls.append("fatal")
            error = RuntimeError("the unit is gone")
            error.status = 4
            raise error
        return rates()

    monkeypatch.setattr(loaded, "place", placed)
    monkeypatch.setattr(loaded, "rates", failing)
    with pytest.raises(fmb.IntegrationError, match="the unit is gone"):
        fmb.simulate(slider(unit["y"]), t_end=1.0, integrator=fmb.GeneralizedAlpha())
    assert calls.index("fatal") == len(calls) - 1
