"""What a unit of a modal coordinate amounts to is the choice of a reduction: `Explicit` is as close for any."""

from dataclasses import replace

import numpy as np
import pytest
from contracts.random_models import beam

import flexmb as fmb
from flexmb.model.subspace_data import in_subspace, own_shapes

HOWS = {
    "bodies": fmb.Explicit(rtol=1e-9),
    "joints": fmb.Explicit(rtol=1e-9, formulation=fmb.Recursive()),
    "SciPy": fmb.Explicit(rtol=1e-9, formulation=fmb.Recursive(), method="RK45"),
}


def tip(how: str, scale: float) -> np.ndarray:
    """Return the deflections, m, of a beam that swings on a hinge, with modes that are larger by a factor."""
    data = beam()
    found = in_subspace(data, scale * own_shapes(data, np.eye(data.n_modes)[:, :4]))
    data = replace(found, frequencies=found.frequencies / scale)
    model = fmb.Model(
        gravity=(0, -9.81, 0),
        bodies=[fmb.Ground(), fmb.FloatingBody("b", data=data)],
        joints=[fmb.Revolute("pin", markers=("ground.origin", "b.root"))],
        sensors=[fmb.Deflection("bent", marker="b.tip")],
    )
    motion = fmb.simulate(model, 0.05, samples=26, integrator=HOWS[how])
    return motion["bent"]


@pytest.mark.parametrize("how", HOWS)
def test_deflections_do_not_depend_on_it(how):
    expected = tip(how, 1.0)
    largest = np.abs(expected).max()
    for scale in (1e-4, 1e4):  # 4e-8 where a modal coordinate was compared with 1e-10 m whatever its unit amounts to
        np.testing.assert_allclose(tip(how, scale), expected, rtol=0, atol=1e-11 * largest)
