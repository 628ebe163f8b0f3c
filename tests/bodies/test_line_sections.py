"""Tapers, lumped masses, tubes and initial strain of cables and beams, against closed forms."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from tolerances import SOLVER

import flexmb as fmb
from flexmb import fem
from flexmb.errors import ModelError

LENGTH, STEEL = 2.0, fmb.Material(young=2e11, poisson=0.3, density=8000.0)
KINDS = {"cable": fmb.AncfCable, "beam": fmb.AncfBeam}


def line(kind, elements=8, **fields):
    return KINDS[kind](
        "b",
        **{
            "points": ((0, 0, 0), (LENGTH, 0, 0)),
            "elements": elements,
            "section": fem.Section.solid_circle(0.02),
            "material": STEEL,
            **fields,
        },
    )


def clamped(body, *, forces=(), gravity=(0, 0, 0), sensors=(), joints=()):
    return fmb.Model(
        bodies=(fmb.Ground(markers={"end": (LENGTH, 0, 0)}), body),
        gravity=gravity,
        forces=forces,
        joints=(fmb.Fixed("clamp", markers=("ground.origin", "b.start")), *joints),
        sensors=(fmb.Position("tip", marker="b.end"), fmb.Reaction("root", joint="clamp"), *sensors),
    )


@pytest.mark.parametrize("kind", KINDS)
def test_taper_bends_as_the_integral_says(kind):
    """A cone under a small load at its tip: P int (L - x)^2 / EI dx, and the mass of a cone."""
    body = line(kind, section=(fem.Section.solid_circle(0.04), fem.Section.solid_circle(0.02)))
    expected, _ = quad(lambda x: (LENGTH - x) ** 2 / (STEEL.young * np.pi / 64 * (0.04 - 0.01 * x) ** 4), 0.0, LENGTH)
    load = 1.0
    solution = fmb.statics(clamped(body, forces=(fmb.PointLoad("P", marker="b.end", force=(0, 0, load)),)))
    assert solution["tip"][-1, 2] == pytest.approx(load * expected, rel=2e-3)
    assert body.mass == pytest.approx(8000.0 * np.pi / 12 * LENGTH * (0.04**2 + 0.04 * 0.02 + 0.02**2), rel=SOLVER)


def test_sections_at_equal_distances():
    """Of three sections the one in the middle holds at the middle, and halfway to it the mean diameter."""
    body = line("cable", section=[fem.Section.solid_circle(d) for d in (0.04, 0.02, 0.03)])
    area = body.constants([0.0, 0.25, 0.5, 1.0], "area")[0]
    np.testing.assert_allclose(area, np.pi / 4 * np.array([0.04, 0.03, 0.02, 0.03]) ** 2, rtol=SOLVER)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("ratio", [0.5, 3.0])
def test_frequency_with_a_mass_at_the_tip(kind, ratio):
    """1 + cos k cosh k = r k (sin k cosh k - cos k sinh k) for the mass ratio r, Euler-Bernoulli."""
    plain = line(kind)
    body = line(kind, lumped_masses=((1.0, ratio * plain.mass),))
    assert body.mass == pytest.approx((1.0 + ratio) * plain.mass, rel=SOLVER)
    k = brentq(
        lambda k: 1 + np.cos(k) * np.cosh(k) - ratio * k * (np.sin(k) * np.cosh(k) - np.cos(k) * np.sinh(k)), 0.1, 1.875
    )
    rod = plain.section
    expected = k**2 * np.sqrt(STEEL.young * rod.inertia_y / (8000.0 * rod.area * LENGTH**4)) / (2 * np.pi)
    found = fmb.linearize(clamped(body)).frequencies
    np.testing.assert_allclose(found[found > 0.1][:2], expected, rtol=2e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_weight_of_a_tube_with_a_mass_inside_an_element(kind):
    """The clamp carries the weight of tube and mass, with its lever."""
    tube = fem.Section.tube(0.05, 0.004)
    body = line(kind, section=tube, lumped_masses=[(0.3, 5.0)])
    own = 8000.0 * np.pi / 4 * (0.05**2 - 0.042**2) * LENGTH
    root = fmb.statics(clamped(body, gravity=(0, 0, -10.0)))["root"][-1]
    np.testing.assert_allclose(root[[2, 4]], [10.0 * (own + 5.0), -10.0 * (own * 1.0 + 5.0 * 0.6)], rtol=1e-4)


@pytest.mark.parametrize("kind", KINDS)
def test_initial_strain_pulls_at_the_ends(kind):
    """Between two fixed ends the line is under the tension EA times the initial strain."""
    body = line(kind, initial_strain=1e-3)
    solution = fmb.statics(
        clamped(
            body,
            joints=(fmb.Spherical("far", markers=("ground.end", "b.end")),),
            sensors=(fmb.Reaction("pull", joint="far"),),
        )
    )
    tension = STEEL.young * np.pi / 4 * 0.02**2 * 1e-3
    assert solution["pull"][-1, 0] == pytest.approx(tension, rel=SOLVER)
    np.testing.assert_allclose(body.section_forces(solution.final.q, [0.1, 0.6])[:, 0], tension, rtol=SOLVER)


@pytest.mark.parametrize("kind", KINDS)
def test_pre_curved_line_is_at_rest(kind):
    angle = np.linspace(0.0, 1.2, 9)
    arc = np.stack([np.sin(angle), 0.0 * angle, 1.0 - np.cos(angle)], axis=1)
    body = line(kind, points=arc, tangents=((1, 0, 0), (np.cos(1.2), 0, np.sin(1.2))))
    model = clamped(body)
    start = fmb.statics(model)
    np.testing.assert_allclose(start["tip"][-1], arc[-1], atol=1e-9)
    bent = fmb.statics(clamped(line(kind, points=arc, straight=True, tangents=body.tangents)))
    assert np.linalg.norm(bent["tip"][-1] - (1.2, 0, 0)) < 5e-3  # without load it is straight


@pytest.mark.parametrize("kind", KINDS)
def test_messages(kind):
    with pytest.raises(ModelError, match=r"lumped mass \(2\.0, 1\.0\).*fraction of the length, mass > 0"):
        line(kind, lumped_masses=[(2.0, 1.0)])
    with pytest.raises(ModelError, match=r"lumped mass 3\.0.*lumped_masses=\[\(0\.5, 2\.0\)\]"):
        line(kind, lumped_masses=[3.0])
    with pytest.raises(ModelError, match=r"section = None without area"):
        line(kind, section=(fem.Section.solid_circle(0.02), None))
    with pytest.raises(ModelError, match=r"section = None without area"):
        line(kind, section=())
