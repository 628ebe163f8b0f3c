"""Lines whose elements collapse or turn inside out are refused with element and time; long soft lines are not."""

import numpy as np
import pytest

import flexmb as fmb
from flexmb import fem
from flexmb.errors import IntegrationError, ModelError

KINDS = {"cable": fmb.AncfCable, "beam": fmb.AncfBeam}
RUBBER = fmb.Material(young=1e5, poisson=0.3, density=1000.0)
EA = 1e5 * np.pi / 4 * 0.05**2


def pressed(kind, force, **fields):
    """A rubber line of one metre along x, held at its start, pushed at its end along itself."""
    body = KINDS[kind](
        "b",
        points=((0, 0, 0), (1, 0, 0)),
        elements=4,
        section=fem.Section.solid_circle(0.05),
        material=RUBBER,
        **fields,
    )
    return fmb.Model(
        bodies=(fmb.Ground(), body),
        gravity=(0, 0, 0),
        joints=(fmb.Fixed("clamp", markers=("ground.origin", "b.start")),),
        forces=(fmb.PointLoad("P", marker="b.end", force=(force, 0, 0)),),
    )


@pytest.mark.parametrize("kind", KINDS)
def test_push_beyond_the_stiffness(kind):
    """Twice EA presses the last element through itself: the run ends there, and keeps its samples."""
    with pytest.raises(
        IntegrationError,
        match=r"Body 'b' at t = 0\.\d+ s: element 3 of 4 has (turned inside out|"
        r"collapsed).*positive length and volume.*more elements",
    ) as error:
        fmb.simulate(pressed(kind, -2.0 * EA), 1.0, samples=1001)
    solution = error.value.solution
    assert solution.status.kind == "failed"
    assert 1 < len(solution.t) < 1001


@pytest.mark.parametrize("kind", KINDS)
def test_long_stretch_is_no_collapse(kind):
    solution = fmb.statics(pressed(kind, EA))
    assert solution.model.body("b").section_forces(solution.final.q, 0.5)[0, 0] == pytest.approx(EA, rel=1e-6)


def test_equilibrium_inside_out():
    """A beam whose sections face the other way than its line is told in equilibrium as well."""
    model = pressed("beam", -3.0 * EA)
    start = fmb.statics(pressed("beam", 0.0)).final
    q = start.q.copy().reshape(-1, 9)
    q[:, 0] *= -2.0
    mirrored = type(start)(t=0.0, q=q.ravel(), u=start.u, a=start.a, lam=start.lam, works=start.works)
    with pytest.raises(IntegrationError, match=r"Body 'b': in equilibrium element \d of 4 has turned inside out"):
        fmb.statics(model, state=mirrored)


def test_input_that_is_wrong_as_drawn():
    """Zero length between points, a fold within an element, a section without area: before any computing."""
    cases = {
        "zero length between points 0 and 1": {"points": ((0, 0, 0), (0, 0, 0), (1, 0, 0))},
        "the curve turns by": {"points": ((0, 0, 0), (1, 0, 0), (0, 0.01, 0)), "elements": 2},
        "without area": {"section": type("Line", (), {"area": 0.0})()},
    }
    for found, fields in cases.items():
        for kind in KINDS.values():
            with pytest.raises(ModelError, match=f"Body 'b': .*{found}"):
                kind(
                    "b",
                    **{
                        "points": ((0, 0, 0), (1, 0, 0)),
                        "elements": 4,
                        "material": RUBBER,
                        "section": fem.Section.solid_circle(0.05),
                        **fields,
                    },
                )
