"""AN06: a free, flexible beam thrown and spun by a force and a moment at its lower end, then in free flight.

Reference: Simo & Vu-Quoc 1986; a spectral solution. Momentum and energy of the flight are laws.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem

TIMES = [2.5, 5.0, 7.5, 10.0]


@pytest.fixture(scope="module")
def flight():
    """EA = GA = 1e4 N, EI = 500 N m2, 1 kg/m, rotary inertia 10 kg m; twenty elements. Values at the four times."""
    section = fem.Section.values(1.0, 0.05, 0.05, 0.1, 2.0, 2.0)
    body = fmb.AncfBeam(
        "b",
        points=((6, 0, 0), (0, 8, 0)),
        elements=20,
        section=section,
        rotary_inertia=(10.0, 10.0),
        material=fmb.Material(young=1e4, poisson=0.0, density=1.0),
    )
    throw = fmb.PointLoad("throw", marker="b.start", force=(8.0, 0, 0), moment=(0, 0, -80.0))
    sensors = (
        fmb.Position("base", marker="b.start"),
        fmb.Position("tip", marker="b.end"),
        fmb.Momentum("p"),
        fmb.Energy("E"),
    )
    thrown = fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0), forces=(throw,), sensors=sensors)
    free = fmb.Model(bodies=(fmb.Ground(), body), gravity=(0, 0, 0), sensors=sensors)
    steps = fmb.GeneralizedAlpha(rho_inf=0.95, step=0.0125)
    first = fmb.simulate(thrown, t_end=2.5, samples=[0.0, 2.5], integrator=steps)
    later = fmb.simulate(free, t_start=2.5, t_end=10.0, samples=TIMES, start=first, integrator=steps)
    return {name: np.asarray(later[name]) for name in ("base", "tip", "p", "E")}


def test_laws(reference, flight):
    """P = F t = 20 N s and free flight: 1e-6 for the linear momentum."""
    p, expected = flight["p"], reference("AN06")["reference"]
    np.testing.assert_allclose(p[:, 0], 20.0, rtol=1e-6)
    np.testing.assert_allclose(p[:, 1:5], 0.0, atol=1e-6)
    # what the force does for the angular momentum depends on the path of the end: exact up to the time steps
    np.testing.assert_allclose(p[:, 5], expected["2.5"]["Lz"], rtol=2e-3)
    np.testing.assert_allclose(flight["E"], expected["2.5"]["E"], rtol=1e-2)


@pytest.mark.parametrize("time", ["2.5", "5.0", "7.5", "10.0"])
def test_ends(reference, flight, time):
    """One per cent of the length, two at the end of the flight."""
    expected = reference("AN06")["reference"][time]
    k = TIMES.index(float(time))
    tolerance = 0.2 if time == "10.0" else 0.1
    np.testing.assert_allclose(flight["base"][k], [*expected["base"], 0.0], atol=tolerance)
    np.testing.assert_allclose(flight["tip"][k], [*expected["tip"], 0.0], atol=tolerance)
