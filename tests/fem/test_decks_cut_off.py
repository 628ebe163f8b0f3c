"""A deck that was cut off behind a whole card reads as a smaller structure: that its end is missing is told."""

import re
import warnings

import pytest

from flexmb import fem

BARS = """SOL 103
CEND
BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,2.,0.,0.
PBARL,1,1,,ROD,,,,,+
+,.05
MAT1,1,2.1+11,,.3,7850.
CBAR,1,1,1,2,0.,1.,0.
CBAR,2,1,2,3,0.,1.,0.
ENDDATA
"""
PLATE = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
*ELEMENT, TYPE=S4, ELSET=PLATE
1, 1, 2, 3, 4
*MATERIAL, NAME=STEEL
*ELASTIC
2.1E11, 0.3
*DENSITY
7850.
*SHELL SECTION, ELSET=PLATE, MATERIAL=STEEL
0.01
*STEP
*FREQUENCY
2,
*BOUNDARY
1, 1, 6
*END STEP
"""


def told(path, text) -> list[str]:
    path.write_text(text)
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        fem.read_deck(path, units="m, kg, s", show=False)
    return [str(one.message) for one in heard]


@pytest.mark.parametrize(
    ("name", "text", "cut", "words"),
    [
        ("bars.bdf", BARS, "CBAR,2", "there is no ENDDATA"),
        ("bars.bdf", BARS, "ENDDATA", "there is no ENDDATA"),
        ("plate.inp", PLATE, "*BOUNDARY", r"\*STEP has no \*END STEP"),
    ],
)
def test_a_missing_end_is_told(tmp_path, name, text, cut, words):
    assert told(tmp_path / name, text) == []
    (sentence,) = told(tmp_path / name, text[: text.index(cut)])
    assert re.search(f"left out: what may follow the last line: {words}", sentence)


def test_bulk_data_alone_have_no_end_to_miss(tmp_path):
    """Punched meshes and included files begin with their first card."""
    cards = BARS[BARS.index("GRID") :].replace("ENDDATA\n", "")
    assert told(tmp_path / "bars.pch", cards) == []
