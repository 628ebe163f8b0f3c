"""AN12: plates and shells with large rotations: cantilever strip, slit annular plate, pinched hemisphere with a hole.

Reference: Sze, Liu & Lo, Finite Elements in Analysis and Design 40 (2004) 1551; the strip also by the elastica.
"""

import numpy as np
import pytest
from by_turns import every_second

import flexmb as fmb

KINDS = pytest.mark.parametrize("shear", [False, True], ids=["thin", "shear"])


def held_strip(model, elements, shear):
    """Return a strip with one end clamped, of n by 1 elements, the ground's markers and the joints."""
    material = fmb.Material(young=model["E"], poisson=model["nu"], density=1.0)
    strip = fmb.AncfPlate.rectangle(
        "p",
        edges=(model["L"], model["b"]),
        elements=(elements, 1),
        thickness=model["h"],
        material=material,
        shear=shear,
        markers={"end": (1.0, "mean")},
    )
    return strip.held("root", "s0", fmb.Fixed)


def bent_strip(model, elements, shear, share=1.0):
    """Return (U, W) of the end under the share of the end shear."""
    strip, supports, clamps = held_strip(model, elements, shear)
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(markers=supports), strip),
            gravity=(0, 0, 0),
            joints=clamps,
            forces=(fmb.PointLoad("P", marker="p.end", force=(0, 0, share * model["P"])),),
            sensors=(fmb.Position("end", marker="p.end"),),
        )
    )
    x, _, z = solution["end"][-1]
    return np.array([model["L"] - x, z])


STRIP = {"L": 10.0, "b": 1.0, "h": 0.1, "E": 1.2e6, "nu": 0.0, "P": 4.0}


@pytest.mark.parametrize(("share", "shear"), every_second([".25", ".5", ".75", "1"], [False, True]))
def test_strip(reference, shear, share):
    """16 elements, 0.5 % of the deflection."""
    expected = np.array(reference("AN12")["reference"]["strip"][share])
    np.testing.assert_allclose(bent_strip(STRIP, 16, shear, float(share)), expected, atol=0.005 * expected[1])


def test_strip_is_the_elastica(reference):
    """8 thin elements, 0.1 % of the elastica with P L^2 / EI = 4."""
    rise, shortening, _ = reference("AN12")["reference"]["strip_elastica_alpha_4"]
    np.testing.assert_allclose(bent_strip(STRIP, 8, False), [10.0 * shortening, 10.0 * rise], rtol=1e-3)


def annulus(elements, shear):
    """Return (W_A, W_B), the deflections of the inner and outer corner of the loaded edge of the slit."""
    turn, radius = np.linspace(0.0, 2.0 * np.pi, elements[0] + 1), np.linspace(6.0, 10.0, elements[1] + 1)
    flat = np.stack([np.outer(np.cos(turn), radius), np.outer(np.sin(turn), radius)], axis=-1)
    plate = fmb.AncfPlate(
        "p",
        points=np.pad(flat, ((0, 0), (0, 0), (0, 1))),
        thickness=0.03,
        shear=shear,
        material=fmb.Material(young=21e6, poisson=0.0, density=1.0),
        markers={"end": (1.0, "mean")},
    )
    plate, supports, clamps = plate.held("root", "s0", fmb.Fixed)
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(markers=supports), plate),
            gravity=(0, 0, 0),
            joints=clamps,
            forces=(fmb.PointLoad("P", marker="p.end", force=(0, 0, 0.8 * 4.0)),),
            sensors=(fmb.Position("A", marker="p.corner_10"), fmb.Position("B", marker="p.corner_11")),
        )
    )
    return np.array([solution["A"][-1][2], solution["B"][-1][2]])


@pytest.mark.slow
@pytest.mark.parametrize(("shear", "elements"), [(False, (30, 4)), (True, (48, 8))], ids=["thin", "shear"])
def test_annulus(reference, shear, elements):
    """30 by 4 thin elements, or 48 by 8 with shear: 2 %."""
    expected = reference("AN12")["reference"]["annular"]
    np.testing.assert_allclose(annulus(elements, shear), [expected["W_A"], expected["W_B"]], rtol=0.02)


def hemisphere(n, shear):
    """Return (V_A, U_B), the way in and the way out of the loaded points, for a quarter of n by n elements."""
    turn, rise = np.linspace(0.0, np.pi / 2, n + 1), np.linspace(0.0, np.radians(72.0), n + 1)
    points = 10.0 * np.stack(
        [
            np.outer(np.cos(turn), np.cos(rise)),
            np.outer(np.sin(turn), np.cos(rise)),
            np.outer(np.ones(n + 1), np.sin(rise)),
        ],
        axis=-1,
    )
    shell = fmb.AncfPlate(
        "p", points=points, thickness=0.04, shear=shear, material=fmb.Material(young=6.825e7, poisson=0.3, density=1.0)
    )
    shell, ground, symmetry = shell.held("x", "s0", fmb.Planar, rotation=(-np.pi / 2, 0, 0))
    shell, more, other = shell.held("y", "s1", fmb.Planar, rotation=(0, np.pi / 2, 0))
    half = 200.0  # of each force, in the plane of symmetry
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(markers={**ground, **more}), shell),
            gravity=(0, 0, 0),
            joints=(*symmetry, *other),
            forces=(
                fmb.PointLoad("out", marker="p.x_0", force=(half, 0, 0)),
                fmb.PointLoad("in", marker="p.y_0", force=(0, -half, 0)),
            ),
            sensors=(fmb.Position("A", marker="p.y_0"), fmb.Position("B", marker="p.x_0")),
        )
    )
    return np.array([10.0 - solution["A"][-1][1], solution["B"][-1][0] - 10.0])


@pytest.mark.slow
@KINDS
def test_hemisphere(reference, shear):
    """16 by 16 elements of a quarter: 3 %."""
    expected = reference("AN12")["reference"]["hemisphere"]
    np.testing.assert_allclose(hemisphere(16, shear), [expected["V_A"], expected["U_B"]], rtol=0.03)


def rolled_up(elements, shear, share):
    """Return the error of the end (m) of a strip 10 m long that an end moment bends into a part of a circle."""
    model = {**STRIP, "h": 0.01}
    strip, supports, clamps = held_strip(model, elements, shear)
    bending = model["E"] * model["h"] ** 3 / 12.0
    angle = 2.0 * np.pi * share
    solution = fmb.statics(
        fmb.Model(
            bodies=(fmb.Ground(markers=supports), strip),
            gravity=(0, 0, 0),
            joints=clamps,
            forces=(fmb.PointLoad("M", marker="p.end", moment=(0, -bending * angle / model["L"], 0)),),
            sensors=(fmb.Position("end", marker="p.end"),),
        )
    )
    radius = model["L"] / angle
    exact = (radius * np.sin(angle), 0.5, radius * (1.0 - np.cos(angle)))
    return float(np.linalg.norm(solution["end"][-1] - exact))


@pytest.mark.slow
@pytest.mark.parametrize(("shear", "elements", "order"), [(False, 4, 4.0), (True, 8, 2.0)], ids=["thin", "shear"])
def test_order_of_convergence(shear, elements, order):
    """Half a circle: a strip of the thin element bends as the cable does, order four; the other has order two."""
    error = [rolled_up(n, shear, 0.5) for n in (elements, 2 * elements)]
    assert np.log2(error[0] / error[1]) == pytest.approx(order, abs=0.4)


@pytest.mark.slow
def test_full_circle():
    """16 thin elements: the end comes back to the beginning, 1e-3 of the length."""
    assert rolled_up(16, False, 1.0) < 1e-2
