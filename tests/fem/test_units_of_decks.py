"""The same structure in five systems of units: the right one is named first, whatever stands in the deck.

The decks are written by the definitions of the units (NIST SP 811): lbf = 4.4482216152605 N, in = 0.0254 m,
ft = 0.3048 m.
"""

import warnings

import numpy as np
import pytest

from flexmb import fem
from flexmb.fem.deck.inventory import mass_and_center

LBF = 4.4482216152605
UNITS = {
    "m, kg, s": (1.0, 1.0, 1.0),
    "mm, t, s": (1e-3, 1e3, 1.0),
    "mm, kg, ms": (1e-3, 1.0, 1e-3),
    "in, lbf s2/in, s": (0.0254, LBF / 0.0254, 1.0),
    "ft, slug, s": (0.3048, LBF / 0.3048, 1.0),
}
"""SI values of length, mass and time."""
MATERIALS = {"steel": (2.1e11, 7850.0), "aluminium": (7.1e10, 2780.0), "carbon": (6e10, 1580.0)}


def number(value):
    """Eight columns hold few digits: free field has sixteen."""
    return f"{value:.9e}".replace("e", "") if "e+" in f"{value:.9e}" or "e-" in f"{value:.9e}" else f"{value:.9e}"


def deck(tmp_path, units, material="steel", size=0.8, density=True, kind="shell"):
    """A plate, or a bar, of `size` m in some units."""
    length, mass, time = UNITS[units]
    e, rho = MATERIALS[material]
    e, rho = e / (mass / length / time**2), rho / (mass / length**3)
    a, t = size / length, 0.004 / length
    rows = [
        f"GRID,1,,0.,0.,0.\nGRID,2,,{number(a)},0.,0.\nGRID,3,,{number(a)},{number(a)},0.\nGRID,4,,0.,{number(a)},0."
    ]
    if kind == "shell":
        rows.append(f"CQUAD4,1,1,1,2,3,4\nPSHELL,1,1,{number(t)},1,,1")
    else:
        rows.append(
            f"CBAR,1,1,1,2,0.,1.,0.\nCBAR,2,1,2,3,1.,0.,0.\nCBAR,3,1,3,4,0.,1.,0.\nPBARL,1,1,,ROD\n,{number(5 * t)}"
        )
    rows.append(f"MAT1,1,{number(e)},,.3{',' + number(rho) if density else ''}")
    rows.append(f"CONM2,9,3,,{number(1.5 / mass)}\nPARAM,COUPMASS,1")
    path = tmp_path / "part.bdf"
    path.write_text("BEGIN BULK\n" + "\n".join(rows) + "\nENDDATA\n")
    return path


def told(path, **options):
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        fe = fem.read_deck(path, show=False, **options)
    words = [str(one.message) for one in heard if issubclass(one.category, fem.MeshWarning)]
    assert [text for text in fe.warnings if "Units that fit" in text] == [w for w in words if "Units that fit" in w]
    return fe, " ".join(words)


@pytest.mark.parametrize("kind", ["shell", "bar"])
@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("units", UNITS)
def test_the_right_system_is_named_first(tmp_path, units, material, kind):
    path = deck(tmp_path, units, material, kind=kind)
    _, words = told(path)
    if units == "m, kg, s":
        assert words == ""
    else:
        assert f"1. '{units}'" in words
        if material != "carbon":
            assert f"'{units}' (like {material}" in words
    fe, words = told(path, units=units)
    assert words == ""
    area = 0.8**2 * 0.004 if kind == "shell" else 3 * 0.8 * np.pi * 0.02**2
    np.testing.assert_allclose(mass_and_center(fe)[0], area * MATERIALS[material][1] + 1.5, rtol=1e-8)


@pytest.mark.parametrize("wrong", ["m, kg, s", "mm, t, s", "in, lbf s2/in, s", "ft, slug, s"])
@pytest.mark.parametrize("units", ["mm, t, s", "mm, kg, ms", "in, lbf s2/in, s"])
def test_a_wrong_choice_is_doubted(tmp_path, units, wrong):
    if units == wrong:
        return
    _, words = told(deck(tmp_path, units), units=wrong)
    assert f"in '{wrong}' it has" in words
    assert f"1. '{units}'" in words


def test_all_systems_that_fit_are_named(tmp_path):
    """2.1e5 without a density: steel in N/mm2, or a plastic in psi."""
    _, words = told(deck(tmp_path, "mm, t, s", density=False))
    assert words.index("1. 'mm, t, s'") < words.index("'in, lbf s2/in, s'")


def test_weight_densities_are_recognised(tmp_path):
    """30e6 psi and 0.283 lbf/in3: without PARAM, WTMASS, 0.00259 everything is 386 times too heavy."""
    path = deck(tmp_path, "in, lbf s2/in, s")
    text = path.read_text().splitlines()
    rho = MATERIALS["steel"][1] * 0.0254**4 / LBF * 9.80665 / 0.0254
    text = [f"MAT1,1,3.046+7,,.3,{rho:.6f}" if line.startswith("MAT1") else line for line in text]
    text = [f"CONM2,9,3,,{1.5 * 9.80665 / LBF:.6f}" if line.startswith("CONM2") else line for line in text]
    path.write_text("\n".join(text) + "\n")
    _, words = told(path, units="in, lbf s2/in, s")
    assert "WTMASS is missing" in words
    path.write_text(path.read_text().replace("ENDDATA", "PARAM,WTMASS,.00259\nENDDATA"))
    fe, words = told(path, units="in, lbf s2/in, s")
    assert words == ""
    np.testing.assert_allclose(mass_and_center(fe)[0], 0.8**2 * 0.004 * 7850 + 1.5, rtol=1e-4)


def test_no_elements_but_masses_and_springs(tmp_path):
    path = tmp_path / "masses.bdf"
    path.write_text(
        "BEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,2400.,0.,0.\nCONM2,1,1,,.05\nCONM2,2,2,,.05\n"
        "RBAR,3,1,2,123456\nENDDATA\n"
    )
    _, words = told(path)
    assert "a size of 2.4e+03 m" in words
