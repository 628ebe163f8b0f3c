"""FE04, NAFEMS FV2: in-plane vibration of a pin-ended double cross, eight arms rigidly joined at the centre.

NAFEMS, Selected Benchmarks for Natural Frequency Analysis (1987). Closed form: arms pinned-pinned in the
modes that do not turn the centre, clamped-pinned in those where the arms oppose each other. Both are
Euler-Bernoulli without rotary inertia (with them the second group of the slender arms is 1.2 % lower).
"""

import numpy as np

from flexmb import fem
from flexmb.model.material import Material

TOLERANCE = 0.01


def test_in_plane_frequencies(reference):
    case = reference("FE04")
    target, model = case["reference"]["NAFEMS_target_Hz"], case["model"]
    material = Material(young=model["E"], poisson=model["nu"], density=model["rho"])
    points, lines, ends = [(0.0, 0.0, 0.0)], [], []
    for angle in np.arange(8) * np.pi / 4:
        before = 0
        for s in np.linspace(0.0, model["arm_length"], 9)[1:]:
            points.append((s * np.cos(angle), s * np.sin(angle), 0.0))
            lines.append((before, len(points) - 1))
            before = len(points) - 1
        ends.append(before)
    fe = fem.frame(
        points,
        connectivity=lines,
        section=fem.Section.rectangle(0.125, 0.125),
        material=material,
        shear=False,
        rotary_inertia=False,
    )
    fe = fem.with_supports(fem.with_supports(fe, directions=(2, 3, 4)), ends, (0, 1))
    expected = [target[key] for key in ("1", *["2-3"] * 2, *["4-8"] * 5, "9", *["10-11"] * 2, *["12-16"] * 5)]
    np.testing.assert_allclose(fem.eigenmodes(fe, None, 16).frequencies, expected, rtol=TOLERANCE)
