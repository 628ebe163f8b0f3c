"""Decks that ask for too much or name what is not there: read in little time, or refused by name."""

import pytest
from fuzz.decks import LINES, MIXED, PARTS, SOLIDS

from flexmb import fem
from flexmb.errors import MeshError

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")


def read(tmp_path, text, name="part.bdf"):
    (tmp_path / "more.bdf").write_text("CONM2,77,2,,1.\n")
    (tmp_path / "more.inp").write_text("*NSET, NSET=MORE\nREF\n")
    (tmp_path / name).write_text(text)
    return fem.read_deck(tmp_path / name, show=False)


def test_the_decks_that_are_damaged_are_sound(tmp_path):
    """Else the campaign would try refusals only."""
    for text, name in ((SOLIDS, "a.bdf"), (LINES, "b.bdf"), (PARTS, "c.inp"), (MIXED, "d.inp")):
        assert read(tmp_path, text, name).ndof > 20


def test_a_range_passes_over_what_does_not_exist(tmp_path):
    """THRU 99999999 means all; it costs nothing."""
    whole = read(tmp_path, SOLIDS.replace("123456,1,THRU,3", "123456,1,THRU,999999999"))
    named = read(tmp_path, SOLIDS.replace("123456,1,THRU,3", "123456,1,THRU,700"))
    assert whole.supports["spc_1"].tolist() == named.supports["spc_1"].tolist()
    assert len(whole.supports["spc_1"]) == 12 * 6


@pytest.mark.parametrize(
    ("text", "change", "words"),
    [
        (LINES, ("THRU,22", "THRU,999999999"), r"SPOINT.*each over 1000000 numbers at most"),
        (SOLIDS, ("123456,4,6,8", "123456,4,THRU,999999999"), r"RBE2.*each over 1000000 numbers at most"),
        (SOLIDS, ("GRID,501,7", "GRID,501,100"), r"more than 60 coordinate systems that refer each to the next"),
        (PARTS, ("ONE.8, TWO.8", "ONE.8, SIX.8"), r"'SIX.8'"),
        (PARTS, ("1, 1, 2, 4, 3, 5,", "1, SIX.1, 2, 4, 3, 5,"), r"node 'SIX.1'. Expected: the name of an \*INSTANCE"),
        (MIXED, ("\n500.\n", "\n,\n"), r"\*SPRING: ''"),
        (MIXED, ("135e9, 10e9, 9e9", "1e-320, 10e9, 9e9"), r"\*ELASTIC: an elasticity that is not positive"),
        (MIXED, ("3, 30.", "4, 30."), r"\*ORIENTATION: the axis 4 of the additional rotation. Expected: 1, 2 or 3"),
        (MIXED, ("3, 30.", "-1, 30."), r"\*ORIENTATION: the axis -1"),
        (MIXED, ("1, 1\n300.", "1, 9\n300."), r"\*SPRING: directions '1, 9'"),
        (MIXED, ("*EQUATION\n2\n", "*EQUATION\n" + "9" * 5000 + "\n"), r"\*EQUATION: '999.*Expected: integers"),
        (MIXED, ("1, 5\n*ELEMENT, TYPE=SPRING2", "1, 5²\n*ELEMENT, TYPE=SPRING2"), r"the node '5²'"),
    ],
)
def test_refused_by_name(tmp_path, text, change, words):
    assert change[0] in text
    chain = "".join(f"CORD2R,{100 + k},{101 + k},0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0.\n" for k in range(80))
    text = text.replace(*change).replace("ENDDATA", f"{chain}CORD2R,180,0,0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0.\nENDDATA")
    with pytest.raises(MeshError, match=f"(?s){words}"):
        read(tmp_path, text, "part.bdf" if "BEGIN BULK" in text else "part.inp")


@pytest.mark.parametrize(("name", "line"), [("part.bdf", "INCLUDE '{}'\n"), ("part.inp", "*INCLUDE, INPUT={}\n")])
def test_files_that_include_the_next_one_twice(tmp_path, monkeypatch, name, line):
    """Eighteen files, a quarter of a million of times to read; a circle they are not."""
    monkeypatch.setattr(fem.deck.files, "FILES", 500)
    for k in range(18):
        (tmp_path / f"{k}.inc").write_text(2 * line.format(f"{k + 1}.inc") if k < 17 else "$\n")
    text = (SOLIDS if name == "part.bdf" else PARTS).replace("more" + name[4:], "0.inc")
    with pytest.raises(MeshError, match="more than 500 INCLUDE"):
        read(tmp_path, text, name)


def test_sets_that_name_the_one_before_twice(tmp_path, monkeypatch):
    monkeypatch.setattr(fem.deck.abaqus_model, "MANY", 1000)
    sets = "*NSET, NSET=D0\n1\n" + "".join(f"*NSET, NSET=D{k + 1}\nD{k}, D{k}\n" for k in range(40))
    with pytest.raises(MeshError, match=r"NSET: more than 1000 numbers"):
        read(tmp_path, MIXED + sets, "part.inp")


def test_parts_of_one_material_are_one_block(tmp_path):
    """Three instances and their sections: one block, with the mass of three."""
    fe = read(tmp_path, PARTS, "part.inp")
    assert [len(block.connectivity) for block in fe.blocks if len(block.connectivity)] == [3]
