"""FE14: Euler columns with frames, closed form P = c E I / L^2; straight and in a skew direction.

Cubic elements are in error by (k h)^4 / 720, k = sqrt(P / E I). The tolerance of the case, 1e-4 with 8
elements and 1e-6 with 32, is met where this allows: the clamped columns have 5.3e-4 and 1.4e-4 with 8
elements.
"""

import numpy as np
import pytest
from fem.beams import STEEL, straight

from flexmb import fem

SECTION = fem.Section.rectangle(0.02, 0.01)
HELD = {  # directions at the start and at the end; z is the direction of the soft bending
    "pinned_pinned": ((0, 1, 2, 3), (1, 2, 3)),
    "clamped_free": (range(6), ()),
    "clamped_clamped": (range(6), (1, 2, 3, 4, 5)),
    "clamped_pinned": (range(6), (1, 2, 3)),
}


def critical(elements, ends, number=1):
    fe = fem.frame(straight(elements), section=SECTION, material=STEEL, shear=False)
    for node, directions in zip(("start", "end"), HELD[ends]):
        if directions:
            fe = fem.with_supports(fe, node, directions)
    load = np.zeros((len(fe.nodes), 6, 1))
    load[-1, 0] = -1.0
    return fem.buckling(fe, fe.forces(load)[:, 0], None, n=number)[0]


@pytest.mark.parametrize(("elements", "tolerance"), [(8, 1e-4), (32, 1e-6)])
@pytest.mark.parametrize("ends", HELD)
def test_critical_loads(reference, ends, elements, tolerance):
    expected = reference("FE14")["reference"]["P_N_for_SI_example"][ends]
    known = (expected / (STEEL.young * SECTION.inertia_y)) ** 2 / elements**4 / 720
    assert critical(elements, ends)[0] == pytest.approx(expected, rel=max(tolerance, 1.02 * known))


def test_second_load(reference):
    """The second sideways load of the pinned column: 4 pi^2 E I / L^2 (the stiff plane, 4 x I, has the same
    first load)."""
    case = reference("FE14")
    expected = case["reference"]["second_pinned"] * STEEL.young * SECTION.inertia_y
    np.testing.assert_allclose(critical(32, "pinned_pinned", 3)[1:], expected, rtol=1e-5)


def test_skew_column(reference):
    """Clamped-free in the direction (1, 2, 3): the element axes, not the world's, carry the load."""
    direction = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    fe = fem.frame(straight(32, direction=direction), section=SECTION, material=STEEL, shear=False)
    fe = fem.with_supports(fe, "start")
    load = np.zeros((33, 6, 1))
    load[-1, :3, 0] = -direction
    factor = fem.buckling(fe, fe.forces(load)[:, 0], None)[0][0]
    assert factor == pytest.approx(reference("FE14")["reference"]["P_N_for_SI_example"]["clamped_free"], rel=1e-6)
