"""FE17: frequencies of a simply supported beam under an axial force P, closed form with sqrt(1 + P L^2 /
(n^2 pi^2 E I))."""

from dataclasses import replace

import numpy as np
import pytest
from fem.beams import STEEL, frequencies, solve, straight

from flexmb import fem

TOLERANCE = 1e-4


@pytest.mark.parametrize("ratio", ["-0.9", "-0.5", "0", "1", "10"])
def test_frequencies(reference, ratio):
    section = fem.Section.rectangle(0.02, 0.01)
    fe = fem.frame(straight(16), section=section, material=STEEL, shear=False, rotary_inertia=False)
    fe = fem.with_supports(fem.with_supports(fe, directions=(1, 3, 5)), "start", (0, 2))
    fe = fem.with_supports(fe, "end", (2,))
    critical = np.pi**2 * STEEL.young * section.inertia_y
    field = solve(fe, 16, (float(ratio) * critical, 0, 0, 0, 0, 0))
    stressed = replace(fe, K=fe.K + fe.blocks[0].geometric_stiffness(field, fe.dofs))
    np.testing.assert_allclose(frequencies(stressed, 2), reference("FE17")["reference"][ratio], rtol=TOLERANCE)
