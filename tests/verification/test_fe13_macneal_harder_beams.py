"""FE13: MacNeal & Harder's straight, curved and twisted beams, Finite Elem. Anal. Des. 1 (1985) 3-20 (units
as published)."""

import numpy as np
import pytest
from fem.beams import solve, straight

from flexmb import fem
from flexmb.model.material import Material

BEAM, CURVED = 0.01, 0.03


def tip(points, section, material, axis, orientation=None):
    fe = fem.with_supports(fem.frame(points, section=section, material=material, orientation=orientation), "start")
    return solve(fe, len(points) - 1, np.eye(6)[axis])[-1, axis]


@pytest.mark.parametrize("elements", [1, 6])
def test_straight(reference, elements):
    """One element is exact. The twist of the case has Roark's approximate torsion constant, 0.08 % above
    the series."""
    case = reference("FE13")["reference"]
    material = Material(young=1e7, poisson=0.3, density=1.0)
    section = fem.Section.rectangle(0.2, 0.1)
    found = [tip(straight(elements, 6.0), section, material, axis) for axis in range(4)]
    published = [case["straight"][key] for key in ("extension", "in_plane", "out_of_plane")]
    np.testing.assert_allclose(found[:3], published, rtol=BEAM)
    own = case["own_beam_theory"]
    np.testing.assert_allclose(found[1:3], [own["in_plane"], own["out_of_plane"]], rtol=1e-8)
    assert found[3] == pytest.approx(own["twist_unit_torque"], rel=1e-3)


def test_curved(reference):
    """The arc by 32 chords; the exact values of curved-beam theory are in `own_beam_theory`."""
    case = reference("FE13")["reference"]
    material = Material(young=1e7, poisson=0.25, density=1.0)
    angle = np.linspace(0.0, np.pi / 2, 33)
    points = 4.22 * np.stack([np.sin(angle), 1.0 - np.cos(angle), 0 * angle], axis=1)
    section = fem.Section.rectangle(0.2, 0.1)
    in_plane, out_of_plane = tip(points, section, material, 0), tip(points, section, material, 2)
    assert out_of_plane == pytest.approx(case["curved"]["out_of_plane"], rel=CURVED)
    assert in_plane == pytest.approx(case["curved"]["in_plane"], rel=CURVED)
    assert in_plane == pytest.approx(case["own_beam_theory"]["curved_in_plane"], rel=2e-3)


def test_twisted(reference):
    """90 degrees of twist in 24 straight pieces."""
    case = reference("FE13")["reference"]
    material = Material(young=29e6, poisson=0.22, density=1.0)
    section = fem.Section.rectangle(1.1, 0.32)
    points = straight(24, 12.0)
    angle = (np.arange(24) + 0.5) * np.pi / 2 / 24
    orientation = np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=1)
    found = sorted((tip(points, section, material, axis, orientation) for axis in (1, 2)), reverse=True)
    np.testing.assert_allclose(found, [case["twisted"]["in_plane"], case["twisted"]["out_of_plane"]], rtol=BEAM)
    np.testing.assert_allclose(found, case["own_beam_theory"]["twisted"], rtol=5e-3)
