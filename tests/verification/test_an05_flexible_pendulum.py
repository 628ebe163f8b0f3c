"""AN05: a very flexible pendulum swings from horizontal (Escalona, Hussien & Shabana 1998 data).

Reference: a spectral solution of the extensible Euler-Bernoulli beam with engineering strain.
"""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem


@pytest.fixture(scope="module")
def swing():
    def run(model, joint, elements=12):
        body = fmb.AncfCable(
            "rope",
            points=((0, 0, 0), (model["L"], 0, 0)),
            elements=elements,
            section=fem.Section.values(model["A"], model["I"], model["I"], 2 * model["I"]),
            material=fmb.Material(young=model["E"], poisson=model["nu"], density=model["rho"]),
        )
        system = fmb.Model(
            bodies=(fmb.Ground(), body),
            joints=(joint("pin", markers=("ground.origin", "rope.start")),),
            gravity=(0, -model["g"], 0),
            sensors=(
                fmb.Position("tip", marker="rope.end"),
                fmb.Energy("T", kind="kinetic"),
                fmb.Energy("U", kind="strain"),
                fmb.Energy("V", kind="potential"),
            ),
        )
        return fmb.simulate(system, t_end=1.1, samples=12, integrator=fmb.GeneralizedAlpha(rho_inf=0.9, rtol=1e-6))

    return run


@pytest.mark.parametrize("joint", [fmb.Spherical, fmb.Revolute])
def test_tip_and_energies(reference, swing, joint):
    case = reference("AN05")
    model = case["model"]
    solution = swing(model, joint)
    scale = np.abs(solution["V"]).max()
    total = solution["T"] + solution["U"] + solution["V"]
    np.testing.assert_allclose(total, 0.0, atol=1e-3 * scale)
    for time, expected in case["reference"].items():
        k = int(np.argmin(np.abs(solution.t - float(time))))
        tolerance = 0.02 * model["L"] + (0.025 if float(time) > 1.0 else 0.0)
        np.testing.assert_allclose(solution["tip"][k], [*expected["tip"], 0.0], atol=tolerance)
        for name in "TUV":
            assert solution[name][k] == pytest.approx(expected[name], abs=0.02 * scale)
