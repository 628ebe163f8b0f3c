"""The decks that the how-to pages print are whole: they can be read and weigh what they should."""

import re
from pathlib import Path

import numpy as np
import pytest

from flexmb import fem
from flexmb.fem.deck.inventory import mass_and_center

PAGES = Path(__file__).parents[2] / "docs" / "howto"


@pytest.mark.parametrize(
    ("page", "suffix", "begins", "mass"),
    [
        ("from-nastran.md", ".bdf", "BEGIN BULK", 12 + 7850 * np.pi * (0.05**2 - 0.04**2) * 2.0),
        ("from-abaqus.md", ".inp", r"\*NODE", 0.5 + 7850 * 0.2 * 0.1 * 0.002),
        ("from-ansys.md", ".cdb", "/PREP7", 12 + 7850 * np.pi / 4 * (0.05**2 - 0.04**2) * 1.2),
    ],
)
def test_deck_of_the_page(tmp_path, page, suffix, begins, mass):
    (text,) = re.findall(rf"```text\n({begins}.*?)```", (PAGES / page).read_text(), re.DOTALL)
    path = tmp_path / f"deck{suffix}"
    path.write_text(text)
    units = "mm, t, s" if suffix == ".inp" else "m, kg, s"
    fe = fem.read_deck(path, units=units, show=False)
    assert mass_and_center(fe)[0] == pytest.approx(mass, rel=1e-9)
    assert fe.reference_points
